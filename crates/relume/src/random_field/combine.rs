//! From planes, and tiles cut from them, to a model of structure and detail.

use super::estimate::{LevelReport, ModelOptions, Scored, outside, scores_of};
use super::joint_color::{JointColor, LENGTHS, in_axes};
use super::levels::{REFERENCE_WINDOW, completed};
use super::marginal::Marginal;
use super::model::Model;
use super::structure::{Structure, Tiles};
use crate::error::{Error, Result};
use crate::job::Job;
use crate::numeric::pyramid;
use crate::planes::Planes;
use crate::rect::Rect;
use crate::size::Size;

/// The budget of the structure.
#[derive(Clone, Copy)]
pub struct Budget<'a> {
    /// The most bytes.
    pub bytes: usize,
    /// The bytes of a structure in a file.
    pub cost: &'a dyn Fn(&Structure) -> usize,
}

/// Fits a model to planes with tiles that fit together: a compressed set of tiles, and a random field for the
/// residual.
///
/// # Errors
/// As [`super::estimate`](fn@super::estimate); tiles of other planes or smaller than the neighbourhood.
pub fn combine(
    planes: &Planes,
    tiles: Tiles<'_, Planes>,
    budget: &Budget<'_>,
    options: &ModelOptions,
    job: &Job,
) -> Result<(Model, Vec<LevelReport>)> {
    let color = options.color.filter(|_| options.marginals);
    let axes = color.map(|first| [planes, tiles.texels].map(|all| in_axes(all.clone(), first)));
    let (planes, found) = axes.as_ref().map_or((planes, tiles.texels), |[planes, found]| (planes, found));
    // The structure is coded in values: scores would stretch the values between two modes.
    let straight = ModelOptions { marginals: false, ..*options };
    let Scored { marginals, mixing, .. } = Scored::of(planes, &straight, job)?;
    if found.count() != planes.count() || !found.size().height.is_multiple_of(tiles.size.height.max(1)) {
        return Err(Error::usage(format!(
            "{} planes of {} cannot hold tiles of {} for a texture of {} planes",
            found.count(),
            found.size(),
            tiles.size,
            planes.count()
        )));
    }
    job.check("the tiles to model", found.size(), 40 * planes.count() as u64)?;
    let scores = scores_of(found, &marginals);
    let deviations = scores.iter().map(root_mean_square).collect::<Vec<f64>>();
    let mut detail = mixing.components_of(&scores);
    let structure = Structure::within(
        Tiles { texels: &detail, size: tiles.size },
        &mixing.norms(&lengths(&marginals, color)),
        budget.bytes,
        budget.cost,
    );
    pyramid::subtract(&mut detail, &structure.decoded());
    let parts = Scored { marginals, color: None, mixing, components: detail };
    let (mut model, reports) = completed(parts, Some(structure), &deviations, options, job)?;
    if options.marginals {
        (model.marginals, model.color) = matched(planes, color, &model, tiles.size, job)?;
    }
    Ok((model, reports))
}

/// The lengths of the planes in which errors of the structure count alike: those of all planes of scores, and
/// of the axes of a colour those of its channels.
fn lengths(marginals: &[Marginal], color: Option<usize>) -> Vec<f64> {
    let mut lengths = vec![1.0; marginals.len()];
    let Some(first) = color else { return lengths };
    let deviation = |k: usize| match marginals[first + k] {
        Marginal::Normal { deviation, .. } => LENGTHS[k] * f64::from(deviation),
        Marginal::Curve { .. } => 0.0,
    };
    let deviations = [0, 1, 2].map(deviation);
    let mean = (deviations.iter().map(|d| d * d).sum::<f64>() / 3.0).sqrt().max(f64::MIN_POSITIVE);
    lengths[first..first + 3].iter_mut().zip(deviations).for_each(|(length, d)| *length = d / mean);
    lengths
}

/// Distributions that give the output of the model those of the planes.
pub(super) fn matched(
    planes: &Planes,
    color: Option<usize>,
    model: &Model,
    tile: Size,
    job: &Job,
) -> Result<(Vec<Marginal>, Option<JointColor>)> {
    // Whole tiles, so that each part of them has its share.
    let side = |tile: usize| REFERENCE_WINDOW.next_multiple_of(tile);
    let area = Rect::new(0, 0, Size::new(side(tile.width), side(tile.height)));
    job.check(
        "the reference window that distributions are measured on",
        area.size,
        40 * planes.count() as u64,
    )?;
    let mut scores = model.scores(area, 0, None, job)?;
    for (plane, gain) in scores.iter_mut().zip(&model.gains) {
        plane.iter_mut().for_each(|v| *v *= gain);
    }
    let marginal = |k: usize| Marginal::matched(planes.plane(k), scores.plane(k));
    let marginals = outside(color, planes.count()).map(marginal).collect();
    Ok((marginals, color.map(|first| JointColor::matched(planes, &scores, first))))
}

fn root_mean_square(values: &[f32]) -> f64 {
    (values.iter().map(|&v| f64::from(v).powi(2)).sum::<f64>() / values.len() as f64).sqrt()
}
