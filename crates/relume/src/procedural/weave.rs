//! A plain weave. Warp and weft yarns swing over and under each other along a cosine (F. T. Peirce, The
//! geometry of cloth structure, 1937, in the small-swing limit), have elliptic sections, and show the twist
//! of their fibres; the higher yarn is visible.

use super::noise::{Canvas, Fractal, Tiling};
use super::paint::{Color, PaintedTexel, Sampler, blend, scale, smoothstep, srgb};
use std::f64::consts::{PI, TAU};

/// The depth of the gaps between yarns, in pitches below the middle of the cloth.
const GAP: f64 = -0.36;

/// The direction of a yarn.
#[derive(Clone, Copy, PartialEq)]
enum Yarn {
    /// Along y.
    Warp,
    /// Along x.
    Weft,
}

/// The yarn at a position: its height above the middle of the cloth and the properties of its surface.
struct Strand {
    height: f64,
    twist: f64,
    shade: f64,
    yarn: Yarn,
}

/// A weave of one seed.
pub struct Weave {
    /// The distance between neighbouring yarns in texels.
    pitch: f64,
    /// Yarns per texel, along x and y.
    yarns_per_texel: [f64; 2],
    count: [i64; 2],
    canvas: Canvas,
    sway: [Fractal; 2],
    fuzz: Fractal,
    slub: Fractal,
    colors: [Color; 2],
}

impl Weave {
    /// Sets up the yarns: an even number on the torus, so that the pattern of over and under continues.
    pub fn new(canvas: &Canvas, feature: f64) -> Self {
        let pitch = 0.55 * feature;
        let sides = [canvas.size.width, canvas.size.height].map(|side| side as f64);
        let even = sides.map(|side| 2.0 * (side / (2.0 * pitch)).round().max(1.0));
        let (yarns_per_texel, count) = match canvas.tiling {
            Tiling::Torus => ([even[0] / sides[0], even[1] / sides[1]], even.map(|n| n as i64)),
            Tiling::Free => ([1.0 / pitch; 2], [i64::MAX; 2]),
        };
        Self {
            pitch,
            yarns_per_texel,
            count,
            canvas: *canvas,
            sway: [0, 1].map(|k| canvas.fractal(3.0 * pitch, 3, 10 + k)),
            fuzz: canvas.fractal(0.3 * pitch, 3, 12),
            slub: canvas.fractal(2.2 * pitch, 2, 13),
            colors: [srgb(0x2f5d8c), srgb(0xe6d3b1)],
        }
    }

    /// The material as a function of the texel.
    pub fn sampler(self) -> Box<Sampler> {
        Box::new(move |texel| self.sample(texel))
    }

    fn sample(&self, texel: [f64; 2]) -> PaintedTexel {
        let sway = self.sway.each_ref().map(|noise| 0.09 * noise.at(texel));
        let u = texel[0] * self.yarns_per_texel[0] + sway[0];
        let v = texel[1] * self.yarns_per_texel[1] + sway[1];
        let thickness = 1.0 + 0.1 * self.slub.at(texel);
        let warp = self.strand(Yarn::Warp, u, v, thickness);
        let weft = self.strand(Yarn::Weft, v, u, thickness);
        let top = if warp.height > weft.height { warp } else { weft };
        let fuzz = self.fuzz.at(texel);
        let height = self.pitch * (top.height.max(GAP) + 0.035 * top.twist + 0.02 * fuzz);
        let color = self.colors[usize::from(top.yarn == Yarn::Weft)];
        let buried = smoothstep(0.0, 0.38, top.height);
        let shade = top.shade * (0.9 + 0.12 * top.twist + 0.08 * fuzz) * (0.4 + 0.6 * buried);
        let albedo = blend(scale(color, shade), [0.6, 0.58, 0.54], 0.03 + 0.05 * fuzz.max(0.0));
        PaintedTexel { height, albedo, roughness: 0.62 + 0.1 * fuzz }
    }

    /// The yarn whose column is `across`, at `along`; lengths in pitches.
    fn strand(&self, yarn: Yarn, across: f64, along: f64, thickness: f64) -> Strand {
        let column = across.floor();
        let index = column as i64;
        let (layer, count, over) = match yarn {
            Yarn::Warp => (1, self.count[0], 1.0),
            Yarn::Weft => (2, self.count[1], -1.0),
        };
        let number = index.rem_euclid(count);
        let random = |k: i64| self.canvas.random(layer, number, k);
        let parity = if index.rem_euclid(2) == 0 { over } else { -over };
        let swing = 0.25 * parity * (PI * (along - 0.5)).cos();

        let half_width = 0.5 * thickness * (0.95 + 0.1 * random(0));
        let offset = across - column - 0.5 + 0.06 * (random(1) - 0.5);
        let q = (offset / half_width) * (offset / half_width);
        let round = (1.0 - q).max(0.0).sqrt();
        let height = if q < 1.0 { swing + 0.36 * round - 0.16 } else { f64::NEG_INFINITY };

        let lay = if yarn == Yarn::Warp { 2.0 } else { -2.0 };
        let around = (offset / half_width).clamp(-1.0, 1.0).asin() / PI;
        let twist = (TAU * (2.0 * around + lay * along + 0.5 * random(2))).sin() * round;
        Strand { height, twist, shade: 0.82 + 0.3 * random(3), yarn }
    }
}
