//! Multi-scale patch distance: the sliced Wasserstein distance of the distributions of patches at
//! the levels of a Gaussian pyramid.
//!
//! Patches of `patch` x `patch` texels of all planes, each plane minus its mean over the patch, are points in
//! a space of many dimensions. Their distributions are compared along random unit vectors, where optimal
//! transport reduces to sorting (J. Rabin, G. Peyré, J. Delon, M. Bernot, Wasserstein barycenter and its
//! application to texture mixing, SSVM 2011; over the levels of a pyramid as T. Karras et al., Progressive
//! growing of GANs, ICLR 2018, section 5). The distance at a level is the mean over the vectors of the
//! Wasserstein-1 distance. The unit is the root mean square value in the patches of the reference at that
//! level, so that fine detail counts as much as coarse shapes. Karras et al. use a Laplacian pyramid and
//! divide each set by its own deviation; here both sets are divided by that of the reference, so that lost
//! contrast shows.
//!
//! It detects local structure at all scales up to the patch at the coarsest level. It does not detect
//! brightness, repetition of good patches, or order beyond that size. Patches and vectors are drawn from
//! random streams of their level and number: the result depends on the seed alone, and only slightly
//! (`docs/measures.md`).

use super::pyramid;
use super::wasserstein::{self, sorted};
use crate::error::{Error, Result};
use crate::job::Job;
use crate::numeric::dot;
use crate::numeric::random::{Purpose, Stream};
use crate::parallel;
use crate::planes::Planes;
use crate::size::Size;

/// How patches are compared.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct SlicedOptions {
    /// Side of the patches in texels, 1 to 255.
    pub patch: usize,
    /// The most levels, 1 to 16, each at half the resolution of the one before; levels with a side below four patches
    /// are left out, because they have too few patches for a distribution.
    pub levels: usize,
    /// The number of random vectors per level, 1 to 4096.
    pub directions: usize,
    /// The most patches per level and texture, 1 to 2^20.
    pub patches: usize,
    /// Another seed gives other vectors and patches.
    pub seed: u64,
}

impl Default for SlicedOptions {
    fn default() -> Self {
        Self { patch: 7, levels: 5, directions: 64, patches: 16_384, seed: 0 }
    }
}

impl SlicedOptions {
    /// Checks that there is something to compare.
    pub fn validate(&self) -> Result<()> {
        let counts = [
            ("patch", self.patch, 255),
            ("levels", self.levels, 16),
            ("directions", self.directions, 4096),
            ("patches", self.patches, 1 << 20),
        ];
        match counts.into_iter().find(|&(_, count, most)| !(1..=most).contains(&count)) {
            Some((name, count, most)) => Err(Error::usage(format!(
                "the patch distance cannot have {name} = {count}: expected a number from 1 to {most}"
            ))),
            None => Ok(()),
        }
    }
}

/// The distance at each level, from the finest; at least one.
///
/// # Errors
/// When the patch does not fit into a texture, or the patches exceed the limits.
///
/// # Panics
/// When the numbers of planes differ.
pub fn levels(reference: &Planes, other: &Planes, options: &SlicedOptions, job: &Job) -> Result<Vec<f64>> {
    assert_eq!(reference.count(), other.count(), "as many planes");
    let smallest = |planes: &Planes| planes.size().width.min(planes.size().height);
    let fits = |planes: &Planes, times: usize| smallest(planes) >= times * options.patch;
    if !fits(reference, 1) || !fits(other, 1) {
        return Err(Error::usage(format!(
            "patches of {0} x {0} texels do not fit into textures of {1} and {2}: choose a smaller patch",
            options.patch,
            reference.size(),
            other.size()
        )));
    }
    let sizes = [reference.size(), other.size()];
    job.check_bytes("the patches", bytes(sizes, reference.count(), options))?;
    let (mut a, mut b) = (reference.clone(), other.clone());
    let mut distances = vec![level_distance(&a, &b, options, 0, job)?];
    for level in 1..options.levels {
        (a, b) = (pyramid::halved(&a), pyramid::halved(&b));
        if !fits(&a, 4) || !fits(&b, 4) {
            break;
        }
        distances.push(level_distance(&a, &b, options, level as u64, job)?);
    }
    Ok(distances)
}

/// The memory of comparing textures of `planes`: both, the patches of both, and for each thread the coordinates
/// of these along a direction.
pub fn bytes(sizes: [Size; 2], planes: usize, options: &SlicedOptions) -> u64 {
    let patches = |size: Size| {
        let places = |side: usize| (side + 1).saturating_sub(options.patch);
        places(size.width).saturating_mul(places(size.height)).min(options.patches) as u64
    };
    let patch = 4 * (options.patch * options.patch * planes) as u64;
    let coordinates = 8 * rayon::current_num_threads() as u64;
    let one = |size: Size| 4 * (size.texels() * planes) as u64 + patches(size) * (patch + coordinates);
    sizes.into_iter().map(one).fold(0, u64::saturating_add)
}

fn level_distance(a: &Planes, b: &Planes, options: &SlicedOptions, level: u64, job: &Job) -> Result<f64> {
    let a = Projections::new(a, 1, options, level, job)?;
    Ok(a.distance(&Projections::new(b, 1, options, level, job)?))
}

/// The patches of a level, projected on each random vector.
#[derive(Debug, Clone)]
pub(super) struct Projections {
    /// For each vector the coordinates of all patches, in increasing order.
    lines: Vec<Vec<f32>>,
    /// The root mean square value in the patches.
    unit: f64,
}

impl Projections {
    /// The texels of a patch are `step` apart. Textures of one size are sampled at the same positions, so that a texture is at distance 0 from itself.
    ///
    /// # Panics
    /// When a patch does not fit.
    pub(super) fn new(
        planes: &Planes,
        step: usize,
        options: &SlicedOptions,
        level: u64,
        job: &Job,
    ) -> Result<Self> {
        let mut random = Stream::new(options.seed, Purpose::MeasuredPatches, [level]);
        let patches = patches(planes, step, options, &mut random);
        let along = |k: u64| {
            let mut random = Stream::new(options.seed, Purpose::MeasuredDirections, [level, k]);
            job.proceed()?;
            Ok(patches.projected(&unit_vector(patches.dimension, &mut random)))
        };
        let lines = parallel::try_map(0..options.directions as u64, along)?;
        Ok(Self { lines, unit: patches.unit() })
    }

    /// The mean distance along the vectors, in units of these patches.
    pub(super) fn distance(&self, other: &Self) -> f64 {
        let pairs = self.lines.iter().zip(&other.lines);
        let distances = parallel::map(pairs, |(a, b)| wasserstein::distance(a, b));
        distances.iter().sum::<f64>() / distances.len() as f64 / self.unit
    }
}

/// Patches as vectors, one after another.
struct Patches {
    dimension: usize,
    values: Vec<f32>,
}

impl Patches {
    /// The root mean square value; 1 for constant patches.
    fn unit(&self) -> f64 {
        let squares = self.values.iter().map(|&v| f64::from(v).powi(2)).sum::<f64>();
        if squares > 0.0 { (squares / self.values.len() as f64).sqrt() } else { 1.0 }
    }

    /// The coordinates of the patches along a vector, in increasing order.
    fn projected(&self, direction: &[f32]) -> Vec<f32> {
        sorted(self.values.chunks_exact(self.dimension).map(|patch| dot(patch, direction)).collect())
    }
}

/// All patches, or as many as allowed, one from each of equal stretches of the texture.
fn patches(planes: &Planes, step: usize, options: &SlicedOptions, random: &mut Stream) -> Patches {
    let (size, side) = (planes.size(), options.patch);
    let span = (side - 1) * step;
    let columns = size.width - span;
    let places = columns * (size.height - span);
    let count = places.min(options.patches);
    let dimension = side * side * planes.count();
    let mut values = Vec::with_capacity(count * dimension);
    for i in 0..count {
        let place = (i * places + random.below(places)) / count;
        let (x, y) = (place % columns, place / columns);
        for plane in planes.iter() {
            let start = values.len();
            for row in (y..=y + span).step_by(step) {
                values.extend(plane[size.index(x, row)..][..=span].iter().step_by(step));
            }
            centre(&mut values[start..]);
        }
    }
    Patches { dimension, values }
}

/// Subtracts the mean of the values; a patch without contrast becomes zeros.
fn centre(values: &mut [f32]) {
    let mean = values.iter().map(|&v| f64::from(v)).sum::<f64>() / values.len() as f64;
    // Differences far below the precision of a sample are rounding errors.
    let rounding = 1e-7 * mean.abs();
    values.iter_mut().for_each(|v| {
        let about = f64::from(*v) - mean;
        *v = if about.abs() > rounding { about as f32 } else { 0.0 };
    });
}

/// A vector of length 1, all directions equally likely.
fn unit_vector(dimension: usize, random: &mut Stream) -> Vec<f32> {
    let vector: Vec<f64> = (0..dimension).map(|_| random.normal()).collect();
    let length = vector.iter().map(|v| v * v).sum::<f64>().sqrt();
    vector.into_iter().map(|v| (v / length) as f32).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn noise(size: Size, count: usize, seed: u64) -> Planes {
        let mut random = Stream::new(seed, Purpose::Sample, [0]);
        let data = (0..size.texels() * count).map(|_| random.unit() as f32).collect();
        Planes::from_vec(size, count, data).unwrap()
    }

    fn distances(a: &Planes, b: &Planes, options: &SlicedOptions) -> Vec<f64> {
        levels(a, b, options, &Job::default()).unwrap()
    }

    #[test]
    fn a_texture_is_at_distance_zero_from_itself_and_near_its_like() {
        let options = SlicedOptions::default();
        let a = noise(Size::new(96, 80), 2, 1);
        let itself = distances(&a, &a, &options);
        assert_eq!(itself, vec![0.0; 2], "sides of 80 and 40 hold four patches, 20 does not");
        let like = distances(&a, &noise(Size::new(70, 111), 2, 2), &options);
        assert!(like[0] < 0.05, "{like:?}");
    }

    #[test]
    fn brightness_does_not_count_and_contrast_does() {
        let a = noise(Size::new(64, 64), 1, 3);
        let changed = |f: &dyn Fn(f32) -> f32| {
            Planes::from_vec(a.size(), 1, a.as_slice().iter().map(|&v| f(v)).collect()).unwrap()
        };
        let options = SlicedOptions { directions: 500, levels: 1, ..SlicedOptions::default() };
        assert!(distances(&a, &changed(&|v| v + 0.2), &options)[0] < 1e-5);
        // Twice as far from 0: each projection moves by its own magnitude, sqrt(2 / pi) deviations on average
        // for normal projections, as sums of 49 numbers nearly are.
        let found = distances(&a, &changed(&|v| 2.0 * v), &options)[0];
        let truth = (2.0 / std::f64::consts::PI).sqrt();
        assert!((found / truth - 1.0).abs() < 0.05, "{found} against {truth}");
    }

    #[test]
    fn the_result_is_the_seeds_alone() {
        let (a, b) = (noise(Size::new(50, 41), 3, 5), noise(Size::new(33, 60), 3, 6));
        let options = SlicedOptions { directions: 9, patches: 500, ..SlicedOptions::default() };
        let pool = rayon::ThreadPoolBuilder::new().num_threads(1).build().unwrap();
        assert_eq!(distances(&a, &b, &options), pool.install(|| distances(&a, &b, &options)));
        assert_ne!(distances(&a, &b, &options), distances(&a, &b, &SlicedOptions { seed: 1, ..options }));
        assert!(levels(&a, &noise(Size::new(6, 60), 3, 1), &options, &Job::default()).is_err());
        assert!(SlicedOptions { directions: 0, ..options }.validate().is_err());
    }
}
