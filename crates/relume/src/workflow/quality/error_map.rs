//! The errors of all photographs at each place of the surface.

use crate::size::Size;

/// Sums of squared differences of cells of the surface.
pub(super) struct ErrorMap<'a> {
    full: Size,
    step: usize,
    size: Size,
    squares: Vec<u64>,
    values: Vec<u64>,
    mask: Option<&'a [bool]>,
}

impl<'a> ErrorMap<'a> {
    pub fn new(full: Size, most: usize, mask: Option<&'a [bool]>) -> Self {
        let step = full.width.max(full.height).div_ceil(most.max(1)).max(1);
        let size = Size::new(full.width.div_ceil(step), full.height.div_ceil(step));
        Self { full, step, size, squares: vec![0; size.texels()], values: vec![0; size.texels()], mask }
    }

    pub fn add(&mut self, relit: &[u8], photograph: &[u8]) {
        let texels = relit.as_chunks::<3>().0.iter().zip(photograph.as_chunks::<3>().0);
        for (t, (a, b)) in texels.enumerate().filter(|(t, _)| self.mask.is_none_or(|mask| mask[*t])) {
            let (x, y) = (t % self.full.width / self.step, t / self.full.width / self.step);
            let cell = self.size.index(x, y);
            self.squares[cell] += squared(a, b);
            self.values[cell] += 3;
        }
    }

    pub fn finish(self) -> (Size, Vec<f32>) {
        let rms = |(square, count): (&u64, &u64)| (*square as f64 / (*count).max(1) as f64).sqrt() as f32;
        (self.size, self.squares.iter().zip(&self.values).map(rms).collect())
    }
}

/// The sum of squared differences of codes.
pub(super) fn squared(a: &[u8], b: &[u8]) -> u64 {
    a.iter().zip(b).map(|(a, b)| u64::from(a.abs_diff(*b)).pow(2)).sum()
}
