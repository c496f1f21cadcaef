//! By-example noise: an endless stochastic texture, any texel of which is computed by itself.
//!
//! ```text
//! index planes --decorrelate--> planes --gaussian--> normal planes --grid--> blended --back--> index planes
//! ```
//!
//! E. Heitz, F. Neyret, "High-Performance By-Example Noise using a Histogram-Preserving Blending
//! Operator", HPG 2018. The plane is covered by a grid of triangles; each vertex shows a part of the
//! exemplar drawn by a hash of its place, and a texel blends the parts of its triangle's three
//! vertices. Blending makes contrasts paler, so it is done on planes whose values are normally
//! distributed, where the variance is restored by a formula, and the histograms are put back
//! afterwards by table.
//!
//! - [`mod@suits`]: textures that repeat or have a direction are refused;
//! - [`gaussian`]: each plane's values to normal ones, and back;
//! - [`grid`]: the three vertices and weights of a texel;
//! - [`model`]: all together.
//!
//! Where we differ: planes are turned to their principal axes instead of colours only, so that any
//! reflectance field can be made; parts are taken from inside the exemplar, which therefore need
//! not tile; texels are copied at whole distances, so nothing is interpolated.
//!
//! Limits: there are no source maps, for texels are sums of three. Features larger than a triangle
//! (gravel's stones) become ghosts. The planes are uncorrelated, not independent: values may be
//! blended that the exemplar does not hold.

pub mod gaussian;
pub mod grid;
pub mod model;
pub mod suits;

pub use model::{Noise, NoiseOptions};
pub use suits::{Suitability, suits};
