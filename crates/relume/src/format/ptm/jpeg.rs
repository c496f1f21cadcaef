//! The compressed formats: every plane of bytes is a grey JPEG file, which may hold the difference to another
//! plane, and corrections of single texels (side information).
//!
//! "Polynomial Texture Map (.ptm) File Format", version 1.2, HP Labs 2001, and Motta, Weinberger, "Compression of
//! Polynomial Texture Maps", HPL-2000-143, 2001.

use super::prediction::{PlaneReference, restore};
use super::words::Words;
use crate::error::{Error, Result};
use crate::format::jpeg;
use crate::job::Job;
use crate::parallel;
use crate::size::Size;

/// The bytes of a correction: the index of a texel in the order of the file, and its value.
pub(super) const CORRECTION_BYTES: usize = 5;

/// What the header says of compressed planes.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct JpegPlanes {
    /// The planes in the order of their decoding.
    pub order: Vec<usize>,
    /// What each plane is a difference to.
    pub references: Vec<Option<PlaneReference>>,
    /// The bytes of the JPEG file of each plane.
    pub compressed: Vec<usize>,
    /// The bytes of the corrections of each plane.
    pub corrections: Vec<usize>,
}

/// The quality of the encoder is for information only.
const QUALITIES: std::ops::RangeInclusive<i64> = -1..=1000;

impl JpegPlanes {
    /// The lines that follow the biases, of a file of `count` planes.
    pub(super) fn parse(words: &mut Words<'_>, count: usize) -> Result<Self> {
        let last = count as i64 - 1;
        let size = 0..=i64::from(u32::MAX);
        words.integers("the quality", 1, QUALITIES)?;
        let transforms = words.integers("transform", count, 0..=255)?;
        let moved = |words: &mut Words<'_>, what| words.integers(what, count, -65536..=65536);
        let motion = [moved(words, "motion in x")?, moved(words, "motion in y")?].concat();
        if transforms.iter().any(|t| t & !1 != 0) || motion.iter().any(|&m| m != 0) {
            return Err(Error::unsupported(
                "the texture map predicts planes by motion, which is not read: convert the file to PTM_FORMAT_RGB or \
                 PTM_FORMAT_LRGB",
            ));
        }
        let order = in_sequence(&words.integers("order", count, 0..=last)?)?;
        let references = words.integers("reference", count, -1..=last)?;
        let reference = |(&plane, &transform): (&i64, &i64)| {
            (plane >= 0).then_some(PlaneReference { plane: plane as usize, is_inverted: transform & 1 != 0 })
        };
        let references: Vec<_> = references.iter().zip(&transforms).map(reference).collect();
        check_sequence(&order, &references)?;
        let bytes = |sizes: Vec<i64>| sizes.into_iter().map(|n| n as usize).collect::<Vec<_>>();
        let compressed = bytes(words.integers("compressed size", count, size.clone())?);
        let corrections = bytes(words.integers("size of side information", count, size)?);
        if let Some(k) = corrections.iter().position(|n| !n.is_multiple_of(CORRECTION_BYTES)) {
            return Err(Error::invalid(format!(
                "the side information of plane {} of {count} has {} bytes: expected a multiple of {CORRECTION_BYTES}",
                k + 1,
                corrections[k]
            )));
        }
        Ok(Self { order, references, compressed, corrections })
    }

    /// The planes of bytes, rows in the order of the file.
    pub(super) fn decode(&self, payload: &[u8], size: Size, job: &Job) -> Result<Vec<Vec<u8>>> {
        let parts = self.parts(payload)?;
        job.check("the planes of the texture map", size, parts.len() as u64)?;
        let plane = |(k, (file, _)): (usize, &(&[u8], &[u8]))| {
            job.proceed()?;
            let found = jpeg::decode(file, job).map_err(|e| of_plane(k, parts.len(), &e))?;
            if found.channels != 1 || found.size != size {
                let expected = format!("expected one of {size} texels in grey");
                let channels = if found.channels == 1 { "grey" } else { "colour" };
                let fault = format!("the picture has {} texels in {channels}: {expected}", found.size);
                return Err(of_plane(k, parts.len(), &Error::invalid(fault)));
            }
            Ok(found.samples)
        };
        let mut planes: Vec<Vec<u8>> = parallel::try_map(parts.iter().enumerate(), plane)?;
        for &k in &self.order {
            if let Some(reference) = self.references[k] {
                // Taken out, since a plane never refers to itself.
                let mut samples = std::mem::take(&mut planes[k]);
                restore(&mut samples, &planes[reference.plane], reference.is_inverted);
                planes[k] = samples;
            }
            correct(&mut planes[k], parts[k].1).map_err(|e| of_plane(k, parts.len(), &e))?;
        }
        Ok(planes)
    }

    /// The JPEG file and the corrections of each plane.
    fn parts<'a>(&self, payload: &'a [u8]) -> Result<Vec<(&'a [u8], &'a [u8])>> {
        let sizes = self.compressed.iter().chain(&self.corrections);
        let expected = sizes.fold(0u64, |sum, &n| sum + n as u64);
        if expected != payload.len() as u64 {
            return Err(Error::invalid(format!(
                "the planes of the texture map need {expected} bytes, found {}: the file is truncated, or the sizes in \
                 its header are wrong",
                payload.len()
            )));
        }
        let mut rest = payload;
        let mut take = |bytes: usize| {
            let (part, later) = rest.split_at(bytes);
            rest = later;
            part
        };
        let sizes = self.compressed.iter().zip(&self.corrections);
        Ok(sizes.map(|(&file, &corrections)| (take(file), take(corrections))).collect())
    }
}

fn of_plane(k: usize, count: usize, error: &Error) -> Error {
    Error::new(error.kind(), format!("plane {} of {count} of the texture map: {}", k + 1, error.message()))
}

/// The planes in sequence, from the place of each plane in it.
fn in_sequence(places: &[i64]) -> Result<Vec<usize>> {
    let place_of = |k: usize| places.iter().position(|&place| place == k as i64);
    (0..places.len()).map(place_of).collect::<Option<_>>().ok_or_else(|| {
        Error::invalid("the order of the planes of the texture map names one twice: expected each once")
    })
}

/// Refuses references to planes that are decoded later.
fn check_sequence(order: &[usize], references: &[Option<PlaneReference>]) -> Result<()> {
    let place = |plane: usize| order.iter().position(|&k| k == plane);
    for (k, reference) in references.iter().enumerate() {
        if let Some(reference) = reference.filter(|reference| place(reference.plane) >= place(k)) {
            return Err(Error::invalid(format!(
                "plane {} of the texture map is predicted from plane {}, which is decoded after it",
                k + 1,
                reference.plane + 1
            )));
        }
    }
    Ok(())
}

/// Sets the texels of the corrections.
fn correct(samples: &mut [u8], corrections: &[u8]) -> Result<()> {
    for record in corrections.chunks_exact(CORRECTION_BYTES) {
        let at = u32::from_be_bytes([record[0], record[1], record[2], record[3]]) as usize;
        let count = samples.len();
        *samples.get_mut(at).ok_or_else(|| {
            Error::invalid(format!("the side information names texel {at} of {count}: the file is damaged"))
        })? = record[4];
    }
    Ok(())
}
