//! Normal maps: blended as directions, not as colours.

use super::RegisteredMap;
use crate::error::{Error, Result};
use crate::field::{Basis, PlaneLayout, ReflectanceField};
use crate::format::MapRole;
use crate::job::Job;
use crate::planes::Planes;
use crate::space::Space;
use crate::surface::{STEEPEST, Slopes};
use crate::synthesis::{SourceMap, gather};

/// The map made by applying a source map to a registered map. Blended normals are unit vectors again.
///
/// # Errors
/// As [`gather`].
pub fn gather_map(map: &SourceMap, registered: &RegisteredMap<'_>, job: &Job) -> Result<ReflectanceField> {
    let made = gather(map, &registered.fields, job)?;
    if map.mix_count() == 0 || !is_normal_map(&made, registered.role) {
        return Ok(made);
    }
    let is_packed = made.space() == Space::Srgb;
    let mut planes = made.coefficients().clone();
    for (texel, _) in map.mixes() {
        let packed: [f32; 3] = std::array::from_fn(|k| planes.plane(k)[texel]);
        let unit = normalised(packed, is_packed);
        (0..3).for_each(|k| planes.plane_mut(k)[texel] = unit[k]);
    }
    made.with_coefficients(planes)
}

/// A normal map with the second channel reversed, from +Y to -Y or back.
///
/// # Errors
/// A field without three planes.
pub fn with_y_reversed(normals: &ReflectanceField) -> Result<ReflectanceField> {
    let mut planes = normals.coefficients().clone();
    if planes.count() != 3 {
        return Err(Error::invalid(format!("a normal map has three channels, found {}", planes.count())));
    }
    let is_packed = normals.space() == Space::Srgb;
    planes.plane_mut(1).iter_mut().for_each(|v| *v = if is_packed { 1.0 - *v } else { -*v });
    normals.with_coefficients(planes)
}

/// Whether a field is a picture of normals.
pub fn is_normal_map(field: &ReflectanceField, role: MapRole) -> bool {
    role == MapRole::Normal && *field.basis() == Basis::Constant && *field.layout() == PlaneLayout::RGB
}

/// Two planes, the slopes of a normal map along x and along its second channel.
///
/// # Errors
/// Normals that are not finite.
pub fn slopes_of_normals(map: &ReflectanceField) -> Result<Planes> {
    let mut normals = map.coefficients().clone();
    if map.space() == Space::Srgb {
        normals.as_mut_slice().iter_mut().for_each(|v| *v = 2.0 * *v - 1.0);
    }
    let slopes = Slopes::from_normals(&normals, STEEPEST)?;
    let values = slopes.p.iter().chain(&slopes.q).map(|slope| *slope as f32).collect();
    Planes::from_vec(map.size(), 2, values)
}

/// The normal map, stored like another one, of two planes of slopes.
///
/// # Errors
/// Another number of planes.
pub fn normals_of_slopes(like: &ReflectanceField, planes: &Planes) -> Result<ReflectanceField> {
    if planes.count() != 2 {
        return Err(Error::invalid(format!("slopes are two planes, found {}", planes.count())));
    }
    let mut slopes = Slopes::level(planes.size());
    let copy = |to: &mut [f64], from: &[f32]| to.iter_mut().zip(from).for_each(|(t, f)| *t = f64::from(*f));
    copy(&mut slopes.p, planes.plane(0));
    copy(&mut slopes.q, planes.plane(1));
    let mut normals = slopes.normals();
    if like.space() == Space::Srgb {
        normals.as_mut_slice().iter_mut().for_each(|v| *v = 0.5 * *v + 0.5);
    }
    like.with_coefficients(normals)
}

/// A normal of length 1, stored as its components or packed as (n + 1) / 2; a vector without a direction stays.
fn normalised(stored: [f32; 3], is_packed: bool) -> [f32; 3] {
    let unpacked = stored.map(|v| if is_packed { 2.0 * f64::from(v) - 1.0 } else { f64::from(v) });
    let length = unpacked.iter().map(|v| v * v).sum::<f64>().sqrt();
    if length < 1e-6 {
        return stored;
    }
    unpacked.map(|v| if is_packed { (0.5 * v / length + 0.5) as f32 } else { (v / length) as f32 })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::picture::Picture;
    use crate::size::Size;
    use crate::synthesis::{BlockOptions, Boundary, Exemplar, synthesize};

    /// Normals of random slopes, packed or not.
    fn normals(size: Size, space: Space) -> ReflectanceField {
        let mut stream = crate::numeric::random::Stream::new(5, crate::numeric::random::Purpose::Sample, [0]);
        let mut slopes = Slopes::level(size);
        slopes.p.iter_mut().chain(&mut slopes.q).for_each(|s| *s = 4.0 * stream.unit() - 2.0);
        let mut planes = slopes.normals();
        if space == Space::Srgb {
            planes.as_mut_slice().iter_mut().for_each(|v| *v = 0.5 * *v + 0.5);
        }
        ReflectanceField::from_picture(Picture { planes, space })
    }

    fn lengths(field: &ReflectanceField) -> Vec<f64> {
        let planes = field.coefficients();
        let component = |k: usize, texel: usize| {
            let v = f64::from(planes.plane(k)[texel]);
            if field.space() == Space::Srgb { 2.0 * v - 1.0 } else { v }
        };
        (0..field.size().texels())
            .map(|t| (0..3).map(|k| component(k, t).powi(2)).sum::<f64>().sqrt())
            .collect()
    }

    #[test]
    fn feathered_normals_are_unit_vectors() {
        for space in [Space::Srgb, Space::Linear] {
            let field = normals(Size::new(48, 48), space);
            let exemplar = [Exemplar { index: field.coefficients(), excluded: None }];
            let options = BlockOptions {
                size: Size::new(70, 60),
                block: 16,
                overlap: 6,
                feather: 4,
                boundary: Boundary::Open,
                ..BlockOptions::default()
            };
            let map = synthesize(&exemplar, &options, &Job::default()).unwrap().map;
            assert!(map.mix_count() > 100);
            let plain = gather(&map, &[&field], &Job::default()).unwrap();
            assert!(lengths(&plain).into_iter().any(|length| length < 0.9));
            let registered = RegisteredMap { role: MapRole::Normal, fields: vec![&field] };
            let made = gather_map(&map, &registered, &Job::default()).unwrap();
            assert!(lengths(&made).into_iter().all(|length| (length - 1.0).abs() < 1e-5));
        }
    }

    #[test]
    fn slopes_lead_back_to_the_normals() {
        for space in [Space::Srgb, Space::Linear] {
            let field = normals(Size::new(9, 7), space);
            let back = normals_of_slopes(&field, &slopes_of_normals(&field).unwrap()).unwrap();
            for (a, b) in back.coefficients().as_slice().iter().zip(field.coefficients().as_slice()) {
                assert!((a - b).abs() < 1e-5);
            }
            let twice = with_y_reversed(&with_y_reversed(&field).unwrap()).unwrap();
            let once = with_y_reversed(&field).unwrap();
            assert_ne!(once, field);
            for (a, b) in twice.coefficients().as_slice().iter().zip(field.coefficients().as_slice()) {
                assert!((a - b).abs() < 1e-6);
            }
        }
    }
}
