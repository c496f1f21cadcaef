//! The numbers of a texel from which its corrections follow, for look-ups between texels and at coarser scales.
//!
//! Distances and contrasts may be averaged like coefficients; what is not linear follows from the averages. Of a patch of
//! several texels a boundary that passes through it covers a part, so there the step from dark to lit is as wide as the
//! patch, and where patches are wider than the reach of the distances nothing is left of the corrections: then linear
//! interpolation of the averages is right.

use super::{HIGHLIGHT, LEVELS, SHADOW, SOFTNESS, Shapes, inside_of, texel};
use crate::direction::Direction;

/// Numbers of a channel: the contrasts of shadows and of highlights, each as a polynomial of 1, x, y and z.
const CONTRASTS: usize = 8;

/// How the numbers of a texel are read: n distances to the boundaries of shadows in texels, n to those of highlights, and
/// two contrasts for each channel.
#[derive(Debug, Clone, PartialEq)]
pub struct ShapeLookup {
    lights: usize,
    channels: usize,
    strengths: [f32; 2],
}

impl ShapeLookup {
    /// The numbers of a texel.
    pub fn len(&self) -> usize {
        2 * self.lights + CONTRASTS * self.channels
    }

    /// Never: there is at least one light.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// The shares of the corrections of shadows and of highlights that are made.
    pub fn strengths(&self) -> [f32; 2] {
        self.strengths
    }

    /// By which distances to the boundaries of shadows and of highlights are whole numbers from -127 to 127.
    pub fn steps(&self) -> [f32; 2] {
        [SHADOW.steps, HIGHLIGHT.steps]
    }

    /// The largest contrasts of shadows and of highlights.
    pub fn most_contrasts(&self) -> [f32; 2] {
        [SHADOW.most, HIGHLIGHT.most]
    }

    /// Half the width of the step from dark to lit, in texels.
    pub fn softness(&self) -> f32 {
        SOFTNESS
    }

    /// What moved boundaries add to the linear value of each channel, of up to three, under a light of which `weights` are the
    /// values of the functions; `footprint` is the width in texels of the patch over which the numbers were averaged.
    ///
    /// # Panics
    /// When there are not as many numbers and weights as there should be.
    pub fn corrections(
        &self,
        numbers: &[f32],
        weights: &[f64],
        light: Direction,
        footprint: f64,
    ) -> [f32; 3] {
        assert!(numbers.len() == self.len() && weights.len() == self.lights, "the numbers of a texel");
        let wider = 0.5 * (footprint.clamp(1.0, 1e6) - 1.0) as f32;
        let softness = (SOFTNESS * SOFTNESS + wider * wider).sqrt();
        let (distances, contrasts) = numbers.split_at(2 * self.lights);
        let mut moved = [0.0f32; 2];
        for (moved, distances) in moved.iter_mut().zip(distances.chunks_exact(self.lights)) {
            let (mut mixed, mut linear) = (0.0f32, 0.0f32);
            for (weight, distance) in weights.iter().zip(distances) {
                mixed += *weight as f32 * distance;
                linear += *weight as f32 * inside_of(*distance, softness);
            }
            *moved = inside_of(mixed, softness) - linear;
        }
        let mut sums = [0.0; 3];
        for (sum, contrasts) in sums.iter_mut().zip(contrasts.as_chunks::<CONTRASTS>().0) {
            let terms = texel::terms(light);
            for (k, (contrast, edge)) in
                contrasts.as_chunks::<4>().0.iter().zip([SHADOW, HIGHLIGHT]).enumerate()
            {
                let contrast: f32 = contrast.iter().zip(terms).map(|(c, term)| c * term).sum();
                *sum += self.strengths[k] * moved[k] * contrast.clamp(0.0, edge.most);
            }
        }
        sums
    }
}

impl Shapes<'_> {
    /// How [`Shapes::numbers_into`] is read.
    pub fn lookup(&self) -> ShapeLookup {
        let channels = self.field.layout().channels();
        ShapeLookup { lights: self.field.basis().len(), channels, strengths: self.strengths }
    }

    /// The numbers of texel number `texel`.
    ///
    /// # Panics
    /// When `out` has not the length that [`ShapeLookup::len`] tells.
    pub fn numbers_into(&self, texel: usize, out: &mut [f32]) {
        let (lights, texels) = (self.field.basis().len(), self.size().texels());
        assert_eq!(out.len(), self.lookup().len(), "the numbers of a texel");
        let (distances, contrasts) = out.split_at_mut(2 * lights);
        let edges = [(&self.distances[0], SHADOW), (&self.distances[1], HIGHLIGHT)];
        for ((codes, edge), out) in edges.into_iter().zip(distances.chunks_exact_mut(lights)) {
            let codes = codes.iter().skip(texel).step_by(texels);
            out.iter_mut().zip(codes).for_each(|(out, code)| *out = f32::from(*code) / edge.steps);
        }
        for (c, out) in contrasts.as_chunks_mut::<CONTRASTS>().0.iter_mut().enumerate() {
            *out = contrast_polynomials(self.levels_of(texel, c));
        }
    }
}

/// Lit minus dark, and bright minus lit; zero where no photograph shows a shadow, or a highlight.
fn contrast_polynomials(levels: &[f32; LEVELS]) -> [f32; CONTRASTS] {
    let [a, b, c, d, dark, bright] = *levels;
    let shadow = if dark == texel::NEVER_DARK { [0.0; 4] } else { [a - dark, b, c, d] };
    let highlight = if bright == texel::NEVER_BRIGHT { [0.0; 4] } else { [bright - a, -b, -c, -d] };
    [shadow, highlight].concat().try_into().expect("two polynomials of four terms")
}
