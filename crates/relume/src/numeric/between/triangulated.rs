//! Interpolation between directions of the hemisphere: barycentric in the triangles of a Delaunay triangulation
//! (B. Delaunay, "Sur la sphère vide", 1934) of the stereographic projection. It maps circles of the sphere to
//! circles, so that the triangles are those of the Delaunay triangulation of the sphere itself.
//!
//! Directions outside the triangulation, as between the last ring of a measurement and the horizon, take the
//! values of the nearest point of its border.

use delaunator::{EMPTY, Point, triangulate};

use crate::direction::Direction;

/// Cells along each axis of the grid in which triangles are looked up.
const CELLS: usize = 24;

/// Barycentric coordinates down to this are inside: neighbours share their edges without a gap.
const MARGIN: f64 = -1e-9;

/// The cosine of the angle from which on a triangle at the border is a sliver: 155 degrees.
const FLAT_COSINE: f64 = -0.906;

/// Three directions and their shares, which sum to 1; a direction may occur with the share 0.
pub type Shares = [(usize, f64); 3];

/// A triangulation of directions.
#[derive(Debug, Clone)]
pub struct Triangulation {
    points: Vec<[f64; 2]>,
    triangles: Vec<[usize; 3]>,
    /// The edges of the border.
    border: Vec<[usize; 2]>,
    /// The triangles that may meet each cell.
    cells: Vec<Vec<u32>>,
}

impl Triangulation {
    /// The triangulation of distinct directions, at least one. Directions in one line have no triangles; their border is
    /// the line.
    pub fn new(directions: &[Direction]) -> Self {
        let points: Vec<[f64; 2]> = directions.iter().map(|d| projected(*d)).collect();
        let sites: Vec<Point> = points.iter().map(|&[x, y]| Point { x, y }).collect();
        let found = triangulate(&sites);
        let (triangles, mut border) = without_slivers(found, &points);
        if triangles.is_empty() {
            border = in_line(&points);
        }
        let mut cells = vec![Vec::new(); CELLS * CELLS];
        for (t, triangle) in triangles.iter().enumerate() {
            let corners = triangle.map(|i| points[i]);
            let range = |axis: usize| {
                let values = corners.map(|corner| corner[axis]);
                let low = values.into_iter().fold(f64::INFINITY, f64::min);
                let high = values.into_iter().fold(f64::NEG_INFINITY, f64::max);
                cell(low - 1e-9)..=cell(high + 1e-9)
            };
            for y in range(1) {
                range(0).for_each(|x| cells[y * CELLS + x].push(t as u32));
            }
        }
        Self { points, triangles, border, cells }
    }

    /// The directions in the stereographic projection from the nadir.
    pub fn points(&self) -> &[[f64; 2]] {
        &self.points
    }

    /// One of the directions.
    pub fn direction(&self, index: usize) -> Direction {
        let [x, y] = self.points[index];
        let scale = 2.0 / (1.0 + x * x + y * y);
        Direction::from_disk(scale * x, scale * y)
    }

    /// The directions around one, and their shares.
    pub fn shares(&self, direction: Direction) -> Shares {
        let place = projected(direction);
        let candidates = &self.cells[cell(place[1]) * CELLS + cell(place[0])];
        let mut best: (f64, Shares) = (f64::NEG_INFINITY, [(0, 1.0), (0, 0.0), (0, 0.0)]);
        for &t in candidates {
            let triangle = self.triangles[t as usize];
            let shares = barycentric(place, triangle.map(|i| self.points[i]));
            let least = shares.into_iter().fold(f64::INFINITY, f64::min);
            if least > best.0 {
                best = (least, std::array::from_fn(|k| (triangle[k], shares[k])));
            }
        }
        if best.0 >= MARGIN { best.1 } else { self.on_border(place) }
    }

    /// The nearest point of the border, as shares of the ends of its edge.
    fn on_border(&self, place: [f64; 2]) -> Shares {
        let mut best = (f64::INFINITY, [(0, 1.0), (0, 0.0), (0, 0.0)]);
        for &[a, b] in &self.border {
            let ([ax, ay], [bx, by]) = (self.points[a], self.points[b]);
            let (dx, dy) = (bx - ax, by - ay);
            let length = dx * dx + dy * dy;
            let along =
                if length > 0.0 { ((place[0] - ax) * dx + (place[1] - ay) * dy) / length } else { 0.0 };
            let t = along.clamp(0.0, 1.0);
            let distance = (ax + t * dx - place[0]).powi(2) + (ay + t * dy - place[1]).powi(2);
            if distance < best.0 {
                best = (distance, [(a, 1.0 - t), (b, t), (a, 0.0)]);
            }
        }
        best.1
    }
}

/// The projection from the nadir: the unit disk is the hemisphere, the distance from its centre the tangent of half the
/// polar angle. Directions below the horizon are those of the horizon.
pub fn projected(direction: Direction) -> [f64; 2] {
    let scale = 1.0 / (1.0 + direction.z().max(0.0));
    [direction.x() * scale, direction.y() * scale]
}

/// The triangles but for slivers at the border, and the edges of the border that they leave. Across a sliver, values of a
/// corner in its middle would change to those of its far corners within a small angle.
fn without_slivers(
    mut found: delaunator::Triangulation,
    points: &[[f64; 2]],
) -> (Vec<[usize; 3]>, Vec<[usize; 2]>) {
    let next = |edge: usize| if edge % 3 == 2 { edge - 2 } else { edge + 1 };
    let corners = found.triangles;
    let mut open: Vec<usize> = (0..corners.len()).filter(|edge| found.halfedges[*edge] == EMPTY).collect();
    let mut is_outer = vec![false; points.len()];
    open.iter().for_each(|edge| is_outer[corners[*edge]] = true);
    let mut is_left = vec![true; corners.len() / 3];
    while let Some(edge) = open.pop() {
        let others = [next(edge), next(next(edge))];
        let [a, b, apex] = [edge, others[0], others[1]].map(|e| corners[e]);
        if is_outer[apex] || !is_flat(points[a], points[apex], points[b]) {
            continue;
        }
        is_left[edge / 3] = false;
        is_outer[apex] = true;
        for other in others {
            let beyond = found.halfedges[other];
            found.halfedges[beyond] = EMPTY;
            open.push(beyond);
        }
    }
    let border = (0..corners.len()).filter(|edge| is_left[edge / 3] && found.halfedges[*edge] == EMPTY);
    let border = border.map(|edge| [corners[edge], corners[next(edge)]]).collect();
    let triangles = corners.as_chunks::<3>().0.iter().zip(is_left).filter(|(_, is_left)| *is_left);
    (triangles.map(|(triangle, _)| *triangle).collect(), border)
}

/// Whether the angle at a corner is nearly a straight one.
fn is_flat([ax, ay]: [f64; 2], [cx, cy]: [f64; 2], [bx, by]: [f64; 2]) -> bool {
    let ([px, py], [qx, qy]) = ([ax - cx, ay - cy], [bx - cx, by - cy]);
    px * qx + py * qy < FLAT_COSINE * (px.hypot(py) * qx.hypot(qy))
}

fn cell(coordinate: f64) -> usize {
    (((coordinate + 1.0) * 0.5 * CELLS as f64).max(0.0) as usize).min(CELLS - 1)
}

/// Edges between neighbours along a line of points; of one point, an edge to itself.
fn in_line(points: &[[f64; 2]]) -> Vec<[usize; 2]> {
    let mut order: Vec<usize> = (0..points.len()).collect();
    let key = |i: usize| points[i];
    order.sort_by(|&a, &b| key(a)[0].total_cmp(&key(b)[0]).then(key(a)[1].total_cmp(&key(b)[1])));
    match order[..] {
        [one] => vec![[one, one]],
        _ => order.windows(2).map(|pair| [pair[0], pair[1]]).collect(),
    }
}

/// The shares of three corners at a place.
pub fn barycentric(place: [f64; 2], [a, b, c]: [[f64; 2]; 3]) -> [f64; 3] {
    let cross = |[px, py]: [f64; 2], [qx, qy]: [f64; 2], [rx, ry]: [f64; 2]| {
        (qx - px) * (ry - py) - (qy - py) * (rx - px)
    };
    let area = cross(a, b, c);
    let [u, v] = [cross(place, b, c) / area, cross(a, place, c) / area];
    [u, v, 1.0 - u - v]
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::TAU;

    fn rings() -> Vec<Direction> {
        let mut all = vec![Direction::ZENITH];
        for (ring, count) in [(1, 6), (2, 12), (3, 18), (4, 20), (5, 24)] {
            let polar = (15.0 * f64::from(ring)).to_radians();
            all.extend(
                (0..count).map(|i| Direction::from_angles(polar, TAU * f64::from(i) / f64::from(count))),
            );
        }
        all
    }

    #[test]
    fn measured_directions_have_their_own_values_and_linear_ones_are_kept() {
        let directions = rings();
        let triangulation = Triangulation::new(&directions);
        for (i, direction) in directions.iter().enumerate() {
            let own: f64 =
                triangulation.shares(*direction).iter().filter(|(k, _)| *k == i).map(|(_, s)| s).sum();
            assert!((own - 1.0).abs() < 1e-6, "{i}: {own}");
        }
        // A function that is linear in the projection is interpolated exactly.
        let linear = |d: Direction| 0.3 + 0.5 * projected(d)[0] - 0.2 * projected(d)[1];
        for i in 0..500 {
            let t = f64::from(i);
            let direction = Direction::from_angles(1.25 * (t / 500.0), 2.4 * t);
            let shares = triangulation.shares(direction);
            assert!((shares.iter().map(|(_, s)| s).sum::<f64>() - 1.0).abs() < 1e-12);
            let value: f64 = shares.iter().map(|(k, s)| s * linear(directions[*k])).sum();
            assert!((value - linear(direction)).abs() < 1e-9, "{direction:?}");
        }
    }

    #[test]
    fn beyond_the_last_ring_the_nearest_point_of_it_counts() {
        let directions = rings();
        let triangulation = Triangulation::new(&directions);
        for i in 0..24 {
            let shares = triangulation.shares(Direction::from_angles(1.55, TAU * f64::from(i) / 24.0));
            let own: f64 = shares.iter().filter(|(k, _)| *k == 57 + i as usize).map(|(_, s)| s).sum();
            assert!((own - 1.0).abs() < 1e-9, "{shares:?}");
        }
    }

    /// A former fault: a direction just within the border had a sliver beside it, across which values changed within half
    /// a degree to those of directions far away.
    #[test]
    fn slivers_at_the_border_are_left_out() {
        let azimuths = [0.0f64, 1.1, 2.0, 3.1, 4.0, 5.2];
        let mut directions: Vec<Direction> =
            azimuths.iter().map(|azimuth| Direction::from_angles(0.9, *azimuth)).collect();
        directions.push(Direction::ZENITH);
        let [a, b] = [0, 1].map(|i| projected(directions[i]));
        let inner = [0.497 * (a[0] + b[0]), 0.497 * (a[1] + b[1])];
        let polar = 2.0 * inner[0].hypot(inner[1]).atan();
        directions.push(Direction::from_angles(polar, inner[1].atan2(inner[0])));
        let triangulation = Triangulation::new(&directions);
        let own = |polar: f64| {
            let direction = Direction::from_angles(polar, inner[1].atan2(inner[0]));
            triangulation.shares(direction).iter().filter(|(k, _)| *k == 7).map(|(_, s)| s).sum::<f64>()
        };
        for beyond in [0.0, 0.005, 0.02, 0.3] {
            assert!(own(polar + beyond) > 0.99, "{} at {beyond}", own(polar + beyond));
        }
        // Corners of six triangles around the zenith, one of which has two edges of the border instead of one.
        assert_eq!((triangulation.triangles.len(), triangulation.border.len()), (7, 7));
    }

    #[test]
    fn one_direction_and_those_in_a_line_are_interpolated_too() {
        let one = Triangulation::new(&[Direction::ZENITH]);
        let sum: f64 = one.shares(Direction::from_angles(1.0, 0.3)).iter().map(|(_, s)| s).sum();
        assert_eq!(sum, 1.0);
        let at = |tangent: f64| Direction::from_angles(2.0 * tangent.atan(), 0.0);
        let line = [-0.4, 0.0, 0.3].map(at);
        let shares = Triangulation::new(&line).shares(at(0.2));
        let value: f64 = shares.iter().map(|(k, s)| s * [-0.4, 0.0, 0.3][*k]).sum();
        assert!((value - 0.2).abs() < 1e-9, "{shares:?}");
    }

    #[test]
    fn shares_are_continuous() {
        let triangulation = Triangulation::new(&rings());
        let value = |t: f64| {
            let direction = Direction::from_angles(0.02 + 1.5 * t, 9.0 * t);
            triangulation.shares(direction).iter().map(|(k, s)| s * ((k * 37) % 11) as f64).sum::<f64>()
        };
        let steps = 20_000;
        let mut before = value(0.0);
        for i in 1..=steps {
            let now = value(f64::from(i) / f64::from(steps));
            assert!((now - before).abs() < 0.2, "a jump at step {i}");
            before = now;
        }
    }
}
