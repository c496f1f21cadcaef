//! Linear light and the sRGB encoding (IEC 61966-2-1:1999), and where each is used.

use serde::Serialize;

use crate::names::{Named, named};

/// Whether values are proportional to light or carry the sRGB encoding.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Space {
    /// Proportional to light.
    Linear,
    /// Encoded for display, as in 8-bit photographs and `.ptm` files.
    Srgb,
}

named!(Space { Srgb => "srgb", Linear => "linear" });

impl Space {
    /// A value of this space as linear light.
    pub fn to_linear(self, value: f32) -> f32 {
        match self {
            Self::Linear => value,
            Self::Srgb => linear_from_srgb(value),
        }
    }

    /// A linear value converted to this space.
    pub fn from_linear(self, value: f32) -> f32 {
        match self {
            Self::Linear => value,
            Self::Srgb => srgb_from_linear(value),
        }
    }

    /// A value of this space, sRGB-encoded.
    pub fn to_srgb(self, value: f32) -> f32 {
        match self {
            Self::Linear => srgb_from_linear(value),
            Self::Srgb => value,
        }
    }
}

impl std::fmt::Display for Space {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(self.name())
    }
}

/// Decodes sRGB; odd about zero, and continued above 1 by the same formula.
pub fn linear_from_srgb(value: f32) -> f32 {
    let v = f64::from(value.abs());
    let linear = if v <= 0.04045 { v / 12.92 } else { ((v + 0.055) / 1.055).powf(2.4) };
    (linear as f32).copysign(value)
}

/// Encodes sRGB; odd about zero, and continued above 1 by the same formula.
pub fn srgb_from_linear(value: f32) -> f32 {
    let v = f64::from(value.abs());
    let encoded = if v <= 0.003_130_8 { v * 12.92 } else { 1.055 * v.powf(1.0 / 2.4) - 0.055 };
    (encoded as f32).copysign(value)
}

/// Linear light of each 8-bit sRGB code.
pub fn linear_from_srgb8() -> [f32; 256] {
    std::array::from_fn(|code| linear_from_srgb(code as f32 / 255.0))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_8_and_16_bit_code_survives_linear_light() {
        for (levels, name) in [(255u32, "8 bit"), (65535, "16 bit")] {
            for code in 0..=levels {
                let linear = linear_from_srgb(code as f32 / levels as f32);
                let back = (srgb_from_linear(linear) * levels as f32).round() as u32;
                assert_eq!(back, code, "{name}");
            }
        }
    }
}
