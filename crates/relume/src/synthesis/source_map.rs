//! The source of each output texel: the result of synthesis.

use super::quantise::Exemplar;
use crate::job::Held;
use crate::size::Size;

/// A texel of an exemplar. Ordered by exemplar, row, column: the order that breaks ties.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Default, serde::Serialize)]
pub struct Texel {
    /// Which exemplar, from 0.
    pub exemplar: u32,
    /// Row from the top.
    pub y: u32,
    /// Column from the left.
    pub x: u32,
}

impl Texel {
    /// The texel `x` farther right and `y` farther down.
    pub fn offset(self, x: usize, y: usize) -> Self {
        Self { exemplar: self.exemplar, y: self.y + y as u32, x: self.x + x as u32 }
    }

    /// The texel `dx` farther right and `dy` farther down, if it has no negative coordinate.
    pub fn moved(self, dx: isize, dy: isize) -> Option<Self> {
        let x = self.x.checked_add_signed(i32::try_from(dx).ok()?)?;
        let y = self.y.checked_add_signed(i32::try_from(dy).ok()?)?;
        Some(Self { x, y, ..self })
    }
}

/// A share in a blended texel.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Part {
    /// Its source.
    pub source: Texel,
    /// Its weight; those of one texel sum to 1 up to rounding.
    pub weight: f32,
}

/// For each texel of an output the exemplar texel it copies, and the shares of blended texels.
#[derive(Debug, Clone, PartialEq)]
pub struct SourceMap {
    size: Size,
    exemplars: Vec<Size>,
    copies: Vec<Texel>,
    mixed: Vec<usize>,
    part_ends: Vec<usize>,
    parts: Vec<Part>,
    held: Held,
}

impl SourceMap {
    /// A map of copies.
    ///
    /// # Panics
    /// When there is not one source for each texel.
    pub(super) fn new(size: Size, exemplars: &[Exemplar<'_>], copies: Vec<Texel>) -> Self {
        let exemplars = exemplars.iter().map(|e| e.index.size()).collect();
        Self::of_sizes(size, exemplars, copies)
    }

    /// Another map of copies of the same exemplars.
    ///
    /// # Panics
    /// When there is not one source for each texel.
    pub(super) fn with_copies(&self, size: Size, copies: Vec<Texel>) -> Self {
        Self::of_sizes(size, self.exemplars.clone(), copies)
    }

    /// The map in which each texel stands for `factor` x `factor` texels, of an exemplar of the given size at
    /// the finer resolution.
    ///
    /// # Panics
    /// When there are blended texels, or the finer exemplar is smaller than `factor` times the coarse one.
    pub fn finer(&self, factor: usize, exemplar: Size) -> Self {
        let Size { width, height } = self.exemplars[0];
        assert!(
            self.mixed.is_empty() && factor * width <= exemplar.width && factor * height <= exemplar.height
        );
        let size = Size::new(factor * self.size.width, factor * self.size.height);
        let copy = |i: usize| {
            let (x, y) = (i % size.width, i / size.width);
            let Texel { exemplar, x: column, y: row } = self.copies[self.size.index(x / factor, y / factor)];
            let along = |coarse: u32, at: usize| coarse * factor as u32 + (at % factor) as u32;
            Texel { exemplar, x: along(column, x), y: along(row, y) }
        };
        Self::of_sizes(size, vec![exemplar], (0..size.texels()).map(copy).collect())
    }

    fn of_sizes(size: Size, exemplars: Vec<Size>, copies: Vec<Texel>) -> Self {
        assert_eq!(copies.len(), size.texels(), "one source for each texel");
        let (mixed, part_ends, parts) = (Vec::new(), Vec::new(), Vec::new());
        Self { size, exemplars, copies, mixed, part_ends, parts, held: Held::default() }
    }

    /// The same map; what was held for more than it takes is given back once it is dropped.
    pub(super) fn holding(mut self, mut held: Held) -> Self {
        held.shrink(self.bytes());
        self.held = held;
        self
    }

    fn bytes(&self) -> u64 {
        let mixes = size_of_val(&*self.mixed) + size_of_val(&*self.part_ends) + size_of_val(&*self.parts);
        (size_of_val(&*self.copies) + mixes) as u64
    }

    /// Marks a texel as a blend; texels come in increasing order. Its dominant source is the share with the
    /// largest weight, the first among equals.
    pub(super) fn push_mix(&mut self, texel: usize, parts: &[Part]) {
        debug_assert!(self.mixed.last().is_none_or(|last| *last < texel), "texels in rising order");
        let heavier = |a: Part, b: &Part| if b.weight > a.weight { *b } else { a };
        self.copies[texel] = parts.iter().skip(1).fold(parts[0], heavier).source;
        self.mixed.push(texel);
        self.parts.extend_from_slice(parts);
        self.part_ends.push(self.parts.len());
    }

    /// Width and height of the output.
    pub fn size(&self) -> Size {
        self.size
    }

    /// The sizes of the exemplars it points into.
    pub fn exemplars(&self) -> &[Size] {
        &self.exemplars
    }

    /// The source of each texel, row by row; for blended texels the dominant one.
    pub fn copies(&self) -> &[Texel] {
        &self.copies
    }

    /// The blended texels in increasing order, with their shares.
    pub fn mixes(&self) -> impl Iterator<Item = (usize, &[Part])> {
        let starts = std::iter::once(0).chain(self.part_ends.iter().copied());
        let ranges = starts.zip(&self.part_ends).map(|(start, &end)| &self.parts[start..end]);
        self.mixed.iter().copied().zip(ranges)
    }

    /// The number of blended texels.
    pub fn mix_count(&self) -> usize {
        self.mixed.len()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::planes::Planes;

    #[test]
    fn mixes_are_given_back_with_their_dominant_source() {
        let index = Planes::zeros(Size::new(4, 4), 1);
        let exemplars = [Exemplar { index: &index, excluded: None }];
        let at = |x, y| Texel { exemplar: 0, y, x };
        let mut map = SourceMap::new(Size::new(3, 1), &exemplars, vec![at(0, 0); 3]);
        let first = [Part { source: at(1, 1), weight: 0.25 }, Part { source: at(2, 1), weight: 0.75 }];
        let second = [Part { source: at(3, 0), weight: 0.5 }, Part { source: at(0, 2), weight: 0.5 }];
        map.push_mix(0, &first);
        map.push_mix(2, &second);
        assert_eq!(map.mixes().collect::<Vec<_>>(), [(0, &first[..]), (2, &second[..])]);
        assert_eq!(map.copies(), [at(2, 1), at(0, 0), at(3, 0)]);
        assert_eq!((map.mix_count(), map.exemplars()), (2, &[Size::new(4, 4)][..]));
    }
}
