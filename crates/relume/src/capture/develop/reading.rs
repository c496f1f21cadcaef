//! Whether integer samples are linear or sRGB-encoded.
//!
//! Files rarely say it, and a wrong guess costs more than any choice of method: shading is proportional to the cosine
//! in linear values only. So both readings are tried on a matt surface at a few thousand texels. The measure of each is
//! the median over the texels of the part of the variance, over the lights, that a matt surface does not explain.

use serde::Serialize;

use super::lambert;
use super::sample::TexelSample;
use crate::names::named;
use crate::space::{Space, linear_from_srgb};

/// How integer samples are read.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum InputSpace {
    /// sRGB-encoded, as cameras write them.
    #[default]
    Srgb,
    /// Proportional to light, as some sets and converters of camera files have them.
    Linear,
    /// As the one of both that a matt surface explains better.
    Auto,
}

named!(InputSpace { Srgb => "srgb", Linear => "linear", Auto => "auto" });

/// How well a matt surface explains both readings.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct ReadingCheck {
    /// The median share of the variance that is left with linear samples.
    pub left_if_linear: f64,
    /// The same with sRGB-encoded samples.
    pub left_if_srgb: f64,
    /// The number of texels compared.
    pub texels: usize,
}

/// Readings whose measures differ by less than this factor are not told apart.
const CLEAR: f64 = 1.25;
/// The fewest texels and lights that say anything.
const FEWEST_TEXELS: usize = 50;
const FEWEST_LIGHTS: usize = 8;

impl ReadingCheck {
    /// The reading that fits better.
    pub fn better(&self) -> Space {
        if self.left_if_linear < self.left_if_srgb { Space::Linear } else { Space::Srgb }
    }

    /// Whether the better one is clearly better.
    pub fn is_clear(&self) -> bool {
        let (a, b) = (self.left_if_linear, self.left_if_srgb);
        a.max(b) > CLEAR * a.min(b)
    }

    /// What is to be said to someone who read the samples in `taken`, if anything.
    pub fn warning(&self, taken: Space) -> Option<String> {
        let better = self.better();
        (better != taken && self.is_clear()).then(|| {
            format!(
                "the photographs look {} rather than {}: a matt surface leaves {:.0} % of their variance unexplained \
                 instead of {:.0} %; compare with --input-space {}",
                described(better),
                described(taken),
                100.0 * self.left_if_linear.min(self.left_if_srgb),
                100.0 * self.left_if_linear.max(self.left_if_srgb),
                crate::names::Named::name(better)
            )
        })
    }
}

fn described(space: Space) -> &'static str {
    match space {
        Space::Linear => "linear",
        Space::Srgb => "sRGB-encoded",
    }
}

/// Compares both readings of integer samples; `None` where there are too few lights or usable texels.
pub fn check_reading(sample: &TexelSample) -> Option<ReadingCheck> {
    if sample.lights.len() < FEWEST_LIGHTS {
        return None;
    }
    let decoded = sample.mapped(|v| f64::from(linear_from_srgb(v as f32)));
    let (mut linear, mut srgb) = (Vec::new(), Vec::new());
    for (stored, decoded) in sample.texels().zip(decoded.texels()) {
        let Some(used) = lambert::used(stored) else { continue };
        let left = |values: &[f64]| unexplained(&sample.lights, values, &used);
        if let (Some(a), Some(b)) = (left(stored), left(decoded)) {
            linear.push(a);
            srgb.push(b);
        }
    }
    let texels = linear.len();
    (texels >= FEWEST_TEXELS).then(|| ReadingCheck {
        left_if_linear: median(linear),
        left_if_srgb: median(srgb),
        texels,
    })
}

/// The part of the variance of the used values that a matt texel leaves.
fn unexplained(lights: &[[f64; 3]], values: &[f64], used: &[usize]) -> Option<f64> {
    let texel = lambert::solve(lights, values, used)?;
    let mean = used.iter().map(|&k| values[k]).sum::<f64>() / used.len() as f64;
    let left: f64 = used.iter().map(|&k| (values[k] - lambert::shaded(&texel, &lights[k])).powi(2)).sum();
    let all: f64 = used.iter().map(|&k| (values[k] - mean).powi(2)).sum();
    (all > 1e-12).then(|| left / all)
}

/// The middle value, the upper one of two; there is one at least.
pub(super) fn median(mut values: Vec<f64>) -> f64 {
    let middle = values.len() / 2;
    *values.select_nth_unstable_by(middle, f64::total_cmp).1
}
