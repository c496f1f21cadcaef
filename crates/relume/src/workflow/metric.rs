//! Metrics by the names that people know, those of the documents among them.

use crate::error::Result;
use crate::field::{Domain, IndexSpace, Metric, ReflectanceField};
use crate::names::named;

/// What the distance of two texels means, by name.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum NamedMetric {
    /// That of all channels' functions.
    #[default]
    Function,
    /// That of luminance functions and unscaled colours.
    LuminanceAndColor,
    /// That of luminance functions.
    Luminance,
    /// Luminance and colour over the square: the nine numbers of HPL-2003-16.
    Legendre9,
    /// Luminance over the square: the six numbers of its conference version.
    Legendre6,
}

named!(NamedMetric {
    Function => "function",
    LuminanceAndColor => "luminance-color",
    Luminance => "luminance",
    Legendre9 => "legendre9",
    Legendre6 => "legendre6",
});

impl NamedMetric {
    /// The index space of fields like this one. The documents' coordinates are those over the square,
    /// whatever the domain.
    ///
    /// # Errors
    /// As [`IndexSpace::new`].
    pub fn space(self, field: &ReflectanceField, domain: Domain) -> Result<IndexSpace> {
        let (metric, domain) = match self {
            Self::Function => (Metric::Function, domain),
            Self::LuminanceAndColor => (Metric::LuminanceAndColor, domain),
            Self::Luminance => (Metric::Luminance, domain),
            Self::Legendre9 => (Metric::LuminanceAndColor, Domain::Square),
            Self::Legendre6 => (Metric::Luminance, Domain::Square),
        };
        IndexSpace::new(field, metric, domain)
    }
}
