//! The images of a virtual gonioreflectometer as files, a few at a time.

use super::capture::PhotographFormat;
use crate::capture::dome::Gonioreflectometer;
use crate::error::Result;
use crate::format::{encode_picture_with, ubo2003};
use crate::job::Job;
use crate::memory::Footprint;
use crate::picture::Picture;
use crate::size::Size;

/// Images per thread that are made before they are written.
const AT_A_TIME: usize = 8;

/// The memory of one image and its file, beside the gonioreflectometer.
pub fn footprint(size: Size, format: PhotographFormat) -> Footprint {
    let (image, file) =
        (Gonioreflectometer::image_footprint(size), format.picture_format().footprint(size, 3));
    Footprint { peak: image.peak.saturating_add(file.peak), kept: file.kept }
}

/// Makes the image of every pair and passes its name ([`ubo2003`]) and bytes to `keep`, in order. Returns the fraction
/// of values brighter than white, which the files cannot hold. Memory holds eight images a thread, or as many as fit.
///
/// # Errors
/// Errors of the images or of `keep`, and a cancelled job.
pub fn images(
    device: &Gonioreflectometer,
    format: PhotographFormat,
    job: &Job,
    keep: &mut dyn FnMut(&str, &[u8]) -> Result<()>,
) -> Result<f64> {
    let (count, values) = (device.pairs().len(), (device.size().texels() * 3) as f64);
    let one = footprint(device.size(), format).peak;
    let fitting = usize::try_from(job.free_bytes() / one.max(1)).unwrap_or(usize::MAX);
    let batch = (AT_A_TIME * rayon::current_num_threads()).min(count).min(fitting).max(1);
    job.check_bytes("the images made at a time", one * batch as u64)?;
    job.start("measuring", count as u64);
    let mut bright = 0;
    for first in (0..count).step_by(batch) {
        let finish = |picture: Picture| {
            let bright = picture.planes.as_slice().iter().filter(|v| **v > 1.0).count();
            let bytes = encode_picture_with(&picture, format.picture_format(), job)?;
            job.advance(1)?;
            Ok((bytes, bright))
        };
        let made = device.images(first..(first + batch).min(count), finish, job)?;
        for (k, (bytes, above)) in made.into_iter().enumerate() {
            let number = first + k;
            bright += above;
            keep(&ubo2003::image_name(number, device.pairs()[number], format.extension()), &bytes)?;
        }
    }
    let clipped = bright as f64 / (values * count.max(1) as f64);
    Ok(if format == PhotographFormat::Exr { 0.0 } else { clipped })
}
