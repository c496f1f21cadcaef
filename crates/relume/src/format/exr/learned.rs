//! The table of a learned basis as two texts. The pairs: for each the light, the view and the weight, numbers
//! separated by spaces and pairs by `;`, the shortest decimals that read back to the same bits. The values of the
//! functions, pair after pair and channel after channel, are numbers as text ([`numbers`]). A basis that is packed has
//! one text instead: its integers as those of a model ([`rlm`]), in Base64.

use std::fmt::Write as _;

use base64::Engine as _;
use base64::engine::general_purpose::STANDARD as BASE64;

use super::{ExrDepth, numbers};
use crate::direction::{Direction, Directions};
use crate::error::{Error, ErrorKind, Result};
use crate::field::Learned;
use crate::format::rlm;
use crate::job::Job;

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

/// The values as text, in halves where those are asked for and are still orthonormal.
pub(super) fn values_of(learned: &Learned, depth: ExrDepth) -> String {
    let text = numbers::text_of(learned.values(), depth);
    let holds = |text: &str| {
        let values = numbers::from_text(text, "the values")?;
        Learned::of_channels(learned.channels(), learned.pairs().to_vec(), learned.weights().to_vec(), values)
    };
    match depth {
        ExrDepth::Half if holds(&text).is_err() => numbers::text_of(learned.values(), ExrDepth::Float),
        ExrDepth::Half | ExrDepth::Float => text,
    }
}

/// The integers of a packed basis as text.
pub(super) fn packed_of(learned: &Learned) -> Option<String> {
    rlm::encode_functions(learned.packed()?).ok().map(|bytes| BASE64.encode(bytes))
}

/// The basis of a text of [`packed_of`].
///
/// # Errors
/// A text that is not Base64 of packed functions of so many channels, and more memory than the limits allow.
pub(super) fn from_packed(text: &str, channels: usize, job: &Job) -> Result<Learned> {
    let broken = |why: String| Error::invalid(format!("the functions in the EXR field are damaged: {why}"));
    let bytes = BASE64.decode(text.trim_ascii()).map_err(|_| broken("expected Base64".to_owned()))?;
    let unpacked = rlm::decode_functions(&bytes, job).and_then(|packed| packed.unpacked());
    let learned = unpacked.map_err(|error| match error.kind() {
        ErrorKind::Invalid => broken(error.to_string()),
        _ => error,
    })?;
    match learned.channels() == channels {
        true => Ok(learned),
        false => Err(broken(format!("they are of {} channels, expected {channels}", learned.channels()))),
    }
}

/// The basis of a table with values for each of some channels.
///
/// # Errors
/// Pairs that are not seven numbers, vectors that are not of length 1, values that are not Base64 of floats, and tables
/// that are not a basis.
pub(super) fn from_texts(pairs: &str, values: &str, channels: usize) -> Result<Learned> {
    let rows = pairs.split(';').enumerate().map(|(number, row)| pair_of(number, row));
    let (pairs, weights) = rows.collect::<Result<(Vec<Directions>, Vec<f64>)>>()?;
    let values = numbers::from_text(values, "the values of the learned basis")?;
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
    use crate::field::{Basis, PackedFunctions, PlaneLayout, ReflectanceField};
    use crate::format::{FieldFormat, decode_field, encode_field};
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
        assert_eq!(
            from_texts(&pairs_of(&learned), &values_of(&learned, ExrDepth::Float), 1).unwrap(),
            learned
        );
    }

    #[test]
    fn packed_functions_come_back_to_the_bit_and_damage_is_refused() {
        let learned = learned_example(20, 20, 4);
        assert_eq!(packed_of(&learned), None);
        let packed = PackedFunctions::new(&learned, &[1e-2; 4]).unwrap().unpacked().unwrap();
        let (text, job) = (packed_of(&packed).unwrap(), Job::default());
        assert_eq!(from_packed(&text, 1, &job).unwrap(), packed);
        let table = pairs_of(&learned).len() + values_of(&learned, ExrDepth::Half).len();
        assert!(text.len() * 3 < table, "{} and {table} characters", text.len());
        let planes = Planes::zeros(Size::new(2, 1), 4);
        let field =
            ReflectanceField::new(Basis::Learned(packed), PlaneLayout::LUMINANCE, Space::Linear, planes);
        let field = field.unwrap();
        for depth in [ExrDepth::Half, ExrDepth::Float] {
            let file = encode_field(&field, FieldFormat::Exr(depth), None, &job).unwrap();
            assert!(decode_field(&file, &job).unwrap().field == field);
        }
        let refused =
            |text: &str, channels: usize| from_packed(text, channels, &job).unwrap_err().to_string();
        assert!(refused(&text, 3).contains("of 1 channels, expected 3"));
        assert!(refused("*", 1).contains("expected Base64"));
        assert!(refused("", 1).contains("damaged"));
        assert!(refused(&text[..text.len() / 8 * 4], 1).contains("damaged"));
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
    fn a_table_in_halves_is_half_as_long_and_stays_orthonormal() {
        let learned = learned_example(20, 20, 6);
        let halves = values_of(&learned, ExrDepth::Half);
        assert!(halves.len() < values_of(&learned, ExrDepth::Float).len() * 51 / 100);
        let read = from_texts(&pairs_of(&learned), &halves, 1).unwrap();
        let largest = learned.values().iter().fold(0.0, |most: f32, v| most.max(v.abs()));
        let pairs = read.values().iter().zip(learned.values());
        assert!(pairs.into_iter().all(|(a, b)| (a - b).abs() < 5e-4 * largest));
    }

    /// A single pair, whose value is not exact in 16 bits.
    #[test]
    fn a_table_that_halves_would_spoil_stays_in_floats() {
        let weight = 1.0 / f64::from(1.2343f32).powi(2);
        let learned = Learned::new(vec![Direction::ZENITH.into()], vec![weight], vec![1.2343]).unwrap();
        assert_eq!(
            from_texts(&pairs_of(&learned), &values_of(&learned, ExrDepth::Half), 1).unwrap(),
            learned
        );
    }

    #[test]
    fn broken_tables_are_refused_in_a_sentence() {
        let (pairs, values) = (pairs_of(&example()), values_of(&example(), ExrDepth::Float));
        let message = |pairs: &str, values: &str, channels: usize| {
            from_texts(pairs, values, channels).unwrap_err().to_string()
        };
        assert!(message(&pairs, &values, 3).contains("3 channels"));
        assert!(message("", &values, 1).contains("pair 0"));
        assert!(message(&format!("{pairs};1 0 0"), &values, 1).contains("3 numbers"));
        assert!(message(&pairs.replacen(' ', " x", 1), &values, 1).contains("expected numbers"));
        assert!(message("2 0 0 0 0 1 1", &values, 1).contains("length"));
        assert!(
            message("0 0 1 0 0 1 1", &numbers::text_of(&[3.0], ExrDepth::Float), 1).contains("orthonormal")
        );
        for damaged in ["*", "AAAA", &values[..values.len() - 4]] {
            let text = message(&pairs, damaged, 1);
            assert!(text.contains("damaged") || text.contains("values"), "{text}");
        }
    }
}
