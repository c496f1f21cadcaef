//! The model of an exemplar, and any window of its plane.

use serde::Serialize;

use super::gaussian::{GaussianTransport, transport};
use super::grid::{corners, vertex};
use super::suits::{Suitability, suits};
use crate::error::{Error, Result};
use crate::job::{Held, Job};
use crate::memory;
use crate::numeric::random::{Purpose, key};
use crate::numeric::{Matrix, hash, principal};
use crate::parallel;
use crate::planes::Planes;
use crate::size::Size;

/// Options of [`Noise::new`].
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct NoiseOptions {
    /// Side of the triangles in texels; `None` for [`NoiseOptions::customary_side`].
    pub side: Option<f64>,
    /// Seed of the random choices.
    pub seed: u64,
}

impl NoiseOptions {
    /// The side with which an exemplar spans as many triangles as in the publication: 1 / (2 root 3) of its
    /// smaller side.
    pub fn customary_side(exemplar: Size) -> f64 {
        exemplar.width.min(exemplar.height) as f64 / 12f64.sqrt()
    }

    /// Checks the options in isolation.
    pub fn validate(&self) -> Result<()> {
        match self.side {
            Some(side) if !(side.is_finite() && side >= 1.0) => {
                Err(Error::usage(format!("triangles of side {side}: choose at least 1 texel")))
            }
            _ => Ok(()),
        }
    }
}

impl Default for NoiseOptions {
    /// The customary side, seed 0.
    fn default() -> Self {
        Self { side: None, seed: 0 }
    }
}

/// An endless plane of noise.
#[derive(Debug, Clone)]
pub struct Noise {
    side: f64,
    key: u64,
    /// Principal planes as normal values, the planes of a texel adjacent.
    normal: Vec<f32>,
    size: Size,
    marginals: Vec<GaussianTransport>,
    /// The mean of each index plane, and the principal axes as rows.
    means: Vec<f32>,
    axes: Matrix,
    suitability: Suitability,
    _held: Held,
}

/// The least texels on each side of an exemplar for triangles of a side.
fn least_exemplar(side: f64) -> f64 {
    2.0 * side + 3.0
}

/// What to do about an exemplar that is too small for its triangles, of the customary side or a given one.
fn too_small(size: Size, side: Option<f64>) -> Error {
    let Some(side) = side else {
        // From here on the customary triangles fit.
        let least =
            (1..).find(|&n| least_exemplar(NoiseOptions::customary_side(Size::new(n, n))) <= n as f64);
        return Error::usage(format!(
            "noise needs an exemplar of at least {} texels on each side, and this is {size}: use a larger one",
            least.expect("triangles grow more slowly than exemplars")
        ));
    };
    let fits_smaller = size.width.min(size.height) as f64 >= least_exemplar(1.0);
    let advice = if fits_smaller { "choose a smaller side or a larger exemplar" } else { "use a larger one" };
    Error::usage(format!(
        "triangles of side {side:.1} need an exemplar of at least {} texels on each side, and this is {size}: {advice}",
        least_exemplar(side).ceil()
    ))
}

impl Noise {
    /// Models index planes; [`super::suits()`] defines what is refused.
    ///
    /// # Errors
    /// When the texture repeats or has a direction, a value is not finite, the exemplar is smaller
    /// than its triangles, or the limits are exceeded.
    pub fn new(index: &Planes, options: &NoiseOptions, job: &Job) -> Result<Self> {
        options.validate()?;
        let size = index.size();
        job.check("the noise model", size, 16 * index.count() as u64)?;
        if index.as_slice().iter().any(|v| !v.is_finite()) {
            return Err(Error::invalid("the exemplar holds values that are not finite"));
        }
        let side = options.side.unwrap_or_else(|| NoiseOptions::customary_side(size));
        if (size.width.min(size.height) as f64) < least_exemplar(side) {
            return Err(too_small(size, options.side));
        }
        let suitability = suits(index, job)?;
        if let Some(objection) = suitability.objection() {
            return Err(Error::usage(objection));
        }
        let key = key(options.seed, Purpose::NoiseVertices, []);
        job.proceed()?;
        let held = job.hold("the noise model", 4 * (size.texels() * index.count()) as u64)?;
        Ok(Self { _held: held, ..Self::of(index, side, key, suitability) })
    }

    fn of(index: &Planes, side: f64, key: u64, suitability: Suitability) -> Self {
        let (size, count) = (index.size(), index.count());
        let (means, axes) = principal::axes(index);
        let along = |k: usize| -> Vec<f32> {
            let mut plane = vec![0.0; size.texels()];
            for (j, values) in index.iter().enumerate() {
                let weight = axes[(k, j)] as f32;
                plane.iter_mut().zip(values).for_each(|(out, v)| *out += weight * (v - means[j]));
            }
            plane
        };
        let planes: Vec<(Vec<f32>, GaussianTransport)> = parallel::map(0..count, |k| transport(&along(k)));
        let mut normal = vec![0.0; size.texels() * count];
        for (k, (plane, _)) in planes.iter().enumerate() {
            normal[k..].iter_mut().step_by(count).zip(plane).for_each(|(out, v)| *out = *v);
        }
        let marginals = planes.into_iter().map(|(_, marginal)| marginal).collect();
        Self { side, key, normal, size, marginals, means, axes, suitability, _held: Held::default() }
    }

    /// The measurements of the exemplar.
    pub fn suitability(&self) -> &Suitability {
        &self.suitability
    }

    /// The size of the exemplar.
    pub fn size(&self) -> Size {
        self.size
    }

    /// Side of the triangles in texels.
    pub fn side(&self) -> f64 {
        self.side
    }

    /// The key under which vertices are hashed ([`crate::numeric::hash::of_place`]), derived from the seed.
    pub fn key(&self) -> u64 {
        self.key
    }

    /// The principal planes of the exemplar as normal values: with [`Noise::marginals`] and [`Noise::axes`]
    /// all that a shader needs besides the side of the triangles and the key.
    pub fn normal_planes(&self) -> Planes {
        self.planes_of(self.size, &self.normal)
    }

    /// The inverse transport from normal values for each principal plane.
    pub fn marginals(&self) -> &[GaussianTransport] {
        &self.marginals
    }

    /// The mean of each index plane, and the principal axes as rows: index values are the mean plus the sum
    /// of all axes, each times the value of its plane.
    pub fn axes(&self) -> (&[f32], &Matrix) {
        (&self.means, &self.axes)
    }

    /// The index planes of the window of `size` texels whose top left texel is (x, y): identical however the
    /// plane is cut.
    ///
    /// # Errors
    /// When the window exceeds the limits.
    pub fn window(&self, x: i64, y: i64, size: Size, job: &Job) -> Result<Planes> {
        let count = self.marginals.len();
        job.check("the window", size, 8 * count as u64)?;
        let mut together = memory::zeros("the window", size.texels() * count)?;
        let rows = together.chunks_exact_mut(size.width * count).enumerate();
        parallel::try_for_each(rows, |(row, texels)| {
            job.proceed()?;
            let mut principal = vec![0.0; count];
            for (column, out) in texels.chunks_exact_mut(count).enumerate() {
                self.blend(x + column as i64, y + row as i64, &mut principal);
                self.index_of(&principal, out);
            }
            Ok(())
        })?;
        Ok(self.planes_of(size, &together))
    }

    /// Plane after plane from values whose planes are adjacent in each texel.
    fn planes_of(&self, size: Size, together: &[f32]) -> Planes {
        let count = self.marginals.len();
        let mut planes = Planes::zeros(size, count);
        parallel::for_each(
            planes.as_mut_slice().chunks_exact_mut(size.texels()).enumerate(),
            |(k, plane)| {
                plane.iter_mut().zip(together[k..].iter().step_by(count)).for_each(|(out, v)| *out = *v);
            },
        );
        planes
    }

    /// The normal values of one texel: sum w g / root(sum w^2), whose variance is that of each g.
    fn blend(&self, x: i64, y: i64, out: &mut [f32]) {
        let corners = corners(x as f64, y as f64, self.side);
        let length = corners.iter().map(|c| c.weight * c.weight).sum::<f64>().sqrt();
        out.fill(0.0);
        for corner in corners {
            let weight = (corner.weight / length) as f32;
            let start = self.source(corner.i, corner.j, x, y) * out.len();
            let texel = &self.normal[start..][..out.len()];
            out.iter_mut().zip(texel).for_each(|(sum, g)| *sum += weight * g);
        }
    }

    /// The exemplar texel shown by a vertex at (x, y).
    fn source(&self, i: i64, j: i64, x: i64, y: i64) -> usize {
        let (vx, vy) = vertex(i, j, self.side);
        let hash = hash::of_place(self.key, i, j);
        // A part extends by one side and the rounding of its middle.
        let margin = self.side as i64 + 1;
        let place = |hash: u32, side: usize| {
            let room = side as i64 - 2 * margin;
            margin + ((i64::from(hash) * room) >> 32)
        };
        let (sx, sy) = (place(hash[0], self.size.width) + x - vx, place(hash[1], self.size.height) + y - vy);
        self.size.index(sx as usize, sy as usize)
    }

    /// The index values of the normal values of a texel.
    fn index_of(&self, normal: &[f32], out: &mut [f32]) {
        out.copy_from_slice(&self.means);
        for (k, (marginal, g)) in self.marginals.iter().zip(normal).enumerate() {
            let value = marginal.value(*g);
            out.iter_mut().zip(self.axes.row(k)).for_each(|(sum, axis)| *sum += *axis as f32 * value);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::numeric::random::Stream;
    use proptest::prelude::*;

    /// Smoothed noise in correlated planes with skewed histograms.
    fn exemplar(side: usize) -> Planes {
        let mut stream = Stream::new(6, Purpose::Sample, [0]);
        let raw: Vec<f32> = (0..2 * side * side).map(|_| stream.unit() as f32).collect();
        let smooth = |k: usize, t: usize| {
            let (x, y) = (t % side, t / side);
            let near = (0..9).map(|i| raw[k * side * side + (y + i / 3) % side * side + (x + i % 3) % side]);
            (near.sum::<f32>() / 9.0).powi(2)
        };
        let data = (0..3 * side * side).map(|i| {
            let (k, t) = (i / (side * side), i % (side * side));
            if k == 2 { 0.5 * smooth(0, t) + smooth(1, t) } else { smooth(k, t) }
        });
        Planes::from_vec(Size::new(side, side), 3, data.collect()).unwrap()
    }

    fn moments(plane: &[f32]) -> [f64; 3] {
        let n = plane.len() as f64;
        let mean = plane.iter().map(|&v| f64::from(v)).sum::<f64>() / n;
        let central = |p: i32| plane.iter().map(|&v| (f64::from(v) - mean).powi(p)).sum::<f64>() / n;
        let deviation = central(2).sqrt();
        [mean, deviation, central(3) / deviation.powi(3)]
    }

    /// Parts come from the middle of the exemplar more often than from its edges, so statistics are those of
    /// about 500 independent spots of 3 x 3 texels: bounds are three standard deviations of such a sample (1
    /// / root 500, 1 / root 1000, root (6 / 500)). Plain averages would keep 0.71 of the deviation.
    #[test]
    fn means_deviations_and_skewness_are_kept() {
        let exemplar = exemplar(128);
        let noise = Noise::new(&exemplar, &NoiseOptions::default(), &Job::default()).unwrap();
        let made = noise.window(-300, 77, Size::new(512, 512), &Job::default()).unwrap();
        for (k, plane) in made.iter().enumerate() {
            let (before, after) = (moments(exemplar.plane(k)), moments(plane));
            assert!((before[0] - after[0]).abs() < 0.134 * before[1], "plane {k}: {before:?} {after:?}");
            assert!((after[1] / before[1] - 1.0).abs() < 0.095, "plane {k}: {before:?} {after:?}");
            assert!((before[2] - after[2]).abs() < 0.33, "plane {k}: {before:?} {after:?}");
        }
    }

    /// Plain averages lose contrast, which the blending operator prevents.
    #[test]
    fn without_the_operator_the_variance_would_be_lost() {
        let mean_squares = |n: usize| {
            let texels = (0..n).flat_map(|y| (0..n).map(move |x| corners(x as f64, y as f64, 20.0)));
            texels.map(|c| c.iter().map(|c| c.weight * c.weight).sum::<f64>()).sum::<f64>() / (n * n) as f64
        };
        assert!((mean_squares(200) - 0.5).abs() < 0.02, "half of the variance");
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(30))]

        #[test]
        fn windows_are_identical_however_they_are_cut(
            (x, y, dx, dy) in (-500i64..500, -500i64..500, 0usize..20, 0usize..20),
            (w, h, seed) in (1usize..20, 1usize..20, any::<u64>()),
        ) {
            let options = NoiseOptions { side: Some(7.5), seed };
            let noise = Noise::new(&exemplar(40), &options, &Job::default()).unwrap();
            let whole = noise.window(x, y, Size::new(dx + w, dy + h), &Job::default()).unwrap();
            let (left, top) = (x + dx as i64, y + dy as i64);
            let part = noise.window(left, top, Size::new(w, h), &Job::default()).unwrap();
            prop_assert_eq!(whole.crop(dx, dy, Size::new(w, h)).unwrap(), part);
        }
    }

    #[test]
    fn what_does_not_suit_is_refused() {
        let job = Job::default();
        let refused = |planes: &Planes, side: Option<f64>| {
            let options = NoiseOptions { side, seed: 0 };
            Noise::new(planes, &options, &job).unwrap_err().message().to_owned()
        };
        let small = exemplar(24);
        assert!(refused(&small, Some(12.0)).contains("24 x 24"));
        assert!(refused(&small, Some(f64::NAN)).contains("at least 1"));
        let tiled = exemplar(16).repeated(6, 6);
        assert!(refused(&tiled, None).contains("repeats"));
        let mut broken = small.clone();
        broken.plane_mut(1)[3] = f32::NAN;
        assert!(refused(&broken, None).contains("finite"));
    }
}
