//! Exact search with projection kernels and rejection.
//!
//! Hel-Or, Malzbender, Gelb, "Synthesis of Reflectance Function Textures from Examples",
//! HPL-2003-16, section 6: a lower bound on the distance from a few projections rejects most
//! positions; only survivors get the full distance. Differences from the document:
//!
//! - **Strips instead of shapes.** Every neighbourhood is a union of strips along a block's sides,
//!   and all strips of one size share one [`table`], whichever side they lie on: two tables (one for
//!   top and bottom, one for left and right) serve every shape, on the torus too. The bounds of
//!   disjoint strips add up. Where a neighbourhood is a little larger than its strips (overlaps on a
//!   torus vary by a texel) the rest is left to the full distance.
//! - **The rest counts.** What the kernels leave of a strip bounds the distance further ([`table`]).
//! - **Nothing is lost to rounding.** Projections are exact integers; their `f32` copies are off by
//!   less than a stated error, by which the threshold is widened. Survivors are settled by the exact
//!   integer distance.
//! - **The threshold tightens during the search**: the best survivor of each stretch of positions is
//!   measured in full at once.

pub mod kernels;
mod scan;
pub mod table;

use rayon::prelude::*;

use super::distance::Target;
use super::{Acceptance, Candidates, Effort, Found, Query, Search};
use crate::synthesis::neighbourhood::Neighbourhood;
use crate::synthesis::positions::{Positions, Run};
use crate::synthesis::quantise::Quantised;
use crate::synthesis::search::KernelBasis;
use crate::synthesis::source_map::Texel;
use kernels::Kernels;
use scan::{Scan, Term};
use table::Table;

/// Positions of one parallel task.
const SLAB: usize = 1 << 15;

/// Every how many runs the first look takes one.
const PROBE: usize = 23;

/// Rejects by projections, then compares in full.
#[derive(Debug)]
pub struct Projection<'a> {
    exemplars: &'a Quantised,
    positions: &'a Positions,
    /// Strips along the top and the bottom.
    level: Table,
    /// Strips along the left and the right, between those.
    upright: Table,
    slabs: Vec<Vec<Run>>,
}

/// The strips that all neighbourhoods of a layout have in common.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Strips {
    /// Side of the blocks.
    pub block: usize,
    /// Narrowest margin.
    pub overlap: usize,
    /// Height of left and right strips: what a top strip, and on a torus a bottom strip, leave.
    pub upright: usize,
}

impl<'a> Projection<'a> {
    /// Projects all strips of the exemplars on `count` kernels of a basis.
    pub fn new(
        exemplars: &'a Quantised,
        positions: &'a Positions,
        strips: Strips,
        basis: KernelBasis,
        count: usize,
    ) -> Self {
        let table =
            |width, height| Table::new(Kernels::new(basis, count, exemplars, width, height), exemplars);
        Self {
            exemplars,
            positions,
            level: table(strips.block, strips.overlap),
            upright: table(strips.overlap, strips.upright),
            slabs: slabs(positions),
        }
    }

    /// Bytes for each exemplar texel: two tables, and the shifted codes and sums of squares while
    /// they are made.
    pub fn bytes_per_texel(count: usize, planes: usize) -> u64 {
        2 * 4 * (count as u64 + 1) + 2 * planes as u64 + 8
    }

    /// The disjoint strips inside a neighbourhood, with the query's coordinates.
    fn terms<'t>(&'t self, query: &Query) -> Vec<Term<'t>> {
        let Neighbourhood { extent, margins } = query.neighbourhood;
        let (level, upright) = (self.level.rectangle(), self.upright.rectangle());
        let above = if margins.top >= level.height { level.height } else { 0 };
        let below = if margins.bottom >= level.height { level.height } else { 0 };
        let mut places = Vec::new();
        if above > 0 {
            places.push((&self.level, 0, 0));
        }
        if below > 0 {
            places.push((&self.level, 0, extent.height - below));
        }
        if above + upright.height + below <= extent.height {
            if margins.left >= upright.width {
                places.push((&self.upright, 0, above));
            }
            if margins.right >= upright.width {
                places.push((&self.upright, extent.width - upright.width, above));
            }
        }
        let stride = extent.width * self.exemplars.planes();
        let term = |(table, x, y): (&'t Table, usize, usize)| {
            let coordinates = table.project(&query.codes, y * stride + x * self.exemplars.planes(), stride);
            Term { table, x, y, coordinates }
        };
        places.into_iter().map(term).collect()
    }
}

/// What a stretch of positions left.
struct Survivors {
    best: u64,
    /// Positions with their lower bounds.
    bounds: Vec<(Texel, f32)>,
    effort: Effort,
}

impl Search for Projection<'_> {
    fn candidates(&self, query: &Query, acceptance: Acceptance) -> Found {
        let targets = Target::all(query, self.exemplars);
        let distance = |position: Texel, limit: u64| {
            let Texel { exemplar, y, x } = position;
            targets[exemplar as usize].distance_within(x as usize, y as usize, limit)
        };
        let scan = Scan::new(self.terms(query));
        let look = |runs: &mut dyn Iterator<Item = &Run>, best: u64| {
            let mut found = Survivors { best, bounds: Vec::new(), effort: Effort::default() };
            for run in runs {
                scan.run(run, acceptance, &distance, &mut found);
            }
            found
        };
        let probe = look(&mut self.positions.runs().iter().step_by(PROBE), u64::MAX).best;
        let slabs: Vec<Survivors> = self.slabs.par_iter().map(|slab| look(&mut slab.iter(), probe)).collect();
        let mut best = slabs.iter().map(|slab| slab.best).min().unwrap_or(probe);
        let mut effort = Effort::default();
        slabs.iter().for_each(|slab| effort.add(&slab.effort));
        let threshold = scan.threshold(acceptance.limit(best));
        let mut near = Vec::new();
        for &(position, _) in slabs.iter().flat_map(|s| &s.bounds).filter(|(_, bound)| *bound <= threshold) {
            effort.verified += 1;
            if let Some(exact) = distance(position, acceptance.limit(best)) {
                best = best.min(exact);
                near.push((position, exact));
            }
        }
        Found { candidates: Candidates::within(near, acceptance), effort }
    }
}

/// The runs of all positions in groups of about [`SLAB`] positions.
fn slabs(positions: &Positions) -> Vec<Vec<Run>> {
    let mut slabs = vec![Vec::new()];
    let mut filled = 0;
    for run in positions.runs() {
        if filled >= SLAB {
            slabs.push(Vec::new());
            filled = 0;
        }
        filled += run.length;
        slabs.last_mut().expect("there is always a slab").push(*run);
    }
    slabs
}
