//! The words of a text header, with their places.

use crate::error::{Error, Result};

/// Words separated by white space.
pub(super) struct Words<'a> {
    bytes: &'a [u8],
    at: usize,
}

/// The longest word of a header; numbers and names are far shorter.
const LONGEST_WORD: usize = 64;

impl<'a> Words<'a> {
    pub(super) fn of(bytes: &'a [u8]) -> Self {
        Self { bytes, at: 0 }
    }

    /// The next word and its first byte position.
    pub(super) fn next(&mut self, what: &str) -> Result<(String, usize)> {
        let rest = &self.bytes[self.at..];
        let blank = rest.iter().take_while(|byte| byte.is_ascii_whitespace()).count();
        let word = rest[blank..].iter().take_while(|byte| !byte.is_ascii_whitespace());
        let word: Vec<u8> = word.copied().take(LONGEST_WORD).collect();
        let start = self.at + blank;
        self.at = start + word.len();
        if word.is_empty() {
            return Err(Error::invalid(format!(
                "the texture map ends at byte {start}, where {what} was expected: the file is truncated"
            )));
        }
        Ok((String::from_utf8_lossy(&word).escape_debug().to_string(), start))
    }

    pub(super) fn side(&mut self, what: &str) -> Result<usize> {
        let (word, at) = self.next(what)?;
        match word.parse() {
            Ok(side) if side > 0 => Ok(side),
            _ => Err(Error::invalid(format!(
                "{what} of the texture map, at byte {at}, is '{word}': expected a whole number above 0"
            ))),
        }
    }

    /// `N` numbers that `check` accepts.
    pub(super) fn numbers<const N: usize>(
        &mut self,
        what: &str,
        check: impl Fn(f32) -> Result<(), &'static str>,
    ) -> Result<[f32; N]> {
        let mut numbers = [0.0; N];
        for (k, number) in numbers.iter_mut().enumerate() {
            let which = format!("{what} {} of {N}", k + 1);
            let (word, at) = self.next(&which)?;
            let parsed = word.parse::<f32>().map_err(|_| "expected a number");
            *number = parsed.and_then(|n| check(n).map(|()| n)).map_err(|reason| {
                Error::invalid(format!("{which} of the texture map, at byte {at}, is '{word}': {reason}"))
            })?;
        }
        Ok(numbers)
    }

    /// `count` whole numbers within a range.
    pub(super) fn integers(
        &mut self,
        what: &str,
        count: usize,
        range: std::ops::RangeInclusive<i64>,
    ) -> Result<Vec<i64>> {
        let integer = |k: usize| {
            let which = format!("{what} {} of {count}", k + 1);
            let (word, at) = self.next(&which)?;
            word.parse().ok().filter(|n| range.contains(n)).ok_or_else(|| {
                Error::invalid(format!(
                    "{which} of the texture map, at byte {at}, is '{word}': expected a whole number from {} to {}",
                    range.start(),
                    range.end()
                ))
            })
        };
        (0..count).map(integer).collect()
    }

    /// The byte after the newline that ends the last line.
    pub(super) fn end_of_line(&self, after: &str) -> Result<usize> {
        let rest = &self.bytes[self.at..];
        let blank = rest.iter().take_while(|byte| matches!(byte, b' ' | b'\t' | b'\r')).count();
        match rest.get(blank) {
            Some(b'\n') => Ok(self.at + blank + 1),
            _ => Err(Error::invalid(format!(
                "the texture map has no end of line at byte {}, after {after}",
                self.at + blank
            ))),
        }
    }
}
