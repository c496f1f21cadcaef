//! The light of every tangent frame, projected on the functions of a hemisphere.
//!
//! For a normal n, the light of the hemisphere is L(l) ≈ sum_p m_p H_p(l) in a frame chosen for n. Turning a frame about
//! its normal by an angle mixes the functions of the same m by cos and sin of m times the angle: exactly, so a table
//! over normals alone serves all frames. Between the normals of the table, the tangent is carried along the shortest
//! arc to each of the four around it, and what they give is interpolated.

use super::super::vector::Vec3;
use super::cells::LightCell;
use super::grid::{Covered, OctahedralGrid};
use super::hemisphere::HemisphereSpace;
use crate::error::Result;
use crate::job::{Held, Job};
use crate::parallel;

/// The normals of the table: 1.6 degrees apart on average, so that the fade at the horizon of a small sun spans several.
const GRID: OctahedralGrid = OctahedralGrid::new(128, Covered::Sphere);
/// Normals of one task.
const TASK: usize = 129;

/// The frame of a texture at a point of an object, in world space; orthonormal.
#[derive(Debug, Clone, Copy)]
pub struct TangentFrame {
    pub tangent: Vec3,
    pub bitangent: Vec3,
    pub normal: Vec3,
}

impl TangentFrame {
    /// Some frame with a normal.
    fn of_normal(normal: Vec3) -> Self {
        let tangent = normal.any_perpendicular();
        Self { tangent, bitangent: normal.cross(tangent), normal }
    }

    /// The components of a world vector.
    pub fn components(&self, v: Vec3) -> [f64; 3] {
        [v.dot(self.tangent), v.dot(self.bitangent), v.dot(self.normal)]
    }
}

/// The moments m_p of red, green and blue for each normal of [`GRID`].
#[derive(Debug)]
pub(super) struct FrameTable {
    frames: Vec<TangentFrame>,
    degree: usize,
    moments: Vec<f32>,
    _held: Held,
}

/// Adds up the moments of the lights in a frame: three colours of each function.
pub(super) fn moments_of(space: &HemisphereSpace, cells: &[LightCell], frame: &TangentFrame) -> Vec<f64> {
    let mut values = vec![0.0; space.len()];
    let mut sums = vec![0.0; 3 * space.len()];
    for cell in cells {
        let local = frame.components(cell.direction);
        let share = space.share(local[2]);
        if share == 0.0 {
            continue;
        }
        space.values_into(local, &mut values);
        let power = cell.power.map(|p| share * p);
        for (sums, value) in sums.chunks_exact_mut(3).zip(&values) {
            sums.iter_mut().zip(power).for_each(|(sum, power)| *sum += power * value);
        }
    }
    sums
}

/// How a frame is turned against another of the same normal.
#[derive(Debug, Clone, Copy)]
pub(super) struct FrameTurn {
    /// Cosine and sine of the azimuth of its tangent in the other frame.
    cos: f64,
    sin: f64,
    /// Whether its bitangent lies on the other side.
    mirrored: bool,
}

impl FrameTurn {
    /// How a frame is turned against another of a normal nearby: its tangent is carried there along the shortest arc.
    pub fn against(own: &TangentFrame, frame: &TangentFrame) -> Self {
        let both = own.normal + frame.normal;
        let share = frame.tangent.dot(own.normal) / (1.0 + own.normal.dot(frame.normal));
        let carried = frame.tangent - both * share;
        Self {
            cos: carried.dot(own.tangent),
            sin: carried.dot(own.bitangent),
            mirrored: frame.normal.cross(frame.tangent).dot(frame.bitangent) < 0.0,
        }
    }

    /// Adds the moments in the frame, given those in the other, times a weight: those of each m are mixed in pairs.
    pub fn add(self, degree: usize, weight: f64, from: &[f32], out: &mut [f32]) {
        let Self { cos, sin, mirrored } = self;
        let (first, rest) = from.split_at(3 * (degree + 1));
        let (first_out, rest_out) = out.split_at_mut(3 * (degree + 1));
        first_out.iter_mut().zip(first).for_each(|(out, m)| *out += weight as f32 * m);
        let (mut c, mut s) = (cos, sin);
        let sign = if mirrored { -1.0 } else { 1.0 };
        let mut pairs = rest.chunks_exact(6).zip(rest_out.chunks_exact_mut(6));
        for m in 1..=degree {
            let (along, aside) = ((weight * c) as f32, (weight * s) as f32);
            for (from, out) in pairs.by_ref().take(degree + 1 - m) {
                for k in 0..3 {
                    out[k] += along * from[k] + aside * from[k + 3];
                    out[k + 3] += sign * (along * from[k + 3] - aside * from[k]);
                }
            }
            (c, s) = (c * cos - s * sin, s * cos + c * sin);
        }
    }
}

impl FrameTable {
    /// The bytes of a table.
    fn bytes(space: &HemisphereSpace) -> u64 {
        (GRID.len() * (3 * space.len() * size_of::<f32>() + size_of::<TangentFrame>())) as u64
    }

    pub fn new(space: &HemisphereSpace, cells: &[LightCell], job: &Job) -> Result<Self> {
        let held = job.hold("the light of the environment for all frames", Self::bytes(space))?;
        let frames: Vec<TangentFrame> =
            (0..GRID.len()).map(|vertex| TangentFrame::of_normal(GRID.direction(vertex))).collect();
        let stride = 3 * space.len();
        let mut moments = vec![0.0f32; GRID.len() * stride];
        let tasks = moments.chunks_mut(TASK * stride).zip(frames.chunks(TASK));
        parallel::try_for_each(tasks, |(out, frames)| {
            job.proceed()?;
            for (out, frame) in out.chunks_exact_mut(stride).zip(frames) {
                let sums = moments_of(space, cells, frame);
                out.iter_mut().zip(sums).for_each(|(out, sum)| *out = sum as f32);
            }
            Ok(())
        })?;
        Ok(Self { frames, degree: space.degree(), moments, _held: held })
    }

    /// The moments in a frame: three colours of each function.
    pub fn moments_into(&self, frame: &TangentFrame, out: &mut Vec<f32>) {
        let stride = 3 * (self.degree + 1) * (self.degree + 1);
        out.clear();
        out.resize(stride, 0.0);
        for (vertex, weight) in GRID.around(frame.normal) {
            let from = &self.moments[vertex * stride..][..stride];
            FrameTurn::against(&self.frames[vertex], frame).add(self.degree, weight, from, out);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::super::horizon::AttachedShadow;
    use super::super::Environment;
    use super::super::cells::cells;
    use super::super::hemisphere::HorizonEdge;
    use super::*;

    #[test]
    fn interpolated_frames_have_the_moments_of_their_own_sums() {
        let job = Job::default();
        let space = HemisphereSpace::new(3, HorizonEdge::Faded(AttachedShadow::Smooth));
        let lights = cells(&Environment::sky(&job).unwrap(), 256);
        let table = FrameTable::new(&space, &lights, &job).unwrap();
        let mut found = Vec::new();
        let (mut errors, mut squares) = (0.0, 0.0);
        for i in 0..300 {
            let (t, a) = (f64::from(i) / 300.0, 2.4 * f64::from(i));
            let ring = (1.0 - (1.0 - 2.0 * t) * (1.0 - 2.0 * t)).sqrt();
            let of_normal = TangentFrame::of_normal(Vec3::new(ring * a.cos(), ring * a.sin(), 1.0 - 2.0 * t));
            let tangent = of_normal.tangent * (1.7 * a).cos() + of_normal.bitangent * (1.7 * a).sin();
            let handed = if i % 2 == 0 { 1.0 } else { -1.0 };
            let bitangent = of_normal.normal.cross(tangent) * handed;
            let frame = TangentFrame { tangent, bitangent, ..of_normal };
            table.moments_into(&frame, &mut found);
            for (found, truth) in found.iter().zip(moments_of(&space, &lights, &frame)) {
                errors += (f64::from(*found) - truth).powi(2);
                squares += truth * truth;
            }
        }
        let relative = (errors / squares).sqrt();
        assert!(relative < 0.02, "{relative}");
    }
}
