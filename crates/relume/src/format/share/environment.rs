//! Light from all around as readers find it on a graphics card: the lamps of each normal
//! ([`EnvironmentNodes`]).
//!
//! A gzip file of little-endian numbers. First floats: the unit vectors of the lamps; for each lamp the factors of the
//! moments; the lamps of the texture itself, seen flat, and their light. Then half floats: for both halves of the
//! sphere, for each moment, row after row, red, green and blue, to be multiplied by the scale of the header.

use half::f16;

use super::header::ShareEnvironment;
use super::planes::compressed;
use crate::error::Result;
use crate::field::ReflectanceField;
use crate::job::Job;
use crate::render::{Environment, EnvironmentNodes};

const FILE_NAME: &str = "environment.gz";
/// The greatest half of a file: far from the greatest that there is.
const MOST: f32 = 1024.0;

/// The header's entry of an environment for a field, and its file.
pub(super) fn shared(
    environment: &Environment,
    field: &ReflectanceField,
    files: &mut Vec<(String, Vec<u8>)>,
    job: &Job,
) -> Result<ShareEnvironment> {
    let made = EnvironmentNodes::new(environment, field.basis(), field.space(), job)?;
    let scale = made.moments.iter().fold(f32::MIN_POSITIVE, |most, m| most.max(m.abs())) / MOST;
    files.push((FILE_NAME.to_owned(), compressed(&bytes(&made, scale))));
    Ok(ShareEnvironment {
        file: FILE_NAME.to_owned(),
        nodes: made.nodes.len(),
        functions: made.functions(),
        lamps: made.kind,
        side: made.side,
        scale,
    })
}

fn bytes(made: &EnvironmentNodes, scale: f32) -> Vec<u8> {
    let directions = |nodes: &[[f64; 3]]| nodes.iter().flatten().map(|&v| v as f32).collect::<Vec<_>>();
    let lamps = made.flat_light.iter().flatten().copied().collect();
    let floats = [directions(&made.nodes), made.factors.clone(), directions(&made.flat_nodes), lamps];
    let mut bytes: Vec<u8> = floats.iter().flatten().flat_map(|v| v.to_le_bytes()).collect();
    bytes.extend(made.moments.iter().flat_map(|m| f16::from_f32(m / scale).to_le_bytes()));
    bytes
}
