//! Numerical tools shared by the stages.

pub mod autocorrelation;
pub mod between;
pub mod cells;
pub mod corner_colors;
pub mod decibel;
pub mod dot;
pub mod eigen;
pub mod endless;
pub mod fourier;
pub mod hash;
pub mod k_means;
pub mod lattice;
pub mod levenberg_marquardt;
pub mod matrix;
pub mod normal;
pub mod orthogonal;
pub mod pairs;
pub mod parts;
pub mod periods;
pub mod principal;
pub mod pyramid;
pub mod quadrature;
pub mod random;
pub mod range_coder;
pub mod shorth;
pub mod signed_distance;
pub mod small;
pub mod summed_area;
pub mod wavelet;

pub use dot::dot;
pub use matrix::Matrix;
