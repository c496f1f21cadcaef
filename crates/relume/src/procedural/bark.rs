//! Bark: long plates along the trunk (y) between fissures, which run where a stretched and bent
//! noise passes through zero; cross cracks, layered ridges on the plates, patches of lichen.

use super::noise::{Canvas, Fractal, NoiseLattice};
use super::paint::{Color, PaintedTexel, Sampler, blend, scale, smoothstep, srgb};

/// Bark of one seed.
pub struct Bark {
    feature: f64,
    plates: Fractal,
    cracks: NoiseLattice,
    bend: [Fractal; 2],
    ridges: Fractal,
    grain: Fractal,
    moss: Fractal,
    fissure: Color,
    inner: Color,
    outer: Color,
    lichen: Color,
}

impl Bark {
    /// Sets up the noise.
    pub fn new(canvas: &Canvas, feature: f64) -> Self {
        Self {
            feature,
            plates: canvas.stretched_fractal([0.75 * feature, 2.6 * feature], 2, 1),
            cracks: canvas.stretched_lattice([0.55 * feature, 0.5 * feature], 2),
            bend: [0, 1].map(|k| canvas.stretched_fractal([0.7 * feature, 1.1 * feature], 2, 10 + k)),
            ridges: canvas.stretched_fractal([0.4 * feature, 1.3 * feature], 4, 12),
            grain: canvas.stretched_fractal([0.12 * feature, 0.22 * feature], 3, 13),
            moss: canvas.fractal(1.5 * feature, 5, 14),
            fissure: srgb(0x3d281c),
            inner: srgb(0x865a3c),
            outer: srgb(0xb3a08b),
            lichen: srgb(0xa3ad84),
        }
    }

    /// The material as a function of the texel.
    pub fn sampler(self) -> Box<Sampler> {
        Box::new(move |texel| self.sample(texel))
    }

    fn sample(&self, texel: [f64; 2]) -> PaintedTexel {
        let bend = self.bend.each_ref().map(|noise| noise.at(texel));
        let bent = [texel[0] + 0.2 * self.feature * bend[0], texel[1] + 0.35 * self.feature * bend[1]];
        let plate = self.plates.at(bent).abs();
        let crack = self.cracks.nearest(bent);
        let grain = self.grain.at(texel);
        let ridges = self.ridges.ridges(texel) - 1.2;

        let rise = smoothstep(0.0, 0.32, plate + 0.04 * grain).sqrt();
        let split = smoothstep(0.0, 0.1, crack.border + 0.025 * grain);
        let layers = 0.82 + 0.3 * crack.first.random(8);
        let top = rise * (layers * (0.75 + 0.25 * split) + 0.3 * ridges);
        let height = self.feature * (0.3 * top + 0.014 * grain);

        let bared = blend(self.fissure, self.inner, smoothstep(0.05, 0.7, top));
        let weathered = smoothstep(0.45, 0.95, top + 0.1 * grain);
        let wood = blend(bared, self.outer, 0.85 * weathered * (0.75 + 0.25 * split));
        let patch = smoothstep(0.25, 0.5, self.moss.at(texel) + 0.12 * grain) * weathered;
        let albedo = scale(blend(wood, self.lichen, 0.7 * patch), 1.0 + 0.16 * grain + 0.12 * ridges);
        PaintedTexel { height, albedo, roughness: 0.85 + 0.08 * grain }
    }
}
