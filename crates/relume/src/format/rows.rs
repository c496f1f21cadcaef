//! Rows of samples copied in by a callback, for files that are written piece by piece.

use crate::error::Result;

/// Copies texels of a lane into a slice, from column `x` of row `y` to the right: `rows(lane, x, y,
/// row)`. An error ends the writing.
pub type Rows<'a> = dyn FnMut(usize, usize, usize, &mut [u8]) -> Result<()> + 'a;
