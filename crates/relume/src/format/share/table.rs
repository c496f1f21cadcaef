//! The functions of a basis as a table over directions, for readers without formulas for them.
//!
//! The upper hemisphere is mapped to a square by the octahedral map (Cigolle, Donow, Evangelakos, Mara, McGuire, Meyer,
//! "A Survey of Efficient Representations for Independent Unit Vectors", Journal of Computer Graphics Techniques 3(2),
//! 2014, hemi-oct): with s = |x| + |y| + z, (x + y) / s and (x - y) / s lie between -1 and 1, and the border is the
//! horizon. Harmonics have an infinite slope there, as the root of z has, so both are divided by 1 + sqrt(z / s): nodes are
//! as dense as the root of z needs them. Nodes lie on a grid that includes the border; with an odd number of them along a side one lies at the zenith.
//! Between nodes a table is bilinear, and for functions of light and view bilinear in both: sixteen nodes.
//!
//! In memory and in files the table is an atlas: for each node of the view, (row, column), a square of the nodes of the
//! light, which is a texture of `light_nodes * view_nodes` texels a side. A layer holds the values of four functions for
//! one channel; those of the first channel come first, and where their number is no multiple of four the last is filled with zeros.

use half::f16;

use super::header::ShareTable;
use crate::direction::{Direction, Directions};
use crate::error::Result;
use crate::field::Basis;
use crate::job::Job;

/// Nodes along a side for functions of light.
const LIGHT_NODES: usize = 129;
/// Nodes along the sides of lights and of views for functions of both: the first that fit.
const PAIR_NODES: [usize; 6] = [33, 29, 25, 21, 17, 13];
/// Bytes of a table. Between few measured directions functions are nearly linear, and a seventh is left of it compressed.
const MOST_BYTES: usize = 64 << 20;
/// Directions at which the error is measured.
const PROBES: usize = 4096;
/// Values of a texel of a layer.
pub(super) const LANES: usize = 4;

/// Values of functions at nodes.
#[derive(Debug, Clone, PartialEq)]
pub struct BasisTable {
    light_nodes: usize,
    view_nodes: usize,
    functions: usize,
    channels: usize,
    /// Layer after layer, rows of texels of four values.
    texels: Vec<f16>,
}

/// Where a direction lies between nodes: the lower node and the fraction, along both axes.
pub(super) type BetweenNodes = [(usize, f64); 2];

impl BasisTable {
    /// The table of a basis.
    ///
    /// # Errors
    /// When memory is short, and a cancelled job.
    pub fn new(basis: &Basis, job: &Job) -> Result<Self> {
        let (functions, channels) = (basis.len(), basis.channels());
        let layers = channels * functions.div_ceil(LANES);
        let bytes = |&(light, view): &(usize, usize)| 2 * LANES * layers * (light * view).pow(2);
        let (light_nodes, view_nodes) = match basis.depends_on_view() {
            false => (LIGHT_NODES, 1),
            true => {
                let pairs = || PAIR_NODES.into_iter().map(|nodes| (nodes, nodes));
                pairs().find(|nodes| bytes(nodes) <= MOST_BYTES).or(pairs().next_back()).expect("some nodes")
            }
        };
        job.check_bytes("the table of the basis", 2 * bytes(&(light_nodes, view_nodes)) as u64)?;
        let side = light_nodes * view_nodes;
        let texels = vec![f16::ZERO; LANES * layers * side * side];
        let mut table = Self { light_nodes, view_nodes, functions, channels, texels };
        let mut weights = vec![0.0; functions * channels];
        job.start("tabulating the basis", side as u64);
        for row in 0..side {
            for column in 0..side {
                basis.weights_into(table.directions(column, row), &mut weights);
                for (k, weight) in weights.iter().enumerate() {
                    let place = table.place(k, column, row);
                    table.texels[place] = f16::from_f64(*weight);
                }
            }
            job.advance(1)?;
        }
        Ok(table)
    }

    /// The light and the view of a texel of the atlas.
    fn directions(&self, column: usize, row: usize) -> Directions {
        let n = self.light_nodes;
        let light = node(column % n, row % n, n);
        let view = match self.view_nodes {
            1 => Direction::ZENITH,
            nodes => node(column / n, row / n, nodes),
        };
        Directions { light, view }
    }

    /// The number of values of a pair of directions.
    fn values(&self) -> usize {
        self.functions * self.channels
    }

    fn place(&self, value: usize, column: usize, row: usize) -> usize {
        let side = self.light_nodes * self.view_nodes;
        let (channel, function) = (value / self.functions, value % self.functions);
        let layer = channel * self.functions.div_ceil(LANES) + function / LANES;
        ((layer * side + row) * side + column) * LANES + function % LANES
    }

    /// Little-endian halves, layer after layer.
    pub fn bytes(&self) -> Vec<u8> {
        self.texels.iter().flat_map(|v| v.to_le_bytes()).collect()
    }

    /// The values between nodes, as shaders find them.
    ///
    /// # Panics
    /// When `out` does not hold the values of all functions and channels.
    pub fn weights_into(&self, directions: Directions, out: &mut [f64]) {
        assert_eq!(out.len(), self.values(), "a number for each function and channel");
        let lights = between(directions.light, self.light_nodes);
        let views = match self.view_nodes {
            1 => [(0, 0.0); 2],
            nodes => between(directions.view, nodes),
        };
        out.fill(0.0);
        for (row_of_view, share_row) in corners(views[1]) {
            for (column_of_view, share_column) in corners(views[0]) {
                for (y, share_y) in corners(lights[1]) {
                    for (x, share_x) in corners(lights[0]) {
                        let share = share_row * share_column * share_y * share_x;
                        let column = column_of_view * self.light_nodes + x;
                        let row = row_of_view * self.light_nodes + y;
                        self.add(share, column, row, out);
                    }
                }
            }
        }
    }

    fn add(&self, share: f64, column: usize, row: usize, out: &mut [f64]) {
        if share > 0.0 {
            let value = |k: usize| self.texels[self.place(k, column, row)].to_f64();
            out.iter_mut().enumerate().for_each(|(k, o)| *o += share * value(k));
        }
    }

    /// The table's entry of the header, with the error against the basis.
    pub(super) fn described(&self, file: String, basis: &Basis) -> ShareTable {
        let (error_rms, error_max) = self.error(basis);
        let Self { light_nodes, view_nodes, .. } = *self;
        ShareTable { file, light_nodes, view_nodes, error_rms, error_max }
    }

    /// `basis_error` of the table.
    pub fn error(&self, basis: &Basis) -> (f64, f64) {
        basis_error(basis, |directions, out| self.weights_into(directions, out))
    }
}

/// The root of the mean squared difference of other functions from those of a basis and the largest one, over the root of
/// the mean square of the basis, at lights spread evenly under views spread evenly.
pub(super) fn basis_error(basis: &Basis, weights_into: impl Fn(Directions, &mut [f64])) -> (f64, f64) {
    let values = basis.len() * basis.channels();
    let (mut truth, mut found) = (vec![0.0; values], vec![0.0; values]);
    let (lights, views) = (Direction::fibonacci(PROBES), Direction::fibonacci(PROBES));
    let (mut squares, mut differences, mut largest) = (0.0, 0.0, 0.0f64);
    for i in 0..PROBES {
        // A step without a common factor visits every view once.
        let directions = Directions { light: lights(i), view: views(i * 1237 % PROBES) };
        basis.weights_into(directions, &mut truth);
        weights_into(directions, &mut found);
        for (a, b) in truth.iter().zip(&found) {
            squares += a * a;
            differences += (a - b) * (a - b);
            largest = largest.max((a - b).abs());
        }
    }
    let count = (PROBES * values) as f64;
    let scale = (squares / count).sqrt().max(f64::MIN_POSITIVE);
    ((differences / count).sqrt() / scale, largest / scale)
}

/// The direction of a node of a map with `nodes` along a side.
pub(super) fn node(column: usize, row: usize, nodes: usize) -> Direction {
    let coordinate = |i: usize| 2.0 * i as f64 / (nodes - 1) as f64 - 1.0;
    let (a, b) = (coordinate(column), coordinate(row));
    let spread = 2.0 - a.abs().max(b.abs());
    let (a, b) = (a * spread, b * spread);
    let (x, y) = (0.5 * (a + b), 0.5 * (a - b));
    let z = (1.0 - x.abs() - y.abs()).max(0.0);
    Direction::new(x, y, z).expect("the sum of the components' sizes is 1")
}

/// Where a direction lies on a map; one below the horizon lies on it.
pub(super) fn between(direction: Direction, nodes: usize) -> BetweenNodes {
    let [x, y, z] = direction.to_array();
    let z = z.max(0.0);
    let sum = x.abs() + y.abs() + z;
    let spread = sum * (1.0 + (z / sum).sqrt());
    let place = |coordinate: f64| {
        let place = (0.5 * coordinate / spread + 0.5) * (nodes - 1) as f64;
        let lower = (place as usize).min(nodes - 2);
        (lower, place - lower as f64)
    };
    [place(x + y), place(x - y)]
}

/// Both nodes along an axis with their shares.
fn corners((lower, fraction): (usize, f64)) -> [(usize, f64); 2] {
    [(lower, 1.0 - fraction), (lower + 1, fraction)]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn nodes_lie_where_directions_are_looked_up() {
        for nodes in [2, 7, 17] {
            for (row, column) in (0..nodes).flat_map(|r| (0..nodes).map(move |c| (r, c))) {
                let found = between(node(column, row, nodes), nodes);
                let place = found.map(|(lower, fraction)| lower as f64 + fraction);
                assert!((place[0] - column as f64).abs() < 1e-9, "{column} {row}: {place:?}");
                assert!((place[1] - row as f64).abs() < 1e-9, "{column} {row}: {place:?}");
            }
        }
        assert_eq!(node(8, 8, 17), Direction::ZENITH);
    }

    #[test]
    fn tables_are_near_every_basis() {
        for basis in Basis::examples() {
            let table = BasisTable::new(&basis, &Job::default()).unwrap();
            let (rms, largest) = table.error(&basis);
            // Values interpolated between few lights or pairs have corners; formulas have none.
            let bound = match basis {
                _ if basis.depends_on_view() => 0.15,
                Basis::Interpolated(_) => 0.02,
                _ => 0.003,
            };
            assert!(rms < bound, "{}: {rms:.5}, at most {largest:.4}", basis.name());
            assert!(rms <= largest || largest == 0.0);
        }
    }

    #[test]
    fn a_table_is_exact_at_its_nodes() {
        for basis in Basis::examples() {
            let table = BasisTable::new(&basis, &Job::default()).unwrap();
            let side = table.light_nodes * table.view_nodes;
            let count = basis.len() * basis.channels();
            let (mut truth, mut found) = (vec![0.0; count], vec![0.0; count]);
            for i in (0..side * side).step_by(53) {
                let directions = table.directions(i % side, i / side);
                basis.weights_into(directions, &mut truth);
                table.weights_into(directions, &mut found);
                for (a, b) in truth.iter().zip(&found) {
                    assert!((a - b).abs() < 1e-3 * a.abs().max(1.0), "{}: {a} and {b}", basis.name());
                }
            }
        }
    }
}
