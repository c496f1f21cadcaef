//! The table of a learned basis as text: for each measured pair the light, the view, the weight and the
//! values of the functions, numbers separated by spaces and pairs by `;`. Numbers are the shortest decimals
//! that read back to the same bits.

use std::fmt::Write as _;

use crate::direction::{Direction, Directions};
use crate::error::{Error, Result};
use crate::field::Learned;

/// Numbers of a pair before its values.
const HEAD: usize = 7;

/// The table as text.
pub(super) fn text_of(learned: &Learned) -> String {
    let mut text = String::new();
    let functions = learned.values().len() / learned.pairs().len();
    let rows = learned.values().chunks_exact(functions);
    for ((pair, weight), values) in learned.pairs().iter().zip(learned.weights()).zip(rows) {
        if !text.is_empty() {
            text.push(';');
        }
        let numbers = pair.to_array().into_iter().chain([*weight]);
        let _ =
            numbers.enumerate().try_for_each(|(i, v)| write!(text, "{}{v}", if i == 0 { "" } else { " " }));
        let _ = values.iter().try_for_each(|v| write!(text, " {v}"));
    }
    text
}

/// The basis of a table.
///
/// # Errors
/// Rows that are not numbers or differ in length, vectors that are not of length 1, and tables that are not a
/// basis.
pub(super) fn from_text(text: &str) -> Result<Learned> {
    let (mut pairs, mut weights, mut values) = (Vec::new(), Vec::new(), Vec::new());
    let mut length = None;
    for (number, row) in text.split(';').enumerate() {
        let broken = |found: String| {
            Error::invalid(format!("pair {number} of the learned basis in the EXR field holds {found}"))
        };
        let words: Vec<&str> = row.split_ascii_whitespace().collect();
        if words.len() <= HEAD || words.len() != *length.get_or_insert(words.len()) {
            return Err(broken(format!(
                "{} numbers: expected a light, a view, a weight and as many values as all pairs",
                words.len()
            )));
        }
        let number_in =
            |word: &str| word.parse::<f64>().map_err(|_| broken(format!("'{word}': expected a number")));
        let head: Vec<f64> = words[..HEAD].iter().map(|word| number_in(word)).collect::<Result<_>>()?;
        let direction = |k: usize| Direction::from_unit_vector(head[k], head[k + 1], head[k + 2]);
        pairs.push(Directions { light: direction(0)?, view: direction(3)? });
        weights.push(head[6]);
        for word in &words[HEAD..] {
            values.push(word.parse::<f32>().map_err(|_| broken(format!("'{word}': expected a number")))?);
        }
    }
    Learned::new(pairs, weights, values)
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
        assert_eq!(from_text(&text_of(&example())).unwrap(), example());
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
        let text = text_of(&example());
        let message = |text: &str| from_text(text).unwrap_err().to_string();
        assert!(message("").contains("pair 0"));
        assert!(message(&format!("{text};1 0 0")).contains("3 numbers"));
        assert!(message(&text.replacen(' ', " x", 1)).contains("expected a number"));
        assert!(message("2 0 0 0 0 1 1 1").contains("length"));
        assert!(message("0 0 1 0 0 1 1 3").contains("orthonormal"));
    }
}
