//! Clusters of the texels of a factorised texture, each with axes of its own.
//!
//! Texels are points in the space of the common functions, whose distance is that of their functions. From texels drawn
//! with probabilities that grow with the distance from those before (D. Arthur, S. Vassilvitskii, "k-means++", SODA
//! 2007), two steps alternate: each texel joins the cluster whose mean and axes are nearest to it, and each cluster takes
//! the mean and the main axes of its texels (Kambhatla, Leen 1997, the algorithm "VQPCA"). Axes follow by subspace
//! iteration from those of the round before (Golub, Van Loan, "Matrix Computations", section 8.2.4).

use super::point_axes::PointCluster;
use crate::error::{Error, Result};
use crate::field::{ClusterSpaces, ClusteredField, MOST_CLUSTERS, ReflectanceField};
use crate::job::Job;
use crate::numeric::random::{Purpose, Stream};
use crate::parallel;
use crate::planes::Planes;

/// Rounds of both steps; the error then falls by less than a thousandth a round.
const ROUNDS: usize = 20;
/// Rounds end where a smaller share of the texels joins another cluster.
const SETTLED: f64 = 0.002;
/// Texels assigned between two questions whether the job goes on.
const PART: usize = 1 << 10;

/// How many clusters, and how many numbers of a texel.
#[derive(Debug, Clone, Copy, PartialEq, Eq, serde::Serialize)]
pub struct ClusterOptions {
    /// Clusters of texels.
    pub clusters: usize,
    /// Axes of a cluster: the numbers of a texel beside its cluster.
    pub axes: usize,
}

impl ClusterOptions {
    /// Checks the options for textures of so many functions and texels.
    ///
    /// # Errors
    /// No cluster, more than [`MOST_CLUSTERS`] or than texels, no axis, or as many as functions or more.
    pub fn validate(&self, functions: usize, texels: usize) -> Result<()> {
        let most = MOST_CLUSTERS.min(texels);
        if self.clusters == 0 || self.clusters > most {
            return Err(Error::usage(format!(
                "1 to {most} clusters are made of {texels} texels, not {}",
                self.clusters
            )));
        }
        if self.axes == 0 || self.axes >= functions {
            return Err(Error::usage(format!(
                "a texel of a cluster has fewer numbers than the {functions} common functions and at least 1, not {}: \
                 ask for fewer, or for more functions",
                self.axes
            )));
        }
        Ok(())
    }
}

/// The clustered form of a texture with one plane for each function.
///
/// # Errors
/// Options without meaning, limits exceeded, and a cancelled job.
pub fn cluster(
    field: &ReflectanceField,
    options: &ClusterOptions,
    seed: u64,
    job: &Job,
) -> Result<ClusteredField> {
    let points = Points::new(field.coefficients(), job)?;
    options.validate(points.functions, points.count())?;
    job.start("clustering", ROUNDS as u64);
    let seeds = points.first_clusters(options.clusters, seed, job)?;
    let mut labels = points.nearest(&seeds, job)?;
    let mut clusters: Vec<PointCluster> =
        seeds.into_iter().map(|seed| seed.with_axes(options.axes)).collect();
    for round in 0..ROUNDS {
        clusters = points.moved(&clusters, &labels, job)?;
        let nearest = points.nearest(&clusters, job)?;
        let changed = nearest.iter().zip(&labels).filter(|(a, b)| a != b).count();
        labels = nearest;
        if changed as f64 <= SETTLED * labels.len() as f64 {
            job.advance((ROUNDS - round) as u64)?;
            break;
        }
        job.advance(1)?;
    }
    let clusters: Vec<PointCluster> = clusters.iter().map(PointCluster::rounded).collect();
    let planes = points.numbers(&clusters, &labels, field.coefficients(), options.axes, job)?;
    let coefficients = clusters.iter().flat_map(PointCluster::coefficients).collect();
    let spaces = ClusterSpaces::new(points.functions, options.axes, coefficients)?;
    ClusteredField::new(field.basis().clone(), field.layout().clone(), field.space(), spaces, planes)
}

/// Texels as points, all coefficients of a texel adjacent.
struct Points {
    functions: usize,
    values: Vec<f32>,
    _held: crate::job::Held,
}

impl Points {
    fn new(planes: &Planes, job: &Job) -> Result<Self> {
        let (functions, texels) = (planes.count(), planes.size().texels());
        let held = job.hold("the texels as points", 12 * texels as u64 + 4 * (functions * texels) as u64)?;
        let mut values = vec![0.0; functions * texels];
        parallel::for_each(values.chunks_mut(PART * functions).enumerate(), |(part, points)| {
            for (texel, point) in (part * PART..).zip(points.chunks_exact_mut(functions)) {
                point.iter_mut().enumerate().for_each(|(k, value)| *value = planes.plane(k)[texel]);
            }
        });
        Ok(Self { functions, values, _held: held })
    }

    fn count(&self) -> usize {
        self.values.len() / self.functions
    }

    fn point(&self, texel: usize) -> &[f32] {
        &self.values[texel * self.functions..][..self.functions]
    }

    /// Texels as means without axes.
    fn first_clusters(&self, count: usize, seed: u64, job: &Job) -> Result<Vec<PointCluster>> {
        let mut stream = Stream::new(seed, Purpose::ClusterSeeds, []);
        let mut chosen = stream.below(self.count());
        let mut squares = vec![f64::INFINITY; self.count()];
        let mut clusters = Vec::with_capacity(count);
        loop {
            job.proceed()?;
            let from = self.point(chosen);
            clusters.push(PointCluster::at(from));
            if clusters.len() == count {
                return Ok(clusters);
            }
            parallel::for_each_value(&mut squares, |texel, square| {
                let pairs = self.point(texel).iter().zip(from);
                *square = square.min(pairs.map(|(a, b)| f64::from(a - b).powi(2)).sum());
            });
            chosen = drawn(&squares, stream.unit());
        }
    }

    /// The nearest cluster of each texel, of equal ones the first.
    fn nearest(&self, clusters: &[PointCluster], job: &Job) -> Result<Vec<u32>> {
        let mut labels = vec![0; self.count()];
        parallel::try_for_each(labels.chunks_mut(PART).enumerate(), |(part, labels)| {
            job.proceed()?;
            let mut from_mean = vec![0.0; self.functions];
            for (i, label) in labels.iter_mut().enumerate() {
                let point = self.point(part * PART + i);
                let mut best = f64::INFINITY;
                for (k, cluster) in clusters.iter().enumerate() {
                    let distance = cluster.square_distance(point, &mut from_mean);
                    if distance < best {
                        (best, *label) = (distance, k as u32);
                    }
                }
            }
            Ok(())
        })?;
        Ok(labels)
    }

    /// Clusters with the means and axes of their texels; one without texels stays.
    fn moved(&self, clusters: &[PointCluster], labels: &[u32], job: &Job) -> Result<Vec<PointCluster>> {
        let moved = |(k, cluster): (usize, &PointCluster)| {
            job.proceed()?;
            let own = labels.iter().enumerate().filter(|(_, label)| **label as usize == k);
            let texels: Vec<&[f32]> = own.map(|(texel, _)| self.point(texel)).collect();
            Ok(cluster.of_points(&texels))
        };
        parallel::try_map(clusters.iter().enumerate(), moved)
    }

    /// The cluster of each texel and its numbers.
    fn numbers(
        &self,
        clusters: &[PointCluster],
        labels: &[u32],
        like: &Planes,
        axes: usize,
        job: &Job,
    ) -> Result<Planes> {
        let mut planes = Planes::zeros_within(job, "the numbers of the clusters", like.size(), axes + 1)?;
        parallel::for_each(planes.bands_mut(PART).into_iter().enumerate(), |(part, mut band)| {
            let mut from_mean = vec![0.0; self.functions];
            for i in 0..band[0].len() {
                let texel = part * PART + i;
                band[0][i] = labels[texel] as f32;
                let cluster = &clusters[labels[texel] as usize];
                cluster.subtract_mean(self.point(texel), &mut from_mean);
                band[1..]
                    .iter_mut()
                    .enumerate()
                    .for_each(|(j, plane)| plane[i] = cluster.along(j, &from_mean) as f32);
            }
        });
        Ok(planes)
    }
}

/// The texel at a share of the sum of all squares.
fn drawn(squares: &[f64], share: f64) -> usize {
    let mut left = share * squares.iter().sum::<f64>();
    let reached = squares.iter().position(|square| {
        left -= square;
        left < 0.0
    });
    reached.unwrap_or(squares.len() - 1)
}
