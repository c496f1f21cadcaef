//! The table of a learned basis as two texts. The pairs: for each the light, the view and the weight, numbers
//! separated by spaces and pairs by `;`, the shortest decimals that read back to the same bits. The values of the
//! functions, pair after pair and channel after channel: little-endian 32-bit floats in Base64 (RFC 4648).

use std::fmt::Write as _;

use base64::Engine as _;
use base64::engine::general_purpose::STANDARD as BASE64;

use crate::direction::{Direction, Directions};
use crate::error::{Error, Result};
use crate::field::Learned;

/// Numbers of a pair.
const NUMBERS: usize = 7;

/// The pairs as text.
pub(super) fn pairs_of(learned: &Learned) -> String {
    let mut text = String::new();
    for (pair, weight) in learned.pairs().iter().zip(learned.weights()) {
        if !text.is_empty() {
            text.push(';');
        }
        let numbers = pair.to_array().into_iter().chain([*weight]);
        let _ =
            numbers.enumerate().try_for_each(|(i, v)| write!(text, "{}{v}", if i == 0 { "" } else { " " }));
    }
    text
}

/// The values as text.
pub(super) fn values_of(learned: &Learned) -> String {
    BASE64.encode(learned.values().iter().flat_map(|value| value.to_le_bytes()).collect::<Vec<u8>>())
}

/// The basis of a table with values for each of some channels.
///
/// # Errors
/// Pairs that are not seven numbers, vectors that are not of length 1, values that are not Base64 of floats, and tables
/// that are not a basis.
pub(super) fn from_texts(pairs: &str, values: &str, channels: usize) -> Result<Learned> {
    let rows = pairs.split(';').enumerate().map(|(number, row)| pair_of(number, row));
    let (pairs, weights) = rows.collect::<Result<(Vec<Directions>, Vec<f64>)>>()?;
    let bytes = BASE64.decode(values.trim_ascii()).ok().filter(|bytes| bytes.len().is_multiple_of(4));
    let bytes = bytes.ok_or_else(|| {
        Error::invalid(
            "the values of the learned basis in the EXR field are damaged: expected 32-bit floats in Base64",
        )
    })?;
    let values = bytes.as_chunks::<4>().0.iter().map(|bytes| f32::from_le_bytes(*bytes)).collect();
    Learned::of_channels(channels, pairs, weights, values)
}

/// A pair and its weight.
fn pair_of(number: usize, row: &str) -> Result<(Directions, f64)> {
    let broken = |found: String| {
        Error::invalid(format!("pair {number} of the learned basis in the EXR field holds {found}"))
    };
    let words: Vec<&str> = row.split_ascii_whitespace().collect();
    let numbers: Option<Vec<f64>> = words.iter().map(|word| word.parse().ok()).collect();
    let numbers = numbers.ok_or_else(|| broken(format!("'{}': expected numbers", row.escape_default())))?;
    if numbers.len() != NUMBERS {
        return Err(broken(format!("{} numbers: expected a light, a view and a weight", numbers.len())));
    }
    let direction = |k: usize| Direction::from_unit_vector(numbers[k], numbers[k + 1], numbers[k + 2]);
    Ok((Directions { light: direction(0)?, view: direction(3)? }, numbers[6]))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::field::basis::learned_example;
    use crate::field::{Basis, PlaneLayout, ReflectanceField};
    use crate::format::{ExrDepth, FieldFormat, decode_field, encode_field};
    use crate::job::Job;
    use crate::planes::Planes;
    use crate::size::Size;
    use crate::space::Space;

    fn example() -> Learned {
        match Basis::examples().pop() {
            Some(Basis::Learned(learned)) => learned,
            other => panic!("the last example is the learned one, found {other:?}"),
        }
    }

    #[test]
    fn a_table_comes_back_to_the_bit() {
        let learned = example();
        assert_eq!(from_texts(&pairs_of(&learned), &values_of(&learned), 1).unwrap(), learned);
    }

    /// A file with the directions of the usual BTF samples, 81 x 81.
    #[test]
    fn a_basis_of_6561_pairs_comes_back_from_a_file() {
        let basis = Basis::Learned(learned_example(81, 81, 8));
        let planes = Planes::zeros(Size::new(2, 1), basis.len());
        let field = ReflectanceField::new(basis, PlaneLayout::LUMINANCE, Space::Linear, planes).unwrap();
        let file = encode_field(&field, FieldFormat::Exr(ExrDepth::Float), None, &Job::default()).unwrap();
        assert!(decode_field(&file, &Job::default()).unwrap().field == field);
    }

    #[test]
    fn broken_tables_are_refused_in_a_sentence() {
        let (pairs, values) = (pairs_of(&example()), values_of(&example()));
        let message = |pairs: &str, values: &str, channels: usize| {
            from_texts(pairs, values, channels).unwrap_err().to_string()
        };
        assert!(message(&pairs, &values, 3).contains("3 channels"));
        assert!(message("", &values, 1).contains("pair 0"));
        assert!(message(&format!("{pairs};1 0 0"), &values, 1).contains("3 numbers"));
        assert!(message(&pairs.replacen(' ', " x", 1), &values, 1).contains("expected numbers"));
        assert!(message("2 0 0 0 0 1 1", &values, 1).contains("length"));
        assert!(message("0 0 1 0 0 1 1", &BASE64.encode(3f32.to_le_bytes()), 1).contains("orthonormal"));
        for damaged in ["*", "AAAA", &values[..values.len() - 4]] {
            let text = message(&pairs, damaged, 1);
            assert!(text.contains("damaged") || text.contains("values"), "{text}");
        }
    }
}
