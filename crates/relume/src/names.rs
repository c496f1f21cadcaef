//! Names of the members of closed families: the same in options, reports and files.

/// A closed family of which every member has a name.
///
/// ```
/// use relume::Named;
/// use relume::synthesis::Blend;
///
/// assert_eq!(Blend::GraphCut.name(), "graphcut");
/// assert_eq!(Blend::from_name("alpha"), Some(Blend::Alpha));
/// assert_eq!(Blend::from_name("paste"), None);
/// ```
pub trait Named: Copy + 'static {
    /// All members, in the order in which they are offered.
    const ALL: &'static [Self];

    /// The member's name.
    fn name(self) -> &'static str;

    /// The member of that name.
    fn from_name(name: &str) -> Option<Self> {
        Self::ALL.iter().copied().find(|member| member.name() == name)
    }
}

/// Implements [`Named`] by a table of members and names.
macro_rules! named {
    ($family:ty { $($member:ident => $name:literal),+ $(,)? }) => {
        impl $crate::names::Named for $family {
            const ALL: &'static [Self] = &[$(Self::$member),+];

            fn name(self) -> &'static str {
                match self {
                    $(Self::$member => $name),+
                }
            }
        }
    };
}

pub(crate) use named;

#[cfg(test)]
mod tests {
    use super::*;
    use crate::capture::Pairing;
    use crate::capture::dome;
    use crate::field::Domain;
    use crate::procedural::Cut;
    use crate::random_field::SelectionOrder;
    use crate::surface::{Estimator, integrate};
    use crate::synthesis::fill::FillMethod;
    use crate::synthesis::search::{KernelBasis, SearchMethod};
    use crate::synthesis::{Blend, Boundary};
    use crate::workflow::{Method, NamedMetric};

    fn check<T: Named + PartialEq + std::fmt::Debug>() {
        for (k, member) in T::ALL.iter().enumerate() {
            assert_eq!(T::from_name(member.name()), Some(*member));
            assert!(!T::ALL[..k].contains(member), "{member:?} is listed twice");
        }
        assert_eq!(T::from_name(""), None);
    }

    #[test]
    fn every_member_is_found_by_its_name() {
        check::<NamedMetric>();
        check::<Method>();
        check::<Domain>();
        check::<SearchMethod>();
        check::<KernelBasis>();
        check::<Blend>();
        check::<Boundary>();
        check::<FillMethod>();
        check::<SelectionOrder>();
        check::<Pairing>();
        check::<crate::space::Space>();
        check::<Cut>();
        check::<Estimator>();
        check::<dome::Border>();
        check::<integrate::Border>();
        check::<integrate::Method>();
    }
}
