//! Parameters of single materials, in addition to those that all have.

use crate::error::{Error, Result};
use crate::names::named;

/// How wood is sawn.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Cut {
    /// Along the trunk: the grain runs upwards in the picture.
    Plank,
    /// Across the trunk: rings around the pith.
    End,
}

named!(Cut { Plank => "plank", End => "end" });

/// Parameters that only some materials have; `None` selects the default of the material.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Parameters {
    /// Marble, wood, clouds: depth of the plane of the picture in the solid, in feature sizes.
    pub z: Option<f64>,
    /// Marble, clouds: feature sizes after which the solid repeats along the depth, 1 to 65,536.
    pub z_period: Option<u32>,
    /// Marble: the power of the sine, 1 to 64; more makes finer veins.
    pub power: Option<u32>,
    /// Strength of the noise, 0 to 1000: marble, in radians; wood, in square ring widths; fire, in
    /// heights of the picture.
    pub turbulence: Option<f64>,
    /// Marble, clouds, fire: the number of the finest octave, 1 to 12.
    pub octaves: Option<u32>,
    /// Wood: how it is sawn.
    pub cut: Option<Cut>,
    /// Fire: how far the noise has moved.
    pub phi: Option<f64>,
}

impl Parameters {
    /// The names of the given parameters.
    fn given(&self) -> impl Iterator<Item = &'static str> {
        let named = [
            ("z", self.z.is_some()),
            ("z-period", self.z_period.is_some()),
            ("power", self.power.is_some()),
            ("turbulence", self.turbulence.is_some()),
            ("octaves", self.octaves.is_some()),
            ("cut", self.cut.is_some()),
            ("phi", self.phi.is_some()),
        ];
        named.into_iter().filter(|(_, given)| *given).map(|(name, _)| name)
    }

    /// Checks that `material` has each given parameter, and that it is in range.
    ///
    /// # Errors
    /// The error names the parameter, and those that the material has.
    pub fn validate(&self, material: &str, known: &[&str]) -> Result<()> {
        if let Some(name) = self.given().find(|name| !known.contains(name)) {
            let list = if known.is_empty() { "none".to_owned() } else { known.join(", ") };
            return Err(Error::usage(format!("{material} has no parameter '{name}': it has {list}")));
        }
        let whole = |value: Option<u32>| value.map(f64::from);
        let ranges = [
            ("z", self.z, -1e6, 1e6),
            ("z-period", whole(self.z_period), 1.0, 65_536.0),
            ("power", whole(self.power), 1.0, 64.0),
            ("turbulence", self.turbulence, 0.0, 1000.0),
            ("octaves", whole(self.octaves), 1.0, 12.0),
            ("phi", self.phi, -1e6, 1e6),
        ];
        for (name, value, low, high) in ranges {
            if let Some(value) = value.filter(|value| !(low..=high).contains(value)) {
                return Err(Error::usage(format!(
                    "{name} is {value}: expected a number from {low} to {high}"
                )));
            }
        }
        Ok(())
    }
}
