//! What is wrong with a value on the command line, in the terms of the user instead of those of a parser.

/// The words of parsers of numbers, and what they expected.
const WORDS: [(&str, &str); 6] = [
    ("invalid digit found in string", "expected a whole number that is not negative"),
    ("cannot parse integer from empty string", "expected a whole number that is not negative"),
    ("number too large to fit in target type", "the number is too large"),
    ("number too small to fit in target type", "the number is too small"),
    ("invalid float literal", "expected a number"),
    ("cannot parse float from empty string", "expected a number"),
];

/// The message with clear words; `None` where it has them already.
pub fn in_words(message: &str) -> Option<String> {
    if !message.starts_with("error: invalid value") {
        return None;
    }
    let (first, rest) = message.split_once('\n').unwrap_or((message, ""));
    let known = WORDS.iter().find(|(words, _)| first.ends_with(words));
    let first = match known {
        Some((words, clear)) => first.replace(words, clear),
        None => ranged(first)?,
    };
    Some(format!("{first}\n{rest}"))
}

/// `V is not in A..=B` as `expected a whole number from A to B`.
fn ranged(line: &str) -> Option<String> {
    let (before, range) = line.split_once(" is not in ")?;
    let (least, most) = range.split_once("..=")?;
    let (before, _) = before.rsplit_once(": ")?;
    Some(format!("{before}: expected a whole number from {least} to {most}"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn parsers_words_become_what_is_expected() {
        let line =
            |words: &str| in_words(&format!("error: invalid value 'x' for '--block <N>': {words}\n\nmore"));
        let expected = "error: invalid value 'x' for '--block <N>': expected a whole number that is not negative\n\nmore";
        assert_eq!(line("invalid digit found in string").unwrap(), expected);
        assert!(line("x is not in 1..=9").unwrap().contains("<N>': expected a whole number from 1 to 9\n"));
        assert_eq!(line("expected a size such as 512x512"), None);
        assert_eq!(in_words("error: unexpected argument '--x' found"), None);
    }
}
