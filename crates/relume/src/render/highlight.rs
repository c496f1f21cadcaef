//! Highlights that a function of light alone cannot move with the viewer: a GGX lobe.

use super::vector::{Vec3, length};
use crate::microfacet;

/// Highlights added from the normals of the texture: a GGX lobe.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Specular {
    /// Reflectance at normal incidence, 0 to 1; 0.04 for plastic, 0 turns highlights off.
    pub strength: f64,
    /// The square root of the GGX alpha, [`LEAST_ROUGHNESS`](crate::microfacet::LEAST_ROUGHNESS) to 1.
    pub roughness: f64,
}

impl Default for Specular {
    /// Plastic, rough enough to stay subtle: straight on, 8 % of a white matt surface.
    fn default() -> Self {
        Self { strength: 0.04, roughness: 0.6 }
    }
}

impl Specular {
    /// The light reflected by a GGX surface to the viewer under a unit light, in units where a white matt surface
    /// reflects the cosine: pi D V F cos.
    pub(super) fn lobe(&self, normal: Vec3, to_light: Vec3, to_viewer: Vec3) -> f64 {
        let (n_l, n_v) = (normal.dot(to_light), normal.dot(to_viewer));
        let half = to_light + to_viewer;
        if n_l <= 0.0 || n_v <= 0.0 || length(half) < 1e-9 {
            return 0.0;
        }
        let half = half * (1.0 / length(half));
        let (n_h, l_h) = (normal.dot(half), to_light.dot(half));
        microfacet::specular(n_l, n_v, n_h, l_h, microfacet::alpha(self.roughness), self.strength) * n_l
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::numeric::quadrature::integrate_hemisphere;

    const UP: Vec3 = Vec3::new(0.0, 0.0, 1.0);

    #[test]
    fn highlights_are_reciprocal_and_reflect_no_more_than_they_get() {
        for roughness in [0.4, 0.7, 1.0] {
            let mirror = Specular { strength: 1.0, roughness };
            let viewer = Vec3::new(0.5, 0.2, 0.8).unit().unwrap();
            let light = Vec3::new(-0.3, 0.6, 0.4).unit().unwrap();
            let (there, back) = (mirror.lobe(UP, light, viewer), mirror.lobe(UP, viewer, light));
            assert!((there / light.z - back / viewer.z).abs() < 1e-9);
            let reflected =
                integrate_hemisphere(64, |w| mirror.lobe(UP, w.into(), viewer)) / std::f64::consts::PI;
            assert!(reflected < 1.0, "roughness {roughness}: {reflected}");
        }
        // With alpha 1 and the viewer straight above, the integral is that of l / (1 + l).
        let mirror = Specular { strength: 1.0, roughness: 1.0 };
        let reflected = integrate_hemisphere(64, |w| mirror.lobe(UP, w.into(), UP)) / std::f64::consts::PI;
        assert!((reflected - (1.0 - 2f64.ln())).abs() < 1e-9, "{reflected}");
    }

    #[test]
    fn the_lobe_is_centred_on_the_mirrored_direction() {
        let specular = Specular { strength: 0.04, roughness: 0.2 };
        let viewer = Vec3::new(0.3, 0.0, 0.9).unit().unwrap();
        let mirrored = Vec3::new(-viewer.x, 0.0, viewer.z);
        let beside = (mirrored + Vec3::new(0.0, 0.3, 0.0)).unit().unwrap();
        assert!(specular.lobe(UP, mirrored, viewer) > 10.0 * specular.lobe(UP, beside, viewer));
        assert_eq!(specular.lobe(UP, Vec3::new(0.0, 0.6, -0.8), viewer), 0.0);
        // Straight on, the lobe has the height F / (4 alpha^2), and a white matt surface 1.
        let top = specular.lobe(UP, UP, UP);
        assert!((top - 0.04 / (4.0 * 0.2f64.powi(4))).abs() < 1e-9, "{top}");
    }
}
