//! Textures as web pages load them: their planes, and what a viewer shows beside the functions.
//!
//! Normals and albedo are those of [`surface::normals`](crate::surface::normals()) and
//! [`surface::albedo`](crate::surface::albedo); heights are the surface whose slopes are nearest to the normals
//! ([`surface::integrate`](crate::surface::integrate)).

use crate::direction::Direction;
use crate::error::Result;
use crate::field::ReflectanceField;
use crate::format::share::blocks::{BLOCK_SIDE, block_bytes};
use crate::format::share::planes::PlaneDepth;
use crate::format::share::pyramid::TILED_TEXELS;
use crate::format::share::{ShareExtras, ShareFiles};
use crate::format::{FieldFile, PictureFormat, TileSetFile, encode_picture_with};
use crate::job::Job;
use crate::memory::Footprint;
use crate::picture::Picture;
use crate::planes::Planes;
use crate::random_field::FieldModel;
use crate::render::{Environment, Relighter};
use crate::size::Size;
use crate::surface::integrate::{self, IntegrateOptions, SurfaceBorder, integrate};
use crate::surface::{STEEPEST, Slopes, normals_and_albedo};
use crate::workflow::endless::{ModelPlane, PlaneWindow};
use crate::workflow::memory::MemoryPeak;

/// The longer side of a thumbnail, in texels.
const THUMBNAIL_SIDE: usize = 512;
/// The quality of a thumbnail's JPEG file.
const THUMBNAIL_QUALITY: u8 = 80;

/// The planes of the maps: normals, heights and albedo.
const MAP_PLANES: u64 = 3 + 1 + 3;
/// Bytes of a texel while heights are found, beside the integration: normals, colours and slopes.
const BYTES_OF_SLOPES: u64 = 12 + 12 + 16;
/// Bytes of a texel while planes are stored whole: three of them as they are encoded.
const BYTES_ENCODED: u64 = 48;
/// Bytes of a texel of a plane that is stored whole: the file, and its halves before they are compressed.
const BYTES_PER_PLANE: u64 = 3;
/// Bytes of a texel of a plane that is stored in tiles: a copy, its smaller levels, and the files.
const BYTES_PER_TILED_PLANE: u64 = 9;

/// What is shared.
#[derive(Debug)]
pub struct ShareOptions {
    /// A name for people.
    pub title: String,
    /// The storage of coefficients.
    pub depth: PlaneDepth,
    /// The side of a texel in millimetres, where known.
    pub mm_per_texel: Option<f64>,
    /// Light from all around.
    pub environment: Option<Environment>,
}

/// The files of a texture.
///
/// # Errors
/// As [`ShareFiles::new`].
pub fn share(file: &FieldFile, options: &ShareOptions, job: &Job) -> Result<ShareFiles> {
    check_memory(&file.field, job)?;
    let (normals, albedo) = normals_and_albedo(&file.field);
    let slopes = Slopes::from_normals(&normals, STEEPEST)?;
    let height = integrate(&slopes, &IntegrateOptions::default(), job)?;
    drop(slopes);
    with_maps(file, options, (&normals, &albedo), Some(&height), None, job)
}

/// The files of a set of tiles. Heights are left out, since a tile has none of its own.
///
/// # Errors
/// As [`ShareFiles::new`].
pub fn share_tiles(set: &TileSetFile, options: &ShareOptions, job: &Job) -> Result<ShareFiles> {
    check_memory(&set.file.field, job)?;
    let (normals, albedo) = normals_and_albedo(&set.file.field);
    with_maps(&set.file, options, (&normals, &albedo), None, Some(set), job)
}

/// The files of the plane of a model but for its squares, which [`block`] makes.
///
/// # Errors
/// As [`ShareFiles::of_blocks`].
pub fn share_model(model: &FieldModel, options: &ShareOptions, job: &Job) -> Result<ShareFiles> {
    ShareFiles::of_blocks(&model.texel()?, model.tile_size(), &options.title, options.mm_per_texel, job)
}

/// The file of a square of the plane of a model, by its column and row.
///
/// # Errors
/// Places too far away, memory, and a cancelled job.
pub fn block(plane: &ModelPlane, [column, row]: [i64; 2], job: &Job) -> Result<Vec<u8>> {
    let side = BLOCK_SIDE as i64;
    let window = PlaneWindow {
        x: column.saturating_mul(side),
        y: row.saturating_mul(side),
        size: Size::new(BLOCK_SIDE, BLOCK_SIDE),
    };
    Ok(block_bytes(&plane.part(&window, job)?))
}

fn check_memory(field: &ReflectanceField, job: &Job) -> Result<()> {
    check_share_memory(field.size(), field.coefficients().count(), job)
}

/// Refuses a texture of so many planes of coefficients that cannot be shared within the memory.
///
/// # Errors
/// [`ErrorKind::Limit`](crate::ErrorKind::Limit).
pub fn check_share_memory(size: Size, planes: usize, job: &Job) -> Result<()> {
    let stored = planes as u64 + MAP_PLANES;
    let storing = if size.texels() >= TILED_TEXELS {
        BYTES_PER_TILED_PLANE * stored
    } else {
        BYTES_ENCODED + BYTES_PER_PLANE * stored
    };
    let slopes = Footprint::of_texels(size, BYTES_OF_SLOPES, BYTES_OF_SLOPES);
    let heights =
        MemoryPeak::of_stages("heights", [slopes, integrate::footprint(size, SurfaceBorder::Open)]).bytes;
    let storing = Footprint::of_texels(size, 4 * MAP_PLANES + storing, 0).peak;
    job.check_bytes("the shared texture", heights.max(storing))
}

fn with_maps(
    file: &FieldFile,
    options: &ShareOptions,
    (normals, albedo): (&Planes, &Picture),
    height: Option<&Planes>,
    tiles: Option<&TileSetFile>,
    job: &Job,
) -> Result<ShareFiles> {
    let extras = ShareExtras {
        title: options.title.clone(),
        normals: Some(normals),
        height,
        albedo: Some(albedo),
        mm_per_texel: options.mm_per_texel,
        tiles,
        environment: options.environment.as_ref(),
    };
    ShareFiles::new(file, &extras, options.depth, job)
}

/// A small picture of a texture under a light from the upper left, as a JPEG file: the mean of whole squares of texels. What it
/// loses of the texture is no loss of the page, and not remarked.
///
/// # Errors
/// As [`encode_picture_with`].
pub fn thumbnail(field: &ReflectanceField, job: &Job) -> Result<Vec<u8>> {
    let light = Direction::new(-0.5, 0.5, 0.7).expect("a vector with a length");
    let picture = Relighter::new(field, job)?.relight(light).to_space(crate::space::Space::Linear);
    let Size { width, height } = picture.size();
    let step = width.max(height).div_ceil(THUMBNAIL_SIDE);
    let picture = Picture { planes: picture.planes.reduced(step), space: picture.space };
    encode_picture_with(&picture, PictureFormat::Jpeg { quality: THUMBNAIL_QUALITY }, &job.unheard())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::field::{Basis, PlaneLayout, Shapes, shapes_example};
    use crate::format::share::{CLOSED_FORMS, PlaneStorage, ShareHeader, ShareShapes};
    use crate::format::{Encoding, ExrDepth, decode_field, decode_raster, encode_field};
    use crate::names::Named;
    use crate::numeric::random::{Purpose, Stream};
    use crate::raster::Samples;
    use crate::space::Space;
    use std::io::Read;

    fn texture(basis: &Basis, layout: PlaneLayout) -> FieldFile {
        let (size, mut stream) = (Size::new(13, 7), Stream::new(3, Purpose::Sample, [0]));
        let count = layout.planes(basis.len());
        let data = (0..count * size.texels()).map(|_| stream.unit() as f32 - 0.3).collect();
        let planes = Planes::from_vec(size, count, data).unwrap();
        let field = ReflectanceField::new(basis.clone(), layout, Space::Linear, planes).unwrap();
        let encoding = Encoding::Exr(ExrDepth::Float);
        FieldFile { field, opacity: None, encoding, record: Default::default(), models: None }
    }

    fn options(depth: PlaneDepth) -> ShareOptions {
        ShareOptions { title: "a <texture>".to_owned(), depth, mm_per_texel: Some(0.1), environment: None }
    }

    /// The planes of shared files, as a reader finds them.
    fn planes(shared: &ShareFiles) -> Vec<Vec<f32>> {
        let bytes = |name: &str| &shared.files.iter().find(|(file, _)| file == name).unwrap().1;
        let mut planes = Vec::new();
        for group in &shared.header.planes {
            assert_eq!(group.first, planes.len());
            match group.storage {
                PlaneStorage::Half => {
                    let mut raw = Vec::new();
                    flate2::read::GzDecoder::new(&bytes(&group.file)[..]).read_to_end(&mut raw).unwrap();
                    let half = |b: &[u8]| half::f16::from_le_bytes([b[0], b[1]]).to_f32();
                    let values: Vec<f32> = raw.chunks_exact(2).map(half).collect();
                    planes.extend(values.chunks_exact(values.len() / group.count).map(<[f32]>::to_vec));
                }
                PlaneStorage::Png => {
                    let raster = decode_raster(bytes(&group.file), &Job::default()).unwrap();
                    let Samples::U8(codes) = raster.samples() else { panic!("8 bits") };
                    let plane = |k: usize| {
                        let codes = codes.iter().skip(k).step_by(group.count);
                        codes.map(|&c| group.scale[k] * f32::from(c) + group.offset[k]).collect()
                    };
                    planes.extend((0..group.count).map(plane));
                }
            }
        }
        planes
    }

    #[test]
    fn planes_come_back_within_the_error_of_the_header() {
        for basis in Basis::examples() {
            for layout in PlaneLayout::examples(&basis).into_iter().filter(|layout| !layout.is_named()) {
                // Large tables take their time once.
                let depths = if basis.depends_on_view() { &PlaneDepth::ALL[2..] } else { PlaneDepth::ALL };
                for &depth in depths {
                    let file = texture(&basis, layout.clone());
                    let shared = share(&file, &options(depth), &Job::default()).unwrap();
                    let header: ShareHeader = serde_json::from_slice(&shared.header_bytes()).unwrap();
                    assert_eq!(header.planes, shared.header.planes);
                    let has_values = header.basis.table.is_some() || header.basis.measured.is_some();
                    assert_ne!(has_values, CLOSED_FORMS.contains(&basis.name()));
                    let bound = if depth == PlaneDepth::Eight { 0.6 / 255.0 } else { 1.0 / 2048.0 };
                    assert!(header.error <= bound, "{depth:?}: {}", header.error);
                    let found = planes(&shared);
                    assert_eq!(found.len(), file.field.coefficients().count());
                    for (a, b) in found.iter().flatten().zip(file.field.coefficients().as_slice()) {
                        assert!((a - b).abs() <= header.error + 1e-6, "{a} and {b}");
                    }
                }
            }
        }
    }

    /// What readers of the shared numbers find is what [`crate::field::Shapes`] adds to a texel.
    #[test]
    fn shared_shapes_have_the_corrections_of_the_field() {
        let job = Job::default();
        for layout in [PlaneLayout::LUMINANCE, PlaneLayout::RGB] {
            let field = shapes_example(layout);
            let shapes = Shapes::of(&field, &job).unwrap().unwrap();
            let light = Direction::from_angles(0.6, 2.9);
            let mut truth = Planes::zeros(field.size(), field.layout().channels());
            shapes.correct(light, &mut truth);
            let encoding = Encoding::Exr(ExrDepth::Float);
            let file = FieldFile { field, opacity: None, encoding, record: Default::default(), models: None };
            let shared = share(&file, &options(PlaneDepth::Half), &job).unwrap();
            let header = shared.header.shapes.as_ref().unwrap();
            let bytes = &shared.files.iter().find(|(name, _)| *name == header.file).unwrap().1;
            let mut raw = Vec::new();
            flate2::read::GzDecoder::new(&bytes[..]).read_to_end(&mut raw).unwrap();
            let weights = file.field.basis().weights(light);
            let found = corrections(header, &raw, &weights, light, file.field.size().texels());
            for (a, b) in found.iter().zip(truth.as_slice()) {
                assert!((a - b).abs() < 1e-3, "{a} and {b}");
            }
            assert!(found.iter().any(|v| v.abs() > 0.02));
        }
    }

    /// The formula of docs/formats.md.
    fn corrections(
        header: &ShareShapes,
        raw: &[u8],
        weights: &[f64],
        light: Direction,
        texels: usize,
    ) -> Vec<f32> {
        let (codes, halves) = raw.split_at(2 * weights.len() * texels);
        let channels = halves.len() / (16 * texels);
        let inside = |s: f64| 0.5 + 0.5 * s / s.hypot(f64::from(header.softness));
        let value = |channel: usize, texel: usize| {
            let of_kind = |kind: usize| {
                let distance = |i: usize| {
                    let code = codes[(kind * weights.len() + i) * texels + texel];
                    (f64::from(code) - 128.0) / f64::from(header.steps[kind])
                };
                let mixed: f64 = weights.iter().enumerate().map(|(i, w)| w * distance(i)).sum();
                let linear: f64 = weights.iter().enumerate().map(|(i, w)| w * inside(distance(i))).sum();
                let term = |k: usize| {
                    let at = 2 * ((8 * channel + 4 * kind + k) * texels + texel);
                    f64::from(half::f16::from_le_bytes([halves[at], halves[at + 1]]))
                };
                let contrast = term(0) + term(1) * light.x() + term(2) * light.y() + term(3) * light.z();
                let contrast = contrast.clamp(0.0, f64::from(header.most[kind]));
                f64::from(header.strengths[kind]) * (inside(mixed) - linear) * contrast
            };
            (of_kind(0) + of_kind(1)) as f32
        };
        (0..channels * texels).map(|i| value(i / texels, i % texels)).collect()
    }

    #[test]
    fn the_bytes_of_a_ptm_are_shared_as_they_are() {
        for layout in [PlaneLayout::RGB, PlaneLayout::LRGB] {
            let field = texture(&Basis::Ptm, layout).field;
            let field = ReflectanceField::new(
                Basis::Ptm,
                field.layout().clone(),
                Space::Srgb,
                field.coefficients().clone(),
            );
            let bytes = encode_field(&field.unwrap(), crate::format::FieldFormat::Ptm, None, &Job::default())
                .unwrap();
            let file = decode_field(&bytes, &Job::default()).unwrap();
            let shared = share(&file, &options(PlaneDepth::Kept), &Job::default()).unwrap();
            assert!(shared.header.error < 1e-6, "{}", shared.header.error);
            assert!(shared.header.planes.iter().all(|group| group.storage == PlaneStorage::Png));
        }
    }

    #[test]
    fn thumbnails_of_odd_sizes_are_small_pictures() {
        for (width, height) in [(1, 1), (1500, 3), (513, 700)] {
            let planes = Planes::from_vec(Size::new(width, height), 1, vec![0.5; width * height]).unwrap();
            let field = ReflectanceField::from_picture(Picture { planes, space: Space::Srgb });
            let raster =
                decode_raster(&thumbnail(&field, &Job::default()).unwrap(), &Job::default()).unwrap();
            assert!(raster.size().width.max(raster.size().height) <= THUMBNAIL_SIDE);
            let Samples::U8(codes) = raster.samples() else { panic!("8 bits") };
            assert!(codes.iter().all(|&code| code.abs_diff(128) <= 1));
        }
    }
}
