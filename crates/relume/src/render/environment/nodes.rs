//! An environment as the lamps of each tangent frame, for shaders.
//!
//! A texel reflects 1/pi ∫ f(l) L(l) dl = sum_j f(l_j) sum_p F_jp m_p ([`FrameLamps`]). The moments m_p depend on the
//! frame, and here on its normal alone, since every normal has one frame: the x axis carried along the shortest arc from the
//! nearer of the poles +z and -z. Lamps of a normal are turned from there into the frame of the texture; where lamps belong to
//! that frame, the moments are turned instead.
//!
//! Moments are known at the vertices of two octahedral grids, one for each half of the sphere, and are bilinear between:
//! within a half the frames turn smoothly.

use super::super::horizon::AttachedShadow;
use super::super::vector::Vec3;
use super::Environment;
use super::cells::{LightCell, cells};
use super::flat;
use super::frames::{FrameTurn, TangentFrame, moments_of};
use super::grid::{Covered, OctahedralGrid};
use super::hemisphere::{HemisphereSpace, HorizonEdge};
use super::lamps::{FrameLamps, LampKind};
use super::prefiltered::{self, degree};
use crate::error::Result;
use crate::field::Basis;
use crate::job::Job;
use crate::parallel;
use crate::space::Space;

/// The normals of a half of the sphere: three degrees apart on average.
const GRID: OctahedralGrid = OctahedralGrid::new(48, Covered::UpperHemisphere);

/// The light of an environment for the textures of one basis.
#[derive(Debug, Clone, PartialEq)]
pub struct EnvironmentNodes {
    /// Unit vectors of the lamps in the frame of a normal, or of the texture.
    pub nodes: Vec<[f64; 3]>,
    /// For each lamp the factors of the moments.
    pub factors: Vec<f32>,
    /// In which frame the lamps are.
    pub kind: LampKind,
    /// Vertices along a side of the grids.
    pub side: usize,
    /// For the upper half of the normals, then the lower one: for each moment, row after row, red, green and blue. The place of
    /// a normal of the lower half is that of its mirror image.
    pub moments: Vec<f32>,
    /// The lamps for the texture itself, x right and y up, where light counts down to the horizon without a fade.
    pub flat_nodes: Vec<[f64; 3]>,
    /// The light of these.
    pub flat_light: Vec<[f32; 3]>,
}

impl EnvironmentNodes {
    /// For the values of a basis, in a space.
    ///
    /// # Errors
    /// When memory is short or the job is cancelled.
    pub fn new(environment: &Environment, basis: &Basis, space: Space, job: &Job) -> Result<Self> {
        let hemisphere =
            HemisphereSpace::new(degree(basis, space), HorizonEdge::Faded(AttachedShadow::of(basis)));
        Self::of_lights(
            (basis, space),
            &hemisphere,
            &cells(environment, prefiltered::CELLS),
            environment,
            job,
        )
    }

    fn of_lights(
        (basis, values): (&Basis, Space),
        space: &HemisphereSpace,
        lights: &[LightCell],
        environment: &Environment,
        job: &Job,
    ) -> Result<Self> {
        let FrameLamps { kind, directions, factors } = FrameLamps::of(basis, values, space);
        let moments = moments(space, lights, job)?;
        let (flat_nodes, flat_light) = flat_lamps(environment, (basis, values), space.degree());
        let nodes = directions.iter().map(|direction| direction.to_array()).collect();
        Ok(Self { nodes, factors, kind, side: GRID.side() + 1, moments, flat_nodes, flat_light })
    }

    /// The number of moments of a frame.
    pub fn functions(&self) -> usize {
        self.factors.len() / self.nodes.len()
    }

    /// The lamps of a frame as shaders find them: directions in this frame, with red, green and blue.
    pub fn lamps(&self, frame: &TangentFrame) -> Vec<([f64; 3], [f64; 3])> {
        let normal = frame.normal;
        let half = usize::from(normal.z < 0.0);
        let mut moments = vec![0.0; 3 * self.functions()];
        for (vertex, weight) in GRID.around(Vec3::new(normal.x, normal.y, normal.z.abs())) {
            for (p, moment) in moments.chunks_exact_mut(3).enumerate() {
                let from = ((half * self.functions() + p) * GRID.len() + vertex) * 3;
                (0..3).for_each(|c| moment[c] += weight as f32 * self.moments[from + c]);
            }
        }
        let own = frame_of(normal);
        if self.kind != LampKind::Normal {
            moments = self.turned(&moments, &own, frame);
        }
        let rows = self.factors.chunks_exact(self.functions());
        let lamp = |(&[x, y, z], row): (&[f64; 3], &[f32])| {
            let direction = match self.kind {
                LampKind::Texture | LampKind::Measured => [x, y, z],
                LampKind::Normal => frame.components(own.tangent * x + own.bitangent * y + own.normal * z),
            };
            (direction, light(row, &moments))
        };
        self.nodes.iter().zip(rows).map(lamp).collect()
    }

    /// The moments in a frame, given those in another of the same normal.
    fn turned(&self, moments: &[f32], own: &TangentFrame, frame: &TangentFrame) -> Vec<f32> {
        let degree = self.functions().isqrt() - 1;
        let mut out = vec![0.0; moments.len()];
        FrameTurn::against(own, frame).add(degree, 1.0, moments, &mut out);
        out
    }
}

/// The light of a lamp with a row of factors.
fn light(row: &[f32], moments: &[f32]) -> [f64; 3] {
    let sum = |c: usize| row.iter().zip(moments.chunks_exact(3)).map(|(f, m)| f64::from(f * m[c])).sum();
    std::array::from_fn(sum)
}

/// The frame of a normal: the x axis carried from the nearer pole.
fn frame_of(normal: Vec3) -> TangentFrame {
    let pole = Vec3::new(0.0, 0.0, if normal.z < 0.0 { -1.0 } else { 1.0 });
    let tangent = Vec3::new(1.0, 0.0, 0.0) - (normal + pole) * (normal.x / (1.0 + normal.z.abs()));
    TangentFrame { tangent, bitangent: normal.cross(tangent), normal }
}

fn moments(hemisphere: &HemisphereSpace, lights: &[LightCell], job: &Job) -> Result<Vec<f32>> {
    let (count, vertices) = (hemisphere.len(), GRID.len());
    job.check_bytes("the light of the environment for all frames", (2 * 8 * 3 * count * vertices) as u64)?;
    let of_normals = parallel::try_map(0..2 * vertices, |index| {
        job.proceed()?;
        let Vec3 { x, y, z } = GRID.direction(index % vertices);
        let normal = Vec3::new(x, y, if index < vertices { z } else { -z });
        // On the border the sign of zero names the half.
        let pole = if index < vertices { 1.0 } else { -1.0 };
        let toward = Vec3::new(x, y, z.max(f64::MIN_POSITIVE) * pole);
        let frame = TangentFrame { normal, ..frame_of(toward) };
        Ok(moments_of(hemisphere, lights, &frame))
    })?;
    let mut moments = Vec::with_capacity(2 * 3 * count * vertices);
    for half in of_normals.chunks_exact(vertices) {
        for p in 0..count {
            moments.extend(half.iter().flat_map(|all| &all[3 * p..3 * p + 3]).map(|&m| m as f32));
        }
    }
    Ok(moments)
}

/// The lamps of the texture itself.
fn flat_lamps(
    environment: &Environment,
    (basis, values): (&Basis, Space),
    degree: usize,
) -> (Vec<[f64; 3]>, Vec<[f32; 3]>) {
    let hemisphere = HemisphereSpace::new(degree, HorizonEdge::Sharp);
    let frame = frame_of(Vec3::new(0.0, 0.0, 1.0));
    let moments: Vec<f32> = moments_of(&hemisphere, &cells(environment, flat::CELLS), &frame)
        .into_iter()
        .map(|m| m as f32)
        .collect();
    let FrameLamps { directions, factors, .. } = FrameLamps::of(basis, values, &hemisphere);
    let rows = factors.chunks_exact(hemisphere.len());
    let lights = rows.map(|row| light(row, &moments).map(|v| v as f32)).collect();
    (directions.iter().map(|direction| direction.to_array()).collect(), lights)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::field::basis::learned_example;
    use crate::render::environment::prefiltered::EnvironmentResponse;

    /// What functions reflect through lamps, against the sums over the environment in the same frames.
    #[test]
    fn lamps_light_functions_as_their_moments_do() {
        let job = Job::default();
        let sky = Environment::sky(&job).unwrap();
        for basis in [Basis::Ptm, Basis::Constant, Basis::Learned(learned_example(20, 12, 4))] {
            let space = Space::Linear;
            let (hemisphere, response) = EnvironmentResponse::of_basis(
                &basis,
                space,
                HorizonEdge::Faded(AttachedShadow::of(&basis)),
                &job,
            )
            .unwrap();
            let lights = cells(&sky, 128);
            let table =
                EnvironmentNodes::of_lights((&basis, space), &hemisphere, &lights, &sky, &job).unwrap();
            let (mut room, mut truth, mut values) = (Vec::new(), Vec::new(), vec![0.0; basis.len()]);
            let (mut errors, mut squares) = (0.0, 0.0);
            for i in 0..60 {
                let (z, a) = (1.0 - 2.0 * (f64::from(i) + 0.5) / 60.0, 2.4 * f64::from(i));
                let ring = (1.0 - z * z).sqrt();
                let normal = Vec3::new(ring * a.cos(), ring * a.sin(), z);
                let own = frame_of(normal);
                let tangent = own.tangent * (1.7 * a).cos() + own.bitangent * (1.7 * a).sin();
                let hand = if i % 2 == 0 { 1.0 } else { -1.0 };
                let frame = TangentFrame { tangent, bitangent: normal.cross(tangent) * hand, normal };
                let moments: Vec<f32> =
                    moments_of(&hemisphere, &lights, &frame).into_iter().map(|m| m as f32).collect();
                response.weights_into(&moments, crate::direction::Direction::ZENITH, &mut room, &mut truth);
                let mut found = vec![[0.0; 3]; basis.len()];
                for ([x, y, _], color) in table.lamps(&frame) {
                    let light = crate::direction::Direction::from_disk(x, y);
                    basis.weights_into(crate::direction::Directions::lit_from(light), &mut values);
                    for (sum, value) in found.iter_mut().zip(&values) {
                        (0..3).for_each(|c| sum[c] += value * color[c]);
                    }
                }
                for (found, truth) in found.iter().flatten().zip(truth.iter().flatten()) {
                    errors += (found - f64::from(*truth)).powi(2);
                    squares += f64::from(*truth).powi(2);
                }
            }
            let relative = (errors / squares).sqrt();
            // Between normals three degrees apart, under lamps without extent, which are the hardest.
            assert!(relative < 0.03, "{}: {relative}", basis.name());
        }
    }
}
