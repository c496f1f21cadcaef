//! Noise as shaders compute it: planes of normal values, tables that restore the values, and their functions.
//!
//! Under a given light the colour of a texel is linear in the values of its planes, so a shader needs no more than the
//! coefficients of the mean and of each plane.

use super::header::ShareNoise;
use super::planes::{self, PlaneDepth, SharedPlanes};
use super::{ShareFiles, ShareHeader, shared_basis};
use crate::error::Result;
use crate::field::ReflectanceField;
use crate::job::Job;
use crate::planes::Planes;

/// What noise is made from.
#[derive(Debug)]
pub struct NoiseParts<'a> {
    /// The planes of the exemplar as normal values.
    pub normals: &'a Planes,
    /// For each plane its values at evenly spaced normal values from -`reach` to `reach`.
    pub tables: Vec<&'a [f32]>,
    /// The largest normal value of a table.
    pub reach: f32,
    /// The side of a triangle in texels.
    pub side: f64,
    /// The key under which the vertices are hashed.
    pub key: u64,
    /// The coefficients of the mean, and then what a unit of each plane adds to them.
    pub functions: &'a [Vec<f32>],
}

impl ShareFiles {
    /// The files of noise whose functions are like those of a field, coefficients of one channel or three.
    ///
    /// # Errors
    /// Memory, and a cancelled job.
    pub fn of_noise(
        parts: &NoiseParts,
        like: &ReflectanceField,
        title: &str,
        depth: PlaneDepth,
        mm_per_texel: Option<f64>,
        job: &Job,
    ) -> Result<Self> {
        let SharedPlanes { groups, mut files, error } =
            SharedPlanes::symmetric(parts.normals, parts.reach, depth, job)?;
        let basis = shared_basis(like, &mut files, job)?;
        let names = ["tables.f32.gz", "functions.f32.gz"].map(str::to_owned);
        files.push((names[0].clone(), planes::floats(parts.tables.iter().copied().flatten())));
        files.push((names[1].clone(), planes::floats(parts.functions.iter().flatten())));
        let [tables, functions] = names;
        let noise = ShareNoise {
            planes: parts.normals.count(),
            side: parts.side,
            key: [parts.key as u32, (parts.key >> 32) as u32],
            reach: parts.reach,
            entries: parts.tables[0].len(),
            tables,
            functions,
        };
        let header = ShareHeader {
            size: [parts.normals.size().width, parts.normals.size().height],
            planes: groups,
            error,
            mm_per_texel,
            noise: Some(noise),
            ..ShareHeader::empty(title, like, basis)
        };
        Ok(Self { header, files })
    }
}
