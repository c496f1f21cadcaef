//! Portable FloatMap, `.pfm`: linear floats without compression (P. Debevec, "PFM", 2001; Netpbm, `pfm`(5)).
//!
//! Three lines of text and then the samples: `PF` for RGB or `Pf` for grey; width and height; a scale that is
//! negative for little-endian samples. **Rows run from the bottom up.** The magnitude of the scale is a unit that
//! programs interpret differently; it is not applied, and one other than 1 becomes a remark.

use super::finite;
use crate::error::{Error, Result};
use crate::job::Job;
use crate::picture::Picture;
use crate::raster::{Raster, Samples};
use crate::size::Size;

/// The longest header that is read.
const MAX_HEADER: usize = 256;

/// What the header says, and where the samples begin.
struct PfmHeader {
    channels: usize,
    size: Size,
    scale: f64,
    start: usize,
}

/// The picture in the bytes of a file.
pub(super) fn decode(bytes: &[u8], job: &Job) -> Result<Raster> {
    let PfmHeader { channels, size, scale, start } = header(bytes)?;
    let data = &bytes[start..];
    let expected = 4 * size.width as u128 * size.height as u128 * channels as u128;
    if data.len() as u128 != expected {
        return Err(Error::invalid(format!(
            "the PFM header says {size} texels of {channels} channels, which are {expected} bytes, and {} follow: the \
             file is damaged or truncated",
            data.len()
        )));
    }
    job.check("the PFM picture", size, 4 * channels as u64)?;
    if scale.abs() != 1.0 {
        job.remark(format!("the scale {} of the PFM file is not applied", scale.abs()));
    }
    let float = if scale < 0.0 { f32::from_le_bytes } else { f32::from_be_bytes };
    let rows = data.chunks_exact(4 * channels * size.width).rev();
    let samples: Vec<f32> =
        rows.flat_map(|row| row.chunks_exact(4).map(|b| float([b[0], b[1], b[2], b[3]]))).collect();
    let names: &[&str] = if channels == 1 { &["Y"] } else { &["R", "G", "B"] };
    finite::check(&samples, size, |i| names[i % channels], |i| i / channels)?;
    Raster::new(size, channels, Samples::F32(samples))
}

fn header(bytes: &[u8]) -> Result<PfmHeader> {
    let broken = || {
        Error::invalid(
            "the PFM header is broken: expected PF or Pf, width and height, and a scale that is not 0",
        )
    };
    let mut at = 0;
    let mut word = || -> Option<&str> {
        let head = &bytes[..bytes.len().min(MAX_HEADER)];
        let begin = at + head[at..].iter().position(|byte| !byte.is_ascii_whitespace())?;
        let end = begin + head[begin..].iter().position(u8::is_ascii_whitespace)?;
        // One byte of white space follows the last word.
        at = end + 1;
        std::str::from_utf8(&head[begin..end]).ok()
    };
    let words: Option<Vec<&str>> = (0..4).map(|_| word()).collect();
    let words = words.ok_or_else(broken)?;
    let channels = if words[0] == "PF" { 3 } else { 1 };
    let side = |text: &str| text.parse::<usize>().map_err(|_| broken());
    let size = Size::new(side(words[1])?, side(words[2])?);
    let scale = words[3].parse::<f64>().ok().filter(|scale| scale.is_finite() && *scale != 0.0);
    Ok(PfmHeader { channels, size, scale: scale.ok_or_else(broken)?, start: at })
}

/// The bytes of a picture of linear values, little-endian.
pub(super) fn encode(linear: &Picture) -> Vec<u8> {
    let (size, channels) = (linear.size(), linear.planes.count());
    let kind = if channels == 1 { "Pf" } else { "PF" };
    let mut out = format!("{kind}\n{} {}\n-1.0\n", size.width, size.height).into_bytes();
    for y in (0..size.height).rev() {
        for x in 0..size.width {
            (0..channels).for_each(|c| out.extend(linear.planes.at(c, x, y).to_le_bytes()));
        }
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::limits::Limits;
    use crate::planes::Planes;
    use crate::space::Space;

    fn read(bytes: &[u8]) -> Result<Raster> {
        decode(bytes, &Job::default())
    }

    #[test]
    fn rows_run_from_the_bottom_in_both_byte_orders() {
        let values = [1.0f32, 2.0, 3.0, 4.0];
        let big: Vec<u8> = values.iter().flat_map(|v| v.to_be_bytes()).collect();
        let little: Vec<u8> = values.iter().flat_map(|v| v.to_le_bytes()).collect();
        for file in [[b"Pf\n2 2\n1.0\n", &big[..]].concat(), [b"Pf\r2\t2 -1 ", &little[..]].concat()] {
            let raster = read(&file).unwrap();
            assert_eq!(raster.samples(), &Samples::F32(vec![3.0, 4.0, 1.0, 2.0]));
        }
    }

    #[test]
    fn pictures_come_back_bit_by_bit() {
        for channels in [1, 3] {
            let size = Size::new(5, 3);
            let values = (0..15 * channels).map(|i| i as f32 / 7.0 - 1.0).collect();
            let planes = Planes::from_vec(size, channels, values).unwrap();
            let picture = Picture { planes, space: Space::Linear };
            assert_eq!(read(&encode(&picture)).unwrap().to_picture(Space::Linear), picture);
        }
    }

    #[test]
    fn broken_files_are_refused_before_memory_is_taken() {
        let file = [b"PF\n2 1\n-1.0\n", &[0; 24][..]].concat();
        assert!(read(&file).is_ok());
        (0..file.len()).for_each(|length| assert!(read(&file[..length]).is_err(), "{length}"));
        for header in ["PF\n2 1\n0\n", "PF\n-2 1\n-1\n", "PF\n2 1\nnan\n", "PF\n0 1\n-1\n", "PF 2 1 # -1\n"] {
            assert!(read(&[header.as_bytes(), &[0; 24]].concat()).is_err(), "{header}");
        }
        let bomb = read(b"PF\n100000 100000\n-1.0\n").unwrap_err().to_string();
        assert!(bomb.contains("120000000000 bytes, and 0 follow"), "{bomb}");
        let small = Job::new(Limits { max_bytes: 8, ..Limits::default() });
        assert!(decode(&file, &small).unwrap_err().to_string().contains("of memory"));
        let nan = [b"Pf\n1 1\n-1.0\n", &f32::NAN.to_le_bytes()[..]].concat();
        assert!(read(&nan).unwrap_err().to_string().contains("'Y' is NaN"));
        let job = Job::default();
        decode(&[b"Pf\n1 1\n-2.5\n", &[0; 4][..]].concat(), &job).unwrap();
        assert!(job.remarks()[0].contains("scale 2.5"));
    }
}
