//! Animated pictures that repeat for ever: APNG in full colour, GIF with a common palette.

mod apng;
#[cfg(feature = "gif")]
mod gif;
#[cfg(feature = "gif")]
mod palette;

pub use apng::{encode_apng, encode_apng_with};
#[cfg(feature = "gif")]
pub use gif::{encode_gif, encode_gif_with};

use crate::error::{Error, Result};
#[cfg(not(feature = "gif"))]
use crate::job::Job;
use crate::memory::Footprint;
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

/// As [`encode_gif`].
///
/// # Errors
/// Always.
#[cfg(not(feature = "gif"))]
pub fn encode_gif_with(frames: &[Picture], frames_per_second: u16, _job: &Job) -> Result<Vec<u8>> {
    encode_gif(frames, frames_per_second)
}

/// The memory of an animation, beside its frames: the codes of all frames, and the file, of at most as many
/// bytes, in a buffer that doubles as it grows.
pub fn footprint(size: Size, channels: usize, frames: usize) -> Footprint {
    let codes = (channels * frames) as u64;
    Footprint::of_texels(size, 3 * codes, codes)
}

/// The memory of an animated GIF: that of any animation, and the tables in which its colours are counted.
pub fn gif_footprint(size: Size, channels: usize, frames: usize) -> Footprint {
    let all = footprint(size, channels, frames);
    Footprint { peak: all.peak.saturating_add(COUNTED_COLORS_BYTES), ..all }
}

/// Counts, occurring colours and entries for 64 x 64 x 64 colours.
const COUNTED_COLORS_BYTES: u64 = (32 + 16 + 1) << 18;

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
