//! Measures of difference between pictures and fields, and between shapes.
//!
//! [`psnr()`] and [`rmse`] compare texel by texel; [`texture`] compares the statistics of textures.

mod psnr;
mod relief;
pub mod texture;

pub use psnr::{psnr, rmse};
pub use relief::{AngleError, HeightError, angle_error, height_error};
