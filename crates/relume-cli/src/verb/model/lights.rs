//! A model for each of some light directions instead of a joint one.

use clap::builder::{PossibleValuesParser, TypedValueParser};
use relume::capture::dome;
use relume::{Direction, Error, ReflectanceField, Result};

use crate::args;

/// Arguments for fields under moving light.
#[derive(Debug, clap::Args)]
#[group(skip)]
pub struct LightArgs {
    /// How functions of light direction are modelled: jointly, or as the pictures under each of some lights
    #[arg(long, value_name = "HOW", default_value = "joint", value_parser = fields())]
    fields: Modelled,
    /// A light for --fields per-light, towards it; give it for each [default: twelve spread over the hemisphere]
    #[arg(long, value_name = "X,Y,Z", value_parser = args::light, allow_hyphen_values = true)]
    light: Vec<Direction>,
}

/// How many lights are taken where none are given: twice as many as the functions of a polynomial texture map.
const CUSTOMARY: usize = 12;

/// How functions are modelled.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Modelled {
    Joint,
    PerLight,
}

fn fields() -> impl TypedValueParser<Value = Modelled> {
    PossibleValuesParser::new(["joint", "per-light"]).map(|name| match name.as_str() {
        "per-light" => Modelled::PerLight,
        _ => Modelled::Joint,
    })
}

impl LightArgs {
    /// The lights under which pictures of a field are modelled; none for a joint model. `combined` is whether a
    /// structure is asked for.
    pub fn chosen(&self, field: &ReflectanceField, combined: bool) -> Result<Option<Vec<Direction>>> {
        if self.fields == Modelled::Joint {
            return match self.light.is_empty() {
                true => Ok(None),
                false => Err(Error::usage("--light belongs to --fields per-light: give both or neither")),
            };
        }
        if field.basis().len() == 1 {
            return Err(Error::usage(
                "--fields per-light is for functions of light direction, and this is a picture",
            ));
        }
        if combined {
            return Err(Error::usage(
                "--combine always cannot be had with --fields per-light: models of single lights have no structure",
            ));
        }
        Ok(Some(if self.light.is_empty() { dome::lights(CUSTOMARY) } else { self.light.clone() }))
    }
}
