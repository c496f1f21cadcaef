//! Whether normals found as directions of maximal luminance can be trusted.
//!
//! The maximum of a function is that of the surface only where lights surround it. With few lights, lights on one side,
//! or lights near the zenith alone, functions rise towards the horizon, and so do the normals.

use std::f64::consts::TAU;
use std::fmt;

use crate::direction::Direction;
use crate::field::{Basis, ReflectanceField};
use crate::planes::Planes;

/// Normals are at the horizon below this z: 3 degrees.
const HORIZON_Z: f32 = 0.052;
/// The share of normals at the horizon from which on they are doubtful.
const DOUBTFUL_SHARE: f64 = 0.1;
/// The number of lights below which they are doubtful: twice the terms of a polynomial texture map.
const FEW_LIGHTS: usize = 12;
/// The sector without lights from which on they are doubtful.
const WIDE_GAP_DEG: f64 = 120.0;
/// Lights nearer to the zenith say nothing about their azimuth.
const NEAR_ZENITH_DEG: f64 = 20.0;

/// A reason to doubt normals.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum NormalDoubt {
    /// The share of normals at the horizon, where functions rise without a maximum.
    Horizon(f64),
    /// The number of lights is small.
    FewLights(usize),
    /// No light in a sector of so many degrees.
    Gap(f64),
}

impl fmt::Display for NormalDoubt {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Horizon(share) => write!(
                f,
                "{:.0} % of the normals lie at the horizon, where the functions have no maximum",
                100.0 * share
            ),
            Self::FewLights(count) => write!(f, "the functions were fitted to {count} lights only"),
            Self::Gap(degrees) => write!(f, "no light comes from a sector of {degrees:.0} degrees"),
        }
    }
}

/// The reasons to doubt the normals of a field, found by [`normals`](super::normals()). Lights are known for fields
/// that record them.
pub fn doubts(field: &ReflectanceField, normals: &Planes) -> Vec<NormalDoubt> {
    if *field.basis() == Basis::Constant {
        return Vec::new();
    }
    let z = normals.plane(2);
    let share = z.iter().filter(|z| **z < HORIZON_Z).count() as f64 / z.len() as f64;
    let lights = field.lights();
    let gap = if lights.is_empty() { 0.0 } else { widest_gap_deg(lights) };
    let few =
        (!lights.is_empty() && lights.len() < FEW_LIGHTS).then_some(NormalDoubt::FewLights(lights.len()));
    let gap = (gap > WIDE_GAP_DEG).then_some(NormalDoubt::Gap(gap));
    let horizon = (share > DOUBTFUL_SHARE).then_some(NormalDoubt::Horizon(share));
    few.into_iter().chain(gap).chain(horizon).collect()
}

/// The widest sector of azimuths without a light, in degrees; 360 if all are near the zenith.
fn widest_gap_deg(lights: &[Direction]) -> f64 {
    let inclined = lights
        .iter()
        .map(|light| light.to_array())
        .filter(|[_, _, z]| z.clamp(-1.0, 1.0).acos().to_degrees() >= NEAR_ZENITH_DEG);
    let mut azimuths: Vec<f64> = inclined.map(|[x, y, _]| y.atan2(x)).collect();
    azimuths.sort_by(f64::total_cmp);
    let (Some(first), Some(last)) = (azimuths.first(), azimuths.last()) else { return 360.0 };
    let across = first + TAU - last;
    azimuths.windows(2).map(|pair| pair[1] - pair[0]).fold(across, f64::max).to_degrees()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::field::PlaneLayout;
    use crate::size::Size;
    use crate::space::Space;

    fn ring(count: usize, sector: f64) -> Vec<Direction> {
        (0..count).map(|i| Direction::from_angles(0.8, sector * i as f64 / count as f64)).collect()
    }

    fn field(lights: Vec<Direction>) -> ReflectanceField {
        let planes = Planes::zeros(Size::new(4, 1), 6);
        let field = ReflectanceField::new(Basis::Ptm, PlaneLayout::LUMINANCE, Space::Linear, planes);
        field.unwrap().with_lights(lights)
    }

    fn normals(z: [f32; 4]) -> Planes {
        let mut planes = Planes::zeros(Size::new(4, 1), 3);
        planes.plane_mut(2).copy_from_slice(&z);
        planes
    }

    #[test]
    fn few_lights_and_lights_from_one_side_are_doubted() {
        let upright = normals([1.0; 4]);
        assert_eq!(doubts(&field(ring(40, TAU)), &upright), []);
        assert_eq!(doubts(&field(ring(6, TAU)), &upright), [NormalDoubt::FewLights(6)]);
        let found = doubts(&field(ring(40, TAU / 4.0)), &upright);
        assert!(matches!(found[..], [NormalDoubt::Gap(gap)] if gap > 265.0 && gap < 285.0), "{found:?}");
        let zenith = vec![Direction::ZENITH; 20];
        assert_eq!(doubts(&field(zenith), &upright), [NormalDoubt::Gap(360.0)]);
        assert_eq!(doubts(&field(Vec::new()), &upright), []);
    }

    #[test]
    fn normals_at_the_horizon_are_doubted() {
        let found = doubts(&field(Vec::new()), &normals([0.0, 0.01, 1.0, 0.8]));
        assert_eq!(found, [NormalDoubt::Horizon(0.5)]);
    }
}
