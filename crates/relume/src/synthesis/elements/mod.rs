//! Whole elements of a regular material, laid in random order: stones, tiles, bricks, planks.
//!
//! ```text
//! Exemplar + lattice --agreement--> the copies of each place of a cell
//!                    --joints-----> one outline for all of them, along the joints
//!                    --whole------> the elements that the exemplar shows whole --lay--> SourceMap
//! ```
//!
//! A sample of two by two stones holds too few periods for a tile of several, and blocks cut its stones. But
//! elements at equal places of the lattice are exchangeable: an expert cuts along the joints and lays the
//! stones anew. Here the joints are the places at which all elements agree, whatever joints look like:
//!
//! - [`agreement`]: the copies of each place of a cell in the exemplar, their variance and their colour;
//! - [`joints`]: how unlike a joint each place is, by either, and the outline that runs along the joints;
//! - [`outline`]: the cell whose border is the lowest line of such a ground, by a watershed (F. Meyer, Topographic
//!   distance and watershed lines, Signal Processing 38, 1994) on the torus of the lattice;
//! - [`whole`]: the elements that lie in the exemplar, and a place to copy for the texels they lack;
//! - [`arrange`]: each cell of the output shows one of them, unlike its neighbours;
//! - [`lay()`]: their texels, as a source map.
//!
//! One outline fits running bond, hexagons and oblique lattices alike, because it is periodic by construction
//! and no rectangle. Limits: one kind of element for each cell of the lattice; elements are shifted by whole
//! texels, so joints may be off by one; an exemplar that cuts all of its elements has none to lay.

pub mod agreement;
pub mod arrange;
pub mod joints;
mod lay;
pub mod options;
pub mod outline;
pub mod whole;

pub use lay::{ElementsLaid, lay};
pub use options::ElementOptions;

#[cfg(test)]
mod tests;
