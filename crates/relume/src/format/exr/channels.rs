//! Which channels of an EXR file are its picture. The first rule that finds them holds; nothing is guessed:
//!
//! | rule | example |
//! |---|---|
//! | `R`, `G`, `B`, in capitals or not | `R G B A Z` |
//! | the only layer with these | `diffuse.R diffuse.G diffuse.B` |
//! | `Y`, without the chroma `RY` and `BY` | `Y A` |
//! | the only channel beside the opacity, of any name | `height`, `A` |
//! | of data, the only layer with `X`, `Y`, `Z` | `N.X N.Y N.Z` |
//!
//! `A` of the same layer is the opacity.

use crate::error::Error;
use crate::words;

/// The channels taken from a file, by their number in it.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct ChosenChannels {
    /// One or three.
    pub colors: Vec<usize>,
    pub opacity: Option<usize>,
    /// The names of the channels that are not taken.
    pub unused: Vec<String>,
}

const RGB: [&str; 3] = ["R", "G", "B"];
const VECTOR: [&str; 3] = ["X", "Y", "Z"];
const OPACITY: &str = "A";

/// The layer of a channel, empty for the file's own, and its name in the layer.
fn parts(name: &str) -> (&str, &str) {
    name.rsplit_once('.').unwrap_or(("", name))
}

/// The channel of a name in a layer; capitals do not matter.
fn find(names: &[String], layer: &str, wanted: &str) -> Option<usize> {
    names.iter().position(|name| {
        let (of, own) = parts(name);
        of == layer && own.eq_ignore_ascii_case(wanted)
    })
}

/// The channels of a picture; `None` where it is not clear which they are. Vectors are a picture only of
/// data.
pub(super) fn choose(names: &[String], of_data: bool) -> Option<ChosenChannels> {
    let colored = layered(names, &RGB).or_else(|| grey(names));
    let (layer, colors) = colored.or_else(|| layered(names, &VECTOR).filter(|_| of_data))?;
    let opacity = find(names, &layer, OPACITY).filter(|k| !colors.contains(k));
    let is_taken = |k: &usize| colors.contains(k) || opacity == Some(*k);
    let unused = (0..names.len()).filter(|k| !is_taken(k)).map(|k| names[k].clone()).collect();
    Some(ChosenChannels { colors, opacity, unused })
}

/// The file's own channels of these names, or those of the only layer that has them.
fn layered(names: &[String], wanted: &[&str; 3]) -> Option<(String, Vec<usize>)> {
    let of = |layer: &str| wanted.iter().map(|wanted| find(names, layer, wanted)).collect::<Option<Vec<_>>>();
    if let Some(own) = of("") {
        return Some((String::new(), own));
    }
    let mut layers: Vec<&str> = names.iter().map(|name| parts(name).0).collect();
    layers.sort_unstable();
    layers.dedup();
    let mut found = layers.into_iter().filter_map(|layer| Some((layer.to_owned(), of(layer)?)));
    let only = found.next()?;
    found.next().is_none().then_some(only)
}

/// The luminance, or the only channel beside an opacity.
fn grey(names: &[String]) -> Option<(String, Vec<usize>)> {
    let chroma = ["RY", "BY"].iter().any(|chroma| find(names, "", chroma).is_some());
    if let Some(luminance) = find(names, "", "Y").filter(|_| !chroma && find(names, "", "X").is_none()) {
        return Some((String::new(), vec![luminance]));
    }
    let layer = |k: usize| parts(&names[k]).0.to_owned();
    match names {
        [_] => Some((layer(0), vec![0])),
        [a, b] if parts(a).0 == parts(b).0 => {
            let other = 1 - find(names, parts(a).0, OPACITY)?;
            Some((layer(other), vec![other]))
        }
        _ => None,
    }
}

/// Whether the channels are those of a plain picture in any viewer: no layers, and a colour or a grey.
pub(super) fn are_plain(names: &[String]) -> bool {
    names.iter().all(|name| parts(name).0.is_empty()) && choose(names, false).is_some()
}

/// The error for channels of which it is not clear which are the picture.
pub(super) fn unclear(names: &[String]) -> Error {
    Error::unsupported(format!(
        "the EXR file holds the channels {}: expected R, G and B, the same in one layer, Y, or a single channel; \
         export the wanted ones alone",
        listed(names)
    ))
}

/// Names in words, at most eight of them.
pub(super) fn listed(names: &[String]) -> String {
    words::listed(names, 8, ", ")
}

#[cfg(test)]
mod tests {
    use super::*;

    fn named(names: &str) -> Vec<String> {
        names.split(' ').map(str::to_owned).collect()
    }

    #[test]
    fn channels_are_taken_where_their_meaning_is_clear() {
        for (names, colors, opacity) in [
            ("B G R", "R G B", None),
            ("A B G R Z", "R G B", Some("A")),
            ("b g r", "r g b", None),
            ("Depth.Z V.L.A V.L.B V.L.G V.L.R", "V.L.R V.L.G V.L.B", Some("V.L.A")),
            ("B G R diffuse.B diffuse.G diffuse.R", "R G B", None),
            ("A Y", "Y", Some("A")),
            ("Y Z", "Y", None),
            ("height", "height", None),
            ("A", "A", None),
            ("A height", "height", Some("A")),
            ("n.A n.height", "n.height", Some("n.A")),
        ] {
            let all = named(names);
            let chosen = choose(&all, false).unwrap_or_else(|| panic!("{names}"));
            let name = |k: &usize| all[*k].clone();
            assert_eq!(chosen.colors.iter().map(name).collect::<Vec<_>>(), named(colors), "{names}");
            assert_eq!(chosen.opacity.as_ref().map(name).as_deref(), opacity, "{names}");
            let taken = chosen.colors.len() + usize::from(opacity.is_some());
            assert_eq!(chosen.unused.len() + taken, all.len(), "{names}");
        }
    }

    #[test]
    fn channels_are_not_guessed() {
        for names in ["a.B a.G a.R b.B b.G b.R", "BY RY Y", "400nm 500nm", "X Y Z", "N.X N.Y N.Z", "G R"] {
            assert_eq!(choose(&named(names), false), None, "{names}");
        }
        assert_eq!(choose(&named("N.X N.Y N.Z"), true).unwrap().colors, [0, 1, 2]);
        assert_eq!(choose(&named("X Y Z"), true).unwrap().colors, [0, 1, 2]);
    }
}
