//! A glossy dielectric on a tilted facet ([`crate::microfacet`]), as artists' programs shade it: base colour, normal,
//! roughness, and the reflectance of the surface at normal incidence (0.04 of most materials).
//!
//! Numbers of a texel: the base colour of each channel, x and y of the unit normal, roughness, specular reflectance.

use super::TexelNumbers;
use crate::direction::Directions;
use crate::microfacet;

/// The least cosine between a normal and the viewer, as of virtual photographs.
const LEAST_VIEW_COSINE: f64 = 1e-4;

/// Numbers beside the base colour.
pub(super) const BESIDE: usize = 4;

/// The names of the numbers of a texel.
pub(super) fn names(channels: &[&str]) -> Vec<String> {
    let base = channels.iter().map(|c| format!("base.{c}"));
    base.chain(["normal.x", "normal.y", "roughness", "specular"].map(str::to_owned)).collect()
}

/// The radiance in each channel, with the cosine between the light and the tilted surface.
pub(crate) fn radiance(numbers: &TexelNumbers, directions: Directions, out: &mut [f64]) {
    let (base, rest) = numbers.split_at(out.len());
    let shares = FacetShares::new(rest, directions);
    out.iter_mut().zip(base).for_each(|(o, base)| *o = shares.radiance(*base));
}

/// What makes the radiance of a facet, whatever its base colour.
#[derive(Debug, Clone, Copy)]
pub(crate) struct FacetShares {
    /// Between the light and the tilted surface; 0 behind it.
    pub cosine: f64,
    /// The share of the light that the body reflects if it is white.
    pub body: f64,
    glossy: f64,
}

impl FacetShares {
    /// Of the numbers beside the base colour.
    pub fn new(rest: &TexelNumbers, Directions { light, view }: Directions) -> Self {
        let [x, y, roughness, f0] = [rest[0], rest[1], rest[2], rest[3]];
        let z = (1.0 - x * x - y * y).max(0.0).sqrt();
        let cosine = |[a, b, c]: [f64; 3]| a * x + b * y + c * z;
        let (to_light, to_viewer) = (cosine(light.to_array()), cosine(view.to_array()));
        if to_light <= 0.0 {
            return Self { cosine: 0.0, body: 0.0, glossy: 0.0 };
        }
        let l_h = (0.5 * (1.0 + light.dot(view))).sqrt();
        let n_h = (to_light + to_viewer) / (2.0 * l_h).max(1e-9);
        let n_v = to_viewer.max(LEAST_VIEW_COSINE);
        let body = microfacet::body_share(to_light, n_v, f0);
        let glossy = microfacet::specular(to_light, n_v, n_h, l_h, microfacet::alpha(roughness), f0);
        Self { cosine: to_light, body, glossy }
    }

    /// The radiance of a channel of that base colour.
    pub fn radiance(self, base: f64) -> f64 {
        self.cosine * (base * self.body + self.glossy)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::direction::Direction;

    #[test]
    fn the_highlight_is_where_the_facet_mirrors_the_light() {
        // A facet tilted by 20 degrees to the right mirrors a light at 40 degrees to the zenith.
        let tilt = 20f64.to_radians();
        let numbers = [0.2, 0.5, 0.1, tilt.sin(), 0.0, 0.3, 0.04];
        let value = |degrees: f64| {
            let mut out = [0.0; 3];
            let light = Direction::from_angles(degrees.to_radians(), 0.0);
            radiance(&numbers, Directions::lit_from(light), &mut out);
            out[2]
        };
        assert!(value(40.0) > value(35.0) && value(40.0) > value(46.0) && value(40.0) > 3.0 * value(0.0));
        let mut out = [1.0; 3];
        radiance(&numbers, Directions::lit_from(Direction::from_angles(1.3, 3.1)), &mut out);
        assert_eq!(out, [0.0; 3]);
    }
}
