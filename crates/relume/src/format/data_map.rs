//! Maps of data, such as roughness, alone or packed as channels of one picture: PNG files that name no colour space.

use super::codes::{code8, code16};
use super::picture::Depth;
use super::png;
use crate::clipping::{Clipper, Clipping};
use crate::error::{Error, Result};
use crate::job::Job;
use crate::planes::Planes;

/// The PNG file of one to four planes of data from 0 to 1; the second of two, and the fourth, is the alpha channel.
///
/// # Errors
/// Another number of planes, and the limits.
pub fn encode_data_map(planes: &Planes, depth: Depth, job: &Job) -> Result<Vec<u8>> {
    let (size, count) = (planes.size(), planes.count());
    if !(1..=4).contains(&count) {
        return Err(Error::invalid(format!("a map of data has 1 to 4 channels, not {count}")));
    }
    job.check("writing the map", size, 6 * count as u64)?;
    job.count_clipped(Clipper::Codes, Clipping::of(planes.as_slice(), Clipper::Codes));
    let texels = (0..size.texels()).flat_map(|texel| (0..count).map(move |k| planes.plane(k)[texel]));
    let (depth, samples) = match depth {
        Depth::Eight => (::png::BitDepth::Eight, texels.map(code8).collect::<Vec<u8>>()),
        Depth::Sixteen => (::png::BitDepth::Sixteen, texels.flat_map(|v| code16(v).to_be_bytes()).collect()),
    };
    png::encode_data(size, count, (depth, &samples), &[])
}
