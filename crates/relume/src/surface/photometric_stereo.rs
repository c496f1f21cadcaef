//! Photometric stereo: normals and albedo from photographs under many known lights.
//!
//! Each texel is solved independently (`robust`) on linear luminance; the albedo of each channel then follows
//! by weighted least squares along the resulting shading. Photographs are read once if all values fit into
//! memory, otherwise once for each band of rows; the result does not depend on the bands. Lamps are far away,
//! or at known places, and of equal strength, and the camera is straight above. Texels whose values determine no direction (black
//! everywhere) face the viewer.

use super::luminance;
use super::robust::{self, Ambient, Estimator, Scratch};
use super::shared_reflectance::{self, FINAL_STEPS, GridTexel, LightAndHalf, SharedReflectance};
use crate::direction::Direction;
use crate::error::{Error, Result};
use crate::job::Job;
use crate::lamps::LampPositions;
use crate::parallel;
use crate::picture::Picture;
use crate::planes::Planes;
use crate::raster::{LoadRaster, Raster, RasterSequence};
use crate::size::Size;
use crate::space::Space;

/// The most memory for the values of a band.
const BAND_BYTES: u64 = 512 << 20;
/// The least share of the smallest eigenvalue: lights with less spread do not allow stereo.
const LEAST_SPREAD: f64 = 1e-4;
/// Texels that one thread solves together.
const TOGETHER: usize = 256;

/// Options of the solution.
#[derive(Debug, Clone, Copy, PartialEq, Eq, serde::Serialize)]
pub struct StereoOptions {
    /// The treatment of outliers.
    pub estimator: Estimator,
    /// Whether a constant light is estimated.
    pub ambient: Ambient,
}

impl Default for StereoOptions {
    fn default() -> Self {
        Self { estimator: Estimator::Robust, ambient: Ambient::None }
    }
}

/// The result.
#[derive(Debug, Clone, PartialEq)]
pub struct Stereo {
    /// Three planes of unit normals (x right, y up, z out).
    pub normals: Planes,
    /// Linear diffuse reflectance, grey or RGB; a white surface facing the light is 1.
    pub albedo: Picture,
    /// Whether the values of a texel determine a direction.
    pub determined: Vec<bool>,
}

/// The photographs of a surface under known lights.
#[derive(Clone, Copy)]
pub struct StereoInput<'a> {
    /// The name of each photograph and its light.
    pub lights: &'a [(String, Direction)],
    /// Where the lamps are, if they are so near that the direction and strength of their light differ over the surface.
    pub lamps: Option<&'a LampPositions>,
    /// Reads a photograph.
    pub load: &'a LoadRaster<'a>,
}

/// Solves all texels.
///
/// # Errors
/// Fewer than three lights, or lights that (nearly) lie in a plane; errors of `load`; photographs that differ
/// in size or channels; an ambient light with a shared reflectance; sizes beyond the limits of the job.
pub fn photometric_stereo(input: StereoInput, options: &StereoOptions, job: &Job) -> Result<Stereo> {
    let StereoInput { lights, load, .. } = input;
    if (options.estimator, options.ambient) == (Estimator::Shared, Ambient::Constant) {
        return Err(Error::usage(
            "a shared reflectance is estimated without an ambient light: choose one of both",
        ));
    }
    let directions: Vec<[f64; 3]> = lights.iter().map(|(_, light)| light.to_array()).collect();
    check_lights(&directions, options.ambient)?;
    let photographs = RasterSequence::open(load)?;
    let (size, channels) = (photographs.size(), photographs.channels());
    let texel_bytes = 4 * (channels * lights.len()) as u64;
    // Solved texels, of the last band twice, and the planes that are made of them.
    let solved_bytes = (2 * size_of::<Solved>() + 4 * (3 + channels) + 1) as u64;
    job.check("the normals and albedo", size, solved_bytes)?;
    let _solved = job.hold("the normals and albedo", solved_bytes * size.texels() as u64)?;
    let row_bytes = texel_bytes * size.width as u64;
    job.check_bytes("a row of all photographs", row_bytes)?;
    let rows = (BAND_BYTES.min(job.free_bytes() / 2) / row_bytes).clamp(1, size.height as u64) as usize;
    let _band = job.hold("rows of all photographs", row_bytes * rows as u64)?;

    job.start("photometric stereo", (lights.len() * size.height.div_ceil(rows)) as u64);
    let read = |i: usize, top: usize, band: Size| {
        let photograph = photographs.read(i)?;
        check_alike(&photograph, (size, channels), &lights[i].0)?;
        Ok(photograph.crop(0, top, band)?.to_picture(Space::Linear).planes)
    };
    let mut solver = Solver { directions, lamps: input.lamps, options: *options, reflectance: None };
    if options.estimator == Estimator::Shared {
        solver.reflectance = Some(learned(&solver, size, &|i| read(i, 0, size), job)?);
    }
    let mut texels = Vec::with_capacity(size.texels());
    for top in (0..size.height).step_by(rows) {
        let band = Size::new(size.width, rows.min(size.height - top));
        let read = |i: usize| {
            let values = read(i, top, band)?;
            job.advance(1)?;
            Ok(values)
        };
        let values = parallel::try_map(0..lights.len(), read)?;
        texels.extend(solver.solve_band(&values, top, job)?);
    }
    Ok(collect(size, channels, &texels))
}

/// About this many texels show the reflectance that all share.
const SHARED_TEXELS: usize = 6_000;

/// The reflectance that all texels share, from a regular grid of them.
fn learned(
    solver: &Solver,
    size: Size,
    read: &(dyn Fn(usize) -> Result<Planes> + Sync),
    job: &Job,
) -> Result<SharedReflectance> {
    let step = ((size.texels() as f64 / SHARED_TEXELS as f64).sqrt().ceil() as usize).max(1);
    let grid: Vec<usize> = (0..size.height)
        .step_by(step)
        .flat_map(|y| (0..size.width).step_by(step).map(move |x| size.index(x, y)))
        .collect();
    let lights = solver.directions.len();
    job.check_bytes("the shared reflectance", (grid.len() * lights * (8 + 2 * 48 + 2 * 32)) as u64)?;
    let of_photograph = |i: usize| {
        let planes = read(i)?;
        Ok(grid.iter().map(|&texel| luminance::of_texel(&planes, texel)).collect::<Vec<f64>>())
    };
    let columns = parallel::try_map(0..lights, of_photograph)?;
    let texel = |(k, &texel): (usize, &usize)| {
        let mut here = solver.lights_at(texel % size.width, texel / size.width);
        let values: Vec<f64> =
            columns.iter().zip(&here.shares).map(|(column, share)| column[k] / share).collect();
        let matt = robust::solve(
            &here.directions,
            &values,
            (Estimator::Shared, Ambient::None),
            &mut Scratch::default(),
        )?;
        let lights = here.directions.drain(..).map(LightAndHalf::new).collect();
        Some(GridTexel { lights, values, b: matt.b })
    };
    let mut texels: Vec<GridTexel> =
        parallel::map(grid.iter().enumerate(), texel).into_iter().flatten().collect();
    // Texels that are black everywhere, such as those outside a mask, say nothing.
    texels.retain(|texel| texel.values.iter().any(|v| *v > 0.0));
    job.proceed()?;
    Ok(shared_reflectance::learn(&mut texels))
}

/// What is the same for all texels.
struct Solver<'a> {
    directions: Vec<[f64; 3]>,
    lamps: Option<&'a LampPositions>,
    options: StereoOptions,
    reflectance: Option<SharedReflectance>,
}

/// The lights at one texel: unit vectors, and their strengths relative to those in the middle of the surface.
struct LightsHere {
    directions: Vec<[f64; 3]>,
    shares: Vec<f64>,
}

/// A solved texel.
#[derive(Debug, Clone, Copy)]
struct Solved {
    normal: [f32; 3],
    albedo: [f32; 3],
    determined: bool,
}

fn check_lights(lights: &[[f64; 3]], ambient: Ambient) -> Result<()> {
    let least = if ambient == Ambient::Constant { 4 } else { 3 };
    if lights.len() < least {
        return Err(Error::invalid(format!(
            "photometric stereo needs at least {least} lights, found {}",
            lights.len()
        )));
    }
    // The determinant of the mean outer product; for directions spread over the whole sphere it is 1 / 27.
    let mean = |i: usize, j: usize| lights.iter().map(|l| l[i] * l[j]).sum::<f64>() / lights.len() as f64;
    let [a, b, c, d, e, f] = [mean(0, 0), mean(1, 1), mean(2, 2), mean(0, 1), mean(0, 2), mean(1, 2)];
    let determinant = a * (b * c - f * f) - d * (d * c - f * e) + e * (d * f - b * e);
    if 27.0 * determinant < LEAST_SPREAD {
        return Err(Error::invalid(
            "the lights nearly lie in one plane with the surface point: photometric stereo needs lights all around",
        ));
    }
    Ok(())
}

fn check_alike(photograph: &Raster, expected: (Size, usize), name: &str) -> Result<()> {
    if (photograph.size(), photograph.channels()) == expected {
        return Ok(());
    }
    Err(Error::invalid(format!(
        "the photograph {name} is {} texels with {} channels, the first {} with {}: all must match",
        photograph.size(),
        photograph.channels(),
        expected.0,
        expected.1
    )))
}

impl Solver<'_> {
    fn lights_at(&self, x: usize, y: usize) -> LightsHere {
        match self.lamps {
            None => {
                LightsHere { directions: self.directions.clone(), shares: vec![1.0; self.directions.len()] }
            }
            Some(lamps) => {
                let (directions, shares) = (0..self.directions.len()).map(|i| lamps.at(i, x, y)).unzip();
                LightsHere { directions, shares }
            }
        }
    }

    /// The texels of the rows from `top`.
    fn solve_band(&self, photographs: &[Planes], top: usize, job: &Job) -> Result<Vec<Solved>> {
        let size = photographs[0].size();
        let far = self.lights_at(0, 0);
        let how = (self.options.estimator, self.options.ambient);
        let mut solved = vec![UNDETERMINED; size.texels()];
        parallel::try_for_each(solved.chunks_mut(TOGETHER).enumerate(), |(part, solved)| {
            let (mut scratch, mut values) = (Scratch::default(), Vec::with_capacity(photographs.len()));
            for (texel, solved) in (part * TOGETHER..).zip(solved) {
                job.proceed()?;
                let near = self.lamps.map(|_| self.lights_at(texel % size.width, top + texel / size.width));
                let here = near.as_ref().unwrap_or(&far);
                values.clear();
                let of_all = photographs.iter().zip(&here.shares);
                values.extend(of_all.map(|(planes, share)| luminance::of_texel(planes, texel) / share));
                if let Some(matt) = robust::solve(&here.directions, &values, how, &mut scratch) {
                    let matt = self.refined(matt, here, &values);
                    *solved = finish(&matt, here, photographs, &scratch.weights, texel);
                }
            }
            Ok(())
        })?;
        Ok(solved)
    }

    /// The solution under the shared reflectance, if there is one.
    fn refined(&self, matt: robust::Matt, here: &LightsHere, values: &[f64]) -> robust::Matt {
        let Some(reflectance) = &self.reflectance else { return matt };
        let lights: Vec<LightAndHalf> = here.directions.iter().copied().map(LightAndHalf::new).collect();
        robust::Matt {
            b: shared_reflectance::refine(reflectance, &lights, values, matt.b, FINAL_STEPS),
            ..matt
        }
    }
}

const UNDETERMINED: Solved = Solved { normal: [0.0, 0.0, 1.0], albedo: [0.0; 3], determined: false };

/// The unit normal, and the albedo of each channel along the shading.
fn finish(
    matt: &robust::Matt,
    here: &LightsHere,
    photographs: &[Planes],
    weights: &[f64],
    texel: usize,
) -> Solved {
    let length = matt.b.iter().map(|b| b * b).sum::<f64>().sqrt();
    if !(length > 1e-9 && length.is_finite()) || matt.b[2] <= 0.0 {
        return UNDETERMINED;
    }
    let normal = matt.b.map(|b| b / length);
    let shading = |light: &[f64; 3]| {
        let cosine: f64 = light.iter().zip(normal).map(|(l, n)| l * n).sum();
        cosine.max(0.0) + matt.ambient / length
    };
    let LightsHere { directions: lights, shares } = here;
    let below: f64 = lights.iter().zip(weights).map(|(l, w)| w * shading(l).powi(2)).sum();
    let channel = |c: usize| {
        let terms = photographs.iter().zip(shares).zip(lights.iter().zip(weights));
        let value = |planes: &Planes, share: f64| f64::from(planes.plane(c)[texel]) / share;
        let above: f64 = terms.map(|((planes, share), (l, w))| w * shading(l) * value(planes, *share)).sum();
        if below > 0.0 { (above / below) as f32 } else { 0.0 }
    };
    let channels = photographs[0].count();
    let albedo = std::array::from_fn(|c| if c < channels { channel(c) } else { 0.0 });
    Solved { normal: normal.map(|n| n as f32), albedo, determined: true }
}

fn collect(size: Size, channels: usize, texels: &[Solved]) -> Stereo {
    let (mut normals, mut albedo) = (Planes::zeros(size, 3), Planes::zeros(size, channels));
    for (k, plane) in normals.iter_mut().enumerate() {
        plane.iter_mut().zip(texels).for_each(|(out, texel)| *out = texel.normal[k]);
    }
    for (c, plane) in albedo.iter_mut().enumerate() {
        plane.iter_mut().zip(texels).for_each(|(out, texel)| *out = texel.albedo[c]);
    }
    let determined = texels.iter().map(|texel| texel.determined).collect();
    Stereo { normals, albedo: Picture { planes: albedo, space: Space::Linear }, determined }
}

#[cfg(test)]
mod tests;
