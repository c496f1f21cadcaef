//! Positions that a search leaves out: squares about some others.

use crate::synthesis::source_map::Texel;

/// Squares of positions.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Avoided {
    squares: Vec<AvoidedSquare>,
}

/// The positions within a number of texels of one, along x and y.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
struct AvoidedSquare {
    middle: Texel,
    within: u32,
}

impl AvoidedSquare {
    fn contains(&self, at: Texel) -> bool {
        let Self { middle, within } = *self;
        middle.exemplar == at.exemplar && middle.x.abs_diff(at.x).max(middle.y.abs_diff(at.y)) <= within
    }
}

impl Avoided {
    /// Adds the positions within a number of texels of one, unless so many could be left out then that more than `most`
    /// are.
    pub fn add(&mut self, middle: Texel, within: u32, most: usize) {
        self.squares.push(AvoidedSquare { middle, within });
        let area = |square: &AvoidedSquare| (2 * square.within as usize + 1).pow(2);
        if self.squares.iter().map(area).sum::<usize>() > most {
            self.squares.pop();
        }
    }

    /// Whether nothing is left out.
    pub fn is_empty(&self) -> bool {
        self.squares.is_empty()
    }

    /// Whether a position is left out.
    pub fn contains(&self, at: Texel) -> bool {
        self.squares.iter().any(|square| square.contains(at))
    }

    /// Replaces the values of the positions that are left out, of those from `first` on to the right.
    pub fn strike<T: Copy>(&self, first: Texel, values: &mut [T], value: T) {
        for &AvoidedSquare { middle, within } in &self.squares {
            if middle.exemplar == first.exemplar && middle.y.abs_diff(first.y) <= within {
                let column = |x: u32| (x.saturating_sub(first.x) as usize).min(values.len());
                let (from, to) = (column(middle.x.saturating_sub(within)), column(middle.x + within + 1));
                values[from..to].fill(value);
            }
        }
    }

    /// Those at half the resolution: no position that is left, nor a neighbour of one, is left out at the whole one.
    pub fn halved(&self) -> Self {
        let half = |&AvoidedSquare { middle, within }: &AvoidedSquare| AvoidedSquare {
            middle: Texel { x: middle.x / 2, y: middle.y / 2, ..middle },
            within: within / 2 + 2,
        };
        Self { squares: self.squares.iter().map(half).collect() }
    }
}
