//! The fit without one photograph, in closed form.
//!
//! With g = (A'A)^-1 a_i, the residual e of texel p under light i and the leverage h = a_i' g, the
//! least-squares coefficients without photograph i are c - g e / (1 - h) (Cook, Weisberg, "Residuals and
//! Influence in Regression", 1982, appendix A.2). Luminance and colour are then separated as in the fit, with
//! the factor of the remaining lights. Where photographs are interpolated, the others are interpolated at its light.

use crate::field::{Interpolated, PlaneLayout};
use crate::planes::Planes;
use crate::raster::Raster;

use super::design::Design;
use super::levels::SampleLevels;
use super::residual::relight_channel;

/// The coefficients of the fit without photograph `i`, from the channel coefficients `linear` of the fit with
/// it; `None` where the remaining lights do not suffice.
pub(super) fn coefficients_without(
    i: usize,
    photograph: &Raster,
    linear: &Planes,
    layout: &PlaneLayout,
    design: &Design,
    levels: &SampleLevels,
) -> Option<Planes> {
    if let Some(table) = design.interpolated() {
        return interpolated_without(i, linear, layout, design, table);
    }
    let remaining = design.without(i)?;
    let n = design.functions();
    let weights: Vec<f32> = design.values(i).iter().map(|&w| w as f32).collect();
    let texels = linear.size().texels();
    let (mut predicted, mut residual) = (vec![0.0f32; texels], vec![0.0f32; texels]);
    let mut planes = linear.clone();
    for channel in 0..photograph.channels() {
        relight_channel(linear, &PlaneLayout::RGB, &weights, channel, 0, &mut predicted);
        levels.channel(photograph, channel, 0, &mut residual);
        residual.iter_mut().zip(&predicted).for_each(|(p, r)| *p -= r);
        for k in 0..n {
            let share = (design.share(k, i) / (1.0 - design.leverage(i))) as f32;
            let plane = planes.plane_mut(channel * n + k);
            plane.iter_mut().zip(&residual).for_each(|(c, e)| *c -= share * e);
        }
    }
    Some(super::finish(planes, layout, &remaining))
}

/// The coefficients in which photograph `i` is replaced by what the others give under its light.
fn interpolated_without(
    i: usize,
    linear: &Planes,
    layout: &PlaneLayout,
    design: &Design,
    table: &Interpolated,
) -> Option<Planes> {
    let n = design.functions();
    let mut weights = vec![0.0; n - 1];
    table.without(i)?.weights_into(table.lights()[i], &mut weights);
    let others = (0..n).filter(|k| *k != i);
    let mut planes = linear.clone();
    for first in (0..linear.count() / n * n).step_by(n) {
        let mut predicted = vec![0.0f32; linear.size().texels()];
        for (k, weight) in others.clone().zip(&weights) {
            let plane = linear.plane(first + k);
            predicted.iter_mut().zip(plane).for_each(|(sum, value)| *sum += *weight as f32 * value);
        }
        planes.plane_mut(first + i).copy_from_slice(&predicted);
    }
    Some(super::finish(planes, layout, design))
}
