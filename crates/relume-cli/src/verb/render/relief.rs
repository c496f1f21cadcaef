//! The relief of a render: its height map and amount.

use std::path::{Path, PathBuf};

use relume::format::HeightScale;
use relume::render::MeshRelief;
use relume::{Error, Job, Planes, Result, Size};

use crate::{args, evaluated, input};

/// A height map and its use.
#[derive(Debug, clap::Args)]
#[command(next_help_heading = "Relief")]
pub struct ReliefArgs {
    /// The height map of the texture (.exr, .png; `relume height` and `relume procedural` write them), or its
    /// .rlm model
    #[arg(long, value_name = "FILE")]
    height: Option<PathBuf>,
    /// Displace the surface: the height from the lowest to the highest point, in texels (12), in millimetres
    /// (2mm), or as a multiple of the recorded range of the map (1x)
    #[arg(long, value_name = "AMOUNT", value_parser = amount, requires = "height")]
    displace: Option<Amount>,
    /// Only tilt the normals of the surface, by a relief of this height; for textures without shading
    #[arg(long, value_name = "AMOUNT", value_parser = amount, requires = "height")]
    bump: Option<Amount>,
    /// The size of a texel, for amounts in millimetres [default: the record in the height map]
    #[arg(long, value_name = "MM", value_parser = args::texel_mm, requires = "height")]
    pixel_mm: Option<f64>,
}

/// The highest relief that can be asked for, in texels or millimetres.
const HIGHEST: f64 = 1e6;

/// The height of a relief.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Amount {
    Texels(f64),
    Millimetres(f64),
    Times(f64),
}

fn amount(text: &str) -> Result<Amount, String> {
    let number = |text: &str| text.trim().parse::<f64>().ok().filter(|v| (0.0..=HIGHEST).contains(v));
    let parsed = match (text.strip_suffix("mm"), text.strip_suffix('x')) {
        (Some(mm), _) => number(mm).map(Amount::Millimetres),
        (None, Some(times)) => number(times).map(Amount::Times),
        (None, None) => number(text.strip_suffix("texels").unwrap_or(text)).map(Amount::Texels),
    };
    parsed.ok_or_else(|| {
        format!("expected texels (12), millimetres (2mm) or a factor (1x), from 0 to {HIGHEST}")
    })
}

impl ReliefArgs {
    /// The file of the height map, if given.
    pub fn file(&self) -> Option<&Path> {
        self.height.as_deref()
    }

    /// The relief of a texture, if a height map is given, and what is said where it has another size than the
    /// texture.
    ///
    /// # Errors
    /// When it cannot be read, has no effect, other proportions than the texture, or lacks the size of a texel
    /// for an amount in millimetres.
    pub fn read(
        &self,
        evaluated: &evaluated::Args,
        (texture, size, of_model): (&Path, Size, bool),
        job: &Job,
    ) -> Result<Option<(MeshRelief, Option<String>)>> {
        let Some(path) = &self.height else {
            evaluated.check(of_model)?;
            return Ok(None);
        };
        if self.displace.is_none() && self.bump.is_none() {
            return Err(Error::usage("--height does nothing alone: give --displace or --bump as well"));
        }
        let (map, model) = evaluated.height(path, job)?;
        evaluated.check(of_model || model)?;
        let height = input::texels(&map);
        let fitted = if model || of_model { None } else { fitted(path, height.size(), texture, size)? };
        let factor = |amount: Option<Amount>| {
            amount.map_or(Ok(0.0), |amount| self.factor(amount, &height, map.scale).map_err(|e| e.at(path)))
        };
        let (displacement, bump) = (factor(self.displace)?, factor(self.bump)?);
        Ok(Some((MeshRelief { height, displacement, bump }, fitted)))
    }

    /// The height as a multiple of the recorded range.
    fn factor(&self, amount: Amount, height: &Planes, scale: Option<HeightScale>) -> Result<f64> {
        let (low, high) = height.range(0);
        let span = f64::from(high - low);
        let of_span = |texels: f64| if span > 0.0 { texels / span } else { 0.0 };
        match amount {
            Amount::Times(times) => Ok(times),
            Amount::Texels(texels) => Ok(of_span(texels)),
            Amount::Millimetres(mm) => {
                let pixel = self.pixel_mm.or(scale.and_then(|scale| scale.mm_per_texel));
                match pixel.filter(|pixel| *pixel > 0.0 && pixel.is_finite()) {
                    Some(pixel) => Ok(of_span(mm / pixel)),
                    None => Err(Error::usage(
                        "an amount in mm needs the size of a texel: give --pixel-mm, above 0, or an amount in texels",
                    )),
                }
            }
        }
    }
}

/// What is said of a height map that is stretched over a texture of another size but the same proportions, to a
/// texel.
///
/// # Errors
/// Other proportions.
fn fitted(path: &Path, height: Size, texture: &Path, size: Size) -> Result<Option<String>> {
    if height == size {
        return Ok(None);
    }
    let across = height.width as f64 / size.width as f64;
    let rows = across * size.height as f64;
    if (rows - height.height as f64).abs() > across.max(1.0) {
        return Err(Error::usage(format!(
            "is {height} texels, but the texture {} is {size}: a height map has the proportions of its texture",
            texture.display()
        ))
        .at(path));
    }
    Ok(Some(format!(
        "the height map {} is {height} texels and the texture {size}: it is stretched over the texture",
        path.display()
    )))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn amounts_are_texels_millimetres_or_factors() {
        assert_eq!(amount("12"), Ok(Amount::Texels(12.0)));
        assert_eq!(amount("12texels"), Ok(Amount::Texels(12.0)));
        assert_eq!(amount("0.5mm"), Ok(Amount::Millimetres(0.5)));
        assert_eq!(amount("2x"), Ok(Amount::Times(2.0)));
        for bad in ["", "x", "mm", "-1", "nan", "3cm", "infx"] {
            assert!(amount(bad).is_err(), "{bad}");
        }
    }
}
