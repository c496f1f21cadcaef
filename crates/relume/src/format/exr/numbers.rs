//! Tables of numbers as text: little-endian 32-bit floats in Base64 (RFC 4648), or, after `half:`, 16-bit floats.

use base64::Engine as _;
use base64::engine::general_purpose::STANDARD as BASE64;
use half::f16;

use super::ExrDepth;
use crate::error::{Error, Result};

const HALVES: &str = "half:";

/// Numbers as text.
pub(super) fn text_of(values: &[f32], depth: ExrDepth) -> String {
    match depth {
        ExrDepth::Float => {
            BASE64.encode(values.iter().flat_map(|value| value.to_le_bytes()).collect::<Vec<u8>>())
        }
        ExrDepth::Half => {
            let bytes = values.iter().flat_map(|value| f16::from_f32(*value).to_le_bytes());
            let mut text = HALVES.to_owned();
            BASE64.encode_string(bytes.collect::<Vec<u8>>(), &mut text);
            text
        }
    }
}

/// The numbers in a text; `what` names them in the message.
///
/// # Errors
/// A text that is not Base64 of floats.
pub(super) fn from_text(text: &str, what: &str) -> Result<Vec<f32>> {
    let (digits, length) = match text.strip_prefix(HALVES) {
        Some(digits) => (digits, 2),
        None => (text, 4),
    };
    let bytes = BASE64.decode(digits.trim_ascii()).ok().filter(|bytes| bytes.len().is_multiple_of(length));
    let bytes = bytes.ok_or_else(|| {
        Error::invalid(format!("{what} in the EXR field are damaged: expected floats in Base64"))
    })?;
    Ok(match length {
        2 => bytes.as_chunks::<2>().0.iter().map(|bytes| f16::from_le_bytes(*bytes).to_f32()).collect(),
        _ => bytes.as_chunks::<4>().0.iter().map(|bytes| f32::from_le_bytes(*bytes)).collect(),
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_come_back_to_the_precision_of_their_type() {
        let values = [0.0, -1.5, 3.25e-5, 1024.0, 0.1];
        assert_eq!(from_text(&text_of(&values, ExrDepth::Float), "numbers").unwrap(), values);
        let halves = from_text(&text_of(&values, ExrDepth::Half), "numbers").unwrap();
        assert!(values.iter().zip(&halves).all(|(a, b)| (a - b).abs() <= 1e-3 * a.abs()), "{halves:?}");
        assert_eq!(from_text("", "numbers").unwrap(), [0.0f32; 0]);
        for damaged in ["*", "AAAA", "half:AA", "half:"] {
            let found = from_text(damaged, "the numbers");
            match found {
                Err(error) => assert!(error.to_string().contains("the numbers in the EXR field are damaged")),
                Ok(values) => assert!(values.is_empty() && damaged == "half:"),
            }
        }
    }
}
