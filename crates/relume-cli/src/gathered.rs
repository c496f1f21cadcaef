//! From field files to index planes, and from a source map back to files: shared by the verbs that
//! synthesise.

use std::path::Path;

use relume::field::IndexSpace;
use relume::format::{
    Encoding, ExrDepth, FieldFile, FieldFormat, PictureFormat, encode_translucent, exr, npy,
};
use relume::synthesis::{SourceMap, gather};
use relume::workflow::memory::MemoryPeak;
use relume::{Error, Planes, ReflectanceField, Result, Size};

use crate::context::Context;
use crate::{opacity, output};

/// The index planes of fields of one kind.
pub fn index(files: &[FieldFile], space: &IndexSpace, context: &Context) -> Result<Vec<Planes>> {
    let bytes = 4 * space.planes() as u64;
    let planes = |file: &FieldFile| {
        context.job.check("the index of the exemplar", file.field.size(), bytes)?;
        space.index_planes(&file.field).held(&context.job, "the index of the exemplar")
    };
    files.iter().map(planes).collect()
}

/// Refuses, before any work, outputs of `size` texels of these files that could not be written within
/// the memory.
pub fn check_memory<'a>(
    size: Size,
    files: impl Iterator<Item = &'a FieldFile>,
    context: &Context,
) -> Result<()> {
    let planes: Vec<usize> = files.map(|file| file.field.coefficients().count()).collect();
    MemoryPeak::of_copies(size, &planes).check(&context.job)
}

/// Refuses names of source maps without a known format.
pub fn check_map(path: &Path) -> Result<()> {
    MapFormat::from_path(path).map(|_| ())
}

/// The file made by applying a map to registered fields, in the encoding of the first one.
pub fn apply(map: &SourceMap, files: &[FieldFile], output: &Path, context: &Context) -> Result<Vec<u8>> {
    let fields: Vec<&ReflectanceField> = files.iter().map(|file| &file.field).collect();
    let field = gather(map, &fields, &context.job).map_err(|e| e.at(output))?;
    let encoding = &files[0].encoding;
    let format = if output::is_stream(output) {
        match *encoding {
            Encoding::Ptm(_) => FieldFormat::Ptm,
            Encoding::Picture(depth) => FieldFormat::Picture(PictureFormat::Png(depth)),
            Encoding::Exr(depth) => FieldFormat::Exr(depth),
        }
    } else {
        FieldFormat::from_path(output)?.in_depth_of(encoding)
    };
    let mut opacity = opacity::gathered(map, files, context)?;
    if opacity.is_some() && !format.holds_opacity() {
        opacity = None;
        context
            .job
            .about(output)
            .remark("this format holds no opacity (alpha): write PNG, TIFF or EXR to keep it");
    }
    let shared = files.iter().all(|file| file.encoding == *encoding).then_some(encoding);
    encode_translucent(&field, opacity.as_ref(), format, shared, &context.job).map_err(|e| e.at(output))
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
            exr::encode_labelled(&["x", "y", "exemplar"], &planes, ExrDepth::Float)
        }
    }
}
