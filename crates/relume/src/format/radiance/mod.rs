//! Radiance pictures, `.hdr` and `.pic`: linear light of a large range in four bytes a texel.
//!
//! G. Ward, "Real Pixels", Graphics Gems II, 1991: three mantissas share an exponent. A component is m 2^(e - 136), and
//! 0 where e is 0, as in the widespread reader of B. Walter, so that white stays 1; Ward adds half a unit to m. The
//! head is text ([`header`]); all eight orders of texels, flat scanlines and both kinds of runs are read
//! ([`scanline`]). EXPOSURE and COLORCORR are factors that the values of the file contain: they are divided out, which
//! becomes a remark. XYZE is refused.

mod header;
mod scanline;

use super::{finite, plausible};
use crate::error::Result;
use crate::job::Job;
use crate::picture::Picture;
use crate::raster::{Raster, Samples};
use header::{RGBE, RadianceHead};
use scanline::{Rgbe, Scanlines};

/// The exponent e of the unit of the mantissas: m 2^(e - 136).
const UNIT_EXPONENT: i32 = 136;
/// The least bytes of a scanline of more than one texel: a texel, and a run.
const LEAST_LINE_BYTES: u64 = 8;

/// The picture in the bytes of a file.
pub(super) fn decode(bytes: &[u8], job: &Job) -> Result<Raster> {
    let RadianceHead { order, factors, start } = header::read(bytes, job)?;
    let size = order.size;
    job.check("the Radiance picture", size, 4 * 3)?;
    let (lines, places) = order.lines();
    let least = lines as u64 * if places > 1 { LEAST_LINE_BYTES } else { 4 };
    plausible::check("Radiance", size, least, (bytes.len() - start) as u64, 1)?;
    if factors != [1.0; 3] {
        let said = factors.map(|factor| factor.to_string());
        let by = if said.iter().all(|word| *word == said[0]) { said[0].clone() } else { said.join(", ") };
        job.remark(format!("the Radiance file contains the exposure {by}, which is divided out"));
    }
    let mut samples = vec![0.0; 3 * size.texels()];
    let mut scanlines = Scanlines::new(bytes, start);
    let mut line = vec![[0; 4]; places];
    for number in 0..lines {
        scanlines.read(number, &mut line)?;
        for (place, texel) in line.iter().enumerate() {
            let values = linear(*texel);
            let out = &mut samples[3 * order.texel(number, place)..][..3];
            for (out, (value, factor)) in out.iter_mut().zip(values.into_iter().zip(factors)) {
                *out = (value / factor) as f32;
            }
        }
    }
    if scanlines.left() > 0 {
        job.remark(format!(
            "{} bytes after the last scanline of the Radiance file are ignored",
            scanlines.left()
        ));
    }
    finite::check(&samples, size, |i| ["R", "G", "B"][i % 3], |i| i / 3)?;
    Raster::new(size, 3, Samples::F32(samples))
}

fn linear([r, g, b, e]: Rgbe) -> [f64; 3] {
    let unit = if e == 0 { 0.0 } else { f64::from(i32::from(e) - UNIT_EXPONENT).exp2() };
    [r, g, b].map(|mantissa| f64::from(mantissa) * unit)
}

/// The texel nearest to a colour. What is below 0 or not a number is 0; what is too bright is the brightest.
fn rgbe(color: [f32; 3]) -> Rgbe {
    let brightest = f64::from(255) * f64::from(255 - UNIT_EXPONENT).exp2();
    let color = color.map(|v| if v > 0.0 { f64::from(v).min(brightest) } else { 0.0 });
    let largest = color[0].max(color[1]).max(color[2]);
    if largest <= 0.0 {
        return [0; 4];
    }
    // The largest mantissa is 128 to 255: one that rounds up to 256 takes the next exponent.
    let mut exponent = largest.log2().floor() as i32 + UNIT_EXPONENT - 7;
    let mantissas = |exponent: i32| color.map(|v| (v * f64::from(UNIT_EXPONENT - exponent).exp2()).round());
    while mantissas(exponent).iter().any(|&m| m > 255.0) {
        exponent += 1;
    }
    if exponent < 1 {
        return [0; 4];
    }
    let [r, g, b] = mantissas(exponent).map(|m| m as u8);
    [r, g, b, exponent as u8]
}

/// The bytes of a picture of linear values: rows from the top, greys as colours.
pub(super) fn encode(linear: &Picture) -> Vec<u8> {
    let (size, channels) = (linear.size(), linear.planes.count());
    let mut out = format!("#?RADIANCE\nFORMAT={RGBE}\n\n-Y {} +X {}\n", size.height, size.width).into_bytes();
    let mut line = Vec::with_capacity(size.width);
    for y in 0..size.height {
        line.clear();
        let color = |x: usize| std::array::from_fn(|c| linear.planes.at(c.min(channels - 1), x, y));
        line.extend((0..size.width).map(|x| rgbe(color(x))));
        scanline::write(&line, &mut out);
    }
    out
}

#[cfg(test)]
mod tests;
