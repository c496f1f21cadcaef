//! Grained leather: plump cells of two sizes between creases (the Voronoi borders of cellular noise on a
//! warped plane), hair pores, and a few long folds. High parts of the grain are worn, lighter and smoother.

use super::noise::{Canvas, Fractal, NoiseLattice};
use super::paint::{Color, PaintedTexel, Sampler, blend, dome, scale, smoothstep, srgb};

/// Leather of one seed.
pub struct Leather {
    feature: f64,
    grain: NoiseLattice,
    fine: NoiseLattice,
    pores: NoiseLattice,
    bend: [Fractal; 2],
    folds: Fractal,
    tint: Fractal,
    skin: Fractal,
    dark: Color,
    brown: Color,
    worn: Color,
}

impl Leather {
    /// Sets up the noise.
    pub fn new(canvas: &Canvas, feature: f64) -> Self {
        Self {
            feature,
            grain: canvas.lattice(0.6 * feature, 1),
            fine: canvas.lattice(0.27 * feature, 2),
            pores: canvas.lattice(0.3 * feature, 3),
            bend: [0, 1].map(|k| canvas.fractal(0.8 * feature, 3, 10 + k)),
            folds: canvas.fractal(2.6 * feature, 3, 12),
            tint: canvas.fractal(1.8 * feature, 4, 13),
            skin: canvas.fractal(0.12 * feature, 3, 14),
            dark: srgb(0x2e160c),
            brown: srgb(0x8a4a24),
            worn: srgb(0xb9733c),
        }
    }

    /// The material as a function of the texel.
    pub fn sampler(self) -> Box<Sampler> {
        Box::new(move |texel| self.sample(texel))
    }

    fn sample(&self, texel: [f64; 2]) -> PaintedTexel {
        let bend = self.bend.each_ref().map(|noise| 0.13 * self.feature * noise.at(texel));
        let bent = [texel[0] + bend[0], texel[1] + bend[1]];
        let grain = self.grain.nearest(bent);
        let fine = self.fine.nearest(bent);
        let plump = swell(grain.border, 0.3) * (0.8 + 0.4 * grain.first.random(7));
        let crease = swell(fine.border, 0.22);
        let fold = smoothstep(0.9, 1.0, 1.0 - self.folds.at(texel).abs());
        let pore = self.pore(bent);
        let skin = self.skin.at(texel);

        let relief = 0.1 * plump + 0.045 * crease * (0.4 + 0.6 * plump) - 0.05 * fold - 0.05 * pore;
        let height = self.feature * (relief + 0.007 * skin + 0.04 * self.folds.at(texel));
        let raised = (0.55 * plump + 0.45 * crease * plump) * (1.0 - 0.5 * fold) * (1.0 - 0.7 * pore);
        let tint = self.tint.at(texel);
        let base = blend(self.dark, self.brown, 0.15 + 0.95 * raised + 0.12 * tint);
        let worn = smoothstep(0.55, 1.1, raised + 0.35 * tint);
        let albedo = scale(blend(base, self.worn, 0.75 * worn), 1.0 + 0.08 * skin);
        PaintedTexel { height, albedo, roughness: 0.6 - 0.2 * raised + 0.06 * skin + 0.06 * tint }
    }

    /// Hair pores: 1 in the middle of a pore.
    fn pore(&self, texel: [f64; 2]) -> f64 {
        let pores = self.pores.sites(texel).filter(|site| site.random(3) < 0.35);
        pores.map(|site| dome((site.distance() / 0.16).powi(2), 1.0)).fold(0.0, f64::max)
    }
}

/// From 0 on a border to 1 at `width` cells from it, round on top.
fn swell(border: f64, width: f64) -> f64 {
    let inward = (1.0 - border / width).max(0.0);
    (1.0 - inward * inward).sqrt()
}
