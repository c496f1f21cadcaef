//! Fields in EXR files: one channel a coefficient, what they mean as attributes of text.
//!
//! | attribute | value |
//! |---|---|
//! | `relumeField` | `1`, the version of this layout |
//! | `relumeBasis` | the basis: `ptm`, `constant` |
//! | `relumeColor` | the colour model: `luminance`, `rgb`, `lrgb` |
//! | `relumeSpace` | `linear` or `srgb` |
//! | `relumeLights` | directions `x y z`, separated by `;`, where known |
//!
//! A channel is named `basis.function.colour`, so that viewers show each function as a layer:
//! `ptm.u2.R`; `ptm.u2.Y` for luminance; `color.R` for the colour of an LRGB field. Files hold
//! channels in alphabetical order, so planes are found by name, never by position. A linear field
//! of constants has the plain names `R`, `G`, `B` or `Y` and is a picture to every program.

use super::ExrDepth;
use super::container::{self, Layer};
use super::picture::{channel_names as picture_names, picture_of};
use crate::direction::Direction;
use crate::error::{Error, Result};
use crate::field::{Basis, ColorModel, ReflectanceField};
use crate::job::Job;
use crate::planes::Planes;
use crate::space::Space;

const VERSION_KEY: &str = "relumeField";
const BASIS_KEY: &str = "relumeBasis";
const COLOR_KEY: &str = "relumeColor";
const SPACE_KEY: &str = "relumeSpace";
const LIGHTS_KEY: &str = "relumeLights";

const VERSION: &str = "1";

/// Whether a layer holds functions rather than a picture.
pub(super) fn is_field(layer: &Layer) -> bool {
    layer.attributes.contains_key(VERSION_KEY) && picture_of(layer).is_err()
}

/// The bytes of a field.
pub(in crate::format) fn encode_field(field: &ReflectanceField, depth: ExrDepth) -> Result<Vec<u8>> {
    let (names, attributes) = field_head(field);
    container::encode(&names, field.coefficients(), depth, &attributes)
}

/// The name of each plane's channel, and the attributes of a field.
pub(in crate::format) fn field_head(field: &ReflectanceField) -> (Vec<String>, Vec<(&'static str, String)>) {
    let names = channel_names(field.basis(), field.color(), field.space());
    let mut attributes = vec![
        (VERSION_KEY, VERSION.to_owned()),
        (BASIS_KEY, field.basis().name().to_owned()),
        (COLOR_KEY, field.color().name().to_owned()),
        (SPACE_KEY, field.space().to_string()),
    ];
    if !field.lights().is_empty() {
        let lights = field.lights().iter().map(|d| format!("{} {} {}", d.x(), d.y(), d.z()));
        attributes.push((LIGHTS_KEY, lights.collect::<Vec<_>>().join(";")));
    }
    (names, attributes)
}

/// The field in an EXR file; a plain picture is a linear field of constants.
pub(in crate::format) fn decode_field(bytes: &[u8], job: &Job) -> Result<(ReflectanceField, ExrDepth)> {
    let layer = container::decode(bytes, job)?;
    let Some(version) = layer.attributes.get(VERSION_KEY) else {
        let picture = picture_of(&layer)?.to_picture(Space::Linear);
        return Ok((ReflectanceField::from_picture(picture), layer.depth));
    };
    if version != VERSION {
        return Err(Error::unsupported(format!(
            "the field's layout has version '{version}' and this program reads version {VERSION}: update it"
        )));
    }
    let basis = named(&layer, BASIS_KEY, Basis::from_name)?;
    let color = named(&layer, COLOR_KEY, ColorModel::from_name)?;
    let space = named(&layer, SPACE_KEY, space_from_name)?;
    let planes = ordered(&layer, &channel_names(basis, color, space))?;
    let field = ReflectanceField::new(basis, color, space, planes)?;
    Ok((field.with_lights(lights_of(&layer)?), layer.depth))
}

/// The channel names of a field in the order of its planes.
fn channel_names(basis: Basis, color: ColorModel, space: Space) -> Vec<String> {
    if basis == Basis::Constant && space == Space::Linear && color != ColorModel::Lrgb {
        return picture_names(color.channels());
    }
    let functions = |channel: &'static str| {
        basis.function_names().iter().map(move |function| format!("{}.{function}.{channel}", basis.name()))
    };
    match color {
        ColorModel::Luminance => functions("Y").collect(),
        ColorModel::Rgb => ["R", "G", "B"].into_iter().flat_map(functions).collect(),
        ColorModel::Lrgb => {
            functions("Y").chain(["R", "G", "B"].map(|channel| format!("color.{channel}"))).collect()
        }
    }
}

fn named<T>(layer: &Layer, key: &str, parse: impl Fn(&str) -> Option<T>) -> Result<T> {
    let value = layer
        .attributes
        .get(key)
        .ok_or_else(|| Error::invalid(format!("the EXR field has no attribute '{key}'")))?;
    parse(value).ok_or_else(|| {
        Error::unsupported(format!("the EXR field's attribute '{key}' has the unknown value '{value}'"))
    })
}

fn space_from_name(name: &str) -> Option<Space> {
    [Space::Linear, Space::Srgb].into_iter().find(|space| space.to_string() == name)
}

/// The planes of the named channels in this order.
fn ordered(layer: &Layer, names: &[String]) -> Result<Planes> {
    let mut samples = Vec::with_capacity(layer.planes.size().texels() * names.len());
    for name in names {
        let k = layer.names.iter().position(|n| n == name).ok_or_else(|| {
            Error::invalid(format!("the EXR field has no channel '{name}', which its basis needs"))
        })?;
        samples.extend_from_slice(layer.planes.plane(k));
    }
    Planes::from_vec(layer.planes.size(), names.len(), samples)
}

fn lights_of(layer: &Layer) -> Result<Vec<Direction>> {
    let text = layer.attributes.get(LIGHTS_KEY).map_or("", String::as_str);
    let lights = text.split(';').filter(|light| !light.trim().is_empty());
    lights.map(light_from).collect()
}

fn light_from(text: &str) -> Result<Direction> {
    let numbers: Option<Vec<f64>> = text.split_whitespace().map(|n| n.parse().ok()).collect();
    match numbers.as_deref() {
        Some(&[x, y, z]) => Direction::from_vector(x, y, z),
        _ => Err(Error::invalid(format!(
            "the EXR field's attribute '{LIGHTS_KEY}' holds '{text}': expected three numbers"
        ))),
    }
}
