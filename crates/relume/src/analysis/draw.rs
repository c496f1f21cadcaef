//! An analysis as a picture: the texture with its lattice, the autocorrelation, and the spectrum, side
//! by side.

use std::f64::consts::PI;

use super::{Analysis, trend};
use crate::error::Result;
use crate::job::Job;
use crate::numeric::autocorrelation::Autocorrelation;
use crate::numeric::fourier::{self, Fourier};
use crate::numeric::lattice::{determinant, length};
use crate::numeric::periods::Pattern;
use crate::picture::Picture;
use crate::planes::Planes;
use crate::size::Size;
use crate::space::Space;

/// Colour of lattice lines: orange, which few textures have.
const LINE: [f32; 3] = [1.0, 0.45, 0.05];
/// Half the width of a line, in texels.
const HALF_LINE: f64 = 0.75;
/// The range of the spectrum's greys in dB below its maximum.
const RANGE_DB: f64 = 60.0;

/// Three panels of the size of the texture: the texture as a picture with the lattice drawn on it, the
/// autocorrelation of the analysed planes (grey is 0, white 1, zero shift at the centre), and their spectrum
/// (white is the maximum, black 60 dB below it; the mean at the centre).
///
/// # Errors
/// When the limits are exceeded.
///
/// # Panics
/// When the picture and the planes differ in size.
pub fn draw(picture: &Picture, planes: &Planes, analysis: &Analysis, job: &Job) -> Result<Picture> {
    let size = picture.size();
    assert_eq!(size, planes.size(), "the picture of the analysed planes");
    let whole = Size::new(3 * size.width, size.height);
    let (even, _) = trend::removed(planes);
    let correlation = Autocorrelation::new(&even, Autocorrelation::half(size), job)?;
    let power_db = power_db(&even, job)?;
    let mut out = Planes::zeros_within(job, "the picture of the analysis", whole, 3)?;
    let encoded = picture.to_space(Space::Srgb).planes;
    let centre = [size.width / 2, size.height / 2];
    for (texel, (x, y)) in (0..size.texels()).map(|i| (i, (i % size.width, i / size.width))) {
        let shift = [x as isize - centre[0] as isize, y as isize - centre[1] as isize];
        let grey = 0.5 + 0.5 * if shift == [0, 0] { 1.0 } else { correlation.at(shift[0], shift[1]) };
        let on_line = is_on_line(&analysis.periods.pattern, [x as f64, y as f64]);
        for (c, color) in LINE.into_iter().enumerate() {
            let own = encoded.plane(c.min(encoded.count() - 1))[texel];
            let panels = [if on_line { color } else { own }, grey as f32, power_db[texel]];
            for (panel, value) in panels.into_iter().enumerate() {
                out.plane_mut(c)[whole.index(panel * size.width + x, y)] = value;
            }
        }
    }
    Ok(Picture { planes: out, space: Space::Srgb })
}

/// Whether a position is on a line of the pattern: sides of lattice cells, or borders of stripes.
fn is_on_line(pattern: &Pattern, place: [f64; 2]) -> bool {
    let near = |coordinate: f64, spacing: f64| (coordinate - coordinate.round()).abs() * spacing < HALF_LINE;
    match pattern {
        Pattern::None => false,
        Pattern::Stripes(period) => {
            let across = (place[0] * period[0] + place[1] * period[1]) / length(*period).powi(2);
            near(across, length(*period))
        }
        Pattern::Lattice(lattice) => {
            let [a, b] = lattice.basis();
            let [i, j] = lattice.coordinates(place);
            let area = determinant(a, b).abs();
            near(i, area / length(b)) || near(j, area / length(a))
        }
    }
}

/// The power of all planes under a Hann window, zero frequency in the middle, as greys.
fn power_db(planes: &Planes, job: &Job) -> Result<Vec<f32>> {
    let size = planes.size();
    job.check("the spectrum", size, fourier::BYTES_PER_TEXEL + 16)?;
    let plan = Fourier::new(size);
    let hann = |i: usize, n: usize| 1.0 - (2.0 * PI * (i as f64 + 0.5) / n as f64).cos();
    let mut power = vec![0.0; plan.columns() * size.height];
    for plane in planes.iter() {
        let mean = plane.iter().map(|&v| f64::from(v)).sum::<f64>() / plane.len() as f64;
        let window = |i: usize| hann(i % size.width, size.width) * hann(i / size.width, size.height);
        let image = plane.iter().enumerate().map(|(i, &v)| window(i) * (f64::from(v) - mean)).collect();
        power.iter_mut().zip(plan.forward(image)).for_each(|(sum, bin)| *sum += bin.norm_sqr());
    }
    let most = power.iter().copied().fold(f64::MIN_POSITIVE, f64::max);
    let grey =
        |value: f64| (1.0 + 10.0 * (value.max(f64::MIN_POSITIVE) / most).log10() / RANGE_DB).clamp(0.0, 1.0);
    let at = |i: usize| {
        let k = (i % size.width + size.width - size.width / 2) % size.width;
        let l = (i / size.width + size.height - size.height / 2) % size.height;
        // The other half of the bins mirrors the kept one.
        let (k, l) =
            if k < plan.columns() { (k, l) } else { (size.width - k, (size.height - l) % size.height) };
        grey(power[k * size.height + l]) as f32
    };
    Ok((0..size.texels()).map(at).collect())
}
