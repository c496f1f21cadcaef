//! Fire, f = z + sum over i = 1..4 of 2^-i n(2^i x, 0, 2^i z + phi): z is the height in the picture, from 0
//! at the bottom to 1 at the top, x is in feature sizes, and flames are hot where f is low. As phi falls the
//! flames rise, finer octaves more slowly; a phi of 2^4 closes the loop on the torus.
//!
//! On the torus z has to be periodic as well: it returns to 0 over the top eighth, so tiles look like rows of
//! flames, one in front of the next.

use super::noise::Tiling;
use super::paint::{Color, PaintedTexel, Sampler, blend, smoothstep, srgb};
use super::parameters::Parameters;
use super::solid::{SolidBlock, SolidFractal};

/// The height at which z begins to return to 0 on the torus.
const FALL: f64 = 0.875;

/// Fire of one seed.
pub struct Fire {
    feature: f64,
    height: f64,
    tiling: Tiling,
    phi: f64,
    turbulence: f64,
    flicker: SolidFractal,
    palette: [(f64, Color); 6],
}

impl Fire {
    /// Sets up the noise: cells of a feature size along x and of the picture along z, for i = 0.
    pub fn new(block: &SolidBlock, parameters: &Parameters) -> Self {
        let height = block.canvas.size.height as f64;
        let cell = [2.0 * block.feature, height, 2.0 * block.feature];
        Self {
            feature: block.feature,
            height,
            tiling: block.canvas.tiling,
            phi: parameters.phi.unwrap_or(0.0),
            turbulence: parameters.turbulence.unwrap_or(1.0),
            flicker: block.fractal(cell, (1, parameters.octaves.unwrap_or(4)), 1),
            palette: [
                (0.0, srgb(0x0d0705)),
                (0.2, srgb(0x4a0d05)),
                (0.42, srgb(0xb62f08)),
                (0.62, srgb(0xf07a12)),
                (0.82, srgb(0xfccb45)),
                (1.0, srgb(0xfff6d8)),
            ],
        }
    }

    /// The material as a function of the texel.
    pub fn sampler(self) -> Box<Sampler> {
        Box::new(move |texel| self.sample(texel))
    }

    /// The height in the picture, and its value in f.
    fn z(&self, texel: [f64; 2]) -> (f64, f64) {
        let z = 1.0 - (texel[1] + 0.5) / self.height;
        match self.tiling {
            Tiling::Free => (z, z),
            Tiling::Torus => (z, z.rem_euclid(1.0) - smoothstep(FALL, 1.0, z.rem_euclid(1.0))),
        }
    }

    /// The sum of the octaves.
    fn flicker(&self, texel: [f64; 2]) -> f64 {
        let (z, _) = self.z(texel);
        let octaves = self.flicker.octaves().zip(1..);
        let terms = octaves.map(|((weight, lattice), i)| {
            let x = lattice.cells(texel)[0];
            weight * lattice.noise([x, f64::from(i).exp2() * z + self.phi, 0.0])
        });
        self.turbulence * terms.sum::<f64>()
    }

    fn sample(&self, texel: [f64; 2]) -> PaintedTexel {
        let flicker = self.flicker(texel);
        let f = self.z(texel).1 + flicker;
        let albedo = self.color(1.0 - f);
        PaintedTexel { height: -0.6 * self.feature * flicker, albedo, roughness: 0.8 + 0.3 * flicker }
    }

    /// The colour of a heat: black at 0, white at 1.
    fn color(&self, heat: f64) -> Color {
        let after = self.palette.iter().position(|(at, _)| heat < *at).unwrap_or(self.palette.len());
        match after {
            0 => self.palette[0].1,
            n if n == self.palette.len() => self.palette[n - 1].1,
            n => {
                let ((from, a), (to, b)) = (self.palette[n - 1], self.palette[n]);
                blend(a, b, (heat - from) / (to - from))
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::noise::Canvas;
    use super::*;
    use crate::size::Size;

    fn fire(tiling: Tiling, phi: f64) -> Fire {
        let canvas = Canvas { size: Size::new(60, 50), tiling, seed: 6 };
        let block = SolidBlock { canvas, feature: 15.0, depth: 0.0, depth_period: None };
        Fire::new(&block, &Parameters { phi: Some(phi), ..Parameters::default() })
    }

    fn texels() -> impl Iterator<Item = [f64; 2]> {
        (0..200).map(|k| [f64::from(k * 37 % 101) * 0.59, f64::from(k * 53 % 97) * 0.51])
    }

    #[test]
    fn flames_are_the_height_and_four_octaves_moved_by_phi() {
        let fire = fire(Tiling::Free, 0.4);
        for texel in texels() {
            let (x, z) = (texel[0] / 30.0, 1.0 - (texel[1] + 0.5) / 50.0);
            let mut f = z;
            for (i, (_, octave)) in fire.flicker.octaves().enumerate() {
                let factor = 2f64.powi(i as i32 + 1);
                f += octave.noise([factor * x, factor * z + 0.4, 0.0]) / factor;
            }
            assert!((fire.z(texel).1 + fire.flicker(texel) - f).abs() < 1e-9, "{texel:?}");
        }
    }

    #[test]
    fn a_phi_of_sixteen_closes_the_loop_and_a_smaller_one_does_not() {
        let difference = |phi: f64| {
            let (a, b) = (fire(Tiling::Torus, 0.0), fire(Tiling::Torus, phi));
            texels().map(|t| (a.flicker(t) - b.flicker(t)).abs()).fold(0.0, f64::max)
        };
        assert!(difference(16.0) < 1e-9);
        assert!(difference(1.5) > 0.1);
    }
}
