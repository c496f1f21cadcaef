//! Reflectance fields of single views (T. Malzbender, D. Gelb, H. Wolters 2001 for one view; of textures of light and view:
//! J. Meseth, G. Müller, R. Klein, "Preserving Realism in Real-Time Rendering of Bidirectional Texture Functions", OpenSG
//! 2003; J. Filip, M. Haindl, "Non-linear Reflectance Model for Bidirectional Texture Function Synthesis", ICPR 2004): a
//! function of the light for each measured view and texel, and between views a mean of those around, weighted as in the
//! triangles of [`Triangulation`]. Beyond the last ring of views the nearest point of its border counts.

use std::sync::Arc;

use super::lobes;
use crate::direction::Direction;
use crate::error::{Error, Result};
use crate::field::Basis;
use crate::numeric::between::{Shares, Triangulation};
use crate::space::Space;

/// The most views or lights, and the most numbers of a texel: planes in one file.
const MOST_DIRECTIONS: usize = 4096;
pub(super) const MOST_NUMBERS: usize = 1 << 16;

/// What the reflectance of one view is made of.
#[derive(Debug, Clone, PartialEq)]
pub enum ViewFunction {
    /// Functions of the light, with values in a space.
    Basis(Basis, Space),
    /// A diffuse part and so many lobes around directions of the light, linear.
    Lobes(usize),
}

impl ViewFunction {
    /// The numbers of a texel for a view.
    pub fn numbers(&self, channels: usize) -> usize {
        match self {
            Self::Basis(basis, _) => channels * basis.len(),
            Self::Lobes(lobes) => lobes::count(channels, *lobes),
        }
    }

    /// The names of these numbers.
    pub(super) fn names(&self, channels: &[&str]) -> Vec<String> {
        match self {
            Self::Basis(basis, _) => {
                let functions = basis.function_names();
                let of_channel = |c: &&str| {
                    functions.iter().map(|f| format!("{}.{f}.{c}", basis.name())).collect::<Vec<_>>()
                };
                channels.iter().flat_map(of_channel).collect()
            }
            Self::Lobes(lobes) => lobes::names(channels, *lobes),
        }
    }
}

/// The views of reflectance fields, and what each is made of.
#[derive(Debug, Clone)]
pub struct PerViewModel {
    views: Arc<[Direction]>,
    around: Arc<Triangulation>,
    function: ViewFunction,
}

impl PerViewModel {
    /// Reflectance fields of distinct views.
    ///
    /// # Errors
    /// No view or too many, two that are equal, functions that are not of light alone, and lobes that are none or too many.
    pub fn new(views: &[Direction], function: ViewFunction) -> Result<Self> {
        check_directions("reflectance fields", "view", views)?;
        match &function {
            ViewFunction::Basis(Basis::Learned(_), _) => {
                return Err(Error::invalid(
                    "reflectance fields of single views have functions of light alone",
                ));
            }
            ViewFunction::Lobes(0) => return Err(Error::invalid("a view has at least one lobe")),
            ViewFunction::Lobes(n) if *n > lobes::MOST_LOBES => {
                return Err(Error::invalid(format!(
                    "a view has at most {} lobes, not {n}",
                    lobes::MOST_LOBES
                )));
            }
            ViewFunction::Basis(..) | ViewFunction::Lobes(_) => {}
        }
        let numbers = views.len() * function.numbers(3);
        if numbers > MOST_NUMBERS {
            return Err(Error::invalid(format!(
                "{} views have {numbers} numbers a texel: more than {MOST_NUMBERS} are not kept",
                views.len()
            )));
        }
        let around = Arc::new(Triangulation::new(views));
        Ok(Self { views: views.into(), around, function })
    }

    /// The views.
    pub fn views(&self) -> &[Direction] {
        &self.views
    }

    /// What each is made of.
    pub fn function(&self) -> &ViewFunction {
        &self.function
    }

    /// The views around one, and their shares.
    pub fn shares(&self, view: Direction) -> Shares {
        self.around.shares(view)
    }
}

/// Refuses directions of models that are none, too many, or not distinct.
pub(super) fn check_directions(models: &str, kind: &str, directions: &[Direction]) -> Result<()> {
    if directions.is_empty() || directions.len() > MOST_DIRECTIONS {
        return Err(Error::invalid(format!(
            "{models} are of 1 to {MOST_DIRECTIONS} {kind}s, not of {}",
            directions.len()
        )));
    }
    let twice = (1..directions.len()).find(|&i| directions[..i].contains(&directions[i]));
    twice.map_or(Ok(()), |i| {
        let [x, y, z] = directions[i].to_array();
        Err(Error::invalid(format!("the {kind} ({x}, {y}, {z}) is given twice")))
    })
}

/// Equal views and functions: the triangles follow from the views.
impl PartialEq for PerViewModel {
    fn eq(&self, other: &Self) -> bool {
        self.views == other.views && self.function == other.function
    }
}
