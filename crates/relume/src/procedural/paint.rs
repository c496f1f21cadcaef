//! From a function of position to the maps of a material, and small functions of shape and colour shared by
//! the materials.

use crate::error::Result;
use crate::job::Job;
use crate::maps::SurfaceMaps;
use crate::microfacet::LEAST_ROUGHNESS;
use crate::parallel;
use crate::planes::Planes;
use crate::size::Size;
use crate::space::linear_from_srgb;
/// A linear colour.
pub type Color = [f64; 3];

/// A material at one position.
#[derive(Debug, Clone, Copy)]
pub struct PaintedTexel {
    /// In texels.
    pub height: f64,
    /// Linear diffuse reflectance, clamped to 0.01..0.95, the range of real materials.
    pub albedo: Color,
    /// GGX roughness, clamped to [`LEAST_ROUGHNESS`]..1.
    pub roughness: f64,
}

/// A material as a function of position, in texels from the middle of the top left texel.
pub type Sampler = dyn Fn([f64; 2]) -> PaintedTexel + Sync;

/// Texels that are computed together before they become samples.
pub(super) const TOGETHER: usize = 1 << 16;

/// Texels that one thread computes together.
const PART: usize = 256;

/// The maps of a function of position, computed in parallel.
///
/// # Errors
/// When the maps exceed the job's limits, or it is cancelled.
pub fn paint(size: Size, sample: Box<Sampler>, job: &Job) -> Result<SurfaceMaps> {
    let zeros = |count| Planes::zeros_within(job, "a material's maps", size, count);
    let (mut height, mut albedo, mut roughness) = (zeros(1)?, zeros(3)?, zeros(1)?);
    let place = |i: usize| [(i % size.width) as f64, (i / size.width) as f64];
    for start in (0..size.texels()).step_by(TOGETHER) {
        job.proceed()?;
        let end = (start + TOGETHER).min(size.texels());
        let parts = (start..end).step_by(PART).map(|first| first..(first + PART).min(end));
        let texels =
            parallel::map(parts, |part| part.map(|i| sample(place(i))).collect::<Vec<PaintedTexel>>());
        for (i, texel) in (start..).zip(texels.iter().flatten()) {
            height.as_mut_slice()[i] = texel.height as f32;
            roughness.as_mut_slice()[i] = texel.roughness.clamp(LEAST_ROUGHNESS, 1.0) as f32;
            for (k, channel) in texel.albedo.iter().enumerate() {
                albedo.plane_mut(k)[i] = channel.clamp(0.01, 0.95) as f32;
            }
        }
    }
    Ok(SurfaceMaps { height, albedo, normal: None, roughness: Some(roughness), metallic: None })
}

/// The linear colour of an sRGB code such as `0xd9a441`.
pub fn srgb(code: u32) -> Color {
    [16, 8, 0].map(|shift| f64::from(linear_from_srgb((code >> shift & 0xff) as f32 / 255.0)))
}

/// Linear interpolation from `a` at 0 to `b` at 1.
pub fn blend(a: Color, b: Color, t: f64) -> Color {
    let t = t.clamp(0.0, 1.0);
    std::array::from_fn(|k| a[k] + (b[k] - a[k]) * t)
}

/// A colour made darker or lighter.
pub fn scale(color: Color, factor: f64) -> Color {
    color.map(|c| c * factor)
}

/// 0 below `low`, 1 above `high`, and the cubic with flat ends in between.
pub fn smoothstep(low: f64, high: f64, x: f64) -> f64 {
    let t = ((x - low) / (high - low)).clamp(0.0, 1.0);
    t * t * (3.0 - 2.0 * t)
}

/// The height of a dome of height 1 at `q`, the squared distance from its centre in radii; zero outside. A
/// `power` of 0.5 is an ellipsoid; higher powers are more pointed.
pub fn dome(q: f64, power: f64) -> f64 {
    (1.0 - q).max(0.0).powf(power)
}
