//! Measures of difference between pictures and fields.
//!
//! [`psnr()`] and [`rmse`] compare texel by texel; [`texture`] compares what textures are made of.

mod psnr;
pub mod texture;

pub use psnr::{psnr, rmse};
