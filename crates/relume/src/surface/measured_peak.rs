//! The brightest light of functions that are known at measured lights and interpolated in triangles between them.
//!
//! Such a function is largest at a measured light, so the directions of maxima would be those of the lights, however finely the texels
//! are tilted. A matt surface is brightest between them: a quadratic through the values at the lights around the brightest one,
//! by least squares in the plane that touches the hemisphere there, has its maximum near the normal. It is sought no farther away
//! than the nearest other light. Limits: shadows and highlights at the lights around pull the maximum as they pull any.

use super::argmax::ptm_maximum;
use crate::direction::Direction;
use crate::field::{Basis, Interpolation};
use crate::numeric::Matrix;
use crate::numeric::matrix::Qr;

/// The lights around the brightest one, itself among them.
const AROUND: usize = 13;

/// The terms of a quadratic, and the least lights that determine them well.
const TERMS: usize = 6;
const LEAST: usize = TERMS + 1;

/// A light and those around it.
struct LightsAround {
    /// Their numbers.
    members: Vec<usize>,
    /// The terms of the quadratic from their values, over the plane that touches at the light, in units of `reach`.
    terms: Matrix,
    /// Right, up and out of that plane.
    frame: [[f64; 3]; 3],
    reach: f64,
}

/// Measured lights, and the quadratics around each.
pub(super) struct MeasuredPeaks {
    lights: Vec<Direction>,
    around: Vec<Option<LightsAround>>,
}

impl MeasuredPeaks {
    /// Of a basis whose functions are interpolated in triangles between lights.
    pub fn of(basis: &Basis) -> Option<Self> {
        let lights = match basis {
            Basis::Learned(learned) => {
                let lights = learned.grid()?.lights();
                (0..lights.points().len()).map(|i| lights.direction(i)).collect()
            }
            Basis::Interpolated(table) if table.interpolation() == Interpolation::Triangles => {
                table.lights().to_vec()
            }
            _ => return None,
        };
        Some(Self::new(lights))
    }

    fn new(lights: Vec<Direction>) -> Self {
        let around = (0..lights.len()).map(|i| LightsAround::of(&lights, i)).collect();
        Self { lights, around }
    }

    /// The lights.
    pub fn lights(&self) -> &[Direction] {
        &self.lights
    }

    /// The direction of the maximum of a function of these values at the lights; of equal ones the first counts.
    pub fn maximum(&self, value: impl Fn(usize) -> f64) -> Direction {
        let (mut best, mut most) = (0, f64::NEG_INFINITY);
        for i in 0..self.lights.len() {
            let found = value(i);
            if found > most {
                (best, most) = (i, found);
            }
        }
        match &self.around[best] {
            Some(around) => around.maximum(value),
            None => self.lights[best],
        }
    }
}

impl LightsAround {
    /// `None` where too few lights determine a quadratic.
    fn of(lights: &[Direction], at: usize) -> Option<Self> {
        let mut members: Vec<usize> = (0..lights.len()).collect();
        let cosine = |i: &usize| lights[*i].dot(lights[at]);
        members.sort_by(|a, b| cosine(b).total_cmp(&cosine(a)).then(a.cmp(b)));
        members.truncate(AROUND);
        let frame = frame(lights[at]);
        let place = |i: usize| {
            let light = lights[i].to_array();
            [0, 1].map(|axis| frame[axis].iter().zip(light).map(|(a, b)| a * b).sum::<f64>())
        };
        let distance = |i: &usize| place(*i)[0].hypot(place(*i)[1]);
        // Lights behind the plane have no place in it.
        members.retain(|i| cosine(i) > 0.0);
        let reach = members.iter().skip(1).map(distance).fold(f64::INFINITY, f64::min);
        let farthest = members.iter().map(distance).fold(0.0, f64::max);
        if members.len() < LEAST || !(reach > 1e-6 && reach.is_finite()) {
            return None;
        }
        // Those that are farther count less, and the farthest still a little.
        let weight = |i: usize| (1.0 - (distance(&i) / (1.1 * farthest)).powi(2)).max(0.0);
        let row = |i: usize| {
            let [x, y] = place(i).map(|v| v / reach);
            [x * x, y * y, x * y, x, y, 1.0]
        };
        let design = Matrix::from_fn(members.len(), TERMS, |r, k| weight(members[r]) * row(members[r])[k]);
        let qr = Qr::new(&design);
        if qr.pivot_ratio() < 1e-4 {
            return None;
        }
        let inverse = qr.pseudo_inverse();
        let terms = Matrix::from_fn(TERMS, members.len(), |k, r| inverse[(k, r)] * weight(members[r]));
        Some(Self { members, terms, frame, reach })
    }

    /// The place of the maximum of the quadratic.
    fn maximum(&self, value: impl Fn(usize) -> f64) -> Direction {
        let mut quadratic = [0.0; TERMS];
        for (r, &i) in self.members.iter().enumerate() {
            let value = value(i);
            quadratic.iter_mut().enumerate().for_each(|(k, sum)| *sum += self.terms[(k, r)] * value);
        }
        let (x, y) = ptm_maximum(quadratic);
        let [x, y] = [x, y].map(|v| (v * self.reach).clamp(-1.0, 1.0));
        let z = (1.0 - x * x - y * y).max(0.0).sqrt();
        let [a, b, c] = [0, 1, 2].map(|k| x * self.frame[0][k] + y * self.frame[1][k] + z * self.frame[2][k]);
        // Beyond the horizon is on it.
        Direction::new(a, b, c.max(0.0)).unwrap_or(Direction::ZENITH)
    }
}

/// Unit vectors to the right, up, and towards a light.
fn frame(light: Direction) -> [[f64; 3]; 3] {
    let [x, y, z] = light.to_array();
    let radius = x.hypot(y);
    let (east, north) = if radius > 1e-9 { (x / radius, y / radius) } else { (1.0, 0.0) };
    // Away from the zenith, and along the horizon.
    [[east * z, north * z, -radius], [-north, east, 0.0], [x, y, z]]
}

#[cfg(test)]
mod tests {
    use super::*;

    fn bonn() -> Vec<Direction> {
        let ring = |(polar, count): (f64, u32)| {
            (0..count).map(move |j| {
                Direction::from_angles(
                    polar.to_radians(),
                    std::f64::consts::TAU * f64::from(j) / f64::from(count),
                )
            })
        };
        [(0.0, 1), (15.0, 6), (30.0, 12), (45.0, 18), (60.0, 20), (75.0, 24)]
            .into_iter()
            .flat_map(ring)
            .collect()
    }

    #[test]
    fn normals_of_a_matt_surface_are_found_between_the_measured_lights() {
        let lights = bonn();
        let peaks = MeasuredPeaks::new(lights.clone());
        let normal = Direction::fibonacci(500);
        let (mut found, mut snapped, mut count) = (0.0, 0.0, 0);
        for n in (0..500).map(normal).filter(|n| n.z() > 0.35) {
            let value = |i: usize| lights[i].dot(n).max(0.0);
            let angle = |d: Direction| d.dot(n).clamp(-1.0, 1.0).acos().to_degrees();
            let error = angle(peaks.maximum(value));
            let nearest = lights.iter().map(|l| angle(*l)).fold(f64::INFINITY, f64::min);
            assert!(error < 2.0, "{n:?}: {error} degrees");
            (found, snapped, count) = (found + error, snapped + nearest, count + 1);
        }
        let [found, snapped] = [found, snapped].map(|sum| sum / f64::from(count));
        assert!(found < 0.5 && snapped > 4.0, "{found} degrees, {snapped} at the lights");
    }

    #[test]
    fn lights_too_few_for_a_quadratic_are_their_own_maxima() {
        let few: Vec<Direction> = bonn().into_iter().take(5).collect();
        let peaks = MeasuredPeaks::new(few.clone());
        assert_eq!(peaks.maximum(|i| f64::from(u8::from(i == 3))), few[3]);
        let line: Vec<Direction> = (0..9).map(|k| Direction::from_angles(0.1 * f64::from(k), 0.3)).collect();
        let peaks = MeasuredPeaks::new(line.clone());
        assert_eq!(peaks.maximum(|i| f64::from(u8::from(i == 4))), line[4]);
    }
}
