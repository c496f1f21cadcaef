//! From slopes to heights. Measured slopes are rarely integrable. Both methods find the surface whose slopes
//! are nearest in the sum of squares; they differ in the definition of a slope.
//!
//! - [`IntegrationMethod::FrankotChellappa`]: derivatives of the trigonometric interpolation, exact for
//!   band-limited surfaces (R. T. Frankot, R. Chellappa, A method for enforcing integrability in shape
//!   from shading algorithms, IEEE PAMI 10(4), 1988, eq. 21);
//! - [`IntegrationMethod::Poisson`]: differences of neighbours, each to equal the mean of the two slopes (the discrete
//!   Poisson equation, with natural boundary conditions for an open picture).
//!
//! Both are one division in the Fourier domain. [`reference::poisson`] solves the second by
//! conjugate gradients on the texels themselves: the slow truth.
//!
//! [`integrate_weighted`] solves the second as well where a mask leaves parts out, or cliffs are to stay.
//!
//! The mean height is unknown and set to zero. A periodic surface has no overall tilt; an open one keeps its
//! tilt, because it is mirrored at its borders before the transform (four times the texels).

mod anchored;
mod fourier;
pub mod reference;
mod weighted;

pub use anchored::{Differences, anchored};
pub use weighted::{Discontinuities, integrate_weighted};

use super::slopes::Slopes;
use crate::error::Result;
use crate::job::Job;
use crate::memory::Footprint;
use crate::names::named;
use crate::numeric::fourier::BYTES_PER_TEXEL;
use crate::planes::Planes;
use crate::size::Size;

/// What a slope is.
#[derive(Debug, Clone, Copy, PartialEq, Eq, serde::Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum IntegrationMethod {
    /// The derivative of the trigonometric interpolation.
    FrankotChellappa,
    /// The mean of the differences to both neighbours.
    Poisson,
}

named!(IntegrationMethod { Poisson => "poisson", FrankotChellappa => "frankot-chellappa" });

/// What lies beyond the borders.
#[derive(Debug, Clone, Copy, PartialEq, Eq, serde::Serialize)]
#[serde(rename_all = "lowercase")]
pub enum SurfaceBorder {
    /// The surface repeats.
    Periodic,
    /// Nothing is known.
    Open,
}

named!(SurfaceBorder { Open => "open", Periodic => "periodic" });

/// How to integrate.
#[derive(Debug, Clone, Copy, PartialEq, Eq, serde::Serialize)]
pub struct IntegrateOptions {
    /// What a slope is.
    pub method: IntegrationMethod,
    /// What lies beyond the borders.
    pub border: SurfaceBorder,
}

impl Default for IntegrateOptions {
    /// Poisson on an open picture: suitable for measured slopes of any picture.
    fn default() -> Self {
        Self { method: IntegrationMethod::Poisson, border: SurfaceBorder::Open }
    }
}

/// Bytes of a texel while heights are solved for: one slope or its spectrum, and the transform of the other slope.
const SOLVED: u64 = 8 + BYTES_PER_TEXEL;

/// One plane of heights in texels, zero on average.
///
/// # Errors
/// When it does not fit into memory, and a cancelled job.
pub fn integrate(slopes: &Slopes, options: &IntegrateOptions, job: &Job) -> Result<Planes> {
    job.check_bytes("the integration of slopes", footprint(slopes.size(), options.border).peak)?;
    let heights = match options.border {
        SurfaceBorder::Periodic => fourier::solve(slopes.clone(), options.method, job)?,
        SurfaceBorder::Open => {
            let doubled = slopes.mirrored();
            let width = doubled.size().width;
            let heights = fourier::solve(doubled, options.method, job)?;
            let rows = heights.chunks_exact(width).take(slopes.size().height);
            rows.flat_map(|row| row[..slopes.size().width].to_vec()).collect()
        }
    };
    Planes::from_vec(slopes.size(), 1, heights.into_iter().map(|h| h as f32).collect())
}

/// The memory of [`integrate`], beside the slopes.
pub fn footprint(size: Size, border: SurfaceBorder) -> Footprint {
    let bytes = match border {
        SurfaceBorder::Periodic => SOLVED,
        // Mirrored slopes are four times as many.
        SurfaceBorder::Open => 4 * SOLVED,
    };
    Footprint::of_texels(size, bytes, 4)
}

/// The slopes nearest to the given ones that are slopes of a periodic surface: the projection of Frankot and
/// Chellappa. Undulations of the wavelength `longest` in texels are halved and longer ones damped more, as by
/// a spring at every texel; infinity disables the damping.
///
/// # Errors
/// A cancelled job.
pub fn project(slopes: &Slopes, longest: f64, job: &Job) -> Result<Slopes> {
    fourier::project(slopes, (std::f64::consts::TAU / longest).powi(2), job)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::limits::Limits;
    use crate::numeric::random::{Purpose, Stream};
    use std::f64::consts::TAU;

    fn integrated(slopes: &Slopes, method: IntegrationMethod, border: SurfaceBorder) -> Vec<f64> {
        let options = IntegrateOptions { method, border };
        let heights = integrate(slopes, &options, &Job::default()).unwrap();
        heights.as_slice().iter().map(|&h| f64::from(h)).collect()
    }

    fn random_slopes(size: Size) -> Slopes {
        let mut stream = Stream::new(5, Purpose::Sample, [size.texels() as u64]);
        let mut slopes = Slopes::level(size);
        slopes.p.iter_mut().chain(&mut slopes.q).for_each(|s| *s = 2.0 * stream.unit() - 1.0);
        slopes
    }

    /// Heights and slopes of a sum of waves that close on the torus; y up.
    fn waves(size: Size) -> (Vec<f64>, Slopes) {
        let (mut heights, mut slopes) = (vec![0.0; size.texels()], Slopes::level(size));
        for (i, (a, b, phase)) in
            [(1.0, 2.0, 0.3), (3.0, -1.0, 1.1), (0.0, 2.0, 2.0), (2.0, 0.0, 0.7)].iter().enumerate()
        {
            let (kx, ky) = (TAU * a / size.width as f64, TAU * b / size.height as f64);
            let amplitude = 1.5 / (1.0 + i as f64);
            for (texel, z) in heights.iter_mut().enumerate() {
                let (x, y) = ((texel % size.width) as f64, -((texel / size.width) as f64));
                let angle = kx * x + ky * y + phase;
                *z += amplitude * angle.sin();
                slopes.p[texel] += amplitude * kx * angle.cos();
                slopes.q[texel] += amplitude * ky * angle.cos();
            }
        }
        (heights, slopes)
    }

    fn worst(a: &[f64], b: &[f64]) -> f64 {
        a.iter().zip(b).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max)
    }

    #[test]
    fn band_limited_surfaces_come_back_exactly() {
        for (width, height) in [(17, 23), (16, 12), (31, 10)] {
            let (truth, slopes) = waves(Size::new(width, height));
            let found = integrated(&slopes, IntegrationMethod::FrankotChellappa, SurfaceBorder::Periodic);
            assert!(worst(&found, &truth) < 1e-5, "{width} x {height}");
        }
        let (truth, slopes) = waves(Size::new(128, 96));
        assert!(
            worst(&integrated(&slopes, IntegrationMethod::Poisson, SurfaceBorder::Periodic), &truth) < 0.05
        );
    }

    #[test]
    fn a_plane_and_a_bowl_come_back_in_open_pictures() {
        let size = Size::new(21, 14);
        let surface = |x: f64, y: f64| 0.3 * x - 0.7 * y + 0.02 * (x - 9.0) * (x - 9.0) + 0.01 * x * y;
        let (mut slopes, mut truth) = (Slopes::level(size), vec![0.0; size.texels()]);
        for (texel, z) in truth.iter_mut().enumerate() {
            let (x, y) = ((texel % 21) as f64, -((texel / 21) as f64));
            *z = surface(x, y);
            slopes.p[texel] = 0.3 + 0.04 * (x - 9.0) + 0.01 * y;
            slopes.q[texel] = -0.7 + 0.01 * x;
        }
        let mean = truth.iter().sum::<f64>() / truth.len() as f64;
        truth.iter_mut().for_each(|z| *z -= mean);
        // The mean of two slopes is the difference of a quadratic: exact.
        assert!(worst(&integrated(&slopes, IntegrationMethod::Poisson, SurfaceBorder::Open), &truth) < 1e-5);
        let fourier = integrated(&slopes, IntegrationMethod::FrankotChellappa, SurfaceBorder::Open);
        assert!(worst(&fourier, &truth) < 0.05 * 14.0, "{}", worst(&fourier, &truth));
    }

    #[test]
    fn the_poisson_solution_is_that_of_conjugate_gradients() {
        for (width, height) in [(1, 1), (1, 7), (6, 1), (2, 2), (5, 8), (13, 11), (16, 9)] {
            let slopes = random_slopes(Size::new(width, height));
            for border in [SurfaceBorder::Open, SurfaceBorder::Periodic] {
                let truth = reference::poisson(&slopes, border);
                let found = integrated(&slopes, IntegrationMethod::Poisson, border);
                assert!(worst(&found, &truth) < 1e-5, "{width} x {height} {border:?}");
            }
        }
    }

    #[test]
    fn projected_slopes_are_those_of_the_integrated_surface_and_stay_when_projected_again() {
        let slopes = random_slopes(Size::new(15, 9));
        let once = project(&slopes, f64::INFINITY, &Job::default()).unwrap();
        let twice = project(&once, f64::INFINITY, &Job::default()).unwrap();
        assert!(worst(&once.p, &twice.p) < 1e-12 && worst(&once.q, &twice.q) < 1e-12);
        let heights =
            |s: &Slopes| integrated(s, IntegrationMethod::FrankotChellappa, SurfaceBorder::Periodic);
        assert!(worst(&heights(&slopes), &heights(&once)) < 1e-5);
        // The removed part is orthogonal to the rest.
        let dot = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
        let rest = |all: &[f64], part: &[f64]| all.iter().zip(part).map(|(a, b)| a - b).collect::<Vec<_>>();
        let inner = dot(&rest(&slopes.p, &once.p), &once.p) + dot(&rest(&slopes.q, &once.q), &once.q);
        assert!(inner.abs() < 1e-9, "{inner}");
    }

    #[test]
    fn memory_is_asked_for_first() {
        let job = Job::new(Limits { max_bytes: 1000, ..Limits::default() });
        assert!(integrate(&Slopes::level(Size::new(9, 9)), &IntegrateOptions::default(), &job).is_err());
    }
}
