//! Distance of the autocorrelations ([`Autocorrelation`]): which shifts a texture resembles itself at.
//!
//! The root mean square difference over the shifts that both textures reach, half their sides; each
//! octave of shift lengths counts alike, because short shifts are few and say most. It sees order at
//! any distance: lost periods, new ones (repetition), other sizes and directions of features. It
//! does not see brightness, contrast or colour, nor how features look.

use crate::error::Result;
use crate::limits::Limits;
use crate::numeric::autocorrelation::Autocorrelation;
use crate::planes::{Planes, Size};

/// The distance; see the module.
///
/// # Errors
/// When the limits are exceeded.
pub fn distance(reference: &Planes, other: &Planes, limits: &Limits) -> Result<f64> {
    let (a, b) = (Autocorrelation::half(reference.size()), Autocorrelation::half(other.size()));
    let reach = Size::new(a.width.min(b.width), a.height.min(b.height));
    let a = Autocorrelation::new(reference, reach, limits)?;
    let b = Autocorrelation::new(other, reach, limits)?;
    Ok(octave_means(reach, |dx, dy| (a.at(dx, dy) - b.at(dx, dy)).powi(2)).sqrt())
}

/// The mean over octaves of the length of the shift of the mean value in each.
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn octaves_count_alike() {
        let reach = Size::new(9, 5);
        assert!((octave_means(reach, |_, _| 3.0) - 3.0).abs() < 1e-12);
        // Lengths 1 and sqrt 2 are the first of four octaves: up to 10.3.
        let first = octave_means(reach, |dx, dy| if dx * dx + dy * dy < 4 { 1.0 } else { 0.0 });
        assert!((first - 0.25).abs() < 1e-12);
    }

    #[test]
    fn brightness_does_not_count_and_periods_do() {
        let values = |f: &dyn Fn(usize, usize) -> f32| {
            Planes::from_vec(Size::new(40, 40), 1, (0..1600).map(|i| f(i % 40, i / 40)).collect()).unwrap()
        };
        let limits = Limits::default();
        let fives = values(&|x, _| (x % 5) as f32);
        let brighter = values(&|x, _| 3.0 + 2.0 * (x % 5) as f32);
        let sevens = values(&|x, _| (x % 7) as f32);
        assert!(distance(&fives, &brighter, &limits).unwrap() < 1e-9);
        assert!(distance(&fives, &sevens, &limits).unwrap() > 0.3);
    }
}
