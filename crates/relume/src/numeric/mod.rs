//! Small dense mathematics that the stages share.

pub mod autocorrelation;
pub mod decibel;
pub mod eigen;
pub mod fourier;
pub mod hash;
pub mod lattice;
pub mod fourier;
pub mod matrix;
pub mod pairs;
pub mod normal;
pub mod periods;
pub mod quadrature;
pub mod random;
pub mod summed_area;
pub mod small;

pub use matrix::Matrix;
