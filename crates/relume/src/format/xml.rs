//! The little of XML that descriptions of tiles need: elements and attributes by their names, without entities.

/// The attributes and the content of the first element of a name; without content for `<NAME/>`.
pub(super) fn element<'a>(text: &'a str, name: &str) -> Option<(&'a str, &'a str)> {
    let open = format!("<{name}");
    let starts = text.match_indices(&open).map(|(at, _)| &text[at + open.len()..]);
    let rest =
        starts.into_iter().find(|rest| rest.starts_with(|c: char| c.is_whitespace() || "/>".contains(c)))?;
    let (attributes, rest) = rest.split_once('>')?;
    match attributes.strip_suffix('/') {
        Some(attributes) => Some((attributes, "")),
        None => Some((attributes, rest.split_once(&format!("</{name}"))?.0)),
    }
}

/// The text after `NAME="`, of the first attribute of a name.
pub(super) fn attribute<'a>(text: &'a str, name: &str) -> Option<&'a str> {
    let after = text.match_indices(name).filter(|(at, _)| text[..*at].ends_with(char::is_whitespace));
    let mut values = after.filter_map(|(at, _)| {
        let value = text[at + name.len()..].trim_start().strip_prefix('=')?.trim_start();
        let quote = value.chars().next().filter(|c| "\"'".contains(*c))?;
        value[1..].split_once(quote).map(|(value, _)| value.trim())
    });
    values.next()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn elements_and_attributes_are_found_by_whole_names() {
        let text = "<Sizes a=\"1\"/><Size w='3' awidth=\"9\" width = \"4\"/>\n<Tree>5 0\n</Tree><Open>";
        let (attributes, content) = element(text, "Size").unwrap();
        assert_eq!(
            (attribute(attributes, "width"), attribute(attributes, "w"), content),
            (Some("4"), Some("3"), "")
        );
        assert_eq!(element(text, "Tree"), Some(("", "5 0\n")));
        assert_eq!(
            (element(text, "Open"), element(text, "None"), attribute(attributes, "h")),
            (None, None, None)
        );
    }
}
