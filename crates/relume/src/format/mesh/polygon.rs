//! Triangulation of polygons by ear clipping (Meisters, "Polygons Have Ears", American Mathematical Monthly
//! 1975), in the plane of their Newell normal (Tampieri, "Newell's Method for Computing the Plane Equation of
//! a Polygon", Graphics Gems III, 1992).
//!
//! A polygon that is star-shaped from its first corner, such as every convex one, is split into a fan. The
//! others usually take O(corners^2) steps, at worst O(corners^3), so they may have at most [`MAX_CORNERS`].

use crate::error::{Error, Result};

/// The most corners of a polygon that is not a fan.
const MAX_CORNERS: usize = 2048;

type PlanePoint = [f64; 2];

/// The triangles of a polygon, as indices into `corners`, with the orientation of the polygon.
///
/// Self-intersecting polygons and those without area give as many triangles as others, in some order.
///
/// # Errors
/// More corners than are supported.
pub(super) fn triangulate(corners: &[[f32; 3]]) -> Result<Vec<[usize; 3]>> {
    let fan: Vec<_> = (2..corners.len()).map(|i| [0, i - 1, i]).collect();
    let points = flattened(corners);
    let at = |t: &[usize; 3]| t.map(|i| points[i]);
    if corners.len() < 4 || fan.iter().all(|t| twice_area(at(t)) >= 0.0) {
        return Ok(fan);
    }
    if corners.len() > MAX_CORNERS {
        return Err(Error::limit(format!(
            "a face that is not convex has {} corners and at most {MAX_CORNERS} are cut: triangulate the mesh before \
             exporting it",
            corners.len()
        )));
    }
    Ok(ears(&points))
}

/// The polygon in the plane of its normal, seen from the side on which it is counter-clockwise.
fn flattened(corners: &[[f32; 3]]) -> Vec<PlanePoint> {
    let corners: Vec<[f64; 3]> = corners.iter().map(|c| c.map(f64::from)).collect();
    let next = corners.iter().cycle().skip(1);
    // Components of the Newell normal: the areas of the projections of the polygon on the coordinate planes.
    let shadow = |a: usize, b: usize| -> f64 {
        corners.iter().zip(next.clone()).map(|(p, q)| (p[a] - q[a]) * (p[b] + q[b])).sum()
    };
    let normal = [shadow(1, 2), shadow(2, 0), shadow(0, 1)];
    let axis = (0..3).max_by(|&a, &b| normal[a].abs().total_cmp(&normal[b].abs())).unwrap_or(2);
    let (a, b) = ((axis + 1) % 3, (axis + 2) % 3);
    let (a, b) = if normal[axis] < 0.0 { (b, a) } else { (a, b) };
    corners.iter().map(|c| [c[a], c[b]]).collect()
}

fn twice_area([a, b, c]: [PlanePoint; 3]) -> f64 {
    (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])
}

fn ears(points: &[PlanePoint]) -> Vec<[usize; 3]> {
    let mut left: Vec<usize> = (0..points.len()).collect();
    let mut triangles = Vec::with_capacity(points.len() - 2);
    let mut start = 0;
    while left.len() > 3 {
        let count = left.len();
        let around = |i: usize| [left[(i + count - 1) % count], left[i], left[(i + 1) % count]];
        let area = |i: usize| twice_area(around(i).map(|j| points[j]));
        let places = (0..count).map(|k| (start + k) % count);
        let ear = places.clone().find(|&i| area(i) > 0.0 && is_empty(around(i), &left, points));
        // Only self-intersecting or degenerate polygons have no ear: the largest turn does the least harm.
        let ear = ear.or_else(|| places.max_by(|&i, &j| area(i).total_cmp(&area(j)))).unwrap_or(0);
        triangles.push(around(ear));
        left.remove(ear);
        start = ear;
    }
    triangles.push([left[0], left[1], left[2]]);
    triangles
}

/// Whether no corner lies in a triangle or on its edges, apart from corners at its own points.
fn is_empty(triangle: [usize; 3], corners: &[usize], points: &[PlanePoint]) -> bool {
    let [a, b, c] = triangle.map(|i| points[i]);
    let inside = |p: PlanePoint| {
        p != a
            && p != b
            && p != c
            && [[a, b, p], [b, c, p], [c, a, p]].into_iter().all(|side| twice_area(side) >= 0.0)
    };
    !corners.iter().any(|&i| inside(points[i]))
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    /// Whether each sample of the plane lies in as many triangles as the even-odd rule requires: none or one.
    fn check_cover(polygon: &[PlanePoint]) {
        let corners: Vec<[f32; 3]> = polygon.iter().map(|p| [p[0] as f32, p[1] as f32, 0.0]).collect();
        let triangles = triangulate(&corners).unwrap();
        assert_eq!(triangles.len(), polygon.len() - 2);
        for (x, y) in (0..40).flat_map(|y| (0..40).map(move |x| (x, y))) {
            let p = [f64::from(x) * 0.2512 - 5.003, f64::from(y) * 0.2507 - 5.001];
            let edges = polygon.iter().zip(polygon.iter().cycle().skip(1));
            let crossed = edges.filter(|(a, b)| {
                (a[1] > p[1]) != (b[1] > p[1]) && p[0] < a[0] + (p[1] - a[1]) / (b[1] - a[1]) * (b[0] - a[0])
            });
            let within = triangles.iter().filter(|t| {
                let [a, b, c] = t.map(|i| polygon[i]);
                [[a, b, p], [b, c, p], [c, a, p]].into_iter().all(|side| twice_area(side) > 0.0)
            });
            assert_eq!(within.count(), crossed.count() % 2, "{p:?} of {polygon:?}");
        }
    }

    #[test]
    fn concave_polygons_are_covered_once() {
        let l = [[-4.0, -4.0], [4.0, -4.0], [4.0, -1.0], [-1.0, -1.0], [-1.0, 4.0], [-4.0, 4.0]];
        let arrow = [[-4.0, 0.0], [4.0, 4.0], [0.0, 0.0], [4.0, -4.0]];
        let comb: Vec<PlanePoint> = (0..9)
            .map(|i| [4.0 - f64::from(i), if i % 2 == 0 { 3.0 } else { -2.0 }])
            .chain([[-4.5, -4.0], [4.5, -4.0]])
            .collect();
        for polygon in [&l[..], &comb] {
            for turn in 0..polygon.len() {
                check_cover(&[&polygon[turn..], &polygon[..turn]].concat());
            }
        }
        let turned: Vec<PlanePoint> = arrow.into_iter().rev().collect();
        check_cover(&turned);
    }

    #[test]
    fn a_wall_with_a_bridged_window_keeps_its_window() {
        let outer = [[-4.0, -4.0], [4.0, -4.0], [4.0, 4.0], [-4.0, 4.0], [-4.0, -4.0]];
        let inner = [[-2.0, -2.0], [-2.0, 2.0], [2.0, 2.0], [2.0, -2.0], [-2.0, -2.0]];
        check_cover(&[&outer[..], &inner[..]].concat());
    }

    #[test]
    fn triangles_turn_as_their_polygon_in_any_plane() {
        let l = [[0.0, 0.0], [3.0, 0.0], [3.0, 1.0], [1.0, 1.0], [1.0, 3.0], [0.0, 3.0]];
        let places: [fn(f32, f32) -> [f32; 3]; 4] =
            [|x, y| [x, y, 7.0], |x, y| [7.0, x, y], |x, y| [y, x, -2.0], |x, y| [x, x - y, x + y]];
        for place in places {
            let corners: Vec<[f32; 3]> = l.iter().map(|p| place(p[0], p[1])).collect();
            let points = flattened(&corners);
            let triangles = triangulate(&corners).unwrap();
            assert!(triangles.iter().all(|t| twice_area(t.map(|i| points[i])) > 0.0), "{triangles:?}");
        }
    }

    #[test]
    fn convex_polygons_stay_fans_and_hopeless_ones_end() {
        let hexagon: Vec<[f32; 3]> = (0..6).map(|i| (i as f32).sin_cos()).map(|(s, c)| [c, s, 0.0]).collect();
        assert_eq!(triangulate(&hexagon).unwrap(), [[0, 1, 2], [0, 2, 3], [0, 3, 4], [0, 4, 5]]);
        assert_eq!(triangulate(&[[1.0; 3]; 5]).unwrap().len(), 3);
        let bow = [[0.0, 0.0, 0.0], [1.0, 1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];
        assert_eq!(triangulate(&bow).unwrap().len(), 2);
        let zigzag: Vec<_> = (0..5000).map(|i| [i as f32, (i % 2) as f32 * 9.0, 0.0]).collect();
        assert!(triangulate(&zigzag).unwrap_err().to_string().contains("5000 corners"));
    }

    proptest! {
        #[test]
        fn polygons_around_a_point_are_covered_once(radii in prop::collection::vec(0.3..4.9f32, 3..14)) {
            let angle = std::f64::consts::TAU / radii.len() as f64;
            let point = |(i, &r): (usize, &f32)| {
                let (sin, cos) = (i as f64 * angle).sin_cos();
                [f64::from((f64::from(r) * cos) as f32), f64::from((f64::from(r) * sin) as f32)]
            };
            check_cover(&radii.iter().enumerate().map(point).collect::<Vec<_>>());
        }
    }
}
