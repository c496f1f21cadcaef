//! The bases that `--basis` names.

use clap::builder::{PossibleValuesParser, TypedValueParser};
use relume::field::{Basis, Interpolation};

/// What is asked for by `--basis`.
#[derive(Debug, Clone, PartialEq)]
pub(super) enum BasisChoice {
    OfLight(Basis),
    Interpolated(Interpolation),
    Learned,
}

impl BasisChoice {
    pub(super) fn name(&self) -> &'static str {
        match self {
            Self::OfLight(basis) => basis.name(),
            Self::Interpolated(rule) => rule.name(),
            Self::Learned => "learned",
        }
    }
}

/// The parser of the option.
pub(super) fn basis() -> impl TypedValueParser<Value = BasisChoice> {
    let of_light = Basis::NAMED.iter().filter(|basis| **basis != Basis::Constant).map(Basis::name);
    let others = Interpolation::ALL.map(Interpolation::name).into_iter().chain([BasisChoice::Learned.name()]);
    PossibleValuesParser::new(of_light.chain(others)).map(|name| {
        let rule = Interpolation::ALL.into_iter().find(|rule| rule.name() == name);
        let of_light = Basis::from_name(&name).map(BasisChoice::OfLight);
        of_light.or(rule.map(BasisChoice::Interpolated)).unwrap_or(BasisChoice::Learned)
    })
}
