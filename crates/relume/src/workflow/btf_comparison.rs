//! A texture of functions compared with the photographs of a texture of light and view, at the measured pairs.

use std::collections::BTreeMap;

use serde::Serialize;

use super::btf::Btf;
use crate::direction::Directions;
use crate::error::{Error, Result};
use crate::job::Job;
use crate::metric::{LabErrors, lab_errors, psnr, rmse, ssim};
use crate::numeric::decibel::mean_psnr_db;
use crate::parallel;
use crate::picture::Picture;
use crate::planes::Planes;
use crate::render::ShownForm;
use crate::space::Space;

/// Errors of pictures whose values are sRGB-encoded and clamped to 0..1.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct PictureErrors {
    /// The peak signal-to-noise ratio in decibels, for a peak of 1; infinite (in JSON: null) for equal pictures.
    pub psnr_db: f64,
    /// The root mean square error.
    pub rmse: f64,
    /// The mean absolute difference of CIE L*, a* and b*.
    pub mae_lab: f64,
    /// The mean of CIEDE2000.
    pub ciede2000: f64,
    /// The structural similarity, 1 for equal pictures.
    pub ssim: f64,
}

/// Errors over all pairs of light and view.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct PairErrors {
    /// Means over pictures; that of the signal-to-noise ratio over those that have an error.
    pub mean: PictureErrors,
    /// The number of pictures without an error.
    pub exact: usize,
    /// The picture with the least signal-to-noise ratio.
    pub worst: PictureErrors,
    /// Its name.
    pub worst_name: String,
    /// The polar angle of the view in degrees, and the mean signal-to-noise ratio of those of its pictures that have an error.
    pub by_view: Vec<(f64, f64)>,
}

/// Compares a texture with every photograph, of which one a thread is in memory.
///
/// # Errors
/// Photographs that cannot be read or differ in size or channels from the texture, limits exceeded, and a cancelled
/// job.
pub fn compare<'a>(btf: &Btf, texture: impl Into<ShownForm<'a>>, job: &Job) -> Result<PairErrors> {
    let pictures = texture.into().pictures(job)?;
    compare_pictures(btf, &|directions| pictures.picture(directions, job), job)
}

/// Compares another set, such as a factored one, with every photograph: its photographs of the same pairs, or
/// interpolated.
///
/// # Errors
/// As [`compare`].
pub fn compare_sets(btf: &Btf, other: &Btf, job: &Job) -> Result<PairErrors> {
    let between = other.between();
    compare_pictures(btf, &|directions| other.relit_by(&between, directions, job), job)
}

fn compare_pictures(
    btf: &Btf,
    other: &(dyn Fn(Directions) -> Result<Picture> + Sync),
    job: &Job,
) -> Result<PairErrors> {
    let entries = &btf.list().entries;
    let first = btf.photograph(0, job)?;
    // Both pictures in two spaces, the windows of the similarity, on each thread.
    let bytes = (16 * first.channels() + 48) as u64 * rayon::current_num_threads() as u64;
    job.check("the pictures to compare", first.size(), bytes)?;
    job.start("comparing", entries.len() as u64);
    let error = |i: usize| {
        let (truth, other) = (btf.photograph(i, job)?.to_picture(Space::Srgb), other(entries[i].directions)?);
        let shape = |planes: &Planes| (planes.size(), planes.count());
        if shape(&truth.planes) != shape(&other.planes) {
            let ((size, channels), (other_size, other_channels)) =
                (shape(&truth.planes), shape(&other.planes));
            return Err(Error::usage(format!(
                "the photograph {} has {channels} channels of {size} and the texture {other_channels} of {other_size}: \
                 both must be the same",
                entries[i].name
            ))
            .at(btf.path()));
        }
        let errors = errors(&truth, &clamped(other))?;
        job.advance(1).map(|()| errors)
    };
    let all = parallel::try_map(0..entries.len(), error)?;
    let worst = (0..all.len()).fold(0, |w, i| if all[i].psnr_db < all[w].psnr_db { i } else { w });
    let mut views: BTreeMap<i64, Vec<f64>> = BTreeMap::new();
    for (entry, errors) in entries.iter().zip(&all) {
        let degrees = entry.directions.view.polar_rad().to_degrees();
        views.entry((10.0 * degrees).round() as i64).or_default().push(errors.psnr_db);
    }
    let average = |values: &[f64]| mean_psnr_db(values.iter().copied()).0;
    let (psnr_db, exact) = mean_psnr_db(all.iter().map(|errors| errors.psnr_db));
    Ok(PairErrors {
        mean: PictureErrors { psnr_db, ..mean(&all) },
        exact,
        worst: all[worst],
        worst_name: entries[worst].name.clone(),
        by_view: views.iter().map(|(tenths, values)| (*tenths as f64 / 10.0, average(values))).collect(),
    })
}

fn errors(truth: &Picture, other: &Picture) -> Result<PictureErrors> {
    let (a, b) = (&truth.planes, &other.planes);
    let LabErrors { mae_lab, ciede2000 } = lab_errors(truth, other)?;
    Ok(PictureErrors { psnr_db: psnr(a, b)?, rmse: rmse(a, b)?, mae_lab, ciede2000, ssim: ssim(a, b)? })
}

/// Encoded values as an 8-bit picture would hold them, without its rounding.
fn clamped(picture: Picture) -> Picture {
    let mut picture = picture.to_space(Space::Srgb);
    picture.planes.as_mut_slice().iter_mut().for_each(|value| *value = value.clamp(0.0, 1.0));
    picture
}

fn mean(all: &[PictureErrors]) -> PictureErrors {
    let of = |value: fn(&PictureErrors) -> f64| all.iter().map(value).sum::<f64>() / all.len() as f64;
    PictureErrors {
        psnr_db: of(|e| e.psnr_db),
        rmse: of(|e| e.rmse),
        mae_lab: of(|e| e.mae_lab),
        ciede2000: of(|e| e.ciede2000),
        ssim: of(|e| e.ssim),
    }
}
