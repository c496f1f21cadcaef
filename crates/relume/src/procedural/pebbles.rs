//! A bed of rounded stones over sand: ellipsoids of three sizes around the feature points of cellular noise,
//! of which the highest is visible. Each stone has its own outline, tilt, colour and polish.

use super::noise::{Canvas, Fractal, NoiseLattice, Site};
use super::paint::{Color, PaintedTexel, Sampler, blend, dome, scale, smoothstep, srgb};

/// Stones of one size.
struct Stones {
    lattice: NoiseLattice,
    /// Side of a cell in texels.
    cell: f64,
    /// Height of the centres of the stones in texels.
    level: f64,
}

/// A bed of one seed.
pub struct Pebbles {
    feature: f64,
    layers: Vec<Stones>,
    outline: [Fractal; 2],
    lumps: Fractal,
    speckle: Fractal,
    veins: Fractal,
    sand: Fractal,
    palette: [Color; 8],
    sand_color: Color,
}

/// The stone visible at a position.
struct Seen {
    site: Site,
    height: f64,
    /// Squared distance from the centre of the stone in radii.
    q: f64,
}

impl Pebbles {
    /// Sets up the noise.
    pub fn new(canvas: &Canvas, feature: f64) -> Self {
        let layer = |(k, (size, level)): (usize, (f64, f64))| Stones {
            lattice: canvas.lattice(size * feature, 10 + k as u64),
            cell: size * feature,
            level: level * feature,
        };
        let sizes = [(1.0, 0.12), (0.62, -0.05), (0.36, -0.14), (0.2, -0.17)];
        Self {
            feature,
            layers: sizes.into_iter().enumerate().map(layer).collect(),
            outline: [0, 1].map(|k| canvas.fractal(0.5 * feature, 2, 20 + k)),
            lumps: canvas.fractal(0.35 * feature, 4, 22),
            speckle: canvas.fractal(0.07 * feature, 2, 23),
            veins: canvas.fractal(0.8 * feature, 3, 24),
            sand: canvas.fractal(0.09 * feature, 3, 25),
            palette: [0x8d8579, 0x6f7276, 0xa9a094, 0x7a5a48, 0x55575a, 0xc9c2b4, 0x94705a, 0x5f6b6a]
                .map(srgb),
            sand_color: srgb(0x6b5d4a),
        }
    }

    /// The material as a function of the texel.
    pub fn sampler(self) -> Box<Sampler> {
        Box::new(move |texel| self.sample(texel))
    }

    fn sample(&self, texel: [f64; 2]) -> PaintedTexel {
        let bend = self.outline.each_ref().map(|noise| 0.05 * self.feature * noise.at(texel));
        let bent = [texel[0] + bend[0], texel[1] + bend[1]];
        let sand = self.sand.at(texel);
        let floor = self.feature * (-0.17 + 0.02 * sand);
        let stones = self.layers.iter().flat_map(|layer| layer.stones(bent));
        let top = stones.max_by(|a, b| a.height.total_cmp(&b.height));
        match top.filter(|stone| stone.height > floor) {
            Some(stone) => self.stone(texel, &stone),
            None => PaintedTexel {
                height: floor,
                albedo: scale(self.sand_color, 0.8 + 0.3 * sand),
                roughness: 0.95,
            },
        }
    }

    fn stone(&self, texel: [f64; 2], stone: &Seen) -> PaintedTexel {
        let lumps = self.lumps.at(texel);
        let speckle = self.speckle.at(texel);
        let site = &stone.site;
        let pick = |k: u64| self.palette[(site.random(k) * self.palette.len() as f64) as usize];
        let mottled = blend(pick(10), pick(11), 0.3 * site.random(12) + 0.25 * lumps);
        // One stone in four is veined with quartz.
        let vein = smoothstep(0.93, 1.0, 1.0 - self.veins.at(texel).abs())
            * f64::from(u8::from(site.random(13) < 0.25));
        let color = blend(mottled, srgb(0xd8d3c8), 0.6 * vein);
        let grain = 1.0 + 0.3 * speckle * site.random(14) + 0.12 * lumps;
        let dusty = smoothstep(0.7, 1.0, stone.q);
        let albedo = blend(scale(color, grain * (0.8 + 0.4 * site.random(15))), self.sand_color, 0.5 * dusty);
        let polish = 0.35 + 0.35 * site.random(16);
        PaintedTexel {
            height: stone.height + self.feature * (0.022 * lumps + 0.004 * speckle),
            albedo,
            roughness: polish + 0.25 * dusty + 0.06 * speckle,
        }
    }
}

impl Stones {
    fn stones(&self, texel: [f64; 2]) -> impl Iterator<Item = Seen> + '_ {
        self.lattice.sites(texel).filter_map(|site| self.seen(site))
    }

    fn seen(&self, site: Site) -> Option<Seen> {
        let radius = 0.42 + 0.22 * site.random(3);
        let slender = 0.75 + 0.25 * site.random(4);
        let (sine, cosine) = (std::f64::consts::TAU * site.random(5)).sin_cos();
        let [x, y] = site.offset;
        let along = (cosine * x + sine * y) / radius;
        let across = (cosine * y - sine * x) / (radius * slender);
        let q = along * along + across * across;
        // Squarer than an ellipse: real pebbles are worn blocks.
        let q = 0.6 * q + 0.4 * (along.powi(4) + across.powi(4)).sqrt();
        let tilt = 0.12 * ((site.random(6) - 0.5) * along + (site.random(7) - 0.5) * across);
        let thickness = radius * slender * (0.55 + 0.2 * site.random(8));
        let height = self.level
            + self.cell * (thickness * dome(q, 0.55) + tilt - 0.3 * radius + 0.12 * site.random(9));
        (q < 1.0).then_some(Seen { site, height, q })
    }
}
