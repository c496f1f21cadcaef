//! Textures of light and view as random fields of clusters of photographs: the scheme of M. Haindl, J. Filip, M. Arnold, "BTF
//! Image Space Utmost Compression and Modelling Method", ICPR 2004.
//!
//! ```text
//! photographs --CIE Lab histograms--> principal components --k-means--> clusters
//! cluster --photograph nearest to its mean--> random field of three planes      (all under the same noise)
//! pair of light and view --> cluster, and how many times as bright               (a table; barycentric between pairs)
//! photographs from above --stereo, integration--> heights --> random field, or tiles where they repeat
//! ```
//!
//! | file | content |
//! |---|---|
//! | `features` | distributions of colours, in principal components |
//! | `range` | the range map |

mod features;
mod range;

pub use range::RangeReport;

use serde::Serialize;

use crate::direction::Directions;
use crate::error::{Error, Result};
use crate::field::{Learned, PackedFunctions};
use crate::fit::learned::pair_weights;
use crate::job::Job;
use crate::numeric::between::PairGrid;
use crate::numeric::decibel::psnr_db;
use crate::numeric::k_means::k_means;
use crate::numeric::random::{Purpose, Stream};
use crate::parallel;
use crate::random_field::{
    FieldModel, LevelReport, MOST_IMAGE_CLUSTERS, ModelOptions, PhotographClusters, estimate,
};
use crate::raster::{LoadRaster, RasterSequence};
use crate::space::Space;
use crate::workflow::model::ModelRequest;
use features::{PhotographFeatures, components};

/// Photographs that are read at a time for each thread.
const AT_A_TIME: usize = 4;

/// What a step of brightness in the table stands for, and the most steps.
const STEP: f64 = 1.0 / 32.0;
const MOST_STEPS: f64 = 4095.0;

/// Pictures darker than this have no ratio of brightness.
const DARKEST: f64 = 1e-3;

/// The request for a model of clusters.
#[derive(Debug, Clone, PartialEq)]
pub struct ImageClusterRequest {
    /// Clusters of photographs; fewer where fewer differ.
    pub clusters: usize,
    /// Options of the random fields of their pictures.
    pub options: ModelOptions,
    /// Whether heights are found and modelled, and how.
    pub range: Option<ModelRequest>,
    /// The seed of the clusters.
    pub seed: u64,
}

impl Default for ImageClusterRequest {
    fn default() -> Self {
        Self { clusters: 20, options: ModelOptions::default(), range: Some(ModelRequest::default()), seed: 0 }
    }
}

impl ImageClusterRequest {
    /// Checks the request before a photograph is read.
    ///
    /// # Errors
    /// No cluster or too many, and options of random fields without meaning.
    pub fn validate(&self) -> Result<()> {
        if !(1..=MOST_IMAGE_CLUSTERS).contains(&self.clusters) {
            return Err(Error::usage(format!(
                "photographs are put into 1 to {MOST_IMAGE_CLUSTERS} clusters, not {}",
                self.clusters
            )));
        }
        self.options.validate()
    }
}

/// A model of clusters of photographs, and how it was made.
#[derive(Debug, Clone)]
pub struct ImageClusterModel {
    /// The model.
    pub model: FieldModel,
    /// How it was made.
    pub report: ImageClusterReport,
    /// How the levels of each picture were chosen.
    pub levels: Vec<Vec<LevelReport>>,
}

/// How a model of clusters was made.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct ImageClusterReport {
    /// Photographs in each cluster.
    pub photographs: Vec<usize>,
    /// The photograph that is the picture of each.
    pub pictures: Vec<String>,
    /// Principal components of the distributions of colours.
    pub components: usize,
    /// The root mean square error of encoded values with the photographs of the clusters themselves in the place of those that
    /// are made: what the table loses.
    pub table_rmse: f64,
    /// The same in decibels, for a peak of 1; infinite (in JSON: null) for an error of zero.
    pub table_psnr_db: f64,
    /// The range map, if there is one.
    pub range: Option<RangeReport>,
}

/// Groups photographs, models the picture of each cluster and the range map. `pairs` names each photograph and its
/// directions, `load(i)` reads the i-th, perhaps more than once.
///
/// # Errors
/// A request without meaning; pairs that are not all of some lights with all of some views; photographs that are too small
/// to be modelled or cannot be read, and limits exceeded.
pub fn model_image_clusters(
    pairs: &[(String, Directions)],
    load: &LoadRaster,
    request: &ImageClusterRequest,
    job: &Job,
) -> Result<ImageClusterModel> {
    request.validate()?;
    if pairs.is_empty() {
        return Err(Error::usage("a model needs at least one photograph, found none"));
    }
    if PairGrid::new(&pairs.iter().map(|(_, pair)| *pair).collect::<Vec<_>>()).is_none() {
        return Err(Error::unsupported(format!(
            "the table of clusters is of all of some lights with all of some views, and the {} photographs are not: add those \
             that are missing",
            pairs.len()
        )));
    }
    let photographs = RasterSequence::open(load)?;
    let (size, channels) = (photographs.size(), photographs.channels());
    let load = |i: usize| alike(&photographs, i, &pairs[i].0);
    let _kept = job
        .hold("what is kept of the photographs", PhotographFeatures::bytes(channels) * pairs.len() as u64)?;
    let features = all_features(pairs.len(), &load, job)?;
    let grouped = Grouped::new(&features, request);
    let table = grouped.table(&features, pairs)?;
    let options = ModelOptions { color: (channels == 3).then_some(0), fewer: false, ..request.options };
    job.start("modelling the pictures of clusters", grouped.pictures.len() as u64);
    let (mut models, mut levels) = (Vec::new(), Vec::new());
    for &picture in &grouped.pictures {
        let planes = load(picture)?.to_picture(Space::Srgb).planes;
        let (model, level) = estimate(&planes, &options, job)?;
        models.push(model);
        levels.push(level);
        job.advance(1)?;
    }
    let range = match &request.range {
        Some(request) => range::range_model(pairs, &load, request, job)?,
        None => None,
    };
    let mean_square = grouped.mean_square(&features);
    let report = ImageClusterReport {
        photographs: grouped.sizes(),
        pictures: grouped.pictures.iter().map(|&i| pairs[i].0.clone()).collect(),
        components: grouped.components,
        table_rmse: mean_square.sqrt(),
        table_psnr_db: psnr_db(mean_square),
        range: range.as_ref().map(|range| range.report.clone()),
    };
    let clusters = PhotographClusters { models, range: range.map(|range| Box::new(range.model)) };
    let model = FieldModel::of_clusters(table, Space::Srgb, clusters, size)?;
    Ok(ImageClusterModel { model, report, levels })
}

/// A photograph that is like the first.
fn alike(photographs: &RasterSequence<'_>, i: usize, name: &str) -> Result<crate::raster::Raster> {
    let photograph = photographs.read(i)?;
    let (size, channels) = (photographs.size(), photographs.channels());
    if (photograph.size(), photograph.channels()) == (size, channels) {
        return Ok(photograph);
    }
    Err(Error::invalid(format!(
        "the photograph {name} is {} with {} channels, the first {size} with {channels}: all must be alike",
        photograph.size(),
        photograph.channels()
    )))
}

/// The features of all photographs, a few of which are in memory at a time.
fn all_features(count: usize, load: &LoadRaster, job: &Job) -> Result<Vec<PhotographFeatures>> {
    job.start("grouping photographs", count as u64);
    let batch = AT_A_TIME * rayon::current_num_threads().max(1);
    let mut features = Vec::with_capacity(count);
    for first in (0..count).step_by(batch) {
        let of = |i: usize| job.proceed().and_then(|()| Ok(PhotographFeatures::of(&load(i)?)));
        features.extend(parallel::try_map(first..(first + batch).min(count), of)?);
        job.advance((count - first).min(batch) as u64)?;
    }
    Ok(features)
}

/// The clusters of photographs.
struct Grouped {
    labels: Vec<usize>,
    /// The photograph nearest to the mean of each.
    pictures: Vec<usize>,
    components: usize,
}

impl Grouped {
    fn new(features: &[PhotographFeatures], request: &ImageClusterRequest) -> Self {
        let (points, n) = components(features);
        let point = |i: usize| &points[i * n..][..n];
        let mut stream = Stream::new(request.seed, Purpose::PhotographClusters, []);
        let found = k_means(&points, n, request.clusters, &mut stream);
        let clusters = found.iter().max().map_or(0, |most| most + 1);
        let means: Vec<Vec<f64>> = (0..clusters).map(|k| mean_of(&found, k, n, &point)).collect();
        // A photograph that is the same everywhere has no random field: another of the cluster stands for it, or that of
        // the nearest cluster.
        let varying: Vec<usize> = (0..features.len()).filter(|&i| features[i].varies).collect();
        let nearest_to = |k: usize| {
            let own = varying.iter().filter(|i| found[**i] == k).copied();
            own.min_by(|&a, &b| apart(point(a), &means[k]).total_cmp(&apart(point(b), &means[k])))
        };
        let chosen: Vec<(usize, usize)> =
            (0..clusters).filter_map(|k| nearest_to(k).map(|picture| (k, picture))).collect();
        let place = |i: usize| {
            let own = chosen.iter().position(|(k, _)| *k == found[i]);
            let distance = |j: &usize| apart(point(i), &means[chosen[*j].0]);
            let nearest = || (0..chosen.len()).min_by(|a, b| distance(a).total_cmp(&distance(b)));
            own.or_else(nearest).unwrap_or(0)
        };
        let labels = (0..features.len()).map(place).collect();
        // Where no photograph varies, the first says so.
        let pictures = if chosen.is_empty() { vec![0] } else { chosen.iter().map(|(_, i)| *i).collect() };
        Self { labels, pictures, components: n }
    }

    fn sizes(&self) -> Vec<usize> {
        let mut sizes = vec![0; self.pictures.len()];
        self.labels.iter().for_each(|label| sizes[*label] += 1);
        sizes
    }

    /// How many times as bright as the picture of its cluster a photograph is, in whole steps.
    fn steps(&self, i: usize, features: &[PhotographFeatures]) -> f64 {
        let picture = features[self.pictures[self.labels[i]]].brightness.max(DARKEST);
        (features[i].brightness / picture / STEP).round().clamp(1.0, MOST_STEPS)
    }

    /// The table: a function for each cluster, that is zero at the pairs of others.
    fn table(
        &self,
        features: &[PhotographFeatures],
        pairs: &[(String, Directions)],
    ) -> Result<PackedFunctions> {
        let directions: Vec<Directions> = pairs.iter().map(|(_, pair)| *pair).collect();
        let (weights, n) = (pair_weights(&directions), self.pictures.len());
        let mut norms = vec![0.0; n];
        for (i, weight) in weights.iter().enumerate() {
            norms[self.labels[i]] += weight * self.steps(i, features).powi(2);
        }
        let mut values = vec![0.0; n * pairs.len()];
        for i in 0..pairs.len() {
            let own = self.labels[i];
            values[i * n + own] = (self.steps(i, features) / norms[own].sqrt()) as f32;
        }
        let learned = Learned::new(directions, weights, values)?;
        let steps: Vec<f32> = norms.iter().map(|norm| (1.0 / norm.sqrt()) as f32).collect();
        let packed = PackedFunctions::new(&learned, &steps)?;
        Ok(PackedFunctions { steps: vec![STEP as f32; n], ..packed })
    }

    /// The mean square error of the photographs as pictures of their clusters, on the texels kept.
    fn mean_square(&self, features: &[PhotographFeatures]) -> f64 {
        let of = |(i, feature): (usize, &PhotographFeatures)| {
            let picture = &features[self.pictures[self.labels[i]]].texels;
            let gain = self.steps(i, features) * STEP;
            let pairs = feature.texels.iter().zip(picture);
            let square = |(a, b): (&u8, &u8)| (f64::from(*a) - (gain * f64::from(*b)).min(255.0)).powi(2);
            pairs.map(square).sum::<f64>()
        };
        let sum: f64 = features.iter().enumerate().map(of).sum();
        let values: usize = features.iter().map(|feature| feature.texels.len()).sum();
        sum / (values.max(1) as f64 * 255.0 * 255.0)
    }
}

/// The mean of the points of a cluster.
fn mean_of<'a>(labels: &[usize], k: usize, n: usize, point: &impl Fn(usize) -> &'a [f64]) -> Vec<f64> {
    let own: Vec<usize> = (0..labels.len()).filter(|i| labels[*i] == k).collect();
    (0..n).map(|j| own.iter().map(|i| point(*i)[j]).sum::<f64>() / own.len().max(1) as f64).collect()
}

/// The squared distance of two points.
fn apart(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| (a - b).powi(2)).sum()
}

#[cfg(test)]
mod tests;
