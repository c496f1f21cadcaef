//! Lamps that stand for the light of a hemisphere: with L = sum_p m_p H_p, a texel reflects
//! 1/pi ∫ f(l) L(l) dl = sum_j f(l_j) sum_p F_jp m_p, whatever is made of the values f.
//!
//! The l_j are the nodes of a rule that integrates the products of the functions H_p, and F_jp = w_j H_p(l_j) / pi. Functions
//! known for measured lights are linear in their triangles, with edges that such a rule does not follow: what it gives depends on
//! how it is turned, so it belongs to the frame of the texture. Where their values are linear light, there is an exact
//! form: the l_j are the measured lights, and F_jp = 1/pi ∫ s_j H_p dl, where s_j(l) is the share of light j at l.

use std::f64::consts::PI;

use serde::{Deserialize, Serialize};

use super::hemisphere::HemisphereSpace;
use crate::direction::Direction;
use crate::field::Basis;
use crate::numeric::between::Triangulation;
use crate::space::Space;

/// Measured lights beyond this number are too many for each texel.
const MOST_MEASURED: usize = 256;

/// What lamps are.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum LampKind {
    /// The nodes of a rule, in any frame of a normal.
    #[default]
    Normal,
    /// The nodes of a rule, in the frame of the texture.
    Texture,
    /// Measured lights, in the frame of the texture.
    Measured,
}

/// Lamps in a frame.
#[derive(Debug)]
pub(super) struct FrameLamps {
    pub kind: LampKind,
    pub directions: Vec<Direction>,
    /// For each lamp a factor for each function of the hemisphere.
    pub factors: Vec<f32>,
}

impl FrameLamps {
    /// Those for the values of a basis in a space.
    pub fn of(basis: &Basis, values: Space, space: &HemisphereSpace) -> Self {
        match basis.measured_grid().map(|grid| grid.lights()) {
            None => Self::of_rule(LampKind::Normal, space),
            Some(lights) if values == Space::Linear && lights.points().len() <= MOST_MEASURED => {
                Self::of_measured(lights, space)
            }
            Some(_) => Self::of_rule(LampKind::Texture, space),
        }
    }

    fn of_rule(kind: LampKind, space: &HemisphereSpace) -> Self {
        let (mut directions, mut factors) = (Vec::new(), Vec::new());
        let mut values = vec![0.0; space.len()];
        for (direction, weight) in space.rule(space.degree() + 1) {
            space.values_into(direction.to_array(), &mut values);
            directions.push(direction);
            factors.extend(values.iter().map(|v| (weight * v / PI) as f32));
        }
        Self { kind, directions, factors }
    }

    fn of_measured(lights: &Triangulation, space: &HemisphereSpace) -> Self {
        let count = lights.points().len();
        let (mut sums, mut values) = (vec![0.0; count * space.len()], vec![0.0; space.len()]);
        for (direction, weight) in space.fine_rule() {
            space.values_into(direction.to_array(), &mut values);
            for (light, share) in lights.shares(direction) {
                let row = &mut sums[light * space.len()..][..space.len()];
                row.iter_mut().zip(&values).for_each(|(sum, v)| *sum += share * weight * v / PI);
            }
        }
        Self {
            kind: LampKind::Measured,
            directions: (0..count).map(|i| lights.direction(i)).collect(),
            factors: sums.into_iter().map(|sum| sum as f32).collect(),
        }
    }
}
