//! The compared surroundings of a texel, and the weight of each texel in them.
//!
//! The weights of Efros, Leung, "Texture Synthesis by Non-parametric Sampling", ICCV 1999, are a Gaussian
//! with a standard deviation of the side of the window divided by 6.4 (the value of their published
//! pseudo-code). Here they are integers, so that distances stay exact: 64 at the centre, in steps of 1 up to
//! 8 and of 8 beyond, so that each is a number of at most 8 times 1 or 8. Texels whose weight rounds to zero
//! are not compared: the corners and edges of the window.

use super::canvas::PixelCanvas;
use crate::error::{Error, Result};

/// The weight of the centre of a Gaussian window.
const PEAK: f64 = 64.0;

/// The longest side of a window: far more than the largest thing of any texture.
const MAX_SIDE: usize = 1023;

/// The side of a window divided by the standard deviation of its Gaussian.
const SIDE_IN_SIGMAS: f64 = 6.4;

/// The largest factor of a weight: 8 times a difference of 12-bit codes fits 16 bits.
pub const MAX_FACTOR: i16 = 8;

/// An integer weight: a factor of 1 to [`MAX_FACTOR`] times 2 to the power of `shift`.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Weight {
    /// 1 to [`MAX_FACTOR`].
    pub factor: i16,
    /// 0 or 3.
    pub shift: u32,
}

impl Weight {
    /// A weight of one.
    pub const ONE: Self = Self { factor: 1, shift: 0 };

    /// The nearest weight to a number of at most 64; `None` if that is zero.
    fn nearest(value: f64) -> Option<Self> {
        let shift = if value > f64::from(MAX_FACTOR) { 3 } else { 0 };
        let factor = (value / f64::from(1u32 << shift)).round() as i16;
        (factor > 0).then_some(Self { factor, shift })
    }

    /// The weight as a number.
    pub fn value(self) -> u64 {
        u64::from(self.factor.unsigned_abs()) << self.shift
    }
}

/// A texel of a window.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Tap {
    /// Columns to the right of the centre.
    pub dx: isize,
    /// Rows below the centre.
    pub dy: isize,
    /// The weight of its squared difference.
    pub weight: Weight,
}

impl Tap {
    /// Column and row in a window of the given radius, counted from its top left.
    fn place(&self, radius: usize) -> (usize, usize) {
        let radius = radius.cast_signed();
        ((radius + self.dx).cast_unsigned(), (radius + self.dy).cast_unsigned())
    }
}

/// A square window of odd side around a texel: its taps in the order of decreasing weight.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct ComparedWindow {
    side: usize,
    taps: Vec<Tap>,
}

impl ComparedWindow {
    /// All texels but the centre, by the Gaussian of Efros and Leung.
    pub fn gaussian(side: usize) -> Self {
        let sigma = side as f64 / SIDE_IN_SIGMAS;
        let weight = |dx: isize, dy: isize| {
            let distance = (dx * dx + dy * dy) as f64 / (2.0 * sigma * sigma);
            Weight::nearest(PEAK * (-distance).exp()).filter(|_| (dx, dy) != (0, 0))
        };
        Self::new(side, weight)
    }

    /// All texels, each with weight one.
    pub fn uniform(side: usize) -> Self {
        Self::new(side, |_, _| Some(Weight::ONE))
    }

    fn new(side: usize, weight: impl Fn(isize, isize) -> Option<Weight>) -> Self {
        let radius = (side / 2).cast_signed();
        let places = (-radius..=radius).flat_map(|dy| (-radius..=radius).map(move |dx| (dx, dy)));
        let tap = |(dx, dy)| weight(dx, dy).map(|weight| Tap { dx, dy, weight });
        let mut taps: Vec<Tap> = places.filter_map(tap).collect();
        let order = |tap: &Tap| (std::cmp::Reverse(tap.weight.value()), tap.dx * tap.dx + tap.dy * tap.dy);
        taps.sort_by_key(order);
        Self { side, taps }
    }

    /// Texels along a side.
    pub fn side(&self) -> usize {
        self.side
    }

    /// Texels from the centre to an edge.
    pub fn radius(&self) -> usize {
        self.side / 2
    }

    /// The texels that are compared.
    pub fn taps(&self) -> &[Tap] {
        &self.taps
    }

    /// Column and row of a tap, counted from the window's top left.
    pub fn place(&self, tap: &Tap) -> (usize, usize) {
        tap.place(self.radius())
    }

    /// Refuses sides that are even or too small to hold a neighbour.
    pub fn check_side(side: usize) -> Result<()> {
        if side < 3 || side.is_multiple_of(2) {
            return Err(Error::usage(format!(
                "a window of {side} texels has no middle and no neighbours: choose an odd side of at least 3"
            )));
        }
        if side > MAX_SIDE {
            return Err(Error::usage(format!(
                "a window of {side} texels is larger than anything it could be compared with: choose an odd side of \
                 at most {MAX_SIDE}"
            )));
        }
        Ok(())
    }

    /// The known texels around one of a canvas.
    pub fn query(&self, canvas: &PixelCanvas, texel: usize) -> WindowQuery {
        let place = canvas.place(texel);
        let mut query = WindowQuery {
            radius: self.radius(),
            taps: Vec::with_capacity(self.taps.len()),
            codes: Vec::with_capacity(self.taps.len() * canvas.copied_codes(texel).len()),
            ..WindowQuery::default()
        };
        for tap in &self.taps {
            let there = canvas.beside(place, tap.dx, tap.dy);
            if let Some(there) = there.filter(|&there| canvas.is_known(there)) {
                query.taps.push(*tap);
                query.codes.extend_from_slice(canvas.copied_codes(there));
            }
        }
        if canvas.guides() > 0 {
            self.add_guide(canvas, place, &mut query);
        }
        query
    }

    /// The guides of all texels around one, and of the texel itself with the weight of a neighbour.
    fn add_guide(&self, canvas: &PixelCanvas, place: (usize, usize), query: &mut WindowQuery) {
        let heaviest = self.taps.first().map_or(Weight::ONE, |tap| tap.weight);
        let middle = Tap { dx: 0, dy: 0, weight: heaviest };
        let around = self.taps.iter().filter(|tap| (tap.dx, tap.dy) != (0, 0));
        for tap in std::iter::once(&middle).chain(around) {
            if let Some(there) = canvas.beside(place, tap.dx, tap.dy) {
                query.guide_taps.push(*tap);
                query.guide_codes.extend_from_slice(canvas.guide_codes(there));
            }
        }
    }
}

/// The query for a window of an exemplar: the known texels around one of the output.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct WindowQuery {
    /// Texels from the centre to an edge of the window.
    pub radius: usize,
    /// The known texels in the order of the window.
    pub taps: Vec<Tap>,
    /// Their codes, the planes of a texel adjacent.
    pub codes: Vec<i16>,
    /// The texels whose guides are compared, known or not, if there are guides.
    pub guide_taps: Vec<Tap>,
    /// Their codes in the planes of the guides.
    pub guide_codes: Vec<i16>,
}

impl WindowQuery {
    /// Column and row of a tap, counted from the window's top left.
    pub fn place(&self, tap: &Tap) -> (usize, usize) {
        tap.place(self.radius)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn gaussian_weights_are_near_the_formula_and_fall() {
        for side in [3, 5, 11, 23] {
            let window = ComparedWindow::gaussian(side);
            let sigma = side as f64 / 6.4;
            assert!(window.taps().iter().any(|tap| (tap.dx, tap.dy) == (1, 1)), "neighbours count");
            assert!(window.taps().windows(2).all(|two| two[0].weight.value() >= two[1].weight.value()));
            for tap in window.taps() {
                let truth = 64.0 * (-((tap.dx.pow(2) + tap.dy.pow(2)) as f64) / (2.0 * sigma * sigma)).exp();
                let step = if truth > 8.0 { 8.0 } else { 1.0 };
                assert!((tap.weight.value() as f64 - truth).abs() <= step / 2.0, "{tap:?} of {truth}");
                assert!((1..=MAX_FACTOR).contains(&tap.weight.factor));
            }
        }
        assert_eq!(ComparedWindow::uniform(5).taps().len(), 25);
    }

    #[test]
    fn windows_without_a_middle_are_refused() {
        assert!(ComparedWindow::check_side(11).is_ok() && ComparedWindow::check_side(3).is_ok());
        assert!(
            [0, 1, 2, 10, MAX_SIDE + 2, usize::MAX]
                .into_iter()
                .all(|side| ComparedWindow::check_side(side).is_err())
        );
    }
}
