//! Copies of pictures whose values are no colours: heights with their scale, normals with the direction of Y, and other data, such as
//! roughness, whose files name no colour space.

use std::path::Path;

use relume::format::{
    Content, Depth, ExrDepth, FieldFile, FieldFormat, HeightFormat, HeightScale, MapRole, NormalY, Opened,
    PictureFormat, encode_translucent,
};
use relume::{Error, Job, ReflectanceField, Result, Space};
use serde_json::json;

use super::{Args, ConvertedPlace, Target, report};
use crate::gathered;
use crate::report::Report;

/// A map, and what it is.
pub(super) struct RecordedMap {
    file: FieldFile,
    meaning: MapMeaning,
}

/// What values are.
enum MapMeaning {
    Heights(HeightScale),
    Normals(NormalY),
    /// To be written as a PNG file of this depth, or as floats.
    Data(Option<Depth>),
}

/// Whether a file is one of floats, whose values are linear by convention.
fn holds_floats(path: &Path) -> bool {
    let picture = PictureFormat::from_path(path);
    matches!(picture, Ok(PictureFormat::Exr(_) | PictureFormat::Pfm | PictureFormat::Radiance))
}

/// The file of data as floats: the values are those of the file they come from, whatever space that names.
fn as_floats(file: &FieldFile, output: &Path, job: &Job) -> Result<Vec<u8>> {
    let field = &file.field;
    let planes = field.coefficients().clone();
    let data = ReflectanceField::new(field.basis().clone(), field.layout().clone(), Space::Linear, planes)?;
    encode_translucent(&data, file.opacity.as_ref(), FieldFormat::from_path(output)?, None, job)
}

impl RecordedMap {
    /// The map in a file; `None` of others, and where other values than those of the file are asked for.
    ///
    /// # Errors
    /// As those of the reader.
    pub fn of(opened: &Opened, args: &Args) -> Result<Option<Self>> {
        let is_copy = args.basis.is_none() && args.space.is_none() && args.color.is_none();
        if !is_copy || !matches!(opened.content(), Content::Picture | Content::Heights) {
            return Ok(None);
        }
        let record = opened.record()?;
        let by_name =
            || NormalY::of_name(&args.file).filter(|_| MapRole::of_name(&args.file) == MapRole::Normal);
        let is_data = MapRole::of_name(&args.file).is_data();
        let is_recorded = record.heights.is_some() || record.normal_y.or_else(by_name).is_some();
        if !is_recorded && !is_data {
            return Ok(None);
        }
        let file = opened.clone().into_registered()?;
        let meaning = match (record.heights, record.normal_y.or_else(by_name)) {
            (Some(scale), _) => Some(MapMeaning::Heights(scale)),
            (None, Some(y)) => (file.field.layout().channels() == 3).then_some(MapMeaning::Normals(y)),
            (None, None) => match gathered::data_depth(&file.encoding, &args.output) {
                Some(depth) => Some(MapMeaning::Data(Some(depth))),
                None => holds_floats(&args.output).then_some(MapMeaning::Data(None)),
            },
        };
        Ok(meaning.map(|meaning| Self { file, meaning }))
    }

    /// Writes the same map in another file.
    ///
    /// # Errors
    /// Files that cannot record what the values are.
    pub fn copied(self, place: ConvertedPlace<'_>) -> Result<Report> {
        let (args, job) = (place.args, &place.context.job);
        let output = &args.output;
        let advice = "; with --space srgb, the values alone";
        match place.target {
            Target::File(FieldFormat::Exr(ExrDepth::Half)) => {
                return Err(Error::usage(format!(
                    "maps of heights and normals keep the depth of their file: leave out --half{advice}"
                ))
                .at(output));
            }
            Target::File(_) => {}
            Target::Npz | Target::Npy | Target::Web(_) => {
                return Err(Error::usage(format!(
                    "a map of {} is written as a picture{advice}",
                    self.name()
                ))
                .at(output));
            }
        }
        let Self { file, meaning } = &self;
        let bytes = match meaning {
            MapMeaning::Normals(_) if HeightFormat::from_path(output).is_err() => Err(Error::usage(format!(
                "normals are written as .png or .exr, which record the direction of Y{advice}"
            ))),
            MapMeaning::Normals(y) => gathered::encode_normals(&file.field, *y, file, output, job),
            MapMeaning::Data(Some(depth)) => {
                gathered::data_map(&file.field, file.opacity.as_ref(), &file.encoding, *depth, job)
            }
            MapMeaning::Data(None) => as_floats(file, output, job),
            MapMeaning::Heights(scale) => HeightFormat::from_path(output)
                .map_err(|_| {
                    Error::usage(format!(
                        "heights are written as .png or .exr, which record their scale{advice}"
                    ))
                })
                .and_then(|format| gathered::encode_heights(&file.field, *scale, format, job)),
        };
        let bytes = bytes.map_err(|e| e.at(output))?;
        let mut outputs = place.outputs;
        outputs.write(output, bytes)?;
        let written = outputs.commit()?;
        let from =
            json!({ "basis": file.field.basis(), "color": file.field.layout(), "space": file.field.space() });
        let said = match meaning {
            MapMeaning::Data(_) => format!("the same {}, which name no colour space", self.name()),
            _ => format!("the same {}, with their record", self.name()),
        };
        Ok(report(output, &file.field, &said, from, None).with_outputs(written))
    }

    fn name(&self) -> String {
        match self.meaning {
            MapMeaning::Heights(_) => "heights".to_owned(),
            MapMeaning::Normals(y) => format!("normals ({})", y.in_words()),
            MapMeaning::Data(_) => "data".to_owned(),
        }
    }
}
