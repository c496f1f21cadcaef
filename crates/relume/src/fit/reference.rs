//! The slow and obvious fit: every texel independently, by normal equations in `f64`.
//!
//! Only the basis is shared with the fast fit. Luminance and colour are found by alternating least squares on
//! the photographs themselves (each is linear while the other is fixed), without singular values or a
//! factorisation of the lights.

use crate::direction::Direction;
use crate::error::{Error, Result};
use crate::field::{Basis, PlaneLayout, ReflectanceField};
use crate::numeric::Matrix;
use crate::picture::Picture;
use crate::planes::Planes;

/// Rounds of alternating least squares.
const ROUNDS: usize = 300;

/// Fits pictures under lights. `layout` is luminance for grey pictures, rgb or lrgb for others; all pictures
/// have the same size and are in one space, which becomes that of the field.
///
/// # Errors
/// When the lights do not determine the functions.
///
/// # Panics
/// When there is not one picture per light, or the channels of the pictures do not match `layout`.
pub fn fit(
    basis: &Basis,
    layout: &PlaneLayout,
    lights: &[Direction],
    pictures: &[Picture],
) -> Result<ReflectanceField> {
    assert_eq!(lights.len(), pictures.len(), "one picture a light");
    let first = pictures.first().ok_or_else(|| Error::usage("a fit needs at least one photograph"))?;
    assert!(pictures.iter().all(|p| p.planes.count() == layout.channels()), "channels of the layout");
    let rows: Vec<Vec<f64>> = lights.iter().map(|&light| basis.weights(light)).collect();
    let n = basis.len();
    let mut planes = Planes::zeros(first.size(), layout.planes(n));
    for texel in 0..first.size().texels() {
        let channel =
            |c: usize| -> Vec<f64> { pictures.iter().map(|p| f64::from(p.planes.plane(c)[texel])).collect() };
        let channels: Vec<Vec<f64>> = (0..layout.channels()).map(channel).collect();
        let solution = if layout.is_product() {
            product(&rows, &channels)?
        } else {
            let functions = channels.iter().map(|values| least_squares(&rows, values));
            functions.collect::<Result<Vec<_>>>()?.concat()
        };
        (0..solution.len()).for_each(|k| planes.plane_mut(k)[texel] = solution[k] as f32);
    }
    ReflectanceField::new(basis.clone(), layout.clone(), first.space, planes)
        .map(|field| field.with_lights(lights.to_vec()))
}

/// The solution of the normal equations A'A x = A'b.
fn least_squares(rows: &[Vec<f64>], values: &[f64]) -> Result<Vec<f64>> {
    let n = rows[0].len();
    let normal = Matrix::from_fn(n, n, |j, k| rows.iter().map(|row| row[j] * row[k]).sum());
    let right: Vec<f64> =
        (0..n).map(|k| rows.iter().zip(values).map(|(row, value)| row[k] * value).sum()).collect();
    let inverse = normal.cholesky()?.lower_inverse();
    let half: Vec<f64> = (0..n).map(|i| (0..=i).map(|j| inverse[(i, j)] * right[j]).sum()).collect();
    Ok((0..n).map(|i| (i..n).map(|j| inverse[(j, i)] * half[j]).sum()).collect())
}

/// The luminance coefficients and the colour, largest component 1, of one texel.
fn product(rows: &[Vec<f64>], channels: &[Vec<f64>]) -> Result<Vec<f64>> {
    let mut color = [1.0; 3];
    let mut luminance = Vec::new();
    for _ in 0..ROUNDS {
        let norm: f64 = color.iter().map(|c| c * c).sum();
        let mixed: Vec<f64> =
            (0..rows.len()).map(|i| (0..3).map(|c| color[c] * channels[c][i]).sum::<f64>() / norm).collect();
        luminance = least_squares(rows, &mixed)?;
        let relit: Vec<f64> =
            rows.iter().map(|row| row.iter().zip(&luminance).map(|(w, l)| w * l).sum()).collect();
        let energy: f64 = relit.iter().map(|l| l * l).sum();
        if energy == 0.0 {
            break;
        }
        color =
            std::array::from_fn(|c| relit.iter().zip(&channels[c]).map(|(l, v)| l * v).sum::<f64>() / energy);
    }
    let largest = color.iter().fold(0.0f64, |a, &b| a.max(b));
    luminance.iter_mut().for_each(|l| *l *= largest);
    luminance.extend(color.map(|c| c / largest));
    Ok(luminance)
}
