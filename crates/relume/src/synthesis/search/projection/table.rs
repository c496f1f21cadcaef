//! The coordinates of every cell of the exemplars, computed once.
//!
//! With the contraction A of [`Kernels`], |t - s|^2 >= |A t - A s|^2 + (r(t) - r(s))^2, where
//! r(x)^2 = |x|^2 - |A x|^2 is the squared residual of x: r(x) is the length of B x for the completion
//! B = (I - A'A)^(1/2), and lengths differ by no more than the vectors do (the reverse triangle inequality, or Cauchy-Schwarz).
//! Codes are first shifted by the mean of their plane, which changes no difference and keeps r small.
//!
//! Projections are exact integers; [`Units`] convert them to small coordinates. Those of the first look are
//! stored in planes, so that neighbouring positions are loaded together; the further ones, with the residual,
//! are stored together for each position.

use super::coordinates::{Coordinates, Further, Units, WIDE};
use super::kernels::Kernels;
use super::product::{MOST, Product, STRETCH, Stretch, WordPlanes, pair, quad};
use crate::error::Result;
use crate::job::Job;
use crate::numeric::pairs::SUMS;
use crate::numeric::summed_area::SummedArea;
use crate::parallel;
use crate::size::Size;
use crate::synthesis::quantise::{IndexTexels, Quantised, squared_length, squared_lengths};
use crate::synthesis::search::BlockQuery;
use crate::synthesis::source_map::Texel;

/// Coordinates of all cells of one size.
#[derive(Debug)]
pub struct Table {
    kernels: Kernels,
    /// The kernels as factors of pairs of texels, for [`MOST`] kernels at a time.
    factors: Vec<Vec<[i32; MOST]>>,
    /// The positions of those pairs in a cell.
    offsets: Vec<(usize, usize)>,
    /// The shift of each plane.
    means: Vec<i16>,
    units: Units,
    grids: Vec<CoordinateGrid>,
    /// The largest squared lengths of what rounding did to the first and the further coordinates of a
    /// cell.
    largest_errors: [f64; 2],
}

/// The coordinates of the cells of one exemplar.
#[derive(Debug)]
pub struct CoordinateGrid {
    places: Size,
    /// Those of the first look: pairs of 16 bits, then four of 8 bits, stored with an offset of 128; minus
    /// half their squared length is added to their products.
    first: WordPlanes,
    /// Position after position.
    further: Vec<Further>,
}

impl CoordinateGrid {
    /// The first coordinates.
    pub fn first(&self) -> &WordPlanes {
        &self.first
    }

    /// One of them at the position (x, y).
    fn first_coordinate(&self, kernel: usize, x: usize, y: usize) -> i16 {
        match kernel.checked_sub(WIDE) {
            None => {
                let pair: [i16; 2] = bytemuck::must_cast(self.first.word(kernel / 2, x, y));
                pair[kernel % 2]
            }
            Some(narrow) => {
                let quad: [u8; 4] = bytemuck::must_cast(self.first.word(WIDE / 2 + narrow / 4, x, y));
                i16::from(quad[narrow % 4]) - 128
            }
        }
    }

    /// The further coordinates of the position (x, y).
    #[inline(always)]
    pub fn further(&self, x: usize, y: usize) -> &Further {
        &self.further[self.places.index(x, y)]
    }
}

impl Table {
    /// Projects every cell of the exemplars, for neighbourhoods of at most `cells` cells.
    pub fn new(kernels: Kernels, exemplars: &Quantised, cells: usize, job: &Job) -> Result<Self> {
        let means = plane_means(exemplars);
        let offsets = pair_offsets(kernels.side);
        let chunks = kernels.weights.chunks(MOST);
        let factors =
            chunks.map(|weights| pair_factors(weights, &offsets, kernels.side, means.len())).collect();
        let shifted: Vec<Shifted> =
            exemplars.texels().iter().map(|texels| Shifted::new(texels, &means)).collect();
        let longest = shifted.iter().map(|s| s.longest(kernels.side)).max().unwrap_or(0);
        let units = Units::new(&kernels, (longest as f64).sqrt(), cells);
        let mut table =
            Self { kernels, factors, offsets, means, units, grids: Vec::new(), largest_errors: [0.0; 2] };
        for shifted in &shifted {
            let (grid, errors) = table.grid(shifted, job)?;
            table.grids.push(grid);
            table.largest_errors = larger(table.largest_errors, errors);
        }
        Ok(table)
    }

    /// The memory of the table of cells of exemplars of this size, with `most` kernels for the first look,
    /// and of its construction.
    pub fn bytes(size: Size, planes: usize, most: usize) -> u64 {
        let (pairs, quads) = words(most);
        let texels = size.texels() as u64;
        WordPlanes::bytes(pairs, quads, size.width, size.height)
            + WordPlanes::bytes(planes, 0, size.width, size.height)
            + texels * (size_of::<Further>() + size_of::<i64>() + 2 * planes) as u64
    }

    /// Texels along a side of a cell.
    pub fn side(&self) -> usize {
        self.kernels.side
    }

    /// The number of kernels, those of the second look included.
    pub fn kernels(&self) -> usize {
        self.kernels.weights.len()
    }

    /// The sum over the cells of a block of the squared difference of one coordinate, in codes.
    pub fn squared_difference(
        &self,
        kernel: usize,
        cells: &[(usize, usize)],
        wanted: &Coordinates,
        position: Texel,
    ) -> f64 {
        let grid = &self.grids[position.exemplar as usize];
        let further = kernel.checked_sub(self.kernels.first);
        let squares = cells.iter().enumerate().map(|(cell, &(dx, dy))| {
            let (x, y) = (position.x as usize + dx, position.y as usize + dy);
            let (own, there) = match further {
                Some(number) => {
                    (wanted.further[cell].coordinate(number), grid.further(x, y).coordinate(number))
                }
                None => (wanted.first(kernel, cell), grid.first_coordinate(kernel, x, y)),
            };
            (f64::from(own) - f64::from(there)).powi(2)
        });
        let unit = if further.is_some() { self.units.further } else { self.units.first };
        squares.sum::<f64>() / unit.powi(2)
    }

    /// Units of the coordinates.
    pub fn units(&self) -> &Units {
        &self.units
    }

    /// The largest squared lengths of what rounding did to the first and the further coordinates of a
    /// cell.
    pub fn largest_errors(&self) -> [f64; 2] {
        self.largest_errors
    }

    /// The coordinates of the cells of an exemplar, and the largest squared errors of one.
    fn grid(&self, shifted: &Shifted, job: &Job) -> Result<(CoordinateGrid, [f64; 2])> {
        let size = shifted.size;
        let places = Size::new(size.width + 1 - self.kernels.side, size.height + 1 - self.kernels.side);
        let (pairs, quads) = words(self.kernels.first);
        let mut grid = CoordinateGrid {
            places,
            first: WordPlanes::zeros(pairs, quads, places.width, places.height),
            further: vec![Further::ZERO; places.texels()],
        };
        let length = grid.first.row_length();
        let rows = grid.first.rows_mut().zip(grid.further.chunks_exact_mut(places.width));
        let fill = |(y, (first, further)): (usize, (&mut [i32], &mut [Further]))| {
            job.proceed()?;
            let mut errors = [0.0; 2];
            for x in (0..places.width).step_by(STRETCH) {
                let width = STRETCH.min(places.width - x);
                let own = self.project_stretch(shifted, x, y, width);
                further[x..][..width].copy_from_slice(&own.further);
                for i in 0..width {
                    let planes = first[x + i..].iter_mut().step_by(length);
                    planes.zip(self.words(&own, i)).for_each(|(to, word)| *to = word);
                    errors = larger(errors, [own.first_errors[i], own.further_errors[i]]);
                }
            }
            Ok(errors)
        };
        let errors = parallel::try_map(rows.enumerate(), fill)?.into_iter().fold([0.0; 2], larger);
        Ok((grid, errors))
    }

    /// The words of a cell of the exemplars.
    fn words(&self, own: &Coordinates, cell: usize) -> impl Iterator<Item = i32> {
        self.packed(own, cell, 128).chain([-(own.first_squares[cell] >> 1)])
    }

    /// The factors of a cell of a query.
    pub fn factors(&self, own: &Coordinates, cell: usize) -> impl Iterator<Item = i32> {
        self.packed(own, cell, 0)
    }

    /// The first coordinates of a cell in words, those of a byte with something added.
    fn packed(&self, own: &Coordinates, cell: usize, added: i16) -> impl Iterator<Item = i32> {
        let (pairs, quads) = words(self.kernels.first);
        let of = move |kernel: usize| own.first(kernel, cell);
        let byte = move |kernel: usize| (of(kernel) + added) as i8;
        let pairs = (0..pairs).map(move |i| pair([of(2 * i), of(2 * i + 1)]));
        pairs.chain((0..quads).map(move |i| quad(std::array::from_fn(|j| byte(WIDE + 4 * i + j)))))
    }

    /// The excess of products with the factors of the cells of a query.
    pub fn bias(&self, own: &Coordinates) -> i32 {
        let narrow = WIDE.min(self.kernels.first)..self.kernels.first;
        let of = |kernel: usize| (0..own.cells()).map(move |cell| i32::from(own.first(kernel, cell)));
        128 * narrow.flat_map(of).sum::<i32>()
    }

    /// The coordinates of consecutive cells of an exemplar.
    fn project_stretch(&self, shifted: &Shifted, x: usize, y: usize, length: usize) -> Coordinates {
        let mut sums: Box<Stretch> = Box::new([[[0; SUMS]; STRETCH / SUMS]; MOST]);
        let mut projections = vec![0; self.kernels() * length];
        for (factors, to) in self.factors.iter().zip(projections.chunks_mut(MOST * length)) {
            let sets = to.len() / length;
            let planes = &shifted.pairs;
            Product { planes, offsets: &self.offsets, factors, sets, x, y, length, sums: &mut sums }
                .compute();
            for (to, sums) in to.chunks_exact_mut(length).zip(&*sums) {
                to.copy_from_slice(&sums.as_flattened()[..length]);
            }
        }
        let side = self.kernels.side;
        let squares: Vec<u64> = (x..x + length).map(|x| shifted.squares.sum(x, y, side, side)).collect();
        self.units.round(&projections, &squares)
    }

    /// The grids, one for each exemplar.
    pub fn grids(&self) -> &[CoordinateGrid] {
        &self.grids
    }

    /// The coordinates of the cells of a query.
    pub fn project(&self, query: &BlockQuery, cells: &[(usize, usize)]) -> Coordinates {
        let shifted: Vec<Vec<i16>> = cells.iter().map(|&cell| self.shifted(query, cell)).collect();
        let product = |weights: &[i16], codes: &[i16]| {
            let terms = weights.iter().zip(codes);
            terms.fold(0i32, |sum, (&w, &c)| sum.wrapping_add(i32::from(w) * i32::from(c)))
        };
        let of_all =
            |weights: &Vec<i16>| shifted.iter().map(|codes| product(weights, codes)).collect::<Vec<_>>();
        let projections: Vec<i32> = self.kernels.weights.iter().flat_map(of_all).collect();
        let square = |codes: &Vec<i16>| squared_length(codes);
        self.units.round(&projections, &shifted.iter().map(square).collect::<Vec<_>>())
    }

    /// The codes of a cell of a query minus the means of the planes.
    fn shifted(&self, query: &BlockQuery, (x, y): (usize, usize)) -> Vec<i16> {
        let planes = self.means.len();
        let mut shifted = Vec::with_capacity(self.kernels.side.pow(2) * planes);
        for y in y..y + self.kernels.side {
            let start = query.neighbourhood.extent.index(x, y) * planes;
            for texel in query.codes[start..][..self.kernels.side * planes].chunks_exact(planes) {
                shifted.extend(texel.iter().zip(&self.means).map(|(code, mean)| code - mean));
            }
        }
        shifted
    }
}

/// The larger ones of two pairs.
fn larger(a: [f64; 2], b: [f64; 2]) -> [f64; 2] {
    [a[0].max(b[0]), a[1].max(b[1])]
}

/// The numbers of words of two coordinates, and of four, for the given number of kernels: at least two, of
/// zeros where the exemplars have no variation and so no kernels.
fn words(kernels: usize) -> (usize, usize) {
    (WIDE / 2, kernels.saturating_sub(WIDE).div_ceil(4))
}

/// The codes of one exemplar minus the means of the planes.
struct Shifted {
    size: Size,
    /// The code of each texel and that of its right neighbour, plane by plane.
    pairs: WordPlanes,
    squares: SummedArea,
}

impl Shifted {
    fn new(texels: &IndexTexels, means: &[i16]) -> Self {
        let (size, planes) = (texels.size(), means.len());
        let mut pairs = WordPlanes::zeros(planes, 0, size.width, size.height);
        let length = pairs.row_length();
        let mut codes = texels.codes()[..size.texels() * planes].to_vec();
        codes.iter_mut().zip(means.iter().cycle()).for_each(|(code, mean)| *code -= mean);
        for (row, codes) in pairs.rows_mut().zip(codes.chunks_exact(size.width * planes)) {
            for (k, plane) in row.chunks_exact_mut(length).take(planes).enumerate() {
                let right = codes.iter().skip(k + planes).step_by(planes).chain([&0]);
                let both = codes.iter().skip(k).step_by(planes).zip(right);
                plane.iter_mut().zip(both).for_each(|(word, (&a, &b))| *word = pair([a, b]));
            }
        }
        let squares = SummedArea::new(size, &squared_lengths(&codes, planes));
        Self { size, pairs, squares }
    }

    /// The largest sum of squares of a cell.
    fn longest(&self, side: usize) -> u64 {
        let size = self.size;
        let places = (0..=size.height - side).flat_map(|y| (0..=size.width - side).map(move |x| (x, y)));
        places.map(|(x, y)| self.squares.sum(x, y, side, side)).max().unwrap_or(0)
    }
}

/// The positions of the pairs of neighbouring texels that make up a cell; those of odd sides extend past it.
fn pair_offsets(side: usize) -> Vec<(usize, usize)> {
    (0..side).flat_map(|y| (0..side).step_by(2).map(move |x| (x, y))).collect()
}

/// For each pair of texels and each plane the weights of several kernels, zeros past the cell.
fn pair_factors(
    kernels: &[Vec<i16>],
    offsets: &[(usize, usize)],
    side: usize,
    planes: usize,
) -> Vec<[i32; MOST]> {
    let weight = |kernel: usize, x: usize, y: usize, plane: usize| match kernels.get(kernel) {
        Some(weights) if x < side => weights[(y * side + x) * planes + plane],
        _ => 0,
    };
    let factors = |(x, y): (usize, usize), plane: usize| {
        std::array::from_fn(|k| pair([weight(k, x, y, plane), weight(k, x + 1, y, plane)]))
    };
    offsets.iter().flat_map(|&offset| (0..planes).map(move |plane| factors(offset, plane))).collect()
}

/// The mean code of each plane over all exemplars, rounded.
fn plane_means(exemplars: &Quantised) -> Vec<i16> {
    let planes = exemplars.planes();
    let mut sums = vec![0i64; planes];
    let mut texels = 0;
    for exemplar in exemplars.texels() {
        let length = exemplar.size().texels() * planes;
        texels += exemplar.size().texels() as i64;
        for texel in exemplar.codes()[..length].chunks_exact(planes) {
            sums.iter_mut().zip(texel).for_each(|(sum, &code)| *sum += i64::from(code));
        }
    }
    sums.into_iter().map(|sum| (sum / texels.max(1)) as i16).collect()
}
