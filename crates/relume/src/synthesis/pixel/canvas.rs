//! The output while texels are added one by one.

use std::ops::Range;

use crate::error::Result;
use crate::job::{Held, Job};
use crate::memory;
use crate::size::Size;
use crate::synthesis::options::Boundary;
use crate::synthesis::quantise::{Exemplar, IndexTexels, Quantised};
use crate::synthesis::source_map::{SourceMap, Texel};

/// Codes and sources of the texels that are known, on an open rectangle or a torus.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct PixelCanvas {
    size: Size,
    planes: usize,
    /// The number of the last planes, which are given and not copied.
    guides: usize,
    boundary: Boundary,
    codes: Vec<i16>,
    sources: Vec<Texel>,
    known: Vec<bool>,
    held: Held,
}

/// What the output is called in a refusal.
const WHAT: &str = "the synthesised output";

impl PixelCanvas {
    /// A canvas without known texels.
    ///
    /// # Errors
    /// When it exceeds the limits.
    pub fn new(size: Size, planes: usize, boundary: Boundary, job: &Job) -> Result<Self> {
        let bytes = (planes * size_of::<i16>() + size_of::<Texel>() + size_of::<bool>()) as u64;
        job.check(WHAT, size, bytes)?;
        let texels = size.texels();
        Ok(Self {
            size,
            planes,
            guides: 0,
            boundary,
            codes: memory::zeros(WHAT, texels * planes)?,
            sources: memory::zeros(WHAT, texels)?,
            known: memory::zeros(WHAT, texels)?,
            held: job.hold(WHAT, bytes * texels as u64)?,
        })
    }

    /// Sets the last planes of every texel to the codes of the guide of the output, permanently.
    pub fn guide(&mut self, target: &IndexTexels) {
        assert_eq!(target.size(), self.size, "a guide is as large as the output");
        let guides = target.planes();
        self.guides = guides;
        for (y, row) in self.codes.chunks_exact_mut(self.size.width * self.planes).enumerate() {
            let theirs = target.run(0, y, self.size.width);
            let texels = row.chunks_exact_mut(self.planes).zip(theirs.chunks_exact(guides));
            texels.for_each(|(to, from)| to[self.planes - guides..].copy_from_slice(from));
        }
    }

    /// The number of given planes.
    pub fn guides(&self) -> usize {
        self.guides
    }

    /// The given codes of a texel.
    pub fn guide_codes(&self, texel: usize) -> &[i16] {
        &self.codes(texel)[self.planes - self.guides..]
    }

    /// The codes of a texel that are copied with it.
    pub fn copied_codes(&self, texel: usize) -> &[i16] {
        &self.codes(texel)[..self.planes - self.guides]
    }

    /// Width and height.
    pub fn size(&self) -> Size {
        self.size
    }

    /// The texel `dx` columns to the right and `dy` rows down; `None` beyond an open edge.
    ///
    /// # Panics
    /// On a torus, when the distance exceeds the size of the torus.
    pub fn neighbour(&self, texel: usize, dx: isize, dy: isize) -> Option<usize> {
        self.beside(self.place(texel), dx, dy)
    }

    /// The column and row of a texel.
    #[inline]
    pub fn place(&self, texel: usize) -> (usize, usize) {
        (texel % self.size.width, texel / self.size.width)
    }

    /// As [`PixelCanvas::neighbour`], from a column and row.
    #[inline]
    pub fn beside(&self, (x, y): (usize, usize), dx: isize, dy: isize) -> Option<usize> {
        let Size { width, height } = self.size;
        let (x, y) = (step(x, dx, width, self.boundary)?, step(y, dy, height, self.boundary)?);
        Some(self.size.index(x, y))
    }

    /// Appends the codes of consecutive texels of a torus, from `dx` columns to the right and `dy` rows down
    /// of a position.
    ///
    /// # Panics
    /// When they lie beyond an open edge.
    pub fn append_row(
        &self,
        place: (usize, usize),
        (dx, dy): (isize, isize),
        length: usize,
        codes: &mut Vec<i16>,
    ) {
        let first = place.0.checked_add_signed(dx);
        let inside = first.is_some_and(|first| first + length <= self.size.width);
        let texel = |dx| self.beside(place, dx, dy).expect("a torus has no edge");
        if inside {
            codes.extend_from_slice(&self.codes[texel(dx) * self.planes..][..length * self.planes]);
        } else {
            (dx..dx + length.cast_signed()).for_each(|dx| codes.extend_from_slice(self.codes(texel(dx))));
        }
    }

    /// The rows of the square of texels within `radius` of one; `None` if it extends beyond an edge.
    pub fn inner_rows(
        &self,
        texel: usize,
        radius: usize,
    ) -> Option<impl Iterator<Item = Range<usize>> + use<>> {
        let (x, y) = self.place(texel);
        let Size { width, height } = self.size;
        let inside = |at: usize, length: usize| at >= radius && at + radius < length;
        (inside(x, width) && inside(y, height)).then(|| {
            let starts = (y - radius..=y + radius).map(move |y| y * width + x - radius);
            starts.map(move |start| start..start + 2 * radius + 1)
        })
    }

    /// The number of texels in the ranges that are known.
    pub fn known_in(&self, ranges: &mut dyn Iterator<Item = Range<usize>>) -> usize {
        ranges.map(|range| self.known[range].iter().filter(|known| **known).count()).sum()
    }

    /// Whether a texel is known.
    pub fn is_known(&self, texel: usize) -> bool {
        self.known[texel]
    }

    /// The unknown texels.
    pub fn unknown(&self) -> impl Iterator<Item = usize> {
        (0..self.known.len()).filter(|&texel| !self.known[texel])
    }

    /// The codes of a texel.
    pub fn codes(&self, texel: usize) -> &[i16] {
        &self.codes[texel * self.planes..][..self.planes]
    }

    /// The source of a texel.
    pub fn source(&self, texel: usize) -> Texel {
        self.sources[texel]
    }

    /// The sources of the texels of a row.
    pub fn sources(&self, y: usize) -> &[Texel] {
        &self.sources[y * self.size.width..][..self.size.width]
    }

    /// Puts a copy of an exemplar texel.
    pub fn put(&mut self, texel: usize, source: Texel, exemplars: &Quantised) {
        let from = exemplars.texels()[source.exemplar as usize].run(source.x as usize, source.y as usize, 1);
        let copied = self.planes - self.guides;
        self.codes[texel * self.planes..][..copied].copy_from_slice(&from[..copied]);
        self.sources[texel] = source;
        self.known[texel] = true;
    }

    /// The finished map.
    pub fn into_map(self, exemplars: &[Exemplar<'_>]) -> SourceMap {
        SourceMap::new(self.size, exemplars, self.sources).holding(self.held)
    }
}

/// The coordinate `by` farther than `from` of 0 to `length` - 1; `None` beyond an open edge.
fn step(from: usize, by: isize, length: usize, boundary: Boundary) -> Option<usize> {
    match from.checked_add_signed(by).filter(|&to| to < length) {
        None if boundary == Boundary::Torus => {
            let length = length.cast_signed();
            let to = from.cast_signed() + by + if by < 0 { length } else { -length };
            assert!((0..length).contains(&to), "a step of {by} on a torus of {length}");
            Some(to.cast_unsigned())
        }
        to => to,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rows_are_those_of_their_texels() {
        let index =
            crate::planes::Planes::from_vec(Size::new(4, 2), 2, (0..16).map(|v| v as f32).collect()).unwrap();
        let exemplars = [Exemplar { index: &index, excluded: None }];
        let exemplars = Quantised::new(&exemplars, &Job::default()).unwrap();
        let mut canvas = PixelCanvas::new(Size::new(5, 3), 2, Boundary::Torus, &Job::default()).unwrap();
        for texel in 0..15 {
            let source = Texel { exemplar: 0, y: (texel % 2) as u32, x: (texel % 4) as u32 };
            canvas.put(texel, source, &exemplars);
        }
        for (x, dx, dy) in (0..5).flat_map(|x| (-5..3).flat_map(move |dx| (-2..3).map(move |dy| (x, dx, dy))))
        {
            let (mut row, mut truth) = (vec![7], vec![7]);
            canvas.append_row((x, 1), (dx, dy), 3, &mut row);
            for dx in dx..dx + 3 {
                truth.extend_from_slice(canvas.codes(canvas.beside((x, 1), dx, dy).unwrap()));
            }
            assert_eq!(row, truth);
        }
    }

    #[test]
    fn inner_rows_are_the_texels_around() {
        let canvas = PixelCanvas::new(Size::new(7, 6), 1, Boundary::Open, &Job::default()).unwrap();
        for (texel, radius) in (0..42).flat_map(|texel| [1, 2].map(|radius| (texel, radius))) {
            let reach = -(radius as isize)..=radius as isize;
            let places = reach.clone().flat_map(|dy| reach.clone().map(move |dx| (dx, dy)));
            let truth: Option<Vec<usize>> = places.map(|(dx, dy)| canvas.neighbour(texel, dx, dy)).collect();
            assert_eq!(canvas.inner_rows(texel, radius).map(|rows| rows.flatten().collect()), truth);
        }
    }

    #[test]
    fn neighbours_end_at_open_edges_and_go_on_around_a_torus() {
        let at = |boundary| PixelCanvas::new(Size::new(5, 3), 1, boundary, &Job::default()).unwrap();
        let (open, torus) = (at(Boundary::Open), at(Boundary::Torus));
        for texel in 0..15 {
            for (dx, dy) in (-3..=3).flat_map(|dy| (-5..=5).map(move |dx| (dx, dy))) {
                let (x, y) = ((texel % 5) as isize + dx, (texel / 5) as isize + dy);
                let around = (y.rem_euclid(3) * 5 + x.rem_euclid(5)) as usize;
                assert_eq!(torus.neighbour(texel, dx, dy), Some(around));
                let inside = (0..5).contains(&x) && (0..3).contains(&y);
                assert_eq!(open.neighbour(texel, dx, dy), inside.then_some(around));
            }
        }
    }
}
