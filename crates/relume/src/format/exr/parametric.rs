//! Textures of reflectance models in EXR files: a channel for each number of a texel, named by its meaning (`diffuse.R`,
//! `lobe0.n`, `view12.ptm.u2.G`, `product0.light3.R`); `relumeParametric` is the kind of model, `relumeParametricViews` are its
//! views where it has a function or a number for each, and `relumeParametricLights` its lights, as in `relumeLights`.

use super::ExrDepth;
use super::codec;
use super::container::{self, Layer};
use super::field::{
    COLOR_KEY, SPACE_KEY, VERSION, VERSION_KEY, attribute, directions_as_text, directions_of, ordered,
    space_of,
};
use crate::direction::Direction;
use crate::error::{Error, Result};
use crate::field::{Basis, ParametricField, PerViewModel, SeparableModel, TexelModel, ViewFunction};
use crate::job::Job;
use crate::space::Space;

pub(super) const MODEL_KEY: &str = "relumeParametric";
const VIEWS_KEY: &str = "relumeParametricViews";
const LIGHTS_KEY: &str = "relumeParametricLights";

/// Whether a file holds a texture of reflectance models.
pub(super) fn is_parametric(layer: &Layer) -> bool {
    layer.attributes.contains_key(MODEL_KEY)
}

/// The bytes of a texture of reflectance models. In 32-bit floats nothing is lost.
///
/// # Errors
/// Limits exceeded, and a cancelled job.
pub fn encode_parametric(field: &ParametricField, depth: ExrDepth, job: &Job) -> Result<Vec<u8>> {
    let color = if field.channels() == 1 { "luminance" } else { "rgb" };
    let mut attributes = vec![
        (VERSION_KEY, VERSION.to_owned()),
        (MODEL_KEY, field.model().name()),
        (COLOR_KEY, color.to_owned()),
        (SPACE_KEY, field.model().space().to_string()),
    ];
    match field.model() {
        TexelModel::PerView(model) => attributes.push((VIEWS_KEY, directions_as_text(model.views()))),
        TexelModel::Separable(model) => attributes.extend([
            (VIEWS_KEY, directions_as_text(model.views())),
            (LIGHTS_KEY, directions_as_text(model.lights())),
        ]),
        TexelModel::Lafortune { .. } | TexelModel::Ggx => {}
    }
    container::encode(&field.plane_names(), field.planes(), depth, &attributes, job)
}

/// The texture of reflectance models of a file of [`encode_parametric`].
///
/// # Errors
/// A file that holds no such texture, is damaged or exceeds the limits.
pub fn decode_parametric(bytes: &[u8], job: &Job) -> Result<ParametricField> {
    let layer = codec::decode(bytes, job)?;
    if !is_parametric(&layer) {
        return Err(Error::unsupported("the EXR file holds no texture of reflectance models"));
    }
    parametric_of(&layer)
}

/// The texture that attributes describe.
pub(super) fn parametric_of(layer: &Layer) -> Result<ParametricField> {
    let channels = match attribute(layer, COLOR_KEY)? {
        "luminance" => 1,
        "rgb" => 3,
        other => {
            return Err(Error::unsupported(format!(
                "the reflectance models in the EXR field have the colour '{}': expected luminance or rgb",
                other.escape_default()
            )));
        }
    };
    let model = model_of(layer)?;
    let names = model.number_names(channels)?;
    ParametricField::new(model, channels, ordered(layer, &names)?)
}

fn model_of(layer: &Layer) -> Result<TexelModel> {
    let name = attribute(layer, MODEL_KEY)?;
    let number = |text: &str| text.parse::<usize>().ok();
    let directions =
        |key: &'static str| directions_of(attribute(layer, key)?, key, Direction::from_unit_vector);
    if let Some(lobes) = name.strip_prefix("lafortune").and_then(number) {
        return Ok(TexelModel::Lafortune { lobes });
    }
    if let Some(products) = name.strip_prefix("separable").and_then(number) {
        let (views, lights) = (directions(VIEWS_KEY)?, directions(LIGHTS_KEY)?);
        return SeparableModel::new(&views, &lights, products, space_of(layer)?).map(TexelModel::Separable);
    }
    if name == "ggx" {
        return Ok(TexelModel::Ggx);
    }
    let function = name.strip_prefix("views-").and_then(|of| match of.strip_prefix("lafortune") {
        Some(count) => number(count).map(ViewFunction::Lobes),
        None => Basis::from_name(of).map(|basis| ViewFunction::Basis(basis, Space::Linear)),
    });
    let function = match function {
        Some(ViewFunction::Basis(basis, _)) => ViewFunction::Basis(basis, space_of(layer)?),
        Some(lobes @ ViewFunction::Lobes(_)) => lobes,
        None => {
            return Err(Error::unsupported(format!(
                "the EXR field holds reflectance models of the unknown kind '{}'",
                name.escape_default()
            )));
        }
    };
    PerViewModel::new(&directions(VIEWS_KEY)?, function).map(TexelModel::PerView)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::field::parametric::examples;
    use crate::format::{Content, decode_field, read};

    #[test]
    fn models_come_back_to_the_bit_and_any_reader_of_fields_takes_them() {
        let job = Job::default();
        for field in examples::all() {
            let bytes = encode_parametric(&field, ExrDepth::Float, &job).unwrap();
            assert_eq!(decode_parametric(&bytes, &job).unwrap(), field);
            let opened = read(&*bytes, "models.exr", &job).unwrap();
            assert_eq!(opened.content(), Content::Field);
            let linear = opened.into_field().unwrap().field;
            assert_eq!((linear.size(), linear.basis().name()), (field.size(), "learned"));
        }
        let remarks = job.remarks().join("\n");
        assert!(remarks.contains("ggx") && remarks.contains("learned functions"), "{remarks}");
    }

    #[test]
    fn halves_keep_the_meaning_of_numbers() {
        let job = Job::default();
        for field in examples::all() {
            let bytes = encode_parametric(&field, ExrDepth::Half, &job).unwrap();
            let read = decode_parametric(&bytes, &job).unwrap();
            assert_eq!(read.model(), field.model());
            let pairs = read.planes().as_slice().iter().zip(field.planes().as_slice());
            assert!(pairs.into_iter().all(|(a, b)| (a - b).abs() < 1e-3));
        }
    }

    #[test]
    fn damaged_models_are_refused_in_a_sentence() {
        let job = Job::default();
        let refused = |example: usize, change: &dyn Fn(&mut Layer)| {
            let bytes = encode_parametric(&examples::all()[example], ExrDepth::Float, &job).unwrap();
            let mut layer = codec::decode(&bytes, &job).unwrap();
            change(&mut layer);
            parametric_of(&layer).unwrap_err().to_string()
        };
        let with = |example: usize, key: &str, value: &str| {
            refused(example, &|layer| {
                layer.attributes.insert(key.to_owned(), value.to_owned());
            })
        };
        assert!(with(1, MODEL_KEY, "phong").contains("unknown kind 'phong'"));
        for lobes in
            ["lafortune0", "lafortune99999999999", "views-lafortune", "views-lafortune-1", "views-learned"]
        {
            let message = with(7, MODEL_KEY, lobes);
            assert!(message.contains("lobes") || message.contains("unknown kind"), "{message}");
        }
        assert!(with(1, COLOR_KEY, "lrgb").contains("'lrgb'"));
        assert!(with(7, VIEWS_KEY, "1 2").contains("expected three numbers"));
        assert!(with(7, VIEWS_KEY, "").contains("of 0"));
        assert!(with(7, VIEWS_KEY, "0 0 2").contains("length"));
        assert!(with(7, VIEWS_KEY, "0 0 1;0 0 1").contains("given twice"));
        for (kind, words) in
            [("separable0", "1 to 16 products"), ("separable99", "not of 99"), ("separable", "unknown kind")]
        {
            assert!(with(11, MODEL_KEY, kind).contains(words), "{kind}");
        }
        assert!(with(11, MODEL_KEY, "separable3").contains("no channel"));
        assert!(with(11, LIGHTS_KEY, "0 0 1;0 0 1").contains("the light (0, 0, 1) is given twice"));
        assert!(refused(5, &|layer| layer.names[1] = "other".to_owned()).contains("no channel"));
        assert!(refused(5, &|layer| layer.planes.plane_mut(0)[2] = f32::NAN).contains("NaN"));
        let plain = crate::field::clustered_example().expanded(&job).unwrap();
        let plain =
            crate::format::encode_field(&plain, crate::format::FieldFormat::Exr(ExrDepth::Float), None, &job);
        let plain = plain.unwrap();
        assert!(decode_parametric(&plain, &job).is_err() && decode_field(&plain, &job).is_ok());
    }
}
