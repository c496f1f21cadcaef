//! Learned functions packed for a model, within a number of bytes.

use crate::error::{Error, Result};
use crate::field::{Basis, Learned, PackedFunctions, ReflectanceField};
use crate::fit::learned::{deviations, in_packed};
use crate::format::rlm;
use crate::job::Job;

/// Halvings of the range of steps.
const HALVINGS: usize = 14;
/// The finest and the coarsest rounding, as root mean squares of values with white at 1.
const ROUNDINGS: [f64; 2] = [1e-5, 0.3];

/// The field in the first `functions` of its learned functions, which are packed in at most `bytes` bytes with the least
/// error; `None` for other fields, and for functions that are packed already.
///
/// # Errors
/// Functions that are not packed (see [`PackedFunctions::new`]), or do not fit; limits exceeded, and a cancelled job.
pub fn packed_field(
    field: &ReflectanceField,
    functions: usize,
    bytes: usize,
    job: &Job,
) -> Result<Option<ReflectanceField>> {
    let Basis::Learned(learned) = field.basis() else { return Ok(None) };
    if learned.packed().is_some() {
        return Ok(None);
    }
    let functions = functions.min(learned.functions());
    let packed = within(learned, &deviations(field.coefficients(), functions), bytes, job)?;
    in_packed(field, learned, &packed, job).map(Some)
}

/// The finest rounding that keeps to the bytes. All functions err alike in the values of the texture: steps are inverse to
/// the coefficients.
fn within(learned: &Learned, deviations: &[f64], bytes: usize, job: &Job) -> Result<PackedFunctions> {
    let at = |rounding: f64| {
        let steps: Vec<f32> = deviations.iter().map(|deviation| (rounding / deviation) as f32).collect();
        PackedFunctions::new(learned, &steps)
    };
    let mut found = None;
    at(ROUNDINGS[1])?;
    let [mut fine, mut coarse] = ROUNDINGS.map(f64::ln);
    for _ in 0..HALVINGS {
        job.proceed()?;
        let middle = 0.5 * (fine + coarse);
        match at(middle.exp()) {
            Ok(packed) if rlm::functions_bytes(&packed) <= bytes => (coarse, found) = (middle, Some(packed)),
            Ok(_) | Err(_) => fine = middle,
        }
    }
    // Rounded too coarsely, a function vanishes.
    found.filter(|packed| packed.unpacked().is_ok()).ok_or_else(|| {
        Error::usage(format!(
            "{} functions do not fit {bytes} bytes: give --function-bytes more, or ask for fewer functions",
            deviations.len()
        ))
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::direction::Direction;
    use crate::field::PlaneLayout;
    use crate::field::basis::{learned_example, learned_of_channels_example};
    use crate::numeric::random::{Purpose, Stream};
    use crate::planes::Planes;
    use crate::size::Size;
    use crate::space::Space;

    fn field() -> ReflectanceField {
        let mut stream = Stream::new(4, Purpose::Sample, [0]);
        let size = Size::new(6, 5);
        let deviation = [1.0, 0.4, 0.1, 0.02];
        let value = |i: usize| deviation[i / size.texels()] * (stream.unit() as f32 - 0.4);
        let planes = Planes::from_vec(size, 4, (0..4 * size.texels()).map(value).collect()).unwrap();
        let basis = Basis::Learned(learned_of_channels_example(3, 20, 15, 4));
        ReflectanceField::new(basis, PlaneLayout::shared(["R", "G", "B"]).unwrap(), Space::Srgb, planes)
            .unwrap()
    }

    /// The largest difference of relit values.
    fn difference(a: &ReflectanceField, b: &ReflectanceField) -> f32 {
        let mut most = 0.0f32;
        for light in [Direction::ZENITH, Direction::from_angles(0.7, 2.0)] {
            for (x, y) in (0..5).flat_map(|y| (0..6).map(move |x| (x, y))) {
                let (a, b) = (a.values(x, y, light), b.values(x, y, light));
                most = a.iter().zip(&b).fold(most, |most, (a, b)| most.max((a - b).abs()));
            }
        }
        most
    }

    #[test]
    fn more_bytes_make_the_texture_more_like_itself() {
        let field = field();
        let errors = [1500, 2200, 3200].map(|bytes| {
            let packed = packed_field(&field, 4, bytes, &Job::default()).unwrap().unwrap();
            let Basis::Learned(learned) = packed.basis() else { panic!("learned functions") };
            let used = rlm::functions_bytes(learned.packed().unwrap());
            assert!(used <= bytes && used > bytes * 9 / 10, "{used} of {bytes} bytes");
            difference(&field, &packed)
        });
        assert!(errors.windows(2).all(|pair| pair[1] < pair[0]) && errors[2] < 2e-2, "{errors:?}");
        assert!(
            packed_field(&field, 4, 100, &Job::default()).unwrap_err().to_string().contains("do not fit 100")
        );
    }

    #[test]
    fn the_first_functions_are_kept_and_other_textures_stay() {
        let packed = packed_field(&field(), 2, 5000, &Job::default()).unwrap().unwrap();
        assert_eq!(packed.coefficients().count(), 2);
        assert_eq!(packed_field(&packed, 2, 10, &Job::default()).unwrap(), None);
        let planes = Planes::zeros(Size::new(2, 2), 6);
        let ptm = ReflectanceField::new(Basis::Ptm, PlaneLayout::LUMINANCE, Space::Srgb, planes).unwrap();
        assert_eq!(packed_field(&ptm, 2, 10, &Job::default()).unwrap(), None);
        assert_eq!(learned_example(3, 2, 2).packed(), None);
    }
}
