//! The bytes of a `.ptm` preserve relit values better than the plain way of storing them: the range from the
//! least to the largest coefficient, each rounded independently.

use relume::field::{Basis, Domain, PlaneLayout};
use relume::format::{FieldFormat, decode_field, encode_field};
use relume::numeric::random::{Purpose, Stream};
use relume::{Planes, ReflectanceField, Size, Space};

use crate::support::{job, random_field};

/// The root of the mean squared error of relit values over lights, channels and texels.
fn relit_rmse(a: &ReflectanceField, b: &ReflectanceField) -> f64 {
    let gram = Basis::Ptm.gram(Domain::Hemisphere).unwrap();
    let texels = a.size().texels();
    let coefficient = |field: &ReflectanceField, channel: usize, k: usize, i: usize| {
        let planes = field.coefficients();
        let layout = field.layout();
        let function = f64::from(planes.plane(layout.function_plane(channel, 6) + k)[i]);
        function * layout.color_plane(channel, 6).map_or(1.0, |color| f64::from(planes.plane(color)[i]))
    };
    let mut sum = 0.0;
    for (i, channel) in (0..texels).flat_map(|i| (0..3).map(move |channel| (i, channel))) {
        let e: [f64; 6] =
            std::array::from_fn(|k| coefficient(a, channel, k, i) - coefficient(b, channel, k, i));
        sum += (0..36).map(|jk| e[jk / 6] * gram.at(jk / 6, jk % 6) * e[jk % 6]).sum::<f64>();
    }
    (sum / (3 * texels) as f64 / std::f64::consts::TAU).sqrt()
}

/// The field as stored in the plain way.
fn plainly_stored(field: &ReflectanceField) -> ReflectanceField {
    let mut planes = field.coefficients().clone();
    let functions = field.layout().functions();
    for k in 0..6 {
        let ranges = (0..functions).map(|c| field.coefficients().range(6 * c + k));
        let (lo, hi) = ranges.fold((f32::MAX, f32::MIN), |(a, b), (lo, hi)| (a.min(lo), b.max(hi)));
        let step = (hi - lo) / 254.0;
        let bias = (-lo / step).round();
        for c in 0..functions {
            planes.plane_mut(6 * c + k).iter_mut().for_each(|v| {
                *v = ((*v / step + bias).round().clamp(0.0, 255.0) - bias) * step;
            });
        }
    }
    planes.iter_mut().skip(6 * functions).flatten().for_each(|v| *v = (*v * 255.0).round() / 255.0);
    field.with_coefficients(planes).unwrap()
}

/// Bumps with a few bright texels, as real captures have: smooth slopes and rare extremes.
fn structured_field(color: PlaneLayout) -> ReflectanceField {
    let size = Size::new(96, 64);
    let mut random = Stream::new(21, Purpose::Sample, [0]);
    let mut planes = Planes::zeros(size, color.planes(6));
    for (i, texel) in (0..size.texels()).map(|i| (i, (i % 96, i / 96))) {
        let (x, y) = (texel.0 as f64 * 0.37, texel.1 as f64 * 0.29);
        let (slope_x, slope_y) = (0.3 * x.cos() * y.sin(), 0.3 * x.sin() * y.cos());
        let glint = if random.below(300) == 0 { 4.0 } else { 1.0 };
        let bright = 0.4 + 0.2 * (x * 0.31).sin() + 0.05 * random.unit();
        let function = [-0.4 * glint, -0.3 * glint, 0.2 * slope_x * slope_y, slope_x, slope_y, 1.0];
        let color_of = [1.0, 0.8 + 0.1 * (y * 0.2).sin(), 0.5 + 0.1 * random.unit()];
        for (k, plane) in planes.iter_mut().enumerate() {
            plane[i] = match color {
                PlaneLayout::LRGB if k >= 6 => color_of[k - 6],
                PlaneLayout::RGB => function[k % 6] * bright * color_of[k / 6],
                _ => function[k % 6] * bright,
            } as f32;
        }
    }
    ReflectanceField::new(Basis::Ptm, color, Space::Srgb, planes).unwrap()
}

fn errors_of(field: &ReflectanceField) -> (f64, f64) {
    let file = encode_field(field, FieldFormat::Ptm, None, &job()).unwrap();
    let ours = decode_field(&file, &job()).unwrap().field;
    (relit_rmse(field, &ours), relit_rmse(field, &plainly_stored(field)))
}

#[test]
fn relit_values_err_less_than_with_plain_rounding() {
    let size = Size::new(96, 64);
    for color in [PlaneLayout::RGB, PlaneLayout::LRGB] {
        let random = random_field(Basis::Ptm, color.clone(), Space::Srgb, size, 5);
        let (ours, plain) = errors_of(&random);
        println!("random {color:?}: {:.3} of 255 against {:.3}", 255.0 * ours, 255.0 * plain);
        assert!(ours < 0.93 * plain, "random {color:?}: {ours} against {plain}");
        let (ours, plain) = errors_of(&structured_field(color.clone()));
        println!("structured {color:?}: {:.3} of 255 against {:.3}", 255.0 * ours, 255.0 * plain);
        assert!(ours < 0.85 * plain, "structured {color:?}: {ours} against {plain}");
    }
}
