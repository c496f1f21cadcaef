//! Marble, f = sin^n(x + t(x, y, z)): bands across x, folded by turbulence t, the sum of 2^-i |n|. The power
//! n narrows the bands to veins. The feature size is the distance between bands for even n.

use super::paint::{Color, PaintedTexel, Sampler, blend, scale, srgb};
use super::parameters::Parameters;
use super::solid::{SolidBlock, SolidFractal, SolidLattice};
use std::f64::consts::TAU;

/// Marble of one seed.
pub struct Marble {
    feature: f64,
    power: i32,
    turbulence: f64,
    bands: SolidLattice,
    folds: SolidFractal,
    clouding: SolidFractal,
    grain: SolidFractal,
    white: Color,
    grey: Color,
    vein: Color,
}

impl Marble {
    /// Sets up the noise. On the torus the picture contains a whole number of periods of the sine.
    pub fn new(block: &SolidBlock, parameters: &Parameters) -> Self {
        let feature = block.feature;
        Self {
            feature,
            power: parameters.power.unwrap_or(5) as i32,
            turbulence: parameters.turbulence.unwrap_or(8.0),
            bands: block.lattice([2.0 * feature; 3], 1),
            folds: block.fractal([3.0 * feature; 3], (0, parameters.octaves.unwrap_or(6)), 2),
            clouding: block.fractal([1.2 * feature; 3], (0, 4), 3),
            grain: block.fractal([0.12 * feature; 3], (0, 2), 4),
            white: srgb(0xf1eee8),
            grey: srgb(0xc9c7c4),
            vein: srgb(0x4d4f55),
        }
    }

    /// The material as a function of the texel.
    pub fn sampler(self) -> Box<Sampler> {
        Box::new(move |texel| self.sample(texel))
    }

    /// sin^n(x + t), in [-1, 1].
    fn bands(&self, texel: [f64; 2]) -> f64 {
        let x = TAU * self.bands.cells(texel)[0];
        (x + self.turbulence * self.folds.turbulence(texel)).sin().powi(self.power)
    }

    fn sample(&self, texel: [f64; 2]) -> PaintedTexel {
        let f = self.bands(texel);
        let clouding = self.clouding.at(texel);
        let grain = self.grain.at(texel);
        let stone = blend(self.white, self.grey, 0.45 + 1.3 * clouding);
        let albedo = scale(blend(stone, self.vein, f.abs() * (0.7 + 0.9 * clouding)), 1.0 + 0.05 * grain);
        let height = self.feature * (0.02 * grain + 0.04 * clouding - 0.14 * f);
        PaintedTexel { height, albedo, roughness: 0.22 + 0.25 * f.abs() + 0.06 * grain }
    }
}

#[cfg(test)]
mod tests {
    use super::super::Tiling;
    use super::super::noise::Canvas;
    use super::*;
    use crate::size::Size;

    #[test]
    fn bands_are_the_power_of_the_sine_of_x_plus_turbulence() {
        let canvas = Canvas { size: Size::new(64, 48), tiling: Tiling::Free, seed: 9 };
        let block = SolidBlock { canvas, feature: 11.0, depth: 0.7, depth_period: None };
        let parameters =
            Parameters { power: Some(5), turbulence: Some(3.5), octaves: Some(2), ..Parameters::default() };
        let marble = Marble::new(&block, &parameters);
        for k in 0..200 {
            let texel = [f64::from(k * 37 % 101) * 0.7, f64::from(k * 53 % 97) * 0.6];
            let mut turbulence = 0.0;
            for (i, (_, octave)) in marble.folds.octaves().enumerate() {
                let cell = 3.0 * 11.0 / 2f64.powi(i as i32);
                let place = [texel[0] / cell, texel[1] / cell, 0.7 * 11.0 / cell];
                turbulence += octave.noise(place).abs() / 2f64.powi(i as i32);
            }
            let x = std::f64::consts::PI * texel[0] / 11.0;
            let truth = (x + 3.5 * turbulence).sin().powi(5);
            assert!((marble.bands(texel) - truth).abs() < 1e-9, "{texel:?}");
        }
    }
}
