//! `.bsdf`: the tables of an RGL BRDF in a tensor file, in RGB or spectral.

use super::tensor::{TensorField, TensorFile};
use crate::brdf::{RglBrdf, RglTables, TableShape, WarpTables, rgb_weights};
use crate::error::{Error, Result};
use crate::job::Job;
use crate::memory;

/// Wavelengths in nm beyond which eyes see little; spectra that end before them are continued by their ends.
const VISIBLE: [f32; 2] = [400.0, 700.0];

/// The BRDF in the bytes of a file.
pub(super) fn decode(bytes: &[u8], job: &Job) -> Result<RglBrdf> {
    let file = TensorFile::read(bytes)?;
    let table = |name: &str| {
        let field = file.field(name, 2)?;
        let shape = TableShape { width: field.shape[1], height: field.shape[0], slices: 1 };
        Ok((shape, field.floats(job)?))
    };
    let (azimuths, polars) = (file.field("phi_i", 1)?.floats(job)?, file.field("theta_i", 1)?.floats(job)?);
    let visible = file.field("vndf", 4)?;
    let slices = slices_of("vndf", visible, [azimuths.len(), polars.len()])?;
    let shape = TableShape { width: visible.shape[3], height: visible.shape[2], slices };
    let visible = WarpTables::new("vndf", shape, visible.floats(job)?, job)?;
    let colors = colors(&file, [azimuths.len(), polars.len()], job)?;
    let scaled = file.field("jacobian", 1)?.is_set();
    RglBrdf::new(RglTables {
        azimuths,
        polars,
        distribution: table("ndf")?,
        areas: table("sigma")?,
        visible,
        colors,
        scaled,
    })
}

fn slices_of(name: &str, field: &TensorField, [azimuths, polars]: [usize; 2]) -> Result<usize> {
    if field.shape[..2] == [azimuths, polars] {
        return Ok(azimuths * polars);
    }
    Err(Error::invalid(format!(
        "array '{name}' of the BRDF has the shape {:?}: expected it to begin with {azimuths} azimuths and {polars} polar \
         angles",
        field.shape
    )))
}

/// Red, green and blue, from the array of that name or from spectra.
fn colors(file: &TensorFile, angles: [usize; 2], job: &Job) -> Result<(TableShape, [Vec<f32>; 3])> {
    let name = if file.find("rgb").is_some() { "rgb" } else { "spectra" };
    let field = file.field(name, 5)?;
    let shape =
        TableShape { width: field.shape[4], height: field.shape[3], slices: slices_of(name, field, angles)? };
    let weights = match name {
        "rgb" => vec![[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]],
        _ => weights(file, job)?,
    };
    if field.shape[2] != weights.len() {
        return Err(Error::invalid(format!(
            "array '{name}' of the BRDF has {} channels: expected {}",
            field.shape[2],
            weights.len()
        )));
    }
    let values = field.floats(job)?;
    let (size, samples) = (shape.slice(), weights.len());
    let texels = values.len() / samples;
    let mut planes: [Vec<f32>; 3] = Default::default();
    job.check_bytes("the colours of the BRDF", 12 * texels as u64)?;
    for (c, plane) in planes.iter_mut().enumerate() {
        *plane = memory::with_capacity("the colours of the BRDF", texels)?;
        for slice in values.chunks_exact((size * samples).max(1)) {
            job.proceed()?;
            let sum =
                |i: usize| (0..samples).map(|s| weights[s][c] * f64::from(slice[s * size + i])).sum::<f64>();
            plane.extend((0..size).map(|i| sum(i) as f32));
        }
    }
    Ok((shape, planes))
}

/// The weights of wavelengths in red, green and blue.
fn weights(file: &TensorFile, job: &Job) -> Result<Vec<[f64; 3]>> {
    let wavelengths = file.field("wavelengths", 1)?.floats(job)?;
    let (Some(&first), Some(&last)) = (wavelengths.first(), wavelengths.last()) else {
        return Err(Error::invalid("the array 'wavelengths' of the BRDF is empty: the file is damaged"));
    };
    if wavelengths.iter().any(|w| !w.is_finite()) || wavelengths.windows(2).any(|pair| pair[0] >= pair[1]) {
        return Err(Error::invalid("the wavelengths of the BRDF do not ascend: the file is damaged"));
    }
    if first > VISIBLE[0] || last < VISIBLE[1] {
        job.remark(format!(
            "the spectra of the BRDF go from {first} to {last} nm; beyond, they are taken as constant"
        ));
    }
    Ok(rgb_weights(&wavelengths))
}
