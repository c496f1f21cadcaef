//! Wood, f = x^2 + y^2 + n(x, y, z): annual rings around the axis z of a trunk, wherever the square root of f
//! is a whole number of ring widths. There are four rings per feature size.
//!
//! A picture shows the *end* of the trunk, or a *plank* sawn along it, whose grain runs upwards in the
//! picture. On the torus the distance x from the pith becomes the chord (P / pi) sin(pi x / P), where P is
//! the side of the picture: equal to x near the pith, smooth, and with the period P, so that tiles look like
//! adjacent boards or trunks.

use super::noise::Tiling;
use super::paint::{Color, PaintedTexel, Sampler, blend, scale, smoothstep, srgb};
use super::parameters::{Cut, Parameters};
use super::solid::{SolidBlock, SolidFractal, SolidLattice};
use std::f64::consts::PI;

/// Rings per feature size.
const RINGS: f64 = 4.0;
/// The distance of a plank at depth 0 from the pith, in rings: close enough for the grain to arch.
const PLANK_DEPTH: f64 = 2.0;

/// Wood of one seed.
pub struct Wood {
    ring: f64,
    /// The lengths of both sides of the picture, in rings.
    sides: [f64; 2],
    tiling: Tiling,
    cut: Cut,
    /// Depth of the picture in rings.
    depth: f64,
    strength: f64,
    bend: SolidLattice,
    fibres: SolidFractal,
    pores: SolidFractal,
    tint: SolidFractal,
    early: Color,
    late: Color,
    pore: Color,
}

impl Wood {
    /// Sets up the noise.
    pub fn new(block: &SolidBlock, parameters: &Parameters) -> Self {
        let (feature, size) = (block.feature, block.canvas.size);
        let (ring, cut) = (feature / RINGS, parameters.cut.unwrap_or(Cut::Plank));
        // Everything is longer along the grain.
        let long = |across: f64, times: f64| match cut {
            Cut::Plank => [across, times * across, across],
            Cut::End => [across, across, times * across],
        };
        Self {
            ring,
            sides: [size.width as f64 / ring, size.height as f64 / ring],
            tiling: block.canvas.tiling,
            cut,
            depth: RINGS * block.depth,
            strength: parameters.turbulence.unwrap_or(14.0),
            bend: block.lattice(long(1.6 * feature, 2.5), 1),
            fibres: block.fractal(long(0.09 * feature, 14.0), (0, 2), 2),
            pores: block.fractal(long(0.05 * feature, 18.0), (0, 1), 3),
            tint: block.fractal(long(0.9 * feature, 5.0), (0, 3), 4),
            early: srgb(0xd9a86c),
            late: srgb(0x8a5228),
            pore: srgb(0x4a2a14),
        }
    }

    /// The material as a function of the texel.
    pub fn sampler(self) -> Box<Sampler> {
        Box::new(move |texel| self.sample(texel))
    }

    /// x^2 + y^2 + n, in square ring widths.
    fn field(&self, texel: [f64; 2]) -> f64 {
        let x = self.pith_distance(texel[0], 0);
        let y = match self.cut {
            Cut::Plank => self.depth + PLANK_DEPTH,
            Cut::End => self.pith_distance(texel[1], 1),
        };
        x * x + y * y + self.strength * self.bend.noise(self.bend.cells(texel))
    }

    /// The distance from the pith, which is in the middle of the picture, in rings.
    fn pith_distance(&self, texel: f64, axis: usize) -> f64 {
        let side = self.sides[axis];
        let distance = texel / self.ring - 0.5 * side;
        match self.tiling {
            Tiling::Torus => side / PI * (PI * distance / side).sin(),
            Tiling::Free => distance,
        }
    }

    fn sample(&self, texel: [f64; 2]) -> PaintedTexel {
        let age = self.field(texel).max(0.0).sqrt();
        let fibres = self.fibres.at(texel);
        let tint = self.tint.at(texel);
        // The wood of a year darkens slowly and ends abruptly.
        let season = age + 0.05 * fibres;
        let late = smoothstep(0.25, 0.95, season.fract()) * (1.0 - smoothstep(0.95, 1.0, season.fract()));
        let pore = smoothstep(0.25, 0.6, self.pores.at(texel)) * (1.0 - 0.6 * late);
        let year = 0.85 + 0.15 * (2.4 * age.floor()).sin();
        let ground =
            scale(blend(self.early, self.late, 0.75 * late * year), 1.0 + 0.22 * tint + 0.12 * fibres);
        let albedo = blend(ground, self.pore, 0.55 * pore);
        // Summer wood is hard and stands out where the surface is worn.
        let height = 4.0 * self.ring * (0.05 * late + 0.018 * fibres - 0.05 * pore + 0.02 * tint);
        PaintedTexel { height, albedo, roughness: 0.5 + 0.2 * pore - 0.1 * late + 0.1 * fibres }
    }
}

#[cfg(test)]
mod tests {
    use super::super::noise::Canvas;
    use super::*;
    use crate::size::Size;

    fn wood(tiling: Tiling, cut: Cut) -> Wood {
        let canvas = Canvas { size: Size::new(64, 48), tiling, seed: 4 };
        let block = SolidBlock { canvas, feature: 20.0, depth: 0.3, depth_period: None };
        let parameters = Parameters { cut: Some(cut), turbulence: Some(6.0), ..Parameters::default() };
        Wood::new(&block, &parameters)
    }

    #[test]
    fn rings_are_the_squares_of_x_and_y_and_noise() {
        for (cut, stretch) in [(Cut::Plank, [1.0, 2.5, 1.0]), (Cut::End, [1.0, 1.0, 2.5])] {
            let wood = wood(Tiling::Free, cut);
            for k in 0..200 {
                let texel = [f64::from(k * 37 % 101) * 0.7, f64::from(k * 53 % 97) * 0.6];
                let place = [texel[0], texel[1], 0.3 * 20.0];
                let cells: [f64; 3] = std::array::from_fn(|a| place[a] / (32.0 * stretch[a]));
                let x = (texel[0] - 32.0) / 5.0;
                let y = if cut == Cut::Plank { 0.3 * 4.0 + 2.0 } else { (texel[1] - 24.0) / 5.0 };
                let truth = x * x + y * y + 6.0 * wood.bend.noise(cells);
                assert!((wood.field(texel) - truth).abs() < 1e-9, "{cut:?} {texel:?}");
            }
        }
    }

    #[test]
    fn a_tile_is_the_free_plane_near_the_pith() {
        let distance = |tiling, x: f64| wood(tiling, Cut::End).pith_distance(x, 0);
        for x in [30.0, 32.0, 33.5] {
            let (tile, plane) = (distance(Tiling::Torus, x), distance(Tiling::Free, x));
            assert!((tile - plane).abs() < 2e-3 * (1.0 + plane.abs()), "{x}: {tile} and {plane}");
        }
        assert!((distance(Tiling::Torus, 10.0).abs() - distance(Tiling::Torus, 74.0).abs()).abs() < 1e-9);
    }
}
