//! The reflectance of rough surfaces: microfacets over a Lambertian body.
//!
//! Used by the virtual dome and for the highlights of rendering.
//!
//! Surface: Cook-Torrance with the GGX distribution (B. Walter et al., Microfacet models for
//! refraction through rough surfaces, EGSR 2007, eq. 33), Smith's height-correlated shadowing (E.
//! Heitz, Understanding the masking-shadowing function in microfacet-based BRDFs, JCGT 3(2), 2014,
//! eq. 99) and Schlick's Fresnel term (An inexpensive BRDF model, 1994, eq. 15). Roughness is the
//! square root of alpha (B. Burley, Physically-based shading at Disney, 2012).
//!
//! Body: albedo / pi, reduced by the light that the surface reflects on the way in and on the way out, (1 -
//! F(l)) (1 - F(v)) (P. Shirley et al., A practitioners' assessment of light reflection models, Pacific
//! Graphics 1997), so that no more light leaves than arrives; a test integrates it.

/// Reflectance at normal incidence of a dielectric of refractive index 1.5.
pub const DIELECTRIC_F0: f64 = 0.04;

/// The least roughness, everywhere: a lobe a third of a degree wide. On a smoother surface the highlight of a
/// point lamp falls between texels and samples, and appears as sparkles that depend on their positions.
pub const LEAST_ROUGHNESS: f64 = 0.05;

/// The parameter of the distribution for a roughness in 0..1; values below [`LEAST_ROUGHNESS`] are raised to
/// it.
pub fn alpha(roughness: f64) -> f64 {
    let roughness = roughness.max(LEAST_ROUGHNESS);
    roughness * roughness
}

/// GGX: microfacets per unit of solid angle and area; `n_h` is the cosine between the half vector and the
/// normal.
pub fn distribution(n_h: f64, alpha: f64) -> f64 {
    let squared = alpha * alpha;
    let t = n_h * n_h * (squared - 1.0) + 1.0;
    squared / (std::f64::consts::PI * t * t)
}

/// Height-correlated Smith masking and shadowing over 4 (n.l)(n.v).
pub fn visibility(n_l: f64, n_v: f64, alpha: f64) -> f64 {
    let squared = alpha * alpha;
    let towards = |a: f64, b: f64| a * (squared + (1.0 - squared) * b * b).sqrt();
    0.5 / (towards(n_l, n_v) + towards(n_v, n_l)).max(1e-9)
}

/// Schlick's Fresnel reflectance at a cosine.
pub fn fresnel(cosine: f64, f0: f64) -> f64 {
    let away = 1.0 - cosine.clamp(0.0, 1.0);
    let squared = away * away;
    f0 + (1.0 - f0) * squared * squared * away
}

/// The reflectance of the surface times pi: 1 is as bright as a white Lambertian facing the light. The cosine
/// at the light is not included. Arguments are cosines, `l_h` between light and half vector.
pub fn specular(n_l: f64, n_v: f64, n_h: f64, l_h: f64, alpha: f64, f0: f64) -> f64 {
    std::f64::consts::PI * distribution(n_h, alpha) * visibility(n_l, n_v, alpha) * fresnel(l_h, f0)
}

/// The share of the light that reaches the body and leaves it again.
pub fn body_share(n_l: f64, n_v: f64, f0: f64) -> f64 {
    (1.0 - fresnel(n_l, f0)) * (1.0 - fresnel(n_v, f0))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::direction::Direction;
    use crate::numeric::quadrature::integrate_hemisphere;
    use std::f64::consts::PI;

    fn half(l: Direction, v: Direction) -> Direction {
        Direction::new(l.x() + v.x(), l.y() + v.y(), l.z() + v.z()).unwrap()
    }

    #[test]
    fn microfacets_cover_their_area_once() {
        for roughness in [0.4, 0.55, 0.8, 1.0] {
            let area = integrate_hemisphere(400, |h| distribution(h.z(), alpha(roughness)) * h.z());
            assert!((area - 1.0).abs() < 1e-6, "roughness {roughness}: {area}");
        }
    }

    /// Heitz 2014, eq. 5: from any direction, the visible microfacets cover the projected area.
    #[test]
    fn masked_microfacets_cover_the_projected_area() {
        for (roughness, polar) in [(0.5, 0.4), (0.8, 1.2), (1.0, 1.45)] {
            let (v, a) = (Direction::from_angles(polar, 0.3), alpha(roughness));
            // G1 is the limit of the correlated term for a light at the zenith, where nothing is masked.
            let cosine = v.z();
            let masking = 2.0 * cosine / (cosine + (a * a + (1.0 - a * a) * cosine * cosine).sqrt());
            let area = integrate_hemisphere(500, |h| distribution(h.z(), a) * masking * v.dot(h).max(0.0));
            assert!((area - cosine).abs() < 2e-3 * cosine, "{roughness} {polar}: {area} {cosine}");
            let by_us = 4.0 * cosine * visibility(1.0, cosine, a);
            assert!((by_us - masking).abs() < 1e-12);
        }
    }

    #[test]
    fn a_white_furnace_gets_no_more_light_than_it_gives() {
        for roughness in [0.3, 0.5, 0.7, 0.85, 1.0] {
            for polar in [0.0, 0.4, 0.8, 1.1, 1.35, 1.5] {
                let (v, a) = (Direction::from_angles(polar, 0.0), alpha(roughness));
                let reflected = |l: Direction| {
                    let h = half(l, v);
                    let surface = specular(l.z(), v.z(), h.z(), l.dot(h), a, DIELECTRIC_F0);
                    (surface + body_share(l.z(), v.z(), DIELECTRIC_F0)) * l.z() / PI
                };
                let sum = integrate_hemisphere(300, reflected);
                assert!(sum <= 1.0 && sum > 0.3, "roughness {roughness}, polar {polar}: {sum}");
                let mirror = integrate_hemisphere(300, |l| {
                    let h = half(l, v);
                    specular(l.z(), v.z(), h.z(), l.dot(h), a, 1.0) * l.z() / PI
                });
                assert!(mirror <= 1.0 + 1e-3, "roughness {roughness}, polar {polar}: {mirror}");
            }
        }
    }
}
