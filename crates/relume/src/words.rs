//! Lists and counts in sentences.

/// The first words of a list, with something between them, and how many more there are.
///
/// ```
/// assert_eq!(relume::words::listed(&["a", "b", "c"], 2, ", "), "a, b and 1 more");
/// ```
pub fn listed<T: AsRef<str>>(words: &[T], most: usize, between: &str) -> String {
    let shown = words.iter().take(most).map(T::as_ref).collect::<Vec<&str>>().join(between);
    match words.len().saturating_sub(most) {
        0 => shown,
        more => format!("{shown} and {more} more"),
    }
}

/// A count and what is counted.
///
/// ```
/// let said = [0, 1, 2].map(|n| relume::words::counted(n, "picture"));
/// assert_eq!(said, ["0 pictures", "1 picture", "2 pictures"]);
/// ```
pub fn counted(count: usize, noun: &str) -> String {
    format!("{count} {noun}{}", if count == 1 { "" } else { "s" })
}
