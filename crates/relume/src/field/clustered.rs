//! Fields whose texels belong to clusters: a texel holds the number of its cluster and a few numbers, and its
//! function is the mean of the cluster plus a combination of the axes of the cluster ("local PCA": N. Kambhatla,
//! T. K. Leen, "Dimension Reduction by Local Principal Component Analysis", Neural Computation 9, 1997; of textures
//! of light and view: G. Müller, J. Meseth, R. Klein, "Compression and Real-Time Rendering of Measured BTFs Using
//! Local PCA", VMV 2003).
//!
//! Means and axes are coefficients in one common basis. So a clustered field, which is not linear in the numbers of
//! a texel, has an exact linear form ([`ClusteredField::expanded`]) with as many planes as the common basis has
//! functions: its planes are the index planes of the texture, and every stage takes it.

use super::{Basis, PlaneLayout, ReflectanceField};
use crate::direction::Directions;
use crate::error::{Error, Result};
use crate::job::Job;
use crate::parallel;
use crate::planes::Planes;
use crate::size::Size;
use crate::space::Space;

/// The most clusters: their numbers are exact in 16-bit floats.
pub const MOST_CLUSTERS: usize = 2048;

/// Texels expanded by one task.
const PART: usize = 1 << 12;

/// The means and axes of clusters, as coefficients of the functions of a common basis.
#[derive(Debug, Clone, PartialEq)]
pub struct ClusterSpaces {
    functions: usize,
    axes: usize,
    /// For each cluster the mean, then its axes.
    coefficients: Vec<f32>,
}

impl ClusterSpaces {
    /// Spaces of `axes` axes over `functions` functions: for each cluster the mean, then each axis.
    ///
    /// # Errors
    /// No cluster or more than [`MOST_CLUSTERS`], more axes than functions, numbers that do not fit these, and those
    /// that are not finite.
    pub fn new(functions: usize, axes: usize, coefficients: Vec<f32>) -> Result<Self> {
        let length = functions.saturating_mul(axes.saturating_add(1));
        let clusters = coefficients.len().checked_div(length).unwrap_or(0);
        let fits = clusters.checked_mul(length) == Some(coefficients.len());
        if !fits || !(1..=MOST_CLUSTERS).contains(&clusters) || axes == 0 || axes > functions {
            return Err(Error::invalid(format!(
                "clusters of {axes} axes over {functions} functions cannot have {} coefficients: expected {length} for \
                 each of 1 to {MOST_CLUSTERS} clusters, and 1 to {functions} axes",
                coefficients.len()
            )));
        }
        if coefficients.iter().any(|value| !value.is_finite()) {
            return Err(Error::invalid("the means and axes of clusters are finite"));
        }
        Ok(Self { functions, axes, coefficients })
    }

    /// The number of clusters.
    pub fn clusters(&self) -> usize {
        self.coefficients.len() / self.stride()
    }

    /// The number of axes of a cluster, which is that of the numbers of a texel beside its cluster.
    pub fn axes(&self) -> usize {
        self.axes
    }

    /// The number of functions of the common basis.
    pub fn functions(&self) -> usize {
        self.functions
    }

    /// Means and axes: for each cluster the mean, then each axis.
    pub fn coefficients(&self) -> &[f32] {
        &self.coefficients
    }

    fn stride(&self) -> usize {
        self.functions * (self.axes + 1)
    }

    /// The mean and the axes of a cluster.
    fn of(&self, cluster: usize) -> (&[f32], &[f32]) {
        self.coefficients[cluster * self.stride()..][..self.stride()].split_at(self.functions)
    }
}

/// A texture of functions in clusters.
///
/// Plane 0 holds the cluster of each texel, the others its numbers; so a source map rearranges them as it does those of
/// any field.
#[derive(Debug, Clone, PartialEq)]
pub struct ClusteredField {
    basis: Basis,
    layout: PlaneLayout,
    space: Space,
    spaces: ClusterSpaces,
    planes: Planes,
}

impl ClusteredField {
    /// A field from its parts.
    ///
    /// # Errors
    /// Spaces over other functions than those of the basis, a layout with several planes for a function, another number
    /// of planes than 1 for the cluster and 1 for each axis, and clusters that do not exist.
    pub fn new(
        basis: Basis,
        layout: PlaneLayout,
        space: Space,
        spaces: ClusterSpaces,
        planes: Planes,
    ) -> Result<Self> {
        if !layout.takes(basis.channels()) || layout.planes(basis.len()) != spaces.functions {
            return Err(Error::invalid(format!(
                "the clusters are of {} planes and a {} field of the {} functions of the basis {} has {}",
                spaces.functions,
                layout.name(),
                basis.len(),
                basis.name(),
                layout.planes(basis.len())
            )));
        }
        if planes.count() != spaces.axes + 1 || planes.size().texels() == 0 {
            return Err(Error::invalid(format!(
                "a texture in clusters of {} axes has {} planes, found {} of {} texels",
                spaces.axes,
                spaces.axes + 1,
                planes.count(),
                planes.size()
            )));
        }
        let exists =
            |cluster: f32| cluster.fract() == 0.0 && (0.0..spaces.clusters() as f32).contains(&cluster);
        if let Some(texel) = planes.plane(0).iter().position(|cluster| !exists(*cluster)) {
            let width = planes.size().width;
            return Err(Error::invalid(format!(
                "texel ({}, {}) belongs to the cluster {}: expected a whole number below {}",
                texel % width,
                texel / width,
                planes.plane(0)[texel],
                spaces.clusters()
            )));
        }
        Ok(Self { basis, layout, space, spaces, planes })
    }

    /// The functions of which means and axes are combinations.
    pub fn basis(&self) -> &Basis {
        &self.basis
    }

    /// The layout of the planes of [`ClusteredField::expanded`].
    pub fn layout(&self) -> &PlaneLayout {
        &self.layout
    }

    /// The encoding of the function values.
    pub fn space(&self) -> Space {
        self.space
    }

    /// The means and axes.
    pub fn spaces(&self) -> &ClusterSpaces {
        &self.spaces
    }

    /// The cluster of each texel, then its numbers.
    pub fn planes(&self) -> &Planes {
        &self.planes
    }

    /// Width and height.
    pub fn size(&self) -> Size {
        self.planes.size()
    }

    /// The same texture with the numbers of texels rounded to multiples of a step.
    #[must_use]
    pub fn rounded(mut self, step: f32) -> Self {
        (1..self.planes.count()).for_each(|k| self.planes.round(k, step));
        self
    }

    /// The channels of one texel for a light and a view, in the space of the field: the mean of its cluster plus its
    /// numbers times the axes. The slow truth of [`ClusteredField::expanded`].
    pub fn values(&self, x: usize, y: usize, directions: impl Into<Directions>) -> Vec<f32> {
        let weights = self.basis.weights(directions);
        let n = self.basis.len();
        let (mean, axes) = self.spaces.of(self.planes.at(0, x, y) as usize);
        let of_row = |row: &[f32], channel: usize| -> f64 {
            let row = &row[self.layout.function_plane(channel, n)..][..n];
            let terms = self.layout.weights(channel, n, &weights).iter().zip(row);
            terms.map(|(weight, value)| weight * f64::from(*value)).sum()
        };
        let value = |channel: usize| {
            let axes = axes.chunks_exact(self.spaces.functions).enumerate();
            let along = axes.map(|(j, axis)| f64::from(self.planes.at(j + 1, x, y)) * of_row(axis, channel));
            (of_row(mean, channel) + along.sum::<f64>()) as f32
        };
        (0..self.layout.channels()).map(value).collect()
    }

    /// The same texture as a field of the common basis.
    ///
    /// # Errors
    /// Limits exceeded, and a cancelled job.
    pub fn expanded(&self, job: &Job) -> Result<ReflectanceField> {
        let mut planes =
            Planes::zeros_within(job, "the texture without clusters", self.size(), self.spaces.functions)?;
        parallel::try_for_each(planes.bands_mut(PART).into_iter().enumerate(), |(part, mut band)| {
            job.proceed()?;
            for i in 0..band[0].len() {
                let texel = part * PART + i;
                let (mean, axes) = self.spaces.of(self.planes.plane(0)[texel] as usize);
                for (m, plane) in band.iter_mut().enumerate() {
                    let along = axes[m..].iter().step_by(self.spaces.functions).enumerate();
                    plane[i] = along.fold(mean[m], |sum, (j, v)| sum + v * self.planes.plane(j + 1)[texel]);
                }
            }
            Ok(())
        })?;
        ReflectanceField::new(self.basis.clone(), self.layout.clone(), self.space, planes)
    }
}

/// A small clustered field of a learned basis, for tests.
#[cfg(test)]
pub(crate) fn clustered_example() -> ClusteredField {
    use super::basis::learned_of_channels_example;
    use crate::numeric::random::{Purpose, Stream};
    let (functions, axes, clusters) = (4, 2, 3);
    let basis = Basis::Learned(learned_of_channels_example(3, 9, 5, functions));
    let mut stream = Stream::new(8, Purpose::Sample, [0]);
    let mut numbers = |n: usize| (0..n).map(|_| stream.unit() as f32 - 0.4).collect::<Vec<f32>>();
    let spaces = ClusterSpaces::new(functions, axes, numbers(clusters * functions * (axes + 1))).unwrap();
    let size = Size::new(5, 3);
    let labels = (0..size.texels()).map(|i| (i * 7 % clusters) as f32);
    let data = labels.chain(numbers(axes * size.texels())).collect();
    let planes = Planes::from_vec(size, axes + 1, data).unwrap();
    let layout = PlaneLayout::shared(["R", "G", "B"]).unwrap();
    ClusteredField::new(basis, layout, Space::Srgb, spaces, planes).unwrap()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::direction::Direction;

    #[test]
    fn the_expanded_field_is_the_same_texture() {
        let clustered = clustered_example();
        let expanded = clustered.expanded(&Job::default()).unwrap();
        assert_eq!((expanded.size(), expanded.space()), (clustered.size(), Space::Srgb));
        let directions =
            Directions { light: Direction::from_angles(0.6, 1.0), view: Direction::from_angles(0.9, -2.0) };
        for (x, y) in (0..3).flat_map(|y| (0..5).map(move |x| (x, y))) {
            let (a, b) = (clustered.values(x, y, directions), expanded.values(x, y, directions));
            assert!(a.iter().zip(&b).all(|(a, b)| (a - b).abs() < 1e-5), "({x}, {y}): {a:?} and {b:?}");
        }
    }

    #[test]
    fn clusters_that_do_not_exist_are_refused() {
        let good = clustered_example();
        let with = |change: &dyn Fn(&mut Planes)| {
            let mut planes = good.planes().clone();
            change(&mut planes);
            let (basis, layout) = (good.basis().clone(), good.layout().clone());
            ClusteredField::new(basis, layout, good.space(), good.spaces().clone(), planes)
        };
        for label in [3.0, -1.0, 0.5, f32::NAN] {
            let error = with(&|planes| planes.plane_mut(0)[7] = label).unwrap_err().to_string();
            assert!(error.contains("texel (2, 1)") && error.contains("below 3"), "{error}");
        }
        assert!(with(&|_| {}).is_ok());
        let fewer = Planes::zeros(good.size(), 2);
        let (basis, layout) = (good.basis().clone(), good.layout().clone());
        let error = ClusteredField::new(basis, layout.clone(), good.space(), good.spaces().clone(), fewer);
        assert!(error.unwrap_err().to_string().contains("has 3 planes, found 2"));
        let other = ClusteredField::new(
            Basis::Ptm,
            PlaneLayout::LUMINANCE,
            good.space(),
            good.spaces().clone(),
            good.planes().clone(),
        );
        assert!(other.unwrap_err().to_string().contains("are of 4 planes"));
    }

    #[test]
    fn spaces_that_do_not_fit_are_refused() {
        for (functions, axes, count) in [(4, 2, 0), (4, 2, 13), (4, 0, 8), (4, 5, 24), (0, 1, 4)] {
            assert!(
                ClusterSpaces::new(functions, axes, vec![0.0; count]).is_err(),
                "{functions} {axes} {count}"
            );
        }
        assert!(ClusterSpaces::new(2, 1, vec![f32::INFINITY; 4]).is_err());
        assert_eq!(ClusterSpaces::new(2, 1, vec![0.5; 12]).unwrap().clusters(), 3);
    }
}
