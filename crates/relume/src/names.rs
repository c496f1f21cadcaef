//! Names of the members of closed families: the same in options, reports and files.

/// A closed family with a name for every member.
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

    /// The name of the member.
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
