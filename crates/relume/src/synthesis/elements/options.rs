//! Options of the laying of elements.

use crate::error::{Error, Result};
use crate::numeric::lattice::Lattice;
use crate::size::Size;
use crate::synthesis::options::Boundary;

/// Options of [`super::lay`].
#[derive(Debug, Clone, PartialEq)]
pub struct ElementOptions {
    /// Size of the texture in texels.
    pub size: Size,
    /// Whether it tiles.
    pub boundary: Boundary,
    /// The lattice of the elements, if known; otherwise it is measured.
    pub lattice: Option<Lattice>,
    /// Seed of the order of elements.
    pub seed: u64,
}

impl ElementOptions {
    /// The least area of a cell in texels: smaller elements have no inside.
    pub const LEAST_AREA: f64 = 64.0;

    /// Checks the options in isolation; they are checked against the exemplar later.
    ///
    /// # Errors
    /// An output without texels, and cells that are too small.
    pub fn validate(&self) -> Result<()> {
        if self.size.texels() == 0 {
            return Err(Error::usage(format!(
                "an output of {} texels: both sides must be at least 1",
                self.size
            )));
        }
        match self.lattice.map(|lattice| lattice.cell_area()) {
            Some(area) if area < Self::LEAST_AREA => Err(Error::usage(format!(
                "elements of {area:.0} texels are too small to be laid one by one: at least {} are needed; the method \
                 roller makes tiles of many",
                Self::LEAST_AREA
            ))),
            _ => Ok(()),
        }
    }
}

impl Default for ElementOptions {
    /// 256 x 256 texels with open edges, on the lattice that is measured.
    fn default() -> Self {
        Self { size: Size::new(256, 256), boundary: Boundary::Open, lattice: None, seed: 0 }
    }
}
