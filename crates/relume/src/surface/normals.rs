//! Normals and albedo from the direction of maximal luminance.
//!
//! A matt surface is brightest when the light is in the direction of its normal (Malzbender, Gelb, Wolters,
//! "Polynomial Texture Maps", SIGGRAPH 2001, section 3.3). The functions of colour fields are combined to one
//! luminance (ITU-R BT.709-6: 0.2126, 0.7152, 0.0722). The weights are defined for linear light; with encoded
//! fields they give a luma, whose maximum is the same where the channels are proportional, because the
//! encoding is monotone. Cast shadows, specular reflections and the smoothness of the basis all bias the
//! maximum. For the biquadratic polynomial fitted to a matt sphere under 60 lights the bias is towards the
//! zenith, below 10 degrees for normals up to 40 degrees steep, about 6 on average; from about 45 degrees on
//! the polynomial is largest on the rim of the disk, and only the azimuth remains correct.

use super::argmax::ptm_maximum;
use super::brightest::BrightestSearch;
use super::luminance::LUMINANCE;
use crate::direction::{Direction, Directions};
use crate::field::{Basis, ReflectanceField};
use crate::parallel;
use crate::picture::Picture;
use crate::planes::Planes;

/// Three planes of unit normals (x right, y up, z to the viewer): for each texel the direction of maximal
/// luminance of its function. Fields of constants have the normal (0, 0, 1).
pub fn normals(field: &ReflectanceField) -> Planes {
    normals_of(field, &brightest(field))
}

/// The value of the function of each texel at its maximum, in the space of the field and not clamped. For a
/// matt surface this is its diffuse reflectance, since the light is then in the direction of the normal. One
/// plane per channel.
pub fn albedo(field: &ReflectanceField) -> Picture {
    albedo_of(field, &brightest(field))
}

/// [`normals`] and [`albedo`], in the time of one of them.
pub fn normals_and_albedo(field: &ReflectanceField) -> (Planes, Picture) {
    let directions = brightest(field);
    (normals_of(field, &directions), albedo_of(field, &directions))
}

fn normals_of(field: &ReflectanceField, directions: &[Direction]) -> Planes {
    let mut planes = Planes::zeros(field.size(), 3);
    for (c, plane) in planes.iter_mut().enumerate() {
        plane.iter_mut().zip(directions).for_each(|(out, direction)| *out = direction.to_array()[c] as f32);
    }
    planes
}

fn albedo_of(field: &ReflectanceField, directions: &[Direction]) -> Picture {
    let width = field.size().width;
    let mut planes = Planes::zeros(field.size(), field.layout().channels());
    let texels = field.size().texels();
    parallel::for_each(planes.as_mut_slice().chunks_exact_mut(texels).enumerate(), |(channel, plane)| {
        parallel::for_each(plane.chunks_mut(width).enumerate(), |(y, row)| {
            let mut weights = vec![0.0; field.basis().len() * field.basis().channels()];
            for (x, out) in row.iter_mut().enumerate() {
                field.basis().weights_into(Directions::lit_from(directions[y * width + x]), &mut weights);
                *out = field.channel_value(channel, x, y, &weights);
            }
        });
    });
    Picture { planes, space: field.space() }
}

/// The light under which each texel is brightest.
fn brightest(field: &ReflectanceField) -> Vec<Direction> {
    let width = field.size().width;
    let mut brightest = vec![Direction::ZENITH; field.size().texels()];
    match field.basis() {
        Basis::Constant => {}
        Basis::Ptm => parallel::for_each_value(&mut brightest, |texel, brightest| {
            let (u, v) = ptm_maximum(std::array::from_fn(|k| luminance_coefficient(field, k, texel)));
            *brightest = Direction::from_disk(u, v);
        }),
        basis => {
            let search = BrightestSearch::new(basis);
            parallel::for_each(brightest.chunks_mut(width).enumerate(), |(y, row)| {
                let (mut coefficients, mut weights) = (vec![0.0; basis.len()], search.scratch());
                for (texel, brightest) in (y * width..).zip(row) {
                    (0..basis.len()).for_each(|k| coefficients[k] = luminance_coefficient(field, k, texel));
                    *brightest = search.maximum(&coefficients, &mut weights);
                }
            });
        }
    }
    brightest
}

/// Coefficient `k` of the luminance of a texel. In an LRGB field the colour scales the function and is not
/// negative, so the function itself serves, even where the colour is black. Channels with other names have
/// equal weights. Channels with common coefficients have them as they are: the search combines their functions.
fn luminance_coefficient(field: &ReflectanceField, k: usize, texel: usize) -> f64 {
    let (layout, n) = (field.layout(), field.basis().len());
    let functions = layout.functions();
    let coefficient =
        |c: usize| f64::from(field.coefficients().plane(layout.function_plane(c, n) + k)[texel]);
    match functions {
        1 => coefficient(0),
        3 if !layout.is_named() => (0..3).map(|c| LUMINANCE[c] * coefficient(c)).sum(),
        _ => (0..functions).map(coefficient).sum::<f64>() / functions as f64,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::field::PlaneLayout;
    use crate::numeric::matrix::{Matrix, Qr};
    use crate::size::Size;
    use crate::space::Space;
    use crate::surface::argmax::maximum_by_search;

    /// Directions spread evenly over the cap above a polar angle (a Fibonacci lattice).
    fn spread(count: usize, lowest_z: f64) -> Vec<Direction> {
        let golden_angle = std::f64::consts::PI * (3.0 - 5f64.sqrt());
        let height = |i: usize| 1.0 - (1.0 - lowest_z) * (i as f64 + 0.5) / count as f64;
        (0..count).map(|i| Direction::from_angles(height(i).acos(), golden_angle * i as f64)).collect()
    }

    /// A row of matt texels with the given normals, fitted from `lights` by least squares.
    fn lambertian(normals: &[Direction], lights: &[Direction], albedo: f64) -> ReflectanceField {
        let design = Matrix::from_fn(lights.len(), 6, |i, k| Basis::Ptm.weights(lights[i])[k]);
        let fit = Qr::new(&design).pseudo_inverse();
        let seen =
            Matrix::from_fn(lights.len(), normals.len(), |i, t| albedo * lights[i].dot(normals[t]).max(0.0));
        let coefficients = fit.times(&seen);
        let data = (0..6).flat_map(|k| coefficients.row(k).iter().map(|&c| c as f32).collect::<Vec<_>>());
        let size = Size::new(normals.len(), 1);
        let planes = Planes::from_vec(size, 6, data.collect()).unwrap();
        ReflectanceField::new(Basis::Ptm, PlaneLayout::LUMINANCE, Space::Linear, planes).unwrap()
    }

    fn errors_deg(truth: &[Direction], found: &Planes) -> Vec<f64> {
        let found = (0..truth.len()).map(|t| {
            let n: Vec<f64> = (0..3).map(|k| f64::from(found.plane(k)[t])).collect();
            Direction::new(n[0], n[1], n[2]).unwrap()
        });
        truth.iter().zip(found).map(|(a, b)| a.dot(b).clamp(-1.0, 1.0).acos().to_degrees()).collect()
    }

    #[test]
    fn normals_of_a_matt_sphere_are_near_the_truth() {
        let truth = spread(500, 40f64.to_radians().cos());
        let field = lambertian(&truth, &spread(60, 0.15), 0.6);
        let errors = errors_deg(&truth, &normals(&field));
        let mean = errors.iter().sum::<f64>() / errors.len() as f64;
        let worst = errors.iter().fold(0.0f64, |a, &b| a.max(b));
        assert!(mean < 7.0 && worst < 10.0, "mean {mean:.2}, worst {worst:.2} degrees");
        let reflectance = albedo(&field);
        let (least, most) = reflectance.planes.range(0);
        assert!(least > 0.54 && most < 0.66, "albedo 0.6 found as {least:.3} to {most:.3}");
    }

    #[test]
    fn normals_keep_their_azimuth_however_steep() {
        let truth = spread(500, 60f64.to_radians().cos());
        let planes = normals(&lambertian(&truth, &spread(60, 0.15), 0.6));
        for (t, n) in truth.iter().enumerate().filter(|(_, n)| n.z() < 0.98) {
            let (x, y) = (f64::from(planes.plane(0)[t]), f64::from(planes.plane(1)[t]));
            let cosine = (x * n.x() + y * n.y()) / (x.hypot(y) * n.x().hypot(n.y()));
            assert!(cosine > 8f64.to_radians().cos(), "normal {n:?} found at azimuth ({x}, {y})");
        }
    }

    #[test]
    fn colour_fields_use_the_luminance_of_their_functions() {
        let size = Size::new(3, 2);
        let data: Vec<f32> = (0..18 * 6).map(|i| ((i * 37 + 11) % 23) as f32 / 11.0 - 1.0).collect();
        let planes = Planes::from_vec(size, 18, data).unwrap();
        let field = ReflectanceField::new(Basis::Ptm, PlaneLayout::RGB, Space::Linear, planes).unwrap();
        let (found, colors) = (normals(&field), albedo(&field));
        for (x, y) in [(0, 0), (1, 0), (2, 0), (0, 1), (1, 1), (2, 1)] {
            let luminance = |u: f64, v: f64| {
                let rgb = field.value(x, y, Direction::from_disk(u, v));
                rgb.iter().zip(LUMINANCE).map(|(&c, w)| f64::from(c) * w).sum::<f64>()
            };
            let (u, v) = maximum_by_search(luminance);
            let best = luminance(f64::from(found.at(0, x, y)), f64::from(found.at(1, x, y)));
            assert!(best >= luminance(u, v) - 1e-5, "({x}, {y})");
            let [r, g, b] = [0, 1, 2].map(|c| f64::from(colors.planes.at(c, x, y)));
            assert!((LUMINANCE[0] * r + LUMINANCE[1] * g + LUMINANCE[2] * b - best).abs() < 1e-5);
        }
    }

    #[test]
    fn constants_face_the_viewer() {
        let planes = Planes::from_vec(Size::new(2, 1), 3, vec![0.1, 0.2, 0.3, 0.4, 0.5, 0.6]).unwrap();
        let field = ReflectanceField::from_picture(Picture { planes: planes.clone(), space: Space::Srgb });
        assert_eq!(normals(&field).as_slice(), [0.0, 0.0, 0.0, 0.0, 1.0, 1.0]);
        assert_eq!(albedo(&field), Picture { planes, space: Space::Srgb });
    }
}
