//! The plane of texels divided into equal cells, one at each point of a lattice of whole texels.
//!
//! With the steps u = (w, t) to the cell at the right and v = (s, h) to the cell below, the cell at i u + j v
//! holds the texels p for which p - i u - j v lies in the parallelogram of u and v: i = floor((p x v) / (u x
//! v)), j = floor((u x p) / (u x v)), in integer arithmetic. Oblique cells follow oblique periods to half a
//! texel; upright ones (s = t = 0) are rectangles.

use serde::Serialize;

use crate::size::Size;

/// Equal cells, given by the steps from one to the next. Coordinates within a cell are relative to its
/// lattice point, x to the right and y down; they are negative where an oblique cell extends to the other
/// side of it.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
pub struct Cells {
    right: [i64; 2],
    down: [i64; 2],
}

/// A cell by its numbers to the right and down, and a texel's coordinates in it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Place {
    /// Numbers of the cell.
    pub cell: [i64; 2],
    /// Coordinates of the texel from the cell's lattice point.
    pub texel: [i64; 2],
}

impl Cells {
    /// The longest side of a cell: products of sides and far places stay within 128 bits.
    const LONGEST: i64 = 1 << 30;

    /// Cells from the steps to the cell at the right and to the one below; `None` if a step is not longer
    /// along its own axis than across it, or is too long.
    pub fn new(right: [i64; 2], down: [i64; 2]) -> Option<Self> {
        let leans_little = |along: i64, aside: i64| along <= Self::LONGEST && aside.saturating_abs() < along;
        (leans_little(right[0], right[1]) && leans_little(down[1], down[0])).then_some(Self { right, down })
    }

    /// Rectangles; `None` where they have no texels.
    pub fn upright(size: Size) -> Option<Self> {
        let side = |n: usize| i64::try_from(n).ok();
        Self::new([side(size.width)?, 0], [0, side(size.height)?])
    }

    /// The step to the cell at the right.
    pub fn right(&self) -> [i64; 2] {
        self.right
    }

    /// The step to the cell below.
    pub fn down(&self) -> [i64; 2] {
        self.down
    }

    /// Whether cells are rectangles.
    pub fn are_upright(&self) -> bool {
        self.right[1] == 0 && self.down[0] == 0
    }

    /// The number of texels of a cell.
    pub fn texels(&self) -> i64 {
        self.right[0] * self.down[1] - self.right[1] * self.down[0]
    }

    /// The bounding rectangle of a cell.
    pub fn bounds(&self) -> Size {
        let side = |along: i64, aside: i64| (along + aside.abs()) as usize;
        Size::new(side(self.right[0], self.down[0]), side(self.down[1], self.right[1]))
    }

    /// The coordinates of the top left texel of that rectangle: zero or less.
    pub fn origin(&self) -> [i64; 2] {
        [self.down[0].min(0), self.right[1].min(0)]
    }

    /// The cell of a texel of the plane, and the position of the texel in it.
    pub fn place(&self, [x, y]: [i64; 2]) -> Place {
        let ([w, t], [s, h]) = (self.right, self.down);
        let [i, j] = if self.are_upright() {
            [x.div_euclid(w), y.div_euclid(h)]
        } else {
            let whole = self.texels();
            [floor_of(cross([x, y], self.down), whole), floor_of(cross(self.right, [x, y]), whole)]
        };
        Place { cell: [i, j], texel: [x - i * w - j * s, y - i * t - j * h] }
    }

    /// The index of a texel in the rectangle that holds the cell, row after row.
    pub fn index(&self, [x, y]: [i64; 2]) -> usize {
        let [left, top] = self.origin();
        self.bounds().index((x - left) as usize, (y - top) as usize)
    }

    /// The coordinates of all texels of the rectangle that holds a cell, row after row.
    pub fn rectangle(&self) -> impl Iterator<Item = [i64; 2]> + use<> {
        let ([left, top], Size { width, height }) = (self.origin(), self.bounds());
        (0..width * height).map(move |t| [left + (t % width) as i64, top + (t / width) as i64])
    }

    /// The first column of a row that is not left of the left side of the cell, or of its continuation.
    pub fn left_side(&self, y: i64) -> i64 {
        ceiling(self.down[0] * y, self.down[1])
    }

    /// The first row of a column that is not above the upper side of the cell, or of its continuation.
    pub fn upper_side(&self, x: i64) -> i64 {
        ceiling(self.right[1] * x, self.right[0])
    }

    /// The first column to the right of the cell in a row that it intersects.
    pub fn end_of_row(&self, y: i64) -> i64 {
        let ([w, t], [s, h]) = (self.right, self.down);
        if self.are_upright() {
            return w;
        }
        let right = w + self.left_side(y - t);
        match t {
            0 => right,
            1.. => right.min((w * y).div_euclid(t) + 1),
            _ => right.min(s + ceiling(w * (h - y), -t)),
        }
    }

    /// The number of texels between a texel and the nearest side of the cell, along its row and its column;
    /// `None` outside.
    pub fn depth(&self, [x, y]: [i64; 2]) -> Option<usize> {
        let ([w, t], [s, h]) = (self.right, self.down);
        let sides = [
            x - self.left_side(y),
            w + self.left_side(y - t) - 1 - x,
            y - self.upper_side(x),
            h + self.upper_side(x - s) - 1 - y,
        ];
        usize::try_from(sides.into_iter().min()?).ok()
    }
}

/// a x b = ax by - ay bx.
fn cross(a: [i64; 2], b: [i64; 2]) -> i128 {
    i128::from(a[0]) * i128::from(b[1]) - i128::from(a[1]) * i128::from(b[0])
}

/// The largest integer that is at most a / b, in 64 bits where they suffice.
fn floor_of(a: i128, b: i64) -> i64 {
    i64::try_from(a).map_or_else(|_| a.div_euclid(i128::from(b)) as i64, |a| a.div_euclid(b))
}

/// The least integer that is at least a / b, for positive b.
fn ceiling(a: i64, b: i64) -> i64 {
    -(-a).div_euclid(b)
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(150))]

        /// Each texel lies in exactly one cell.
        #[test]
        fn cells_cover_the_plane_once(
            (w, h, s, t) in (1i64..14, 1i64..14, -13i64..14, -13i64..14),
            (x, y) in (-40i64..40, -40i64..40),
        ) {
            let cells = Cells::new([w, t % w], [s % h, h]).unwrap();
            let ([w, t], [s, h]) = (cells.right(), cells.down());
            let place = cells.place([x, y]);
            let holders = (-90..90).flat_map(|i| (-90..90).map(move |j| [i, j]));
            let holders: Vec<[i64; 2]> = holders
                .filter(|[i, j]| cells.depth([x - i * w - j * s, y - i * t - j * h]).is_some())
                .collect();
            if place.cell.iter().all(|n| n.abs() < 90) {
                prop_assert_eq!(holders, vec![place.cell]);
            }
            prop_assert_eq!(cells.rectangle().position(|p| p == place.texel), Some(cells.index(place.texel)));
            let held = cells.rectangle().filter(|&p| cells.depth(p).is_some()).count();
            prop_assert_eq!(held as i64, cells.texels());
        }

        /// A texel whose neighbour belongs to another cell lies at a side.
        #[test]
        fn depth_counts_from_the_sides(
            (w, h, s, t) in (4i64..16, 4i64..16, -15i64..16, -15i64..16),
        ) {
            let cells = Cells::new([w, t % w], [s % h, h]).unwrap();
            for p in cells.rectangle().filter(|&p| cells.depth(p).is_some()) {
                let beside = [[1, 0], [-1, 0], [0, 1], [0, -1]].map(|[dx, dy]| [p[0] + dx, p[1] + dy]);
                let is_inside = beside.iter().all(|&q| cells.depth(q).is_some());
                prop_assert_eq!(cells.depth(p) > Some(0), is_inside, "{:?} of {:?}", p, cells);
                let last = cells.depth([p[0] + 1, p[1]]).is_none();
                prop_assert_eq!(cells.end_of_row(p[1]) == p[0] + 1, last, "{:?} of {:?}", p, cells);
            }
        }
    }

    #[test]
    fn upright_cells_are_rectangles() {
        let cells = Cells::upright(Size::new(7, 5)).unwrap();
        assert!(cells.are_upright() && cells.bounds() == Size::new(7, 5) && cells.origin() == [0, 0]);
        assert_eq!(cells.place([-1, 12]), Place { cell: [-1, 2], texel: [6, 2] });
        assert_eq!((cells.depth([3, 2]), cells.depth([6, 2]), cells.depth([7, 2])), (Some(2), Some(0), None));
        assert_eq!(cells.place([1 << 52, -(1 << 52)]).texel, [(1 << 52) % 7, (-(1i64 << 52)).rem_euclid(5)]);
    }

    #[test]
    fn cells_that_lean_too_far_or_hold_nothing_are_refused() {
        assert!(Cells::new([4, 4], [0, 9]).is_none() && Cells::new([4, 0], [-9, 9]).is_none());
        assert!(Cells::new([0, 0], [0, 9]).is_none() && Cells::new([5, 0], [0, -3]).is_none());
        assert!(Cells::new([i64::MAX, 0], [0, 3]).is_none() && Cells::new([4, i64::MIN], [0, 3]).is_none());
        assert!(Cells::upright(Size::new(0, 3)).is_none());
    }
}
