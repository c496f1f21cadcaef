//! The memory that writing takes, from sizes alone: what encoders check before they work, and jobs before
//! their first stage.

use super::exr::ExrDepth;
use super::field_file::FieldFormat;
use super::height::HeightFormat;
use super::picture::{Depth, PictureFormat};
use crate::field::ReflectanceField;
use crate::memory::Footprint;
use crate::size::Size;

/// A PNG encoder's most bytes for each byte of samples: the samples, compressed, and the file, both in
/// buffers that double as they grow.
const PNG: u64 = 5;
/// The planes of a product of luminance and colour in a `.ptm` file.
const PTM_PRODUCT: u64 = 9;
/// The planes of functions of luminance.
const PTM_LUMINANCE: u64 = 6;

impl PictureFormat {
    /// The memory of [`encode_picture`](super::encode_picture) for a picture of `channels`, beside the
    /// picture.
    pub fn footprint(self, size: Size, channels: usize) -> Footprint {
        let channels = channels as u64;
        let samples = |depth: Depth| channels * depth.bytes();
        match self {
            Self::Png(depth) => Footprint::of_texels(size, PNG * samples(depth), samples(depth)),
            // The codes of 16 bits are in memory in two orders of bytes while the file does not exist yet.
            Self::Tiff(depth) => Footprint::of_texels(size, 2 * samples(depth), samples(depth)),
            Self::Jpeg { .. } => Footprint::of_texels(size, 2 * channels, channels),
            // A linear copy of the values, and the file in one piece.
            Self::Pfm => Footprint::of_texels(size, (4 + 8) * channels, 4 * channels),
            // A linear copy, and a file of at most five bytes a texel in a buffer that doubles as it grows.
            Self::Radiance => Footprint::of_texels(size, 4 * channels + 15, 5),
            // A linear copy of the values.
            Self::Exr(depth) => {
                let file = depth.footprint(size, channels);
                Footprint { peak: file.peak + Footprint::of_texels(size, 4 * channels, 0).peak, ..file }
            }
        }
    }

    /// The memory of [`encode_normals`](super::encode_normals), beside the normals: a packed copy, and its file of 16
    /// bits where there is a choice.
    pub fn normals_footprint(self, size: Size) -> Footprint {
        Footprint::of_texels(size, 12, 12).then(self.with_depth(Depth::Sixteen).footprint(size, 3))
    }
}

impl FieldFormat {
    /// The memory of [`encode_field`](super::encode_field) for a field of `planes`, beside the field.
    pub fn footprint(self, size: Size, planes: usize) -> Footprint {
        let planes = planes as u64;
        match self {
            // The luminance, the factors that belong to the rounded colours, and these.
            Self::Rti => Footprint::of_texels(size, 3 * planes, planes),
            // The channels of a product multiplied out, and the file.
            Self::Hsh => Footprint::of_texels(size, 15 * planes, 3 * planes),
            Self::Ptm if planes == PTM_PRODUCT => Footprint::of_texels(size, 24 + 3 + 9, 9),
            Self::Ptm if planes == PTM_LUMINANCE => Footprint::of_texels(size, 3 + 9, 9),
            Self::Ptm => Footprint::of_texels(size, planes, planes),
            // The raw file, its planes, those that are decoded again, and a residual with its JPEG file.
            Self::PtmJpeg { .. } => Self::Ptm.footprint(size, planes as usize).then(Footprint::of_texels(
                size,
                2 * planes + 4,
                planes,
            )),
            Self::Exr(depth) => depth.footprint(size, planes),
            Self::Picture(format) => {
                // The coefficients as a picture.
                let copy = Footprint::of_texels(size, 4 * planes, 4 * planes);
                copy.then(format.footprint(size, planes as usize))
            }
        }
    }

    /// What an opacity adds to it: in an EXR file the planes that are multiplied by it, and those of the file; in a
    /// picture a fourth channel, and the colours of a grey one.
    pub(super) fn opacity_footprint(self, field: &ReflectanceField) -> Footprint {
        let planes = field.coefficients().count() as u64;
        let bytes = match self {
            Self::Exr(_) => 4 * (2 * planes + 1) + 4,
            Self::Picture(_) | Self::Ptm | Self::PtmJpeg { .. } | Self::Rti | Self::Hsh => {
                2 * PNG + if planes == 1 { 12 + 2 * PNG } else { 0 }
            }
        };
        Footprint::of_texels(field.size(), bytes, 0)
    }
}

impl HeightFormat {
    /// The memory of [`encode_height`](super::encode_height), beside the heights.
    pub fn footprint(self, size: Size) -> Footprint {
        let scaled = Footprint::of_texels(size, 4, 4);
        scaled.then(match self {
            Self::Png => Footprint::of_texels(size, PNG * 2, 2),
            Self::Exr => ExrDepth::Float.footprint(size, 1),
        })
    }
}

impl ExrDepth {
    /// The memory of the file of `planes`: the file, and the blocks that are compressed at a time.
    pub(super) fn footprint(self, size: Size, planes: u64) -> Footprint {
        let texel = planes * self.bytes() as u64;
        let rows = (super::exr::ROWS * BLOCKS_A_THREAD * (rayon::current_num_threads() + 1)) as u64;
        let blocks =
            Footprint::of_texels(Size::new(size.width, size.height.min(rows as usize)), texel, 0).peak;
        let file = Footprint::of_texels(size, texel, texel);
        Footprint { peak: file.peak.saturating_add(blocks), ..file }
    }
}

/// The blocks of an EXR file in memory for each thread: the samples, reordered, and compressed.
const BLOCKS_A_THREAD: usize = 3;

impl Depth {
    fn bytes(self) -> u64 {
        match self {
            Self::Eight => 1,
            Self::Sixteen => 2,
        }
    }
}
