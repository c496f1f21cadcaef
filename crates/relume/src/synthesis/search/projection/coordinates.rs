//! Coordinates of cells in small integers, and their rounding errors.
//!
//! A cell x of codes has the exact coordinates A x, for the contraction A of the kernels, and the residual
//! r(x), the length of the part not captured by them. Three operations never lengthen the difference of two
//! cells, and therefore preserve a lower bound: shifting both alike, projecting both onto a ball (the
//! projection on a convex set is a contraction), and clipping both alike, which is a projection onto a box.
//! So
//!
//! - the first [`WIDE`] coordinates, the longest, are rounded to 16 bits;
//! - the others of the first look are clipped to 8 bits, in the same unit;
//! - those of the second look, and r minus its usual length, are clipped to 8 bits in a unit of their own.
//!
//! Only rounding causes errors. They are measured cell by cell, which gives less than half a unit for each
//! coordinate: a third of the worst case for most cells.

use pulp::Arch;

use super::kernels::{FURTHER, Kernels};

/// Coordinates of the first look that keep 16 bits.
pub const WIDE: usize = 4;

/// The largest coordinate of 8 bits.
const MOST: f64 = 127.0;

/// Coordinates of a neighbourhood are no longer than this, so that sums of products of two of them fit 32
/// bits.
const LONGEST: f64 = 32_000.0;

/// The largest ratio of the units of the first and the further coordinates: enough where the latter are all
/// small.
const FINEST: f64 = 64.0;

/// The coordinates of one cell for the second look, including the residual, stored with an offset of 128; the
/// last four bytes hold their squared length.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[repr(align(64))]
pub struct Further(pub [u8; 64]);

/// Added to a number of less than 51 bits and subtracted again, it leaves the nearest integer, because no
/// bits are left for a fraction.
const ROUNDING: f64 = 1.5 * (1u64 << 52) as f64;

/// The position of the squared length in [`Further`].
const SQUARE: usize = FURTHER + 1;

const _: () = assert!(SQUARE + 4 == 64);

impl Further {
    /// All zeros.
    pub const ZERO: Self = Self([0; 64]);

    /// A coordinate, or the residual for [`FURTHER`].
    pub fn coordinate(&self, number: usize) -> i16 {
        i16::from(self.0[number]) - 128
    }

    /// The squared length of all of them.
    #[inline(always)]
    pub fn square(&self) -> i32 {
        i32::from_le_bytes(*self.0.last_chunk().expect("the square is part of it"))
    }

    /// The coordinates as factors, and zeros in place of the squared length.
    pub fn factors(&self) -> FurtherFactors {
        FurtherFactors(std::array::from_fn(|i| if i < SQUARE { (self.0[i] ^ 0x80) as i8 } else { 0 }))
    }
}

/// Further coordinates as factors.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[repr(align(64))]
pub struct FurtherFactors(pub [i8; 64]);

/// Units of the coordinates.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Units {
    /// Kernels of the first look.
    kernels: usize,
    /// Codes per unit of the projections of the kernels.
    codes: f64,
    /// The length of the longest cell of the exemplars, in codes.
    radius: f64,
    /// The usual length of the residual, in codes.
    residual: f64,
    /// Units of the first coordinates per code.
    pub first: f64,
    /// Units of the further ones per code.
    pub further: f64,
}

impl Units {
    /// Units for cells of length at most `radius` codes, with at most `cells` of them in a neighbourhood.
    pub fn new(kernels: &Kernels, radius: f64, cells: usize) -> Self {
        let first = LONGEST / (radius.max(1.0) * (cells.max(1) as f64).sqrt());
        let first = first.min(MOST / kernels.usual_narrow.max(f64::MIN_POSITIVE));
        let further = (MOST / kernels.usual_further.max(f64::MIN_POSITIVE)).min(FINEST * first);
        let codes = kernels.lambda.sqrt().recip();
        Self { kernels: kernels.first, codes, radius, residual: kernels.usual_residual, first, further }
    }

    /// The coordinates of given cells, from the exact projections, kernel after kernel, and the exact squared
    /// lengths.
    ///
    /// A query may combine parts that no exemplar has side by side, and be longer than any cell of them. It
    /// is then projected onto the ball that contains all of those.
    pub fn round(&self, projections: &[i32], squares: &[u64]) -> Coordinates {
        Arch::new().dispatch(
            #[inline(always)]
            || self.rounded(projections, squares),
        )
    }

    #[inline(always)]
    fn rounded(&self, projections: &[i32], squares: &[u64]) -> Coordinates {
        let cells = squares.len();
        let mut out = Coordinates::new(cells, self.kernels);
        let inwards = squares.iter().map(|&square| (self.radius / (square as f64).sqrt()).min(1.0));
        let codes: Vec<f64> = inwards.map(|inwards| inwards * self.codes).collect();
        let lengths =
            squares.iter().zip(&codes).map(|(&square, codes)| square as f64 * (codes / self.codes).powi(2));
        let mut residuals: Vec<f64> = lengths.collect();
        let mut values = vec![0.0; cells];
        let mut places = vec![0.0; cells];
        let mut further_square = vec![0.0; cells];
        let mut first_square = vec![0.0; cells];
        for (kernel, projections) in projections.chunks_exact(cells.max(1)).enumerate() {
            for (((value, residual), &projection), codes) in
                values.iter_mut().zip(&mut residuals).zip(projections).zip(&codes)
            {
                *value = f64::from(projection) * codes;
                *residual -= *value * *value;
            }
            if kernel < self.kernels {
                let most = if kernel < WIDE { f64::from(i16::MAX) } else { MOST };
                clip(&values, self.first, most, &mut places, &mut out.first_errors, &mut first_square);
                let to = &mut out.first[kernel * cells..][..cells];
                to.iter_mut().zip(&places).for_each(|(to, place)| *to = *place as i16);
            } else {
                clip(&values, self.further, MOST, &mut places, &mut out.further_errors, &mut further_square);
                out.set_further(kernel - self.kernels, &places);
            }
        }
        residuals.iter_mut().for_each(|length| *length = length.max(0.0).sqrt() - self.residual);
        clip(&residuals, self.further, MOST, &mut places, &mut out.further_errors, &mut further_square);
        out.set_further(FURTHER, &places);
        out.first_squares.extend(first_square.iter().map(|square| *square as i32));
        for (further, square) in out.further.iter_mut().zip(&further_square) {
            further.0[SQUARE..].copy_from_slice(&(*square as i32).to_le_bytes());
        }
        out
    }
}

/// Converts values to units, clips and rounds them, and adds up their squares and those of the rounding
/// errors.
#[inline(always)]
fn clip(values: &[f64], unit: f64, most: f64, places: &mut [f64], errors: &mut [f64], squares: &mut [f64]) {
    let sums = errors.iter_mut().zip(squares);
    for ((value, place), (error, square)) in values.iter().zip(places).zip(sums) {
        let exact = (value * unit).clamp(-most, most);
        *place = (exact + ROUNDING) - ROUNDING;
        *square += *place * *place;
        *error += (exact - *place) * (exact - *place);
    }
}

/// Rounded coordinates of given cells.
#[derive(Debug, Clone, PartialEq)]
pub struct Coordinates {
    /// The coordinates of the first look, kernel after kernel.
    first: Vec<i16>,
    /// Their squared lengths.
    pub first_squares: Vec<i32>,
    /// The squared lengths of what rounding did to them.
    pub first_errors: Vec<f64>,
    /// The further ones.
    pub further: Vec<Further>,
    /// The squared lengths of what rounding did to them.
    pub further_errors: Vec<f64>,
}

impl Coordinates {
    fn new(cells: usize, kernels: usize) -> Self {
        // Missing kernels have no coordinates.
        let mut none = Further::ZERO;
        none.0[..SQUARE].fill(128);
        Self {
            first: vec![0; cells * kernels],
            first_squares: Vec::with_capacity(cells),
            first_errors: vec![0.0; cells],
            further: vec![none; cells],
            further_errors: vec![0.0; cells],
        }
    }

    /// The number of cells.
    pub fn cells(&self) -> usize {
        self.further.len()
    }

    /// A coordinate of the first look, or zero if there are fewer kernels.
    pub fn first(&self, kernel: usize, cell: usize) -> i16 {
        self.first.get(kernel * self.cells() + cell).copied().unwrap_or(0)
    }

    #[inline(always)]
    fn set_further(&mut self, number: usize, places: &[f64]) {
        let to = self.further.iter_mut().zip(places);
        to.for_each(|(further, place)| further.0[number] = (*place as i16 + 128) as u8);
    }
}
