//! BRDFs of the database of UTIA (J. Filip, R. Vavra, "Template-Based Sampling of Anisotropic BRDFs", Computer Graphics
//! Forum 33(7), 2014): tabulated over polar angles in steps of 15 degrees up to 75 and azimuths in steps of 7.5
//! degrees, of light and view.
//!
//! The rule of the database: linear interpolation in all four angles, around the circle in the azimuths, and linear
//! extrapolation beyond 75 degrees; negative values are 0. The values are taken as they are, as 1/sr.

use std::f64::consts::TAU;

use super::angles;
use super::check_numbers;
use crate::direction::{Direction, Directions};
use crate::error::Result;

const POLARS: usize = 6;
const AZIMUTHS: usize = 48;
const DIRECTIONS: usize = POLARS * AZIMUTHS;
const POLAR_STEP: f64 = 15.0 / 180.0 * std::f64::consts::PI;

/// An anisotropic BRDF.
#[derive(Debug, Clone, PartialEq)]
pub struct UtiaBrdf {
    values: Vec<f64>,
}

impl UtiaBrdf {
    /// The polar angles and azimuths of a table.
    pub const ANGLES: [usize; 2] = [POLARS, AZIMUTHS];
    /// The numbers of a table.
    pub const NUMBERS: usize = 3 * DIRECTIONS * DIRECTIONS;

    /// A BRDF from the numbers of a file: red, green and blue, each with the azimuth of the view fastest, then its
    /// polar angle, the azimuth of the light and its polar angle. Negative numbers are 0.
    ///
    /// # Errors
    /// Other than [`UtiaBrdf::NUMBERS`] numbers, or one that is not finite.
    pub fn new(mut numbers: Vec<f64>) -> Result<Self> {
        check_numbers("UTIA", &numbers, Self::NUMBERS)?;
        numbers.iter_mut().for_each(|number| *number = number.max(0.0));
        Ok(Self { values: numbers })
    }

    /// The interpolated value of directions above the surface.
    pub(super) fn evaluate(&self, Directions { light, view }: Directions) -> [f64; 3] {
        let (lights, views) = (corners(light), corners(view));
        std::array::from_fn(|channel| {
            let plane = &self.values[channel * DIRECTIONS * DIRECTIONS..];
            let of_light = |(light, weight): (usize, f64)| {
                let row = &plane[light * DIRECTIONS..];
                weight * views.iter().map(|&(view, weight)| weight * row[view]).sum::<f64>()
            };
            lights.iter().copied().map(of_light).sum::<f64>().max(0.0)
        })
    }
}

/// The four tabulated directions around a direction, and their weights.
fn corners(direction: Direction) -> [(usize, f64); 4] {
    let (polar, azimuth) = angles(direction.to_array());
    let ring = ((polar / POLAR_STEP) as usize).min(POLARS - 2);
    // Beyond the last ring the weight of the one before it is negative.
    let outer = polar / POLAR_STEP - ring as f64;
    let turn = azimuth.rem_euclid(TAU) / TAU * AZIMUTHS as f64;
    let (first, second) = (turn.floor() as usize % AZIMUTHS, (turn.floor() as usize + 1) % AZIMUTHS);
    let next = turn - turn.floor();
    let at = |ring: usize, azimuth: usize| AZIMUTHS * ring + azimuth;
    [
        (at(ring, first), (1.0 - outer) * (1.0 - next)),
        (at(ring, second), (1.0 - outer) * next),
        (at(ring + 1, first), outer * (1.0 - next)),
        (at(ring + 1, second), outer * next),
    ]
}
