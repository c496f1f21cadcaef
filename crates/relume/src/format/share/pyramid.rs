//! Large textures as tiles of several levels, of which readers load what they show.
//!
//! A level has half the size of the one before (rounded down), and its texels are the means of those that they cover. Functions are
//! averaged, so luminance times colour is multiplied out from the second level on. A tile has [`SIDE`] texels a side, less at the
//! right and lower edges of a level, and [`BORDER`] texels of its neighbours around it; around a level it repeats. A file holds a tile:
//! all its planes, coefficients and then maps, one below the other.

use super::header::{PlaneStorage, ShareLevel, SharePyramid};
use super::planes::{LinearCodes, PlaneDepth, encode_codes, halves, steps};
use super::{ShareExtras, map_planes};
use crate::error::Result;
use crate::field::{PlaneLayout, ReflectanceField};
use crate::format::FieldFile;
use crate::job::Job;
use crate::numeric::parts::coverage;
use crate::parallel;
use crate::planes::Planes;
use crate::size::Size;

/// Texels from which on a texture comes in tiles.
pub const TILED_TEXELS: usize = 1 << 21;
/// The side of a tile without its border.
pub const SIDE: usize = 256;
/// Wide enough for blurs of eight texels.
pub const BORDER: usize = 16;
/// The longest side of the last level.
const SMALLEST: usize = 32;

/// A level: coefficients and maps in one list of planes.
struct PyramidLevel {
    layout: PlaneLayout,
    planes: Planes,
    /// The codes of each plane; `None` for half floats.
    codes: Option<Vec<LinearCodes>>,
}

/// The tiles of all levels.
#[derive(Debug, Default)]
pub(super) struct TiledTexture {
    pub pyramid: SharePyramid,
    pub files: Vec<(String, Vec<u8>)>,
    /// The largest difference of a coefficient from that of the field.
    pub error: f32,
}

impl TiledTexture {
    pub fn new(file: &FieldFile, extras: &ShareExtras, depth: PlaneDepth, job: &Job) -> Result<Self> {
        let field = &file.field;
        let (maps, map_codes, roles) = map_planes(extras, field.size())?;
        let heights = extras.height.map(|height| height.range(0));
        let mut made = Self {
            pyramid: SharePyramid {
                side: SIDE,
                border: BORDER,
                maps: roles,
                height_range: heights.map(|(low, high)| [low, high]),
                levels: Vec::new(),
            },
            ..Self::default()
        };
        let count = field.coefficients().count();
        let first: Option<Vec<LinearCodes>> =
            (0..count).map(|k| steps(field, k, &file.encoding, depth)).collect();
        if let Some(codes) = &first {
            made.error = largest_error(field, codes);
        }
        let keeps_codes = first.is_some();
        let codes = first.map(|own| [own, map_codes.clone()].concat());
        let planes = field.coefficients().followed_by(&maps)?;
        let mut level = PyramidLevel { layout: field.layout().clone(), planes, codes };
        loop {
            made.add(&level, field.basis().len(), job)?;
            let Size { width, height } = level.planes.size();
            if width.max(height) <= SMALLEST {
                return Ok(made);
            }
            level = level.next(field, &map_codes, keeps_codes, job)?;
        }
    }

    fn add(&mut self, level: &PyramidLevel, functions: usize, job: &Job) -> Result<()> {
        let (size, index) = (level.planes.size(), self.pyramid.levels.len());
        let places: Vec<(usize, usize)> = (0..size.height.div_ceil(SIDE))
            .flat_map(|row| (0..size.width.div_ceil(SIDE)).map(move |column| (column, row)))
            .collect();
        let storage = if level.codes.is_some() { PlaneStorage::Png } else { PlaneStorage::Half };
        job.start("storing tiles", places.len() as u64);
        let files = parallel::try_map(places, |place| {
            job.advance(1)?;
            Ok((tile_name(index, place, storage), level.tile(place, job)?))
        })?;
        self.files.extend(files);
        let codes = || level.codes.iter().flatten();
        self.pyramid.levels.push(ShareLevel {
            size: [size.width, size.height],
            layout: level.layout.name().to_owned(),
            storage,
            planes: level.layout.planes(functions),
            scale: codes().map(|c| c.scale).collect(),
            offset: codes().map(|c| c.offset).collect(),
        });
        Ok(())
    }
}

impl PyramidLevel {
    /// The level of half the size.
    fn next(
        &self,
        field: &ReflectanceField,
        map_codes: &[LinearCodes],
        keeps_codes: bool,
        job: &Job,
    ) -> Result<Self> {
        let n = field.basis().len();
        let own = self.layout.planes(n);
        let layout = if self.layout == PlaneLayout::LRGB { PlaneLayout::RGB } else { self.layout.clone() };
        let count = layout.planes(n);
        let maps = self.planes.count() - own;
        let Size { width, height } = self.planes.size();
        let size = Size::new((width / 2).max(1), (height / 2).max(1));
        let mut planes = Planes::zeros_within(job, "a level of the texture", size, count + maps)?;
        let (columns, rows) = (coverage(width, size.width), coverage(height, size.height));
        let from = &self.planes;
        parallel::for_each(planes.iter_mut().enumerate(), |(k, out)| {
            let function =
                if k < count { self.layout.function_plane(k / n, n) + k % n } else { own + k - count };
            let color = if k < count { self.layout.color_plane(k / n, n) } else { None };
            let color = color.map(|color| from.plane(color));
            let values = from.plane(function);
            for (texel, mean) in out.iter_mut().enumerate() {
                let (x, y) = (texel % size.width, texel / size.width);
                for &(row, wy) in &rows[y] {
                    for &(column, wx) in &columns[x] {
                        let at = row * width + column;
                        *mean += wx * wy * values[at] * color.map_or(1.0, |color| color[at]);
                    }
                }
            }
        });
        let codes = keeps_codes.then(|| {
            let range = |k: usize| LinearCodes::between(planes.range(k));
            (0..count).map(range).chain(map_codes.iter().copied()).collect()
        });
        Ok(Self { layout, planes, codes })
    }

    /// The file of the tile in a column and row.
    fn tile(&self, (column, row): (usize, usize), job: &Job) -> Result<Vec<u8>> {
        let Size { width, height } = self.planes.size();
        let along = |place: usize, whole: usize| {
            let (from, to) = (place * SIDE, ((place + 1) * SIDE).min(whole));
            let around = whole * BORDER.div_ceil(whole) - BORDER;
            (0..to - from + 2 * BORDER).map(move |i| (from + i + around) % whole).collect::<Vec<_>>()
        };
        let (columns, rows) = (along(column, width), along(row, height));
        let size = Size::new(columns.len(), rows.len() * self.planes.count());
        let mut values = Vec::with_capacity(size.texels());
        for (k, plane) in self.planes.iter().enumerate() {
            let codes = self.codes.as_ref().map(|codes| codes[k]);
            let stored = |value: f32| codes.map_or(value, |codes| codes.code(value) / 255.0);
            for &y in &rows {
                values.extend(columns.iter().map(|&x| stored(plane[y * width + x])));
            }
        }
        match &self.codes {
            Some(_) => encode_codes(&Planes::from_vec(size, 1, values)?, job),
            None => Ok(halves(&values)),
        }
    }
}

/// The file of a tile of a level.
fn tile_name(level: usize, (column, row): (usize, usize), storage: PlaneStorage) -> String {
    let extension = if storage == PlaneStorage::Png { "png" } else { "f16.gz" };
    format!("tile-{level}-{column}-{row}.{extension}")
}

fn largest_error(field: &ReflectanceField, codes: &[LinearCodes]) -> f32 {
    let planes = field.coefficients().iter().zip(codes);
    let errors = planes.flat_map(|(plane, code)| plane.iter().map(|&v| (code.value(code.code(v)) - v).abs()));
    errors.fold(0.0, f32::max)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::field::Basis;
    use crate::format::{Encoding, ExrDepth, decode_raster};
    use crate::raster::Samples;
    use crate::space::Space;

    fn texture(layout: PlaneLayout, size: Size) -> FieldFile {
        let count = layout.planes(6);
        let value = |i: usize| (i * 7 % 251) as f32 / 250.0;
        let planes = Planes::from_vec(size, count, (0..count * size.texels()).map(value).collect()).unwrap();
        let field = ReflectanceField::new(Basis::Ptm, layout, Space::Srgb, planes).unwrap();
        FieldFile {
            field,
            opacity: None,
            encoding: Encoding::Exr(ExrDepth::Float),
            record: Default::default(),
            models: None,
        }
    }

    /// The values of a tile of 8 bits: plane `k`, at a place counted from its upper left corner without the border.
    fn value(made: &TiledTexture, name: &str, k: usize, x: usize, y: usize) -> f32 {
        let bytes = &made.files.iter().find(|(file, _)| file == name).unwrap().1;
        let raster = decode_raster(bytes, &Job::default()).unwrap();
        let level = &made.pyramid.levels[name.split('-').nth(1).unwrap().parse::<usize>().unwrap()];
        let planes = level.scale.len();
        let Samples::U8(codes) = raster.samples() else { panic!("8 bits") };
        let (width, height) = (raster.size().width, raster.size().height / planes);
        let code = codes[(k * height + y + BORDER) * width + x + BORDER];
        level.scale[k] * f32::from(code) + level.offset[k]
    }

    #[test]
    fn tiles_hold_the_texture_with_a_border_that_repeats_it() {
        let (size, job) = (Size::new(300, 131), Job::default());
        for layout in [PlaneLayout::RGB, PlaneLayout::LUMINANCE] {
            let file = texture(layout, size);
            let made = TiledTexture::new(&file, &ShareExtras::default(), PlaneDepth::Eight, &job).unwrap();
            let sizes: Vec<[usize; 2]> = made.pyramid.levels.iter().map(|level| level.size).collect();
            assert_eq!(sizes, [[300, 131], [150, 65], [75, 32], [37, 16], [18, 8]]);
            let own = |k: usize, x: usize, y: usize| file.field.coefficients().at(k, x % 300, y % 131);
            for (k, x, y) in [(0, 0, 0), (3, 43, 130), (5, 12, 77)] {
                let found = value(&made, "tile-0-1-0.png", k, x, y);
                assert!((found - own(k, 256 + x, y)).abs() <= made.error + 1e-6);
                let beyond = value(&made, "tile-0-1-0.png", k, 43 + BORDER, y);
                assert!((beyond - own(k, 299 + BORDER, y)).abs() <= made.error + 1e-6);
            }
            assert!(made.error < 0.6 / 255.0);
        }
    }

    #[test]
    fn coarse_levels_are_means_of_the_products_of_luminance_and_colour() {
        let (size, job) = (Size::new(70, 66), Job::default());
        let file = texture(PlaneLayout::LRGB, size);
        let made = TiledTexture::new(&file, &ShareExtras::default(), PlaneDepth::Eight, &job).unwrap();
        assert_eq!(made.pyramid.levels[0].layout, "lrgb");
        assert_eq!((made.pyramid.levels[1].layout.as_str(), made.pyramid.levels[1].planes), ("rgb", 18));
        let planes = file.field.coefficients();
        for (x, y) in [(0, 0), (34, 32), (7, 20)] {
            for (channel, function) in [(0, 0), (1, 4), (2, 5)] {
                let product = |x: usize, y: usize| planes.at(function, x, y) * planes.at(6 + channel, x, y);
                let sum = [(0, 0), (1, 0), (0, 1), (1, 1)].map(|(i, k)| product(2 * x + i, 2 * y + k));
                let truth = sum.iter().sum::<f32>() / 4.0;
                let found = value(&made, "tile-1-0-0.png", 6 * channel + function, x, y);
                assert!((found - truth).abs() < 0.6 / 255.0, "{found} and {truth}");
            }
        }
    }
}
