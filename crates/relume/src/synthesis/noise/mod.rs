//! By-example noise: an endless stochastic texture whose texels can be computed independently.
//!
//! ```text
//! index planes --decorrelate--> planes --gaussian--> normal planes --grid--> blended --back--> index planes
//! ```
//!
//! E. Heitz, F. Neyret, "High-Performance By-Example Noise using a Histogram-Preserving Blending Operator",
//! HPG 2018. The plane is covered by a triangle grid; each vertex shows a part of the exemplar drawn by a
//! hash of its place, and a texel blends the parts of the three vertices of its triangle. Blending reduces
//! contrast, so it is done on planes with normally distributed values, where a formula restores the variance;
//! tables then restore the histograms.
//!
//! - [`mod@suits`]: textures that repeat or have a direction are refused;
//! - [`gaussian`]: the values of each plane to normal ones, and back;
//! - [`grid`]: the three vertices and weights of a texel;
//! - [`model`]: the complete model.
//!
//! Where we differ: planes are rotated to their principal axes, not only colours, so that any reflectance
//! field is supported; parts are taken from inside the exemplar, which therefore need not tile; texels are
//! copied at integer distances, so nothing is interpolated.
//!
//! Limits: there are no source maps, because texels are sums of three. Features larger than a triangle
//! (stones of gravel) become ghosts. The planes are uncorrelated, not independent: blended values may not
//! occur in the exemplar.

pub mod gaussian;
pub mod grid;
pub mod model;
pub mod suits;

pub use model::{Noise, NoiseOptions};
pub use suits::{Suitability, suits};
