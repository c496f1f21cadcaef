//! Closing a texture on the torus by blocks of the exemplars that bridge its border.
//!
//! Blocks lie over the four corners, which are one place of the torus, and side by side along the borders between
//! them. Each is the block of the exemplars that fits best what lies under its rim, on both sides of the border
//! at once ([`Template`]), and is joined to it by four cuts of least error through the rim, so that seams follow
//! edges of the texture: image quilting (Efros, Freeman, SIGGRAPH 2001) over a texture that is there already, as in
//! the offset and refined seams of Kwatra, Schödl, Essa, Turk, Bobick, "Graphcut Textures", SIGGRAPH 2003. Large
//! pieces stay whole, and only texels within the band change.

use crate::error::Result;
use crate::job::Job;
use crate::numeric::summed_area::SummedArea;
use crate::size::Size;
use crate::synthesis::cut::path::least_path;
use crate::synthesis::quantise::{Exemplar, Quantised};
use crate::synthesis::roller::profile::squared_distance;
use crate::synthesis::roller::template::{ExemplarSpectra, Template};
use crate::synthesis::source_map::Texel;

/// The width of a block in rims: two of neighbouring blocks and a part between them.
const WIDTH_IN_RIMS: usize = 6;

/// The least width of a band with room for cuts.
pub const LEAST_BAND: usize = 3;

/// A texture on a torus while its border is bridged.
pub struct Bridging<'a> {
    quantised: &'a Quantised,
    /// The numbers of excluded texels in parts of each exemplar with such.
    excluded: Vec<Option<SummedArea>>,
    size: Size,
    sources: Vec<Texel>,
    band: usize,
}

/// A block by its left column, top row, and size; columns and rows may be negative or beyond the edges.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
struct Bridge {
    x: isize,
    y: isize,
    size: Size,
}

impl<'a> Bridging<'a> {
    /// A texture of copies of the exemplars, given by the source of each texel, whose border is to be bridged
    /// within a band along each edge.
    pub fn new(
        exemplars: &[Exemplar<'_>],
        quantised: &'a Quantised,
        size: Size,
        sources: Vec<Texel>,
        band: usize,
    ) -> Self {
        let sums = |exemplar: &Exemplar<'_>| {
            let marks: Vec<u64> = exemplar.excluded?.iter().map(|mark| u64::from(*mark)).collect();
            Some(SummedArea::new(exemplar.index.size(), &marks))
        };
        Self { quantised, excluded: exemplars.iter().map(sums).collect(), size, sources, band }
    }

    /// The sources of its texels.
    pub fn into_sources(self) -> Vec<Texel> {
        self.sources
    }

    /// Bridges the border; false, with some of it bridged, if a block fits nowhere in the exemplars.
    ///
    /// # Errors
    /// When it exceeds the limits or is cancelled.
    pub fn run(&mut self, job: &Job) -> Result<bool> {
        let bridges = self.bridges();
        let planes = self.quantised.planes() as u64;
        let texels: u64 = self.quantised.texels().iter().map(|texels| texels.size().texels() as u64).sum();
        job.check_bytes("the spectra of the exemplars", texels * (8 * (planes + 4) + 32))?;
        let spectra: Vec<ExemplarSpectra<'_>> =
            self.quantised.texels().iter().map(ExemplarSpectra::new).collect();
        job.start("bridging the border", bridges.len() as u64);
        for bridge in bridges {
            let Some(corner) = self.best(bridge, &spectra) else { return Ok(false) };
            self.join(bridge, corner);
            job.advance(1)?;
        }
        Ok(true)
    }

    /// The width of the rim in which a block is joined.
    fn rim(&self) -> usize {
        (2 * self.band / WIDTH_IN_RIMS).max(1)
    }

    /// The blocks: over the corners, down along the left and right borders, and along the upper and lower ones.
    fn bridges(&self) -> Vec<Bridge> {
        let (side, start) = (2 * self.band, -self.band.cast_signed());
        let corner = Bridge { x: start, y: start, size: Size::new(side, side) };
        let down = self.chain(self.size.height).into_iter().map(|(from, length)| Bridge {
            x: start,
            y: from.cast_signed(),
            size: Size::new(side, length),
        });
        let along = self.chain(self.size.width).into_iter().map(|(from, length)| Bridge {
            x: from.cast_signed(),
            y: start,
            size: Size::new(length, side),
        });
        std::iter::once(corner).chain(down).chain(along).collect()
    }

    /// The beginnings and lengths of the blocks between the corners along a border, which overlap by two rims, so
    /// that the cut of each lies inside its neighbour.
    fn chain(&self, border: usize) -> Vec<(usize, usize)> {
        let (side, overlap) = (2 * self.band, 2 * self.rim());
        let (first, span) = (self.band - overlap, border - side + 2 * overlap);
        if span <= side {
            return vec![(first, span)];
        }
        let count = (span - overlap).div_ceil(side - overlap);
        (0..count).map(|i| (first + i * (span - side) / (count - 1), side)).collect()
    }

    /// Whether a part of an exemplar has no excluded texels.
    fn is_free(&self, exemplar: usize, (x, y): (usize, usize), size: Size) -> bool {
        self.excluded[exemplar].as_ref().is_none_or(|sums| sums.sum(x, y, size.width, size.height) == 0)
    }

    /// The side of the largest blocks, and the number of places for one in the exemplars.
    pub fn blocks(&self) -> (usize, usize) {
        let side = 2 * self.band;
        let block = Size::new(side, side);
        let places = self.quantised.texels().iter().enumerate().map(|(number, texels)| {
            let size = texels.size();
            let columns = (size.width + 1).saturating_sub(side);
            let rows = 0..(size.height + 1).saturating_sub(side);
            let places = rows.flat_map(|y| (0..columns).map(move |x| (x, y)));
            places.filter(|place| self.is_free(number, *place, block)).count()
        });
        (side, places.sum())
    }

    /// The texel of the torus at a place of a block.
    fn texel(&self, bridge: Bridge, (x, y): (usize, usize)) -> usize {
        let at = |start: isize, by: usize, length: usize| {
            (start + by.cast_signed()).rem_euclid(length.cast_signed()).cast_unsigned()
        };
        self.size.index(at(bridge.x, x, self.size.width), at(bridge.y, y, self.size.height))
    }

    fn codes(&self, texel: Texel) -> &[i16] {
        self.quantised.texels()[texel.exemplar as usize].run(texel.x as usize, texel.y as usize, 1)
    }

    /// The top left texel of the block of the exemplars that fits under the rim best.
    fn best(&self, bridge: Bridge, spectra: &[ExemplarSpectra<'_>]) -> Option<Texel> {
        let (rim, Size { width, height }) = (self.rim(), bridge.size);
        let places = (0..height).flat_map(|y| (0..width).map(move |x| (x, y)));
        let is_rim = |&(x, y): &(usize, usize)| x.min(y).min(width - 1 - x).min(height - 1 - y) < rim;
        let code = |place| (place, self.codes(self.sources[self.texel(bridge, place)]));
        let template = Template { size: bridge.size, texels: places.filter(is_rim).map(code).collect() };
        let found = (0u32..).zip(spectra).filter_map(|(number, spectra)| {
            let number_of = number as usize;
            let compared = template.compared(spectra);
            let ((x, y), error) = compared.best(|x, y| self.is_free(number_of, (x, y), bridge.size))?;
            Some((error, Texel { exemplar: number, y: y as u32, x: x as u32 }))
        });
        found.min().map(|(_, texel)| texel)
    }

    /// Puts a block, joined along a cut through each side of its rim.
    fn join(&mut self, bridge: Bridge, corner: Texel) {
        let (rim, Size { width, height }) = (self.rim(), bridge.size);
        let error = |x: usize, y: usize| {
            let old = self.sources[self.texel(bridge, (x, y))];
            squared_distance(self.codes(old), self.codes(corner.offset(x, y)))
        };
        let left = least_path(height, rim, |along, across| error(across, along));
        let right = least_path(height, rim, |along, across| error(width - 1 - across, along));
        let top = least_path(width, rim, error);
        let bottom = least_path(width, rim, |along, across| error(along, height - 1 - across));
        for (x, y) in (0..height).flat_map(|y| (0..width).map(move |x| (x, y))) {
            let inside =
                x >= left[y] && width - 1 - x >= right[y] && y >= top[x] && height - 1 - y >= bottom[x];
            if inside {
                let texel = self.texel(bridge, (x, y));
                self.sources[texel] = corner.offset(x, y);
            }
        }
    }
}
