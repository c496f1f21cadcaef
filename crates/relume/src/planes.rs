//! Stacks of planes of `f32`: the memory layout shared by all stages.
//!
//! A stack of `count` planes of `width` x `height` texels is stored plane after plane, each plane row by row.
//! **Row 0 is the top row**, as in a picture; directions have y up, so one row down is a step of -y. Files
//! that store rows bottom-up are flipped when they are read and written.

use crate::error::{Error, Result};
use crate::job::{Held, Job};
use crate::memory;
use crate::size::Size;

/// A stack of planes of the same size.
///
/// Planes made for a job ([`Planes::zeros_within`], [`Planes::held`]) count against its memory budget
/// for as long as they live, and so do their clones.
#[derive(Debug, Clone, PartialEq)]
pub struct Planes {
    size: Size,
    count: usize,
    data: Vec<f32>,
    held: Held,
}

impl Planes {
    /// `count` planes of zeros.
    pub fn zeros(size: Size, count: usize) -> Self {
        Self::of(size, count, vec![0.0; size.texels() * count])
    }

    fn of(size: Size, count: usize, data: Vec<f32>) -> Self {
        Self { size, count, data, held: Held::default() }
    }

    /// `count` planes of zeros that count against the job's budget; `what` names them in the message.
    ///
    /// # Errors
    /// [`ErrorKind::Limit`](crate::ErrorKind::Limit) when they do not fit beside what is held, or the
    /// system does not give the memory.
    pub fn zeros_within(job: &Job, what: &str, size: Size, count: usize) -> Result<Self> {
        job.check(what, size, 4 * count as u64)?;
        let held = job.hold(what, 4 * (size.texels() * count) as u64)?;
        let data = memory::zeros(what, size.texels() * count)?;
        Ok(Self { held, ..Self::of(size, count, data) })
    }

    /// Whether all values are the same.
    pub fn is_constant(&self) -> bool {
        self.data.windows(2).all(|pair| pair[0] == pair[1])
    }

    /// The same planes, counted against the job's budget; `what` names them in the message.
    ///
    /// # Errors
    /// [`ErrorKind::Limit`](crate::ErrorKind::Limit) when they do not fit beside what is held.
    pub fn held(mut self, job: &Job, what: &str) -> Result<Self> {
        self.held = Held::default();
        self.held = job.hold(what, 4 * self.data.len() as u64)?;
        Ok(self)
    }

    /// Planes from their samples, plane after plane, each row by row from the top.
    pub fn from_vec(size: Size, count: usize, data: Vec<f32>) -> Result<Self> {
        if size.texels() == 0 || data.len() != size.texels() * count {
            return Err(Error::invalid(format!(
                "{count} planes of {size} texels need {} samples, found {}",
                size.texels() * count,
                data.len()
            )));
        }
        Ok(Self::of(size, count, data))
    }

    /// All planes of one stack, and then those of another of its size.
    ///
    /// # Errors
    /// Stacks of differing sizes.
    pub(crate) fn followed_by(&self, other: &Self) -> Result<Self> {
        let data = [self.as_slice(), other.as_slice()].concat();
        Self::from_vec(self.size(), self.count() + other.count(), data)
    }

    /// Width and height.
    pub fn size(&self) -> Size {
        self.size
    }

    /// The number of planes.
    pub fn count(&self) -> usize {
        self.count
    }

    /// All samples, plane after plane.
    pub fn as_slice(&self) -> &[f32] {
        &self.data
    }

    /// All samples, plane after plane.
    pub fn as_mut_slice(&mut self) -> &mut [f32] {
        &mut self.data
    }

    /// One plane.
    ///
    /// # Panics
    /// When `k` is not below [`Planes::count`].
    pub fn plane(&self, k: usize) -> &[f32] {
        let n = self.size.texels();
        &self.data[k * n..(k + 1) * n]
    }

    /// One plane.
    ///
    /// # Panics
    /// When `k` is not below [`Planes::count`].
    pub fn plane_mut(&mut self, k: usize) -> &mut [f32] {
        let n = self.size.texels();
        &mut self.data[k * n..(k + 1) * n]
    }

    /// Rounds the values of plane `k` to multiples of a step.
    ///
    /// # Panics
    /// When `k` is not below [`Planes::count`].
    pub fn round(&mut self, k: usize, step: f32) {
        self.plane_mut(k).iter_mut().for_each(|value| *value = (*value / step).round() * step);
    }

    /// Each row of all planes, from the top: the row of the first plane, of the second, and so on.
    pub(crate) fn rows_mut(&mut self) -> Vec<Vec<&mut [f32]>> {
        let (count, height) = (self.count, self.size.height);
        let mut rows: Vec<Vec<&mut [f32]>> = (0..height).map(|_| Vec::with_capacity(count)).collect();
        for plane in self.iter_mut() {
            let width = plane.len() / height.max(1);
            rows.iter_mut().zip(plane.chunks_exact_mut(width.max(1))).for_each(|(rows, row)| rows.push(row));
        }
        rows
    }

    /// All planes in order.
    pub fn iter(&self) -> std::slice::ChunksExact<'_, f32> {
        self.data.chunks_exact(self.size.texels().max(1))
    }

    /// All planes in order.
    pub fn iter_mut(&mut self) -> std::slice::ChunksExactMut<'_, f32> {
        self.data.chunks_exact_mut(self.size.texels().max(1))
    }

    /// The sample of plane `k` at texel (x, y).
    pub fn at(&self, k: usize, x: usize, y: usize) -> f32 {
        self.plane(k)[self.size.index(x, y)]
    }

    /// The first `count` planes; the memory of the others is released.
    #[must_use]
    pub fn truncated(mut self, count: usize) -> Self {
        self.count = self.count.min(count);
        self.data.truncate(self.size.texels() * self.count);
        self.data.shrink_to_fit();
        self.held.shrink(4 * self.data.len() as u64);
        self
    }

    /// All planes cut into bands of `texels` consecutive texels (the last may be shorter): for each band its
    /// part of every plane, so that bands can be processed in parallel.
    pub fn bands_mut(&mut self, texels: usize) -> Vec<Vec<&mut [f32]>> {
        let bands = self.size.texels().div_ceil(texels);
        let mut pieces: Vec<_> = (0..bands).map(|_| Vec::with_capacity(self.count)).collect();
        for plane in self.iter_mut() {
            for (band, piece) in pieces.iter_mut().zip(plane.chunks_mut(texels)) {
                band.push(piece);
            }
        }
        pieces
    }

    /// Smallest and largest sample of plane `k`.
    pub fn range(&self, k: usize) -> (f32, f32) {
        self.plane(k).iter().fold((f32::INFINITY, f32::NEG_INFINITY), |(lo, hi), &v| (lo.min(v), hi.max(v)))
    }

    /// The means of squares of `by` texels a side, whole ones only; a side that is shorter counts as one square.
    pub fn reduced(&self, by: usize) -> Self {
        let whole = self.size();
        let size = Size::new((whole.width / by).max(1), (whole.height / by).max(1));
        let (across, down) = (by.min(whole.width), by.min(whole.height));
        let mut out = Self::zeros(size, self.count());
        for (plane, values) in out.iter_mut().zip(self.iter()) {
            for (texel, mean) in plane.iter_mut().enumerate() {
                let (x, y) = (texel % size.width * by, texel / size.width * by);
                let rows = (y..y + down).flat_map(|y| &values[whole.index(x, y)..][..across]);
                *mean = (rows.map(|v| f64::from(*v)).sum::<f64>() / (across * down) as f64) as f32;
            }
        }
        out
    }

    /// The rectangle of `size` texels whose top-left texel is (x, y).
    pub fn crop(&self, x: usize, y: usize, size: Size) -> Result<Self> {
        self.size.check_crop(x, y, size)?;
        let rows = self.iter().flat_map(|plane| {
            (y..y + size.height).map(move |row| &plane[self.size.index(x, row)..][..size.width])
        });
        let mut data = Vec::with_capacity(size.texels() * self.count);
        rows.for_each(|row| data.extend_from_slice(row));
        Ok(Self::of(size, self.count, data))
    }

    /// The planes repeated `across` times to the right and `down` times downwards.
    pub fn repeated(&self, across: usize, down: usize) -> Self {
        let size = Size::new(self.size.width * across, self.size.height * down);
        let mut data = Vec::with_capacity(size.texels() * self.count);
        for plane in self.iter() {
            for _ in 0..down {
                for row in plane.chunks_exact(self.size.width) {
                    (0..across).for_each(|_| data.extend_from_slice(row));
                }
            }
        }
        Self::of(size, self.count, data)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::error::ErrorKind;

    fn numbered(size: Size, count: usize) -> Planes {
        Planes::from_vec(size, count, (0..size.texels() * count).map(|i| i as f32).collect()).unwrap()
    }

    #[test]
    fn crop_takes_the_named_rectangle() {
        let planes = numbered(Size::new(5, 4), 2);
        let crop = planes.crop(1, 2, Size::new(3, 2)).unwrap();
        for (k, y, x) in (0..2).flat_map(|k| (0..2).flat_map(move |y| (0..3).map(move |x| (k, y, x)))) {
            assert_eq!(crop.at(k, x, y), planes.at(k, x + 1, y + 2));
        }
        assert!(planes.crop(3, 0, Size::new(3, 1)).is_err());
        assert!(planes.crop(usize::MAX, 0, Size::new(1, 1)).is_err());
    }

    #[test]
    fn bands_cover_every_plane_and_truncation_keeps_the_first() {
        let mut planes = numbered(Size::new(5, 3), 3);
        let original = planes.clone();
        let bands = planes.bands_mut(4);
        assert_eq!(bands.iter().map(|b| b[0].len()).collect::<Vec<_>>(), [4, 4, 4, 3]);
        for (b, band) in bands.iter().enumerate() {
            for (k, piece) in band.iter().enumerate() {
                assert_eq!(**piece, original.plane(k)[4 * b..][..piece.len()]);
            }
        }
        let kept = planes.truncated(2);
        assert_eq!((kept.count(), kept.as_slice()), (2, &original.as_slice()[..30]));
    }

    #[test]
    fn planes_of_a_job_count_for_as_long_as_they_live() {
        let job = Job::new(crate::Limits { max_bytes: 100, ..crate::Limits::default() });
        let planes = Planes::zeros_within(&job, "planes", Size::new(3, 2), 3).unwrap();
        assert_eq!(job.free_bytes(), 28);
        let copy = planes.clone();
        assert_eq!((job.free_bytes(), copy == planes), (0, true));
        drop(planes);
        assert_eq!(job.free_bytes(), 28);
        assert_eq!(
            Planes::zeros_within(&job, "more", Size::new(3, 2), 2).unwrap_err().kind(),
            ErrorKind::Limit
        );
        let fewer = copy.truncated(1);
        assert_eq!(job.free_bytes(), 76);
        drop(fewer);
        assert_eq!(job.free_bytes(), 100);
    }

    #[test]
    fn repetition_is_periodic() {
        let planes = numbered(Size::new(3, 2), 2);
        let tiled = planes.repeated(2, 3);
        assert_eq!(tiled.size(), Size::new(6, 6));
        for y in 0..6 {
            for x in 0..6 {
                assert_eq!(tiled.at(1, x, y), planes.at(1, x % 3, y % 2));
            }
        }
    }
}
