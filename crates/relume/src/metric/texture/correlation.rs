//! Distance of the autocorrelations ([`Autocorrelation`]): the shifts at which a texture is similar to
//! itself.
//!
//! [`Autocorrelation::distance`] over the shifts that both textures reach, half their sides. It detects order
//! at any distance: lost periods, new ones (repetition), other sizes and directions of features. It does not
//! detect brightness, contrast or colour, nor the appearance of features.

use crate::error::Result;
use crate::job::Job;
use crate::numeric::autocorrelation::Autocorrelation;
use crate::planes::Planes;
use crate::size::Size;

/// The distance; see the module.
///
/// # Errors
/// When the limits are exceeded.
pub fn distance(reference: &Planes, other: &Planes, job: &Job) -> Result<f64> {
    let (a, b) = (Autocorrelation::half(reference.size()), Autocorrelation::half(other.size()));
    let reach = Size::new(a.width.min(b.width), a.height.min(b.height));
    let a = Autocorrelation::new(reference, reach, job)?;
    let b = Autocorrelation::new(other, reach, job)?;
    Ok(a.distance(&b))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn brightness_does_not_count_and_periods_do() {
        let values = |f: &dyn Fn(usize, usize) -> f32| {
            Planes::from_vec(Size::new(40, 40), 1, (0..1600).map(|i| f(i % 40, i / 40)).collect()).unwrap()
        };
        let job = Job::default();
        let fives = values(&|x, _| (x % 5) as f32);
        let brighter = values(&|x, _| 3.0 + 2.0 * (x % 5) as f32);
        let sevens = values(&|x, _| (x % 7) as f32);
        assert!(distance(&fives, &brighter, &job).unwrap() < 1e-9);
        assert!(distance(&fives, &sevens, &job).unwrap() > 0.3);
    }
}
