//! Members of closed families are found by their names.

use relume::capture::Pairing;
use relume::capture::develop::{InputSpace, TurnedFrames};
use relume::capture::dome;
use relume::field::Domain;
use relume::procedural::Cut;
use relume::random_field::SelectionOrder;
use relume::surface::{Estimator, integrate};
use relume::synthesis::fill::FillMethod;
use relume::synthesis::search::{KernelBasis, SearchMethod};
use relume::synthesis::{Blend, Boundary};
use relume::workflow::{NamedMetric, SynthesisMethod};
use relume::{Named, Space};

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
    check::<SynthesisMethod>();
    check::<Domain>();
    check::<SearchMethod>();
    check::<KernelBasis>();
    check::<Blend>();
    check::<Boundary>();
    check::<FillMethod>();
    check::<SelectionOrder>();
    check::<Pairing>();
    check::<InputSpace>();
    check::<TurnedFrames>();
    check::<Space>();
    check::<Cut>();
    check::<Estimator>();
    check::<dome::ReliefBorder>();
    check::<dome::DirectionSampling>();
    check::<integrate::SurfaceBorder>();
    check::<integrate::IntegrationMethod>();
    check::<integrate::Discontinuities>();
}
