//! The maximum of a reflectance function over the unit disk of light directions.

/// Grid points along a side of the disk in the first pass of [`maximum_by_search`].
const SEARCH_STEPS: i32 = 40;
/// Each pass of the search after the first narrows the window by this factor.
const SEARCH_ZOOM: f64 = 8.0;
const SEARCH_PASSES: i32 = 10;

/// Coefficients below this share of the largest are rounding errors.
const NEGLIGIBLE: f64 = 1e-9;
/// Newton steps on the multiplier; the iteration is monotone and converges in fewer than ten.
const MAX_NEWTON_STEPS: usize = 60;

/// The point (u, v) of the unit disk at which a biquadratic polynomial is largest; coefficients
/// in file order (u^2, v^2, uv, u, v, 1).
///
/// Malzbender, Gelb, Wolters, "Polynomial Texture Maps", SIGGRAPH 2001, section 3.3 (equations 16 and 17)
/// sets both derivatives to zero. The result is a maximum only where the form is concave, and a light only
/// where it lies inside the disk. Otherwise the maximum is on the rim, where (H - lambda I) p = -g, |p| = 1,
/// with the multiplier lambda not below the largest eigenvalue of the Hessian H: the trust-region problem of
/// Moré and Sorensen, "Computing a Trust Region Step", 1983, solved by Newton's method on 1 / |p(lambda)|. Of
/// several maxima, the one nearest the zenith is returned; of two opposite ones on the rim, either. A
/// function without any slope, or with non-finite coefficients, gives (0, 0).
pub fn ptm_maximum(coefficients: [f64; 6]) -> (f64, f64) {
    let [a, b, c, d, e, _] = coefficients;
    let scale = [a, b, c, d, e].iter().fold(0.0f64, |m, v| m.max(v.abs()));
    if !coefficients[..5].iter().all(|v| v.is_finite()) || scale == 0.0 {
        return (0.0, 0.0);
    }
    let axes = Axes::of_symmetric(2.0 * a / scale, c / scale, 2.0 * b / scale);
    let slope = axes.coordinates(d / scale, e / scale);
    let (p, q) = maximum_along_axes(axes.eigenvalues, slope);
    axes.point(p, q)
}

/// The principal axes of a symmetric 2 x 2 matrix; the axis of the larger eigenvalue comes first.
struct Axes {
    eigenvalues: (f64, f64),
    /// The first axis; the second is (-y, x).
    first: (f64, f64),
}

impl Axes {
    /// The axes of the matrix (xx, xy; xy, yy).
    fn of_symmetric(xx: f64, xy: f64, yy: f64) -> Self {
        let (mean, half) = (0.5 * (xx + yy), 0.5 * (xx - yy));
        let radius = half.hypot(xy);
        let angle = 0.5 * xy.atan2(half);
        Self { eigenvalues: (mean + radius, mean - radius), first: (angle.cos(), angle.sin()) }
    }

    fn coordinates(&self, u: f64, v: f64) -> (f64, f64) {
        let (x, y) = self.first;
        (x * u + y * v, x * v - y * u)
    }

    fn point(&self, p: f64, q: f64) -> (f64, f64) {
        let (x, y) = self.first;
        (x * p - y * q, y * p + x * q)
    }
}

/// The maximum over the unit disk of g p + 1/2 h p^2 summed over both axes, h.0 >= h.1.
fn maximum_along_axes(h: (f64, f64), g: (f64, f64)) -> (f64, f64) {
    // Inside: concave along both axes, or flat along the first without a slope there.
    let step = |h: f64, g: f64| if g.abs() <= NEGLIGIBLE { 0.0 } else { -g / h };
    let flat = h.0.abs() <= NEGLIGIBLE && g.0.abs() <= NEGLIGIBLE;
    if h.0 < -NEGLIGIBLE || flat {
        let inside = (step(h.0, g.0), step(h.1, g.1));
        if inside.0.hypot(inside.1) <= 1.0 {
            return inside;
        }
    }
    // No slope along the first axis: the multiplier may be its eigenvalue; both signs are equivalent.
    let second = step(h.1 - h.0, g.1);
    if g.0.abs() <= NEGLIGIBLE && second.abs() <= 1.0 {
        return ((1.0 - second * second).sqrt(), second);
    }
    let lambda = rim_multiplier(h, g);
    let (p, q) = (g.0 / (lambda - h.0), g.1 / (lambda - h.1));
    let length = p.hypot(q);
    (p / length, q / length)
}

/// The multiplier at which |p(lambda)| = 1, p_i = g_i / (lambda - h_i), above h.0.
fn rim_multiplier(h: (f64, f64), g: (f64, f64)) -> f64 {
    // At this start |p| >= 1; 1 / |p| is concave and increasing, so Newton's steps stay below
    // the root from there and only go up.
    let mut lambda = h.0 + g.0.abs();
    if g.0.abs() <= NEGLIGIBLE {
        lambda = lambda.max(h.1 + g.1.abs());
    }
    for _ in 0..MAX_NEWTON_STEPS {
        let (p, q) = (g.0 / (lambda - h.0), g.1 / (lambda - h.1));
        let square = p * p + q * q;
        let slope = (p * p / (lambda - h.0) + q * q / (lambda - h.1)) / square;
        let step = (square.sqrt() - 1.0) / slope;
        lambda += step;
        if step <= 1e-14 * lambda.abs() {
            break;
        }
    }
    lambda
}

/// The point of the unit disk at which any function is largest, by grids that close in on the best point so
/// far: the slow truth for the closed forms, and the method for bases without one.
pub fn maximum_by_search(value: impl Fn(f64, f64) -> f64) -> (f64, f64) {
    let (mut best, mut center, mut reach) = (value(0.0, 0.0), (0.0, 0.0), 1.0);
    for _ in 0..SEARCH_PASSES {
        let middle = center;
        for (i, j) in
            (-SEARCH_STEPS..=SEARCH_STEPS).flat_map(|j| (-SEARCH_STEPS..=SEARCH_STEPS).map(move |i| (i, j)))
        {
            let offset = |k: i32| reach * f64::from(k) / f64::from(SEARCH_STEPS);
            let (u, v) = (middle.0 + offset(i), middle.1 + offset(j));
            // Points outside are projected onto the rim, so the rim is searched as finely.
            let radius = u.hypot(v).max(1.0);
            let (u, v) = (u / radius, v / radius);
            let found = value(u, v);
            if found > best {
                (best, center) = (found, (u, v));
            }
        }
        reach /= SEARCH_ZOOM;
    }
    center
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::direction::Direction;
    use crate::field::Basis;
    use crate::numeric::random::{Purpose, Stream};

    fn value(coefficients: [f64; 6], (u, v): (f64, f64)) -> f64 {
        Basis::Ptm.weights(Direction::from_disk(u, v)).iter().zip(coefficients).map(|(w, c)| w * c).sum()
    }

    #[test]
    fn a_known_maximum_inside_is_found() {
        // 1 - (u - 0.3)^2 - 2 (v + 0.4)^2 + (u - 0.3)(v + 0.4)
        let coefficients = [-1.0, -2.0, 1.0, 0.6 + 0.4, -1.6 - 0.3, 0.0];
        let (u, v) = ptm_maximum(coefficients);
        assert!((u - 0.3).abs() < 1e-12 && (v + 0.4).abs() < 1e-12, "{u} {v}");
    }

    #[test]
    fn no_point_of_the_disk_is_brighter() {
        let mut stream = Stream::new(3, Purpose::Sample, [0]);
        for case in 0..400 {
            let mut coefficients: [f64; 6] = std::array::from_fn(|_| 2.0 * stream.unit() - 1.0);
            if case % 4 == 1 {
                coefficients[3..5].fill(0.0);
            }
            if case % 4 == 2 {
                coefficients[..3].iter_mut().for_each(|c| *c *= 1e-6);
            }
            if case % 8 == 3 {
                // Concave: a maximum inside or, with a strong slope, outside.
                coefficients = [-1.0, -1.2, 0.3, coefficients[3] * 4.0, coefficients[4] * 4.0, 0.0];
            }
            let found = ptm_maximum(coefficients);
            assert!(found.0.hypot(found.1) <= 1.0 + 1e-12);
            let truth = maximum_by_search(|u, v| value(coefficients, (u, v)));
            let (found, truth) = (value(coefficients, found), value(coefficients, truth));
            assert!((found - truth).abs() < 1e-9, "{coefficients:?}: {found} below {truth}");
        }
    }

    #[test]
    fn special_forms_have_their_maximum() {
        let near = |c: [f64; 6], (u, v): (f64, f64)| {
            let found = ptm_maximum(c);
            assert!((found.0 - u).hypot(found.1 - v) < 1e-7, "{c:?}: {found:?}");
        };
        near([0.0; 6], (0.0, 0.0));
        near([f64::NAN, 0.0, 0.0, 1.0, 0.0, 0.0], (0.0, 0.0));
        near([0.0, 0.0, 0.0, f64::INFINITY, 0.0, 0.0], (0.0, 0.0));
        near([0.0, 0.0, 0.0, 3.0, 4.0, 1.0], (0.6, 0.8));
        // A ridge along v: the point nearest to the zenith.
        near([-1.0, 0.0, 0.0, 0.8, 0.0, 0.0], (0.4, 0.0));
        near([-1.0, -1.0, 0.0, 1e30, 0.0, 0.0], (1.0, 0.0));
        near([-1e-30, -1e-30, 0.0, 1e-30, 0.0, 0.0], (0.5, 0.0));
        // The hard case: convex along u without a slope there, a weak slope along v.
        let (u, v) = ptm_maximum([1.0, -1.0, 0.0, 0.0, 1.0, 0.0]);
        assert!((v - 0.25).abs() < 1e-12 && (u.hypot(v) - 1.0).abs() < 1e-12);
    }
}
