//! Fields in EXR files: one channel per coefficient, described by text attributes.
//!
//! | attribute | value |
//! |---|---|
//! | `relumeField` | `1`, the version of this layout |
//! | `relumeBasis` | the name of the basis |
//! | `relumeInterpolated` | of `rbf` and `tabulated`, the directions of their lights as in `relumeLights` |
//! | `relumeLearned`, `relumeLearnedValues` | the table of a learned basis: see [`learned`] |
//! | `relumeLearnedPacked` | the integers of a learned basis that is packed, instead of the table |
//! | `relumeColor` | the layout of planes: `luminance`, `rgb`, `lrgb`, `channels`, `shared` |
//! | `relumeChannels` | the names of the channels of `channels` and `shared`, in order, separated by `;` |
//! | `relumeSpace` | `linear` or `srgb` |
//! | `relumeLights` | directions `x y z`, separated by `;`, where known |
//!
//! A texture in clusters, and one of reflectance models, has other channels: see [`clustered`] and [`parametric`].
//!
//! A channel is named `basis.function.colour`, so that viewers show each function as a layer: `ptm.u2.R`;
//! `ptm.u2.Y` for luminance; `color.R` for the colour of an LRGB field; `learned.f0` for coefficients common to
//! all channels. Files store channels in alphabetical
//! order, so planes are looked up by name, never by position. A linear field of constants has the plain names
//! of its channels, such as `R`, `G`, `B` or `Y`, and any program reads it as a picture. An opacity is the
//! channel `A`; it multiplies the values of such a picture, and no others.

use std::collections::BTreeMap;

use super::ExrDepth;
use super::channels;
use super::clustered;
use super::codec;
use super::container::{self, Layer};
use super::learned;
use super::parametric;
use super::picture::{multiplied, picture_of};
use crate::direction::Direction;
use crate::error::{Error, Result};
use crate::field::{Basis, Interpolated, Interpolation, PlaneLayout, PlaneRole, ReflectanceField};
use crate::fit::parametric::linear_form;
use crate::format::meaning::Meaning;
use crate::format::opacity;
use crate::format::texel_models::TexelModels;
use crate::job::Job;
use crate::names::Named;
use crate::planes::Planes;
use crate::raster::{Raster, Samples};
use crate::space::Space;

pub(super) const VERSION_KEY: &str = "relumeField";
const BASIS_KEY: &str = "relumeBasis";
const INTERPOLATED_KEY: &str = "relumeInterpolated";
const LEARNED_KEY: &str = "relumeLearned";
const PACKED_KEY: &str = "relumeLearnedPacked";
const VALUES_KEY: &str = "relumeLearnedValues";
pub(super) const COLOR_KEY: &str = "relumeColor";
const CHANNELS_KEY: &str = "relumeChannels";
pub(super) const SPACE_KEY: &str = "relumeSpace";
const LIGHTS_KEY: &str = "relumeLights";

pub(super) const VERSION: &str = "1";

/// The channel of the opacity.
const OPACITY: &str = "A";

/// Whether channels and attributes belong to functions rather than to a picture.
pub(in crate::format) fn is_field(names: &[String], texts: &BTreeMap<String, String>) -> bool {
    texts.contains_key(VERSION_KEY) && !channels::are_plain(names)
}

/// The linear picture in an EXR file.
pub(in crate::format) fn decode_picture(bytes: &[u8], meaning: Meaning, job: &Job) -> Result<Raster> {
    let layer = codec::decode(bytes, job)?;
    if is_field(&layer.names, &layer.attributes) {
        return Err(Error::unsupported(
            "the EXR file holds a texture of functions: expected a picture; relight it to make one",
        ));
    }
    picture_of(&layer, meaning, job)
}

/// The bytes of a field, with an opacity if there is one.
pub(in crate::format) fn encode_field(
    field: &ReflectanceField,
    opacity: Option<&Planes>,
    depth: ExrDepth,
    job: &Job,
) -> Result<Vec<u8>> {
    encode_with(field, opacity, depth, &[], job)
}

/// As [`encode_field`], with more attributes.
pub(super) fn encode_with(
    field: &ReflectanceField,
    opacity: Option<&Planes>,
    depth: ExrDepth,
    more: &[(&'static str, String)],
    job: &Job,
) -> Result<Vec<u8>> {
    let (mut names, mut attributes) = field_head(field, depth);
    attributes.extend_from_slice(more);
    let Some(opacity) = opacity else {
        return container::encode(&names, field.coefficients(), depth, &attributes, job);
    };
    let planes = match channels::are_plain(&names) {
        true => multiplied(field.coefficients(), opacity),
        false => field.coefficients().clone(),
    };
    names.push(OPACITY.to_owned());
    let samples = [planes.as_slice(), opacity.plane(0)].concat();
    let planes = Planes::from_vec(field.size(), names.len(), samples)?;
    container::encode(&names, &planes, depth, &attributes, job)
}

/// The name of each plane's channel, and the attributes of a field.
pub(in crate::format) fn field_head(
    field: &ReflectanceField,
    depth: ExrDepth,
) -> (Vec<String>, Vec<(&'static str, String)>) {
    let names = channel_names(field.basis(), field.layout(), field.space());
    let mut attributes = parts_of(field.basis(), field.layout(), field.space(), depth);
    if !field.lights().is_empty() {
        attributes.push((LIGHTS_KEY, directions_as_text(field.lights())));
    }
    (names, attributes)
}

/// The attributes of a field beside its planes and lights.
pub(super) fn parts_of(
    basis: &Basis,
    layout: &PlaneLayout,
    space: Space,
    depth: ExrDepth,
) -> Vec<(&'static str, String)> {
    let mut attributes = vec![
        (VERSION_KEY, VERSION.to_owned()),
        (BASIS_KEY, basis.name().to_owned()),
        (COLOR_KEY, layout.name().to_owned()),
        (SPACE_KEY, space.to_string()),
    ];
    if let Basis::Interpolated(interpolated) = basis {
        attributes.push((INTERPOLATED_KEY, directions_as_text(interpolated.lights())));
    }
    if let Basis::Learned(learned) = basis {
        match learned::packed_of(learned) {
            Some(packed) => attributes.push((PACKED_KEY, packed)),
            None => {
                attributes.push((LEARNED_KEY, learned::pairs_of(learned)));
                attributes.push((VALUES_KEY, learned::values_of(learned, depth)));
            }
        }
    }
    if layout.is_named() || layout.is_shared() {
        attributes.push((CHANNELS_KEY, layout.channel_names().join(";")));
    }
    attributes
}

/// A field as an EXR file holds it.
pub(in crate::format) struct ExrField {
    pub field: ReflectanceField,
    /// One plane, where it varies.
    pub opacity: Option<Planes>,
    pub depth: ExrDepth,
    /// The reflectance models of which the field is the linear form.
    pub models: Option<TexelModels>,
}

/// The field in an EXR file. A picture is a linear field of constants, and so are several channels that are
/// no picture.
pub(in crate::format) fn decode_field(bytes: &[u8], meaning: Meaning, job: &Job) -> Result<ExrField> {
    let layer = codec::decode(bytes, job)?;
    match layer.attributes.get(VERSION_KEY) {
        None if channels::choose(&layer.names, meaning != Meaning::Colors).is_none() => {
            named_channels(&layer, job)
        }
        None => {
            let raster = opacity::kept(picture_of(&layer, meaning, job)?, meaning, job);
            let opacity = raster.opacity_plane();
            let field = ReflectanceField::from_picture(raster.to_picture(Space::Linear));
            Ok(ExrField { field, opacity, depth: layer.depth, models: None })
        }
        Some(version) if version == VERSION => described(&layer, job),
        Some(version) => Err(Error::unsupported(format!(
            "the field's layout has version '{version}' and this program reads version {VERSION}: update it"
        ))),
    }
}

/// The field that attributes describe.
fn described(layer: &Layer, job: &Job) -> Result<ExrField> {
    if clustered::is_clustered(layer) {
        let field = clustered::clustered_of(layer, job)?.expanded(job)?;
        return Ok(ExrField { field, opacity: None, depth: layer.depth, models: None });
    }
    if parametric::is_parametric(layer) {
        let models = parametric::parametric_of(layer)?;
        let (field, rmse) = linear_form(&models, job)?;
        let models = Some(TexelModels { models, rmse });
        return Ok(ExrField { field, opacity: None, depth: layer.depth, models });
    }
    let layout = layout_of(layer)?;
    let basis = basis_of(layer, &layout, job)?;
    let space = space_of(layer)?;
    let names = channel_names(&basis, &layout, space);
    let mut planes = ordered(layer, &names)?;
    let has_opacity = !names.iter().any(|name| name == OPACITY);
    let alphas = layer.names.iter().position(|name| name == OPACITY).filter(|_| has_opacity);
    let alphas = alphas.map(|k| Samples::F32(layer.planes.plane(k).to_vec()));
    if let Some(alphas) = alphas.as_ref().filter(|_| channels::are_plain(&names)) {
        planes.iter_mut().for_each(|plane| opacity::divide_plane(plane, alphas));
    }
    let opacity = alphas.and_then(|alphas| opacity::plane(layer.planes.size(), alphas, job));
    let field = ReflectanceField::new(basis, layout, space, planes)?.with_lights(lights_of(layer)?);
    Ok(ExrField { field, opacity, depth: layer.depth, models: None })
}

/// All channels as those of one texture of constants, with a remark: which of them are a picture is not clear.
fn named_channels(layer: &Layer, job: &Job) -> Result<ExrField> {
    job.remark(format!(
        "the EXR channels {} are no picture: all are taken, as the named channels of one texture",
        channels::listed(&layer.names)
    ));
    let layout = PlaneLayout::of_channels(layer.names.iter().cloned())?;
    let field = ReflectanceField::new(Basis::Constant, layout, Space::Linear, layer.planes.clone())?;
    Ok(ExrField { field, opacity: None, depth: layer.depth, models: None })
}

/// The basis that attributes describe.
pub(super) fn basis_of(layer: &Layer, layout: &PlaneLayout, job: &Job) -> Result<Basis> {
    let channels = if layout.is_shared() { layout.channels() } else { 1 };
    match layer.attributes.get(BASIS_KEY).map(String::as_str) {
        Some("learned") if layer.attributes.contains_key(PACKED_KEY) => {
            learned::from_packed(attribute(layer, PACKED_KEY)?, channels, job).map(Basis::Learned)
        }
        Some("learned") => {
            let (pairs, values) = (attribute(layer, LEARNED_KEY)?, attribute(layer, VALUES_KEY)?);
            learned::from_texts(pairs, values, channels).map(Basis::Learned)
        }
        name => match Interpolation::ALL.into_iter().find(|rule| Some(rule.name()) == name) {
            Some(rule) => {
                let text = attribute(layer, INTERPOLATED_KEY)?;
                let lights = directions_of(text, INTERPOLATED_KEY, Direction::from_unit_vector)?;
                Interpolated::new(&lights, rule).map(Basis::Interpolated)
            }
            None => named(layer, BASIS_KEY, Basis::from_name),
        },
    }
}

/// The space that attributes describe.
pub(super) fn space_of(layer: &Layer) -> Result<Space> {
    named(layer, SPACE_KEY, Space::from_name)
}

/// The layout that attributes describe.
pub(super) fn layout_of(layer: &Layer) -> Result<PlaneLayout> {
    match layer.attributes.get(COLOR_KEY).map(String::as_str) {
        Some("channels") => PlaneLayout::of_channels(attribute(layer, CHANNELS_KEY)?.split(';')),
        Some("shared") => PlaneLayout::shared(attribute(layer, CHANNELS_KEY)?.split(';')),
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
        PlaneRole::Shared { function } => format!("{}.{}", basis.name(), functions[function]),
        PlaneRole::Color { channel } => format!("color.{channel}"),
    };
    layout.roles(functions.len()).into_iter().map(name).collect()
}

/// An attribute that must be there.
pub(super) fn attribute<'a>(layer: &'a Layer, key: &str) -> Result<&'a str> {
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
pub(super) fn ordered(layer: &Layer, names: &[String]) -> Result<Planes> {
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
    directions_of(text, LIGHTS_KEY, Direction::new)
}

pub(super) fn directions_of(
    text: &str,
    key: &str,
    direction: impl Fn(f64, f64, f64) -> Result<Direction>,
) -> Result<Vec<Direction>> {
    let one = |text: &str| {
        let numbers: Option<Vec<f64>> = text.split_whitespace().map(|n| n.parse().ok()).collect();
        match numbers.as_deref() {
            Some(&[x, y, z]) => direction(x, y, z),
            _ => Err(Error::invalid(format!(
                "the EXR field's attribute '{key}' holds '{text}': expected three numbers"
            ))),
        }
    };
    text.split(';').filter(|light| !light.trim().is_empty()).map(one).collect()
}

pub(super) fn directions_as_text(directions: &[Direction]) -> String {
    let texts = directions.iter().map(|d| format!("{} {} {}", d.x(), d.y(), d.z()));
    texts.collect::<Vec<_>>().join(";")
}
