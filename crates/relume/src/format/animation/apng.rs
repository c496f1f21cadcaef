//! Animated PNG (W3C PNG, third edition, section 11.3.3): 8 bits, every frame complete.

use super::{check_rate, common_shape, footprint};
use crate::error::{Error, Result};
use crate::format::{codes, png};
use crate::job::Job;
use crate::picture::Picture;

/// The bytes of an animated PNG that repeats for ever.
///
/// # Errors
/// No frames, frames that differ in size, or a rate of 0.
pub fn encode_apng(frames: &[Picture], frames_per_second: u16) -> Result<Vec<u8>> {
    encode_apng_with(frames, frames_per_second, &Job::unlimited())
}

/// [`encode_apng`] as a part of a job.
///
/// # Errors
/// As [`encode_apng`]; limits exceeded, and a cancelled job.
pub fn encode_apng_with(frames: &[Picture], frames_per_second: u16, job: &Job) -> Result<Vec<u8>> {
    let (size, channels) = common_shape(frames)?;
    check_rate(frames_per_second, u16::MAX)?;
    let count = u32::try_from(frames.len())
        .map_err(|_| Error::usage(format!("{} frames are too many for a PNG", frames.len())))?;
    job.check_bytes("writing the animation", footprint(size, channels, frames.len()).peak)?;
    let mut out = Vec::new();
    let mut encoder = png::encoder(&mut out, size, channels, ::png::BitDepth::Eight)?;
    encoder.set_animated(count, 0).map_err(png::failed)?;
    encoder.set_frame_delay(1, frames_per_second).map_err(png::failed)?;
    let mut writer = encoder.write_header().map_err(png::failed)?;
    for frame in frames {
        writer.write_image_data(&codes::interleaved8(frame, job)?).map_err(png::failed)?;
    }
    writer.finish().map_err(png::failed)?;
    Ok(out)
}
