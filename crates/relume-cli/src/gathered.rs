//! From field files to index planes, and from a source map back to files: shared by the verbs that
//! synthesise.

use std::path::Path;

use relume::field::{IndexSpace, ParametricField};
use relume::format::{
    Depth, Encoding, ExrDepth, FieldFile, FieldFormat, HeightFormat, HeightMap, HeightScale, MapRole,
    NormalY, PictureFormat, encode_data_map, encode_scaled_height, encode_stored_normals, encode_translucent,
    exr, npy,
};
use relume::synthesis::{SourceMap, gather_index};
use relume::workflow::RegisteredMap;
use relume::workflow::map_set::{gather_map, joint_index};
use relume::workflow::memory::MemoryPeak;
use relume::{Error, Job, Picture, Planes, ReflectanceField, Result, Size, Space};

use crate::context::Context;
use crate::{opacity, output};

/// The index planes of fields of one kind, and of the maps that are compared with them.
pub fn index(
    files: &[FieldFile],
    maps: &[RegisteredMap<'_>],
    space: &IndexSpace,
    context: &Context,
) -> Result<Vec<Planes>> {
    let planes =
        |file: &FieldFile| space.index_planes_within(&file.field, &context.job, "the index of the exemplar");
    joint_index(files.iter().map(planes).collect::<Result<_>>()?, maps, &context.job)
}

/// Refuses, before any work, outputs of `size` texels that could not be written within the memory: files
/// made by applying a map to fields such as these, and with them the map.
pub fn check_memory<'a>(
    size: Size,
    outputs: impl Iterator<Item = (&'a Path, &'a FieldFile)>,
    context: &Context,
) -> Result<()> {
    let output = |(path, file): (&Path, &FieldFile)| {
        Ok((format_of(path, &file.encoding)?, file.field.coefficients().count()))
    };
    let outputs = outputs.map(output).collect::<Result<Vec<_>>>()?;
    MemoryPeak::of_copies(size, &outputs).check(&context.job)
}

/// The format of an output with the values of a file in the given encoding; on standard output its own.
pub fn format_of(output: &Path, encoding: &Encoding) -> Result<FieldFormat> {
    if !output::is_stream(output) {
        return Ok(FieldFormat::from_path(output)?.in_depth_of(encoding));
    }
    Ok(match *encoding {
        Encoding::Ptm(_) => FieldFormat::Ptm,
        Encoding::Hsh(_) => FieldFormat::Rti,
        Encoding::Picture(depth) => FieldFormat::Picture(PictureFormat::Png(depth)),
        Encoding::Exr(depth) => FieldFormat::Exr(depth),
    })
}

/// Refuses names of source maps without a known format.
pub fn check_map(path: &Path) -> Result<()> {
    MapFormat::from_path(path).map(|_| ())
}

/// The field made by applying a map to exemplars, the first of which has a name that says its meaning.
pub fn gather(
    map: &SourceMap,
    files: &[FieldFile],
    name: &Path,
    context: &Context,
) -> Result<ReflectanceField> {
    let fields = files.iter().map(|file| &file.field).collect();
    gather_map(map, &RegisteredMap { role: MapRole::of_name(name), fields }, &context.job)
}

/// The file of a field made of the texels of files by a map, in the encoding of the first one.
pub fn encode(
    field: &ReflectanceField,
    map: &SourceMap,
    files: &[FieldFile],
    output: &Path,
    context: &Context,
) -> Result<Vec<u8>> {
    let encoding = &files[0].encoding;
    let format = format_of(output, encoding)?;
    if let (FieldFormat::Exr(depth), Some(models)) = (format, models_of(files)) {
        let planes: Vec<&Planes> = models.iter().map(|models| models.planes()).collect();
        let made = models[0].with_planes(gather_index(map, &planes, &context.job)?)?;
        return exr::encode_parametric(&made, depth, &context.job).map_err(|e| e.at(output));
    }
    let linear = files.iter().filter_map(FieldFile::linear_remark);
    linear.for_each(|remark| context.job.about(output).remark(remark));
    let mut opacity = opacity::gathered(map, files, context)?;
    if opacity.is_some() && !format.holds_opacity() {
        opacity = None;
        context
            .job
            .about(output)
            .remark("this format holds no opacity (alpha): write PNG, TIFF or EXR to keep it");
    }
    let shared = files.iter().all(|file| file.encoding == *encoding).then_some(encoding);
    encode_translucent(field, opacity.as_ref(), format, shared, &context.job).map_err(|e| e.at(output))
}

/// As [`encode`], of data: a PNG names no colour space, and holds whole numbers as they were and floats from 0 to 1 in 16 bits.
pub fn encode_data(
    field: &ReflectanceField,
    map: &SourceMap,
    files: &[FieldFile],
    output: &Path,
    context: &Context,
) -> Result<Vec<u8>> {
    let opacity = || opacity::gathered(map, files, context);
    let job = &context.job;
    match data_depth(&files[0].encoding, output) {
        Some(depth) => {
            data_map(field, opacity()?.as_ref(), &files[0].encoding, depth, job).map_err(|e| e.at(output))
        }
        None => encode(field, map, files, output, context),
    }
}

/// The file of a map by its meaning: heights and normals with their records, other data without a colour space, else colours; `y` is the
/// direction of Y of normals. A remark says which record the format of the output loses.
pub fn encode_map(
    made: &ReflectanceField,
    map: &SourceMap,
    (files, role, y): (&[FieldFile], MapRole, Option<NormalY>),
    output: &Path,
    context: &Context,
) -> Result<Vec<u8>> {
    let heights =
        files[0].record.heights.filter(|scale| files.iter().all(|f| f.record.heights == Some(*scale)));
    let is_opaque = files.iter().all(|file| file.opacity.as_ref().is_none_or(Planes::is_constant));
    let loses = |what: &str| {
        let sentence = format!("this format does not record {what}: write PNG or EXR to keep it");
        context.job.about(output).remark(sentence);
    };
    if output::is_stream(output) {
        if heights.is_some() || y.is_some() {
            loses("what the values are");
        }
        return encode(made, map, files, output, context);
    }
    match (y, heights, HeightFormat::from_path(output)) {
        (Some(y), _, format) if is_opaque => {
            if format.is_err() {
                loses("the direction of Y of normals");
            }
            encode_normals(made, y, &files[0], output, &context.job)
        }
        (None, Some(scale), Ok(format)) if is_opaque => encode_heights(made, scale, format, &context.job),
        (None, Some(_), Err(_)) if is_opaque => {
            loses("the scale of heights");
            encode_data(made, map, files, output, context)
        }
        _ if role.is_data() => encode_data(made, map, files, output, context),
        _ => encode(made, map, files, output, context),
    }
}

/// The depth of a PNG file of data that come from a file; `None` of other files.
pub fn data_depth(from: &Encoding, output: &Path) -> Option<Depth> {
    match (FieldFormat::from_path(output), from) {
        (Ok(FieldFormat::Picture(PictureFormat::Png(_))), Encoding::Picture(depth)) => Some(*depth),
        (Ok(FieldFormat::Picture(PictureFormat::Png(_))), Encoding::Exr(_)) => Some(Depth::Sixteen),
        _ => None,
    }
}

/// The PNG file of data, with their opacity.
pub fn data_map(
    field: &ReflectanceField,
    opacity: Option<&Planes>,
    from: &Encoding,
    depth: Depth,
    job: &Job,
) -> Result<Vec<u8>> {
    let values = field.coefficients();
    let outside = values.as_slice().iter().find(|value| !(0.0..=1.0).contains(*value));
    // Heights that were joined may pass the largest code a little: they are clipped, which is said.
    if let (Some(outside), Encoding::Exr(_)) = (outside, from) {
        return Err(Error::usage(format!(
            "a PNG holds data from 0 to 1, and the values reach {outside}: name an .exr (--apply-format exr)"
        )));
    }
    let planes: Vec<f32> =
        values.iter().chain(opacity.into_iter().flat_map(Planes::iter)).flatten().copied().collect();
    let planes = Planes::from_vec(field.size(), planes.len() / field.size().texels(), planes)?;
    encode_data_map(&planes, depth, job)
}

/// The reflectance models of files that all hold one kind of them: their numbers are rearranged as they are.
fn models_of(files: &[FieldFile]) -> Option<Vec<&ParametricField>> {
    let models = files.iter().map(|file| Some(&file.models.as_ref()?.models)).collect::<Option<Vec<_>>>()?;
    let kind = |models: &ParametricField| (models.model().clone(), models.channels());
    models.iter().all(|other| kind(other) == kind(models[0])).then_some(models)
}

/// The file of normals as stored, in the depth of the file they come from.
pub fn encode_normals(
    made: &ReflectanceField,
    y: NormalY,
    from: &FieldFile,
    output: &Path,
    job: &Job,
) -> Result<Vec<u8>> {
    let format = match FieldFormat::from_path(output)?.in_depth_of(&from.encoding) {
        FieldFormat::Exr(depth) => PictureFormat::Exr(depth),
        // Floats have more than 8 bits.
        FieldFormat::Picture(format) if matches!(from.encoding, Encoding::Exr(_)) => {
            format.with_depth(Depth::Sixteen)
        }
        FieldFormat::Picture(format) => format,
        FieldFormat::Ptm | FieldFormat::PtmJpeg { .. } | FieldFormat::Rti | FieldFormat::Hsh => {
            return Err(Error::usage("a .ptm or .rti holds functions of light, not normals: name a picture"));
        }
    };
    let mut planes = made.coefficients().clone();
    let is_packed = made.space() == Space::Srgb;
    let is_float = matches!(format, PictureFormat::Exr(_) | PictureFormat::Pfm);
    if is_packed == is_float {
        let convert = |v: &mut f32| *v = if is_packed { 2.0 * *v - 1.0 } else { 0.5 * *v + 0.5 };
        planes.as_mut_slice().iter_mut().for_each(convert);
    }
    let is_linear = is_float || format == PictureFormat::Radiance;
    let space = if is_linear { Space::Linear } else { Space::Srgb };
    encode_stored_normals(&Picture { planes, space }, y, format, job)
}

/// The file of heights as stored, with their scale.
pub fn encode_heights(
    made: &ReflectanceField,
    scale: HeightScale,
    format: HeightFormat,
    job: &Job,
) -> Result<Vec<u8>> {
    let samples = made.coefficients().clone().truncated(1);
    encode_scaled_height(&HeightMap { samples, scale: Some(scale) }, format, job)
}

/// A file format of source maps.
enum MapFormat {
    Npy,
    Exr,
}

impl MapFormat {
    fn from_path(path: &Path) -> Result<Self> {
        match path.extension().and_then(|e| e.to_str()) {
            Some("npy") => Ok(Self::Npy),
            Some("exr") => Ok(Self::Exr),
            _ => Err(Error::usage("a source map is written as .npy or .exr: name the file so").at(path)),
        }
    }
}

/// x, y and exemplar of the source of each texel; for blended texels the dominant one.
pub fn source_map(map: &SourceMap, path: &Path, context: &Context) -> Result<Vec<u8>> {
    context.job.check("the source map", map.size(), 24)?;
    let values = map.copies().iter().flat_map(|from| [from.x, from.y, from.exemplar]);
    match MapFormat::from_path(path)? {
        MapFormat::Npy => {
            let values: Vec<i32> = values.map(u32::cast_signed).collect();
            npy::encode_i32(map.size(), 3, &values)
        }
        MapFormat::Exr => {
            let mut planes = Planes::zeros(map.size(), 3);
            for (k, plane) in planes.iter_mut().enumerate() {
                plane.iter_mut().zip(values.clone().skip(k).step_by(3)).for_each(|(out, v)| *out = v as f32);
            }
            exr::encode_labelled_with(&["x", "y", "exemplar"], &planes, ExrDepth::Float, &context.job)
        }
    }
}
