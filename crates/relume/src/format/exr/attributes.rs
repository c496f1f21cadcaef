//! The order of header attributes. The writer keeps added attributes in a hash map, so their order varies
//! from run to run; sorting them alphabetically makes the file a function of its content.
//!
//! After eight bytes of magic and version, a header is a sequence of attributes: name and type as
//! zero-terminated text, a little-endian `i32` size, the value; a zero ends it. Reordering moves nothing
//! behind the header.

/// Bytes before the first attribute.
const PROLOGUE: usize = 8;

/// Sorts the attributes of a single-part file by name. Other bytes are left unchanged.
pub(super) fn sort(file: &mut [u8]) {
    let Some(mut attributes) = split(file) else { return };
    attributes.sort_by(|a, b| name(a).cmp(name(b)));
    let sorted = attributes.concat();
    file[PROLOGUE..PROLOGUE + sorted.len()].copy_from_slice(&sorted);
}

/// The attributes of the header, each complete; `None` if the header is invalid.
fn split(file: &[u8]) -> Option<Vec<Vec<u8>>> {
    let mut attributes = Vec::new();
    let mut at = PROLOGUE;
    while *file.get(at)? != 0 {
        let size_at = after_text(file, after_text(file, at)?)?;
        let size = i32::from_le_bytes(file.get(size_at..size_at + 4)?.try_into().ok()?);
        let end = size_at + 4 + usize::try_from(size).ok()?;
        attributes.push(file.get(at..end)?.to_vec());
        at = end;
    }
    Some(attributes)
}

/// The position after the zero that ends the text at `at`.
fn after_text(file: &[u8], at: usize) -> Option<usize> {
    Some(at + file.get(at..)?.iter().position(|&byte| byte == 0)? + 1)
}

fn name(attribute: &[u8]) -> &[u8] {
    attribute.split(|&byte| byte == 0).next().unwrap_or_default()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn attributes_are_sorted_and_the_rest_stays() {
        let attribute = |name: &str, value: &[u8]| {
            let size = (value.len() as i32).to_le_bytes();
            [name.as_bytes(), b"\0type\0", &size, value].concat()
        };
        let (b, a) = (attribute("bee", &[0, 9, 0]), attribute("ant", b""));
        let mut file = [&b"12345678"[..], &b, &a, b"\0rest"].concat();
        sort(&mut file);
        assert_eq!(file, [&b"12345678"[..], &a, &b, b"\0rest"].concat());
        let whole = [&b"12345678"[..], &b, &a].concat();
        for length in 0..=whole.len() {
            let mut cut = whole[..length].to_vec();
            sort(&mut cut);
            assert_eq!(cut, whole[..length], "a broken header of {length} bytes stays");
        }
    }
}
