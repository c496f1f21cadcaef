//! The shape of a surface: normals and albedo from a field or from photographs, and heights.
//!
//! | file | content |
//! |---|---|
//! | `normals`, `argmax` | normals and albedo of a field: the direction of maximal luminance |
//! | `measured_peak` | the same of functions known at measured lights, between these |
//! | `doubts` | whether those normals can be trusted |
//! | `photometric_stereo`, `robust` | normals and albedo from photographs under many lights |
//! | `shared_reflectance`, `reflectance_table`, `bipolynomial` | the same with a reflectance that all texels share |
//! | `shape_from_shading` | slopes from one photograph under a known light |
//! | `highlights` | roughness and the strength of highlights, from what a matt body leaves over |
//! | `slopes` | normals to slopes and back |
//! | `integrate` | slopes to heights: Frankot and Chellappa, Poisson, and the slow truth |

pub mod argmax;
mod bipolynomial;
mod brightest;
mod doubts;
pub mod highlights;
pub mod integrate;
mod luminance;
mod measured_peak;
mod normals;
pub mod photometric_stereo;
mod reflectance_table;
mod robust;
pub mod shape_from_shading;
mod shared_reflectance;
mod slopes;

pub use doubts::{NormalDoubt, doubts};
pub use luminance::luminance;
pub use normals::{albedo, normals, normals_and_albedo};
pub use robust::{Ambient, Estimator};
pub use slopes::{STEEPEST, Slopes};
