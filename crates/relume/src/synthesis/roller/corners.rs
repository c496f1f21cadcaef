//! Tiles whose borders vary: a tile for each choice of colours of its four corners.
//!
//! Where a texture does not repeat, one border common to all tiles shows as a grid. Here each lattice point of
//! the plane has a colour, and a tile fits wherever its four corners have the colours that it was made for: A.
//! Lagae, P. Dutré, "An Alternative for Wang Tiles: Colored Edges versus Colored Corners", ACM Transactions on
//! Graphics 25(4), 2006, after M. Cohen, J. Shade, S. Hiller, O. Deussen, "Wang Tiles for Image and Texture
//! Generation", SIGGRAPH 2003. With c colours there are c^4 tiles, c^2 borders along each axis and c corners.
//!
//! 1. Each colour is a square piece of the exemplar around the corner.
//! 2. Each border is the strip of the exemplar that fits the pieces at both of its ends best ([`Template`]),
//!    joined to them by cuts of least error.
//! 3. Each tile is the part of the exemplar that fits its four borders best, joined to them by a closed cut
//!    ([`least_closed_cut`]).

use super::closed_cut::least_closed_cut;
use super::further::TilePart;
use super::lay::lay;
use super::profile::squared_distance;
use super::region::Strips;
use super::seams::TileSeams;
use super::template::{ExemplarSpectra, Template};
use super::tile_set::TileSet;
use crate::error::{Error, Result};
use crate::job::Job;
use crate::numeric::cells::Cells;
use crate::numeric::corner_colors::CornerColors;
use crate::parallel;
use crate::size::Size;
use crate::synthesis::cut::path::least_path;
use crate::synthesis::options::Boundary;
use crate::synthesis::quantise::IndexTexels;
use crate::synthesis::source_map::Texel;

/// Sides of a tile in widths of its border: four for the pieces at its corners, three for the strip between
/// them.
const SIDE_IN_BORDERS: usize = 7;

/// The least width of a border in texels.
const LEAST_BORDER: usize = 3;

/// Cells along a side of the part of the plane whose seams are measured: each of 16 tiles four times on average.
const MEASURED_CELLS: usize = 8;

/// The seams of a part of the plane that repeats, with those between its tiles.
pub fn laid_seams(tiles: &TileSet, texels: &IndexTexels, step: f64, job: &Job) -> Result<TileSeams> {
    let Size { width, height } = tiles.tile();
    let size = Size::new(MEASURED_CELLS * width, MEASURED_CELLS * height);
    let laid = lay(tiles, size, Boundary::Torus, 0, job)?;
    let cells = Cells::upright(size).expect("the part has texels");
    Ok(TileSeams::measure(texels, step, &cells, laid.copies()))
}

/// What tiles with coloured corners are made from.
pub struct CornerWork<'a> {
    /// The codes of the exemplar.
    pub texels: &'a IndexTexels,
    /// The places without excluded texels.
    pub strips: &'a Strips<'a>,
    /// The size of a tile.
    pub tile: Size,
    /// Texels from the edge of a tile to the end of what it shares with its neighbours.
    pub border: usize,
    /// The colours of the corners.
    pub colors: CornerColors,
    /// The job.
    pub job: &'a Job,
}

/// The width of the border of tiles of a size, at most the given one; `None` if they are too small.
pub fn border(tile: Size, most: usize) -> Option<usize> {
    let border = (tile.width.min(tile.height) / SIDE_IN_BORDERS).min(most);
    (border >= LEAST_BORDER).then_some(border)
}

/// A border along an axis: `long` x `2 border` texels if it lies across, from the middle of the piece at one
/// end to that at the other.
struct BorderStrip {
    sources: Vec<Texel>,
    long: usize,
}

/// The direction of a border.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Along {
    Row,
    Column,
}

impl Along {
    /// Column and row of a place along and across.
    fn place(self, along: usize, across: usize) -> (usize, usize) {
        if self == Self::Row { (along, across) } else { (across, along) }
    }

    fn size(self, along: usize, across: usize) -> Size {
        let (width, height) = self.place(along, across);
        Size::new(width, height)
    }
}

impl CornerWork<'_> {
    /// The sources of all tiles, in the order of [`CornerColors::corners`], and further ones of the same
    /// corners up to `count`.
    ///
    /// # Errors
    /// When the exemplar has no room for the pieces or the tiles.
    pub fn tiles(&self, count: usize) -> Result<(Vec<Vec<Texel>>, Vec<TilePart>)> {
        let spectra = ExemplarSpectra::new(self.texels);
        let pieces = self.pieces()?;
        let pairs = || (0..self.colors.count()).flat_map(|a| (0..self.colors.count()).map(move |b| (a, b)));
        let borders = |along: Along| -> Result<Vec<BorderStrip>> {
            let pairs: Vec<(usize, usize)> = pairs().collect();
            let strip = |&(a, b): &(usize, usize)| {
                self.job.proceed()?;
                self.strip(along, [pieces[a], pieces[b]], &spectra)
            };
            parallel::try_map(pairs.iter(), strip)
        };
        let (rows, columns) = (borders(Along::Row)?, borders(Along::Column)?);
        let mut taken = Vec::new();
        let mut tiles = Vec::new();
        for number in 0..count {
            self.job.proceed()?;
            let [c00, c10, c01, c11] = self.colors.corners(number);
            let colors = self.colors.count();
            let bordered = Bordered {
                work: self,
                corners: [c00, c10, c01, c11].map(|color| pieces[color]),
                rows: [&rows[c00 * colors + c10], &rows[c01 * colors + c11]],
                columns: [&columns[c00 * colors + c01], &columns[c10 * colors + c11]],
            };
            let (tile, part) = self.tile(&bordered, &spectra, &taken)?;
            taken.push(part);
            tiles.push(tile);
        }
        Ok((tiles, taken))
    }

    /// The top left texel of the piece of each colour, spread over the exemplar.
    fn pieces(&self) -> Result<Vec<(usize, usize)>> {
        let (size, side) = (self.texels.size(), 4 * self.border);
        let piece = Size::new(side, side);
        let rows = 0..(size.height + 1).saturating_sub(side);
        let columns = (size.width + 1).saturating_sub(side);
        let places = rows.flat_map(|y| (0..columns).map(move |x| (x, y)));
        let places: Vec<(usize, usize)> = places.filter(|&(x, y)| self.strips.allows(x, y, piece)).collect();
        let count = self.colors.count();
        // Evenly along the places in order, and across them by the golden section.
        let target = |color: usize| {
            let (across, down) =
                ((color as f64 * 0.618_034 + 0.3).fract(), (color as f64 + 0.5) / count as f64);
            ((columns as f64 * across) as usize, (size.height.saturating_sub(side) as f64 * down) as usize)
        };
        let nearest = |color: usize| {
            let (x, y) = target(color);
            let distance = |&&(px, py): &&(usize, usize)| px.abs_diff(x).pow(2) + py.abs_diff(y).pow(2);
            places.iter().min_by_key(distance).copied()
        };
        let found: Option<Vec<(usize, usize)>> = (0..count).map(nearest).collect();
        found.ok_or_else(|| self.no_room("the pieces around the corners of tiles"))
    }

    fn no_room(&self, what: &str) -> Error {
        Error::usage(format!(
            "the exemplar of {} has no room for {what} of {} whose borders vary: exclude less, or ask for fewer than \
             16 tiles",
            self.texels.size(),
            self.tile
        ))
    }

    /// The border between two pieces.
    fn strip(
        &self,
        along: Along,
        ends: [(usize, usize); 2],
        spectra: &ExemplarSpectra<'_>,
    ) -> Result<BorderStrip> {
        let n = self.border;
        let long = if along == Along::Row { self.tile.width } else { self.tile.height };
        let size = along.size(long, 2 * n);
        // The pieces reach two borders from their middle; the outer one of them overlaps the strip.
        let piece = |a: usize, c: usize| {
            let (end, from) = if a < 2 * n { (ends[0], a + 2 * n) } else { (ends[1], a + 2 * n - long) };
            let (x, y) = along.place(from, c + n);
            texel(end.0 + x, end.1 + y)
        };
        let overlap = (n..2 * n).chain(long - 2 * n..long - n);
        let places: Vec<(usize, usize)> = overlap.flat_map(|a| (0..2 * n).map(move |c| (a, c))).collect();
        let codes = places.iter().map(|&(a, c)| (along.place(a, c), self.run(piece(a, c)))).collect();
        let template = Template { size, texels: codes };
        let best = template.compared(spectra).best(|x, y| self.strips.allows(x, y, size));
        let ((x, y), _) = best.ok_or_else(|| self.no_room("the borders of tiles"))?;
        let strip = |a: usize, c: usize| {
            let (dx, dy) = along.place(a, c);
            texel(x + dx, y + dy)
        };
        let error = |a: usize, c: usize| squared_distance(self.run(piece(a, c)), self.run(strip(a, c)));
        let first = least_path(2 * n, n, |c, by| error(n + by, c));
        let last = least_path(2 * n, n, |c, by| error(long - 2 * n + by, c));
        let source = |(a, c): (usize, usize)| {
            let is_piece = a < n + first[c] || a > long - 2 * n + last[c];
            if is_piece { piece(a, c) } else { strip(a, c) }
        };
        let places = (0..long).flat_map(|a| (0..2 * n).map(move |c| (a, c)));
        Ok(BorderStrip { sources: places.map(source).collect(), long })
    }

    /// The tile inside a border, and the part of the exemplar that fills it: the one that fits best, away from
    /// those taken if there is room.
    fn tile(
        &self,
        bordered: &Bordered<'_>,
        spectra: &ExemplarSpectra<'_>,
        taken: &[TilePart],
    ) -> Result<(Vec<Texel>, TilePart)> {
        let Size { width, height } = self.tile;
        let cells = Cells::upright(self.tile).expect("a tile has texels");
        let places = || (0..height).flat_map(move |y| (0..width).map(move |x| (x, y)));
        let border: Vec<((usize, usize), Texel)> =
            places().filter_map(|place| Some((place, bordered.source(place)?))).collect();
        let texels = border.iter().map(|&(place, source)| (place, self.run(source))).collect();
        let template = Template { size: self.tile, texels };
        let compared = template.compared(spectra);
        let fits = |apart: usize| {
            compared.best(|x, y| {
                let is_apart = |part: &TilePart| x.abs_diff(part.x).max(y.abs_diff(part.y)) >= apart;
                taken.iter().all(is_apart) && self.strips.allows(x, y, self.tile)
            })
        };
        let mut apart = width.min(height) / 2;
        let ((px, py), border_error) = loop {
            match (fits(apart), apart) {
                (Some(place), _) => break place,
                (None, 0) => return Err(self.no_room("tiles")),
                (None, _) => apart /= 2,
            }
        };
        let inner = |(x, y): (usize, usize)| texel(px + x, py + y);
        let outer = |place| bordered.source(place).unwrap_or_else(|| inner(place));
        let error = |place| squared_distance(self.run(outer(place)), self.run(inner(place)));
        let errors: Vec<u64> = places().map(error).collect();
        let cut = least_closed_cut(&cells, self.border - 1, &errors);
        let source =
            |(place, inside): ((usize, usize), &bool)| if *inside { inner(place) } else { outer(place) };
        let part = TilePart { x: px, y: py, border_error };
        Ok((places().zip(&cut.inside).map(source).collect(), part))
    }

    fn run(&self, texel: Texel) -> &[i16] {
        self.texels.run(texel.x as usize, texel.y as usize, 1)
    }
}

/// The border of one tile.
struct Bordered<'a> {
    work: &'a CornerWork<'a>,
    /// The top left texels of the pieces: upper left, upper right, lower left, lower right.
    corners: [(usize, usize); 4],
    /// The upper and the lower border.
    rows: [&'a BorderStrip; 2],
    /// The left and the right border.
    columns: [&'a BorderStrip; 2],
}

impl Bordered<'_> {
    /// The source of a texel of the tile that lies in its border.
    fn source(&self, (x, y): (usize, usize)) -> Option<Texel> {
        let (n, Size { width, height }) = (self.work.border, self.work.tile);
        // Which end of the axis is near, and the place relative to the lattice line there.
        let side = |at: usize, length: usize| match at {
            at if at < n => Some((0, at + n)),
            at if at + n >= length => Some((1, at + n - length)),
            _ => None,
        };
        let source = |strip: &BorderStrip, along: usize, across: usize| {
            debug_assert!(along < strip.long, "inside the strip");
            strip.sources[along * 2 * n + across]
        };
        match (side(x, width), side(y, height)) {
            (Some((right, dx)), Some((below, dy))) => {
                let (left, top) = self.corners[2 * below + right];
                Some(texel(left + dx + n, top + dy + n))
            }
            (None, Some((below, dy))) => Some(source(self.rows[below], x, dy)),
            (Some((right, dx)), None) => Some(source(self.columns[right], y, dx)),
            (None, None) => None,
        }
    }
}

fn texel(x: usize, y: usize) -> Texel {
    Texel { exemplar: 0, y: y as u32, x: x as u32 }
}
