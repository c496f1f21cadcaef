//! The functions of a texture, projected on those of a hemisphere.
//!
//! Where the values of a texture are linear light, what a texel reflects of the environment is a sum over its
//! coefficients: 1/pi sum_k c_k sum_p A_kp m_p, with A_kp = ∫ b_k H_p dl. Functions of light alone have one matrix A;
//! those of light and view have one for each view: for measured views, between which the functions themselves are
//! interpolated, without an error; for functions without such views for those of a grid, and nearly. Encoded values
//! are decoded for each of some lamps.

use super::super::vector::Vec3;
use super::grid::{Covered, OctahedralGrid};
use super::hemisphere::HemisphereSpace;
use super::lamps::{FrameLamps, LampKind};
use crate::direction::{Direction, Directions};
use crate::error::Result;
use crate::field::Basis;
use crate::job::{Held, Job};
use crate::numeric::between::Triangulation;
use crate::parallel;
use crate::space::Space;

/// The views of functions without measured views of their own: about four degrees apart.
const VIEWS: OctahedralGrid = OctahedralGrid::new(40, Covered::UpperHemisphere);
/// Rings of the rule that projects functions, beyond their degree.
const BEYOND: usize = 4;

/// The views for which a table has a matrix.
#[derive(Debug)]
enum TabulatedViews {
    /// One, for functions of light alone.
    Any,
    /// Those in whose triangles the functions are interpolated.
    Measured(Triangulation),
    Grid(OctahedralGrid),
}

impl TabulatedViews {
    fn of(basis: &Basis) -> Self {
        match basis.measured_grid() {
            _ if !basis.depends_on_view() => Self::Any,
            Some(grid) => Self::Measured(grid.views().clone()),
            None => Self::Grid(VIEWS),
        }
    }

    fn len(&self) -> usize {
        match self {
            Self::Any => 1,
            Self::Measured(views) => views.points().len(),
            Self::Grid(grid) => grid.len(),
        }
    }

    fn direction(&self, index: usize) -> Direction {
        match self {
            Self::Any => Direction::ZENITH,
            Self::Measured(views) => views.direction(index),
            Self::Grid(grid) => {
                let Vec3 { x, y, .. } = grid.direction(index);
                Direction::from_disk(x, y)
            }
        }
    }

    /// The views around one and their shares.
    fn around(&self, view: Direction) -> [(usize, f64); 4] {
        match self {
            Self::Any => [(0, 1.0), (0, 0.0), (0, 0.0), (0, 0.0)],
            Self::Measured(views) => {
                let [a, b, c] = views.shares(view);
                [a, b, c, (a.0, 0.0)]
            }
            Self::Grid(grid) => grid.around(view.into()),
        }
    }
}

/// A matrix for each view, or one for all.
#[derive(Debug)]
pub(super) struct ViewTable {
    views: TabulatedViews,
    /// Numbers of a matrix.
    length: usize,
    data: Vec<f32>,
    _held: Held,
}

impl ViewTable {
    /// From the matrix of each view.
    fn new(
        basis: &Basis,
        length: usize,
        job: &Job,
        matrix: impl Fn(Direction, &mut [f32]) + Sync,
    ) -> Result<Self> {
        let views = TabulatedViews::of(basis);
        let numbers = (views.len() * length) as u64;
        let held = job.hold("the texture's functions under the environment", 4 * numbers)?;
        let mut data = vec![0.0; views.len() * length];
        parallel::try_for_each(data.chunks_exact_mut(length).enumerate(), |(index, out)| {
            matrix(views.direction(index), out);
            job.proceed()
        })?;
        Ok(Self { views, length, data, _held: held })
    }

    /// The matrix of a view; `room` holds it where it is interpolated.
    pub fn of<'a>(&'a self, view: Direction, room: &'a mut Vec<f32>) -> &'a [f32] {
        if matches!(self.views, TabulatedViews::Any) {
            return &self.data;
        }
        room.clear();
        room.resize(self.length, 0.0);
        for (index, weight) in self.views.around(view).into_iter().filter(|(_, weight)| *weight != 0.0) {
            let from = &self.data[index * self.length..][..self.length];
            room.iter_mut().zip(from).for_each(|(out, v)| *out += weight as f32 * v);
        }
        room
    }
}

/// For each view the matrix 1/pi ∫ b_k H_p dl, a row for each function (and channel) of the basis.
pub(super) fn projected(basis: &Basis, space: &HemisphereSpace, job: &Job) -> Result<ViewTable> {
    let lamps = FrameLamps::of(basis, Space::Linear, space);
    if lamps.kind == LampKind::Measured {
        return of_measured(basis, &lamps, space.len(), job);
    }
    let rule = space.rule(space.degree() + BEYOND);
    let (n, count) = (basis.channels() * basis.len(), space.len());
    ViewTable::new(basis, n * count, job, |view, out| {
        let (mut weights, mut values) = (vec![0.0; n], vec![0.0; count]);
        let mut sums = vec![0.0; n * count];
        for &(light, share) in &rule {
            basis.weights_into(Directions { light, view }, &mut weights);
            space.values_into(light.to_array(), &mut values);
            for (row, weight) in sums.chunks_exact_mut(count).zip(&weights) {
                let factor = share * weight / std::f64::consts::PI;
                row.iter_mut().zip(&values).for_each(|(sum, v)| *sum += factor * v);
            }
        }
        out.iter_mut().zip(sums).for_each(|(out, sum)| *out = sum as f32);
    })
}

/// As [`projected`]: the functions are sums over measured lights, and so are their projections.
fn of_measured(basis: &Basis, lamps: &FrameLamps, count: usize, job: &Job) -> Result<ViewTable> {
    let n = basis.channels() * basis.len();
    ViewTable::new(basis, n * count, job, |view, out| {
        let (mut weights, mut sums) = (vec![0.0; n], vec![0.0; n * count]);
        for (light, factors) in lamps.directions.iter().zip(lamps.factors.chunks_exact(count)) {
            basis.weights_into(Directions { light: *light, view }, &mut weights);
            for (row, weight) in sums.chunks_exact_mut(count).zip(&weights) {
                row.iter_mut().zip(factors).for_each(|(sum, f)| *sum += weight * f64::from(*f));
            }
        }
        out.iter_mut().zip(sums).for_each(|(out, sum)| *out = sum as f32);
    })
}

/// Functions for lamps, and the light of these.
#[derive(Debug)]
pub(super) struct NodeResponse {
    /// The functions of the basis for each lamp.
    pub functions: ViewTable,
    /// For each lamp its factors of the functions of the hemisphere.
    pub light: Vec<f32>,
}

/// For encoded values, whose decoding is not linear.
pub(super) fn at_nodes(basis: &Basis, space: &HemisphereSpace, job: &Job) -> Result<NodeResponse> {
    let FrameLamps { directions, factors, .. } = FrameLamps::of(basis, Space::Srgb, space);
    let n = basis.channels() * basis.len();
    let functions = ViewTable::new(basis, n * directions.len(), job, |view, out| {
        let mut weights = vec![0.0; n];
        for (light, out) in directions.iter().zip(out.chunks_exact_mut(n)) {
            basis.weights_into(Directions { light: *light, view }, &mut weights);
            out.iter_mut().zip(&weights).for_each(|(out, w)| *out = *w as f32);
        }
    })?;
    Ok(NodeResponse { functions, light: factors })
}

/// 1/pi ∫ (n.l) H_p dl: the response of a matt white surface.
pub(super) fn matt(space: &HemisphereSpace) -> Vec<f32> {
    let mut values = vec![0.0; space.len()];
    let mut sums = vec![0.0; space.len()];
    for (light, share) in space.rule(space.degree() + BEYOND) {
        space.values_into(light.to_array(), &mut values);
        let factor = share * light.z() / std::f64::consts::PI;
        sums.iter_mut().zip(&values).for_each(|(sum, v)| *sum += factor * v);
    }
    sums.into_iter().map(|sum| sum as f32).collect()
}
