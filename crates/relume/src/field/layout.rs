//! The layout of coefficient planes: how they form the channels of a texel.

use std::collections::BTreeSet;
use std::sync::Arc;

use serde::{Serialize, Serializer};

use crate::error::{Error, Result};

/// The order and the meaning of the planes of a field; `n` is the length of its basis.
///
/// | layout | channels | planes |
/// |---|---|---|
/// | [`LUMINANCE`](Self::LUMINANCE) | `L` | `n` |
/// | [`RGB`](Self::RGB) | `R`, `G`, `B` | 3 n: the `n` of red first, then green, then blue |
/// | [`LRGB`](Self::LRGB) | `R`, `G`, `B` | n + 3: one function, then the colour that multiplies it |
/// | [`of_channels`](Self::of_channels) | any names | `n` for each channel in order |
/// | [`shared`](Self::shared) | any names | `n`, of all channels: the functions differ between channels |
///
/// Names are behind an `Arc`: copies are cheap.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct PlaneLayout(Arrangement);

#[derive(Debug, Clone, PartialEq, Eq)]
enum Arrangement {
    Luminance,
    Rgb,
    Lrgb,
    Named(Arc<[String]>),
    Shared(Arc<[String]>),
}

/// The meaning of one plane of a field.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum PlaneRole<'a> {
    /// The coefficient of a function of a channel; `L` is the luminance channel.
    Coefficient {
        /// The channel's name.
        channel: &'a str,
        /// The index of the function in the basis.
        function: usize,
    },
    /// The coefficient of a function that has a value for each channel.
    Shared {
        /// The index of the function in the basis.
        function: usize,
    },
    /// A channel of the colour that multiplies the luminance function.
    Color {
        /// The channel's name.
        channel: &'a str,
    },
}

const RED_GREEN_BLUE: [&str; 3] = ["R", "G", "B"];

impl PlaneLayout {
    /// One function per texel: `n` planes.
    pub const LUMINANCE: Self = Self(Arrangement::Luminance);
    /// A function for each of red, green and blue: 3 n planes.
    pub const RGB: Self = Self(Arrangement::Rgb);
    /// One function times a colour: `n` planes of luminance, then red, green, blue.
    pub const LRGB: Self = Self(Arrangement::Lrgb);

    /// The layouts whose relit channels are grey or a colour.
    pub const COLORS: [Self; 3] = [Self::LUMINANCE, Self::RGB, Self::LRGB];

    /// A function for each of the named channels: the maps of a material, spectral bands. `L` alone is
    /// [`PlaneLayout::LUMINANCE`], and `R`, `G`, `B` in this order are [`PlaneLayout::RGB`].
    ///
    /// # Errors
    /// No name, an empty or repeated name, and characters other than printable ASCII without `;`, which files
    /// cannot hold.
    pub fn of_channels<S: Into<String>>(names: impl IntoIterator<Item = S>) -> Result<Self> {
        let names = channel_names(names)?;
        Ok(Self(match names.iter().map(String::as_str).collect::<Vec<_>>()[..] {
            ["L"] => Arrangement::Luminance,
            ["R", "G", "B"] => Arrangement::Rgb,
            _ => Arrangement::Named(names.into()),
        }))
    }

    /// One coefficient for all channels of a function: the arrangement of factorised textures, whose basis
    /// holds values of its functions for each channel ([`Basis::channels`](super::Basis::channels)). A single
    /// channel is that of [`PlaneLayout::of_channels`].
    ///
    /// # Errors
    /// As [`PlaneLayout::of_channels`].
    pub fn shared<S: Into<String>>(names: impl IntoIterator<Item = S>) -> Result<Self> {
        let names = channel_names(names)?;
        match names.len() {
            1 => Self::of_channels(names),
            _ => Ok(Self(Arrangement::Shared(names.into()))),
        }
    }

    /// The name used in files, options and messages; `channels` for layouts with named channels, and `shared`
    /// where they have common coefficients.
    pub fn name(&self) -> &'static str {
        match self.0 {
            Arrangement::Luminance => "luminance",
            Arrangement::Rgb => "rgb",
            Arrangement::Lrgb => "lrgb",
            Arrangement::Named(_) => "channels",
            Arrangement::Shared(_) => "shared",
        }
    }

    /// Whether the channels are those of a basis with that many values of a function
    /// ([`Basis::channels`](super::Basis::channels)).
    pub fn takes(&self, values: usize) -> bool {
        values == if self.is_shared() { self.channels() } else { 1 }
    }

    /// Layouts of each kind that a basis takes, for tests that run over the family.
    pub fn examples(basis: &super::Basis) -> Vec<Self> {
        let named = Self::of_channels(["base", "metallic", "R", "480 nm", "L"]);
        let shared = Self::shared(RED_GREEN_BLUE);
        let all = Self::COLORS.into_iter().chain(named).chain(shared);
        all.filter(|layout| layout.takes(basis.channels())).collect()
    }

    /// The layout of that name; `None` for those that need the names of their channels.
    pub fn from_name(name: &str) -> Option<Self> {
        Self::COLORS.into_iter().find(|layout| layout.name() == name)
    }

    /// The names of a relit texel's channels, in order.
    pub fn channel_names(&self) -> Vec<&str> {
        match &self.0 {
            Arrangement::Luminance => vec!["L"],
            Arrangement::Rgb | Arrangement::Lrgb => RED_GREEN_BLUE.to_vec(),
            Arrangement::Named(names) | Arrangement::Shared(names) => {
                names.iter().map(String::as_str).collect()
            }
        }
    }

    /// The number of channels of a relit texel.
    pub fn channels(&self) -> usize {
        match &self.0 {
            Arrangement::Luminance => 1,
            Arrangement::Rgb | Arrangement::Lrgb => 3,
            Arrangement::Named(names) | Arrangement::Shared(names) => names.len(),
        }
    }

    /// Whether the channels have names that do not form a colour.
    pub fn is_named(&self) -> bool {
        match &self.0 {
            Arrangement::Named(_) => true,
            Arrangement::Shared(names) => **names != RED_GREEN_BLUE,
            Arrangement::Luminance | Arrangement::Rgb | Arrangement::Lrgb => false,
        }
    }

    /// Whether all channels have the same coefficients, and functions of their own.
    pub fn is_shared(&self) -> bool {
        matches!(self.0, Arrangement::Shared(_))
    }

    /// Whether the planes of a field of constants are a picture: grey, or red, green and blue.
    pub fn is_picture(&self) -> bool {
        matches!(self.0, Arrangement::Luminance | Arrangement::Rgb)
    }

    /// Whether the channels are one function times a colour.
    pub fn is_product(&self) -> bool {
        self.0 == Arrangement::Lrgb
    }

    /// The number of functions of a texel: one per channel, or one for all of them.
    pub fn functions(&self) -> usize {
        if self.is_product() || self.is_shared() { 1 } else { self.channels() }
    }

    /// The number of planes with a basis of `n` functions.
    pub fn planes(&self, n: usize) -> usize {
        self.functions() * n + if self.is_product() { self.channels() } else { 0 }
    }

    /// The first of the `n` planes of the function of a channel.
    pub fn function_plane(&self, channel: usize, n: usize) -> usize {
        if self.is_product() || self.is_shared() { 0 } else { channel * n }
    }

    /// The values of the functions for a channel, of those of a basis of length `n` for a pair of directions.
    pub fn weights<'a, T>(&self, channel: usize, n: usize, values: &'a [T]) -> &'a [T] {
        if self.is_shared() { &values[channel * n..][..n] } else { &values[..n] }
    }

    /// The plane that multiplies the function of a channel, if any.
    pub fn color_plane(&self, channel: usize, n: usize) -> Option<usize> {
        self.is_product().then_some(n + channel)
    }

    /// The meaning of each plane, in order.
    pub fn roles(&self, n: usize) -> Vec<PlaneRole<'_>> {
        if self.is_shared() {
            return (0..n).map(|function| PlaneRole::Shared { function }).collect();
        }
        let channels = self.channel_names();
        let functions = if self.is_product() { vec!["L"] } else { channels.clone() };
        let coefficients = functions
            .into_iter()
            .flat_map(|channel| (0..n).map(move |function| PlaneRole::Coefficient { channel, function }));
        let colors = channels.into_iter().filter(|_| self.is_product());
        coefficients.chain(colors.map(|channel| PlaneRole::Color { channel })).collect()
    }
}

/// Names that files can hold, each once.
fn channel_names<S: Into<String>>(names: impl IntoIterator<Item = S>) -> Result<Vec<String>> {
    let names: Vec<String> = names.into_iter().map(Into::into).collect();
    let unfit = |name: &&String| {
        name.is_empty() || name.chars().any(|c| c == ';' || !(c.is_ascii_graphic() || c == ' '))
    };
    if let Some(name) = names.iter().find(unfit) {
        return Err(Error::usage(format!(
            "the channel name '{}' cannot be stored: use printable ASCII letters without ';'",
            name.escape_default()
        )));
    }
    let distinct = names.iter().collect::<BTreeSet<_>>().len();
    if names.is_empty() || distinct < names.len() {
        return Err(Error::usage(format!(
            "a texture has channels of different names, found {}: {}",
            names.len(),
            names.join(", ")
        )));
    }
    Ok(names)
}

/// As [`PlaneLayout::name`].
impl Serialize for PlaneLayout {
    fn serialize<S: Serializer>(&self, serializer: S) -> std::result::Result<S::Ok, S::Error> {
        serializer.serialize_str(self.name())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::field::Basis;

    fn layouts() -> Vec<PlaneLayout> {
        let shared = PlaneLayout::shared(RED_GREEN_BLUE).unwrap();
        PlaneLayout::examples(&Basis::Constant).into_iter().chain([shared]).collect()
    }

    #[test]
    fn every_plane_has_one_role_and_the_questions_agree_with_it() {
        for layout in layouts() {
            let n = 6;
            let roles = layout.roles(n);
            assert_eq!(roles.len(), layout.planes(n), "{layout:?}");
            assert_eq!(layout.channel_names().len(), layout.channels());
            for (c, &name) in layout.channel_names().iter().enumerate() {
                let of = if layout.is_product() { "L" } else { name };
                for function in 0..n {
                    let plane = layout.function_plane(c, n) + function;
                    let expected = match layout.is_shared() {
                        true => PlaneRole::Shared { function },
                        false => PlaneRole::Coefficient { channel: of, function },
                    };
                    assert_eq!(roles[plane], expected);
                }
                let color = layout.color_plane(c, n).map(|plane| roles[plane]);
                assert_eq!(color, layout.is_product().then_some(PlaneRole::Color { channel: name }));
            }
        }
    }

    #[test]
    fn names_of_layouts_and_channels_come_back() {
        for layout in PlaneLayout::COLORS {
            assert_eq!(PlaneLayout::from_name(layout.name()), Some(layout));
        }
        for layout in layouts().into_iter().filter(|layout| !layout.is_product()) {
            let again = match layout.is_shared() {
                true => PlaneLayout::shared(layout.channel_names()),
                false => PlaneLayout::of_channels(layout.channel_names()),
            };
            assert_eq!(again.unwrap(), layout);
        }
        assert_eq!(PlaneLayout::shared(["L"]).unwrap(), PlaneLayout::LUMINANCE);
    }

    #[test]
    fn channels_that_no_file_could_hold_are_refused() {
        for names in [&[][..], &["a", "a"], &[""], &["a;b"], &["höhe"], &["a\n"]] {
            assert!(PlaneLayout::of_channels(names.iter().copied()).is_err(), "{names:?}");
            assert!(PlaneLayout::shared(names.iter().copied()).is_err(), "{names:?}");
        }
    }
}
