//! The distance of two textures in appearance: six kinds of statistics, each in units of the differences
//! between the parts of the reference itself.
//!
//! | kind | statistics | detects |
//! |---|---|---|
//! | patches | distributions of patches at several scales ([`super::sliced`]) | broken shapes, garbage |
//! | colours | distributions along the principal axes of the values, at several scales (`colour`) | wrong colours and brightness, patches of light and dark |
//! | detail | distributions of the strength of steps (`detail`) | blur, noise, missing joints |
//! | direction | main directions of steps (`detail`) | turned textures, broken lines |
//! | order | autocorrelations up to half the sides ([`super::correlation`]) | lost or new periods, order beyond the patch |
//! | repetition | the share that recurs nearby (`repetition`) | blocks laid several times in a row |
//!
//! Parts of one texture differ: a stone more or less in view changes a histogram. Each statistic is therefore
//! measured between the left and right half, and between the upper and lower half of the reference as well, and
//! its distance divided by the root mean square of these two and of a least value below which nobody looks. The
//! idea is that of the STSIM-M of J. Zujovic, T. Pappas, D. Neuhoff, Structural texture similarity metrics for
//! image analysis and retrieval, 2013: statistics in units of their deviation among views of one texture. So 1
//! is what the parts of the reference differ by, and no weights have to be chosen.
//!
//! Scales and axes of one kind are combined as root mean squares, kinds with the power 6, so that the worst
//! decides: a texture with perfect patches and wrong colours is wrong.
//!
//! The result depends on the textures and the seed alone. `docs/measures.md` shows what is detected and what is
//! not: a change that is smaller than the differences between parts of the reference.

use serde::Serialize;

use super::colour::Colours;
use super::detail::Detail;
use super::repetition::Repetition;
use super::resolutions::Resolution;
use super::sliced::{Projections, SlicedOptions};
use super::{LEAST_SIDE, pyramid};
use crate::error::Result;
use crate::job::Job;
use crate::numeric::autocorrelation::Autocorrelation;
use crate::numeric::{Matrix, principal};
use crate::planes::Planes;
use crate::size::Size;

/// Patches as in the patch distance, of a smaller sample.
const PATCHES: SlicedOptions = SlicedOptions { patch: 7, levels: 5, directions: 48, patches: 6_000, seed: 0 };
/// The most values of a distribution.
const VALUES: usize = 16_384;
/// The least side at which distributions of values are compared.
const COARSEST: usize = 16;
/// Autocorrelations are compared at the first level with a shorter side below this.
const ORDERED: usize = 384;
/// The power by which kinds are combined.
const POWER: i32 = 6;
/// Repetition is searched for within this part of the shorter side of the reference.
const REACH: usize = 5;

/// The kinds of statistics.
const KINDS: usize = 6;
/// Differences below which nobody looks: patches in units of their contrast, colours in deviations of the
/// reference, logarithms, anisotropy, correlation, and shares.
const LEAST: [f64; KINDS] = [0.01, 0.02, 0.02, 0.02, 0.01, 0.025];

/// The distance in appearance and its parts, each in units of the differences between halves of the reference.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Appearance {
    /// All of the following together.
    pub distance: f64,
    /// Patches at several scales.
    pub patches: f64,
    /// Values at several scales.
    pub colours: f64,
    /// The strength of steps at several scales.
    pub detail: f64,
    /// The direction of steps at several scales.
    pub direction: f64,
    /// Autocorrelation.
    pub order: f64,
    /// What recurs nearby.
    pub repetition: f64,
}

impl Appearance {
    fn new(parts: [f64; KINDS]) -> Self {
        let [patches, colours, detail, direction, order, repetition] = parts;
        let power = parts.iter().map(|part| part.powi(POWER)).sum::<f64>() / KINDS as f64;
        let distance = power.powf(1.0 / f64::from(POWER));
        Self { distance, patches, colours, detail, direction, order, repetition }
    }

    /// All parts as a list: patches, colours, detail, direction, order, repetition.
    pub fn parts(&self) -> [f64; KINDS] {
        [self.patches, self.colours, self.detail, self.direction, self.order, self.repetition]
    }

    /// The distance from several references or under several lights: the mean of each part, combined anew.
    /// `None` for an empty list.
    pub fn mean(all: &[Self]) -> Option<Self> {
        let of = |k: usize| all.iter().map(|one| one.parts()[k]).sum::<f64>() / all.len() as f64;
        (!all.is_empty()).then(|| Self::new(std::array::from_fn(of)))
    }

    /// The largest of each part, combined anew.
    pub fn worst(all: &[Self]) -> Option<Self> {
        let of = |k: usize| all.iter().map(|one| one.parts()[k]).fold(0.0, f64::max);
        (!all.is_empty()).then(|| Self::new(std::array::from_fn(of)))
    }
}

/// A texture to which others are compared.
#[derive(Debug, Clone)]
pub struct Reference {
    rules: Rules,
    whole: TextureStatistics,
    /// The differences between halves: for each kind one number for each of its statistics.
    spreads: [Vec<f64>; KINDS],
}

/// How all textures are measured that are compared to one reference.
#[derive(Debug, Clone)]
struct Rules {
    /// The principal axes of the reference as rows.
    axes: Matrix,
    /// The unit of values: the deviation of the reference.
    unit: f64,
    /// The level at which autocorrelations are compared, and the farthest shifts.
    ordered: usize,
    reach: Size,
    /// How far repetition is searched for.
    nearby: usize,
    seed: u64,
}

impl Reference {
    /// Measures a reference; `seed` draws patches and windows.
    ///
    /// # Errors
    /// When the limits are exceeded or the job is cancelled.
    ///
    /// # Panics
    /// When a side is below [`LEAST_SIDE`].
    pub fn new(planes: &Planes, seed: u64, job: &Job) -> Result<Self> {
        let size = planes.size();
        let shorter = size.width.min(size.height);
        assert!(shorter >= LEAST_SIDE, "large enough");
        let ordered = (0..).find(|level| shorter >> level < ORDERED).unwrap_or(0);
        let rules = Rules {
            axes: principal::axes(planes).1,
            unit: super::deviation(planes),
            ordered,
            reach: Autocorrelation::half(Size::new(size.width >> ordered, size.height >> ordered)),
            nearby: shorter / REACH,
            seed,
        };
        let whole = TextureStatistics::new(planes, &rules, job)?;
        let spreads = spreads(planes, &rules, job)?;
        Ok(Self { rules, whole, spreads })
    }

    /// The distance of a texture with the same planes.
    ///
    /// # Errors
    /// As [`Reference::new`].
    ///
    /// # Panics
    /// When the numbers of planes differ, or a side is below [`LEAST_SIDE`].
    pub fn distance(&self, other: &Planes, job: &Job) -> Result<Appearance> {
        assert_eq!(other.count(), self.rules.axes.rows(), "as many planes");
        let found = self.whole.distances(&TextureStatistics::new(other, &self.rules, job)?, &self.rules);
        Ok(Appearance::new(std::array::from_fn(|kind| {
            let spreads = &self.spreads[kind];
            let units = found[kind].iter().zip(spreads).map(|(d, s)| (d / s.hypot(LEAST[kind])).powi(2));
            let count = found[kind].len().min(spreads.len()).max(1);
            (units.sum::<f64>() / count as f64).sqrt()
        })))
    }
}

/// The root mean square differences between left and right, and upper and lower half.
fn spreads(planes: &Planes, rules: &Rules, job: &Job) -> Result<[Vec<f64>; KINDS]> {
    let Size { width, height } = planes.size();
    // Parts of small references overlap.
    let half = |side: usize| (side / 2).max(LEAST_SIDE);
    let (columns, rows) = (Size::new(half(width), height), Size::new(width, half(height)));
    let part = |x: usize, y: usize, size: Size| TextureStatistics::new(&planes.crop(x, y, size)?, rules, job);
    let across = part(0, 0, columns)?.distances(&part(width - columns.width, 0, columns)?, rules);
    let down = part(0, 0, rows)?.distances(&part(0, height - rows.height, rows)?, rules);
    Ok(std::array::from_fn(|kind| {
        let pairs = across[kind].iter().zip(&down[kind]);
        pairs.map(|(a, b)| a.hypot(*b) / 2.0f64.sqrt()).collect()
    }))
}

/// What is measured on one texture.
#[derive(Debug, Clone)]
struct TextureStatistics {
    /// At each level that holds four patches along a side.
    patches: Vec<Projections>,
    /// At each level down to [`COARSEST`].
    colours: Vec<Colours>,
    detail: Vec<Detail>,
    order: Autocorrelation,
    repetition: Repetition,
}

impl TextureStatistics {
    fn new(planes: &Planes, rules: &Rules, job: &Job) -> Result<Self> {
        let options = SlicedOptions { seed: rules.seed, ..PATCHES };
        let bytes = 4 * (PATCHES.patch.pow(2) * planes.count() + PATCHES.directions) * PATCHES.patches;
        job.check_bytes("the patches", bytes as u64)?;
        // A resolution, the one before it, and its rows.
        job.check("the texture at several resolutions", planes.size(), 12 * planes.count() as u64)?;
        let (mut patches, mut colours, mut detail) = (Vec::new(), Vec::new(), Vec::new());
        let mut level = Resolution::finest(planes);
        for number in 0u64.. {
            let Size { width, height } = level.size();
            let shorter = width.min(height);
            if number > 0 && shorter < COARSEST {
                break;
            }
            colours.push(Colours::new(&level.planes, &rules.axes, VALUES));
            detail.push(Detail::new(&level, VALUES));
            if (number as usize) < PATCHES.levels && (number == 0 || shorter >= 4 * PATCHES.patch) {
                patches.push(Projections::new(&level.planes, level.step, &options, number, job)?);
            }
            level = level.coarser();
        }
        let mut ordered = planes.clone();
        for _ in 0..rules.ordered {
            ordered = pyramid::halved(&ordered);
        }
        let order = Autocorrelation::new(&ordered, rules.reach, job)?;
        let repetition = Repetition::new(planes, rules.nearby, rules.seed);
        Ok(Self { patches, colours, detail, order, repetition })
    }

    /// The distances of each kind at each level, from this texture as the reference.
    fn distances(&self, other: &Self, rules: &Rules) -> [Vec<f64>; KINDS] {
        let patches = self.patches.iter().zip(&other.patches).map(|(a, b)| a.distance(b)).collect();
        let colours = self.colours.iter().zip(&other.colours);
        let colours = colours.flat_map(|(a, b)| a.distances(b)).map(|d| d / rules.unit).collect();
        let steps = self.detail.iter().zip(&other.detail).map(|(a, b)| a.distances(b));
        let (detail, direction) = steps.map(|[detail, direction]| (detail, direction)).unzip();
        let order = vec![self.order.distance(&other.order)];
        let repetition = vec![self.repetition.excess(&other.repetition, LEAST[KINDS - 1])];
        [patches, colours, detail, direction, order, repetition]
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::numeric::random::{Purpose, Stream};

    fn noise(size: Size, count: usize, seed: u64) -> Planes {
        let mut random = Stream::new(seed, Purpose::Sample, [0]);
        let data = (0..size.texels() * count).map(|_| random.unit() as f32).collect();
        Planes::from_vec(size, count, data).unwrap()
    }

    #[test]
    fn a_texture_is_at_distance_zero_from_itself_and_at_about_one_from_its_like() {
        let job = Job::default();
        let planes = noise(Size::new(96, 80), 3, 1);
        let reference = Reference::new(&planes, 0, &job).unwrap();
        assert_eq!(reference.distance(&planes, &job).unwrap(), Appearance::new([0.0; KINDS]));
        let like = reference.distance(&noise(Size::new(70, 111), 3, 2), &job).unwrap();
        assert!(like.distance < 1.5, "{like:?}");
    }

    #[test]
    fn each_part_counts_what_it_is_for() {
        let job = Job::default();
        let size = Size::new(128, 128);
        let planes = noise(size, 1, 5);
        let reference = Reference::new(&planes, 0, &job).unwrap();
        let found = |f: &dyn Fn(usize) -> f32| {
            let data = (0..size.texels()).map(f).collect();
            reference.distance(&Planes::from_vec(size, 1, data).unwrap(), &job).unwrap()
        };
        let at = |i: usize| planes.as_slice()[i % size.texels()];
        let brighter = found(&|i| at(i) + 0.1);
        assert!(brighter.colours > 5.0 && brighter.patches < 1e-3 && brighter.order < 1e-3, "{brighter:?}");
        let smooth = found(&|i| 0.5 * (at(i) + at(i + 1)));
        assert!(smooth.detail > 5.0 && smooth.direction > 5.0, "{smooth:?}");
        let repeated = found(&|i| at(i / 128 % 24 * 128 + i % 128 % 24));
        assert!(repeated.order > 1.2 && repeated.repetition > 20.0, "{repeated:?}");
    }

    #[test]
    fn the_smallest_and_flat_textures_can_be_compared() {
        let job = Job::default();
        for (width, height) in [(16, 16), (16, 90), (33, 17)] {
            for planes in [noise(Size::new(width, height), 2, 3), Planes::zeros(Size::new(width, height), 2)]
            {
                let reference = Reference::new(&planes, 0, &job).unwrap();
                assert_eq!(reference.distance(&planes, &job).unwrap().distance, 0.0);
                let other = reference.distance(&noise(Size::new(40, 20), 2, 4), &job).unwrap();
                assert!(other.distance.is_finite(), "{other:?}");
            }
        }
    }

    #[test]
    fn threads_do_not_change_the_result() {
        let job = Job::default();
        let (a, b) = (noise(Size::new(60, 50), 2, 8), noise(Size::new(50, 77), 2, 9));
        let found = || Reference::new(&a, 3, &job).unwrap().distance(&b, &job).unwrap();
        let pool = rayon::ThreadPoolBuilder::new().num_threads(1).build().unwrap();
        assert_eq!(found(), pool.install(found));
    }
}
