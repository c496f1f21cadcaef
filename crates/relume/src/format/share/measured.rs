//! Functions known for all of some lights with all of some views, as readers find them on a graphics card.
//!
//! Such functions are linear in the triangles of the lights and of the views
//! ([`numeric::between`](crate::numeric::between)), with an edge along each side of a triangle that no table over
//! directions follows. So readers get the values as measured, and the triangle around a direction from a map: the
//! octahedral map of [`table`](super::table), whose nodes hold the indices of three directions. The nearest node gives the
//! triangle, and the coordinates in it are computed for the direction itself. Beyond the border a node holds an edge, as its two ends and
//! the first again. Near a side the nearest node may lie in the next triangle: coordinates below zero are then set to zero.

use half::f16;

use super::header::ShareMeasured;
use super::table::{LANES, basis_error, between, node};
use crate::direction::{Direction, Directions};
use crate::error::Result;
use crate::field::Basis;
use crate::job::Job;
use crate::numeric::between::{PairGrid, Triangulation, barycentric, projected};

/// Nodes along a side of a map of triangles.
const MAP_NODES: usize = 257;

/// Values at measured directions, and the triangles around all directions.
#[derive(Debug, Clone, PartialEq)]
pub struct MeasuredTable {
    lights: TriangleMap,
    views: TriangleMap,
    functions: usize,
    channels: usize,
    /// Layer after layer: a row for each view, a texel of four values for each light.
    texels: Vec<f16>,
}

/// Directions in the projection, and the three around each node.
#[derive(Debug, Clone, PartialEq)]
struct TriangleMap {
    points: Vec<[f64; 2]>,
    corners: Vec<[u16; 3]>,
}

impl MeasuredTable {
    /// The table of a basis; `None` for one that was not measured on a grid.
    ///
    /// # Errors
    /// When memory is short, and a cancelled job.
    pub fn new(basis: &Basis, job: &Job) -> Result<Option<Self>> {
        let Basis::Learned(learned) = basis else { return Ok(None) };
        let Some(grid) = learned.grid() else { return Ok(None) };
        let (lights, views) = (grid.lights().points().len(), grid.views().points().len());
        if lights.max(views) > usize::from(u16::MAX) {
            return Ok(None);
        }
        let (functions, channels) = (learned.functions(), learned.channels());
        let layers = channels * functions.div_ceil(LANES);
        let bytes = 2 * LANES * layers * lights * views + 12 * MAP_NODES * MAP_NODES;
        job.check_bytes("the table of the basis", 2 * bytes as u64)?;
        let mut table = Self {
            lights: TriangleMap::new(grid.lights(), job)?,
            views: TriangleMap::new(grid.views(), job)?,
            functions,
            channels,
            texels: vec![f16::ZERO; LANES * layers * lights * views],
        };
        table.fill(grid, learned.values());
        Ok(Some(table))
    }

    fn fill(&mut self, grid: &PairGrid, values: &[f32]) {
        let count = self.functions * self.channels;
        for view in 0..self.views.points.len() {
            for light in 0..self.lights.points.len() {
                let row = &values[grid.pair(light, view) * count..][..count];
                for (value, number) in row.iter().enumerate() {
                    let place = self.place(value, light, view);
                    self.texels[place] = f16::from_f32(*number);
                }
            }
        }
    }

    fn place(&self, value: usize, light: usize, view: usize) -> usize {
        let (channel, function) = (value / self.functions, value % self.functions);
        let layer = channel * self.functions.div_ceil(LANES) + function / LANES;
        ((layer * self.views.points.len() + view) * self.lights.points.len() + light) * LANES
            + function % LANES
    }

    /// The values: little-endian halves, layer after layer.
    pub fn bytes(&self) -> Vec<u8> {
        self.texels.iter().flat_map(|v| v.to_le_bytes()).collect()
    }

    /// The maps of triangles: four little-endian 16-bit integers a node, the last 0; that of the lights, then that of the
    /// views.
    pub fn corner_bytes(&self) -> Vec<u8> {
        let nodes = self.lights.corners.iter().chain(&self.views.corners);
        nodes.flat_map(|&[a, b, c]| [a, b, c, 0]).flat_map(u16::to_le_bytes).collect()
    }

    /// The values between the measured ones, as shaders find them.
    ///
    /// # Panics
    /// When `out` does not hold the values of all functions and channels.
    pub fn weights_into(&self, directions: Directions, out: &mut [f64]) {
        assert_eq!(out.len(), self.functions * self.channels, "a number for each function and channel");
        out.fill(0.0);
        for (view, a) in self.views.shares(directions.view) {
            for (light, b) in self.lights.shares(directions.light) {
                let value = |k: usize| self.texels[self.place(k, light, view)].to_f64();
                out.iter_mut().enumerate().for_each(|(k, o)| *o += a * b * value(k));
            }
        }
    }

    /// The table's entry of the header, with the error against the basis.
    pub(super) fn described(&self, [file, corners]: [String; 2], basis: &Basis) -> ShareMeasured {
        let (error_rms, error_max) = basis_error(basis, |directions, out| self.weights_into(directions, out));
        let single = |points: &[[f64; 2]]| points.iter().map(|p| p.map(|v| v as f32)).collect();
        let (lights, views) = (single(&self.lights.points), single(&self.views.points));
        ShareMeasured { file, corners, map_nodes: MAP_NODES, lights, views, error_rms, error_max }
    }
}

impl TriangleMap {
    fn new(triangulation: &Triangulation, job: &Job) -> Result<Self> {
        job.proceed()?;
        let nodes = (0..MAP_NODES).flat_map(|row| (0..MAP_NODES).map(move |column| (column, row)));
        let corners = nodes.map(|(column, row)| {
            triangulation.shares(node(column, row, MAP_NODES)).map(|(index, _)| index as u16)
        });
        Ok(Self { points: triangulation.points().to_vec(), corners: corners.collect() })
    }

    /// The directions around one, and their shares.
    fn shares(&self, direction: Direction) -> [(usize, f64); 3] {
        let [column, row] = between(direction, MAP_NODES).map(|(lower, t)| lower + usize::from(t >= 0.5));
        let corners = self.corners[row * MAP_NODES + column].map(usize::from);
        let shares =
            shares_in(projected(direction), corners.map(|i| self.points[i]), corners[0] == corners[2]);
        std::array::from_fn(|k| (corners[k], shares[k]))
    }
}

/// The shares of three corners at a place, or along the edge of the first two.
fn shares_in(place: [f64; 2], corners: [[f64; 2]; 3], is_edge: bool) -> [f64; 3] {
    let [a, b, _] = corners;
    if is_edge {
        let (dx, dy) = (b[0] - a[0], b[1] - a[1]);
        let along = (place[0] - a[0]) * dx + (place[1] - a[1]) * dy;
        let t = (along / (dx * dx + dy * dy).max(1e-12)).clamp(0.0, 1.0);
        return [1.0 - t, t, 0.0];
    }
    let shares = barycentric(place, corners).map(|share| share.max(0.0));
    let sum: f64 = shares.iter().sum();
    shares.map(|share| share / sum)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn measured_functions_are_nearly_those_of_the_basis() {
        let mut found = 0;
        for basis in Basis::examples() {
            let Some(table) = MeasuredTable::new(&basis, &Job::default()).unwrap() else { continue };
            let (rms, largest) = basis_error(&basis, |directions, out| table.weights_into(directions, out));
            assert!(rms < 0.005, "{rms} and at most {largest}");
            found += 1;
        }
        assert!(found > 0, "an example was measured on a grid");
    }

    #[test]
    fn other_bases_have_no_measured_directions() {
        assert_eq!(MeasuredTable::new(&Basis::Ptm, &Job::default()).unwrap(), None);
    }
}
