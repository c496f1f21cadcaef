//! Clouds, f = sum over i = 1..4 of 2^-i n(2^i x, 2^i y, 2^i z): white where f is high, sky where it is low.
//! The height is f itself: a bank of clouds seen from above.

use super::paint::{Color, PaintedTexel, Sampler, blend, smoothstep, srgb};
use super::parameters::Parameters;
use super::solid::{SolidBlock, SolidFractal};

/// Clouds of one seed.
pub struct Clouds {
    feature: f64,
    density: SolidFractal,
    sky: Color,
    shade: Color,
    white: Color,
}

impl Clouds {
    /// Sets up the noise; the octave i = 1 has cells of a feature size.
    pub fn new(block: &SolidBlock, parameters: &Parameters) -> Self {
        let feature = block.feature;
        Self {
            feature,
            density: block.fractal([2.0 * feature; 3], (1, parameters.octaves.unwrap_or(4)), 1),
            sky: srgb(0x4f87c7),
            shade: srgb(0xb9c7da),
            white: srgb(0xfbfbfa),
        }
    }

    /// The material as a function of the texel.
    pub fn sampler(self) -> Box<Sampler> {
        Box::new(move |texel| self.sample(texel))
    }

    fn sample(&self, texel: [f64; 2]) -> PaintedTexel {
        let f = self.density.at(texel);
        let cloud = blend(self.shade, self.white, smoothstep(0.0, 0.35, f));
        let albedo = blend(self.sky, cloud, smoothstep(-0.14, 0.16, f));
        PaintedTexel { height: self.feature * f, albedo, roughness: 0.85 - 0.2 * f }
    }
}

#[cfg(test)]
mod tests {
    use super::super::Tiling;
    use super::super::noise::Canvas;
    use super::*;
    use crate::size::Size;

    #[test]
    fn heights_are_the_sum_of_four_octaves() {
        let canvas = Canvas { size: Size::new(64, 48), tiling: Tiling::Free, seed: 2 };
        let block = SolidBlock { canvas, feature: 10.0, depth: 1.3, depth_period: None };
        let clouds = Clouds::new(&block, &Parameters::default());
        assert_eq!(clouds.density.octaves().count(), 4);
        for k in 0..200 {
            let texel = [f64::from(k * 37 % 101) * 0.7, f64::from(k * 53 % 97) * 0.6];
            let mut sum = 0.0;
            for (i, (_, octave)) in clouds.density.octaves().enumerate() {
                let factor = 2f64.powi(i as i32 + 1);
                sum += octave.noise([texel[0], texel[1], 13.0].map(|c| factor * c / 20.0)) / factor;
            }
            assert!((clouds.sample(texel).height - 10.0 * sum).abs() < 1e-9, "{texel:?}");
        }
    }
}
