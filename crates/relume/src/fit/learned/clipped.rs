//! Coefficients of values that a display clips.
//!
//! Where a photograph is black, a function below black is as good as one at black, and likewise beyond white: relit values
//! are clipped. Least squares does not know it, and bends functions to zero wherever there is shadow. Here the residual of
//! such values is zero, and the coefficients move to the least squares of the others by the functions of the factorisation:
//! c + s P e with the pseudo-inverse P of the functions, the clipped residuals e and the step s of over-relaxation. (An
//! instance of majorisation: each step with s = 1 replaces what is clipped by its prediction and solves again.) Two steps
//! come within 0.02 dB of the limit on a capture of the SynthRTI set under lights that were not fitted.
//!
//! Photographs are read once for each step, so that memory does not grow with their number; textures of many views, whose
//! photographs are thousands, are left as they are.

use crate::error::Result;
use crate::fit::held_out::HeldOut;
use crate::fit::levels::SampleLevels;
use crate::fit::products::BAND;
use crate::fit::stream::PhotographStream;
use crate::job::Job;
use crate::numeric::Matrix;
use crate::parallel;
use crate::planes::Planes;
use crate::raster::Raster;

/// Steps, each a pass over the photographs.
const STEPS: usize = 2;

/// The over-relaxation of a step: below 2, at which it would stop to converge.
const RELAXATION: f64 = 1.7;

/// Moves coefficients to the least squares of values that are not clipped. `functions` holds the values of all functions
/// for each channel of each pair that takes part.
pub(super) fn refine(
    planes: &mut Planes,
    functions: &[f32],
    stream: &PhotographStream,
    held_out: &HeldOut,
    levels: &SampleLevels,
    job: &Job,
) -> Result<()> {
    let shares = relaxed_shares(functions, planes.count())?;
    let kept: Vec<Option<usize>> = held_out.places();
    let _before = job.hold("the coefficients", 4 * (planes.count() * planes.size().texels()) as u64)?;
    for _ in 0..STEPS {
        let before = planes.clone();
        stream.for_each_batch(job, |first, batch| {
            let pass = Pass { before: &before, functions, shares: &shares, levels };
            pass.add(planes, batch, &kept[first..]);
            job.proceed()
        })?;
    }
    Ok(())
}

/// The rows of the pseudo-inverse for each row of the functions, times the relaxation.
fn relaxed_shares(functions: &[f32], n: usize) -> Result<Vec<f32>> {
    let mut squares = Matrix::zeros(n, n);
    for row in functions.chunks_exact(n) {
        for (j, a) in row.iter().enumerate() {
            squares.row_mut(j).iter_mut().zip(row).for_each(|(sum, b)| *sum += f64::from(*a) * f64::from(*b));
        }
    }
    let factor = squares.cholesky()?.lower_inverse();
    let inverse = factor.transposed().times(&factor);
    let share = |row: &[f32], k: usize| {
        let dot: f64 = row.iter().zip(inverse.row(k)).map(|(f, m)| f64::from(*f) * m).sum();
        (RELAXATION * dot) as f32
    };
    Ok(functions.chunks_exact(n).flat_map(|row| (0..n).map(move |k| share(row, k))).collect())
}

/// A pass over the photographs.
struct Pass<'a> {
    before: &'a Planes,
    functions: &'a [f32],
    shares: &'a [f32],
    levels: &'a SampleLevels,
}

impl Pass<'_> {
    /// Adds the corrections of a batch, whose photographs have these places among those that take part.
    fn add(&self, planes: &mut Planes, batch: &[Raster], places: &[Option<usize>]) {
        let n = self.before.count();
        parallel::for_each(planes.bands_mut(BAND).into_iter().enumerate(), |(b, mut band)| {
            let (start, texels) = (b * BAND, band[0].len());
            let (mut residual, mut relit) = (vec![0.0f32; texels], vec![0.0f32; texels]);
            let taking_part = batch.iter().zip(places).filter_map(|(p, place)| place.map(|place| (p, place)));
            for (photograph, place) in taking_part {
                for channel in 0..photograph.channels() {
                    let row = (place * photograph.channels() + channel) * n;
                    self.relight(row, start, &mut relit);
                    self.levels.channel(photograph, channel, start, &mut residual);
                    residual
                        .iter_mut()
                        .zip(&relit)
                        .for_each(|(value, relit)| *value = clipped(*value, *relit));
                    for (plane, share) in band.iter_mut().zip(&self.shares[row..row + n]) {
                        plane.iter_mut().zip(&residual).for_each(|(c, e)| *c += share * e);
                    }
                }
            }
        });
    }

    fn relight(&self, row: usize, start: usize, out: &mut [f32]) {
        let n = self.before.count();
        out.fill(0.0);
        for (k, weight) in self.functions[row..row + n].iter().enumerate() {
            let plane = &self.before.plane(k)[start..][..out.len()];
            out.iter_mut().zip(plane).for_each(|(o, c)| *o += weight * c);
        }
    }
}

/// What a displayed value lacks: nothing where both are black or both are white.
fn clipped(value: f32, relit: f32) -> f32 {
    let is_clipped = (value <= 0.0 && relit < value) || (value >= 1.0 && relit > value);
    if is_clipped { 0.0 } else { value - relit }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::direction::{Direction, Directions};
    use crate::raster::Samples;
    use crate::size::Size;
    use crate::space::Space;

    /// Functions 1 and g, whose combination is below black under a part of the photographs.
    #[test]
    fn steps_lower_the_error_of_values_in_shadow() {
        let (count, size) = (24, Size::new(9, 4));
        let slope = |i: usize| -1.0 + 2.0 * i as f32 / (count - 1) as f32;
        let functions: Vec<f32> = (0..count).flat_map(|i| [1.0, slope(i)]).collect();
        let truth = |t: usize, i: usize| (0.1 + 0.01 * t as f32) + 0.5 * slope(i);
        let photograph = |i: usize| {
            let samples = (0..size.texels()).map(|t| truth(t, i).clamp(0.0, 1.0)).collect();
            Raster::new(size, 1, Samples::F32(samples)).unwrap()
        };
        let pairs: Vec<Directions> = (0..count).map(|i| Direction::fibonacci(count)(i).into()).collect();
        let held_out = HeldOut::new(&pairs, None).unwrap();
        let names: Vec<String> = (0..count).map(|i| format!("p{i}")).collect();
        let load = |i: usize| Ok(photograph(i));
        let job = Job::default();
        let names = names.iter().map(String::as_str).collect();
        let stream = PhotographStream::open(names, &load, |_| 2, &job).unwrap();
        let levels = SampleLevels::new(Space::Linear);
        let error = |planes: &Planes| -> f64 {
            let one = |t: usize, i: usize| {
                let relit = planes.plane(0)[t] + slope(i) * planes.plane(1)[t];
                f64::from(relit.clamp(0.0, 1.0) - truth(t, i).clamp(0.0, 1.0)).powi(2)
            };
            (0..size.texels()).flat_map(|t| (0..count).map(move |i| (t, i))).map(|(t, i)| one(t, i)).sum()
        };
        // Least squares: 1 and g are orthogonal over the photographs.
        let mut planes = Planes::zeros(size, 2);
        let norm: f32 = (0..count).map(|i| slope(i) * slope(i)).sum();
        for t in 0..size.texels() {
            let values: Vec<f32> = (0..count).map(|i| truth(t, i).clamp(0.0, 1.0)).collect();
            planes.plane_mut(0)[t] = values.iter().sum::<f32>() / count as f32;
            planes.plane_mut(1)[t] = values.iter().enumerate().map(|(i, v)| slope(i) * v).sum::<f32>() / norm;
        }
        let before = error(&planes);
        refine(&mut planes, &functions, &stream, &held_out, &levels, &job).unwrap();
        let after = error(&planes);
        assert!(after < 0.3 * before, "{before} before and {after} after");
    }

    #[test]
    fn only_values_beyond_the_display_are_free() {
        assert_eq!(clipped(0.0, -0.2), 0.0);
        assert_eq!(clipped(1.0, 1.5), 0.0);
        assert_eq!(clipped(0.0, 0.25), -0.25);
        assert_eq!(clipped(0.5, -0.5), 1.0);
        assert_eq!(clipped(1.0, 0.75), 0.25);
    }
}
