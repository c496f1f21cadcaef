//! What is fitted to each texel, and how.

use crate::error::{Error, Result};
use crate::field::{Basis, MOST_LOBES, MOST_PRODUCTS, TexelModel, ViewFunction};
use crate::space::Space;

/// What is fitted to each texel.
#[derive(Debug, Clone, PartialEq)]
pub enum ParametricForm {
    /// A diffuse part and so many lobes of light and view.
    Lafortune(usize),
    /// A glossy dielectric on a tilted facet.
    Ggx,
    /// A function of the light for each view.
    PerView(ViewFunction),
    /// So many products of a function of the view and one of the light, of values in a space.
    Separable(usize, Space),
}

impl ParametricForm {
    /// The forms of fixed name: others are `views-` and the name of a basis of functions of light, and `separable` and a number
    /// of products.
    pub const NAMES: [&'static str; 5] =
        ["lafortune1", "lafortune2", "ggx", "views-lafortune1", "views-lafortune2"];

    /// The numbers of a texel of so many channels, views and lights.
    pub fn numbers(&self, channels: usize, views: usize, lights: usize) -> usize {
        match self {
            Self::Lafortune(lobes) => TexelModel::Lafortune { lobes: *lobes }.numbers(channels),
            Self::Ggx => TexelModel::Ggx.numbers(channels),
            Self::PerView(function) => views * function.numbers(channels),
            Self::Separable(products, _) => products * (views + channels * lights),
        }
    }

    /// The form of that name; functions of a basis, and products, are fitted to values in a space.
    pub fn from_name(name: &str, space: Space) -> Option<Self> {
        if let Some(products) = name.strip_prefix("separable") {
            let products = products.parse().ok().filter(|products| (1..=MOST_PRODUCTS).contains(products));
            return products.map(|products| Self::Separable(products, space));
        }
        Some(match name {
            "lafortune1" => Self::Lafortune(1),
            "lafortune2" => Self::Lafortune(2),
            "ggx" => Self::Ggx,
            "views-lafortune1" => Self::PerView(ViewFunction::Lobes(1)),
            "views-lafortune2" => Self::PerView(ViewFunction::Lobes(2)),
            _ => {
                let basis = Basis::from_name(name.strip_prefix("views-")?)?;
                Self::PerView(ViewFunction::Basis(basis, space))
            }
        })
    }
}

/// What the numbers of facets are for.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum FacetAim {
    /// Pictures near to the photographs: every photograph counts alike.
    #[default]
    Pictures,
    /// Maps for other programs: photographs from above count more, and shadows less, so that roughness, normals and colours
    /// are nearer to those of the surface, and pictures are worse.
    Maps,
}

/// The options of a fit of reflectance models.
#[derive(Debug, Clone, PartialEq)]
pub struct ParametricOptions {
    /// What is fitted to each texel.
    pub form: ParametricForm,
    /// The most pairs of light and view to which lobes and facets of a texel are fitted, spread evenly over all.
    pub pairs: usize,
    /// Every so-manieth light and view is left out of the fit, and its photographs are predicted; `None` leaves none out.
    pub hold_out: Option<usize>,
    /// At most this many texels, on a regular grid, are compared with the photographs.
    pub report_texels: usize,
    /// What the numbers of facets are for; other forms do not depend on it.
    pub aim: FacetAim,
}

impl ParametricOptions {
    /// The usual options of a form.
    pub fn of(form: ParametricForm) -> Self {
        Self { form, pairs: 1024, hold_out: None, report_texels: 1024, aim: FacetAim::Pictures }
    }

    /// Checks the options before a photograph is read.
    ///
    /// # Errors
    /// No lobe or more than [`MOST_LOBES`], fewer pairs than parameters, no texel to compare, and a step of less than 2 of
    /// what is left out.
    pub fn validate(&self) -> Result<()> {
        if let ParametricForm::Lafortune(n) | ParametricForm::PerView(ViewFunction::Lobes(n)) = self.form
            && !(1..=MOST_LOBES).contains(&n)
        {
            return Err(Error::usage(format!("1 to {MOST_LOBES} lobes are fitted, not {n}")));
        }
        if self.pairs < LEAST_PAIRS {
            return Err(Error::usage(format!(
                "a texel is fitted to at least {LEAST_PAIRS} pairs of light and view, not {}",
                self.pairs
            )));
        }
        if self.report_texels == 0 {
            return Err(Error::usage("the error report needs at least 1 texel, found 0"));
        }
        if self.hold_out.is_some_and(|step| step < 2) {
            return Err(Error::usage("leaving out every first light and view leaves none: give 2 or more"));
        }
        Ok(())
    }
}

/// The fewest pairs, or lights of a view, that determine a model.
pub(super) const LEAST_PAIRS: usize = 8;
