//! Measures of difference between pictures and fields, and between shapes.
//!
//! [`psnr()`], [`rmse`], [`ssim()`] and [`lab_errors`] compare texel by texel; [`texture`] compares the statistics of
//! textures.

mod ciede2000;
mod lab;
mod psnr;
mod relief;
mod ssim;
pub mod texture;

pub use ciede2000::ciede2000;
pub use lab::{LabErrors, lab_errors};
pub use psnr::{psnr, rmse};
pub use relief::{AngleError, HeightError, angle_error, height_error};
pub use ssim::ssim;
