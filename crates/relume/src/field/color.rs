//! How coefficient planes make colours.

use serde::Serialize;

/// The colour model of a field; `n` stands for the length of its basis.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum ColorModel {
    /// One function a texel: `n` planes.
    Luminance,
    /// A function for each channel: 3 n planes, the `n` of red first, then green, then blue.
    Rgb,
    /// One function times a colour: `n` planes of luminance, then red, green, blue.
    Lrgb,
}

impl ColorModel {
    /// The number of planes with a basis of `n` functions.
    pub fn planes(self, n: usize) -> usize {
        match self {
            Self::Luminance => n,
            Self::Rgb => 3 * n,
            Self::Lrgb => n + 3,
        }
    }

    /// Channels of a relit picture.
    pub fn channels(self) -> usize {
        match self {
            Self::Luminance => 1,
            Self::Rgb | Self::Lrgb => 3,
        }
    }

    /// The name used in files, options and messages.
    pub fn name(self) -> &'static str {
        match self {
            Self::Luminance => "luminance",
            Self::Rgb => "rgb",
            Self::Lrgb => "lrgb",
        }
    }

    /// The model of that name.
    pub fn from_name(name: &str) -> Option<Self> {
        [Self::Luminance, Self::Rgb, Self::Lrgb].into_iter().find(|model| model.name() == name)
    }
}
