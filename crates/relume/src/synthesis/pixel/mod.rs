//! Pixel methods: synthesis of one texel after another, each a copy of an exemplar texel with surroundings
//! like those already placed.
//!
//! ```text
//! Exemplar --quantise--> codes --+
//! Lattice --front--> texel --window--> query --scan--> matches --draw--> texel --> Lattice
//! ```
//!
//! - [`mod@efros_leung`]: outward from a seed, by weighted windows;
//! - [`mod@wei_levoy`]: in scanline order from noise, coarse to fine; [`pyramid`]: its resolutions; [`tsvq`]:
//!   a tree that finds near [`vectors`]; or few candidates, which continue their surroundings;
//! - [`mod@patch_match`]: the output improved as a whole, coarse to fine, by matching its patches;
//! - [`grow`]: growth, shared with hole filling; [`front`]: its order;
//! - [`canvas`]: the output under construction; [`window`]: the compared surroundings and their weights;
//! - [`scan`]: the search, many positions at a time, by a `target` for each query and exemplar whose sums are
//!   in `kernel`; [`sieve`]: its lower bounds; [`plain`]: its slow truth.
//!
//! All decisions are made on integers, as in block synthesis.

pub mod canvas;
pub mod efros_leung;
pub mod front;
pub mod grow;
mod kernel;
pub mod patch_match;
pub mod plain;
pub mod pyramid;
pub mod scan;
pub mod sieve;
mod target;
pub mod tsvq;
pub mod vectors;
pub mod wei_levoy;
pub mod window;

pub use efros_leung::{EfrosLeungOptions, efros_leung};
pub use grow::Growth;
pub use patch_match::{PatchMatchOptions, PatchSearch, patch_match};
pub use wei_levoy::{NeighbourSearch, WeiLevoyOptions, wei_levoy};
