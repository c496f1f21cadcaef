//! Bidirectional texture functions (BTF) of the University of Bonn, `.btf`: the container of the database UBO2014 (M.
//! Weinmann, J. Gall, R. Klein, "Material Classification Based on Training Data Synthesized Using a BTF Database",
//! ECCV 2014).
//!
//! | signature | kind | values |
//! |---|---|---|
//! | `!DFMF08FCR` | decorrelated full matrix factorisation | products of factors, in a colour model |
//! | `!FMF12FCER`, `!FMF06FC`, `!FMF06FCR` | full matrix factorisation | products of factors, or their exponentials |
//! | `!PVF06FC`, `!PVF06FCR` | factorisation for each view | products of factors plus a mean |
//! | `!BDIF06R2!` | images | half floats |
//!
//! [`BonnBtf`] evaluates the image of any pair of directions from the factors, or gathers it from the file; nothing
//! is clamped, and the order of calls does not matter. Where the values are linear in the factors,
//! [`BonnBtf::linear_factors`] gives the functions and the coefficients exactly, without an image.
//! [`encode_fmf`], [`encode_dfmf`] and [`encode_pvf`] write them.
//!
//! Row 0 is taken as the top row. Lights may differ between views; the pairs are in the order of the file, view
//! after view. Rotations and height maps are skipped.

mod color_model;
mod factor;
mod factors;
mod full;
mod grid;
mod header;
mod images;
mod per_view;
mod source;
mod write;
mod write_per_view;

use std::fmt;
use std::path::Path;
use std::sync::Arc;

pub use color_model::BtfColorModel;
pub use factors::{BtfFactors, FactorShape};
use full::{Dfmf, Fmf};
pub use header::BonnKind;
use header::BtfHead;
use images::StoredImages;
use per_view::PerView;
use source::{BtfCursor, BtfSource};
pub use write::{check_grid, check_square, encode_dfmf, encode_fmf};
pub use write_per_view::{ViewPart, encode_pvf};

use super::finite;
use crate::direction::Directions;
use crate::error::{Error, Result};
use crate::job::Job;
use crate::planes::Planes;
use crate::raster::{Raster, Samples};
use crate::size::Size;

/// The channels of files that are written: R, G and B.
const CHANNELS: usize = 3;

/// The numbers of a factored `.btf` file.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum BtfScalar {
    /// 16 bits: a relative error of 2^-11, and at most 65,504.
    #[default]
    Half,
    /// 32 bits.
    Float,
    /// 64 bits.
    Double,
}

/// How a `.btf` file stores its texture.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct StoredBtf {
    /// The kind of data.
    pub kind: BonnKind,
    /// The components: of all, of each channel of the colour model, or of each view; none of images.
    pub components: Vec<usize>,
    /// The numbers, of the first matrix.
    pub scalar: BtfScalar,
}

/// As in `8, 2 and 2 functions of three channels (DFMF), 16-bit floats`.
impl fmt::Display for StoredBtf {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let (least, most) = (self.components.iter().min(), self.components.iter().max());
        let count = match (least, most) {
            (Some(least), Some(most)) if least != most => format!("{least} to {most}"),
            (Some(least), _) => least.to_string(),
            _ => String::new(),
        };
        let views = self.components.len();
        match self.kind {
            BonnKind::Fmf => write!(f, "{count} functions of all (FMF)"),
            BonnKind::Dfmf => {
                let each: Vec<String> = self.components.iter().map(usize::to_string).collect();
                write!(f, "{} functions of the channels of a colour model (DFMF)", each.join(", "))
            }
            BonnKind::Pvf => write!(f, "{count} functions of each of {views} views (PVF)"),
            BonnKind::Bdi => write!(f, "images (BDI)"),
        }?;
        write!(f, ", {}-bit floats", self.scalar.bits())
    }
}

/// A texture of light and view in a `.btf` file.
#[derive(Debug)]
pub struct BonnBtf {
    head: BtfHead,
    body: BtfBody,
    source: BtfSource,
}

/// The data of each kind.
#[derive(Debug)]
enum BtfBody {
    Fmf(Fmf),
    Dfmf(Dfmf),
    PerView(PerView),
    Images(StoredImages),
}

impl BonnBtf {
    /// The texture in the bytes of a file. Factors are decoded to `f32` and count against the memory of the job for
    /// as long as the result lives; images stay in `bytes`.
    ///
    /// # Errors
    /// A file that is truncated, contradicts itself, has numbers that are not finite, or exceeds the limits.
    pub fn decode(bytes: Arc<Vec<u8>>, job: &Job) -> Result<Self> {
        Self::of(BtfSource::of_bytes(bytes), job)
    }

    /// The texture in a file, which is read where it is needed: images stay in the file, so it may be larger than
    /// memory.
    ///
    /// # Errors
    /// As [`BonnBtf::decode`], with the file; and one that cannot be read.
    pub fn open(path: &Path, job: &Job) -> Result<Self> {
        BtfSource::of_file(path).and_then(|source| Self::of(source, job)).map_err(|error| error.at(path))
    }

    fn of(source: BtfSource, job: &Job) -> Result<Self> {
        let mut cursor = BtfCursor::new(&source, job, 0);
        let head = BtfHead::read(&mut cursor)?;
        let body = match head.kind {
            BonnKind::Fmf => BtfBody::Fmf(Fmf::read(&head, &mut cursor)?),
            BonnKind::Dfmf => BtfBody::Dfmf(Dfmf::read(&head, &mut cursor)?),
            BonnKind::Pvf => BtfBody::PerView(PerView::read(&head, &mut cursor)?),
            BonnKind::Bdi => BtfBody::Images(StoredImages::read(&head, &mut cursor)?),
        };
        if cursor.at() != source.length() {
            return Err(Error::invalid(format!(
                "the BTF file has {} bytes after its data: it is damaged",
                source.length() - cursor.at()
            )));
        }
        // Factors are in memory now.
        let source = if matches!(body, BtfBody::Images(_)) { source } else { BtfSource::default() };
        Ok(Self { head, body, source })
    }

    /// The kind of data in the file.
    pub fn kind(&self) -> BonnKind {
        self.head.kind
    }

    /// How the texture is stored.
    pub fn stored(&self) -> StoredBtf {
        let (components, scalar) = match &self.body {
            BtfBody::Fmf(fmf) => (vec![fmf.matrix.components], Some(fmf.matrix.scalar)),
            BtfBody::Dfmf(dfmf) => (
                dfmf.channels.iter().map(|(matrix, _)| matrix.components).collect(),
                dfmf.channels.first().map(|(matrix, _)| matrix.scalar),
            ),
            BtfBody::PerView(views) => views.stored(),
            BtfBody::Images(_) => (Vec::new(), Some(BtfScalar::Half)),
        };
        StoredBtf { kind: self.kind(), components, scalar: scalar.unwrap_or_default() }
    }

    /// The measured pairs of light and view, in the order of the file: view after view.
    pub fn pairs(&self) -> &[Directions] {
        &self.head.sampling.pairs
    }

    /// Width and height of the images.
    pub fn size(&self) -> Size {
        self.head.size
    }

    /// The names of the channels: R, G and B, or others.
    pub fn channels(&self) -> &[String] {
        &self.head.channels
    }

    /// Whether the values contain the cosine between the light and the normal, as photographs do.
    pub fn has_cosine(&self) -> bool {
        self.head.has_cosine
    }

    /// The texels of a millimetre, where the file says so.
    pub fn texels_per_mm(&self) -> Option<f32> {
        Some(self.head.pixels_per_mm).filter(|texels| texels.is_finite() && *texels > 0.0)
    }

    /// The colour model of a decorrelated factorisation.
    pub fn color_model(&self) -> Option<BtfColorModel> {
        match &self.body {
            BtfBody::Dfmf(dfmf) => Some(dfmf.model),
            _ => None,
        }
    }

    /// The image of pair `i`: a plane of linear values for each channel, neither clamped nor encoded.
    ///
    /// # Errors
    /// Values that are not finite, limits, cancellation.
    ///
    /// # Panics
    /// When `i` is not below the number of pairs.
    pub fn planes(&self, i: usize, job: &Job) -> Result<Planes> {
        assert!(i < self.pairs().len(), "pair {i} of {}", self.pairs().len());
        job.proceed()?;
        let mut planes =
            Planes::zeros_within(job, "an image of the BTF", self.size(), self.channels().len())?;
        match &self.body {
            BtfBody::Fmf(fmf) => fmf.image(i, &mut planes),
            BtfBody::Dfmf(dfmf) => dfmf.image(i, &mut planes),
            BtfBody::PerView(views) => views.image(self.head.sampling.place(i), &mut planes),
            BtfBody::Images(images) => images.image(&self.source, i, &mut planes, job)?,
        }
        let texels = self.size().texels();
        let channel = |at: usize| self.channels()[at / texels].as_str();
        let checked = finite::check(planes.as_slice(), self.size(), channel, |at| at % texels);
        checked.map_err(|error| {
            Error::new(error.kind(), format!("image {i} of the BTF: {}", error.message()))
        })?;
        Ok(planes)
    }

    /// As [`BonnBtf::planes`], as a picture of one or three channels.
    ///
    /// # Errors
    /// As [`BonnBtf::planes`], and for other numbers of channels.
    ///
    /// # Panics
    /// As [`BonnBtf::planes`].
    pub fn image(&self, i: usize, job: &Job) -> Result<Raster> {
        let channels = self.channels().len();
        if !matches!(channels, 1 | 3) {
            return Err(Error::unsupported(format!(
                "the BTF has {channels} channels ({} to {}): a picture has one or three",
                self.channels()[0],
                self.channels()[channels - 1]
            )));
        }
        let planes = self.planes(i, job)?;
        let texels = self.size().texels();
        let at = |i: usize| planes.as_slice()[i % channels * texels + i / channels];
        Raster::new(self.size(), channels, Samples::F32((0..texels * channels).map(at).collect()))
    }
}
