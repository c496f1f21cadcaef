//! The light that a point of the surface sends to the viewer.
//!
//! A dielectric is a diffuse body under a glossy surface ([`crate::microfacet`]). Bare metal has no body: its gloss
//! has the colour of the albedo. A metallic share between 0 and 1 mixes the two by its weight, as in the glTF 2.0
//! specification (Khronos, 2021, appendix B).

use super::Surface;
use crate::direction::{Direction, Directions};
use crate::microfacet;

/// The least cosine between a normal and the viewer: a normal interpolated over an edge, or that of a map, may turn
/// away although its point is seen.
const LEAST_VIEW_COSINE: f64 = 1e-4;

/// What the reflection of a point depends on besides the light that arrives.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct ReflectingPoint {
    /// The unit normal: x right, y up, z out.
    pub normal: [f32; 3],
    /// Linear reflectance of the body; of the surface, where it is metal.
    pub albedo: [f32; 3],
    /// The square root of alpha.
    pub roughness: f32,
    /// The share of bare metal.
    pub metallic: f32,
}

impl ReflectingPoint {
    /// The cosine at which a lamp shines onto the point, 0 from behind.
    pub fn cosine(&self, light: Direction) -> f32 {
        let [x, y, z] = light.to_array().map(|c| c as f32);
        let [nx, ny, nz] = self.normal;
        (nx * x + ny * y + nz * z).max(0.0)
    }

    /// The light sent to the viewer, given the irradiance from the lamp, cosine included, and that from the
    /// surroundings.
    pub fn reflected(
        &self,
        surface: Surface,
        directions: Directions,
        lamp: f32,
        indirect: [f32; 3],
    ) -> [f32; 3] {
        let albedo = self.albedo;
        let Surface::Ggx { f0 } = surface else {
            return std::array::from_fn(|k| albedo[k] * (lamp + indirect[k]));
        };
        let lobe = Lobe::new(self, directions);
        let dielectric = self.dielectric(&lobe, f0, lamp, indirect);
        if self.metallic <= 0.0 {
            return dielectric;
        }
        std::array::from_fn(|k| {
            // Surroundings are reflected as by a rough metal, evenly.
            let metal = lobe.glossy(lamp, f64::from(albedo[k])) + albedo[k] * indirect[k];
            dielectric[k] + (metal - dielectric[k]) * self.metallic
        })
    }

    fn dielectric(&self, lobe: &Lobe, f0: f64, lamp: f32, indirect: [f32; 3]) -> [f32; 3] {
        // The cosine-weighted mean of Schlick's term over all directions is f0 + (1 - f0) / 21.
        let around = (1.0 - microfacet::fresnel(lobe.n_v, f0)) * (1.0 - f0) * 20.0 / 21.0;
        let body = (f64::from(lamp) * microfacet::body_share(lobe.n_l, lobe.n_v, f0)) as f32;
        let glossy = lobe.glossy(lamp, f0);
        std::array::from_fn(|k| self.albedo[k] * (body + around as f32 * indirect[k]) + glossy)
    }
}

/// The cosines of a highlight, and its width.
struct Lobe {
    n_l: f64,
    n_v: f64,
    n_h: f64,
    l_h: f64,
    alpha: f64,
}

impl Lobe {
    fn new(point: &ReflectingPoint, Directions { light, view }: Directions) -> Self {
        let normal = point.normal.map(f64::from);
        let dot = |v: [f64; 3]| normal[0] * v[0] + normal[1] * v[1] + normal[2] * v[2];
        let (to_light, to_viewer) = (dot(light.to_array()), dot(view.to_array()));
        // Halfway between the light and the viewer: of both cosines as they are, or it is no cosine.
        let l_h = (0.5 * (1.0 + light.dot(view))).sqrt();
        let n_h = (to_light + to_viewer) / (2.0 * l_h);
        let (n_l, n_v) = (to_light.max(0.0), to_viewer.max(LEAST_VIEW_COSINE));
        Self { n_l, n_v, n_h, l_h, alpha: microfacet::alpha(f64::from(point.roughness)) }
    }

    /// The highlight of a lamp of the given irradiance.
    fn glossy(&self, lamp: f32, f0: f64) -> f32 {
        if lamp <= 0.0 {
            return 0.0;
        }
        let Self { n_l, n_v, n_h, l_h, alpha } = *self;
        (f64::from(lamp) * microfacet::specular(n_l, n_v, n_h, l_h, alpha, f0)) as f32
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::numeric::quadrature::integrate_hemisphere;
    use std::f64::consts::PI;

    const GLOSSY: Surface = Surface::Ggx { f0: microfacet::DIELECTRIC_F0 };

    fn point(metallic: f32) -> ReflectingPoint {
        ReflectingPoint { normal: [0.0, 0.0, 1.0], albedo: [0.9, 0.5, 0.2], roughness: 0.5, metallic }
    }

    #[test]
    fn light_and_viewer_may_be_exchanged() {
        let tilted = ReflectingPoint { normal: [0.36, -0.48, 0.8], ..point(0.3) };
        for (a, b) in [((0.2, 1.0), (1.1, 5.4)), ((0.9, 5.6), (0.3, 4.0)), ((1.0, 0.1), (1.0, 5.7))] {
            let [a, b] = [a, b].map(|(polar, azimuth)| Direction::from_angles(polar, azimuth));
            let one = tilted.reflected(GLOSSY, Directions { light: a, view: b }, 1.0, [0.0; 3]);
            let other = tilted.reflected(GLOSSY, Directions { light: b, view: a }, 1.0, [0.0; 3]);
            assert!(one.iter().zip(other).all(|(a, b)| (a - b).abs() < 1e-5 * a), "{one:?} {other:?}");
        }
    }

    #[test]
    fn a_metal_reflects_its_colour_only_and_no_more_than_arrives() {
        for polar in [0.1, 0.8, 1.3] {
            let view = Direction::from_angles(polar, 0.7);
            for k in 0..3 {
                let metal = point(1.0);
                let sum = integrate_hemisphere(200, |light| {
                    let lamp = metal.cosine(light);
                    f64::from(metal.reflected(GLOSSY, Directions { light, view }, lamp, [0.0; 3])[k]) / PI
                });
                let f0 = f64::from(metal.albedo[k]);
                assert!(sum < 1.0 && sum > 0.7 * f0, "{polar} channel {k}: {sum}");
            }
        }
        // From the mirror direction at the zenith: the albedo is the reflectance of the lobe.
        let straight = Directions { light: Direction::ZENITH, view: Direction::ZENITH };
        let [red, green, blue] = point(1.0).reflected(GLOSSY, straight, 1.0, [0.0; 3]);
        assert!((red / green - 1.8).abs() < 1e-5 && (green / blue - 2.5).abs() < 1e-5);
    }

    /// A fault: the half vector's cosine was that of a clamped viewer, above 1 where a normal turns away from the viewer
    /// and lamp and viewer stand opposite, and the density of normals has a pole there: values of 8e5.
    #[test]
    fn highlights_of_normals_that_turn_away_are_bounded() {
        let (light, view) =
            (Direction::from_angles(1.3, 0.0), Direction::from_angles(1.3, std::f64::consts::PI));
        for i in 0..=900 {
            let tilt = 1.5 * f64::from(i) / 900.0;
            let normal = [tilt.sin() as f32, 0.0, tilt.cos() as f32];
            let turned = ReflectingPoint { normal, ..point(0.0) };
            let lobe = Lobe::new(&turned, Directions { light, view });
            assert!(lobe.n_h <= 1.0 + 1e-6, "tilt {tilt}: a cosine of {}", lobe.n_h);
            let sent = turned.reflected(GLOSSY, Directions { light, view }, turned.cosine(light), [0.0; 3]);
            assert!(sent.iter().all(|v| *v < 200.0), "tilt {tilt}: {sent:?}");
        }
    }

    #[test]
    fn a_metallic_share_mixes_both_kinds() {
        let directions =
            Directions { light: Direction::from_angles(0.5, 0.0), view: Direction::from_angles(0.7, 3.0) };
        let of = |metallic: f32| point(metallic).reflected(GLOSSY, directions, 0.8, [0.1, 0.2, 0.3]);
        let (none, half, all) = (of(0.0), of(0.5), of(1.0));
        (0..3).for_each(|k| assert!((half[k] - 0.5 * (none[k] + all[k])).abs() < 1e-6));
    }

    #[test]
    fn a_normal_that_turns_away_from_the_viewer_gives_finite_light() {
        let away = ReflectingPoint { normal: [-1.0, 0.0, 0.0], ..point(0.5) };
        let directions =
            Directions { light: Direction::from_angles(1.3, PI), view: Direction::from_angles(1.3, 0.0) };
        let light = away.reflected(GLOSSY, directions, away.cosine(directions.light), [0.1; 3]);
        assert!(light.iter().all(|v| v.is_finite() && *v >= 0.0), "{light:?}");
    }
}
