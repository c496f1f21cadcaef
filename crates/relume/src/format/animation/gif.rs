//! Animated GIF (GIF89a, CompuServe 1990) with one palette for all frames, without dithering.

use super::palette::Palette;
use super::{check_rate, common_shape, gif_footprint};
use crate::error::{Error, Result};
use crate::format::codes;
use crate::job::Job;
use crate::picture::Picture;
use crate::size::Size;

/// Delays are whole hundredths of a second, and browsers slow down frames shorter than two.
const MOST_FRAMES_PER_SECOND: u16 = 50;

/// The bytes of an animated GIF that repeats for ever. Grey frames keep their 8-bit codes; colours
/// are reduced to 256.
///
/// # Errors
/// No frames, frames that differ in size, sides over 65,535, or a rate outside 1 to 50.
pub fn encode_gif(frames: &[Picture], frames_per_second: u16) -> Result<Vec<u8>> {
    encode_gif_with(frames, frames_per_second, &Job::unlimited())
}

/// [`encode_gif`] as a part of a job.
///
/// # Errors
/// As [`encode_gif`]; limits exceeded, and a cancelled job.
pub fn encode_gif_with(frames: &[Picture], frames_per_second: u16, job: &Job) -> Result<Vec<u8>> {
    let (size, channels) = common_shape(frames)?;
    check_rate(frames_per_second, MOST_FRAMES_PER_SECOND)?;
    let Size { width, height } = size;
    let sides = u16::try_from(width).ok().zip(u16::try_from(height).ok());
    let (width, height) = sides.ok_or_else(|| {
        Error::usage(format!("a GIF has sides up to 65535 texels, not {width} x {height}: write PNG instead"))
    })?;
    job.check_bytes("writing the animation", gif_footprint(size, channels, frames.len()).peak)?;
    let codes: Vec<Vec<u8>> =
        frames.iter().map(|frame| codes::interleaved8(frame, job)).collect::<Result<_>>()?;
    let palette = match channels {
        1 => Palette::greys(),
        _ => Palette::of_colors(codes.iter().flat_map(|frame| frame.as_chunks().0)),
    };
    let mut out = Vec::new();
    let mut encoder = ::gif::Encoder::new(&mut out, width, height, &palette.bytes()).map_err(failed)?;
    encoder.set_repeat(::gif::Repeat::Infinite).map_err(failed)?;
    for (i, frame) in codes.into_iter().enumerate() {
        job.proceed()?;
        let buffer = match channels {
            1 => frame,
            _ => frame.as_chunks().0.iter().map(|color| palette.index_of(color)).collect(),
        };
        let delay = delay_centiseconds(i, frames_per_second);
        let frame = ::gif::Frame { width, height, delay, buffer: buffer.into(), ..::gif::Frame::default() };
        encoder.write_frame(&frame).map_err(failed)?;
    }
    drop(encoder);
    Ok(out)
}

/// The delay of frame `i`: whole hundredths of a second that keep pace with the rate in the long run.
fn delay_centiseconds(i: usize, frames_per_second: u16) -> u16 {
    let rate = u64::from(frames_per_second);
    let time = |frame: usize| (frame as u64 * 100 + rate / 2) / rate;
    (time(i + 1) - time(i)) as u16
}

fn failed(error: ::gif::EncodingError) -> Error {
    match error {
        ::gif::EncodingError::Io(error) => Error::io("cannot write the GIF animation", &error),
        _ => Error::limit("a GIF file cannot hold frames of this size: write PNG"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn delays_keep_step_with_the_rate() {
        for rate in 1..=MOST_FRAMES_PER_SECOND {
            let delays: Vec<u16> = (0..usize::from(rate) * 3).map(|i| delay_centiseconds(i, rate)).collect();
            assert_eq!(delays.iter().map(|&d| u32::from(d)).sum::<u32>(), 300);
            assert!(delays.iter().all(|&d| d >= 2));
        }
    }
}
