//! How far a fit can be trusted: the errors of each light and of each place of the surface, what of the photographs is
//! in shadow or saturated, which of them look wrong, and how well their lights cover the hemisphere.
//!
//! Pictures are compared as displays show them: sRGB-encoded 8-bit values. A photograph looks wrong when the others
//! contradict it:
//!
//! - its brightness differs from that of the fit by a factor that is an outlier among the factors of all photographs:
//!   another exposure, or a lamp that failed;
//! - it fits better shifted by up to three texels: it, or the object, moved;
//! - it fits better turned over or mirrored: another orientation;
//! - its error is an outlier among the errors: its light stands elsewhere, or something was in the way.
//!
//! Outliers are more than four and a half robust standard deviations (1.4826 medians of absolute deviations) from the
//! median, and more than a stated least difference.

mod error_map;

use serde::Serialize;

use super::tested::ComparedPhotographs;
use crate::direction::Direction;
use crate::error::Result;
use crate::field::ReflectanceField;
use crate::job::Job;
use crate::numeric::decibel::{mean_psnr_db, psnr_db};
use crate::numeric::quadrature::hemisphere;
use crate::size::Size;
use error_map::{ErrorMap, squared};

/// Codes up to this are shadow, and from [`SATURATED`] on saturated.
const SHADOW: u8 = 5;
const SATURATED: u8 = 254;

/// The greatest shift, in texels, that is looked for.
const MOST_SHIFT: isize = 3;

/// A shift, or another orientation, has to lower the squared error to this share of it.
const CLEARLY_BETTER: f64 = 0.9;

/// Robust standard deviations from the median beyond which a figure is an outlier.
const OUTLIER: f64 = 4.5;

/// Least deviations of outliers: a tenth in brightness (as a natural logarithm), and 3 dB.
const LEAST_LOG_FACTOR: f64 = 0.1;
const LEAST_DECIBELS: f64 = 3.0;

/// The error of one code of 255 everywhere: pictures that are nearer to the photographs do not differ in what can be seen.
const ONE_CODE_DB: f64 = 48.13;

/// Places of the hemisphere down to this polar angle are to have a light near them.
const COVERED_TO_DEG: f64 = 70.0;

/// The distance to the nearest light from which on a place counts as uncovered: twice that of 50 lights spread evenly.
const UNCOVERED_DEG: f64 = 40.0;

/// The report on a fit.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[non_exhaustive]
pub struct QualityReport {
    /// The mean of the peak signal-to-noise ratio over pictures that have an error, in dB; infinite (in JSON: null) where none
    /// has one.
    pub psnr_db: f64,
    /// The number of pictures without an error.
    pub exact: usize,
    /// Each photograph.
    pub lights: Vec<LightQuality>,
    /// Indices of the photographs with the largest errors, the worst first.
    pub worst: Vec<usize>,
    /// How the lights cover the hemisphere.
    pub coverage: Coverage,
    /// Of all values, the share in shadow and the share saturated.
    pub shadow_share: f64,
    /// As `shadow_share`.
    pub saturated_share: f64,
    /// The width and the height of the map of errors.
    pub map_size: [usize; 2],
    /// The root mean square error of each cell of the surface over all photographs, in codes of 8 bits, row after row.
    pub error_map: Vec<f32>,
    /// Reasons for doubt, one sentence each.
    pub warnings: Vec<String>,
}

/// The figures of a photograph.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct LightQuality {
    /// The name of the photograph.
    pub name: String,
    /// The unit vector towards the light.
    pub direction: [f64; 3],
    /// The peak signal-to-noise ratio of the relit texture, in dB.
    pub psnr_db: f64,
    /// The share of its values in shadow.
    pub shadow_share: f64,
    /// The share of its values that are saturated.
    pub saturated_share: f64,
    /// The sum of its codes over that of the relit texture.
    pub brightness_factor: f64,
    /// The shift in texels, right and down, under which it fits best.
    pub shift: [isize; 2],
    /// What about it looks wrong, one sentence each.
    pub doubts: Vec<String>,
}

/// How lights cover the hemisphere.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Coverage {
    /// The largest angle between a direction within 70 degrees of the zenith and the nearest light, in degrees.
    pub widest_gap_deg: f64,
    /// Where that is.
    pub gap: [f64; 3],
    /// The share of these directions with a light within 20 degrees.
    pub covered_share: f64,
    /// The least and the greatest polar angle of a light, in degrees.
    pub polar_range_deg: [f64; 2],
}

/// Compares a fitted texture with the photographs of its fit. The map of errors has no more than `most_cells` cells along a
/// side.
///
/// # Errors
/// No photograph, photographs of another size, channels without a colour, and errors of the reader.
pub fn quality(
    field: &ReflectanceField,
    photographs: &ComparedPhotographs<'_>,
    most_cells: usize,
    job: &Job,
) -> Result<QualityReport> {
    job.check_bytes("the map of errors", 8 * field.size().texels() as u64)?;
    let mut map = ErrorMap::new(field.size(), most_cells, photographs.mask);
    let mut lights = Vec::with_capacity(photographs.pairs.len());
    photographs.for_each(field, job, |i, relit, photograph| {
        let (name, pair) = &photographs.pairs[i];
        map.add(relit, photograph);
        let pictures = PicturePair { relit, photograph, size: field.size(), mask: photographs.mask };
        lights.push(pictures.figures(name, pair.light, photographs.texels(field.size())));
    })?;
    let coverage = coverage(&photographs.pairs.iter().map(|(_, pair)| pair.light).collect::<Vec<_>>());
    doubt_outliers(&mut lights);
    let mut worst: Vec<usize> = (0..lights.len()).collect();
    worst.sort_by(|&a, &b| lights[a].psnr_db.total_cmp(&lights[b].psnr_db).then(a.cmp(&b)));
    let mean = |of: fn(&LightQuality) -> f64| lights.iter().map(of).sum::<f64>() / lights.len() as f64;
    let (psnr_db, exact) = mean_psnr_db(lights.iter().map(|light| light.psnr_db));
    let (shadow_share, saturated_share) = (mean(|l| l.shadow_share), mean(|l| l.saturated_share));
    let warnings = warnings(&lights, &coverage, saturated_share);
    let (map_size, error_map) = map.finish();
    Ok(QualityReport {
        psnr_db,
        exact,
        worst,
        coverage,
        shadow_share,
        saturated_share,
        map_size: [map_size.width, map_size.height],
        error_map,
        warnings,
        lights,
    })
}

/// A relit texture and its photograph, as codes.
struct PicturePair<'a> {
    relit: &'a [u8],
    photograph: &'a [u8],
    size: Size,
    mask: Option<&'a [bool]>,
}

impl PicturePair<'_> {
    /// The figures of the photograph, over so many texels inside the mask.
    fn figures(&self, name: &str, light: Direction, texels: usize) -> LightQuality {
        let (relit, photograph, size) = (self.relit, self.photograph, self.size);
        let sum = |codes: &[u8]| codes.iter().map(|code| u64::from(*code)).sum::<u64>().max(1) as f64;
        let error = squared(relit, photograph);
        let shift = best_shift(relit, photograph, size);
        let mut doubts = Vec::new();
        if shift != [0, 0] {
            doubts.push(format!(
                "fits better {} texels to the right and {} down: moved between photographs?",
                shift[0], shift[1]
            ));
        }
        if let Some(turn) = better_orientation(relit, photograph, size, error) {
            doubts.push(format!("fits better {turn}: another orientation than the others?"));
        }
        LightQuality {
            name: name.to_owned(),
            direction: light.to_array(),
            psnr_db: psnr_db(error as f64 / (255.0 * 255.0 * 3.0 * texels as f64)),
            shadow_share: self.share(texels, |code| code <= SHADOW),
            saturated_share: self.share(texels, |code| code >= SATURATED),
            brightness_factor: sum(photograph) / sum(relit),
            shift,
            doubts,
        }
    }

    /// The share of the codes of the photograph inside the mask.
    fn share(&self, texels: usize, is: impl Fn(u8) -> bool) -> f64 {
        let inside = |texel: usize| self.mask.is_none_or(|mask| mask[texel]);
        let codes = self.photograph.iter().enumerate().filter(|(i, code)| is(**code) && inside(i / 3));
        codes.count() as f64 / (3 * texels) as f64
    }
}

/// The mean squared difference of green, of the photograph moved against the relit texture, where both are inside.
fn moved_error(relit: &[u8], photograph: &[u8], size: Size, [dx, dy]: [isize; 2]) -> f64 {
    let margin = MOST_SHIFT as usize;
    let (mut sum, mut count) = (0u64, 0u64);
    for y in margin..size.height - margin {
        for x in margin..size.width - margin {
            let from = size.index(x.wrapping_add_signed(dx), y.wrapping_add_signed(dy));
            let difference = relit[3 * size.index(x, y) + 1].abs_diff(photograph[3 * from + 1]);
            sum += u64::from(difference).pow(2);
            count += 1;
        }
    }
    sum as f64 / count as f64
}

/// The shift by which the photograph fits clearly better, or none.
fn best_shift(relit: &[u8], photograph: &[u8], size: Size) -> [isize; 2] {
    if size.width.min(size.height) < 8 * MOST_SHIFT as usize {
        return [0, 0];
    }
    let still = moved_error(relit, photograph, size, [0, 0]);
    let mut best = ([0, 0], CLEARLY_BETTER * still);
    let range = -MOST_SHIFT..=MOST_SHIFT;
    for shift in range.clone().flat_map(|dy| range.clone().map(move |dx| [dx, dy])) {
        let error = moved_error(relit, photograph, size, shift);
        if error < best.1 {
            best = (shift, error);
        }
    }
    best.0
}

/// The orientation in which the photograph fits clearly better, or none.
fn better_orientation(relit: &[u8], photograph: &[u8], size: Size, error: u64) -> Option<&'static str> {
    let Size { width, height } = size;
    let turned = |place: &dyn Fn(usize, usize) -> usize| -> u64 {
        let texels = (0..height).flat_map(|y| (0..width).map(move |x| (x, y)));
        texels
            .map(|(x, y)| squared(&relit[3 * size.index(x, y)..][..3], &photograph[3 * place(x, y)..][..3]))
            .sum()
    };
    let flips: [(&'static str, u64); 3] = [
        ("upside down", turned(&|x, y| size.index(width - 1 - x, height - 1 - y))),
        ("mirrored from left to right", turned(&|x, y| size.index(width - 1 - x, y))),
        ("mirrored from top to bottom", turned(&|x, y| size.index(x, height - 1 - y))),
    ];
    let best = flips.into_iter().min_by_key(|(_, error)| *error)?;
    (best.1 < (CLEARLY_BETTER * error as f64) as u64).then_some(best.0)
}

/// The median and the robust standard deviation.
fn spread(values: &[f64]) -> (f64, f64) {
    let median = |values: &mut Vec<f64>| {
        let middle = values.len() / 2;
        *values.select_nth_unstable_by(middle, f64::total_cmp).1
    };
    let centre = median(&mut values.to_vec());
    let deviation = median(&mut values.iter().map(|value| (value - centre).abs()).collect());
    (centre, 1.4826 * deviation)
}

fn doubt_outliers(lights: &mut [LightQuality]) {
    let factors: Vec<f64> = lights.iter().map(|light| light.brightness_factor.ln()).collect();
    let errors: Vec<f64> = lights.iter().map(|light| light.psnr_db.min(ONE_CODE_DB)).collect();
    let ((factor, factor_spread), (error, error_spread)) = (spread(&factors), spread(&errors));
    for (light, (log_factor, decibels)) in lights.iter_mut().zip(factors.iter().zip(&errors)) {
        let from_median = log_factor - factor;
        if from_median.abs() > (OUTLIER * factor_spread).max(LEAST_LOG_FACTOR) {
            light.doubts.push(format!(
                "{:.2} times as bright as the fit under its light, where others are {:.2} times: another exposure?",
                light.brightness_factor,
                factor.exp()
            ));
        }
        if error - decibels > (OUTLIER * error_spread).max(LEAST_DECIBELS) {
            let decibels = light.psnr_db;
            light.doubts.push(format!(
                "its error of {decibels:.1} dB is far from the usual {error:.1} dB: is its light where the list says, or \
                 was something in the way?"
            ));
        }
    }
}

fn coverage(lights: &[Direction]) -> Coverage {
    let (mut widest, mut gap, mut covered, mut all) = (0.0f64, Direction::ZENITH, 0.0, 0.0);
    for (place, share) in hemisphere(24).filter(|(d, _)| d.z() >= COVERED_TO_DEG.to_radians().cos()) {
        let cosine = lights.iter().map(|light| light.dot(place)).fold(-1.0f64, f64::max);
        let angle = cosine.clamp(-1.0, 1.0).acos().to_degrees();
        all += share;
        covered += if angle <= 20.0 { share } else { 0.0 };
        if angle > widest {
            (widest, gap) = (angle, place);
        }
    }
    let polar = lights.iter().map(|light| light.z().clamp(-1.0, 1.0).acos().to_degrees());
    let (least, most) = polar.fold((180.0f64, 0.0f64), |(l, m), angle| (l.min(angle), m.max(angle)));
    Coverage {
        widest_gap_deg: widest,
        gap: gap.to_array(),
        covered_share: covered / all,
        polar_range_deg: [least, most],
    }
}

fn warnings(lights: &[LightQuality], coverage: &Coverage, saturated: f64) -> Vec<String> {
    let mut warnings = Vec::new();
    if coverage.widest_gap_deg > UNCOVERED_DEG {
        let [x, y, z] = coverage.gap;
        warnings.push(format!(
            "no light within {:.0} degrees of ({x:.2}, {y:.2}, {z:.2}): what the texture shows there is a guess",
            coverage.widest_gap_deg
        ));
    }
    if saturated > 0.02 {
        warnings.push(format!(
            "{:.1} % of all values are saturated: a shorter exposure keeps highlights",
            100.0 * saturated
        ));
    }
    let doubtful = lights.iter().flat_map(|light| light.doubts.iter().map(move |doubt| (light, doubt)));
    warnings.extend(doubtful.map(|(light, doubt)| format!("{} {doubt}", light.name)));
    warnings
}

#[cfg(test)]
mod tests;
