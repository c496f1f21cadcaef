//! Animated pictures that repeat for ever: APNG in full colour, GIF with a common palette.

mod apng;
#[cfg(feature = "gif")]
mod gif;
#[cfg(feature = "gif")]
mod palette;

pub use apng::encode_apng;
#[cfg(feature = "gif")]
pub use gif::encode_gif;

use crate::error::{Error, Result};
use crate::picture::Picture;
use crate::size::Size;

/// Refuses to write GIF in a build without it.
///
/// # Errors
/// Always.
#[cfg(not(feature = "gif"))]
pub fn encode_gif(_frames: &[Picture], _frames_per_second: u16) -> Result<Vec<u8>> {
    Err(Error::unsupported("this build writes no GIF files: write PNG, or build with the feature 'gif'"))
}

/// The size and the number of channels of all frames.
fn common_shape(frames: &[Picture]) -> Result<(Size, usize)> {
    let first = frames.first().ok_or_else(|| Error::usage("an animation needs at least one frame"))?;
    let (size, channels) = (first.size(), first.planes.count());
    for (i, frame) in frames.iter().enumerate() {
        let (own_size, own_channels) = (frame.size(), frame.planes.count());
        if (own_size, own_channels) != (size, channels) {
            return Err(Error::invalid(format!(
                "frame {i} has {own_size} texels and {own_channels} channels, the first {size} and {channels}: \
                 all frames must be alike"
            )));
        }
    }
    if !matches!(channels, 1 | 3) {
        return Err(Error::invalid(format!("a picture has 1 or 3 channels, not {channels}")));
    }
    Ok((size, channels))
}

/// Refuses rates that a format cannot show.
fn check_rate(frames_per_second: u16, most: u16) -> Result<()> {
    if (1..=most).contains(&frames_per_second) {
        return Ok(());
    }
    Err(Error::usage(format!("the format shows 1 to {most} frames a second, not {frames_per_second}")))
}
