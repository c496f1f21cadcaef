//! Metrics by name, including those of HPL-2003-16.

use crate::error::Result;
use crate::field::{Domain, IndexSpace, Metric, ReflectanceField};
use crate::names::named;

/// The meaning of the distance of two texels, by name.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum NamedMetric {
    /// The distance of the functions of all channels.
    #[default]
    Function,
    /// The distance of luminance functions and unscaled colours.
    LuminanceAndColor,
    /// The distance of luminance functions.
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
    /// The index space of fields like this one. The coordinates of HPL-2003-16 are over the square, whatever
    /// the domain.
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
