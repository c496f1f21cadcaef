//! The grid of equilateral triangles: the three vertices of a texel and its barycentric weights.

/// A vertex of the grid by its numbers along the two axes, and its weight at a texel.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct GridCorner {
    /// Number along the first axis, which points to the right.
    pub i: i64,
    /// Number along the second, which points to the right and down at 60 degrees.
    pub j: i64,
    /// Barycentric weight; those of the three corners sum to 1.
    pub weight: f64,
}

/// Height of an equilateral triangle of side 1: the root of 3/4.
const HEIGHT: f64 = 0.866_025_403_784_438_6;

/// The corners of the triangle that contains (x, y), for triangles of the given side.
pub fn corners(x: f64, y: f64, side: f64) -> [GridCorner; 3] {
    let down = y / (side * HEIGHT);
    let across = x / side - 0.5 * down;
    let (i, j) = (across.floor(), down.floor());
    let (s, t) = (across - i, down - j);
    let (i, j) = (i as i64, j as i64);
    if s + t < 1.0 {
        return [
            GridCorner { i, j, weight: 1.0 - s - t },
            GridCorner { i: i + 1, j, weight: s },
            GridCorner { i, j: j + 1, weight: t },
        ];
    }
    [
        GridCorner { i: i + 1, j: j + 1, weight: s + t - 1.0 },
        GridCorner { i, j: j + 1, weight: 1.0 - s },
        GridCorner { i: i + 1, j, weight: 1.0 - t },
    ]
}

/// The position of a vertex, rounded to whole texels.
pub fn vertex(i: i64, j: i64, side: f64) -> (i64, i64) {
    let x = side * (i as f64 + 0.5 * j as f64);
    let y = side * HEIGHT * j as f64;
    (x.round() as i64, y.round() as i64)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn texels_lie_where_their_weights_say() {
        assert!((HEIGHT - 0.75f64.sqrt()).abs() < 1e-15);
        for side in [3.0, 17.3, 74.0] {
            for (x, y) in (-60..60).flat_map(|y| (-60..60).map(move |x| (f64::from(x), f64::from(y)))) {
                let corners = corners(x, y, side);
                let sum =
                    |f: &dyn Fn(&GridCorner) -> f64| corners.iter().map(|c| c.weight * f(c)).sum::<f64>();
                assert!(corners.iter().all(|c| (-1e-12..=1.0).contains(&c.weight)));
                assert!((sum(&|_| 1.0) - 1.0).abs() < 1e-12);
                assert!((sum(&|c| side * (c.i as f64 + 0.5 * c.j as f64)) - x).abs() < 1e-9);
                assert!((sum(&|c| side * HEIGHT * c.j as f64) - y).abs() < 1e-9);
                for corner in corners {
                    let (vx, vy) = vertex(corner.i, corner.j, side);
                    assert!((vx as f64 - x).hypot(vy as f64 - y) <= side + 1.0);
                }
            }
        }
    }
}
