//! Textures of light and view whose photographs are rearranged by a source map, one after another, into an archive.

use std::io::{BufWriter, Seek, SeekFrom};
use std::path::{Path, PathBuf};

use rayon::prelude::*;
use relume::format::{Depth, ExrDepth, PictureFormat, ZipArchive, encode_picture_with, ubo2003};
use relume::synthesis::{SourceMap, gather};
use relume::workflow::{Btf, Missing};
use relume::{Error, Footprint, Picture, Raster, ReflectanceField, Result, Samples, Size};

use crate::context::Context;
use crate::output::Outputs;
use crate::report::counted;

/// Photographs per thread that are made before they are written.
const AT_A_TIME: usize = 4;

/// A set of photographs to rearrange, and the archive for the result.
pub struct AppliedBtf {
    pub input: PathBuf,
    pub output: PathBuf,
}

/// Opens the sets, whose photographs must have the size of the exemplar.
///
/// # Errors
/// A set that cannot be opened, or whose first photograph has another size.
pub fn open_all(sets: &[AppliedBtf], exemplar: Size, context: &Context) -> Result<Vec<Btf>> {
    let open = |set: &AppliedBtf| {
        let btf = Btf::open(&set.input, Missing::Fill, &context.job)?;
        let size = btf.photograph(0, &context.job)?.size();
        if size != exemplar {
            return Err(Error::usage(format!(
                "has photographs of {size} and its exemplar {exemplar} texels: both must be registered, texel by texel"
            ))
            .at(&set.input));
        }
        Ok(btf)
    };
    sets.iter().map(open).collect()
}

/// The bytes of photographs, if nothing were compressed, from which on their size is said before the work.
const NOTABLE_BYTES: u64 = 1 << 30;

/// Writes the archives: of each photograph the texels that the map says, in its own encoding. Returns a line on each.
///
/// # Errors
/// Photographs that cannot be read or differ in size, limits, cancellation, and errors of the system.
pub fn write_all(
    sets: &[AppliedBtf],
    opened: &[Btf],
    map: &SourceMap,
    outputs: &mut Outputs,
    context: &Context,
) -> Result<Vec<String>> {
    let mut said = Vec::new();
    for (set, btf) in sets.iter().zip(opened) {
        let count = btf.list().entries.len();
        context.job.start("rearranging photographs", count as u64);
        let one = Footprint::of_texels(map.size(), 64, 16).peak;
        let fitting = usize::try_from(context.job.free_bytes() / one.max(1)).unwrap_or(usize::MAX);
        let batch = (AT_A_TIME * rayon::current_num_threads()).min(fitting).max(1);
        context.job.check_bytes("the photographs made at a time", one * batch as u64)?;
        let first = btf.photograph(0, &context.job)?;
        let samples = (count * map.size().texels() * first.channels()) as u64;
        if samples >= NOTABLE_BYTES {
            context.job.about(&set.output).remark(format!(
                "{} of {} have {:.1} GB before compression",
                counted(count, "photograph"),
                map.size(),
                samples as f64 / 1e9
            ));
        }
        let mut bytes = 0;
        let root = Path::new(set.output.file_stem().unwrap_or_default()).to_string_lossy().into_owned();
        outputs.write_with(&set.output, |file| {
            let mut archive = ZipArchive::new(BufWriter::new(file), root);
            for first in (0..count).step_by(batch) {
                let made = (first..(first + batch).min(count)).into_par_iter();
                let made: Vec<(String, Vec<u8>)> =
                    made.map(|i| rearranged(btf, i, map, context)).collect::<Result<_>>()?;
                for (name, bytes) in made {
                    archive.add(&name, &bytes)?;
                }
            }
            let mut file = archive.finish()?;
            let end = file.seek(SeekFrom::End(0));
            bytes = end.map_err(|e| Error::io("cannot write the file", &e).at(&set.output))?;
            Ok(())
        })?;
        said.push(format!(
            "{}: {} of {} rearranged, {:.1} MB",
            set.output.display(),
            counted(count, "photograph"),
            map.size(),
            bytes as f64 / 1e6
        ));
    }
    Ok(said)
}

/// The name and the file of photograph `i`, rearranged.
fn rearranged(btf: &Btf, i: usize, map: &SourceMap, context: &Context) -> Result<(String, Vec<u8>)> {
    let photograph = btf.photograph(i, &context.job)?;
    let (format, extension) = format_of(&photograph);
    let space = photograph.samples().space();
    let field = ReflectanceField::from_picture(photograph.to_picture(space));
    let made = gather(map, &[&field], &context.job).map_err(|e| e.at(btf.path()))?;
    let picture = Picture { planes: made.coefficients().clone(), space };
    let bytes = encode_picture_with(&picture, format, &context.job)?;
    context.job.advance(1)?;
    Ok((ubo2003::image_name(i, btf.list().entries[i].directions, extension), bytes))
}

/// The format without further loss: a JPEG becomes a PNG.
fn format_of(photograph: &Raster) -> (PictureFormat, &'static str) {
    match photograph.samples() {
        Samples::U8(_) => (PictureFormat::Png(Depth::Eight), "png"),
        Samples::U16(_) => (PictureFormat::Png(Depth::Sixteen), "png"),
        Samples::F32(_) => (PictureFormat::Exr(ExrDepth::Half), "exr"),
    }
}
