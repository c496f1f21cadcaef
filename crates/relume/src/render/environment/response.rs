//! The functions of a texture, projected on those of a hemisphere.
//!
//! Where the values of a texture are linear light, what a texel reflects of the environment is a sum over its
//! coefficients: 1/pi sum_k c_k sum_p A_kp m_p, with A_kp = ∫ b_k H_p dl. Functions of light alone have one matrix A;
//! those of light and view have one for each view, interpolated between those of a grid of views. Encoded values are
//! decoded at the nodes of a rule, where the light of the hemisphere is sum_p m_p H_p.

use rayon::prelude::*;

use super::super::vector::Vec3;
use super::grid::{Covered, OctahedralGrid};
use super::hemisphere::HemisphereSpace;
use crate::direction::{Direction, Directions};
use crate::error::Result;
use crate::field::Basis;
use crate::job::{Held, Job};

/// The views of functions of light and view: about seven degrees apart.
const VIEWS: OctahedralGrid = OctahedralGrid::new(20, Covered::UpperHemisphere);
/// Rings of the rule that projects functions, beyond their degree.
const BEYOND: usize = 4;

/// A matrix for each view, or one for all.
#[derive(Debug)]
pub(super) struct ViewTable {
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
        let count = if basis.depends_on_view() { VIEWS.len() } else { 1 };
        let held = job.hold("the texture's functions under the environment", 4 * (count * length) as u64)?;
        let mut data = vec![0.0; count * length];
        if !basis.depends_on_view() {
            matrix(Direction::ZENITH, &mut data);
            return Ok(Self { length, data, _held: held });
        }
        data.par_chunks_exact_mut(length).enumerate().try_for_each(|(vertex, out)| {
            let Vec3 { x, y, .. } = VIEWS.direction(vertex);
            matrix(Direction::from_disk(x, y), out);
            job.proceed()
        })?;
        Ok(Self { length, data, _held: held })
    }

    /// The matrix of a view; `room` holds it where it is interpolated.
    pub fn of<'a>(&'a self, view: Direction, room: &'a mut Vec<f32>) -> &'a [f32] {
        if self.data.len() == self.length {
            return &self.data;
        }
        room.clear();
        room.resize(self.length, 0.0);
        for (vertex, weight) in VIEWS.around(view.into()) {
            let from = &self.data[vertex * self.length..][..self.length];
            room.iter_mut().zip(from).for_each(|(out, v)| *out += weight as f32 * v);
        }
        room
    }
}

/// For each view the matrix 1/pi ∫ b_k H_p dl, a row for each function (and channel) of the basis.
pub(super) fn projected(basis: &Basis, space: &HemisphereSpace, job: &Job) -> Result<ViewTable> {
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

/// Functions at the nodes of a rule, and the light there.
#[derive(Debug)]
pub(super) struct NodeResponse {
    /// The functions of the basis at each node.
    pub functions: ViewTable,
    /// For each node, 1/pi times its weight times all functions of the hemisphere.
    pub light: Vec<f32>,
}

/// For encoded values, whose decoding is not linear.
pub(super) fn at_nodes(basis: &Basis, space: &HemisphereSpace, job: &Job) -> Result<NodeResponse> {
    let rule = space.rule(space.degree() + 1);
    let n = basis.channels() * basis.len();
    let functions = ViewTable::new(basis, n * rule.len(), job, |view, out| {
        let mut weights = vec![0.0; n];
        for ((light, _), out) in rule.iter().zip(out.chunks_exact_mut(n)) {
            basis.weights_into(Directions { light: *light, view }, &mut weights);
            out.iter_mut().zip(&weights).for_each(|(out, w)| *out = *w as f32);
        }
    })?;
    let mut light = Vec::with_capacity(rule.len() * space.len());
    let mut values = vec![0.0; space.len()];
    for (direction, share) in &rule {
        space.values_into(direction.to_array(), &mut values);
        light.extend(values.iter().map(|v| (share * v / std::f64::consts::PI) as f32));
    }
    Ok(NodeResponse { functions, light })
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
