//! The copies of each place of a cell: the texels of the exemplar that lie at it, one for each cell.

use crate::numeric::lattice::{Lattice, length};
use crate::size::Size;
use crate::synthesis::quantise::IndexTexels;

/// The places of a cell on a grid of about one texel, along both vectors of the basis.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CellGrid {
    /// The lattice.
    pub lattice: Lattice,
    /// The numbers of places along its two vectors.
    pub size: Size,
}

impl CellGrid {
    /// The grid of a lattice.
    pub fn new(lattice: Lattice) -> Self {
        let [across, down] = lattice.basis().map(|v| length(v).round().max(1.0) as usize);
        Self { lattice, size: Size::new(across, down) }
    }

    /// The cell of a position of the plane, counted along the basis, and its place there.
    pub fn place(&self, position: [f64; 2]) -> ([i64; 2], usize) {
        let sides = [self.size.width, self.size.height];
        let numbers: [(i64, usize); 2] = std::array::from_fn(|k| {
            let steps = (self.lattice.coordinates(position)[k] * sides[k] as f64).round() as i64;
            (steps.div_euclid(sides[k] as i64), steps.rem_euclid(sides[k] as i64) as usize)
        });
        (numbers.map(|(cell, _)| cell), self.size.index(numbers[0].1, numbers[1].1))
    }

    /// The position of a place in a cell.
    pub fn position(&self, place: usize, cell: [i64; 2]) -> [f64; 2] {
        let step = |along: usize, side: usize, cell: i64| along as f64 / side as f64 + cell as f64;
        let Size { width, height } = self.size;
        self.lattice.point([step(place % width, width, cell[0]), step(place / width, height, cell[1])])
    }

    /// All cells of places in a picture, and those up to `beyond` cells farther, row by row of the lattice.
    pub fn cells_over(&self, size: Size, beyond: i64) -> Vec<[i64; 2]> {
        let (w, h) = (size.width as f64, size.height as f64);
        let corners = [[0.0, 0.0], [w, 0.0], [0.0, h], [w, h]].map(|p| self.lattice.coordinates(p));
        let range = |k: usize| {
            let least = corners.iter().map(|c| c[k]).fold(f64::INFINITY, f64::min);
            let most = corners.iter().map(|c| c[k]).fold(f64::NEG_INFINITY, f64::max);
            least.floor() as i64 - 1 - beyond..=most.ceil() as i64 + beyond
        };
        range(1).flat_map(|j| range(0).map(move |i| [i, j])).collect()
    }
}

/// The texel of a picture nearest to a position; `None` outside.
pub fn texel_at(size: Size, position: [f64; 2]) -> Option<(usize, usize)> {
    let [x, y] = position.map(|c| c.round() as i64);
    let inside = (0..size.width as i64).contains(&x) && (0..size.height as i64).contains(&y);
    inside.then_some((x as usize, y as usize))
}

/// The copies of each place of a cell.
#[derive(Debug)]
pub struct PlaceCopies<'a> {
    texels: &'a IndexTexels,
    excluded: Option<&'a [bool]>,
    grid: &'a CellGrid,
    cells: Vec<[i64; 2]>,
}

/// The number of copies of a place, and their means in codes, plane by plane.
#[derive(Debug, Clone, PartialEq)]
pub struct CopyMoments {
    count: f64,
    /// The mean of each plane.
    pub means: Vec<f64>,
    /// The mean of the sum of squares over all planes.
    squares: f64,
}

impl CopyMoments {
    /// The variance, as the sum over planes; `None` of a single copy.
    fn variance(&self) -> Option<f64> {
        let squared: f64 = self.means.iter().map(|mean| mean * mean).sum();
        (self.count > 1.0).then(|| ((self.squares - squared) * self.count / (self.count - 1.0)).max(0.0))
    }

    /// The mean squared distance from a colour.
    fn squared_distance(&self, colour: &[f64]) -> f64 {
        let products = self.means.iter().zip(colour).map(|(mean, c)| c * (c - 2.0 * mean));
        (self.squares + products.sum::<f64>()).max(0.0)
    }
}

impl<'a> PlaceCopies<'a> {
    /// The copies in an exemplar.
    pub fn new(texels: &'a IndexTexels, excluded: Option<&'a [bool]>, grid: &'a CellGrid) -> Self {
        Self { texels, excluded, grid, cells: grid.cells_over(texels.size(), 0) }
    }

    /// The copies of a place; `None` where the exemplar shows none.
    pub fn moments(&self, place: usize) -> Option<CopyMoments> {
        let (mut sums, mut squares, mut count) = (vec![0.0; self.texels.planes()], 0.0, 0u32);
        for &cell in &self.cells {
            let Some((x, y)) = texel_at(self.texels.size(), self.grid.position(place, cell)) else {
                continue;
            };
            if self.excluded.is_some_and(|mask| mask[self.texels.size().index(x, y)]) {
                continue;
            }
            for (sum, &code) in sums.iter_mut().zip(self.texels.run(x, y, 1)) {
                *sum += f64::from(code);
                squares += f64::from(code) * f64::from(code);
            }
            count += 1;
        }
        let n = f64::from(count);
        let means = sums.into_iter().map(|sum| sum / n).collect();
        (count > 0).then(|| CopyMoments { count: n, means, squares: squares / n })
    }

    /// The variance over the copies of each place, as the sum over planes in squared codes.
    pub fn variance(&self) -> Vec<f64> {
        self.everywhere(CopyMoments::variance)
    }

    /// The mean squared distance of the copies of each place from a colour.
    pub fn distance_from(&self, colour: &[f64]) -> Vec<f64> {
        self.everywhere(|moments| Some(moments.squared_distance(colour)))
    }

    /// A value for each place, smoothed over 3 x 3 places; the mean of the others where a place has none.
    fn everywhere(&self, value: impl Fn(&CopyMoments) -> Option<f64>) -> Vec<f64> {
        let places = 0..self.grid.size.texels();
        let raw: Vec<Option<f64>> =
            places.map(|place| self.moments(place).and_then(|moments| value(&moments))).collect();
        let known: Vec<f64> = raw.iter().flatten().copied().collect();
        let mean = known.iter().sum::<f64>() / known.len().max(1) as f64;
        let filled: Vec<f64> = raw.into_iter().map(|v| v.unwrap_or(mean)).collect();
        smoothed(&filled, self.grid.size, 1)
    }
}

/// The means over 3 x 3 places of a torus that are `step` places apart, weighted 1 2 1 along both axes.
pub fn smoothed(values: &[f64], size: Size, step: usize) -> Vec<f64> {
    let near = |at: usize, side: usize| {
        let step = step % side;
        [(at + side - step) % side, at, (at + step) % side]
    };
    let weights = [0.25, 0.5, 0.25];
    let mean = |t: usize| {
        let (columns, rows) = (near(t % size.width, size.width), near(t / size.width, size.height));
        let row = |y: usize| (0..3).map(|i| weights[i] * values[size.index(columns[i], y)]).sum::<f64>();
        (0..3).map(|j| weights[j] * row(rows[j])).sum()
    };
    (0..values.len()).map(mean).collect()
}
