//! The options of a built-in material, shared by several verbs.

use relume::procedural::{Cut, MaterialOptions, Parameters, Tiling};
use relume::{Error, Result, Size};

use crate::args;

/// Options of a built-in material.
#[derive(Debug, clap::Args)]
#[command(next_help_heading = "Built-in materials")]
pub struct MaterialArgs {
    /// Size in texels, such as 512x512 [default: 256x256]
    #[arg(long, value_name = "WxH", value_parser = args::size)]
    size: Option<Size>,
    /// Another seed gives another sample of the same material [default: 0]
    #[arg(long, value_name = "N")]
    seed: Option<u64>,
    /// Size of the largest features in texels [default: 40]
    #[arg(long, value_name = "TEXELS")]
    feature: Option<f64>,
    /// Marble, wood, clouds: depth of the slice through the solid, in feature sizes [default: 0]
    #[arg(long, value_name = "FEATURES", allow_hyphen_values = true)]
    z: Option<f64>,
    /// Marble, clouds: feature sizes after which slices repeat [default: never]
    #[arg(long, value_name = "FEATURES")]
    z_period: Option<u32>,
    /// Marble: the power of the sine, which narrows the veins [default: 5]
    #[arg(long, value_name = "N")]
    power: Option<u32>,
    /// Marble, wood, fire: strength of the noise [default: 8 radians, 14 square rings, 1 height of the
    /// picture]
    #[arg(long, value_name = "A")]
    turbulence: Option<f64>,
    /// Marble, clouds, fire: the number of the finest octave of noise [default: 6, 4, 4]
    #[arg(long, value_name = "N")]
    octaves: Option<u32>,
    /// Wood: a plank sawn along the trunk, or its end [default: plank]
    #[arg(long, value_parser = args::named::<Cut>())]
    cut: Option<Cut>,
    /// Fire: offset of the noise; as it falls, flames rise [default: 0]
    #[arg(long, value_name = "CELLS", allow_hyphen_values = true)]
    phi: Option<f64>,
}

impl MaterialArgs {
    /// The requested options.
    pub fn options(&self, tiling: Tiling) -> MaterialOptions {
        let default = MaterialOptions::default();
        MaterialOptions {
            size: self.size.unwrap_or(default.size),
            seed: self.seed.unwrap_or(default.seed),
            feature: self.feature.unwrap_or(default.feature),
            tiling,
            parameters: self.parameters(),
        }
    }

    fn parameters(&self) -> Parameters {
        Parameters {
            z: self.z,
            z_period: self.z_period,
            power: self.power,
            turbulence: self.turbulence,
            octaves: self.octaves,
            cut: self.cut,
            phi: self.phi,
        }
    }

    /// Refuses all of them: the output is not a built-in material.
    pub fn refuse(&self) -> Result<()> {
        let given = [
            ("--size", self.size.is_some()),
            ("--seed", self.seed.is_some()),
            ("--feature", self.feature.is_some()),
            ("--z", self.z.is_some()),
            ("--z-period", self.z_period.is_some()),
            ("--power", self.power.is_some()),
            ("--turbulence", self.turbulence.is_some()),
            ("--octaves", self.octaves.is_some()),
            ("--cut", self.cut.is_some()),
            ("--phi", self.phi.is_some()),
        ];
        match given.iter().find(|(_, given)| *given) {
            Some((option, _)) => Err(Error::usage(format!(
                "{option} is for built-in materials: map files have a fixed size and fixed features"
            ))),
            None => Ok(()),
        }
    }
}
