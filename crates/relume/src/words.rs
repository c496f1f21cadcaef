//! Lists in sentences.

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
