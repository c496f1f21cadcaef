//! A natural sponge: pores of four sizes sunk into a gently undulating body. The pores of each layer are as
//! deep as they are wide and cut into the remains of the larger layers, so small holes open in the walls of
//! large ones. Lengths are fractions of the feature size, the distance between large pores.

use super::noise::{Canvas, Fractal, NoiseLattice};
use super::paint::{Color, PaintedTexel, Sampler, blend, dome, scale, smoothstep, srgb};

/// Pores of one size.
struct Pores {
    lattice: NoiseLattice,
    /// Side of a cell in texels.
    cell: f64,
    /// Fraction of the cells that have a pore.
    density: f64,
}

/// A sponge of one seed.
pub struct Sponge {
    feature: f64,
    layers: Vec<Pores>,
    bend: [Fractal; 2],
    body: Fractal,
    fibres: Fractal,
    tint: Fractal,
    pale: Color,
    ochre: Color,
    deep: Color,
}

impl Sponge {
    /// Sets up the noise.
    pub fn new(canvas: &Canvas, feature: f64) -> Self {
        let densities = [0.85, 0.7, 0.5, 0.3];
        let layer = |(k, density): (usize, f64)| {
            let cell = feature * [1.0, 0.55, 0.3, 0.16][k];
            Pores { lattice: canvas.lattice(cell, 10 + k as u64), cell, density }
        };
        Self {
            feature,
            layers: densities.into_iter().enumerate().map(layer).collect(),
            bend: [0, 1].map(|k| canvas.fractal(0.5 * feature, 3, 20 + k)),
            body: canvas.fractal(2.5 * feature, 3, 30),
            fibres: canvas.fractal(0.14 * feature, 3, 31),
            tint: canvas.fractal(1.6 * feature, 4, 32),
            pale: srgb(0xf6dd9c),
            ochre: srgb(0xe0ab52),
            deep: srgb(0xa05a1e),
        }
    }

    /// The material as a function of the texel.
    pub fn sampler(self) -> Box<Sampler> {
        Box::new(move |texel| self.sample(texel))
    }

    fn sample(&self, texel: [f64; 2]) -> PaintedTexel {
        let bend = self.bend.each_ref().map(|noise| 0.06 * self.feature * noise.at(texel));
        let bent = [texel[0] + bend[0], texel[1] + bend[1]];
        let sunk: f64 = self.layers.iter().map(|pores| pores.depth(bent)).sum();
        let fibres = self.fibres.at(texel);
        let height = self.feature * (0.1 * self.body.at(texel) + 0.011 * fibres) - sunk;

        let depth = smoothstep(0.0, 0.45, sunk / self.feature);
        let body = blend(self.ochre, self.pale, 0.5 + 0.35 * self.tint.at(texel) + 0.2 * fibres);
        let albedo = scale(blend(body, self.deep, 0.75 * depth), 1.0 + 0.08 * fibres);
        PaintedTexel { height, albedo, roughness: 0.82 + 0.1 * fibres }
    }
}

impl Pores {
    /// Depth below the body in texels: that of the deepest pore around the position.
    fn depth(&self, texel: [f64; 2]) -> f64 {
        let depths = self.lattice.sites(texel).filter(|site| site.random(3) < self.density).map(|site| {
            let radius = 0.2 + 0.3 * site.random(4);
            let slender = 0.75 + 0.5 * site.random(5);
            let [x, y] = site.offset;
            let q = (x * x * slender + y * y / slender) / (radius * radius);
            self.cell * radius * (0.6 + 0.45 * site.random(6)) * dome(q, 0.8)
        });
        depths.fold(0.0, f64::max)
    }
}
