//! Measured reflectances (BRDF) of single materials, evaluated by the rule of their files: textures of light and view
//! with a single texel.
//!
//! A BRDF is the radiance that leaves a surface towards the viewer over the irradiance from the light, in 1/sr. It
//! does not contain the cosine between light and normal: a white Lambertian surface has 1 / pi for all directions.
//! [`BrdfSamples`] gives them pair by pair in the unit of textures, where that surface is 1.

mod merl;
mod rgl;
mod samples;
mod spectrum;
mod tables;
mod utia;

pub use merl::MerlBrdf;
pub use rgl::{RglBrdf, RglTables};
pub use samples::BrdfSamples;
pub use spectrum::rgb_weights;
pub use tables::{TableShape, WarpTables};
pub use utia::UtiaBrdf;

use crate::direction::Directions;
use crate::error::{Error, Result};

/// A measured BRDF.
#[derive(Debug, Clone)]
#[non_exhaustive]
pub enum MeasuredBrdf {
    /// Of the MERL database: isotropic.
    Merl(MerlBrdf),
    /// Of the database of UTIA: anisotropic.
    Utia(UtiaBrdf),
    /// Of the database of the RGL at EPFL: isotropic or anisotropic.
    Rgl(Box<RglBrdf>),
}

impl MeasuredBrdf {
    /// The reflectance in red, green and blue, linear and in 1/sr, without the cosine; 0 where light or view are not
    /// above the surface.
    pub fn evaluate(&self, directions: Directions) -> [f64; 3] {
        if directions.light.z() <= 0.0 || directions.view.z() <= 0.0 {
            return [0.0; 3];
        }
        match self {
            Self::Merl(brdf) => brdf.evaluate(directions),
            Self::Utia(brdf) => brdf.evaluate(directions),
            Self::Rgl(brdf) => brdf.evaluate(directions),
        }
    }

    /// The database.
    pub fn name(&self) -> &'static str {
        match self {
            Self::Merl(_) => "MERL",
            Self::Utia(_) => "UTIA",
            Self::Rgl(_) => "RGL",
        }
    }
}

/// The polar angle from the zenith and the azimuth from x towards y, accurate near the zenith.
fn angles([x, y, z]: [f64; 3]) -> (f64, f64) {
    (x.hypot(y).atan2(z), y.atan2(x))
}

/// Refuses numbers that are not all of a database's table.
fn check_numbers(database: &str, numbers: &[f64], expected: usize) -> Result<()> {
    if numbers.len() != expected {
        return Err(Error::invalid(format!(
            "a {database} BRDF has {expected} numbers, found {}",
            numbers.len()
        )));
    }
    match numbers.iter().position(|number| !number.is_finite()) {
        None => Ok(()),
        Some(i) => Err(Error::invalid(format!(
            "number {i} of the {database} BRDF is not finite: the file is damaged"
        ))),
    }
}
