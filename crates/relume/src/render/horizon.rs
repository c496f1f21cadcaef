//! The attached shadow: light near the horizon of a surface fades out.

use crate::field::Basis;

/// The cosine between light and object below which the attached shadow begins by itself: six degrees.
const FADE_COSINE: f64 = 0.1;

/// How the light that a surface gets fades out towards its horizon.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum AttachedShadow {
    /// Smoothly over the last six degrees.
    Smooth,
    /// In proportion to the cosine below that of the lowest lights that were measured: values there are those of these lights, and
    /// a matt surface gets so much less of the light.
    Proportional {
        /// The cosine of the lowest lights.
        from: f64,
    },
}

impl AttachedShadow {
    /// That of a texture whose texels have the functions of a basis.
    pub fn of(basis: &Basis) -> Self {
        match basis.lowest_light_cosine().filter(|cosine| *cosine > FADE_COSINE) {
            Some(from) => Self::Proportional { from },
            None => Self::Smooth,
        }
    }

    /// The cosine between the light and the normal of the surface below which it begins.
    pub fn begins(self) -> f64 {
        match self {
            Self::Smooth => FADE_COSINE,
            Self::Proportional { from } => from,
        }
    }

    /// The share of a light that a surface gets, by the cosine between the light and its normal: 0 below the horizon, 1
    /// above the fade, and continuous.
    pub fn share(self, cosine: f64) -> f64 {
        let t = (cosine / self.begins()).clamp(0.0, 1.0);
        match self {
            Self::Smooth => t * t * (3.0 - 2.0 * t),
            Self::Proportional { .. } => t,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::direction::Direction;
    use crate::field::{Interpolated, Interpolation};

    /// A fault: objects were as bright below the lowest measured lights as there, down to a hard edge at the horizon.
    #[test]
    fn below_the_lowest_measured_lights_a_surface_gets_light_as_a_matt_one() {
        let basis = |deg: f64, rule| {
            let ring = (0..8).map(|i| Direction::from_angles(deg.to_radians(), 0.7 * f64::from(i)));
            let lights: Vec<Direction> = ring.chain([Direction::ZENITH]).collect();
            Basis::Interpolated(Interpolated::new(&lights, rule).unwrap())
        };
        let shadow = AttachedShadow::of(&basis(60.0, Interpolation::Triangles));
        for (cosine, share) in [(-0.1, 0.0), (0.0, 0.0), (0.25, 0.5), (0.5, 1.0), (0.9, 1.0)] {
            assert!((shadow.share(cosine) - share).abs() < 1e-9, "{shadow:?} {cosine}");
        }
        assert_eq!(AttachedShadow::of(&basis(86.0, Interpolation::Triangles)), AttachedShadow::Smooth);
        assert_eq!(AttachedShadow::of(&basis(60.0, Interpolation::RadialBasis)), AttachedShadow::Smooth);
        assert_eq!(AttachedShadow::of(&Basis::Ptm), AttachedShadow::Smooth);
    }
}
