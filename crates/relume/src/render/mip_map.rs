//! Mip maps: planes at decreasing resolution, for look-ups at any position and scale.
//!
//! Values are interpolated bilinearly between texels under magnification, trilinearly in a pyramid of box
//! averages under minification (Williams, "Pyramidal Parametrics", SIGGRAPH 1983). Texture coordinates are 0,
//! 0 at the bottom left; outside 0..1 the texture repeats.

use crate::error::Result;
use crate::job::Job;
use crate::numeric::parts::coverage;
use crate::parallel;
use crate::planes::Planes;
use crate::size::Size;

/// Values of texels, those of a texel adjacent, in a pyramid; the finest level first, one texel last.
#[derive(Debug)]
pub struct MipMap {
    /// Values per texel.
    stride: usize,
    levels: Vec<MipLevel>,
}

#[derive(Debug)]
struct MipLevel {
    size: Size,
    /// Texel after texel.
    data: Vec<f32>,
}

impl MipMap {
    /// From `stride` values for each texel, named `what` in errors; they are made after memory has been
    /// checked.
    ///
    /// # Errors
    /// When memory is short.
    pub fn new(
        what: &str,
        size: Size,
        stride: usize,
        job: &Job,
        data: impl FnOnce() -> Vec<f32>,
    ) -> Result<Self> {
        // The pyramid above a level is a third of it.
        job.check(what, size, (4 * stride as u64 * 4).div_ceil(3))?;
        let mut levels = vec![MipLevel { size, data: data() }];
        while let Some(next) = levels.last().and_then(|level| level.reduced(stride)) {
            levels.push(next);
        }
        Ok(Self { stride, levels })
    }

    /// From planes of any values.
    ///
    /// # Errors
    /// When memory is short.
    pub fn of_planes(what: &str, planes: &Planes, job: &Job) -> Result<Self> {
        let texels = 0..planes.size().texels();
        let data = || texels.flat_map(|texel| planes.iter().map(move |plane| plane[texel])).collect();
        Self::new(what, planes.size(), planes.count(), job, data)
    }

    /// Texels along both sides of the finest level.
    pub fn size(&self) -> Size {
        self.levels[0].size
    }

    /// Looks up the values at texture coordinates, for a sample whose neighbours are `footprint` texels away.
    pub fn fetch(&self, [s, t]: [f64; 2], footprint: f64, values: &mut Vec<f32>) {
        let last = (self.levels.len() - 1) as f64;
        // Written so that a NaN footprint selects the coarsest level.
        let level = if footprint <= 1.0 { 0.0 } else { footprint.log2().min(last) };
        let fine = level as usize;
        let blend = level - fine as f64;
        values.clear();
        values.resize(self.stride, 0.0);
        self.levels[fine].accumulate(s, t, 1.0 - blend, values);
        if blend > 0.0 {
            self.levels[fine + 1].accumulate(s, t, blend, values);
        }
    }
}

impl MipLevel {
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

    /// The level of half the size: each texel is the mean of the texels it covers. `None` for one texel.
    fn reduced(&self, stride: usize) -> Option<Self> {
        let Size { width, height } = self.size;
        if self.size.texels() == 1 {
            return None;
        }
        let size = Size::new((width / 2).max(1), (height / 2).max(1));
        let (columns, lines) = (coverage(width, size.width), coverage(height, size.height));
        let mut data = vec![0.0f32; size.texels() * stride];
        parallel::for_each(data.chunks_exact_mut(size.width * stride).zip(&lines), |(row, lines)| {
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

/// The two texels around a coordinate of the repeated texture, and the fraction from the first to the second.
/// Casts to integers replace `floor`, which is a slow call on older instruction sets.
fn neighbours(coordinate: f64, count: usize) -> ([usize; 2], f64) {
    let whole = coordinate as i64 as f64;
    let part = coordinate - if whole > coordinate { whole - 1.0 } else { whole };
    // Half a texel to the left, plus one to stay positive.
    let place = part * count as f64 + 0.5;
    let right = (place as usize).min(count);
    let left = if right == 0 { count - 1 } else { right - 1 };
    ([left, if right == count { 0 } else { right }], place - right as f64)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn mip_map(size: Size, value: impl Fn(usize, usize) -> f32) -> MipMap {
        let data = (0..size.texels()).map(|i| value(i % size.width, i / size.width)).collect();
        let planes = Planes::from_vec(size, 1, data).unwrap();
        MipMap::of_planes("the texture", &planes, &Job::default()).unwrap()
    }

    fn fetched(texture: &MipMap, place: [f64; 2], footprint: f64) -> f64 {
        let mut values = Vec::new();
        texture.fetch(place, footprint, &mut values);
        f64::from(values[0])
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
        let texture = mip_map(size, value);
        let place = |x: f64, y: f64| [(x + 0.5) / 5.0, 1.0 - (y + 0.5) / 3.0];
        for (x, y) in [(0, 0), (4, 2), (2, 1)] {
            assert!(
                (fetched(&texture, place(x as f64, y as f64), 1.0) - f64::from(value(x, y))).abs() < 1e-5
            );
        }
        assert!((fetched(&texture, place(1.25, 0.5), 1.0) - 6.25).abs() < 1e-5);
        // Across the edge the texture repeats: halfway between 4 and 0.
        assert!((fetched(&texture, place(4.5, 0.0), 1.0) - 2.0).abs() < 1e-5);
        assert!((fetched(&texture, [1.3, -0.2], 1.0) - fetched(&texture, [0.3, 0.8], 1.0)).abs() < 1e-5);
    }

    #[test]
    fn every_level_has_the_mean_of_the_texture() {
        let size = Size::new(13, 6);
        let texture = mip_map(size, |x, y| ((x * 7 + y * 5) % 11) as f32);
        let mean = |level: &MipLevel| level.data.iter().sum::<f32>() / level.data.len() as f32;
        let truth = mean(&texture.levels[0]);
        assert_eq!(texture.levels.last().unwrap().size, Size::new(1, 1));
        for level in &texture.levels {
            assert!((mean(level) - truth).abs() < 1e-5, "{}", level.size);
        }
        for footprint in [1e9, f64::INFINITY, f64::NAN] {
            assert!((fetched(&texture, [0.3, 0.7], footprint) - f64::from(truth)).abs() < 1e-5);
        }
        let between = fetched(&texture, [0.3, 0.7], 2f64.powf(0.25));
        let (fine, coarse) = (fetched(&texture, [0.3, 0.7], 1.0), fetched(&texture, [0.3, 0.7], 2.0));
        assert!((between - (0.75 * fine + 0.25 * coarse)).abs() < 1e-5);
    }
}
