//! A texture of learned functions as one of their packed form.

use crate::error::Result;
use crate::field::{Basis, Learned, PackedFunctions, ReflectanceField};
use crate::job::Job;
use crate::numeric::Matrix;
use crate::planes::Planes;

/// The texture in packed functions: its functions projected on the space of those that are restored from the integers,
/// which are orthonormal. `learned` is its basis.
///
/// # Errors
/// Integers that are not those of independent functions; limits exceeded, and a cancelled job.
pub fn in_packed(
    field: &ReflectanceField,
    learned: &Learned,
    packed: &PackedFunctions,
    job: &Job,
) -> Result<ReflectanceField> {
    let unpacked = packed.unpacked()?;
    let planes = projected(field.coefficients(), &projection(&unpacked, learned), job)?;
    ReflectanceField::new(Basis::Learned(unpacked), field.layout().clone(), field.space(), planes)
}

/// The root mean square of the coefficients of each of the first functions.
pub fn deviations(planes: &Planes, functions: usize) -> Vec<f64> {
    let square =
        |plane: &[f32]| plane.iter().map(|v| f64::from(*v).powi(2)).sum::<f64>() / plane.len() as f64;
    planes.iter().take(functions).map(|plane| square(plane).sqrt().max(1e-9)).collect()
}

/// The inner products of the packed functions with the functions.
fn projection(packed: &Learned, learned: &Learned) -> Matrix {
    let (m, n, channels) = (packed.functions(), learned.functions(), learned.channels());
    let basis = Basis::Learned(learned.clone());
    let mut products = Matrix::zeros(m, n);
    for (i, (pair, weight)) in packed.pairs().iter().zip(packed.weights()).enumerate() {
        let values = basis.weights(*pair);
        for c in 0..channels {
            let own = &packed.values()[(i * channels + c) * m..][..m];
            for (j, v) in own.iter().enumerate() {
                let factor = weight * f64::from(*v);
                let sums = products.row_mut(j).iter_mut().zip(&values[c * n..]);
                sums.for_each(|(sum, value)| *sum += factor * value);
            }
        }
    }
    products
}

/// Combinations of planes.
fn projected(planes: &Planes, matrix: &Matrix, job: &Job) -> Result<Planes> {
    let mut out =
        Planes::zeros_within(job, "the texture of the packed functions", planes.size(), matrix.rows())?;
    for (j, sums) in out.iter_mut().enumerate() {
        job.proceed()?;
        for (k, plane) in planes.iter().enumerate() {
            let share = matrix[(j, k)] as f32;
            sums.iter_mut().zip(plane).for_each(|(sum, v)| *sum += share * v);
        }
    }
    Ok(out)
}
