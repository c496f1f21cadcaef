//! The fast form: what a texture reflects of an environment, as products of tables.

use super::super::highlight::Specular;
use super::super::material::{LitTexture, Lookup};
use super::super::vector::Vec3;
use super::Environment;
use super::cells::cells;
use super::frames::{FrameTable, TangentFrame};
use super::hemisphere::{HemisphereSpace, HorizonEdge};
use super::reflections::ReflectionMap;
use super::response::{self, NodeResponse, ViewTable};
use crate::direction::Direction;
use crate::error::Result;
use crate::field::{Basis, PlaneLayout};
use crate::job::Job;
use crate::space::{Space, linear_from_srgb};

/// Lights that stand for the environment.
pub(super) const CELLS: usize = 2048;
/// Parts of 0..1 between which decoding is linear: exact to 1e-7.
const DECODING_STEPS: usize = 4096;

/// An environment prepared for one texture.
#[derive(Debug)]
pub struct Prefiltered {
    frames: FrameTable,
    response: EnvironmentResponse,
    reflections: Option<ReflectionMap>,
}

/// What texels reflect of the light of a hemisphere.
#[derive(Debug)]
pub(super) enum EnvironmentResponse {
    /// Colours on a matt surface.
    Matt(Vec<f32>),
    /// Linear functions.
    Linear(ViewTable),
    /// Encoded functions.
    Encoded(NodeResponse, DecodingTable),
}

/// The sRGB decoding as a table.
#[derive(Debug)]
pub(super) struct DecodingTable(Vec<f32>);

impl DecodingTable {
    fn new() -> Self {
        Self((0..=DECODING_STEPS).map(|i| linear_from_srgb(i as f32 / DECODING_STEPS as f32)).collect())
    }

    /// Linear light of an encoded value; none below zero.
    fn linear(&self, value: f32) -> f32 {
        let place = value * DECODING_STEPS as f32;
        if place.is_nan() || place <= 0.0 {
            return 0.0;
        }
        let low = place as usize;
        match self.0.get(low..low + 2) {
            Some(ends) => ends[0] + (ends[1] - ends[0]) * (place - low as f32),
            None => linear_from_srgb(value),
        }
    }
}

/// The degree of the functions of a hemisphere that hold those of a basis: exactly for colours and the polynomials of
/// texture maps, whose decoded values have more detail, and nearly for others.
pub(super) fn degree(basis: &Basis, space: Space) -> usize {
    match (basis, space) {
        (Basis::Constant, _) => 0,
        (Basis::Ptm, Space::Linear) => 2,
        (Basis::Ptm, Space::Srgb) => 4,
        (Basis::Polynomial(polynomial), Space::Linear) => polynomial.degree() as usize,
        _ => 6,
    }
}

impl EnvironmentResponse {
    /// That of a basis, and the functions of the hemisphere on which it is projected.
    pub fn of_basis(
        basis: &Basis,
        space: Space,
        edge: HorizonEdge,
        job: &Job,
    ) -> Result<(HemisphereSpace, Self)> {
        let hemisphere = HemisphereSpace::new(degree(basis, space), edge);
        let response = match space {
            Space::Linear => Self::Linear(response::projected(basis, &hemisphere, job)?),
            Space::Srgb => Self::Encoded(response::at_nodes(basis, &hemisphere, job)?, DecodingTable::new()),
        };
        Ok((hemisphere, response))
    }

    /// The weights of a texel's coefficients in one frame, for many texels: three for each function of a linear basis,
    /// or for each node of an encoded one.
    pub fn weights_into(
        &self,
        moments: &[f32],
        view: Direction,
        room: &mut Vec<f32>,
        out: &mut Vec<[f32; 3]>,
    ) {
        let matrix = match self {
            Self::Matt(matrix) => matrix,
            Self::Linear(table) => table.of(view, room),
            Self::Encoded(nodes, _) => &nodes.light[..],
        };
        out.clear();
        out.extend(matrix.chunks_exact(moments.len() / 3).map(|row| product(row, moments)));
    }

    /// The colour of a texel seen from a direction.
    pub fn color(
        &self,
        weights: &[[f32; 3]],
        texel: &TexelValues<'_>,
        view: Direction,
        room: &mut Vec<f32>,
    ) -> [f64; 3] {
        let mut sum = [0.0f32; 3];
        match self {
            Self::Matt(_) | Self::Linear(_) => {
                for (c, sum) in sum.iter_mut().enumerate() {
                    let (weights, coefficients) = texel.of_channel(c, weights);
                    *sum = weights.iter().zip(coefficients).map(|(w, v)| w[c] * v).sum();
                }
            }
            Self::Encoded(nodes, decoding) => {
                let functions = nodes.functions.of(view, room);
                let length = functions.len() / weights.len();
                for (functions, weight) in functions.chunks_exact(length).zip(weights) {
                    let mut light = [0.0; 3];
                    for (c, light) in light.iter_mut().enumerate().take(texel.layout.channels()) {
                        let (functions, own) = texel.of_channel(c, functions);
                        *light = decoding.linear(functions.iter().zip(own).map(|(f, v)| f * v).sum());
                    }
                    let last = texel.layout.channels() - 1;
                    (0..3).for_each(|c| sum[c] += weight[c] * light[c.min(last)]);
                }
            }
        }
        sum.map(|v| f64::from(v).max(0.0))
    }
}

/// The coefficients of a texel.
#[derive(Debug, Clone, Copy)]
pub(super) struct TexelValues<'a> {
    /// Of one or three channels, without products.
    pub layout: &'a PlaneLayout,
    /// The length of the basis; 1 for colours.
    pub functions: usize,
    pub values: &'a [f32],
}

impl<'a> TexelValues<'a> {
    /// What belongs to a colour, of what there is for each function (and channel) of a basis; and its coefficients.
    fn of_channel<'b, T>(&self, color: usize, all: &'b [T]) -> (&'b [T], &'a [f32]) {
        let (channel, n) = (color.min(self.layout.channels() - 1), self.functions);
        let own = &self.values[self.layout.function_plane(channel, n)..][..n];
        (self.layout.weights(channel, n, all), own)
    }
}

/// A row of the matrix times the moments of each colour.
fn product(row: &[f32], moments: &[f32]) -> [f32; 3] {
    let mut sum = [0.0; 3];
    for (a, m) in row.iter().zip(moments.chunks_exact(3)) {
        (0..3).for_each(|c| sum[c] += a * m[c]);
    }
    sum
}

impl Prefiltered {
    /// For a texture and, where it has normals, its highlights.
    ///
    /// # Errors
    /// When memory is short or the job is cancelled.
    pub fn new(
        environment: &Environment,
        material: &LitTexture,
        highlights: Option<&Specular>,
        job: &Job,
    ) -> Result<Self> {
        let lights = cells(environment, CELLS);
        let edge = HorizonEdge::Faded(material.attached_shadow());
        let (space, response) = match material.functions() {
            Some((basis, space)) => EnvironmentResponse::of_basis(basis, space, edge, job)?,
            None => {
                let space = HemisphereSpace::new(1, edge);
                let matt = response::matt(&space);
                (space, EnvironmentResponse::Matt(matt))
            }
        };
        let frames = FrameTable::new(&space, &lights, job)?;
        let reflections = highlights.map(|specular| ReflectionMap::new(&lights, specular));
        Ok(Self { frames, response, reflections })
    }

    /// The light reflected to the viewer by looked-up texels of a material in a frame.
    pub fn reflected(
        &self,
        material: &LitTexture,
        lookup: &mut Lookup,
        frame: &TangentFrame,
        to_viewer: Vec3,
    ) -> [f64; 3] {
        let [x, y, _] = frame.components(to_viewer);
        let view = Direction::from_disk(x, y);
        let Lookup { values, moments, matrix, products, .. } = lookup;
        self.frames.moments_into(frame, moments);
        self.response.weights_into(moments, view, matrix, products);
        let functions = material.functions().map_or(1, |(basis, _)| basis.len());
        let texel = TexelValues { layout: material.layout(), functions, values };
        let color = self.response.color(products, &texel, view, matrix);
        let normal = material.normal(values).and_then(|n| Vec3::from(n).unit());
        match (&self.reflections, normal) {
            (Some(reflections), Some(Vec3 { x, y, z })) => {
                let normal = frame.tangent * x + frame.bitangent * y + frame.normal * z;
                let light = reflections.highlight(normal, to_viewer);
                std::array::from_fn(|c| color[c] + light[c])
            }
            _ => color,
        }
    }
}
