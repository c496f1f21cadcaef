//! BRDFs of the MERL database (W. Matusik, H. Pfister, M. Brand, L. McMillan, "A Data-Driven Reflectance Model", ACM
//! Transactions on Graphics 22(3), 2003): isotropic, tabulated over the angles of the half vector and the difference
//! vector (S. Rusinkiewicz, "A New Change of Variables for Efficient BRDF Representation", 1998).
//!
//! The rule of the database: the value of the cell into which the angles fall, without interpolation. Cells are a
//! degree of the polar angle and the azimuth of the difference vector, and 90 of the polar angle of the half vector
//! that are narrow at the mirror direction. The azimuth has period pi: measured values are taken as reciprocal.

use std::f64::consts::{FRAC_PI_2, PI};

use super::angles;
use super::check_numbers;
use crate::direction::{Direction, Directions};
use crate::error::Result;

/// Cells of the polar angle of the half vector.
const HALF: usize = 90;
/// Cells of the polar angle of the difference vector.
const DIFFERENCE: usize = 90;
/// Cells of the azimuth of the difference vector.
const AZIMUTH: usize = 180;
/// From stored numbers to 1/sr.
const SCALES: [f64; 3] = [1.0 / 1500.0, 1.15 / 1500.0, 1.66 / 1500.0];

/// An isotropic BRDF.
#[derive(Debug, Clone, PartialEq)]
pub struct MerlBrdf {
    values: Vec<f64>,
}

impl MerlBrdf {
    /// The cells of a table: half vector, difference vector, azimuth.
    pub const CELLS: [usize; 3] = [HALF, DIFFERENCE, AZIMUTH];
    /// The numbers of a table.
    pub const NUMBERS: usize = 3 * HALF * DIFFERENCE * AZIMUTH;

    /// A BRDF from the numbers of a file: red, green and blue, each with the azimuth fastest and the half vector
    /// slowest. Negative numbers mark directions without a measurement, where the BRDF is 0.
    ///
    /// # Errors
    /// Other than [`MerlBrdf::NUMBERS`] numbers, or one that is not finite.
    pub fn new(mut numbers: Vec<f64>) -> Result<Self> {
        check_numbers("MERL", &numbers, Self::NUMBERS)?;
        for (plane, scale) in numbers.chunks_exact_mut(HALF * DIFFERENCE * AZIMUTH).zip(SCALES) {
            plane.iter_mut().for_each(|number| *number = (*number * scale).max(0.0));
        }
        Ok(Self { values: numbers })
    }

    /// The value of the cell of the directions.
    pub(super) fn evaluate(&self, directions: Directions) -> [f64; 3] {
        let cell = cell_of(directions);
        std::array::from_fn(|c| self.values[c * HALF * DIFFERENCE * AZIMUTH + cell])
    }
}

/// The number of the cell into which directions above the surface fall.
fn cell_of(Directions { light, view }: Directions) -> usize {
    let Ok(half) = Direction::new(light.x() + view.x(), light.y() + view.y(), light.z() + view.z()) else {
        return 0;
    };
    let (half_polar, half_azimuth) = angles(half.to_array());
    let turned = about_y(about_z(light.to_array(), -half_azimuth), -half_polar);
    let (polar, azimuth) = angles(turned);
    let half = ((half_polar / FRAC_PI_2).sqrt() * HALF as f64) as usize;
    let difference = (polar / FRAC_PI_2 * DIFFERENCE as f64) as usize;
    let azimuth = ((if azimuth < 0.0 { azimuth + PI } else { azimuth }) / PI * AZIMUTH as f64) as usize;
    azimuth.min(AZIMUTH - 1) + AZIMUTH * (difference.min(DIFFERENCE - 1) + DIFFERENCE * half.min(HALF - 1))
}

fn about_z([x, y, z]: [f64; 3], angle: f64) -> [f64; 3] {
    let (sin, cos) = angle.sin_cos();
    [cos * x - sin * y, sin * x + cos * y, z]
}

fn about_y([x, y, z]: [f64; 3], angle: f64) -> [f64; 3] {
    let (sin, cos) = angle.sin_cos();
    [cos * x + sin * z, y, cos * z - sin * x]
}
