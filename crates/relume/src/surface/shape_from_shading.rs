//! Shape from shading: slopes from one photograph of a matt surface of uniform albedo under a known light.
//!
//! The image irradiance equation E = rho R(p, q), R = (l_z - p l_x - q l_y) / sqrt(1 + p^2 + q^2), gives one
//! number for two unknowns; integrability makes them a surface. As in R. T. Frankot and R. Chellappa (A
//! method for enforcing integrability in shape from shading algorithms, IEEE PAMI 10(4), 1988), every round
//! moves the slopes of each texel towards its equation and then projects all of them onto the nearest
//! integrable ones. Where we differ: the step is a damped Newton step along the gradient of R instead of a
//! fixed fraction, so no step size has to be chosen; and the start is the linear solution in the Fourier
//! domain (A. P. Pentland, Linear shape from shading, IJCV 4, 1990) instead of a level surface, from which
//! the iteration would never depart under an almost overhead light.
//!
//! One photograph leaves ambiguities: undulations along the stripes of the light (perpendicular to its
//! azimuth) hardly shade, changes of albedo look like slopes, shadows are black whatever lies in them, and
//! under an overhead light hills and hollows look alike. Photometric stereo ([`super::photometric_stereo`])
//! has none of these problems and should be used where possible.

use realfft::num_complex::Complex64;

use super::integrate::{SurfaceBorder, project};
use super::slopes::Slopes;
use crate::direction::Direction;
use crate::error::{Error, Result};
use crate::job::Job;
use crate::memory::Footprint;
use crate::numeric::fourier::{BYTES_PER_TEXEL, Fourier};
use crate::planes::Planes;
use crate::size::Size;

/// Values darker than this fraction of the albedo are shadows and have no effect.
const SHADOW: f64 = 0.02;
/// Damping of the Newton step, relative to squared gradients of R, which are at most about one.
const DAMPING: f64 = 0.1;
/// The longest step of a round, as a slope.
const LONGEST_STEP: f64 = 0.5;
/// The noise-to-signal ratio of the linear start: how fast it fades where the light does not shade.
const LINEAR_NOISE: f64 = 0.05;
/// Lights within about six degrees of the zenith shade hills and hollows alike.
const LEAST_TILT: f64 = 0.1;

/// Options of the method.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize)]
pub struct ShadingOptions {
    /// The linear diffuse reflectance of the whole surface; `None` uses the value for which a level surface
    /// has the mean of the photograph. 1e-6 to 1e6.
    pub albedo: Option<f64>,
    /// The number of rounds of steps and projections, 1 to 10,000.
    pub rounds: usize,
    /// What lies beyond the borders.
    pub border: SurfaceBorder,
    /// Undulations of this wavelength in texels are halved in every round and longer ones damped more,
    /// because one photograph hardly determines them: at least 2. `None` applies no damping on the torus,
    /// where a surface cannot bend as a whole, and uses the longer side of an open picture.
    pub longest: Option<f64>,
}

impl Default for ShadingOptions {
    fn default() -> Self {
        Self { albedo: None, rounds: 50, border: SurfaceBorder::Open, longest: None }
    }
}

impl ShadingOptions {
    /// Checks every number.
    ///
    /// # Errors
    /// An albedo, rounds or a wavelength out of range.
    pub fn validate(&self) -> Result<()> {
        if let Some(albedo) = self.albedo.filter(|a| !(1e-6..=1e6).contains(a)) {
            return Err(Error::usage(format!(
                "the albedo is {albedo}: expected a number from 0.000001 to 1,000,000"
            )));
        }
        if !(1..=10_000).contains(&self.rounds) {
            return Err(Error::usage(format!("{} rounds: expected 1 to 10000", self.rounds)));
        }
        if let Some(longest) = self.longest.filter(|l| l.is_nan() || *l < 2.0) {
            return Err(Error::usage(format!(
                "the longest undulation is {longest} texels: expected at least 2"
            )));
        }
        Ok(())
    }
}

/// The result.
#[derive(Debug, Clone, PartialEq)]
pub struct Shading {
    /// Integrable slopes.
    pub slopes: Slopes,
    /// The albedo used.
    pub albedo: f64,
    /// Root of the mean squared difference of shading and E / rho.
    pub residual: f64,
}

/// Finds slopes whose shading reproduces the photograph: one plane, linear luminance.
///
/// # Errors
/// Options out of range, a photograph that is black or not finite, a light below the surface or nearly
/// overhead, or too little memory.
pub fn shape_from_shading(
    luminance: &Planes,
    light: Direction,
    options: &ShadingOptions,
    job: &Job,
) -> Result<Shading> {
    options.validate()?;
    check_light(light)?;
    job.check_bytes("shape from shading", footprint(luminance.size(), options.border).peak)?;
    let albedo = options.albedo.map_or_else(|| level_albedo(luminance, light), Ok)?;
    let shades: Vec<f64> = luminance.plane(0).iter().map(|&v| f64::from(v) / albedo).collect();
    if !shades.iter().all(|e| e.is_finite()) {
        return Err(Error::invalid("the photograph holds values that are not finite"));
    }
    let mut slopes = linear_start(&shades, luminance.size(), light, options.border, job)?;
    job.start("shape from shading", options.rounds as u64);
    for _ in 0..options.rounds {
        step(&mut slopes, &shades, light);
        slopes = integrable(&slopes, options, job)?;
        job.advance(1)?;
    }
    let residual = residual(&slopes, &shades, light);
    Ok(Shading { slopes, albedo, residual })
}

/// The memory of [`shape_from_shading`], beside the photograph.
pub fn footprint(size: Size, border: SurfaceBorder) -> Footprint {
    let bytes = match border {
        SurfaceBorder::Periodic => PROJECTED,
        // Mirrored slopes are four times as many.
        SurfaceBorder::Open => 4 * PROJECTED,
    };
    // The shades and the slopes.
    Footprint::of_texels(size, 8 + 16 + bytes, 16)
}

/// Bytes of a texel while slopes are projected: these and the projected slopes, the spectrum of the heights, and
/// a transform.
const PROJECTED: u64 = 16 + 16 + 8 + BYTES_PER_TEXEL;

/// The shading of slopes under a light, negative where they face away.
pub fn shading(p: f64, q: f64, light: Direction) -> f64 {
    (light.z() - p * light.x() - q * light.y()) / (1.0 + p * p + q * q).sqrt()
}

fn check_light(light: Direction) -> Result<()> {
    if light.z() <= 0.0 {
        return Err(Error::usage("the light is below the surface: its third number must be above 0"));
    }
    if light.x().hypot(light.y()) < LEAST_TILT {
        return Err(Error::usage(
            "the light is nearly overhead, where hills and hollows look alike: choose a photograph under a lower light",
        ));
    }
    Ok(())
}

/// The albedo for which a level surface has the mean of the photograph.
fn level_albedo(luminance: &Planes, light: Direction) -> Result<f64> {
    let values = luminance.plane(0);
    let mean = values.iter().map(|&v| f64::from(v)).sum::<f64>() / values.len() as f64;
    if !(mean > 1e-6 && mean.is_finite()) {
        return Err(Error::invalid("the photograph is black or not finite: there is no shading to read"));
    }
    Ok(mean / light.z())
}

/// Pentland's linear solution: E - l_z = -p l_x - q l_y, with Wiener damping where the light does not shade.
fn linear_start(
    shades: &[f64],
    size: Size,
    light: Direction,
    border: SurfaceBorder,
    job: &Job,
) -> Result<Slopes> {
    let image: Vec<f64> = shades.iter().map(|e| e - light.z()).collect();
    let (image, whole) = match border {
        SurfaceBorder::Periodic => (image, size),
        SurfaceBorder::Open => (even_mirror(&image, size), Size::new(2 * size.width, 2 * size.height)),
    };
    let plan = Fourier::new(whole);
    let mut spectrum = plan.forward_within(image, job)?;
    let frequency = |k: usize, n: usize| {
        let signed = if 2 * k > n { k as f64 - n as f64 } else { k as f64 };
        std::f64::consts::TAU * signed / n as f64
    };
    for (i, bin) in spectrum.iter_mut().enumerate() {
        let (wx, wy) = (frequency(i / whole.height, whole.width), -frequency(i % whole.height, whole.height));
        let along = wx * light.x() + wy * light.y();
        let below = along * along + LINEAR_NOISE * (wx * wx + wy * wy) + 1e-12;
        // E = -i (wx l_x + wy l_y) Z.
        *bin *= Complex64::i() * along / below;
    }
    let heights = plan.inverse_within(spectrum, job)?;
    Ok(central_slopes(&heights, whole, size))
}

/// An image mirrored at its right and lower border.
fn even_mirror(image: &[f64], size: Size) -> Vec<f64> {
    let Size { width, height } = size;
    let fold = |i: usize, n: usize| if i < n { i } else { 2 * n - 1 - i };
    let places = (0..2 * height).flat_map(|y| (0..2 * width).map(move |x| (x, y)));
    places.map(|(x, y)| image[size.index(fold(x, width), fold(y, height))]).collect()
}

/// Central differences of heights on the torus `whole`, of its upper left part `size`.
fn central_slopes(heights: &[f64], whole: Size, size: Size) -> Slopes {
    let mut slopes = Slopes::level(size);
    for (x, y) in (0..size.height).flat_map(|y| (0..size.width).map(move |x| (x, y))) {
        let at = |dx: usize, dy: usize| {
            heights[whole
                .index((x + whole.width + dx - 1) % whole.width, (y + whole.height + dy - 1) % whole.height)]
        };
        slopes.p[size.index(x, y)] = 0.5 * (at(2, 1) - at(0, 1));
        slopes.q[size.index(x, y)] = 0.5 * (at(1, 0) - at(1, 2));
    }
    slopes
}

/// One damped step of every texel towards its equation.
fn step(slopes: &mut Slopes, shades: &[f64], light: Direction) {
    let each = slopes.p.iter_mut().zip(&mut slopes.q).zip(shades);
    for ((p, q), &shade) in each.filter(|(_, shade)| **shade > SHADOW) {
        let square = 1.0 + *p * *p + *q * *q;
        let found = shading(*p, *q, light);
        let slant = found / square;
        let (along_p, along_q) =
            (-light.x() / square.sqrt() - slant * *p, -light.y() / square.sqrt() - slant * *q);
        let gradient = along_p * along_p + along_q * along_q;
        let factor = (shade.min(1.0) - found) / (gradient + DAMPING);
        let length = factor.abs() * gradient.sqrt();
        let factor = if length > LONGEST_STEP { factor * LONGEST_STEP / length } else { factor };
        *p += factor * along_p;
        *q += factor * along_q;
    }
}

fn integrable(slopes: &Slopes, options: &ShadingOptions, job: &Job) -> Result<Slopes> {
    let size = slopes.size();
    match options.border {
        SurfaceBorder::Periodic => project(slopes, options.longest.unwrap_or(f64::INFINITY), job),
        SurfaceBorder::Open => {
            let longest = options.longest.unwrap_or(size.width.max(size.height) as f64);
            Ok(project(&slopes.mirrored(), longest, job)?.cropped(size))
        }
    }
}

fn residual(slopes: &Slopes, shades: &[f64], light: Direction) -> f64 {
    let each = slopes.p.iter().zip(&slopes.q).zip(shades);
    let sum: f64 = each.map(|((p, q), e)| (shading(*p, *q, light).max(0.0) - e).powi(2)).sum();
    (sum / shades.len() as f64).sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::surface::integrate::{IntegrateOptions, IntegrationMethod, integrate};
    use std::f64::consts::TAU;

    /// A gentle periodic relief, its slopes, and its picture under a light.
    fn relief(size: Size, light: Direction, albedo: f64) -> (Slopes, Planes) {
        let mut slopes = Slopes::level(size);
        for texel in 0..size.texels() {
            let (x, y) = ((texel % size.width) as f64, -((texel / size.width) as f64));
            let (kx, ky) = (TAU / size.width as f64, TAU / size.height as f64);
            slopes.p[texel] =
                2.0 * kx * (kx * x + 0.5 * (ky * y).sin()).cos() + 1.2 * kx * (2.0 * kx * x - ky * y).cos();
            slopes.q[texel] = ky * (ky * y).cos() * (kx * x + 0.5 * (ky * y).sin()).cos()
                - 0.6 * ky * (2.0 * kx * x - ky * y).cos();
        }
        let value = |i: usize| (albedo * shading(slopes.p[i], slopes.q[i], light).max(0.0)) as f32;
        let picture = Planes::from_vec(size, 1, (0..size.texels()).map(value).collect()).unwrap();
        (slopes, picture)
    }

    fn correlation(a: &[f32], b: &[f32]) -> f64 {
        let dot = |a: &[f32], b: &[f32]| a.iter().zip(b).map(|(a, b)| f64::from(a * b)).sum::<f64>();
        dot(a, b) / (dot(a, a) * dot(b, b)).sqrt()
    }

    #[test]
    fn the_shape_of_a_matt_relief_is_found_along_the_light() {
        let light = Direction::new(0.8, 0.1, 0.6).unwrap();
        let (truth, picture) = relief(Size::new(48, 40), light, 0.7);
        let options = ShadingOptions {
            albedo: Some(0.7),
            rounds: 150,
            border: SurfaceBorder::Periodic,
            ..ShadingOptions::default()
        };
        let found = shape_from_shading(&picture, light, &options, &Job::default()).unwrap();
        assert!(found.residual < 0.01, "{}", found.residual);
        let integrated =
            IntegrateOptions { method: IntegrationMethod::FrankotChellappa, border: SurfaceBorder::Periodic };
        let height = |s: &Slopes| integrate(s, &integrated, &Job::default()).unwrap();
        let agreement = correlation(height(&found.slopes).as_slice(), height(&truth).as_slice());
        assert!(agreement > 0.95, "correlation {agreement:.3}");
    }

    #[test]
    fn rounds_bring_the_shading_nearer_to_the_photograph_in_open_pictures_too() {
        let light = Direction::new(-0.5, 0.6, 0.6).unwrap();
        let (_, picture) = relief(Size::new(37, 30), light, 0.5);
        let residual = |rounds: usize| {
            // Without damping: this relief is one undulation of the length of the picture.
            let options =
                ShadingOptions { rounds, longest: Some(f64::INFINITY), ..ShadingOptions::default() };
            shape_from_shading(&picture, light, &options, &Job::default()).unwrap().residual
        };
        assert!(residual(100) < 0.5 * residual(1), "{} {}", residual(100), residual(1));
    }

    #[test]
    fn what_cannot_be_read_is_refused() {
        let light = Direction::new(0.8, 0.1, 0.6).unwrap();
        let picture = relief(Size::new(8, 8), light, 0.7).1;
        let run = |picture: &Planes, light: Direction, options: ShadingOptions| {
            shape_from_shading(picture, light, &options, &Job::default()).map(|s| s.albedo)
        };
        let default = ShadingOptions::default();
        assert!(run(&picture, light, default).is_ok());
        assert!(run(&picture, Direction::ZENITH, default).is_err());
        assert!(run(&picture, Direction::new(1.0, 0.0, -0.1).unwrap(), default).is_err());
        assert!(run(&Planes::zeros(Size::new(8, 8), 1), light, default).is_err());
        assert!(run(&picture, light, ShadingOptions { albedo: Some(0.0), ..default }).is_err());
        assert!(run(&picture, light, ShadingOptions { rounds: 0, ..default }).is_err());
        assert!(run(&picture, light, ShadingOptions { longest: Some(f64::NAN), ..default }).is_err());
        let nan = Planes::from_vec(Size::new(1, 1), 1, vec![f32::NAN]).unwrap();
        assert!(run(&nan, light, default).is_err());
    }
}
