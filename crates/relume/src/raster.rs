//! Samples as stored in a picture file: the interface between file readers and the stages.
//!
//! A raster is interleaved (all channels of a texel are adjacent), grey or RGB, rows from the top, with an
//! opacity of its own where the file has one. Integer samples are sRGB-encoded, floating-point samples are linear, by the convention of the files they come
//! from. Nothing is converted until a caller asks for a [`Picture`].

use std::sync::{Mutex, PoisonError};

use crate::error::{Error, Result};
use crate::job::Job;
use crate::picture::Picture;
use crate::planes::Planes;
use crate::size::Size;
use crate::space::Space;

/// Reads photograph `i` of several; called from any thread, and perhaps more than once for each.
pub type LoadRaster<'a> = dyn Fn(usize) -> Result<Raster> + Sync + 'a;

/// The last two codes of 8 bits, decoded.
const SATURATED: f32 = 0.991;

/// The samples of a [`Raster`] in the bit depth of their file.
#[derive(Debug, Clone, PartialEq)]
pub enum Samples {
    /// 8 bits, sRGB-encoded, 255 is white.
    U8(Vec<u8>),
    /// 16 bits, sRGB-encoded, 65,535 is white.
    U16(Vec<u16>),
    /// Linear light, 1 is white.
    F32(Vec<f32>),
}

impl Samples {
    /// The number of samples.
    pub fn len(&self) -> usize {
        match self {
            Self::U8(s) => s.len(),
            Self::U16(s) => s.len(),
            Self::F32(s) => s.len(),
        }
    }

    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// The space the samples are in.
    pub fn space(&self) -> Space {
        match self {
            Self::U8(_) | Self::U16(_) => Space::Srgb,
            Self::F32(_) => Space::Linear,
        }
    }

    /// Sample `i` with white at 1, in [`Samples::space`].
    pub fn value(&self, i: usize) -> f32 {
        match self {
            Self::U8(s) => f32::from(s[i]) / 255.0,
            Self::U16(s) => f32::from(s[i]) / 65535.0,
            Self::F32(s) => s[i],
        }
    }

    /// The number of samples at the end of their range: the last two codes of 8 bits, also where they are decoded. Floats above 1 go
    /// on beyond white.
    pub fn saturated(&self) -> usize {
        match self {
            Self::U8(s) => s.iter().filter(|s| **s >= 254).count(),
            Self::U16(s) => s.iter().filter(|s| **s >= 65_278).count(),
            Self::F32(s) => s.iter().filter(|s| (SATURATED..=1.0).contains(*s)).count(),
        }
    }

    /// Sets the samples of texels outside a mask to black.
    fn blacken(&mut self, mask: &[bool]) {
        fn outside<T: Copy + Default>(samples: &mut [T], mask: &[bool]) {
            let channels = samples.len() / mask.len();
            let texels = samples.chunks_exact_mut(channels).zip(mask);
            texels.filter(|(_, inside)| !**inside).for_each(|(texel, _)| texel.fill(T::default()));
        }
        match self {
            Self::U8(s) => outside(s, mask),
            Self::U16(s) => outside(s, mask),
            Self::F32(s) => outside(s, mask),
        }
    }

    /// Those of the rectangle of `size` texels at (x, y), which lies inside a picture of `of` texels.
    fn crop(&self, of: Size, x: usize, y: usize, size: Size) -> Self {
        fn rows<T: Copy>(samples: &[T], of: Size, x: usize, y: usize, size: Size) -> Vec<T> {
            let channels = samples.len() / of.texels();
            let row = |y: usize| &samples[of.index(x, y) * channels..][..size.width * channels];
            (y..y + size.height).flat_map(|y| row(y).iter().copied()).collect()
        }
        match self {
            Self::U8(s) => Self::U8(rows(s, of, x, y, size)),
            Self::U16(s) => Self::U16(rows(s, of, x, y, size)),
            Self::F32(s) => Self::F32(rows(s, of, x, y, size)),
        }
    }
}

/// A picture as stored: interleaved samples, one or three channels, rows from the top, and the opacity (alpha)
/// of its texels where it varies.
#[derive(Debug, Clone, PartialEq)]
pub struct Raster {
    size: Size,
    channels: usize,
    samples: Samples,
    opacity: Option<Samples>,
}

impl Raster {
    /// A raster of one (grey) or three (RGB) channels.
    pub fn new(size: Size, channels: usize, samples: Samples) -> Result<Self> {
        if !matches!(channels, 1 | 3) || size.texels() == 0 || samples.len() != size.texels() * channels {
            return Err(Error::invalid(format!(
                "a picture of {size} texels and {channels} channels cannot hold {} samples",
                samples.len()
            )));
        }
        Ok(Self { size, channels, samples, opacity: None })
    }

    /// The same picture with an opacity: one sample per texel, 0 is transparent and white opaque. Colours are
    /// not multiplied by it.
    pub fn with_opacity(self, opacity: Samples) -> Result<Self> {
        if opacity.len() != self.size.texels() {
            return Err(Error::invalid(format!(
                "a picture of {} texels cannot have the opacity of {}",
                self.size,
                opacity.len()
            )));
        }
        Ok(Self { opacity: Some(opacity), ..self })
    }

    /// The same picture without an opacity.
    #[must_use]
    pub fn without_opacity(self) -> Self {
        Self { opacity: None, ..self }
    }

    /// The same picture, black where a mask with a value for each texel is false.
    ///
    /// # Errors
    /// A mask of another number of texels.
    pub fn blackened(mut self, mask: &[bool]) -> Result<Self> {
        if mask.len() != self.size.texels() {
            return Err(Error::invalid(format!(
                "the mask has {} texels and the picture {}: they must have the same size",
                mask.len(),
                self.size
            )));
        }
        self.samples.blacken(mask);
        Ok(self)
    }

    /// The opacity of each texel, if the file has one that varies.
    pub fn opacity(&self) -> Option<&Samples> {
        self.opacity.as_ref()
    }

    /// The opacity as a plane, from 0 to 1: coverage, in which no space is encoded.
    pub fn opacity_plane(&self) -> Option<Planes> {
        let opacity = self.opacity.as_ref()?;
        let values = (0..self.size.texels()).map(|texel| opacity.value(texel).clamp(0.0, 1.0)).collect();
        Some(Planes::from_vec(self.size, 1, values).expect("one value per texel"))
    }

    /// Width and height.
    pub fn size(&self) -> Size {
        self.size
    }

    /// 1 for grey, 3 for RGB.
    pub fn channels(&self) -> usize {
        self.channels
    }

    /// The interleaved samples.
    pub fn samples(&self) -> &Samples {
        &self.samples
    }

    /// The rectangle of `size` texels whose top-left texel is (x, y).
    ///
    /// # Errors
    /// When the rectangle does not lie inside.
    pub fn crop(&self, x: usize, y: usize, size: Size) -> Result<Self> {
        self.size.check_crop(x, y, size)?;
        let cropped = Self::new(size, self.channels, self.samples.crop(self.size, x, y, size))?;
        match &self.opacity {
            Some(opacity) => cropped.with_opacity(opacity.crop(self.size, x, y, size)),
            None => Ok(cropped),
        }
    }

    /// The values as planes, converted to `space`, which count against the budget for as long as they live.
    ///
    /// # Errors
    /// [`ErrorKind::Limit`](crate::ErrorKind::Limit) when they do not fit beside what is held.
    pub fn to_planes(&self, space: Space, job: &Job) -> Result<Planes> {
        const WHAT: &str = "the values of the picture";
        job.check(WHAT, self.size, 4 * self.channels as u64)?;
        self.to_picture(space).planes.held(job, WHAT)
    }

    /// The values as planes, converted to `space`.
    pub fn to_picture(&self, space: Space) -> Picture {
        let own = self.samples.space();
        let convert = |value: f32| match (own, space) {
            (Space::Srgb, Space::Linear) => own.to_linear(value),
            (Space::Linear, Space::Srgb) => own.to_srgb(value),
            _ => value,
        };
        let table: Option<Vec<f32>> = match &self.samples {
            Samples::U8(_) => Some((0..=255u8).map(|code| convert(f32::from(code) / 255.0)).collect()),
            _ => None,
        };
        let mut planes = Planes::zeros(self.size, self.channels);
        for (c, plane) in planes.iter_mut().enumerate() {
            for (texel, out) in plane.iter_mut().enumerate() {
                let i = texel * self.channels + c;
                *out = match (&self.samples, &table) {
                    (Samples::U8(s), Some(table)) => table[usize::from(s[i])],
                    (samples, _) => convert(samples.value(i)),
                };
            }
        }
        Picture { planes, space }
    }
}

/// Rasters read by number. The first is read beforehand, so that the common size is known before the work, and
/// given out where it is asked for: none is opened twice for it.
pub struct RasterSequence<'a> {
    load: &'a LoadRaster<'a>,
    size: Size,
    channels: usize,
    first: Mutex<Option<Raster>>,
}

impl<'a> RasterSequence<'a> {
    /// Reads the first.
    ///
    /// # Errors
    /// Those of `load`.
    pub fn open(load: &'a LoadRaster<'a>) -> Result<Self> {
        let first = load(0)?;
        Ok(Self { load, size: first.size(), channels: first.channels(), first: Mutex::new(Some(first)) })
    }

    /// Width and height of the first.
    pub fn size(&self) -> Size {
        self.size
    }

    /// The channels of the first.
    pub fn channels(&self) -> usize {
        self.channels
    }

    /// Raster `i`, which may be unlike the first.
    ///
    /// # Errors
    /// Those of `load`.
    pub fn read(&self, i: usize) -> Result<Raster> {
        let kept = || self.first.lock().unwrap_or_else(PoisonError::into_inner).take();
        (i == 0).then(kept).flatten().map_or_else(|| (self.load)(i), Ok)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_first_of_a_sequence_is_loaded_once() {
        let loaded = Mutex::new(Vec::new());
        let load = |i: usize| {
            loaded.lock().unwrap().push(i);
            Raster::new(Size::new(2, 1), 1, Samples::U8(vec![i as u8, 7]))
        };
        let sequence = RasterSequence::open(&load).unwrap();
        assert_eq!((sequence.size(), sequence.channels()), (Size::new(2, 1), 1));
        for i in 0..3 {
            assert_eq!(sequence.read(i).unwrap().samples().value(0), i as f32 / 255.0);
        }
        assert_eq!(*loaded.lock().unwrap(), [0, 1, 2]);
        // A second pass over photographs that were too many to keep reads them again.
        sequence.read(0).unwrap();
        assert_eq!(loaded.lock().unwrap().len(), 4);
    }

    #[test]
    fn a_crop_is_that_of_the_picture() {
        let samples = Samples::U8((0..5 * 4 * 3).collect());
        let raster = Raster::new(Size::new(5, 4), 3, samples).unwrap();
        let size = Size::new(3, 2);
        let expected = raster.to_picture(Space::Srgb).planes.crop(2, 1, size).unwrap();
        assert_eq!(raster.crop(2, 1, size).unwrap().to_picture(Space::Srgb).planes, expected);
        let opaque = raster.clone().with_opacity(Samples::U8((0..20).collect())).unwrap();
        let cropped = opaque.crop(2, 1, size).unwrap();
        assert_eq!(cropped.opacity(), Some(&Samples::U8(vec![7, 8, 9, 12, 13, 14])));
        assert!(raster.crop(3, 0, size).is_err() && raster.crop(0, usize::MAX, size).is_err());
        assert!(raster.crop(0, 0, Size::new(0, 2)).is_err());
    }
}
