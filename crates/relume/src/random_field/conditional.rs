//! The distribution of the values of a plane given the scores of one or two earlier planes.
//!
//! Curves of single planes preserve the distribution of each, not their joint distribution: planes that are
//! combined anew, such as the channels of a colour, take values together that they never had together. The
//! transport of Rosenblatt ("Remarks on a Multivariate Transformation", Annals of Mathematical Statistics 23,
//! 1952) preserves it: the score of the second plane is its quantile among the texels whose first plane has a
//! like score, that of the third its quantile among those in which both have. Scores so made are independent
//! of each other at a texel, and lead back.
//!
//! Quantiles are stored on a coarse grid of the earlier scores and interpolated between its nodes, which moves
//! modes and makes no new ones. They are estimated from the texels around a node, the nearer the heavier.

use super::marginal::{inverse, normal_cdf};

/// The number of steps in which values are stored between the least and the greatest of a plane.
pub const CODES: u16 = 255;

/// Beyond this score on either side, nodes and quantiles are constant.
const NODE_SPAN: f64 = 2.0;
const KNOT_SPAN: f64 = 3.2;

/// The most texels that quantiles are estimated from.
const MOST_TEXELS: usize = 1 << 16;

/// The least weight of the texels around a node, in texels; with fewer, the node looks farther.
const LEAST_WEIGHT: f64 = 24.0;

/// The number of nodes along each earlier plane, and of quantiles at each, for one and for two earlier planes.
const GRIDS: [(usize, usize); 2] = [(9, 17), (5, 9)];

/// The values of a plane as a function of its own standard normal score and those of earlier planes.
#[derive(Debug, Clone, PartialEq)]
pub struct Conditional {
    /// The number of earlier planes, 1 or 2.
    pub parents: usize,
    /// Value of code 0.
    pub low: f32,
    /// Value of code [`CODES`].
    pub high: f32,
    /// For each node, the last earlier plane changing fastest, the values at its quantiles, never decreasing.
    pub codes: Vec<u8>,
}

impl Conditional {
    /// The number of nodes in all, and of quantiles at each, for 1 or 2 earlier planes.
    pub fn grid(parents: usize) -> [usize; 2] {
        let (nodes, knots) = GRIDS[parents - 1];
        [nodes.pow(parents as u32), knots]
    }

    /// The quantiles of values given the scores of earlier planes at the same texels, for a score that is
    /// standard normal.
    ///
    /// # Panics
    /// When there are no values, or other than one or two earlier planes.
    pub fn of(values: &[f32], earlier: &[&[f32]]) -> Self {
        let [_, knots] = Self::grid(earlier.len());
        let shares: Vec<f64> = (0..knots).map(|k| normal_cdf(knot(k, knots))).collect();
        Self::through(values, earlier, |_| shares.clone())
    }

    /// The quantiles of values given the scores of earlier planes, at the shares of given scores below each
    /// quantile among the texels with like `conditions`: scores of any distribution become the values.
    ///
    /// # Panics
    /// As [`Self::of`]; when there are no scores.
    pub fn matched(values: &[f32], earlier: &[&[f32]], scores: &[f32], conditions: &[&[f32]]) -> Self {
        let (parents, texels) = (earlier.len(), ordered(scores, conditions));
        let [_, knots] = Self::grid(parents);
        Self::through(values, earlier, |node| {
            let near = around(&texels, parents, node);
            let total: f64 = near.iter().map(|(_, weight)| weight).sum();
            let below = |k: usize| {
                let end = near.partition_point(|(score, _)| f64::from(*score) <= knot(k, knots));
                near[..end].iter().map(|(_, weight)| weight).sum::<f64>() / total
            };
            (0..knots).map(below).collect()
        })
    }

    fn through(values: &[f32], earlier: &[&[f32]], shares: impl Fn(usize) -> Vec<f64>) -> Self {
        let (parents, texels) = (earlier.len(), ordered(values, earlier));
        let (low, high) = (texels[0].0, texels[texels.len() - 1].0);
        let code =
            |v: f32| if high > low { ((v - low) / (high - low) * f32::from(CODES)).round() } else { 0.0 };
        let [nodes, _] = Self::grid(parents);
        let quantiles = (0..nodes).flat_map(|node| at_shares(&around(&texels, parents, node), &shares(node)));
        Self { parents, low, high, codes: quantiles.map(|v| code(v) as u8).collect() }
    }

    /// Whether all values are the same.
    pub fn is_constant(&self) -> bool {
        self.high <= self.low
    }

    /// The same as numbers ready for use.
    pub fn table(&self) -> ConditionalTable {
        let scale = (self.high - self.low) / f32::from(CODES);
        let (nodes, knots) = GRIDS[self.parents - 1];
        ConditionalTable {
            nodes,
            knots,
            stride: if self.parents == 2 { nodes * knots } else { knots },
            second: if self.parents == 2 { knots } else { 0 },
            values: self.codes.iter().map(|&code| self.low + scale * f32::from(code)).collect(),
        }
    }
}

/// The coordinates of a node.
fn place_of(parents: usize, node: usize) -> [f64; 2] {
    let (nodes, _) = GRIDS[parents - 1];
    let at = |i: usize| i as f64 * node_step(nodes) - NODE_SPAN;
    if parents == 2 { [at(node / nodes), at(node % nodes)] } else { [at(node), 0.0] }
}

fn node_step(nodes: usize) -> f64 {
    2.0 * NODE_SPAN / (nodes - 1) as f64
}

/// Values in increasing order, with the scores of one or two earlier planes at their texels; of large planes
/// one texel of each of equal stretches.
fn ordered(values: &[f32], earlier: &[&[f32]]) -> Vec<(f32, [f32; 2])> {
    let every = values.len().div_ceil(MOST_TEXELS);
    let scores = |t: usize| [earlier[0][t], earlier.get(1).map_or(0.0, |plane| plane[t])];
    let mut texels: Vec<(f32, [f32; 2])> =
        (0..values.len()).step_by(every).map(|t| (values[t], scores(t))).collect();
    texels.sort_by(|a, b| a.0.total_cmp(&b.0));
    texels
}

/// The texels around a node, in the order of their values, with weights that fall to zero at the next node,
/// or farther if there are few.
fn around(texels: &[(f32, [f32; 2])], parents: usize, node: usize) -> Vec<(f32, f64)> {
    let (nodes, _) = GRIDS[parents - 1];
    let (place, mut width) = (place_of(parents, node), node_step(nodes));
    loop {
        let hat = |k: usize, scores: &[f32; 2]| {
            let score = f64::from(scores[k]).clamp(-NODE_SPAN, NODE_SPAN);
            (1.0 - (score - place[k]).abs() / width).max(0.0)
        };
        let weight = |scores: &[f32; 2]| (0..parents).map(|k| hat(k, scores)).product::<f64>();
        let near: Vec<(f32, f64)> =
            texels.iter().map(|(v, scores)| (*v, weight(scores))).filter(|(_, w)| *w > 0.0).collect();
        let total: f64 = near.iter().map(|(_, w)| w).sum();
        if total >= LEAST_WEIGHT || width > 2.0 * NODE_SPAN {
            return near;
        }
        width *= 1.5;
    }
}

/// The values of weighted texels, in increasing order, at shares of their weight, in increasing order; the
/// least and the greatest at the ends.
fn at_shares(near: &[(f32, f64)], shares: &[f64]) -> Vec<f32> {
    let total: f64 = near.iter().map(|(_, weight)| weight).sum();
    let (last, mut i, mut below) = (near.len() - 1, 0, 0.0);
    let mut value = |(k, share): (usize, &f64)| {
        while i < last && below + near[i].1 < share * total {
            below += near[i].1;
            i += 1;
        }
        match k {
            0 => near[0].0,
            _ if k + 1 == shares.len() => near[last].0,
            _ => near[i].0,
        }
    };
    shares.iter().enumerate().map(&mut value).collect()
}

/// The score of a quantile.
fn knot(k: usize, knots: usize) -> f64 {
    knot_step(knots) * k as f64 - KNOT_SPAN
}

fn knot_step(knots: usize) -> f64 {
    2.0 * KNOT_SPAN / (knots - 1) as f64
}

/// The quantiles of a [`Conditional`] as values.
#[derive(Debug)]
pub struct ConditionalTable {
    nodes: usize,
    knots: usize,
    /// The distances in `values` of neighbouring nodes along the first and the second earlier plane.
    stride: usize,
    second: usize,
    values: Vec<f32>,
}

impl ConditionalTable {
    /// The position of a score between `count` places over a span: the place below, and the part beyond it.
    fn between(score: f32, span: f64, count: usize) -> (usize, f32) {
        let (last, span) = ((count - 1) as f32, span as f32);
        let place = ((score + span) * (last / (2.0 * span))).clamp(0.0, last);
        let below = (place as usize).min(count - 2);
        (below, place - below as f32)
    }

    /// The first quantile of the node below the earlier scores, and the parts beyond it.
    fn node(&self, earlier: [f32; 2]) -> (usize, [f32; 2]) {
        let (i, s) = Self::between(earlier[0], NODE_SPAN, self.nodes);
        if self.second == 0 {
            return (i * self.stride, [s, 0.0]);
        }
        let (j, t) = Self::between(earlier[1], NODE_SPAN, self.nodes);
        (i * self.stride + j * self.second, [s, t])
    }

    /// A quantile between four nodes.
    fn quantile(&self, start: usize, [s, t]: [f32; 2], knot: usize) -> f32 {
        let line = |at: usize| {
            let (here, there) = (self.values[at], self.values[at + self.stride]);
            here + s * (there - here)
        };
        let first = line(start + knot);
        if t == 0.0 { first } else { first + t * (line(start + self.second + knot) - first) }
    }

    /// The value of a score given earlier ones.
    pub fn value(&self, score: f32, earlier: [f32; 2]) -> f32 {
        let (start, parts) = self.node(earlier);
        let (knot, part) = Self::between(score, KNOT_SPAN, self.knots);
        let (here, there) = (self.quantile(start, parts, knot), self.quantile(start, parts, knot + 1));
        here + part * (there - here)
    }

    /// The score of a value given earlier ones: the inverse, and the middle of level stretches.
    pub fn score(&self, value: f32, earlier: [f32; 2]) -> f32 {
        let (start, parts) = self.node(earlier);
        let knots: Vec<f32> = (0..self.knots).map(|k| self.quantile(start, parts, k)).collect();
        inverse(&knots, value, -KNOT_SPAN, knot_step(self.knots))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::numeric::random::{Purpose, Stream};

    /// Scores of an earlier plane, and values whose spread and skew depend on them.
    fn planes(n: usize) -> [Vec<f32>; 2] {
        let mut random = Stream::new(4, Purpose::Sample, [0]);
        let earlier: Vec<f32> = (0..n).map(|_| random.normal() as f32).collect();
        let values = earlier.iter().map(|z| {
            let own = random.normal() as f32;
            z.abs() + (0.2 + 0.3 * (z + 3.0).clamp(0.0, 6.0)) * if *z > 0.0 { own } else { own.abs() }
        });
        let values = values.collect();
        [earlier, values]
    }

    #[test]
    fn scores_are_normal_and_independent_of_the_earlier_plane_and_lead_back() {
        let [earlier, values] = planes(40_000);
        let table = Conditional::of(&values, &[&earlier]).table();
        let scores: Vec<f32> = values.iter().zip(&earlier).map(|(&v, &z)| table.score(v, [z, 0.0])).collect();
        let mean = |of: &dyn Fn(f64, f64) -> f64| {
            let pairs = scores.iter().zip(&earlier).map(|(&s, &z)| of(f64::from(s), f64::from(z)));
            pairs.sum::<f64>() / scores.len() as f64
        };
        let (first, second) = (mean(&|s, _| s), mean(&|s, _| s * s));
        // Between the rows of the table the spread is smoothed, so that of the scores is a little low.
        assert!(first.abs() < 0.05 && (second - 1.0).abs() < 0.15, "{first} {second}");
        // Neither the mean nor the spread of the scores depends on the earlier plane.
        let (slope, spread) = (mean(&|s, z| s * z), mean(&|s, z| (s * s - second) * z));
        assert!(slope.abs() < 0.08 && spread.abs() < 0.15, "{slope} {spread}");
        let span = 0.02 * f64::from(values.iter().fold(0.0f32, |most, v| most.max(v.abs())));
        for ((&v, &z), &s) in values.iter().zip(&earlier).zip(&scores).filter(|(_, s)| s.abs() < 3.0) {
            assert!(f64::from((table.value(s, [z, 0.0]) - v).abs()) < span, "{v} given {z}");
        }
    }

    #[test]
    fn values_rise_with_their_score_and_stay_in_range_given_two_planes() {
        let [first, values] = planes(3000);
        let second: Vec<f32> = first.iter().rev().copied().collect();
        let conditional = Conditional::of(&values, &[&first, &second]);
        let table = conditional.table();
        for earlier in [[-5.0, 5.0], [0.3, -1.2], [1.9, 2.1], [7.0, 0.0]] {
            let line: Vec<f32> = (-50..=50).map(|i| table.value(0.1 * i as f32, earlier)).collect();
            assert!(line.windows(2).all(|pair| pair[0] <= pair[1]));
            let slack = 1e-4 * (conditional.high - conditional.low);
            assert!(line[0] >= conditional.low - slack && line[100] <= conditional.high + slack);
        }
    }

    #[test]
    fn scores_of_any_distribution_become_the_values() {
        let [earlier, values] = planes(20_000);
        // Uniform scores, and as many conditions with the distribution of the earlier plane.
        let mut random = Stream::new(9, Purpose::Sample, [0]);
        let scores: Vec<f32> = values.iter().map(|_| random.unit() as f32 * 4.0 - 2.0).collect();
        let conditions: Vec<f32> = earlier.iter().rev().copied().collect();
        let table = Conditional::matched(&values, &[&earlier], &scores, &[&conditions]).table();
        let made: Vec<f32> =
            scores.iter().zip(&conditions).map(|(&s, &z)| table.value(s, [z, 0.0])).collect();
        let sorted = |values: &[f32]| {
            let mut sorted = values.to_vec();
            sorted.sort_unstable_by(f32::total_cmp);
            sorted
        };
        let (made, wanted) = (sorted(&made), sorted(&values));
        let error = made.iter().zip(&wanted).map(|(a, b)| f64::from((a - b).abs())).sum::<f64>();
        assert!(error / (made.len() as f64) < 0.15, "{}", error / made.len() as f64);
    }

    #[test]
    fn one_value_is_constant() {
        let conditional = Conditional::of(&[0.5; 9], &[&[0.0; 9]]);
        assert!(conditional.is_constant());
        assert!((conditional.table().value(1.3, [0.2, 0.0]) - 0.5).abs() < 1e-6);
    }
}
