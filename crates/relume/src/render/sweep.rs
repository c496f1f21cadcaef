//! Paths of the light for sequences of relit pictures.

use std::f64::consts::{FRAC_PI_4, PI, TAU};
use std::str::FromStr;

use crate::direction::Direction;
use crate::error::{Error, Result};

/// Half the angle of an arc: 75 degrees, the lowest lights of most captures. Functions fitted to photographs
/// extrapolate beyond.
const ARC_POLAR_RAD: f64 = 75.0 * PI / 180.0;
/// The most pictures in one sweep.
const MAX_LIGHTS: usize = 100_000;

/// A path of the light, written `orbit:N` or `arc:N` for N pictures.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Sweep {
    /// A circle around the zenith, from the right (+x) counter-clockwise; it closes, so the last light is one
    /// step before the first.
    Orbit {
        /// The number of lights.
        lights: usize,
        /// The angle from the zenith.
        polar_rad: f64,
    },
    /// From 75 degrees on the left (-x) over the zenith to 75 degrees on the right.
    Arc {
        /// The number of lights; a single one is at the zenith.
        lights: usize,
    },
}

impl Sweep {
    /// The light directions in order.
    pub fn directions(self) -> Vec<Direction> {
        match self {
            Self::Orbit { lights, polar_rad } => (0..lights)
                .map(|i| Direction::from_angles(polar_rad, TAU * i as f64 / lights as f64))
                .collect(),
            Self::Arc { lights: 1 } => vec![Direction::ZENITH],
            Self::Arc { lights } => (0..lights)
                .map(|i| 2.0 * i as f64 / (lights - 1) as f64 - 1.0)
                .map(|t| Direction::from_angles(t * ARC_POLAR_RAD, 0.0))
                .collect(),
        }
    }
}

impl FromStr for Sweep {
    type Err = Error;

    /// Reads `orbit:N` (at 45 degrees) or `arc:N`.
    fn from_str(text: &str) -> Result<Self> {
        let wrong = || {
            Error::usage(format!(
                "{text:?} is not a sweep: expected orbit:N or arc:N with N from 1 to {MAX_LIGHTS}"
            ))
        };
        let (path, lights) = text.split_once(':').ok_or_else(wrong)?;
        let lights = lights.parse().ok().filter(|n| (1..=MAX_LIGHTS).contains(n)).ok_or_else(wrong)?;
        match path {
            "orbit" => Ok(Self::Orbit { lights, polar_rad: FRAC_PI_4 }),
            "arc" => Ok(Self::Arc { lights }),
            _ => Err(wrong()),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn assert_near(a: Direction, b: Direction) {
        assert!(a.to_array().iter().zip(b.to_array()).all(|(a, b)| (a - b).abs() < 1e-12), "{a:?} {b:?}");
    }

    #[test]
    fn an_orbit_closes_at_one_height() {
        let lights = "orbit:8".parse::<Sweep>().unwrap().directions();
        assert_eq!(lights.len(), 8);
        let step = lights[0].dot(lights[1]);
        for (i, light) in lights.iter().enumerate() {
            assert!((light.z() - FRAC_PI_4.cos()).abs() < 1e-12);
            assert!((light.dot(lights[(i + 1) % 8]) - step).abs() < 1e-12);
        }
        assert_near(lights[2], Direction::new(0.0, 1.0, 1.0).unwrap());
    }

    #[test]
    fn an_arc_goes_over_the_zenith_from_left_to_right() {
        let lights = "arc:5".parse::<Sweep>().unwrap().directions();
        assert_near(lights[2], Direction::ZENITH);
        assert_near(lights[4], Direction::from_angles(ARC_POLAR_RAD, 0.0));
        assert!(lights.windows(2).all(|pair| pair[0].x() < pair[1].x() && pair[0].y().abs() < 1e-15));
        assert_near("arc:1".parse::<Sweep>().unwrap().directions()[0], Direction::ZENITH);
    }

    #[test]
    fn what_is_no_sweep_is_refused() {
        for text in ["", "orbit", "orbit:", "orbit:0", "arc:-3", "spiral:4", "arc:1e3", "orbit:99999999999"] {
            assert!(text.parse::<Sweep>().is_err(), "{text}");
        }
    }
}
