//! Files of the values themselves (BDI): for each stored texel its half floats, channel after channel, then light
//! after light, then view after view, in chunks of some rows of texels.
//!
//! An image is gathered from all chunks, a few bytes of each texel. On a disk that is a page of the file for each, so
//! there the images of as many following pairs as a quarter of the free memory holds are gathered in the same pass,
//! and kept: in the order of pairs, a file is read a few times, not once for each image.

use std::sync::{Mutex, PoisonError};

use super::header::{BtfHead, skip_rotations};
use super::source::{BtfCursor, BtfSource, half_at};
use crate::error::{Error, Result};
use crate::job::{Held, Job};
use crate::memory;
use crate::planes::Planes;

/// Where the texels of a file lie.
#[derive(Debug)]
pub(super) struct StoredImages {
    /// The first byte of each chunk of texels, after its length.
    chunks: Vec<u64>,
    /// Stored texels in a chunk.
    texels_a_chunk: usize,
    /// The bytes of a texel.
    texel_bytes: u64,
    /// The number of each texel among the stored ones, where some are missing.
    stored: Option<Vec<u32>>,
    /// The images gathered last, of a file that is not in memory.
    kept: Mutex<Option<GatheredImages>>,
    _held: Held,
}

/// The images of consecutive pairs.
#[derive(Debug)]
struct GatheredImages {
    first: usize,
    pairs: usize,
    /// The halves of these pairs, texel after texel; 0 where none is stored.
    bytes: Vec<u8>,
    _held: Held,
}

/// The number of a texel that is not stored.
const MISSING: u32 = u32::MAX;

impl StoredImages {
    pub(super) fn read(head: &BtfHead, cursor: &mut BtfCursor) -> Result<Self> {
        let lines = cursor.u32("the lines of a chunk")? as usize;
        let texels_a_chunk = head.size.width.saturating_mul(lines);
        if lines == 0 {
            return Err(Error::invalid("the chunks of the BTF file have 0 lines: it is damaged"));
        }
        let sparse = match cursor.u8("the kind of compression")? {
            0 => false,
            2 => true,
            1 => {
                return Err(Error::unsupported(
                    "the chunks of the BTF file are compressed by bzip2, which is not read: write them uncompressed",
                ));
            }
            other => {
                return Err(Error::unsupported(format!(
                    "the compression {other} of the BTF file is not read: expected 0 (none) or 2 (sparse)"
                )));
            }
        };
        let texels = head.size.texels();
        let held = cursor.job().hold("the mask of the BTF file", 5 * texels as u64)?;
        let mask = cursor.bytes("the mask", texels as u64)?;
        skip_rotations(cursor)?;
        let stored = if sparse { numbered(&mask, cursor.job())? } else { None };
        let count = stored.as_ref().map_or(texels, |stored| stored.iter().filter(|&&n| n != MISSING).count());
        let texel_bytes = head.values().saturating_mul(2);
        let chunks = chunks(cursor, count, texels_a_chunk, texel_bytes)?;
        Ok(Self { chunks, texels_a_chunk, texel_bytes, stored, kept: Mutex::default(), _held: held })
    }

    /// The image of a pair, in all channels; 0 where no texel is stored.
    pub(super) fn image(
        &self,
        source: &BtfSource,
        pair: usize,
        planes: &mut Planes,
        job: &Job,
    ) -> Result<()> {
        if source.is_in_memory() {
            self.gather(source, pair, 1, planes, job)?.fill(pair, planes);
            return Ok(());
        }
        let mut kept = self.kept.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(images) = kept.as_ref().filter(|images| images.holds(pair)) {
            images.fill(pair, planes);
            return Ok(());
        }
        // Given back before the next are gathered.
        *kept = None;
        let (texels, channels) = (planes.size().texels() as u64, planes.count() as u64);
        let following = self.texel_bytes / (2 * channels) - pair as u64;
        let together = (job.free_bytes() / 4 / (2 * channels * texels)).clamp(1, following);
        let images = self.gather(source, pair, together as usize, planes, job)?;
        images.fill(pair, planes);
        *kept = Some(images);
        Ok(())
    }

    /// The images of `pairs` pairs from `first` on, of the size and the channels of `planes`.
    fn gather(
        &self,
        source: &BtfSource,
        first: usize,
        pairs: usize,
        planes: &Planes,
        job: &Job,
    ) -> Result<GatheredImages> {
        const WHAT: &str = "the images of the BTF that are read together";
        let (size, pair_bytes) = (planes.size(), 2 * planes.count());
        let held = job.hold(WHAT, (size.texels() * pairs * pair_bytes) as u64)?;
        let mut bytes = memory::zeros(WHAT, size.texels() * pairs * pair_bytes)?;
        for (texel, out) in bytes.chunks_exact_mut(pairs * pair_bytes).enumerate() {
            if texel % size.width == 0 {
                job.proceed()?;
            }
            let number = self.stored.as_ref().map_or(texel, |stored| stored[texel] as usize);
            if number == MISSING as usize {
                continue;
            }
            let inside = (number % self.texels_a_chunk) as u64 * self.texel_bytes;
            let at = self.chunks[number / self.texels_a_chunk] + inside + (first * pair_bytes) as u64;
            source.read(at, out)?;
        }
        Ok(GatheredImages { first, pairs, bytes, _held: held })
    }
}

impl GatheredImages {
    fn holds(&self, pair: usize) -> bool {
        (self.first..self.first + self.pairs).contains(&pair)
    }

    fn fill(&self, pair: usize, planes: &mut Planes) {
        let channels = planes.count();
        let stride = 2 * channels * self.pairs;
        for (channel, plane) in planes.iter_mut().enumerate() {
            let first = 2 * ((pair - self.first) * channels + channel);
            for (texel, value) in plane.iter_mut().enumerate() {
                *value = half_at(&self.bytes[texel * stride + first..]).to_f32();
            }
        }
    }
}

/// The number of each texel among those of the mask, row by row; `None` if all are stored.
fn numbered(mask: &[u8], job: &Job) -> Result<Option<Vec<u32>>> {
    let missing = mask.iter().filter(|&&stored| stored == 0).count();
    if missing == 0 {
        return Ok(None);
    }
    if mask.len() >= MISSING as usize {
        return Err(Error::unsupported(
            "the mask of the BTF file has more texels than are read: at most 2^32 - 2",
        ));
    }
    job.remark(format!(
        "{missing} of the {} texels are not stored in the BTF file and are 0; its mask is taken row by row, an order \
         that the format leaves open",
        mask.len()
    ));
    let mut numbers = memory::with_capacity("the mask of the BTF file", mask.len())?;
    let mut next = 0;
    for &stored in mask {
        numbers.push(if stored == 0 { MISSING } else { next });
        next += u32::from(stored != 0);
    }
    Ok(Some(numbers))
}

/// The first byte of each chunk.
fn chunks(cursor: &mut BtfCursor, count: usize, texels_a_chunk: usize, texel_bytes: u64) -> Result<Vec<u64>> {
    let number = count.div_ceil(texels_a_chunk);
    let texels = texel_bytes.saturating_mul(count as u64);
    cursor.expect("the values of all texels", texels.saturating_add(4 * number as u64))?;
    cursor.job().check_bytes("the table of chunks", 8 * number as u64)?;
    let mut chunks = memory::with_capacity("the table of chunks", number)?;
    for chunk in 0..number {
        let texels = texels_a_chunk.min(count - chunk * texels_a_chunk) as u64;
        let (found, expected) = (u64::from(cursor.u32("the length of a chunk")?), texels * texel_bytes);
        if found != expected {
            return Err(Error::invalid(format!(
                "chunk {chunk} of the BTF file has {found} bytes: expected {expected} for {texels} texels; the file is \
                 damaged"
            )));
        }
        chunks.push(cursor.at());
        cursor.skip("a chunk", expected)?;
    }
    Ok(chunks)
}
