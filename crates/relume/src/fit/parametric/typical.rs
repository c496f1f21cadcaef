//! The roughness and the specular reflectance that are typical of a texture: those with which a sample of its texels, each with
//! a base colour and a normal of its own, come nearest to their values together.
//!
//! The sum over texels has one clear minimum where that of each has two or three, so it is searched on a grid: the roughness of a
//! usual dielectric first, then the specular reflectance, then the roughness more finely. Reflectances of metals have to
//! explain markedly more: in deep relief, where no facet explains much, they are hardly better than dielectrics, and wrong.

use super::ggx::GgxModel;
use crate::microfacet::DIELECTRIC_F0;

/// The reflectance of most gems; above are metals.
const BRIGHTEST_DIELECTRIC: f64 = 0.1;
/// The factor of the sum of squares of metals.
const METAL_BURDEN: f64 = 1.2;

/// What texels are held near to.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct TypicalFacet {
    pub roughness: f64,
    /// The reflectance at normal incidence.
    pub specular: f64,
    /// What a deviation of 1 of either counts.
    pub weights: [f64; 2],
}

impl TypicalFacet {
    /// One that holds nothing.
    fn free(roughness: f64, specular: f64) -> Self {
        Self { roughness, specular, weights: [0.0; 2] }
    }
}

/// The facet of the least sum of squares.
pub(super) fn typical_facet(model: &GgxModel, sample: &[Vec<f32>]) -> TypicalFacet {
    let mut best = (f64::INFINITY, TypicalFacet::free(0.5, DIELECTRIC_F0));
    let mut try_all = |facets: &[TypicalFacet]| {
        for facet in facets {
            let burden = if facet.specular > BRIGHTEST_DIELECTRIC { METAL_BURDEN } else { 1.0 };
            let squares = burden * model.fixed_at(*facet).squares(sample);
            if squares < best.0 {
                best = (squares, *facet);
            }
        }
        best.1
    };
    let coarse: Vec<_> = (1..=10).map(|k| TypicalFacet::free(0.1 * f64::from(k), DIELECTRIC_F0)).collect();
    let TypicalFacet { roughness, .. } = try_all(&coarse);
    let TypicalFacet { specular, .. } = try_all(
        &[0.015, 0.025, 0.06, 0.09, 0.2, 0.5].map(|specular| TypicalFacet::free(roughness, specular)),
    );
    let near = [-0.1, -0.05, 0.05, 0.1].map(|step| roughness + step);
    let fine: Vec<_> = (near.into_iter().filter(|r| (0.1..=1.0).contains(r)))
        .map(|roughness| TypicalFacet::free(roughness, specular))
        .collect();
    try_all(&fine)
}
