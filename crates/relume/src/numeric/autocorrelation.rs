//! The similarity of planes to shifted copies of themselves.
//!
//! For a shift d the planes overlap their own copy in a rectangle; with values f_k relative to the mean of
//! each plane, and sums over planes and the overlap,
//!
//! ```text
//! c(d) = 2 sum f_k(x) f_k(x + d) / sum (f_k(x)^2 + f_k(x + d)^2)
//!      = 1 - sum (f_k(x) - f_k(x + d))^2 / sum (f_k(x)^2 + f_k(x + d)^2).
//! ```
//!
//! It is exactly 1 where the overlap agrees, 0 for unrelated texels and -1 for opposites. Nothing wraps
//! around, so an exemplar need not hold whole periods. The products of all shifts come from one transform of
//! each plane, padded so that shifts within reach do not wrap (Wiener and Khinchin); the squares come from a
//! summed-area table (F. Crow, Summed-area tables for texture mapping, SIGGRAPH 1984), as in J. P. Lewis,
//! Fast normalized cross-correlation, 1995, for templates. On index planes the distance of texels is that of
//! their functions, so all planes have equal weight. [`Autocorrelation::direct`] is the slow truth.

use realfft::num_complex::Complex64;

use super::fourier::{self, Fourier, fast_length};
use crate::error::Result;
use crate::job::Job;
use crate::planes::Planes;
use crate::size::Size;

/// The correlation of planes with themselves at all shifts within reach.
#[derive(Debug, Clone, PartialEq)]
pub struct Autocorrelation {
    /// The size of the planes.
    size: Size,
    reach: Size,
    /// Shifts (-reach.width..=reach.width, 0..=reach.height), row after row.
    values: Vec<f64>,
}

impl Autocorrelation {
    /// The default range of shifts: half of each side, so that a period occurs twice and an overlap is at
    /// least a quarter of the texels.
    pub fn half(size: Size) -> Size {
        Size::new(size.width / 2, size.height / 2)
    }

    /// The range of shifts in which periods are sought: three quarters of each side, so that the diagonals of a
    /// lattice that occurs twice lie inside; an overlap is at least a sixteenth of the texels.
    pub fn far(size: Size) -> Size {
        Size::new(3 * size.width / 4, 3 * size.height / 4)
    }

    /// Correlates planes with themselves at all shifts up to `reach` texels along x and y, limited so that an
    /// overlap remains. Constant planes have correlation 0 at all shifts.
    ///
    /// # Errors
    /// When the transforms exceed the limits.
    pub fn new(planes: &Planes, reach: Size, job: &Job) -> Result<Self> {
        let reach = within(planes.size(), reach);
        let padded = Size::new(
            fast_length(planes.size().width + reach.width),
            fast_length(planes.size().height + reach.height),
        );
        job.check_bytes("the autocorrelation", Self::bytes(planes.size(), reach))?;
        let plan = Fourier::new(padded);
        let mut power = vec![0.0; plan.columns() * padded.height];
        let mut squares = vec![0.0; planes.size().texels()];
        for plane in planes.iter() {
            job.proceed()?;
            let values = centred(plane);
            squares.iter_mut().zip(&values).for_each(|(sum, v)| *sum += v * v);
            let spectrum = plan.forward(pad(&values, planes.size(), padded));
            power.iter_mut().zip(&spectrum).for_each(|(sum, bin)| *sum += bin.norm_sqr());
        }
        let products = plan.inverse(power.into_iter().map(Complex64::from).collect());
        let energy = Energy::new(&squares, planes.size());
        let product = |dx: isize, dy: usize| {
            products[dy * padded.width + dx.rem_euclid(padded.width as isize) as usize]
        };
        let value = |dx, dy| ratio(product(dx, dy), energy.of_overlaps(dx, dy), energy.total());
        Ok(Self::from_fn(planes.size(), reach, value))
    }

    /// The memory of [`Autocorrelation::new`] for planes of `size`.
    pub fn bytes(size: Size, reach: Size) -> u64 {
        let reach = within(size, reach);
        let padded =
            Size::new(fast_length(size.width + reach.width), fast_length(size.height + reach.height));
        (fourier::BYTES_PER_TEXEL + 16).saturating_mul(padded.texels() as u64)
    }

    /// The memory of the result of [`Autocorrelation::new`].
    pub fn kept_bytes(size: Size, reach: Size) -> u64 {
        let reach = within(size, reach);
        size_of::<f64>() as u64 * (2 * reach.width as u64 + 1) * (reach.height as u64 + 1)
    }

    /// The slow truth of [`Autocorrelation::new`]: the defining sums.
    pub fn direct(planes: &Planes, reach: Size) -> Self {
        let size = planes.size();
        let centred: Vec<Vec<f64>> = planes.iter().map(centred).collect();
        let total: f64 = centred.iter().flatten().map(|v| v * v).sum();
        let sums = |dx: isize, dy: usize| {
            let (mut product, mut energy) = (0.0, 0.0);
            for y in 0..size.height - dy {
                for x in (-dx).max(0) as usize..size.width - dx.max(0) as usize {
                    let (here, there) = (size.index(x, y), size.index(x.wrapping_add_signed(dx), y + dy));
                    for plane in &centred {
                        product += plane[here] * plane[there];
                        energy += plane[here].powi(2) + plane[there].powi(2);
                    }
                }
            }
            ratio(product, energy, total)
        };
        Self::from_fn(size, within(size, reach), sums)
    }

    fn from_fn(size: Size, reach: Size, value: impl Fn(isize, usize) -> f64) -> Self {
        let across = reach.width as isize;
        let shifts = (0..=reach.height).flat_map(|dy| (-across..=across).map(move |dx| (dx, dy)));
        Self { size, reach, values: shifts.map(|(dx, dy)| value(dx, dy)).collect() }
    }

    /// The size of the planes.
    pub fn size(&self) -> Size {
        self.size
    }

    /// The largest shifts known, along x and y.
    pub fn reach(&self) -> Size {
        self.reach
    }

    /// The correlation at a shift of whole texels, x to the right and y down; 0 beyond reach.
    pub fn at(&self, dx: isize, dy: isize) -> f64 {
        let (dx, dy) = if dy < 0 || (dy == 0 && dx < 0) { (-dx, -dy) } else { (dx, dy) };
        let Size { width, height } = self.reach;
        if dx.unsigned_abs() > width || dy as usize > height {
            return 0.0;
        }
        self.values[dy as usize * (2 * width + 1) + (dx + width as isize) as usize]
    }

    /// The root mean square difference from another autocorrelation over the shifts that both reach; each
    /// octave of shift lengths has equal weight, because short shifts are few and carry the most information.
    pub fn distance(&self, other: &Self) -> f64 {
        let (a, b) = (self.reach, other.reach);
        let reach = Size::new(a.width.min(b.width), a.height.min(b.height));
        octave_means(reach, |dx, dy| (self.at(dx, dy) - other.at(dx, dy)).powi(2)).sqrt()
    }

    /// The same shifts with values that are a function of shift and value.
    pub fn mapped(&self, value: impl Fn([f64; 2], f64) -> f64) -> Self {
        let at = |dx: isize, dy: usize| value([dx as f64, dy as f64], self.at(dx, dy as isize));
        Self::from_fn(self.size, self.reach, at)
    }

    /// The number of texels that a shift leaves in the overlap.
    pub fn overlap(&self, shift: [f64; 2]) -> f64 {
        let side = |side: usize, shift: f64| (side as f64 - shift.abs()).max(0.0);
        side(self.size.width, shift[0]) * side(self.size.height, shift[1])
    }

    /// Whether a shift lies within reach.
    pub fn covers(&self, shift: [f64; 2]) -> bool {
        shift[0].abs() <= self.reach.width as f64 && shift[1].abs() <= self.reach.height as f64
    }

    /// The correlation between whole texels, by the cubic convolution of R. G. Keys (Cubic convolution
    /// interpolation for digital image processing, 1981, with a = -1/2). Linear interpolation would cut off
    /// the peaks of fine textures and favour integer periods.
    pub fn sample(&self, shift: [f64; 2]) -> f64 {
        let [x, y] = shift.map(f64::floor);
        let [across, down] = [cubic(shift[0] - x), cubic(shift[1] - y)];
        let rows = down.into_iter().enumerate().filter(|(_, weight)| *weight != 0.0);
        rows.map(|(j, weight)| {
            let columns = across.into_iter().enumerate();
            let at = |i: usize| self.at(x as isize + i as isize - 1, y as isize + j as isize - 1);
            weight * columns.map(|(i, weight)| if weight == 0.0 { 0.0 } else { weight * at(i) }).sum::<f64>()
        })
        .sum()
    }
}

/// The mean, over octaves of the length of the shift, of the mean value in each.
fn octave_means(reach: Size, value: impl Fn(isize, isize) -> f64) -> f64 {
    let (across, down) = (reach.width as isize, reach.height as isize);
    let mut octaves: Vec<(f64, u64)> = Vec::new();
    for (dx, dy) in (0..=down).flat_map(|dy| (-across..=across).map(move |dx| (dx, dy))) {
        let squared = (dx * dx + dy * dy).unsigned_abs() as u64;
        if squared == 0 || (dy == 0 && dx < 0) {
            continue;
        }
        let octave = squared.ilog2() as usize / 2;
        octaves.resize(octaves.len().max(octave + 1), (0.0, 0));
        octaves[octave].0 += value(dx, dy);
        octaves[octave].1 += 1;
    }
    let means = octaves.iter().filter(|(_, count)| *count > 0).map(|(sum, count)| sum / *count as f64);
    let count = octaves.iter().filter(|(_, count)| *count > 0).count();
    means.sum::<f64>() / count.max(1) as f64
}

/// The weights of the neighbours at -1, 0, 1 and 2 for a position t in [0, 1).
fn cubic(t: f64) -> [f64; 4] {
    [
        ((2.0 - t) * t - 1.0) * t * 0.5,
        ((3.0 * t - 5.0) * t * t + 2.0) * 0.5,
        ((4.0 - 3.0 * t) * t + 1.0) * t * 0.5,
        (t - 1.0) * t * t * 0.5,
    ]
}

/// The reach that still leaves an overlap of one texel.
fn within(size: Size, reach: Size) -> Size {
    Size::new(reach.width.min(size.width - 1), reach.height.min(size.height - 1))
}

/// 2 product / energy; 0 where the overlap holds almost none of the energy of the planes.
fn ratio(product: f64, energy: f64, total: f64) -> f64 {
    if energy <= 1e-12 * total { 0.0 } else { (2.0 * product / energy).clamp(-1.0, 1.0) }
}

/// A plane minus its mean; values far below the precision of its samples are rounding errors and set to 0.
fn centred(plane: &[f32]) -> Vec<f64> {
    let mean = plane.iter().map(|&v| f64::from(v)).sum::<f64>() / plane.len() as f64;
    let kept = |v: f64| if v.abs() > 1e-10 * mean.abs() { v } else { 0.0 };
    plane.iter().map(|&v| kept(f64::from(v) - mean)).collect()
}

/// An image in the upper left corner of a larger one of zeros.
fn pad(values: &[f64], size: Size, padded: Size) -> Vec<f64> {
    let mut image = vec![0.0; padded.texels()];
    for (row, out) in values.chunks_exact(size.width).zip(image.chunks_exact_mut(padded.width)) {
        out[..size.width].copy_from_slice(row);
    }
    image
}

/// Sums of squares over rectangles.
struct Energy {
    size: Size,
    /// Sums over the x first columns and y first rows, (width + 1) x (height + 1).
    table: Vec<f64>,
}

impl Energy {
    fn new(squares: &[f64], size: Size) -> Self {
        let stride = size.width + 1;
        let mut table = vec![0.0; stride * (size.height + 1)];
        for y in 0..size.height {
            let mut row = 0.0;
            for x in 0..size.width {
                row += squares[size.index(x, y)];
                table[(y + 1) * stride + x + 1] = table[y * stride + x + 1] + row;
            }
        }
        Self { size, table }
    }

    fn total(&self) -> f64 {
        self.rectangle([0, self.size.width], [0, self.size.height])
    }

    fn rectangle(&self, [left, right]: [usize; 2], [top, bottom]: [usize; 2]) -> f64 {
        let at = |x: usize, y: usize| self.table[y * (self.size.width + 1) + x];
        at(right, bottom) - at(left, bottom) - at(right, top) + at(left, top)
    }

    /// The sum over both overlaps of a shift.
    fn of_overlaps(&self, dx: isize, dy: usize) -> f64 {
        let Size { width, height } = self.size;
        let columns = width - dx.unsigned_abs();
        let (here, there) = ((-dx).max(0) as usize, dx.max(0) as usize);
        self.rectangle([here, here + columns], [0, height - dy])
            + self.rectangle([there, there + columns], [dy, height])
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::limits::Limits;
    use crate::numeric::random::{Purpose, Stream};
    use proptest::prelude::*;

    fn noise(size: Size, count: usize, seed: u64) -> Planes {
        let mut stream = Stream::new(seed, Purpose::Sample, [0]);
        let data = (0..size.texels() * count).map(|_| stream.unit() as f32 + 3.0).collect();
        Planes::from_vec(size, count, data).unwrap()
    }

    fn correlate(planes: &Planes, reach: Size) -> Autocorrelation {
        Autocorrelation::new(planes, reach, &Job::default()).unwrap()
    }

    #[test]
    fn octaves_count_alike() {
        let reach = Size::new(9, 5);
        assert!((octave_means(reach, |_, _| 3.0) - 3.0).abs() < 1e-12);
        // Lengths 1 and sqrt 2 are the first of four octaves: up to 10.3.
        let first = octave_means(reach, |dx, dy| if dx * dx + dy * dy < 4 { 1.0 } else { 0.0 });
        assert!((first - 0.25).abs() < 1e-12);
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(30))]

        #[test]
        fn fast_correlation_is_the_defining_sum(
            (width, height, count) in (1usize..20, 1usize..20, 1usize..4),
            (across, down, seed) in (0usize..25, 0usize..25, any::<u64>()),
        ) {
            let planes = noise(Size::new(width, height), count, seed);
            let reach = Size::new(across, down);
            let (fast, slow) = (correlate(&planes, reach), Autocorrelation::direct(&planes, reach));
            prop_assert_eq!(fast.reach(), slow.reach());
            for (a, b) in fast.values.iter().zip(&slow.values) {
                prop_assert!((a - b).abs() < 1e-9, "{} against {}", a, b);
            }
        }
    }

    #[test]
    fn whole_periods_correlate_fully_and_nothing_else_does() {
        let planes = noise(Size::new(7, 5), 2, 3).repeated(4, 5);
        let found = correlate(&planes, Autocorrelation::half(planes.size()));
        assert_eq!(found.reach(), Size::new(14, 12));
        for dy in -12..=12 {
            for dx in -14..=14 {
                let whole = dx % 7 == 0 && dy % 5 == 0;
                let value = found.at(dx, dy);
                assert!(if whole { value > 1.0 - 1e-9 } else { value < 0.8 }, "({dx}, {dy}): {value}");
                assert_eq!(value, found.at(-dx, -dy));
            }
        }
        assert_eq!(found.at(15, 0), 0.0);
    }

    #[test]
    fn samples_are_those_at_whole_texels_and_smooth_in_between() {
        let found = correlate(&noise(Size::new(12, 9), 1, 4), Size::new(6, 4));
        assert!((found.sample([6.0, -4.0]) - found.at(6, -4)).abs() < 1e-12);
        assert!((found.sample([-0.25, -0.75]) - found.sample([0.25, 0.75])).abs() < 1e-12);
        // Quadratic values are interpolated exactly: here those of a smooth peak, by hand.
        let peak = Autocorrelation::from_fn(Size::new(8, 8), Size::new(6, 6), |dx, dy| {
            1.0 - 0.01 * (dx * dx) as f64 - 0.02 * (dy * dy) as f64 - 0.005 * (dx * dy as isize) as f64
        });
        let truth = 1.0 - 0.01 * 2.3 * 2.3 - 0.02 * 3.6 * 3.6 + 0.005 * 2.3 * 3.6;
        assert!((peak.sample([-2.3, 3.6]) - truth).abs() < 1e-12);
    }

    #[test]
    fn constant_planes_resemble_nothing() {
        let flat = Planes::from_vec(Size::new(9, 6), 1, vec![0.3; 54]).unwrap();
        let found = correlate(&flat, Size::new(4, 3));
        assert!(found.values.iter().all(|&v| v == 0.0));
        let tight = Job::new(Limits { max_bytes: 100, ..Limits::default() });
        assert!(Autocorrelation::new(&flat, Size::new(4, 3), &tight).is_err());
    }
}
