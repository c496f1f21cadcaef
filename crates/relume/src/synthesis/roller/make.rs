//! From an exemplar to a set of tiles.

use rayon::prelude::*;
use serde::Serialize;

use super::further::{Border, Part};
use super::options::RollerOptions;
use super::profile::{Axis, profile, squared_distance};
use super::region::{Region, SHORTLIST, Strips, is_whole, largest, sides};
use super::ring::{least_ring, least_side};
use super::seams::Seams;
use super::tile_set::TileSet;
use super::toroidal::{Strip, closed_cuts};
use crate::error::{Error, Result};
use crate::limits::Limits;
use crate::numeric::autocorrelation::Autocorrelation;
use crate::numeric::periods::{Pattern, Periods, find};
use crate::planes::Size;
use crate::synthesis::quantise::{Exemplar, IndexTexels, Quantised};
use crate::synthesis::source_map::{SourceMap, Texel};

/// What the Roller gives.
#[derive(Debug, Clone, PartialEq)]
pub struct Rolled {
    /// The tiles.
    pub tiles: TileSet,
    /// How they came about.
    pub report: Report,
}

/// How a set of tiles came about, and how good it is.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Report {
    /// The part of the exemplar that became the first tile.
    pub region: Region,
    /// How the texture repeats.
    pub periods: Periods,
    /// Whether the tile's sides are whole periods; true where there are none.
    pub whole_periods: bool,
    /// The corner through which both cuts go.
    pub corner: (usize, usize),
    /// Mean squared difference of the overlaps as a share of that of unrelated texels: 0 where the
    /// texture repeats exactly, about 1 where it does not.
    pub mismatch: f64,
    /// The parts that became the further tiles.
    pub parts: Vec<Part>,
    /// The seams of each tile.
    pub seams: Vec<Seams>,
}

impl Report {
    /// Whether no tile's seams are expected to be seen.
    pub fn is_acceptable(&self) -> bool {
        self.seams.iter().all(Seams::are_acceptable)
    }
}

/// Makes tiles of an exemplar. The result depends on the exemplar and the options only.
///
/// # Errors
/// When the options mean nothing, the exemplar has no room for such tiles, or the limits are
/// exceeded.
pub fn roll(exemplar: &Exemplar<'_>, options: &RollerOptions, limits: &Limits) -> Result<Rolled> {
    options.validate()?;
    // Tables of the shortlisted sides, and the spectra of the border's correlation.
    limits.check("the Roller's tables", exemplar.index.size(), 16 * SHORTLIST as u64 + 64)?;
    let quantised = Quantised::new(std::slice::from_ref(exemplar), limits)?;
    let size = exemplar.index.size();
    let overlap = options.overlap.unwrap_or_else(|| RollerOptions::customary_overlap(size));
    let periods = match options.pattern {
        Some(pattern) => Periods { pattern, share: 1.0 },
        None => find(&Autocorrelation::new(exemplar.index, Autocorrelation::half(size), limits)?),
    };
    let work = Work {
        texels: &quantised.texels()[0],
        planes: quantised.planes(),
        options,
        overlap,
        pattern: periods.pattern,
    };
    let strips = Strips::new(work.texels, exemplar.excluded, overlap);
    let (region, whole_periods) = work.region(&strips)?;
    let (first, corner) = work.first_tile(&region);
    let parts = work.parts(&region, &first, &strips)?;
    let further = parts.par_iter().map(|part| work.further_tile(&region, &first, part));
    let tiles: Vec<Vec<Texel>> = rayon::iter::once(first.clone()).chain(further).collect();
    let tile = region.tile();
    let measure = |sources: &Vec<Texel>| Seams::measure(work.texels, quantised.step(), tile, sources);
    let report = Report {
        region,
        periods,
        whole_periods,
        corner,
        mismatch: work.mismatch(&region),
        parts,
        seams: tiles.iter().map(measure).collect(),
    };
    let stacked = Size::new(tile.width, tile.height * tiles.len());
    let map = SourceMap::new(stacked, std::slice::from_ref(exemplar), tiles.concat());
    Ok(Rolled { tiles: TileSet::new(tile, map), report })
}

/// What every step needs to know.
struct Work<'a> {
    texels: &'a IndexTexels,
    planes: usize,
    options: &'a RollerOptions,
    overlap: usize,
    pattern: Pattern,
}

impl Work<'_> {
    /// The part that becomes the first tile, and whether it holds whole periods.
    fn region(&self, strips: &Strips<'_>) -> Result<(Region, bool)> {
        let (widths, whole_x) = self.sides(Axis::X)?;
        let (heights, whole_y) = self.sides(Axis::Y)?;
        let regions = strips.best_origins(&widths, &heights);
        let region = largest(&regions, self.options.slack).ok_or_else(|| {
            Error::usage("the mask leaves no place for a tile: exclude less or ask for more, smaller tiles")
        })?;
        Ok((region, whole_x && whole_y))
    }

    /// The sides of tiles worth trying along an axis, best first, and whether they are whole periods:
    /// up to the longest that leaves room for the other tiles, or the shortest period where that is
    /// longer.
    fn sides(&self, axis: Axis) -> Result<(Vec<usize>, bool)> {
        let side = axis.side(self.texels.size());
        let room = side.saturating_sub(self.overlap);
        let longest = (room as f64 / (self.options.tiles as f64).sqrt()) as usize;
        let least = self.least_side();
        if longest < least {
            return Err(Error::usage(format!(
                "tiles of k = {} from an exemplar of {} with an overlap of {} texels would have sides of at most \
                 {longest}, and they need at least {least}: ask for fewer tiles or a smaller overlap",
                self.options.tiles,
                self.texels.size(),
                self.overlap
            )));
        }
        let least = least.max((self.options.least_side * longest as f64).ceil() as usize);
        let profile = profile(self.texels, self.planes, axis);
        let whole = |shift: usize| is_whole(self.pattern, axis, shift);
        let found = sides(&profile, least, longest, whole);
        if !found.is_empty() {
            return Ok((found, true));
        }
        match (longest + 1..=room).find(|&shift| whole(shift)) {
            Some(first) => Ok((sides(&profile, first, (first + 2).min(room), whole), true)),
            None => Ok((sides(&profile, least, longest, |_| true), false)),
        }
    }

    /// The least side of a tile: larger than its overlap, and with something inside the border where
    /// tiles share one.
    fn least_side(&self) -> usize {
        if self.options.tiles > 1 { least_side(self.overlap) } else { self.overlap + 1 }
    }

    /// The tile that two closed cuts make of a region, and their corner.
    fn first_tile(&self, region: &Region) -> (Vec<Texel>, (usize, usize)) {
        let Region { x, y, width, height, overlap, .. } = *region;
        let across =
            |along: usize, across: usize| Axis::X.squared_step(self.texels, x + across, y + along, width);
        let down =
            |along: usize, across: usize| Axis::Y.squared_step(self.texels, x + along, y + across, height);
        let cuts = closed_cuts(&Strip::new(height, overlap, across), &Strip::new(width, overlap, down));
        let tile = region.tile();
        let source = |i: usize, j: usize| {
            let (right, below) = cuts.shift(tile, i, j);
            texel(x + i + right, y + j + below)
        };
        let places = (0..height).flat_map(|j| (0..width).map(move |i| (i, j)));
        (places.map(|(i, j)| source(i, j)).collect(), cuts.corner)
    }

    /// The parts that become the further tiles, each the best that lies apart from all before it.
    fn parts(&self, region: &Region, first: &[Texel], strips: &Strips<'_>) -> Result<Vec<Part>> {
        let tile = region.tile();
        let mut parts: Vec<Part> = Vec::new();
        if self.options.tiles == 1 {
            return Ok(parts);
        }
        let codes: Vec<i16> = first.iter().flat_map(|&t| self.run(t)).copied().collect();
        let border = Border::new(self.texels, self.planes, tile, self.overlap, &codes);
        let offset = |side: usize| (self.options.least_offset * side as f64).ceil().max(1.0) as usize;
        let (least_x, least_y) = (offset(tile.width), offset(tile.height));
        while parts.len() + 1 < self.options.tiles {
            let is_apart = |x: usize, y: usize, from: (usize, usize)| {
                x.abs_diff(from.0) >= least_x || y.abs_diff(from.1) >= least_y
            };
            let taken = std::iter::once((region.x, region.y)).chain(parts.iter().map(|p| (p.x, p.y)));
            let taken: Vec<(usize, usize)> = taken.collect();
            let allowed = |x: usize, y: usize| {
                taken.iter().all(|&from| is_apart(x, y, from)) && strips.allows(x, y, tile)
            };
            let part = border.best(allowed).ok_or_else(|| {
                Error::usage(format!(
                    "the exemplar of {} has room for {} tiles of {tile} and not for {}: ask for fewer, or \
                     give a larger exemplar",
                    self.texels.size(),
                    parts.len() + 1,
                    self.options.tiles
                ))
            })?;
            parts.push(part);
        }
        Ok(parts)
    }

    /// The first tile with another part of the exemplar inside its border.
    fn further_tile(&self, region: &Region, first: &[Texel], part: &Part) -> Vec<Texel> {
        let tile = region.tile();
        let other = |t: usize| texel(part.x + t % tile.width, part.y + t / tile.width);
        let error = |t: usize| squared_distance(self.run(first[t]), self.run(other(t)));
        let errors: Vec<u64> = (0..tile.texels()).map(error).collect();
        let ring = least_ring(tile, self.overlap, &errors);
        (0..tile.texels()).map(|t| if ring.inside[t] { other(t) } else { first[t] }).collect()
    }

    fn run(&self, texel: Texel) -> &[i16] {
        self.texels.run(texel.x as usize, texel.y as usize, 1)
    }

    /// The mean squared difference of a region's overlaps as a share of that of unrelated texels,
    /// which is twice the variance.
    fn mismatch(&self, region: &Region) -> f64 {
        let n = self.texels.size().texels();
        let variance = |k: usize| {
            let codes =
                || self.texels.codes()[k..].iter().step_by(self.planes).take(n).map(|&c| f64::from(c));
            let mean = codes().sum::<f64>() / n as f64;
            codes().map(|code| (code - mean).powi(2)).sum::<f64>() / n as f64
        };
        let unrelated = 2.0 * (0..self.planes).map(variance).sum::<f64>();
        if unrelated > 0.0 { region.mean_error() / unrelated } else { 0.0 }
    }
}

fn texel(x: usize, y: usize) -> Texel {
    Texel { exemplar: 0, y: y as u32, x: x as u32 }
}
