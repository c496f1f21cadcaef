//! From an exemplar to a tile set.

use serde::Serialize;

use super::closed_cut::{has_room, least_closed_cut, least_side};
use super::corners::{self, CornerWork, laid_seams};
use super::further::{SharedBorder, TilePart};
use super::oblique::{self, misfit, pairs};
use super::options::RollerOptions;
use super::profile::{Axis, profile, squared_distance, squared_step};
use super::region::{ROUNDING, Region, SHORTLIST, Strips, is_exactly_whole, is_whole, largest, sides};
use super::seams::TileSeams;
use super::tile_set::TileSet;
use super::toroidal::{Strip, closed_cuts};
use crate::error::{Error, Result};
use crate::job::Job;
use crate::numeric::cells::Cells;
use crate::numeric::corner_colors::CornerColors;
use crate::numeric::lattice::Lattice;
use crate::numeric::periods::{self, Pattern, Periods};
use crate::parallel;
use crate::size::Size;
use crate::synthesis::quantise::{Exemplar, IndexTexels, Quantised};
use crate::synthesis::source_map::{SourceMap, Texel};

/// The result of the Roller.
#[derive(Debug, Clone, PartialEq)]
pub struct Rolled {
    /// The tiles.
    pub tiles: TileSet,
    /// The report.
    pub report: RollReport,
}

/// How a tile set was made, and its quality.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[non_exhaustive]
pub struct RollReport {
    /// How the first tile was made, whose border all others have; `None` if borders vary.
    pub first: Option<FirstTile>,
    /// The periods of the texture.
    pub periods: Periods,
    /// Whether the sides of the tile are whole periods; true if there are none.
    pub whole_periods: bool,
    /// The parts that became the further tiles, or all of them if borders vary.
    pub parts: Vec<TilePart>,
    /// The seams of each tile; if borders vary, those of a part of the plane.
    pub seams: Vec<TileSeams>,
    /// The share of texels that all tiles have in common, 1 for a single one: what returns in every cell.
    pub common: f64,
}

/// How the first tile was made.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct FirstTile {
    /// The part of the exemplar that became the tile.
    pub region: Region,
    /// The corner through which both cuts go, relative to the lattice point of the cell.
    pub corner: (usize, usize),
    /// The mean squared difference of the overlaps as a fraction of that of unrelated texels: 0 where the
    /// texture repeats exactly, about 1 where it does not.
    pub mismatch: f64,
}

impl RollReport {
    /// Whether the seams of all tiles are expected to be invisible.
    pub fn is_acceptable(&self) -> bool {
        self.seams.iter().all(TileSeams::are_acceptable)
    }
}

/// Makes tiles from an exemplar. The result depends on the exemplar and the options only.
///
/// # Errors
/// When the options are invalid, the exemplar has no room for such tiles, or the limits are exceeded.
pub fn roll(exemplar: &Exemplar<'_>, options: &RollerOptions, job: &Job) -> Result<Rolled> {
    options.validate()?;
    // Tables of the shortlisted sides, and the spectra of the correlation of the border.
    let tables = 2 * if options.oblique { oblique::SHORTLIST } else { SHORTLIST };
    job.check("the Roller's tables", exemplar.index.size(), 8 * tables as u64 + 64)?;
    let quantised = Quantised::new(std::slice::from_ref(exemplar), job)?;
    let _codes = job.hold("the codes of the exemplar", quantised.bytes())?;
    let size = exemplar.index.size();
    let overlap = options.overlap.unwrap_or_else(|| RollerOptions::customary_overlap(size));
    let periods = match options.pattern {
        Some(pattern) => Periods { pattern, share: 1.0, uncertain: None },
        None => periods::of(exemplar.index, job)?,
    };
    let work = RollWork {
        texels: &quantised.texels()[0],
        planes: quantised.planes(),
        options,
        overlap,
        pattern: periods.pattern,
        job,
    };
    let strips = Strips::new(work.texels, exemplar.excluded, overlap);
    if let Some((tile, border)) = work.varied()? {
        return work.rolled_with_corners(exemplar, &strips, (tile, border), quantised.step());
    }
    let (region, whole_periods) = work.region(&strips)?;
    let (first, corner) = work.first_tile(&region);
    let parts = work.parts(&region, &first, &strips)?;
    let further = parallel::try_map(parts.iter(), |part| {
        job.proceed()?;
        Ok(work.further_tile(&region, &first, part))
    })?;
    let tiles: Vec<Vec<Texel>> = std::iter::once(first).chain(further).collect();
    let measure =
        |sources: &Vec<Texel>| TileSeams::measure(work.texels, quantised.step(), &region.cells, sources);
    let seams = tiles.iter().map(measure).collect();
    let tile = region.tile();
    let stacked = Size::new(tile.width, tile.height * tiles.len());
    let map = SourceMap::new(stacked, std::slice::from_ref(exemplar), tiles.concat());
    let tiles = TileSet::new(region.cells, CornerColors::ALIKE, map);
    let first = Some(FirstTile { region, corner, mismatch: work.mismatch(&region) });
    let report = RollReport { first, periods, whole_periods, parts, seams, common: tiles.common() };
    Ok(Rolled { tiles, report })
}

/// A rectangle is kept unless its overlaps differ by more than this times the error of an oblique cell: other
/// programs can use it as well.
const CLEARLY_WORSE: f64 = 1.25;

/// The data common to all steps.
struct RollWork<'a> {
    texels: &'a IndexTexels,
    planes: usize,
    options: &'a RollerOptions,
    overlap: usize,
    pattern: Pattern,
    job: &'a Job,
}

impl RollWork<'_> {
    /// The size and the border of tiles with coloured corners, if such are to be made.
    fn varied(&self) -> Result<Option<(Size, usize)>> {
        let repeats = self.pattern != Pattern::None;
        if !self.options.vary || repeats || !CornerColors::most(self.options.tiles).vary() {
            return Ok(None);
        }
        let tile = Size::new(self.lengths(Axis::X)?.1, self.lengths(Axis::Y)?.1);
        Ok(corners::border(tile, self.overlap + 1).map(|border| (tile, border)))
    }

    /// Tiles with coloured corners.
    fn rolled_with_corners(
        &self,
        exemplar: &Exemplar<'_>,
        strips: &Strips<'_>,
        (tile, border): (Size, usize),
        step: f64,
    ) -> Result<Rolled> {
        let (count, colors) = (self.options.tiles, CornerColors::most(self.options.tiles));
        let work = CornerWork { texels: self.texels, strips, tile, border, colors, job: self.job };
        let bytes = 8 * (self.planes as u64 + 4) + 32;
        self.job.check("the spectra of the exemplar", self.texels.size(), bytes)?;
        let (tiles, parts) = work.tiles(count)?;
        let cells = Cells::upright(tile).expect("a tile has texels");
        let stacked = Size::new(tile.width, tile.height * count);
        let map = SourceMap::new(stacked, std::slice::from_ref(exemplar), tiles.concat());
        let tiles = TileSet::new(cells, colors, map);
        let report = RollReport {
            first: None,
            periods: Periods { pattern: self.pattern, share: 0.0, uncertain: None },
            whole_periods: true,
            parts,
            seams: vec![laid_seams(&tiles, self.texels, step, self.job)?],
            common: tiles.common(),
        };
        Ok(Rolled { tiles, report })
    }

    /// The part that becomes the first tile, and whether it has whole periods.
    fn region(&self, strips: &Strips<'_>) -> Result<(Region, bool)> {
        let (upright, whole) = self.upright_region(strips)?;
        match self.oblique_region(strips, &upright, whole)? {
            Some(oblique) => Ok((oblique, true)),
            None if whole || self.options.pattern.is_none() => Ok((upright, whole)),
            None => Err(self.no_such_tile(&upright)),
        }
    }

    /// Why no tile has the given periods.
    fn no_such_tile(&self, upright: &Region) -> Error {
        let periods = match self.pattern {
            Pattern::None => String::new(),
            Pattern::Stripes([x, y]) => format!("the given period of ({x}, {y})"),
            Pattern::Lattice(lattice) => {
                let [[ax, ay], [bx, by]] = lattice.basis();
                format!("the given periods of ({ax}, {ay}) and ({bx}, {by})")
            }
        };
        let shapes = if self.options.oblique { "rectangle or oblique tile" } else { "rectangle" };
        let advice = if self.options.oblique { "" } else { ", or allow oblique tiles" };
        Error::usage(format!(
            "no {shapes} for k = {} in the exemplar of {} holds whole numbers of {periods} texels; the nearest is {}: \
             give a larger exemplar, fewer tiles or a smaller overlap{advice}",
            self.options.tiles,
            self.texels.size(),
            upright.tile()
        ))
    }

    /// The best rectangle.
    fn upright_region(&self, strips: &Strips<'_>) -> Result<(Region, bool)> {
        let (widths, whole_x) = self.sides(Axis::X)?;
        let (heights, whole_y) = self.sides(Axis::Y)?;
        let cells = |&width: &usize, &height: &usize| Cells::upright(Size::new(width, height));
        let all =
            widths.iter().flat_map(|width| heights.iter().filter_map(move |height| cells(width, height)));
        let regions = strips.best_origins(&all.collect::<Vec<_>>(), self.job)?;
        let region = largest(&regions, self.options.slack).ok_or_else(|| {
            Error::usage("the mask leaves no place for a tile: exclude less or ask for more, smaller tiles")
        })?;
        Ok((region, whole_x && whole_y))
    }

    /// An oblique cell, if the lattice is oblique and the cell is clearly better than a rectangle, or the only one
    /// with the given periods.
    fn oblique_region(&self, strips: &Strips<'_>, upright: &Region, whole: bool) -> Result<Option<Region>> {
        let Pattern::Lattice(lattice) = self.pattern else { return Ok(None) };
        if !self.options.oblique || misfit(&upright.cells, &lattice) <= ROUNDING {
            return Ok(None);
        }
        let Some(cells) = self.oblique_pairs(strips, &lattice) else { return Ok(None) };
        let region = largest(&strips.best_origins(&cells, self.job)?, self.options.slack);
        let is_needed = !whole && self.options.pattern.is_some();
        Ok(region.filter(|region| is_needed || upright.mean_error() > CLEARLY_WORSE * region.mean_error()))
    }

    fn oblique_pairs(&self, strips: &Strips<'_>, lattice: &Lattice) -> Option<Vec<Cells>> {
        let lengths = [Axis::X, Axis::Y].map(|axis| self.lengths(axis).ok());
        let [across, down] = [lengths[0]?, lengths[1]?];
        let has_inside = |cells: &Cells| self.options.tiles == 1 || has_room(cells, self.overlap);
        Some(pairs(self.texels, lattice, [across, down], |cells| strips.holds(cells) && has_inside(cells)))
    }

    /// The least and the longest side worth trying along an axis.
    fn lengths(&self, axis: Axis) -> Result<(usize, usize)> {
        let longest = (self.room(axis) as f64 / (self.options.tiles as f64).sqrt()) as usize;
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
        Ok((least.max((self.options.least_side * longest as f64).ceil() as usize), longest))
    }

    /// The longest side with room for the overlap.
    fn room(&self, axis: Axis) -> usize {
        axis.side(self.texels.size()).saturating_sub(self.overlap)
    }

    /// The sides of tiles worth trying along an axis, best first, and whether they are whole periods: up to
    /// the longest with room for the other tiles, or the shortest whole periods if these are longer, or, of
    /// given ones, the longest if these are shorter than usual.
    fn sides(&self, axis: Axis) -> Result<(Vec<usize>, bool)> {
        let ((least, longest), room) = (self.lengths(axis)?, self.room(axis));
        let profile = profile(self.texels, self.planes, axis);
        // Measured periods are known to a fraction of a texel, given ones are meant.
        let whole = |shift: usize| match self.options.pattern {
            None => is_whole(self.pattern, axis, shift),
            Some(given) => is_exactly_whole(given, axis, shift),
        };
        let found = sides(&profile, least, longest, whole);
        if !found.is_empty() {
            return Ok((found, true));
        }
        let longer = (longest + 1..=room).find(|&shift| whole(shift));
        // Given periods are followed even where tiles are small with them.
        let is_given = self.options.pattern.is_some();
        let shorter = || (self.least_side()..least).rev().find(|&shift| is_given && whole(shift));
        match longer.or_else(shorter) {
            Some(first) => Ok((sides(&profile, first, (first + 2).min(room), whole), true)),
            None => Ok((sides(&profile, least, longest, |_| true), false)),
        }
    }

    /// The least side of a tile: larger than its overlap, and with texels inside the border if tiles share
    /// one.
    fn least_side(&self) -> usize {
        if self.options.tiles > 1 { least_side(self.overlap) } else { self.overlap + 1 }
    }

    /// The tile made from a region by two closed cuts, and their corner.
    fn first_tile(&self, region: &Region) -> (Vec<Texel>, (usize, usize)) {
        let (cells, [x, y], overlap) = (&region.cells, region.corner(), region.overlap);
        let (right, down) = (cells.right(), cells.down());
        let step = |i: i64, j: i64, by: [i64; 2]| squared_step(self.texels, [x + i, y + j], by);
        let across = |along: usize, across: usize| {
            step(cells.left_side(along as i64) + across as i64, along as i64, right)
        };
        let below = |along: usize, across: usize| {
            step(along as i64, cells.upper_side(along as i64) + across as i64, down)
        };
        let cuts = closed_cuts(
            cells,
            &Strip::new(down[1] as usize, overlap, across),
            &Strip::new(right[0] as usize, overlap, below),
        );
        let source = |place: [i64; 2]| {
            let here @ [i, j] = cells.place(place).texel;
            let [dx, dy] = cuts.shift(here);
            texel((x + i + dx) as usize, (y + j + dy) as usize)
        };
        (cells.rectangle().map(source).collect(), cuts.corner)
    }

    /// The parts that become the further tiles, each the best one apart from all previous ones.
    fn parts(&self, region: &Region, first: &[Texel], strips: &Strips<'_>) -> Result<Vec<TilePart>> {
        let tile = region.tile();
        let mut parts: Vec<TilePart> = Vec::new();
        if self.options.tiles == 1 {
            return Ok(parts);
        }
        let codes: Vec<i16> = first.iter().flat_map(|&t| self.run(t)).copied().collect();
        let border = SharedBorder::new(self.texels, self.planes, region.cells, self.overlap, &codes);
        let offset = |side: usize| (self.options.least_offset * side as f64).ceil().max(1.0) as usize;
        let (least_x, least_y) = (offset(tile.width), offset(tile.height));
        while parts.len() + 1 < self.options.tiles {
            self.job.proceed()?;
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
    fn further_tile(&self, region: &Region, first: &[Texel], part: &TilePart) -> Vec<Texel> {
        let tile = region.tile();
        let other = |t: usize| texel(part.x + t % tile.width, part.y + t / tile.width);
        let error = |t: usize| squared_distance(self.run(first[t]), self.run(other(t)));
        let errors: Vec<u64> = (0..tile.texels()).map(error).collect();
        let cut = least_closed_cut(&region.cells, self.overlap, &errors);
        (0..tile.texels()).map(|t| if cut.inside[t] { other(t) } else { first[t] }).collect()
    }

    fn run(&self, texel: Texel) -> &[i16] {
        self.texels.run(texel.x as usize, texel.y as usize, 1)
    }

    /// The mean squared difference of the overlaps of a region as a fraction of that of unrelated texels,
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
