//! A field made ready for lookups at any place and scale.
//!
//! Functions are interpolated, not colours: bilinearly between texels where the texture is
//! magnified, trilinearly in a pyramid of box averages where it is reduced (Williams, "Pyramidal
//! Parametrics", SIGGRAPH 1983). Both are linear in the coefficients, so LRGB texels become RGB
//! functions first; averaging luminance and colour apart would not be linear. Coefficients of an
//! encoded field are averaged as they are, which is right only where neighbours differ little.

use rayon::prelude::*;

use crate::error::{Error, Result};
use crate::field::{Basis, ColorModel, ReflectanceField};
use crate::job::Job;
use crate::planes::{Planes, Size};
use crate::space::Space;

/// A field's functions and the texture's normals, a texel's numbers side by side, in a pyramid.
#[derive(Debug)]
pub struct Material {
    basis: Basis,
    space: Space,
    /// Functions a texel: 1 or 3.
    channels: usize,
    has_normals: bool,
    levels: Vec<Level>,
}

#[derive(Debug)]
struct Level {
    size: Size,
    /// Texel after texel: coefficients of the channels, then the normal.
    data: Vec<f32>,
}

/// The interpolated numbers of one place.
#[derive(Debug, Clone, Default)]
pub struct Texel {
    values: Vec<f32>,
}

impl Texel {
    /// The numbers, in the order of the planes they come from.
    pub fn values(&self) -> &[f32] {
        &self.values
    }
}

impl Material {
    /// From a field and, for highlights, the normals of its texels.
    ///
    /// # Errors
    /// When the normals do not fit the field, or memory is short.
    pub fn new(field: &ReflectanceField, normals: Option<&Planes>, job: &Job) -> Result<Self> {
        if let Some(normals) = normals
            && (normals.size() != field.size() || normals.count() != 3)
        {
            return Err(Error::invalid(format!(
                "a texture of {} needs three planes of normals of its size, found {} of {}",
                field.size(),
                normals.count(),
                normals.size()
            )));
        }
        let channels = field.color().channels();
        let stride = channels * field.basis().len() + if normals.is_some() { 3 } else { 0 };
        // The pyramid above a level is a third of it.
        job.check("the texture's pyramid", field.size(), (4 * stride as u64 * 4).div_ceil(3))?;
        let data = interleaved(field, normals, stride);
        let levels = pyramid(Level { size: field.size(), data }, stride);
        let has_normals = normals.is_some();
        Ok(Self { basis: field.basis(), space: field.space(), channels, has_normals, levels })
    }

    /// From planes of any numbers, to be looked up by [`Texel::values`].
    ///
    /// # Errors
    /// When memory is short.
    pub fn of_planes(planes: &Planes, job: &Job) -> Result<Self> {
        let stride = planes.count();
        job.check("the pyramid of planes", planes.size(), (4 * stride as u64 * 4).div_ceil(3))?;
        let texels = 0..planes.size().texels();
        let data = texels.flat_map(|texel| planes.iter().map(move |plane| plane[texel])).collect();
        let levels = pyramid(Level { size: planes.size(), data }, stride);
        Ok(Self {
            basis: Basis::Constant,
            space: Space::Linear,
            channels: stride,
            has_normals: false,
            levels,
        })
    }

    /// The basis of the functions.
    pub fn basis(&self) -> Basis {
        self.basis
    }

    /// Texels along both sides.
    pub fn size(&self) -> Size {
        self.levels[0].size
    }

    /// Looks up texture coordinates (0, 0 at the bottom left; repeated outside 0..1), for a
    /// sample whose neighbours are `footprint` texels away.
    pub fn fetch(&self, [s, t]: [f64; 2], footprint: f64, texel: &mut Texel) {
        let last = (self.levels.len() - 1) as f64;
        // Written so that a footprint that is not a number takes the coarsest level.
        let level = if footprint <= 1.0 { 0.0 } else { footprint.log2().min(last) };
        let fine = level as usize;
        let blend = level - fine as f64;
        texel.values.clear();
        texel.values.resize(self.stride(), 0.0);
        self.levels[fine].accumulate(s, t, 1.0 - blend, &mut texel.values);
        if blend > 0.0 {
            self.levels[fine + 1].accumulate(s, t, blend, &mut texel.values);
        }
    }

    /// The linear colour of a looked-up texel under a light with those basis weights.
    pub fn color(&self, texel: &Texel, weights: &[f64]) -> [f64; 3] {
        let n = weights.len();
        let function = |c: usize| {
            let terms = weights.iter().zip(&texel.values[c * n..(c + 1) * n]);
            let value: f64 = terms.map(|(w, &v)| w * f64::from(v)).sum();
            f64::from(self.space.to_linear(value as f32)).max(0.0)
        };
        match self.channels {
            1 => [function(0); 3],
            _ => [function(0), function(1), function(2)],
        }
    }

    /// The unit normal of a looked-up texel, where normals were given.
    pub fn normal(&self, texel: &Texel) -> Option<[f32; 3]> {
        if !self.has_normals {
            return None;
        }
        texel.values[self.stride() - 3..].try_into().ok()
    }

    fn stride(&self) -> usize {
        self.channels * self.basis.len() + if self.has_normals { 3 } else { 0 }
    }
}

/// A level and all smaller ones.
fn pyramid(base: Level, stride: usize) -> Vec<Level> {
    let mut levels = vec![base];
    while let Some(next) = levels.last().and_then(|level| level.reduced(stride)) {
        levels.push(next);
    }
    levels
}

/// All numbers of each texel side by side; LRGB texels as three functions.
fn interleaved(field: &ReflectanceField, normals: Option<&Planes>, stride: usize) -> Vec<f32> {
    let (n, planes) = (field.basis().len(), field.coefficients());
    let functions = field.color().channels() * n;
    let mut data = vec![0.0; field.size().texels() * stride];
    data.par_chunks_exact_mut(stride).enumerate().for_each(|(texel, out)| {
        let (functions, normal) = out.split_at_mut(functions);
        for (k, value) in functions.iter_mut().enumerate() {
            *value = match field.color() {
                ColorModel::Lrgb => planes.plane(k % n)[texel] * planes.plane(n + k / n)[texel],
                ColorModel::Luminance | ColorModel::Rgb => planes.plane(k)[texel],
            };
        }
        if let Some(normals) = normals {
            normal.iter_mut().enumerate().for_each(|(k, value)| *value = normals.plane(k)[texel]);
        }
    });
    data
}

impl Level {
    /// Adds `weight` times the bilinear interpolation at (s, t).
    fn accumulate(&self, s: f64, t: f64, weight: f64, values: &mut [f32]) {
        let Size { width, height } = self.size;
        let (x, fx) = neighbours(s, width);
        let (y, fy) = neighbours(1.0 - t, height);
        for (line, wy) in [(y[0], 1.0 - fy), (y[1], fy)] {
            for (column, wx) in [(x[0], 1.0 - fx), (x[1], fx)] {
                let weight = (weight * wx * wy) as f32;
                let texel = &self.data[self.size.index(column, line) * values.len()..][..values.len()];
                values.iter_mut().zip(texel).for_each(|(sum, v)| *sum += weight * v);
            }
        }
    }

    /// The level of half the size: each texel the mean of what it covers. `None` for one texel.
    fn reduced(&self, stride: usize) -> Option<Self> {
        let Size { width, height } = self.size;
        if self.size.texels() == 1 {
            return None;
        }
        let size = Size::new((width / 2).max(1), (height / 2).max(1));
        let (columns, lines) = (coverage(width, size.width), coverage(height, size.height));
        let mut data = vec![0.0f32; size.texels() * stride];
        data.par_chunks_exact_mut(size.width * stride).zip(&lines).for_each(|(row, lines)| {
            for (out, columns) in row.chunks_exact_mut(stride).zip(&columns) {
                for &(line, wy) in lines {
                    for &(column, wx) in columns {
                        let texel = &self.data[self.size.index(column, line) * stride..][..stride];
                        out.iter_mut().zip(texel).for_each(|(sum, v)| *sum += wx * wy * v);
                    }
                }
            }
        });
        Some(Self { size, data })
    }
}

/// The two texels around a coordinate of the repeated texture, and the way from the first to the
/// second. Casts to integers stand for `floor`, which is a slow call on older instruction sets.
fn neighbours(coordinate: f64, count: usize) -> ([usize; 2], f64) {
    let whole = coordinate as i64 as f64;
    let part = coordinate - if whole > coordinate { whole - 1.0 } else { whole };
    // Half a texel to the left, plus one to stay positive.
    let place = part * count as f64 + 0.5;
    let right = (place as usize).min(count);
    let left = if right == 0 { count - 1 } else { right - 1 };
    ([left, if right == count { 0 } else { right }], place - right as f64)
}

/// For each of `to` equal parts of `from` texels, the texels it covers and their shares.
fn coverage(from: usize, to: usize) -> Vec<Vec<(usize, f32)>> {
    (0..to)
        .map(|i| {
            // In units of 1 / to texels, so that all bounds are integers.
            let (start, end) = (i * from, (i + 1) * from);
            let share = |k: usize| (end.min((k + 1) * to) - start.max(k * to)) as f32 / from as f32;
            (start / to..end.div_ceil(to)).map(|k| (k, share(k))).collect()
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::picture::Picture;

    fn material(size: Size, value: impl Fn(usize, usize) -> f32) -> Material {
        let data = (0..size.texels()).map(|i| value(i % size.width, i / size.width)).collect();
        let planes = Planes::from_vec(size, 1, data).unwrap();
        let field = ReflectanceField::from_picture(Picture { planes, space: Space::Linear });
        Material::new(&field, None, &Job::default()).unwrap()
    }

    fn fetched(material: &Material, place: [f64; 2], footprint: f64) -> f64 {
        let mut texel = Texel::default();
        material.fetch(place, footprint, &mut texel);
        material.color(&texel, &[1.0])[0]
    }

    #[test]
    fn neighbours_are_those_of_the_floor() {
        for count in [1, 2, 7] {
            for i in -300..300 {
                let coordinate = f64::from(i) * 0.037;
                let place = coordinate.rem_euclid(1.0) * count as f64 - 0.5;
                let wrap = |v: f64| v.rem_euclid(count as f64) as usize;
                let (found, way) = neighbours(coordinate, count);
                assert_eq!(
                    found,
                    [wrap(place.floor()), wrap(place.floor() + 1.0)],
                    "{coordinate} of {count}"
                );
                assert!((way - (place - place.floor())).abs() < 1e-9);
            }
        }
        for coordinate in [f64::NAN, f64::INFINITY, -1e300, 1e300, -1e-300] {
            let (found, _) = neighbours(coordinate, 5);
            assert!(found.iter().all(|&i| i < 5), "{coordinate}");
        }
    }

    #[test]
    fn texels_are_kept_at_their_centres_and_blended_between() {
        let size = Size::new(5, 3);
        let value = |x: usize, y: usize| (x + 10 * y) as f32;
        let material = material(size, value);
        let place = |x: f64, y: f64| [(x + 0.5) / 5.0, 1.0 - (y + 0.5) / 3.0];
        for (x, y) in [(0, 0), (4, 2), (2, 1)] {
            assert!(
                (fetched(&material, place(x as f64, y as f64), 1.0) - f64::from(value(x, y))).abs() < 1e-5
            );
        }
        assert!((fetched(&material, place(1.25, 0.5), 1.0) - 6.25).abs() < 1e-5);
        // Across the edge the texture repeats: halfway between 4 and 0.
        assert!((fetched(&material, place(4.5, 0.0), 1.0) - 2.0).abs() < 1e-5);
        assert!((fetched(&material, [1.3, -0.2], 1.0) - fetched(&material, [0.3, 0.8], 1.0)).abs() < 1e-5);
    }

    #[test]
    fn every_level_has_the_mean_of_the_texture() {
        let size = Size::new(13, 6);
        let material = material(size, |x, y| ((x * 7 + y * 5) % 11) as f32);
        let mean = |level: &Level| level.data.iter().sum::<f32>() / level.data.len() as f32;
        let truth = mean(&material.levels[0]);
        assert_eq!(material.levels.last().unwrap().size, Size::new(1, 1));
        for level in &material.levels {
            assert!((mean(level) - truth).abs() < 1e-5, "{}", level.size);
        }
        for footprint in [1e9, f64::INFINITY, f64::NAN] {
            assert!((fetched(&material, [0.3, 0.7], footprint) - f64::from(truth)).abs() < 1e-5);
        }
        let between = fetched(&material, [0.3, 0.7], 2f64.powf(0.25));
        let (fine, coarse) = (fetched(&material, [0.3, 0.7], 1.0), fetched(&material, [0.3, 0.7], 2.0));
        assert!((between - (0.75 * fine + 0.25 * coarse)).abs() < 1e-5);
    }
}
