//! Lattices of the plane: all integer combinations of two vectors.
//!
//! A lattice has many bases. This type holds the reduced one (J. L. Lagrange 1773, C. F. Gauss 1801: two
//! shortest independent vectors, at 60 to 120 degrees), in a fixed order: first the vector nearer to the x
//! axis, pointing right, then the other, pointing down. Vectors are in texels, x to the right and y down the
//! rows.

/// How many steps along each vector are followed to an axis.
const STEPS: i32 = 4;

/// All integer combinations of two vectors.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize)]
pub struct Lattice {
    basis: [[f64; 2]; 2],
}

impl Lattice {
    /// The lattice of two vectors; `None` where they are (nearly) collinear, or so short or long that the squares
    /// of their lengths are not numbers of full precision.
    pub fn new(a: [f64; 2], b: [f64; 2]) -> Option<Self> {
        let lengths = length(a) * length(b);
        let apart = determinant(a, b).abs() > 1e-6 * lengths;
        let squares = [a, b].map(|v| v[0] * v[0] + v[1] * v[1]);
        let is_exact = squares.iter().all(|square| square.is_normal());
        (apart && is_exact).then(|| Self { basis: ordered(reduced([a, b])) })
    }

    /// The reduced basis.
    pub fn basis(&self) -> [[f64; 2]; 2] {
        self.basis
    }

    /// The area of one cell in texels.
    pub fn cell_area(&self) -> f64 {
        determinant(self.basis[0], self.basis[1]).abs()
    }

    /// The lattice point i a + j b of the basis (a, b); between lattice points for fractions.
    pub fn point(&self, [i, j]: [f64; 2]) -> [f64; 2] {
        let [a, b] = self.basis;
        [i * a[0] + j * b[0], i * a[1] + j * b[1]]
    }

    /// The numbers (i, j) with `point([i, j])` = `place`.
    pub fn coordinates(&self, place: [f64; 2]) -> [f64; 2] {
        let [a, b] = self.basis;
        let whole = determinant(a, b);
        [determinant(place, b) / whole, determinant(a, place) / whole]
    }

    /// The lattice point nearest to a position.
    pub fn nearest(&self, place: [f64; 2]) -> [f64; 2] {
        let [i, j] = self.coordinates(place).map(f64::floor);
        let around = [[0.0, 0.0], [1.0, 0.0], [0.0, 1.0], [1.0, 1.0]];
        let points = around.map(|[s, t]| self.point([i + s, j + t]));
        let distance = |p: [f64; 2]| length([p[0] - place[0], p[1] - place[1]]);
        points.into_iter().min_by(|p, q| distance(*p).total_cmp(&distance(*q))).expect("four points")
    }

    /// The shortest steps of the lattice along x and along y, to `tolerance` texels across; `None` where none is found among few.
    pub fn along_axes(&self, tolerance: f64) -> [Option<f64>; 2] {
        [0, 1].map(|axis| {
            let points = Self::half(STEPS).map(|at| self.point(at));
            let along = points.filter(|point| point[1 - axis].abs() <= tolerance);
            along.map(|point| point[axis].abs()).min_by(f64::total_cmp)
        })
    }

    /// The lattice points (i, j) other than the origin with |i|, |j| at most `most`, one of each
    /// opposite pair.
    pub fn half(most: i32) -> impl Iterator<Item = [f64; 2]> {
        let all = (0..=most).flat_map(move |j| (-most..=most).map(move |i| (i, j)));
        all.filter(|&(i, j)| j > 0 || i > 0).map(|(i, j)| [f64::from(i), f64::from(j)])
    }
}

fn reduced([mut a, mut b]: [[f64; 2]; 2]) -> [[f64; 2]; 2] {
    loop {
        if length(b) < length(a) {
            std::mem::swap(&mut a, &mut b);
        }
        let times = ((a[0] * b[0] + a[1] * b[1]) / (a[0] * a[0] + a[1] * a[1])).round();
        let shorter = [b[0] - times * a[0], b[1] - times * a[1]];
        // Rounding may make vectors of equal length alternate: only real gains count, and NaN is none.
        if length(shorter) < length(b) * (1.0 - 1e-12) {
            b = shorter;
        } else {
            return [a, b];
        }
    }
}

fn ordered([a, b]: [[f64; 2]; 2]) -> [[f64; 2]; 2] {
    let steepness = |v: [f64; 2]| v[1].abs() / length(v);
    let (first, second) = if steepness(b) < steepness(a) { (b, a) } else { (a, b) };
    let flipped = |v: [f64; 2], flip: bool| if flip { v.map(|c| -c) } else { v };
    [flipped(first, first[0] < 0.0), flipped(second, second[1] < 0.0)]
}

/// The length of a vector.
pub fn length(v: [f64; 2]) -> f64 {
    v[0].hypot(v[1])
}

/// The area spanned by two vectors, signed by their orientation.
pub fn determinant(a: [f64; 2], b: [f64; 2]) -> f64 {
    a[0] * b[1] - a[1] * b[0]
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn every_basis_of_a_lattice_gives_the_shortest_one(
            (ax, ay) in (3.0..40.0f64, -20.0..20.0f64),
            (bx, by) in (-20.0..20.0f64, 21.0..50.0f64),
            (m, n) in (-4i32..5, -4i32..5),
        ) {
            let (m, n) = (f64::from(m), f64::from(n));
            let lattice = Lattice::new([ax, ay], [bx, by]).unwrap();
            // (a, b) times a matrix of determinant 1.
            let a = [ax + m * bx, ay + m * by];
            let b = [bx + n * a[0], by + n * a[1]];
            let other = Lattice::new(a, b).unwrap();
            prop_assert!((other.cell_area() - lattice.cell_area()).abs() < 1e-7 * lattice.cell_area());
            for lattice in [lattice, other] {
                let [p, q] = lattice.basis();
                prop_assert!(p[0] >= 0.0 && q[1] >= 0.0);
                let shortest = Lattice::half(6).map(|ij| length(lattice.point(ij))).fold(f64::INFINITY, f64::min);
                prop_assert!((shortest - length(p).min(length(q))).abs() < 1e-9);
                let cosine = (p[0] * q[0] + p[1] * q[1]) / (length(p) * length(q));
                prop_assert!(cosine.abs() < 0.5 + 1e-9);
            }
        }

        #[test]
        fn the_nearest_point_is_that_of_a_dense_search(x in -90.0..90.0f64, y in -90.0..90.0f64) {
            let lattice = Lattice::new([11.0, 3.5], [-4.0, 13.0]).unwrap();
            let [i, j] = lattice.coordinates([x, y]);
            let back = lattice.point([i, j]);
            prop_assert!((back[0] - x).abs() < 1e-9 && (back[1] - y).abs() < 1e-9);
            let near = lattice.nearest([x, y]);
            let distance = |p: [f64; 2]| length([p[0] - x, p[1] - y]);
            for ij in Lattice::half(12) {
                for sign in [-1.0, 1.0] {
                    prop_assert!(distance(near) <= distance(lattice.point(ij.map(|c| sign * c))) + 1e-9);
                }
            }
        }
    }

    #[test]
    fn vectors_on_one_line_span_no_lattice() {
        assert!(Lattice::new([2.0, 1.0], [-4.0, -2.0]).is_none());
        assert!(Lattice::new([0.0, 0.0], [1.0, 2.0]).is_none());
        assert!(Lattice::new([f64::INFINITY, 0.0], [1.0, 2.0]).is_none());
        // The reduction of these never ended.
        for (w, h) in [(1e-300, 20.0), (1e300, 1e-300), (1e300, 1e300), (5e-324, 5e-324)] {
            assert!(Lattice::new([w, 0.0], [0.0, h]).is_none(), "{w}, {h}");
        }
        assert!(Lattice::new([1e-9, 0.0], [1e9, 1e9]).is_some());
        let lattice = Lattice::new([0.0, -20.0], [-30.0, 0.0]).unwrap();
        assert_eq!(lattice.basis(), [[30.0, 0.0], [0.0, 20.0]]);
    }
}
