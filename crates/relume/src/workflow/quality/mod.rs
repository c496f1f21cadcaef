//! How far a fit can be trusted: the errors of each light and of each place of the surface, what of the photographs is
//! in shadow or saturated, which of them look wrong, and how well their lights cover the hemisphere.
//!
//! Pictures are compared as displays show them: sRGB-encoded 8-bit values. A photograph looks wrong when the others
//! contradict it:
//!
//! - its brightness differs from that of the fit by a factor that is an outlier among the factors of all photographs, and by
//!   more than its texels differ among each other and than two degrees of the light explain: another exposure, or a lamp that
//!   failed;
//! - it fits better shifted by some texels, and better than by any shift near it: it, or the object, moved;
//! - it fits better turned over or mirrored: another orientation;
//! - its error is an outlier among the errors: its light stands elsewhere, or something was in the way.
//!
//! Where each photograph is compared with what the others give, a wrong one spoils those of the lights around it. So the worst of
//! those that look wrong, among lights near each other, are set aside, and all are compared anew with what is left, until no other
//! looks wrong.
//!
//! Outliers are more than four and a half robust standard deviations (1.4826 medians of absolute deviations) from the
//! median, and more than a stated least difference.

mod error_map;
mod pictures;

use serde::Serialize;

use super::tested::ComparedPhotographs;
use crate::direction::Direction;
use crate::error::Result;
use crate::field::{Basis, ReflectanceField};
use crate::job::Job;
use crate::numeric::decibel::mean_psnr_db;
use crate::numeric::quadrature::hemisphere;
use error_map::ErrorMap;
use pictures::PicturePair;

/// Codes up to this are shadow, and from [`SATURATED`] on saturated.
const SHADOW: u8 = 5;
const SATURATED: u8 = 254;

/// Robust standard deviations from the median beyond which a figure is an outlier.
const OUTLIER: f64 = 4.5;

/// Least deviations of outliers: a tenth in brightness (as a natural logarithm), and 3 dB.
const LEAST_LOG_FACTOR: f64 = 0.1;
const LEAST_DECIBELS: f64 = 3.0;

/// What a level surface changes in brightness where its light stands two degrees from where the list says, times the tangent of the
/// polar angle.
const LIGHT_ERROR_RAD: f64 = 2.0 * std::f64::consts::PI / 180.0;

/// The error of two codes of 255 everywhere: pictures that are nearer to the photographs hardly differ in what can be seen.
const TWO_CODES_DB: f64 = 42.11;

/// Texels from which on photographs are judged.
const LEAST_TEXELS: usize = 400;

/// The lights around one, whose photographs its photograph spoils; and the share of photographs that may be set aside.
const AROUND: usize = 8;
const SET_ASIDE_SHARE: f64 = 0.25;

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
    /// What each photograph was compared with.
    pub compared: ComparedWith,
    /// Indices of photographs that look wrong, and have no part in what the others give; none where the fit is compared.
    pub set_aside: Vec<usize>,
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

/// What a photograph is compared with.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum ComparedWith {
    /// The texture, whose functions one photograph among many bends little.
    Fit,
    /// What the other photographs give under its light, as the texture shows each as it is.
    Others,
    /// The texture, whose functions are learned from the photographs and follow also one that is wrong.
    Learned,
}

impl ComparedWith {
    fn of(basis: &Basis) -> Self {
        match basis {
            Basis::Interpolated(_) => Self::Others,
            Basis::Learned(_) => Self::Learned,
            _ => Self::Fit,
        }
    }
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
    /// The factor of its codes over those of the relit texture, between most of the lit texels.
    pub brightness_factor: f64,
    /// The natural logarithm of the ratio of the greatest to the least of these factors.
    pub brightness_spread: f64,
    /// By how many texels, right and down, it shows the surface moved; 0 where no shift fits clearly better.
    pub shift: [isize; 2],
    /// What about it looks wrong, one sentence each.
    pub doubts: Vec<String>,
}

impl LightQuality {
    /// The tangent of the polar angle of the light.
    fn tangent(&self) -> f64 {
        let [x, y, z] = self.direction;
        x.hypot(y) / z.max(1e-3)
    }
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
    let compared = ComparedWith::of(field.basis());
    let mut photographs = photographs.clone();
    let (mut lights, map) = loop {
        let (mut lights, map) = figures(field, &photographs, most_cells, job)?;
        doubt_outliers(&mut lights, compared);
        let wrong = wrongest(&lights, &photographs.set_aside);
        let most = (SET_ASIDE_SHARE * lights.len() as f64) as usize;
        if compared != ComparedWith::Others
            || wrong.is_empty()
            || photographs.set_aside.len() + wrong.len() > most
        {
            break (lights, map);
        }
        photographs.set_aside.extend(wrong);
    };
    let coverage = coverage(&photographs.pairs.iter().map(|(_, pair)| pair.light).collect::<Vec<_>>());
    let texels = photographs.texels(field.size());
    if texels < LEAST_TEXELS {
        lights.iter_mut().for_each(|light| light.doubts.clear());
    }
    let mut worst: Vec<usize> = (0..lights.len()).collect();
    worst.sort_by(|&a, &b| lights[a].psnr_db.total_cmp(&lights[b].psnr_db).then(a.cmp(&b)));
    let mean = |of: fn(&LightQuality) -> f64| lights.iter().map(of).sum::<f64>() / lights.len() as f64;
    let (psnr_db, exact) = mean_psnr_db(lights.iter().map(|light| light.psnr_db));
    let (shadow_share, saturated_share) = (mean(|l| l.shadow_share), mean(|l| l.saturated_share));
    let limits = limits(field, lights.len(), texels, compared);
    let warnings = limits.into_iter().chain(warnings(&lights, &coverage, saturated_share)).collect();
    let (map_size, error_map) = map.finish();
    Ok(QualityReport {
        psnr_db,
        exact,
        compared,
        set_aside: photographs.set_aside,
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

/// The figures of all photographs, without doubts of outliers, and the map of errors.
fn figures<'a>(
    field: &ReflectanceField,
    photographs: &ComparedPhotographs<'a>,
    most_cells: usize,
    job: &Job,
) -> Result<(Vec<LightQuality>, ErrorMap<'a>)> {
    let mut map = ErrorMap::new(field.size(), most_cells, photographs.mask);
    let mut lights = Vec::with_capacity(photographs.pairs.len());
    let texels = photographs.texels(field.size());
    photographs.for_each(field, job, |i, relit, photograph| {
        let (name, pair) = &photographs.pairs[i];
        map.add(relit, photograph);
        let pictures = PicturePair { relit, photograph, size: field.size(), mask: photographs.mask };
        lights.push(pictures.figures(name, pair.light, texels));
    })?;
    Ok((lights, map))
}

/// Of the photographs that look wrong and are not set aside, those of which none around has a larger error and looks wrong, too.
fn wrongest(lights: &[LightQuality], set_aside: &[usize]) -> Vec<usize> {
    let looks_wrong = |i: usize| !lights[i].doubts.is_empty() && !set_aside.contains(&i);
    let cosine = |i: usize, k: usize| -> f64 {
        lights[i].direction.iter().zip(&lights[k].direction).map(|(a, b)| a * b).sum()
    };
    let is_worst_around = |i: &usize| {
        let mut around: Vec<usize> = (0..lights.len()).filter(|k| k != i).collect();
        around.sort_by(|a, b| cosine(*i, *b).total_cmp(&cosine(*i, *a)));
        let worse = |k: &usize| looks_wrong(*k) && lights[*k].psnr_db < lights[*i].psnr_db;
        !around.iter().take(AROUND).any(worse)
    };
    (0..lights.len()).filter(|i| looks_wrong(*i)).filter(is_worst_around).collect()
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

fn doubt_outliers(lights: &mut [LightQuality], compared: ComparedWith) {
    let other = if compared == ComparedWith::Others { "what the others give" } else { "the fit" };
    let factors: Vec<f64> = lights.iter().map(|light| light.brightness_factor.ln()).collect();
    let errors: Vec<f64> = lights.iter().map(|light| light.psnr_db.min(TWO_CODES_DB)).collect();
    let ((factor, factor_spread), (error, error_spread)) = (spread(&factors), spread(&errors));
    for (light, (log_factor, decibels)) in lights.iter_mut().zip(factors.iter().zip(&errors)) {
        let from_median = log_factor - factor;
        let of_surface = light.brightness_spread + LIGHT_ERROR_RAD * light.tangent();
        if from_median.abs() > (OUTLIER * factor_spread).max(LEAST_LOG_FACTOR).max(of_surface) {
            light.doubts.push(format!(
                "is {:.2} times as bright as {other} under its light, where others are {:.2} times: another exposure?",
                light.brightness_factor,
                factor.exp()
            ));
        }
        if error - decibels > (OUTLIER * error_spread).max(LEAST_DECIBELS) {
            let decibels = light.psnr_db;
            light.doubts.push(format!(
                "has an error of {decibels:.1} dB, far from the usual {error:.1} dB: is its light where the list says, or was \
                 something in the way?"
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

/// Why wrong photographs may not be found.
fn limits(
    field: &ReflectanceField,
    photographs: usize,
    texels: usize,
    compared: ComparedWith,
) -> Option<String> {
    let functions = field.basis().len();
    match compared {
        _ if texels < LEAST_TEXELS => Some(format!("{texels} texels are too few to tell which photographs are wrong")),
        ComparedWith::Learned if field.basis().depends_on_view() => Some(
            "functions that are learned from the photographs follow also one that is wrong, which the report may not find: --hold-out N \
             says how well photographs are predicted that were left out"
                .to_owned(),
        ),
        ComparedWith::Learned => Some(
            "functions that are learned from the photographs follow also one that is wrong, which the report may not find: that \
             of a fit of ptm or hsh9 does"
                .to_owned(),
        ),
        ComparedWith::Fit if 2 * functions > photographs => Some(format!(
            "{functions} functions for {photographs} photographs follow each of them, and a wrong one may not be found: the report of \
             --basis rbf compares each with the others"
        )),
        _ => None,
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
