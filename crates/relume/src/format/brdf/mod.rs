//! Files of measured reflectances: MERL `.binary`, UTIA `.bin` and RGL `.bsdf`.

mod bsdf;
mod tensor;

use super::kind::Kind;
use crate::brdf::{MeasuredBrdf, MerlBrdf, UtiaBrdf};
use crate::error::{Error, Result};
use crate::job::Job;
use crate::memory;

/// The bytes of a file of a UTIA BRDF, which has neither a signature nor a header.
pub(super) const UTIA_BYTES: usize = 8 * UtiaBrdf::NUMBERS;

/// The bytes before the numbers of a MERL BRDF.
const MERL_HEADER: usize = 12;

/// Whether a file without a signature is a UTIA BRDF, by its length.
pub(super) fn is_utia(bytes: &[u8]) -> bool {
    bytes.len() == UTIA_BYTES
}

/// The BRDF in the bytes of a file: MERL or RGL by the first bytes, UTIA by the length of the file.
///
/// # Errors
/// A file of another kind; one that is truncated, contradicts itself, has numbers that are not finite, or exceeds the
/// limits.
pub fn decode_brdf(bytes: &[u8], job: &Job) -> Result<MeasuredBrdf> {
    match Kind::of(bytes) {
        Some(Kind::Bsdf) => bsdf::decode(bytes, job).map(|brdf| MeasuredBrdf::Rgl(Box::new(brdf))),
        Some(Kind::Merl) => {
            let numbers = numbers(bytes, MERL_HEADER, MerlBrdf::NUMBERS, "MERL", job)?;
            let missing = numbers.iter().filter(|number| **number < 0.0).count();
            if missing > 0 {
                job.remark(format!(
                    "{missing} numbers of the MERL BRDF are negative, which means none; they are 0"
                ));
            }
            MerlBrdf::new(numbers).map(MeasuredBrdf::Merl)
        }
        None if is_utia(bytes) => {
            job.remark("the values of the UTIA BRDF are taken as 1/sr: the file does not say their unit");
            UtiaBrdf::new(numbers(bytes, 0, UtiaBrdf::NUMBERS, "UTIA", job)?).map(MeasuredBrdf::Utia)
        }
        _ => Err(Error::unsupported(format!(
            "the file is not a measured BRDF: expected MERL .binary, RGL .bsdf, or UTIA .bin of {UTIA_BYTES} bytes"
        ))),
    }
}

/// The numbers that follow a header and fill the file.
fn numbers(bytes: &[u8], header: usize, count: usize, named: &str, job: &Job) -> Result<Vec<f64>> {
    let expected = header + 8 * count;
    if bytes.len() != expected {
        return Err(Error::invalid(format!(
            "the {named} BRDF has {} bytes: expected {expected}; the file is damaged or truncated",
            bytes.len()
        )));
    }
    job.check_bytes("the BRDF", 8 * count as u64)?;
    let mut numbers = memory::with_capacity("the BRDF", count)?;
    let (eights, _) = bytes[header..].as_chunks::<8>();
    numbers.extend(eights.iter().map(|eight| f64::from_le_bytes(*eight)));
    Ok(numbers)
}
