//! Factorisation of a texture of light and view for each view by itself (PVF; M. Sattler, R. Sarlette, R. Klein, "Efficient and
//! Realistic Visualization of Cloth", EGSR 2003): the photographs of one view are alike, so few functions of the light
//! suffice, but a texel has numbers for each view.

use crate::direction::{Direction, Directions};
use crate::error::{Error, Result};
use crate::field::Basis;
use crate::fit::learned::{LearnedOptions, Rank, fit};
use crate::format::bonn::{BtfFactors, FactorShape, ViewPart};
use crate::job::Job;
use crate::raster::LoadRaster;
use crate::space::Space;

/// The factors of each view, in linear light without the cosine between light and normal: at most `rank` functions of light and
/// channel. `load(i)` reads the i-th photograph, twice.
///
/// # Errors
/// Lights on the horizon, and as [`fit`].
pub fn per_view(
    pairs: &[(String, Directions)],
    load: &LoadRaster,
    rank: usize,
    job: &Job,
) -> Result<Vec<ViewPart>> {
    let mut views: Vec<(Direction, Vec<usize>)> = Vec::new();
    for (i, (_, pair)) in pairs.iter().enumerate() {
        match views.iter_mut().find(|(view, _)| *view == pair.view) {
            Some((_, own)) => own.push(i),
            None => views.push((pair.view, vec![i])),
        }
    }
    views.into_iter().map(|(_, own)| one_view(pairs, load, own, rank, job)).collect()
}

fn one_view(
    pairs: &[(String, Directions)],
    load: &LoadRaster,
    own: Vec<usize>,
    rank: usize,
    job: &Job,
) -> Result<ViewPart> {
    let own_pairs: Vec<(String, Directions)> = own.iter().map(|&i| pairs[i].clone()).collect();
    let first = load(own[0])?;
    let most = (own.len() * first.channels()).min(first.size().texels());
    let options = LearnedOptions {
        rank: Rank::Functions(rank.min(most)),
        space: Space::Linear,
        report_texels: 1,
        ..LearnedOptions::default()
    };
    drop(first);
    // Errors are not reported, and so not what a fit says of them, for each view again.
    let field = fit(&own_pairs, &|i| load(own[i]), &options, &job.unheard())?.field;
    let Basis::Learned(learned) = field.basis() else {
        return Err(Error::invalid("factors of other than learned functions"));
    };
    let norm = |plane: &[f32]| plane.iter().map(|v| f64::from(*v).powi(2)).sum::<f64>().sqrt() as f32;
    let factors = BtfFactors {
        shape: FactorShape::Functions,
        functions: learned.values().to_vec(),
        singular: field.coefficients().iter().map(norm).collect(),
        coefficients: field.coefficients().clone(),
    };
    let factors = factors.without_cosine(learned.pairs())?;
    Ok(ViewPart { pairs: own, factors })
}
