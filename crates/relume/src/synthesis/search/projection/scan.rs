//! Lower bounds of many positions at a time, one projection after another.

use pulp::Arch;

use super::Survivors;
use super::table::Table;
use crate::synthesis::positions::Run;
use crate::synthesis::search::Acceptance;
use crate::synthesis::source_map::Texel;

/// Positions that are rejected together.
const STRETCH: usize = 64;

/// One strip of a neighbourhood.
pub(super) struct Term<'a> {
    pub table: &'a Table,
    /// Where the strip lies in the block.
    pub x: usize,
    pub y: usize,
    /// The query's projections and the length of their rest.
    pub coordinates: Vec<f32>,
}

/// A query ready to be compared.
pub(super) struct Scan<'a> {
    terms: Vec<Term<'a>>,
    stages: usize,
    /// How far the square root of a bound may be too large by rounding.
    error: f64,
    arch: Arch,
}

impl<'a> Scan<'a> {
    pub fn new(terms: Vec<Term<'a>>) -> Self {
        let stages = terms.iter().map(|term| term.table.count()).max().unwrap_or(0);
        // Each coordinate of the difference is off by two roundings and one subtraction.
        let square = |term: &Term<'_>| (3.0 * term.table.error()).powi(2) * term.table.count() as f64;
        let error = terms.iter().map(square).sum::<f64>().sqrt();
        Self { terms, stages, error, arch: Arch::new() }
    }

    /// The bound above which no position can have a squared distance of at most `limit`.
    pub fn threshold(&self, limit: u64) -> f32 {
        if limit == u64::MAX {
            return f32::INFINITY;
        }
        // The last factor covers the rounding of sums of at most a few hundred squares.
        (((limit as f64).sqrt() + self.error).powi(2) * (1.0 + 1e-4)) as f32
    }

    /// Bounds the positions of a run, measures the most promising ones, keeps what may be accepted.
    pub fn run(
        &self,
        run: &Run,
        acceptance: Acceptance,
        distance: &impl Fn(Texel, u64) -> Option<u64>,
        found: &mut Survivors,
    ) {
        let mut bounds = [0.0f32; STRETCH];
        for start in (0..run.length).step_by(STRETCH) {
            let length = STRETCH.min(run.length - start);
            let bounds = &mut bounds[..length];
            let threshold = self.threshold(acceptance.limit(found.best));
            let first = run.first.offset(start, 0);
            found.effort.examined += length as u64;
            let least = self.bound(first, bounds, threshold, &mut found.effort.rejected);
            if least > threshold {
                continue;
            }
            if least < self.threshold(found.best) {
                let at = bounds.iter().position(|bound| *bound == least).unwrap_or(0);
                found.effort.verified += 1;
                if let Some(exact) = distance(first.offset(at, 0), found.best) {
                    found.best = found.best.min(exact);
                }
            }
            let near = bounds.iter().enumerate().filter(|(_, bound)| **bound <= threshold);
            found.bounds.extend(near.map(|(i, bound)| (first.offset(i, 0), *bound)));
        }
    }

    /// The bounds of neighbouring positions, as far as needed to see that all exceed the threshold;
    /// the least one is returned. Counts what each stage rejects.
    fn bound(&self, first: Texel, bounds: &mut [f32], threshold: f32, rejected: &mut Vec<u64>) -> f32 {
        bounds.fill(0.0);
        let mut least = 0.0;
        let mut left = bounds.len();
        rejected.resize(self.stages.max(rejected.len()), 0);
        for (stage, rejected) in rejected.iter_mut().enumerate().take(self.stages) {
            let (minimum, near) = self.arch.dispatch(
                #[inline(always)]
                || self.add_stage(stage, first, bounds, threshold),
            );
            least = minimum;
            *rejected += (left - near) as u64;
            left = near;
            if near == 0 {
                break;
            }
        }
        least
    }

    /// Adds one coordinate of every strip; returns the least bound and how many stay within.
    #[inline(always)]
    fn add_stage(&self, stage: usize, first: Texel, bounds: &mut [f32], threshold: f32) -> (f32, usize) {
        for term in self.terms.iter().filter(|term| stage < term.table.count()) {
            let (x, y) = (first.x as usize + term.x, first.y as usize + term.y);
            let row = term.table.row(first.exemplar as usize, stage, x, y, bounds.len());
            let wanted = term.coordinates[stage];
            for (bound, value) in bounds.iter_mut().zip(row) {
                let difference = value - wanted;
                *bound += difference * difference;
            }
        }
        let mut least = [f32::INFINITY; 8];
        let mut near = [0u32; 8];
        let (heads, tail) = bounds.as_chunks::<8>();
        for head in heads {
            for i in 0..8 {
                least[i] = if head[i] < least[i] { head[i] } else { least[i] };
                near[i] += u32::from(head[i] <= threshold);
            }
        }
        let (mut least, mut near) =
            (least.into_iter().fold(f32::INFINITY, f32::min), near.iter().sum::<u32>());
        for &bound in tail {
            least = least.min(bound);
            near += u32::from(bound <= threshold);
        }
        (least, near as usize)
    }
}
