//! Fields in EXR files: one channel per coefficient, described by text attributes.
//!
//! | attribute | value |
//! |---|---|
//! | `relumeField` | `1`, the version of this layout |
//! | `relumeBasis` | the basis: `constant`, `ptm`, `hsh9`, `learned` |
//! | `relumeLearned` | the table of a learned basis: see [`learned`] |
//! | `relumeColor` | the layout of planes: `luminance`, `rgb`, `lrgb`, `channels` |
//! | `relumeChannels` | the names of `channels`, in order, separated by `;` |
//! | `relumeSpace` | `linear` or `srgb` |
//! | `relumeLights` | directions `x y z`, separated by `;`, where known |
//!
//! A channel is named `basis.function.colour`, so that viewers show each function as a layer: `ptm.u2.R`;
//! `ptm.u2.Y` for luminance; `color.R` for the colour of an LRGB field. Files store channels in alphabetical
//! order, so planes are looked up by name, never by position. A linear field of constants has the plain names
//! of its channels, such as `R`, `G`, `B` or `Y`, and any program reads it as a picture.

use std::collections::BTreeMap;

use super::ExrDepth;
use super::codec;
use super::container::{self, Layer};
use super::learned;
use super::picture::{is_picture, picture_of};
use crate::direction::Direction;
use crate::error::{Error, Result};
use crate::field::{Basis, PlaneLayout, PlaneRole, ReflectanceField};
use crate::job::Job;
use crate::names::Named;
use crate::planes::Planes;
use crate::raster::Raster;
use crate::space::Space;

const VERSION_KEY: &str = "relumeField";
const BASIS_KEY: &str = "relumeBasis";
const LEARNED_KEY: &str = "relumeLearned";
const COLOR_KEY: &str = "relumeColor";
const CHANNELS_KEY: &str = "relumeChannels";
const SPACE_KEY: &str = "relumeSpace";
const LIGHTS_KEY: &str = "relumeLights";

const VERSION: &str = "1";

/// Whether channels and attributes belong to functions rather than to a picture.
pub(in crate::format) fn is_field(names: &[String], texts: &BTreeMap<String, String>) -> bool {
    texts.contains_key(VERSION_KEY) && !is_picture(names)
}

/// The linear picture in an EXR file.
pub(in crate::format) fn decode_picture(bytes: &[u8], job: &Job) -> Result<Raster> {
    let layer = codec::decode(bytes, job)?;
    if is_field(&layer.names, &layer.attributes) {
        return Err(Error::unsupported(
            "the EXR file holds a texture of functions: expected a picture; relight it to make one",
        ));
    }
    picture_of(&layer)
}

/// The bytes of a field.
pub(in crate::format) fn encode_field(field: &ReflectanceField, depth: ExrDepth) -> Result<Vec<u8>> {
    let (names, attributes) = field_head(field);
    container::encode(&names, field.coefficients(), depth, &attributes)
}

/// The name of each plane's channel, and the attributes of a field.
pub(in crate::format) fn field_head(field: &ReflectanceField) -> (Vec<String>, Vec<(&'static str, String)>) {
    let names = channel_names(field.basis(), field.layout(), field.space());
    let mut attributes = vec![
        (VERSION_KEY, VERSION.to_owned()),
        (BASIS_KEY, field.basis().name().to_owned()),
        (COLOR_KEY, field.layout().name().to_owned()),
        (SPACE_KEY, field.space().to_string()),
    ];
    if let Basis::Learned(learned) = field.basis() {
        attributes.push((LEARNED_KEY, learned::text_of(learned)));
    }
    if field.layout().is_named() {
        attributes.push((CHANNELS_KEY, field.layout().channel_names().join(";")));
    }
    if !field.lights().is_empty() {
        let lights = field.lights().iter().map(|d| format!("{} {} {}", d.x(), d.y(), d.z()));
        attributes.push((LIGHTS_KEY, lights.collect::<Vec<_>>().join(";")));
    }
    (names, attributes)
}

/// The field in an EXR file; a plain picture is a linear field of constants.
pub(in crate::format) fn decode_field(bytes: &[u8], job: &Job) -> Result<(ReflectanceField, ExrDepth)> {
    let layer = codec::decode(bytes, job)?;
    let Some(version) = layer.attributes.get(VERSION_KEY) else {
        let picture = picture_of(&layer)?.to_picture(Space::Linear);
        return Ok((ReflectanceField::from_picture(picture), layer.depth));
    };
    if version != VERSION {
        return Err(Error::unsupported(format!(
            "the field's layout has version '{version}' and this program reads version {VERSION}: update it"
        )));
    }
    let basis = basis_of(&layer)?;
    let layout = layout_of(&layer)?;
    let space = named(&layer, SPACE_KEY, Space::from_name)?;
    let planes = ordered(&layer, &channel_names(&basis, &layout, space))?;
    let field = ReflectanceField::new(basis, layout, space, planes)?;
    Ok((field.with_lights(lights_of(&layer)?), layer.depth))
}

fn basis_of(layer: &Layer) -> Result<Basis> {
    match layer.attributes.get(BASIS_KEY).map(String::as_str) {
        Some("learned") => learned::from_text(attribute(layer, LEARNED_KEY)?).map(Basis::Learned),
        _ => named(layer, BASIS_KEY, Basis::from_name),
    }
}

fn layout_of(layer: &Layer) -> Result<PlaneLayout> {
    match layer.attributes.get(COLOR_KEY).map(String::as_str) {
        Some("channels") => PlaneLayout::of_channels(attribute(layer, CHANNELS_KEY)?.split(';')),
        _ => named(layer, COLOR_KEY, PlaneLayout::from_name),
    }
}

/// The channel names of a field in the order of its planes.
fn channel_names(basis: &Basis, layout: &PlaneLayout, space: Space) -> Vec<String> {
    // `Y` is the customary name of luminance; named channels keep their names.
    let of_exr = |channel: &str| if channel == "L" && !layout.is_named() { "Y" } else { channel }.to_owned();
    if *basis == Basis::Constant && space == Space::Linear && !layout.is_product() {
        return layout.channel_names().into_iter().map(of_exr).collect();
    }
    let functions = basis.function_names();
    let name = |role: PlaneRole<'_>| match role {
        PlaneRole::Coefficient { channel, function } => {
            format!("{}.{}.{}", basis.name(), functions[function], of_exr(channel))
        }
        PlaneRole::Color { channel } => format!("color.{channel}"),
    };
    layout.roles(functions.len()).into_iter().map(name).collect()
}

fn attribute<'a>(layer: &'a Layer, key: &str) -> Result<&'a str> {
    let value = layer.attributes.get(key).map(String::as_str);
    value.ok_or_else(|| Error::invalid(format!("the EXR field has no attribute '{key}'")))
}

fn named<T>(layer: &Layer, key: &str, parse: impl Fn(&str) -> Option<T>) -> Result<T> {
    let value = attribute(layer, key)?;
    parse(value).ok_or_else(|| {
        Error::unsupported(format!("the EXR field's attribute '{key}' has the unknown value '{value}'"))
    })
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
        Some(&[x, y, z]) => Direction::new(x, y, z),
        _ => Err(Error::invalid(format!(
            "the EXR field's attribute '{LIGHTS_KEY}' holds '{text}': expected three numbers"
        ))),
    }
}
