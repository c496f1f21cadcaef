//! Polynomial texture maps: the `.ptm` files of HP Labs.
//!
//! Malzbender, Gelb, Wolters, "Polynomial Texture Maps", SIGGRAPH 2001, and "Polynomial Texture Map (.ptm)
//! File Format", version 1.2, HP Labs 2001. A coefficient is a byte with a scale and a bias common to all
//! channels: a_k = (byte - bias_k) scale_k, in units where white is 255. Values here are a_k / 255. Rows run
//! bottom-up in the file. No gamma is recorded: by convention the values are sRGB-encoded, as photographs
//! are.

mod compress;
mod header;
mod jpeg;
mod lum;
mod pictures;
mod prediction;
mod read;
mod rounding;
mod words;
mod write;

pub(super) use pictures::pictures;
pub(super) use read::decode;
pub(super) use write::{Under, check_finite, encode, encode_compressed};

/// Scale and bias of the six coefficients, in file order: u^2, v^2, uv, u, v, 1.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize)]
pub struct PtmEncoding {
    /// Steps between bytes, in units where white is 255; never zero.
    pub scale: [f32; 6],
    /// The bytes that represent 0: integers in files that follow the format.
    pub bias: [f32; 6],
}

/// The value of white in the units of the file.
pub(super) const WHITE: f64 = 255.0;

impl PtmEncoding {
    /// The coefficient of a byte.
    pub(super) fn value(&self, k: usize, byte: u8) -> f32 {
        ((f64::from(byte) - f64::from(self.bias[k])) * f64::from(self.scale[k]) / WHITE) as f32
    }

    /// The position of a coefficient on the scale of bytes; not rounded, not clamped.
    pub(super) fn position(&self, k: usize, value: f32) -> f64 {
        f64::from(value) * WHITE / f64::from(self.scale[k]) + f64::from(self.bias[k])
    }
}

/// Rounds to the nearest of 0..=255.
pub(super) fn nearest_byte(position: f64) -> u8 {
    (position.clamp(0.0, 255.0) + 0.5) as u8
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::numeric::random::{Purpose, Stream};

    #[test]
    fn every_byte_comes_back_under_any_scale_and_bias() {
        let mut random = Stream::new(5, Purpose::Sample, [0]);
        for _ in 0..2000 {
            let sign = if random.unit() < 0.2 { -1.0 } else { 1.0 };
            let scale = (sign * 10f64.powf(24.0 * random.unit() - 12.0)) as f32;
            let bias = match random.below(3) {
                0 => random.below(256) as f32,
                1 => (random.unit() * 300.0 - 20.0) as f32,
                _ => (random.below(1 << 21) as i64 - (1 << 20)) as f32,
            };
            let encoding = PtmEncoding { scale: [scale; 6], bias: [bias; 6] };
            for byte in 0..=255 {
                assert_eq!(
                    nearest_byte(encoding.position(3, encoding.value(3, byte))),
                    byte,
                    "scale {scale:e}, bias {bias}"
                );
            }
        }
    }
}
