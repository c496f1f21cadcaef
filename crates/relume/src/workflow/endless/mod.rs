//! Windows of endless planes, written to a file row by row: of a tile set, of noise, or of a random-field
//! model. A window is the same however the plane is cut, and may be larger than memory.
//!
//! ```text
//! TilePlane | NoisePlane | ModelPlane --drawing(window, target)--> Drawing --write--> file
//! ```
//!
//! - [`tiles`] copies tiles into place; [`noise`] and [`model`] compute [`bands`] of pieces;
//! - [`Drawing`] is their common result: a file about to be written.

pub mod bands;
mod drawing;
pub mod model;
pub mod noise;
pub mod tiles;

use std::str::FromStr;

pub use drawing::{Drawing, FileTarget};
pub use model::ModelPlane;
pub use noise::NoisePlane;
pub use tiles::TilePlane;

use crate::error::Error;
use crate::size::Size;

/// A rectangle of an endless plane.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct PlaneWindow {
    /// Left column.
    pub x: i64,
    /// Top row.
    pub y: i64,
    /// Texels.
    pub size: Size,
}

impl PlaneWindow {
    /// The largest distance of a window from the origin: far beyond any picture, and without overflow.
    pub const FARTHEST: i64 = 1 << 52;

    /// The window of a size at the origin of the plane.
    pub const fn of_size(size: Size) -> Self {
        Self { x: 0, y: 0, size }
    }
}

impl FromStr for PlaneWindow {
    type Err = Error;

    /// `X,Y,W,H` in whole texels.
    fn from_str(text: &str) -> Result<Self, Error> {
        let numbers: Option<Vec<i64>> = text.split(',').map(|s| s.trim().parse().ok()).collect();
        let is_near = |v: i64| v.unsigned_abs() <= Self::FARTHEST as u64;
        match numbers.as_deref() {
            Some(&[x, y, w, h]) if w > 0 && h > 0 && [x, y, w, h].into_iter().all(is_near) => {
                Ok(Self { x, y, size: Size::new(w as usize, h as usize) })
            }
            _ => Err(Error::usage(
                "expected left, top, width and height such as -200,1000,512,512 in whole texels",
            )),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn windows_parse_or_say_what_they_expect() {
        let expected = PlaneWindow { x: -200, y: 1000, size: Size::new(512, 40) };
        assert_eq!("-200,1000, 512,40".parse(), Ok(expected));
        for bad in ["", "1,2,3", "0,0,0,5", "0,0,5,-1", "1,2,3,4,5", "a,0,1,1", "4503599627370497,0,1,1"] {
            assert!(bad.parse::<PlaneWindow>().is_err(), "{bad}");
        }
    }

    #[test]
    fn a_window_at_the_end_of_all_integers_is_refused() {
        assert!("-9223372036854775808,0,16,16".parse::<PlaneWindow>().is_err());
    }
}
