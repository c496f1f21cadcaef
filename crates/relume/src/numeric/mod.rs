//! Small dense mathematics that the stages share.

pub mod decibel;
pub mod matrix;
pub mod pairs;
pub mod quadrature;
pub mod random;

pub use matrix::Matrix;
