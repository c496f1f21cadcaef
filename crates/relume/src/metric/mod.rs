//! Measures of difference between pictures and fields.

mod psnr;

pub use psnr::{psnr, rmse};
