//! Heights from differences of neighbours that hold on to given heights: gradient-domain joining of pieces.
//!
//! Pieces of height maps laid side by side meet in cliffs, though each is right in itself. The surface h is
//! sought whose differences D h are nearest to those within the pieces, g, and whose values are near the given
//! heights a:
//!
//! min |D h - g|^2 + s |h - a|^2,   that is   (D'D + s) h = D'g + s a.
//!
//! P. Perez, M. Gangnet, A. Blake, "Poisson Image Editing", SIGGRAPH 2003, eq. 3 to 7, with the screening term of
//! P. Bhat, B. Curless, M. Cohen, C. L. Zitnick, "Fourier Analysis of the 2D Screened Poisson Equation for Gradient
//! Domain Problems", ECCV 2008, eq. 4. D'D is diagonal in the Fourier domain of a periodic surface, and in that of
//! the mirrored surface for an open one.

use realfft::num_complex::Complex64;
use std::f64::consts::TAU;

use super::fourier::factors;
use super::{IntegrationMethod, SurfaceBorder};
use crate::error::{Error, Result};
use crate::job::Job;
use crate::numeric::fourier::{BYTES_PER_TEXEL, Fourier};
use crate::planes::Planes;
use crate::size::Size;

/// Differences of neighbouring heights, row by row. On an open surface those of the last column and row are 0.
#[derive(Debug, Clone, PartialEq)]
pub struct Differences {
    /// From each texel to the one at its right.
    pub right: Vec<f64>,
    /// From each texel to the one below it.
    pub down: Vec<f64>,
}

/// The heights nearest to the differences and to the anchor, which holds undulations longer than `longest`
/// texels: at that wavelength both have the same say.
///
/// # Errors
/// A number of differences other than that of texels, an anchor of other than one plane, a wavelength that is not
/// positive, and the limits.
pub fn anchored(
    differences: &Differences,
    anchor: &Planes,
    longest: f64,
    border: SurfaceBorder,
    job: &Job,
) -> Result<Planes> {
    let size = anchor.size();
    let are_of_size = [&differences.right, &differences.down].iter().all(|all| all.len() == size.texels());
    if anchor.count() != 1 || !are_of_size || longest.is_nan() || longest <= 0.0 {
        return Err(Error::usage(
            "heights are joined from one plane, as many differences, and a wavelength above 0",
        ));
    }
    let mirrored = if border == SurfaceBorder::Open { 4 } else { 1 };
    job.check("the joining of heights", size, mirrored * 2 * BYTES_PER_TEXEL)?;
    let spring = (TAU / longest).powi(2);
    let wanted = right_side(differences, anchor, spring);
    job.proceed()?;
    let heights = match border {
        SurfaceBorder::Periodic => solve(size, wanted, spring),
        SurfaceBorder::Open => {
            let doubled = Size::new(2 * size.width, 2 * size.height);
            let all = solve(doubled, mirrored_values(size, &wanted), spring);
            all.chunks_exact(doubled.width)
                .take(size.height)
                .flat_map(|row| row[..size.width].to_vec())
                .collect()
        }
    };
    Planes::from_vec(size, 1, heights.into_iter().map(|h| h as f32).collect())
}

/// D'g + s a. Differences beyond an open border are 0, so that the sums are those of a periodic surface.
fn right_side(differences: &Differences, anchor: &Planes, spring: f64) -> Vec<f64> {
    let size = anchor.size();
    let mut sums: Vec<f64> = anchor.as_slice().iter().map(|h| spring * f64::from(*h)).collect();
    for (texel, (right, down)) in differences.right.iter().zip(&differences.down).enumerate() {
        let (x, y) = (texel % size.width, texel / size.width);
        sums[texel] -= right + down;
        sums[size.index((x + 1) % size.width, y)] += right;
        sums[size.index(x, (y + 1) % size.height)] += down;
    }
    sums
}

/// Values mirrored at the right and lower border.
fn mirrored_values(size: Size, values: &[f64]) -> Vec<f64> {
    let rows = (0..size.height).chain((0..size.height).rev());
    let row = |y: usize| {
        let row = &values[y * size.width..][..size.width];
        row.iter().chain(row.iter().rev()).copied()
    };
    rows.flat_map(row).collect()
}

/// Divides by D'D + s on the torus.
fn solve(size: Size, wanted: Vec<f64>, spring: f64) -> Vec<f64> {
    let plan = Fourier::new(size);
    let mut spectrum = plan.forward(wanted);
    let factor = |k: usize, n: usize| factors(k, n, IntegrationMethod::Poisson).1;
    let rows: Vec<f64> = (0..size.height).map(|l| factor(l, size.height)).collect();
    let divide = |(i, bin): (usize, &mut Complex64)| {
        *bin /= factor(i / rows.len(), size.width) + rows[i % rows.len()] + spring;
    };
    spectrum.iter_mut().enumerate().for_each(divide);
    plan.inverse(spectrum)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::numeric::random::{Purpose, Stream};

    fn random(size: Size, purpose: u64) -> Vec<f64> {
        let mut stream = Stream::new(7, Purpose::Sample, [purpose, size.texels() as u64]);
        (0..size.texels()).map(|_| stream.unit() - 0.5).collect()
    }

    fn plane(size: Size, values: &[f64]) -> Planes {
        Planes::from_vec(size, 1, values.iter().map(|v| *v as f32).collect()).unwrap()
    }

    /// The differences of given heights; beyond an open border 0.
    fn differences(size: Size, heights: &[f64], border: SurfaceBorder) -> Differences {
        let is_open = border == SurfaceBorder::Open;
        let of = |dx: usize, dy: usize| {
            let at = |texel: usize| {
                let (x, y) = (texel % size.width + dx, texel / size.width + dy);
                match is_open && (x == size.width || y == size.height) {
                    true => 0.0,
                    false => heights[size.index(x % size.width, y % size.height)] - heights[texel],
                }
            };
            (0..size.texels()).map(at).collect()
        };
        Differences { right: of(1, 0), down: of(0, 1) }
    }

    fn worst(a: &[f64], b: &[f32]) -> f64 {
        a.iter().zip(b).map(|(a, b)| (a - f64::from(*b)).abs()).fold(0.0, f64::max)
    }

    #[test]
    fn the_gradient_of_the_sum_of_squares_is_zero_at_the_solution() {
        for border in [SurfaceBorder::Open, SurfaceBorder::Periodic] {
            for (width, height) in [(1, 1), (1, 6), (7, 1), (2, 2), (5, 8), (12, 9)] {
                let size = Size::new(width, height);
                let mut g = Differences { right: random(size, 1), down: random(size, 2) };
                if border == SurfaceBorder::Open {
                    (0..height).for_each(|y| g.right[size.index(width - 1, y)] = 0.0);
                    (0..width).for_each(|x| g.down[size.index(x, height - 1)] = 0.0);
                }
                let anchor = plane(size, &random(size, 3));
                let found = anchored(&g, &anchor, 9.0, border, &Job::default()).unwrap();
                let heights: Vec<f64> = found.as_slice().iter().map(|h| f64::from(*h)).collect();
                let made = differences(size, &heights, border);
                let spring = (TAU / 9.0).powi(2);
                let mut gradient: Vec<f64> = heights
                    .iter()
                    .zip(anchor.as_slice())
                    .map(|(h, a)| spring * (h - f64::from(*a)))
                    .collect();
                for texel in 0..size.texels() {
                    let (x, y) = (texel % width, texel / width);
                    let (right, down) =
                        (made.right[texel] - g.right[texel], made.down[texel] - g.down[texel]);
                    gradient[texel] -= right + down;
                    gradient[size.index((x + 1) % width, y)] += right;
                    gradient[size.index(x, (y + 1) % height)] += down;
                }
                let largest = gradient.iter().fold(0.0f64, |a, g| a.max(g.abs()));
                assert!(largest < 1e-5, "{border:?} {size}: {largest}");
            }
        }
    }

    #[test]
    fn a_surface_is_its_own_solution_and_a_cliff_without_slope_becomes_a_ramp() {
        let size = Size::new(32, 4);
        let surface = random(size, 4);
        for border in [SurfaceBorder::Open, SurfaceBorder::Periodic] {
            let own = differences(size, &surface, border);
            let found = anchored(&own, &plane(size, &surface), 16.0, border, &Job::default()).unwrap();
            assert!(worst(&surface, found.as_slice()) < 1e-6);
        }
        let cliff: Vec<f64> = (0..size.texels()).map(|texel| f64::from(u8::from(texel % 32 >= 16))).collect();
        let level = Differences { right: vec![0.0; size.texels()], down: vec![0.0; size.texels()] };
        let ramp =
            anchored(&level, &plane(size, &cliff), 32.0, SurfaceBorder::Open, &Job::default()).unwrap();
        let step = ramp.plane(0).windows(2).take(31).map(|pair| pair[1] - pair[0]).fold(0.0, f32::max);
        assert!(step < 0.12 && ramp.at(0, 0, 0) < 0.1 && ramp.at(0, 31, 0) > 0.9, "{step}");
    }

    #[test]
    fn lists_of_other_lengths_are_refused() {
        let anchor = Planes::zeros(Size::new(3, 2), 1);
        let short = Differences { right: vec![0.0; 5], down: vec![0.0; 6] };
        assert!(anchored(&short, &anchor, 9.0, SurfaceBorder::Open, &Job::default()).is_err());
        let level = Differences { right: vec![0.0; 6], down: vec![0.0; 6] };
        assert!(anchored(&level, &anchor, 0.0, SurfaceBorder::Open, &Job::default()).is_err());
    }
}
