//! The maps of a material, registered texel by texel, as one exemplar: where texels come from is chosen by all of
//! them.
//!
//! A synthesis that looks at the colour alone joins blocks where the colour matches, and tears everything else:
//! heights become a patchwork of cliffs. Index planes of several maps are therefore compared together, each map in
//! units of what shows of it:
//!
//! - values count by their variance, so that every map has the same say whatever its unit;
//! - heights count by their *slopes*: what shows of a height is the shading of its steps, so a difference of
//!   heights weighs in units of the steps between neighbours, as a difference of colours does in units of theirs.
//!
//! Maps that hardly vary keep a small weight: below a code of 8 bits there is noise only. With a map of opacity, all others
//! fade to their means where the surface is not there, so that what a hole hides is not compared.

mod heights;
mod normals;

pub use heights::{LONGEST_JOINED, join_heights};
pub use normals::{gather_map, is_normal_map, normals_of_slopes, slopes_of_normals, with_y_reversed};

use super::NamedMetric;
use crate::error::{Error, Result};
use crate::field::{Basis, Domain, ReflectanceField};
use crate::format::MapRole;
use crate::job::Job;
use crate::planes::Planes;
use crate::space::Space;

/// The least deviation of encoded values that is more than noise: a code of 8 bits.
const LEAST_DEVIATION: f64 = 1.0 / 255.0;
/// The least root mean square step of encoded heights that is more than noise.
const LEAST_STEP: f64 = 1.0 / 1000.0;

/// A map registered with the exemplars.
#[derive(Debug, Clone)]
pub struct RegisteredMap<'a> {
    /// Its meaning.
    pub role: MapRole,
    /// Its fields, one for each exemplar in turn and of its size.
    pub fields: Vec<&'a ReflectanceField>,
}

/// The index planes of exemplars, followed by those of the maps registered with them, in the scale of the
/// first.
///
/// # Errors
/// Maps that are not registered with the exemplars, and the job's limits.
pub fn joint_index(index: Vec<Planes>, maps: &[RegisteredMap<'_>], job: &Job) -> Result<Vec<Planes>> {
    if maps.is_empty() {
        return Ok(index);
    }
    let values = |planes: &Planes| planes.as_slice().len() as u64;
    let of_maps =
        maps.iter().flat_map(|map| &map.fields).map(|field| values(field.coefficients())).sum::<u64>();
    // Copies of the maps, and all planes joined.
    let bytes = 4 * (2 * of_maps + index.iter().map(values).sum::<u64>());
    job.check_bytes("the index of the exemplar and its maps", bytes)?;
    let mut parts: Vec<Vec<Planes>> = index.into_iter().map(|planes| vec![planes]).collect();
    maps.iter().try_for_each(|map| check_registered(map, &parts))?;
    let visible =
        maps.iter().find(|map| map.role == MapRole::Opacity).map(|map| map.planes(job)).transpose()?;
    for part in parts.iter_mut().flatten().zip(visible.iter().flatten()) {
        faded(part.0, part.1);
    }
    let texture = Spread::of(&parts.iter().flatten().collect::<Vec<_>>());
    for map in maps {
        let mut planes = map.planes(job)?;
        if map.role != MapRole::Opacity {
            planes
                .iter_mut()
                .zip(visible.iter().flatten())
                .for_each(|(planes, opacity)| faded(planes, opacity));
        }
        let weight = map.weight(&texture, &Spread::of(&planes.iter().collect::<Vec<_>>())) as f32;
        planes.iter_mut().for_each(|planes| planes.as_mut_slice().iter_mut().for_each(|v| *v *= weight));
        parts.iter_mut().zip(planes).for_each(|(parts, planes)| parts.push(planes));
    }
    parts.into_iter().map(|parts| joined(&parts, job)).collect()
}

/// Fades planes to their means where the surface is not there: what a hole hides is not compared.
fn faded(planes: &mut Planes, opacity: &Planes) {
    for plane in planes.iter_mut() {
        let mean = (plane.iter().map(|v| f64::from(*v)).sum::<f64>() / plane.len() as f64) as f32;
        let shares = opacity.plane(0).iter().map(|share| share.clamp(0.0, 1.0));
        plane.iter_mut().zip(shares).for_each(|(v, share)| *v = share * *v + (1.0 - share) * mean);
    }
}

impl RegisteredMap<'_> {
    /// Planes whose Euclidean distance is that of the map's values or functions.
    fn planes(&self, job: &Job) -> Result<Vec<Planes>> {
        let planes = |field: &&ReflectanceField| {
            if *field.basis() == Basis::Constant {
                return Ok(field.coefficients().clone());
            }
            let space = NamedMetric::Function.space(field, Domain::Hemisphere)?;
            space.index_planes_within(field, job, "the index of a registered map")
        };
        self.fields.iter().map(planes).collect()
    }

    /// The factor that brings its planes to the scale of the texture.
    fn weight(&self, texture: &Spread, map: &Spread) -> f64 {
        // Integer files hold values from 0 to 1; floats have any unit, and their own noise is not known.
        let is_encoded = self.fields.iter().all(|field| field.space() == Space::Srgb);
        let least = |floor: f64| if is_encoded { floor * floor } else { 0.0 };
        let (of_texture, of_map) = match self.role {
            MapRole::Height => (texture.steps, map.steps.max(least(LEAST_STEP))),
            _ => (texture.variance, map.variance.max(least(LEAST_DEVIATION))),
        };
        if of_map > 0.0 { (of_texture / of_map).sqrt() } else { 0.0 }
    }
}

fn check_registered(map: &RegisteredMap<'_>, exemplars: &[Vec<Planes>]) -> Result<()> {
    if map.fields.len() != exemplars.len() {
        return Err(Error::usage(format!(
            "{} fields are registered with {} exemplars: give one for each",
            map.fields.len(),
            exemplars.len()
        )));
    }
    for (field, exemplar) in map.fields.iter().zip(exemplars) {
        let (found, expected) = (field.size(), exemplar[0].size());
        if found != expected {
            return Err(Error::usage(format!(
                "a registered map has {found} texels and its exemplar {expected}: they must have the same size"
            )));
        }
    }
    Ok(())
}

/// All planes one after the other.
fn joined(parts: &[Planes], job: &Job) -> Result<Planes> {
    let count = parts.iter().map(Planes::count).sum();
    let mut joined =
        Planes::zeros_within(job, "the index of the exemplar and its maps", parts[0].size(), count)?;
    let planes = parts.iter().flat_map(Planes::iter);
    joined.iter_mut().zip(planes).for_each(|(to, from)| to.copy_from_slice(from));
    Ok(joined)
}

/// How much planes vary, summed over the planes: the mean squares over all exemplars together.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Spread {
    /// About the mean of each plane.
    variance: f64,
    /// Of the differences of neighbours, to the right and down.
    steps: f64,
}

impl Spread {
    fn of(exemplars: &[&Planes]) -> Self {
        let texels: usize = exemplars.iter().map(|planes| planes.size().texels()).sum();
        let mut spread = Self { variance: 0.0, steps: 0.0 };
        for k in 0..exemplars[0].count() {
            let values = || exemplars.iter().flat_map(|planes| planes.plane(k)).map(|v| f64::from(*v));
            let mean = values().sum::<f64>() / texels as f64;
            spread.variance += values().map(|v| (v - mean).powi(2)).sum::<f64>() / texels as f64;
            let (sum, count) =
                exemplars.iter().map(|planes| steps(planes, k)).fold((0.0, 0), |a, b| (a.0 + b.0, a.1 + b.1));
            spread.steps += sum / count.max(1) as f64;
        }
        spread
    }
}

/// The sum of the squared differences of neighbours in one plane, and their number.
fn steps(planes: &Planes, k: usize) -> (f64, usize) {
    let (size, plane) = (planes.size(), planes.plane(k));
    let square = |a: f32, b: f32| (f64::from(a) - f64::from(b)).powi(2);
    let across: f64 = plane
        .chunks_exact(size.width)
        .flat_map(|row| row.windows(2))
        .map(|pair| square(pair[0], pair[1]))
        .sum();
    let down: f64 = plane.iter().zip(&plane[size.width..]).map(|(a, b)| square(*a, *b)).sum();
    (across + down, (size.width - 1) * size.height + size.width * (size.height - 1))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::numeric::random::{Purpose, Stream};
    use crate::picture::Picture;
    use crate::size::Size;

    fn noise(size: Size, count: usize, amplitude: f64, seed: u64) -> ReflectanceField {
        let mut stream = Stream::new(seed, Purpose::Sample, [0]);
        let values = (0..size.texels() * count).map(|_| (amplitude * stream.unit()) as f32).collect();
        let planes = Planes::from_vec(size, count, values).unwrap();
        ReflectanceField::from_picture(Picture { planes, space: Space::Srgb })
    }

    fn of(role: MapRole, field: &ReflectanceField) -> RegisteredMap<'_> {
        RegisteredMap { role, fields: vec![field] }
    }

    #[test]
    fn what_a_hole_hides_is_not_compared() {
        let size = Size::new(12, 10);
        let (colour, other) = (noise(size, 3, 0.8, 1), noise(size, 3, 0.8, 2));
        let mut shares = Planes::from_vec(size, 1, vec![1.0; 120]).unwrap();
        shares.plane_mut(0)[..60].fill(0.0);
        let opacity = ReflectanceField::from_picture(Picture { planes: shares, space: Space::Srgb });
        let hidden = |of: &ReflectanceField| {
            let index = vec![of.coefficients().clone()];
            let joint = joint_index(
                index,
                &[MapRole::Opacity].map(|role| self::tests::of(role, &opacity)),
                &Job::default(),
            );
            let joint = joint.unwrap().swap_remove(0);
            (joint.plane(0)[..60].to_vec(), joint.plane(0)[60..].to_vec())
        };
        let (holes, surface) = hidden(&colour);
        assert!(holes.iter().all(|v| *v == holes[0]), "holes look alike");
        assert_eq!(surface, colour.coefficients().plane(0)[60..]);
        assert_ne!(hidden(&other).1, surface);
    }

    #[test]
    fn every_map_has_the_same_say_whatever_its_unit() {
        let size = Size::new(40, 30);
        let (colour, rough) = (noise(size, 3, 0.8, 1), noise(size, 1, 0.1, 2));
        let index = colour.coefficients().clone();
        let maps = [of(MapRole::Roughness, &rough)];
        let joint = joint_index(vec![index.clone()], &maps, &Job::default()).unwrap().swap_remove(0);
        assert_eq!(joint.count(), 4);
        assert_eq!(joint.as_slice()[..index.as_slice().len()], *index.as_slice());
        let texture = Spread::of(&[&index]);
        let mut added = joint.clone();
        added.as_mut_slice().rotate_left(3 * size.texels());
        let added = Spread::of(&[&added.truncated(1)]);
        assert!((added.variance / texture.variance - 1.0).abs() < 1e-5);
    }

    #[test]
    fn a_height_counts_by_its_steps_and_a_level_one_hardly() {
        let size = Size::new(64, 16);
        let colour = noise(size, 1, 1.0, 3);
        let field = |height: &dyn Fn(usize) -> f32| {
            let values = (0..size.texels()).map(|texel| height(texel % size.width)).collect();
            let planes = Planes::from_vec(size, 1, values).unwrap();
            ReflectanceField::from_picture(Picture { planes, space: Space::Srgb })
        };
        let slope = field(&|x| x as f32 / 64.0);
        let index = vec![colour.coefficients().clone()];
        let joint = joint_index(index.clone(), &[of(MapRole::Height, &slope)], &Job::default())
            .unwrap()
            .swap_remove(0);
        let step = f64::from(joint.at(1, 1, 0) - joint.at(1, 0, 0));
        // A step of the slope weighs like one of the colours; half of the pairs lie along it.
        let usual = Spread::of(&[colour.coefficients()]).steps.sqrt();
        assert!(step / usual > 1.2 && step / usual < 1.6, "{step} {usual}");
        let level = field(&|x| if x % 2 == 0 { 0.5 } else { 0.5 + 1e-5 });
        let joint =
            joint_index(index, &[of(MapRole::Height, &level)], &Job::default()).unwrap().swap_remove(0);
        assert!((f64::from(joint.at(1, 1, 0) - joint.at(1, 0, 0)) / usual).abs() < 0.02);
    }

    #[test]
    fn maps_of_another_size_or_number_are_refused() {
        let (colour, small) = (noise(Size::new(8, 8), 1, 1.0, 1), noise(Size::new(8, 7), 1, 1.0, 1));
        let index = || vec![colour.coefficients().clone()];
        assert!(joint_index(index(), &[of(MapRole::Other, &small)], &Job::default()).is_err());
        let none = RegisteredMap { role: MapRole::Other, fields: Vec::new() };
        assert!(joint_index(index(), &[none], &Job::default()).is_err());
    }
}
