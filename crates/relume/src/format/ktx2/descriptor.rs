//! The formats of texels, and their descriptors.

use super::{KtxContent, TextureFormat, blocks};
use crate::format::codes::code8;
use crate::planes::Planes;

/// A format of texels.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum TexelFormat {
    /// One byte.
    R8,
    /// Four bytes.
    Rgba8 { is_srgb: bool },
    /// Blocks of 4 x 4 texels in 16 bytes.
    Bc7 { is_srgb: bool, has_opacity: bool },
}

impl TexelFormat {
    /// The format of a number of planes.
    pub fn of(planes: usize, content: KtxContent, storage: TextureFormat) -> Self {
        let is_srgb = content == KtxContent::Color;
        match (storage, planes) {
            (TextureFormat::Bc7, _) => Self::Bc7 { is_srgb, has_opacity: planes == 4 },
            (_, 1) => Self::R8,
            _ => Self::Rgba8 { is_srgb },
        }
    }

    /// The number of Vulkan's format.
    pub fn vulkan(self) -> u32 {
        match self {
            Self::R8 => 9,
            Self::Rgba8 { is_srgb: false } => 37,
            Self::Rgba8 { is_srgb: true } => 43,
            Self::Bc7 { is_srgb: false, .. } => 145,
            Self::Bc7 { is_srgb: true, .. } => 146,
        }
    }

    /// The common multiple of four and the bytes of a block.
    pub fn alignment(self) -> usize {
        if matches!(self, Self::Bc7 { .. }) { 16 } else { 4 }
    }

    /// The bytes of a level.
    pub fn bytes(self, level: &Planes) -> Vec<u8> {
        match self {
            Self::R8 => level.plane(0).iter().map(|v| code8(*v)).collect(),
            Self::Rgba8 { .. } => rgba(level),
            Self::Bc7 { has_opacity, .. } => blocks::bc7(&rgba(level), level.size(), has_opacity),
        }
    }

    /// The basic descriptor of the format.
    pub fn descriptor(self) -> Vec<u8> {
        const RGBSDA: u8 = 1;
        const BC7: u8 = 134;
        let (model, side, bytes) = match self {
            Self::R8 => (RGBSDA, 0, 1),
            Self::Rgba8 { .. } => (RGBSDA, 0, 4),
            Self::Bc7 { .. } => (BC7, 3, 16),
        };
        let is_srgb = matches!(self, Self::Rgba8 { is_srgb: true } | Self::Bc7 { is_srgb: true, .. });
        let transfer = if is_srgb { 2 } else { 1 };
        let samples = self.samples(is_srgb);
        let block = 24 + 16 * samples.len() as u32;
        let mut out = Vec::new();
        out.extend((4 + block).to_le_bytes());
        out.extend(0u32.to_le_bytes());
        out.extend((2 | block << 16).to_le_bytes());
        // The primaries are those of BT.709, and the opacity is not multiplied in.
        out.extend([model, 1, transfer, 0, side, side, 0, 0, bytes, 0, 0, 0, 0, 0, 0, 0]);
        out.extend(samples.into_iter().flatten());
        out
    }

    fn samples(self, is_srgb: bool) -> Vec<[u8; 16]> {
        /// Of a sample whose values are linear although the format is not.
        const LINEAR: u8 = 0x10;
        const OPACITY: u8 = 15;
        let sample = |offset: u16, bits: u8, channel: u8, upper: u32| {
            let mut out = [0; 16];
            out[..2].copy_from_slice(&offset.to_le_bytes());
            (out[2], out[3]) = (bits - 1, channel);
            out[12..].copy_from_slice(&upper.to_le_bytes());
            out
        };
        match self {
            Self::R8 => vec![sample(0, 8, 0, 255)],
            Self::Rgba8 { .. } => {
                let opacity = if is_srgb { OPACITY | LINEAR } else { OPACITY };
                [0, 1, 2, opacity].iter().zip(0..).map(|(&c, k)| sample(8 * k, 8, c, 255)).collect()
            }
            Self::Bc7 { .. } => vec![sample(0, 128, 0, u32::MAX)],
        }
    }
}

/// Four bytes a texel; a single channel is grey, and what is missing is opaque.
fn rgba(level: &Planes) -> Vec<u8> {
    let channel = |k: usize| match (level.count(), k) {
        (1 | 3, 3) => None,
        (1, _) => Some(level.plane(0)),
        (count, k) => (k < count).then(|| level.plane(k)),
    };
    let channels: [Option<&[f32]>; 4] = std::array::from_fn(channel);
    let mut out = Vec::with_capacity(4 * level.size().texels());
    for texel in 0..level.size().texels() {
        out.extend(channels.map(|plane| plane.map_or(255, |plane| code8(plane[texel]))));
    }
    out
}
