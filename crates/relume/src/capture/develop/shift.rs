//! Frames that moved against each other: a tripod that was touched, a hand-held camera.
//!
//! Light from another side turns bright edges into dark ones but leaves edges where they are, so the *magnitudes* of the
//! gradients are compared. The shift is the peak of their phase correlation (C. D. Kuglin, D. C. Hines, The phase
//! correlation image alignment method, IEEE Conf. Cybernetics and Society, 1975), and its fraction of a pixel the top of
//! the parabolas through its neighbours. Each frame is compared
//! with the sum of all others, moved by what is known so far. Where the phases do not agree, as of noise and of surfaces without
//! edges, the peak is one of chance, and the frame is taken not to have moved.
//!
//! Shadows and shading move edges a little with the light: that part is not undone ([`super::shift_by_light`]).

use realfft::num_complex::Complex64;

use super::{luminance_of, shift_by_light};
use crate::direction::Direction;
use crate::error::{Error, Result};
use crate::job::Job;
use crate::numeric::fourier::Fourier;
use crate::parallel;
use crate::planes::Planes;
use crate::raster::LoadRaster;
use crate::size::Size;
use crate::space::Space;

/// Shifts beyond this part of the shorter side are not believed.
pub const MOST_SHIFT: f64 = 0.1;
/// The side of the square in the middle that is compared, in pixels.
const MOST_SIDE: usize = 1024;
/// Rounds against a sum that is sharper each time.
const ROUNDS: usize = 4;

/// A peak is believed from so many standard deviations of the correlation on, and from this part of the peak of frames that agree in
/// all phases. Noise reaches 8.4 and 0.06, photographs of real surfaces 37 and 0.17.
const LEAST_DEVIATIONS: f64 = 9.0;
const LEAST_AGREEMENT: f64 = 0.1;
/// The standard deviation of the Gaussian over frequencies, in cycles a pixel: a peak as wide as a pixel, and no say of noise.
const FREQUENCIES: f64 = 0.15;

/// How frames moved.
#[derive(Debug, Clone, PartialEq)]
pub struct Shifts {
    /// For each photograph, by how many pixels (right, down) it has moved against the first.
    pub shifts: Vec<[f64; 2]>,
    /// The photographs that show too little to tell, which are taken not to have moved.
    pub untold: Vec<usize>,
    /// The most pixels of a photograph that follow the light, and are not among its shift.
    pub by_light: f64,
}

/// Finds how photographs moved against the first.
///
/// # Errors
/// Errors of `load`, photographs that differ in size, and the limits of the job.
pub fn shifts(lights: &[(String, Direction)], load: &LoadRaster, job: &Job) -> Result<Shifts> {
    let whole = load(0)?.size();
    let size = Size::new(whole.width.min(MOST_SIDE), whole.height.min(MOST_SIDE));
    let (x, y) = ((whole.width - size.width) / 2, (whole.height - size.height) / 2);
    let spectrum_bytes = 16 * (size.texels() / 2 + size.height) as u64;
    job.check_bytes("the alignment of the photographs", spectrum_bytes * (lights.len() as u64 + 6))?;
    let plan = Fourier::new(size);
    job.start("aligning the photographs", lights.len() as u64);
    let spectra = parallel::try_map(lights.iter().enumerate(), |(i, (name, _))| {
        let photograph = load(i)?;
        if photograph.size() != whole {
            return Err(Error::invalid(format!(
                "the photograph {name} is {} texels and the first {whole}: all must have the same size",
                photograph.size()
            )));
        }
        let part = photograph.crop(x, y, size)?.to_picture(Space::Srgb).planes;
        job.advance(1)?;
        Ok(plan.forward(edges(&part)))
    })?;
    let mut found = vec![[0.0; 2]; lights.len()];
    let mut peaks = vec![None; lights.len()];
    for _ in 0..ROUNDS {
        let mean = sum_of_moved(&spectra, &found, &plan);
        let of = |(spectrum, shift): (&Vec<Complex64>, &[f64; 2])| {
            // Without the frame itself, which would agree with itself where it is.
            let own = |(bin, all): (usize, &Complex64)| all - moved_back(spectrum[bin], &plan, bin, *shift);
            let others: Vec<Complex64> = mean.iter().enumerate().map(own).collect();
            peak(spectrum, &others, &plan)
        };
        peaks = parallel::map(spectra.iter().zip(&found), of);
        found = peaks.iter().map(|peak| peak.unwrap_or_default()).collect();
        job.proceed()?;
    }
    let directions: Vec<Direction> = lights.iter().map(|(_, light)| *light).collect();
    let by_light = shift_by_light::taken_out(&mut peaks, &directions);
    let first = peaks[0].unwrap_or_default();
    let from_first = |peak: &Option<[f64; 2]>| peak.map_or([0.0; 2], |[x, y]| [x - first[0], y - first[1]]);
    Ok(Shifts {
        shifts: peaks.iter().map(from_first).collect(),
        untold: (0..peaks.len()).filter(|i| peaks[*i].is_none()).collect(),
        by_light,
    })
}

/// The magnitudes of the gradients of the logarithm, less their mean, faded out towards the borders.
fn edges(part: &Planes) -> Vec<f64> {
    let size = part.size();
    let value = |x: usize, y: usize| {
        let texel = size.index(x, y);
        let v = |c: usize| f64::from(part.plane(c)[texel]);
        (if part.count() == 1 { v(0) } else { luminance_of([v(0), v(1), v(2)]) } + 0.05).ln()
    };
    let mut magnitudes = vec![0.0; size.texels()];
    for y in 1..size.height.saturating_sub(1) {
        for x in 1..size.width.saturating_sub(1) {
            let along = value(x + 1, y) - value(x - 1, y);
            let down = value(x, y + 1) - value(x, y - 1);
            magnitudes[size.index(x, y)] = along.hypot(down).min(1.0);
        }
    }
    let mean = magnitudes.iter().sum::<f64>() / magnitudes.len() as f64;
    let fade = |k: usize, n: usize| 0.5 - 0.5 * (std::f64::consts::TAU * (k as f64 + 0.5) / n as f64).cos();
    for (texel, m) in magnitudes.iter_mut().enumerate() {
        let (x, y) = (texel % size.width, texel / size.width);
        *m = (*m - mean) * fade(x, size.width) * fade(y, size.height);
    }
    magnitudes
}

/// The phase of a bin under a shift, in turns.
fn turns(plan: &Fourier, bin: usize, [right, down]: [f64; 2]) -> f64 {
    let Size { width, height } = plan.size();
    let (column, row) = (bin / height, bin % height);
    let row = if 2 * row > height { row as f64 - height as f64 } else { row as f64 };
    column as f64 * right / width as f64 + row * down / height as f64
}

/// A bin of the spectrum of a frame that is moved back by its shift.
fn moved_back(value: Complex64, plan: &Fourier, bin: usize, shift: [f64; 2]) -> Complex64 {
    value * Complex64::from_polar(1.0, std::f64::consts::TAU * turns(plan, bin, shift))
}

fn sum_of_moved(spectra: &[Vec<Complex64>], shifts: &[[f64; 2]], plan: &Fourier) -> Vec<Complex64> {
    let mut sums = vec![Complex64::ZERO; spectra[0].len()];
    parallel::for_each_value(&mut sums, |bin, sum| {
        let moved =
            spectra.iter().zip(shifts).map(|(spectrum, shift)| moved_back(spectrum[bin], plan, bin, *shift));
        *sum = moved.sum::<Complex64>();
    });
    sums
}

/// The shift of a frame against the mean, if they agree.
fn peak(spectrum: &[Complex64], mean: &[Complex64], plan: &Fourier) -> Option<[f64; 2]> {
    let size = plan.size();
    let weight = |bin: usize| {
        let (column, row) = (bin / size.height, bin % size.height);
        let row = row.min(size.height - row) as f64 / size.height as f64;
        let column = column as f64 / size.width as f64;
        (-(row * row + column * column) / (2.0 * FREQUENCIES * FREQUENCIES)).exp()
    };
    let phase = |(bin, (a, b)): (usize, (&Complex64, &Complex64))| {
        let cross = a * b.conj();
        let length = cross.norm();
        if length <= 1e-12 {
            return Complex64::ZERO;
        }
        cross / length * weight(bin)
    };
    let surface = plan.inverse(spectrum.iter().zip(mean).enumerate().map(phase).collect());
    let most = (MOST_SHIFT * size.width.min(size.height) as f64).max(1.0) as isize;
    let at = |dx: isize, dy: isize| {
        let x = dx.rem_euclid(size.width as isize) as usize;
        let y = dy.rem_euclid(size.height as isize) as usize;
        surface[size.index(x, y)]
    };
    let candidates = (-most..=most).flat_map(|dy| (-most..=most).map(move |dx| (dx, dy)));
    let best = candidates.max_by(|a, b| at(a.0, a.1).total_cmp(&at(b.0, b.1)));
    let (dx, dy) = best?;
    // The peak of frames that agree in all phases, and the usual height where none does.
    let whole = std::f64::consts::TAU * FREQUENCIES.powi(2);
    let by_chance = FREQUENCIES * (std::f64::consts::PI / surface.len() as f64).sqrt();
    if at(dx, dy) < (LEAST_AGREEMENT * whole).max(LEAST_DEVIATIONS * by_chance) {
        return None;
    }
    let top = |before: f64, here: f64, after: f64| {
        let below = before - 2.0 * here + after;
        if below < 0.0 { (0.5 * (before - after) / below).clamp(-0.5, 0.5) } else { 0.0 }
    };
    let right = dx as f64 + top(at(dx - 1, dy), at(dx, dy), at(dx + 1, dy));
    let down = dy as f64 + top(at(dx, dy - 1), at(dx, dy), at(dx, dy + 1));
    Some([right, down])
}

/// The planes of a frame that has moved by (right, down), moved back: cubic interpolation (R. G. Keys, Cubic
/// convolution interpolation, IEEE ASSP 29(6), 1981, a = -1/2), borders repeated.
pub(super) fn moved(planes: &Planes, right: f64, down: f64) -> Planes {
    let size = planes.size();
    let mut out = Planes::zeros(size, planes.count());
    let taps = |shift: f64, n: usize| -> Vec<([usize; 4], [f64; 4])> {
        let (whole, part) = (shift.floor(), shift - shift.floor());
        let weights = [1.0 + part, part, 1.0 - part, 2.0 - part].map(cubic);
        let place =
            |at: usize, k: isize| (at as isize + whole as isize + k - 1).clamp(0, n as isize - 1) as usize;
        (0..n).map(|at| (std::array::from_fn(|k| place(at, k as isize)), weights)).collect()
    };
    let (columns, rows) = (taps(right, size.width), taps(down, size.height));
    for (plane, values) in out.iter_mut().zip(planes.iter()) {
        for (texel, value) in plane.iter_mut().enumerate() {
            let ((xs, wx), (ys, wy)) = (&columns[texel % size.width], &rows[texel / size.width]);
            let row = |y: usize| -> f64 {
                xs.iter().zip(wx).map(|(&x, w)| w * f64::from(values[size.index(x, y)])).sum()
            };
            *value = ys.iter().zip(wy).map(|(&y, w)| w * row(y)).sum::<f64>().max(0.0) as f32;
        }
    }
    out
}

fn cubic(distance: f64) -> f64 {
    let d = distance.abs();
    match d {
        d if d < 1.0 => (1.5 * d - 2.5) * d * d + 1.0,
        d if d < 2.0 => ((-0.5 * d + 2.5) * d - 4.0) * d + 2.0,
        _ => 0.0,
    }
}
