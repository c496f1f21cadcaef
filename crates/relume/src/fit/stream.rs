//! Photographs one batch at a time: decoded in parallel, checked against the first, and dropped.

use std::sync::Mutex;

use super::sample::Grid;
use crate::clipping::{Clipper, Clipping};
use crate::error::{Error, Result};
use crate::job::Job;
use crate::parallel;
use crate::raster::{LoadRaster, Raster, Samples};
use crate::size::Size;

/// The most photographs in a batch. Every batch passes over all sums once, so small batches are slow; with
/// sixteen this costs a tenth of the decoding.
pub(super) const BATCH: usize = 16;

/// The bytes of a batch beyond which it has no more than two photographs.
const LARGE_BATCH: usize = 128 << 20;

/// Larger or non-finite floating-point samples cannot be photographs; squares up to this still fit.
const LARGEST_SAMPLE: f32 = 1e12;

/// The photographs of a fit.
pub(super) struct PhotographStream<'a> {
    names: Vec<&'a str>,
    load: &'a LoadRaster<'a>,
    size: Size,
    channels: usize,
    depth: usize,
    batch: usize,
    /// The first photograph, until it is used.
    first: Mutex<Option<Raster>>,
    job: &'a Job,
}

impl<'a> PhotographStream<'a> {
    /// Reads the first photograph, which determines the size, and refuses a fit that does not fit into the
    /// limits: `sums` is the number of planes of sums for photographs with that many channels.
    pub fn open(
        names: Vec<&'a str>,
        load: &'a LoadRaster<'a>,
        sums: impl FnOnce(usize) -> usize,
        job: &'a Job,
    ) -> Result<Self> {
        let first = load(0)?;
        check_samples(&first, names[0], job)?;
        let (size, channels) = (first.size(), first.channels());
        let depth = match first.samples() {
            Samples::U8(_) => 1,
            Samples::U16(_) => 2,
            Samples::F32(_) => 4,
        };
        // A batch takes no more memory than the sums, four bytes per plane, or than four photographs; of large ones,
        // whose sums alone take gigabytes, there are two.
        let sums = sums(channels);
        let few = (LARGE_BATCH / (size.texels() * channels * depth).max(1)).max(2);
        let batch = (4 * sums / (channels * depth)).clamp(4, BATCH).min(few);
        job.check("the fit", size, (4 * sums + batch * channels * depth) as u64)?;
        Ok(Self { names, load, size, channels, depth, batch, first: Mutex::new(Some(first)), job })
    }

    /// The size of every photograph.
    pub fn size(&self) -> Size {
        self.size
    }

    /// The channels of every photograph.
    pub fn channels(&self) -> usize {
        self.channels
    }

    /// The name of photograph `i`.
    pub fn name(&self, i: usize) -> &str {
        self.names[i]
    }

    /// The number of photographs.
    pub fn len(&self) -> usize {
        self.names.len()
    }

    /// The memory of the texels of a grid kept from every photograph.
    pub fn sample_bytes(&self, grid: &Grid) -> u64 {
        (grid.texels() * self.channels * self.depth) as u64 * self.names.len() as u64
    }

    /// The memory of all photographs.
    pub fn bytes(&self) -> u64 {
        (self.size.texels() * self.channels * self.depth) as u64 * self.names.len() as u64
    }

    /// Reads photograph `i`.
    pub fn read(&self, i: usize) -> Result<Raster> {
        let held = || self.first.lock().ok().and_then(|mut first| first.take());
        if let Some(first) = (i == 0).then(held).flatten() {
            return Ok(first);
        }
        let photograph = (self.load)(i)?;
        self.check(&photograph, i)?;
        Ok(photograph)
    }

    /// Passes each batch, with the number of its first photograph, to `take`.
    ///
    /// # Errors
    /// The error of the first photograph, in order, that cannot be read, and errors of `take`.
    pub fn for_each_batch(
        &self,
        job: &Job,
        mut take: impl FnMut(usize, &[Raster]) -> Result<()>,
    ) -> Result<()> {
        for start in (0..self.names.len()).step_by(self.batch) {
            let end = (start + self.batch).min(self.names.len());
            let read = |i: usize| job.proceed().and_then(|()| self.read(i));
            let read: Vec<Result<Raster>> = parallel::map(start..end, read);
            take(start, &read.into_iter().collect::<Result<Vec<_>>>()?)?;
        }
        Ok(())
    }

    fn check(&self, photograph: &Raster, i: usize) -> Result<()> {
        let (name, first) = (self.names[i], self.names[0]);
        if photograph.size() != self.size {
            return Err(Error::invalid(format!(
                "the photograph {name} is {} texels and {first} is {}: all must have the same size",
                photograph.size(),
                self.size
            )));
        }
        if photograph.channels() != self.channels {
            let kind = |channels: usize| if channels == 1 { "grey" } else { "in colour" };
            return Err(Error::invalid(format!(
                "the photograph {name} is {} and {first} is {}: convert them to the same kind",
                kind(photograph.channels()),
                kind(self.channels)
            )));
        }
        check_samples(photograph, name, self.job)
    }
}

/// Refuses floating-point samples that no camera produces, and counts those brighter than white.
fn check_samples(photograph: &Raster, name: &str, job: &Job) -> Result<()> {
    let Samples::F32(samples) = photograph.samples() else { return Ok(()) };
    job.count_clipped(Clipper::White, Clipping::of(samples, Clipper::White));
    let wrong = samples.iter().position(|s| s.is_nan() || s.abs() > LARGEST_SAMPLE);
    wrong.map_or(Ok(()), |i| {
        let texel = i / photograph.channels();
        let (x, y) = (texel % photograph.size().width, texel / photograph.size().width);
        Err(Error::invalid(format!(
            "the photograph {name} holds the sample {} at texel ({x}, {y}): expected finite numbers with white at 1",
            samples[i]
        )))
    })
}
