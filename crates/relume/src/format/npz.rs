//! Fields as NumPy archives (`.npz`), for programs of others: written, not read.
//!
//! | array | type and shape | what |
//! |---|---|---|
//! | `coefficients` | f32 (planes, height, width) | rows from the top |
//! | `names` | texts (planes) | of the planes: `R.u2`, `L.h0`, `G` |
//! | `lights` | f64 (n, 3) | directions of the photographs where known: x right, y up, z to the viewer |
//! | `basis`, `color`, `space` | texts | names of the functions, of the arrangement, and `linear` or `srgb` |
//! | `pair_lights`, `pair_views` | f64 (m, 3) | of learned functions: the measured directions |
//! | `pair_values` | f32 (m, channels, functions) | their values there |

use std::io::{Cursor, Write};

use ::zip::write::SimpleFileOptions;
use ::zip::{CompressionMethod, ZipWriter};

use super::npy;
use crate::error::{Error, Result};
use crate::field::{Basis, ReflectanceField};
use crate::job::Job;

/// More than the records of a file in an archive take.
const BYTES_AROUND_AN_ARRAY: usize = 512;

fn coefficient_bytes(field: &ReflectanceField) -> u64 {
    size_of_val(field.coefficients().as_slice()) as u64
}

/// The coefficients alone, as an `.npy` file of shape (planes, height, width).
///
/// # Errors
/// When memory is short.
pub fn encode_npy(field: &ReflectanceField, job: &Job) -> Result<Vec<u8>> {
    // The bytes, and what a growing buffer holds beside them.
    job.check_bytes("the array of coefficients", 3 * coefficient_bytes(field))?;
    let planes = field.coefficients();
    npy::encode_f32(&[planes.count(), planes.size().height, planes.size().width], planes.as_slice())
}

/// The coefficients with their names and directions, as an `.npz` archive, not compressed.
///
/// # Errors
/// When memory is short, and archives that are too large for the system.
pub fn encode_npz(field: &ReflectanceField, job: &Job) -> Result<Vec<u8>> {
    let values = match field.basis() {
        Basis::Learned(learned) => size_of_val(learned.values()) as u64,
        _ => 0,
    };
    // The arrays, the archive of them, and what a growing buffer holds beside them.
    job.check_bytes("the arrays of the archive", 4 * (coefficient_bytes(field) + values))?;
    let text = |text: &str| npy::encode_texts(&[text.to_owned()], false);
    let lights: Vec<[f64; 3]> = field.lights().iter().map(|light| light.to_array()).collect();
    let mut arrays = vec![
        ("coefficients", encode_npy(field, job)?),
        ("names", npy::encode_texts(&field.plane_names(), true)),
        ("lights", npy::encode_vectors(&lights)),
        ("basis", text(field.basis().name())),
        ("color", text(field.layout().name())),
        ("space", text(&field.space().to_string())),
    ];
    if let Basis::Learned(learned) = field.basis() {
        let vectors = |of: fn(&crate::direction::Directions) -> crate::Direction| -> Vec<[f64; 3]> {
            learned.pairs().iter().map(|pair| of(pair).to_array()).collect()
        };
        arrays.push(("pair_lights", npy::encode_vectors(&vectors(|pair| pair.light))));
        arrays.push(("pair_views", npy::encode_vectors(&vectors(|pair| pair.view))));
        let shape = [learned.pairs().len(), learned.channels(), learned.functions()];
        arrays.push(("pair_values", npy::encode_f32(&shape, learned.values())?));
    }
    let total: usize = arrays.iter().map(|(_, bytes)| bytes.len() + BYTES_AROUND_AN_ARRAY).sum();
    let mut writer = ZipWriter::new(Cursor::new(Vec::with_capacity(total)));
    for (name, bytes) in arrays {
        let options = SimpleFileOptions::default()
            .compression_method(CompressionMethod::Stored)
            .large_file(u32::try_from(bytes.len()).is_err());
        let unwritable = |e: std::io::Error| Error::io("cannot write the archive", &e);
        writer.start_file(format!("{name}.npy"), options).map_err(|e| unwritable(e.into()))?;
        writer.write_all(&bytes).map_err(unwritable)?;
    }
    let out = writer.finish().map_err(|e| Error::io("cannot write the archive", &e.into()))?;
    Ok(out.into_inner())
}
