//! Photometric stereo: normals and albedo from photographs under many known lights.
//!
//! Each texel is solved independently (`robust`) on linear luminance; the albedo of each channel then follows
//! by weighted least squares along the resulting shading. Photographs are read once if all values fit into
//! memory, otherwise once for each band of rows; the result does not depend on the bands. Lamps are far away,
//! or at known places, and of equal strength, and the camera is straight above. Texels whose values determine no direction (black
//! everywhere) face the viewer.

use rayon::prelude::*;

use super::luminance;
use super::robust::{self, Ambient, Estimator, Scratch};
use super::shared_reflectance::{self, FINAL_STEPS, GridTexel, LightAndHalf, ReflectanceTable};
use crate::direction::Direction;
use crate::error::{Error, Result};
use crate::job::Job;
use crate::lamps::LampPositions;
use crate::picture::Picture;
use crate::planes::Planes;
use crate::raster::{LoadRaster, Raster, RasterSequence};
use crate::size::Size;
use crate::space::Space;

/// The most memory for the values of a band.
const BAND_BYTES: u64 = 512 << 20;
/// The least share of the smallest eigenvalue: lights with less spread do not allow stereo.
const LEAST_SPREAD: f64 = 1e-4;

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
    /// Texels whose values determine no direction.
    pub undetermined: usize,
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
    let solved_bytes = (2 * size_of::<Solved>() + 4 * (3 + channels)) as u64;
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
    let mut solver = Solver { directions, lamps: input.lamps, options: *options, table: None };
    if options.estimator == Estimator::Shared {
        solver.table = Some(learned(&solver, size, &|i| read(i, 0, size), job)?);
    }
    let mut texels = Vec::with_capacity(size.texels());
    for top in (0..size.height).step_by(rows) {
        let band = Size::new(size.width, rows.min(size.height - top));
        let read = |i: usize| {
            let values = read(i, top, band)?;
            job.advance(1)?;
            Ok(values)
        };
        let values = (0..lights.len()).into_par_iter().map(read).collect::<Result<Vec<Planes>>>()?;
        texels.extend(solver.solve_band(&values, top, job)?);
    }
    Ok(collect(size, channels, &texels))
}

/// About this many texels show the reflectance that all share.
const SHARED_TEXELS: usize = 15_000;

/// The reflectance that all texels share, from a regular grid of them.
fn learned(
    solver: &Solver,
    size: Size,
    read: &(dyn Fn(usize) -> Result<Planes> + Sync),
    job: &Job,
) -> Result<ReflectanceTable> {
    let step = ((size.texels() as f64 / SHARED_TEXELS as f64).sqrt().ceil() as usize).max(1);
    let grid: Vec<usize> = (0..size.height)
        .step_by(step)
        .flat_map(|y| (0..size.width).step_by(step).map(move |x| size.index(x, y)))
        .collect();
    let lights = solver.directions.len();
    job.check_bytes("the shared reflectance", (grid.len() * lights * (8 + 2 * 48)) as u64)?;
    let of_photograph = |i: usize| {
        let planes = read(i)?;
        Ok(grid.iter().map(|&texel| luminance::of_texel(&planes, texel)).collect())
    };
    let columns = (0..lights).into_par_iter().map(of_photograph).collect::<Result<Vec<Vec<f64>>>>()?;
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
    let mut texels: Vec<GridTexel> = grid.par_iter().enumerate().filter_map(texel).collect();
    // Texels that are black everywhere, such as those outside a mask, say nothing.
    texels.retain(|texel| texel.b[2] > 0.0 && texel.values.iter().any(|v| *v > 0.0));
    job.proceed()?;
    Ok(shared_reflectance::learn(&mut texels))
}

/// What is the same for all texels.
struct Solver<'a> {
    directions: Vec<[f64; 3]>,
    lamps: Option<&'a LampPositions>,
    options: StereoOptions,
    table: Option<ReflectanceTable>,
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
        return Err(Error::usage(format!(
            "photometric stereo needs at least {least} lights, found {}",
            lights.len()
        )));
    }
    // The determinant of the mean outer product; for directions spread over the whole sphere it is 1 / 27.
    let mean = |i: usize, j: usize| lights.iter().map(|l| l[i] * l[j]).sum::<f64>() / lights.len() as f64;
    let [a, b, c, d, e, f] = [mean(0, 0), mean(1, 1), mean(2, 2), mean(0, 1), mean(0, 2), mean(1, 2)];
    let determinant = a * (b * c - f * f) - d * (d * c - f * e) + e * (d * f - b * e);
    if 27.0 * determinant < LEAST_SPREAD {
        return Err(Error::usage(
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
        let solved = (0..size.texels()).into_par_iter().with_min_len(256).map_init(
            || (Scratch::default(), Vec::with_capacity(photographs.len())),
            |(scratch, values), texel| {
                job.proceed()?;
                let near = self.lamps.map(|_| self.lights_at(texel % size.width, top + texel / size.width));
                let here = near.as_ref().unwrap_or(&far);
                values.clear();
                let of_all = photographs.iter().zip(&here.shares);
                values.extend(of_all.map(|(planes, share)| luminance::of_texel(planes, texel) / share));
                let how = (self.options.estimator, self.options.ambient);
                Ok(match robust::solve(&here.directions, values, how, scratch) {
                    Some(matt) => {
                        let matt = self.refined(matt, here, values);
                        finish(&matt, here, photographs, &scratch.weights, texel)
                    }
                    None => UNDETERMINED,
                })
            },
        );
        solved.collect()
    }

    /// The solution under the shared reflectance, if there is one.
    fn refined(&self, matt: robust::Matt, here: &LightsHere, values: &[f64]) -> robust::Matt {
        let Some(table) = &self.table else { return matt };
        let lights: Vec<LightAndHalf> = here.directions.iter().copied().map(LightAndHalf::new).collect();
        robust::Matt { b: shared_reflectance::refine(table, &lights, values, matt.b, FINAL_STEPS), ..matt }
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
    let undetermined = texels.iter().filter(|texel| !texel.determined).count();
    Stereo { normals, albedo: Picture { planes: albedo, space: Space::Linear }, undetermined }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::limits::Limits;
    use crate::numeric::random::{Purpose, Stream};
    use crate::raster::Samples;

    /// Lights on three rings.
    fn lights(count: usize) -> Vec<(String, Direction)> {
        let light = |i: usize| Direction::from_angles(0.3 + 0.25 * (i % 3) as f64, 2.4 * i as f64);
        (0..count).map(|i| (format!("{i}.exr"), light(i))).collect()
    }

    /// Texels with known normals and albedo, and their photographs; on request every fifth value of each is
    /// corrupted by a shadow or a highlight.
    struct Planted {
        size: Size,
        normals: Vec<Direction>,
        albedo: Vec<[f32; 3]>,
        photographs: Vec<Raster>,
    }

    fn planted(size: Size, lights: &[(String, Direction)], ambient: f64, spoilt: bool) -> Planted {
        let mut stream = Stream::new(3, Purpose::Sample, [1]);
        let normals: Vec<Direction> = (0..size.texels())
            .map(|_| Direction::from_angles(0.6 * stream.unit(), 6.25 * stream.unit()))
            .collect();
        let albedo: Vec<[f32; 3]> =
            (0..size.texels()).map(|_| [0; 3].map(|_| 0.2 + 0.7 * stream.unit() as f32)).collect();
        let photograph = |(k, (_, light)): (usize, &(String, Direction))| {
            let value = |i: usize| {
                let (texel, c) = (i / 3, i % 3);
                let shading = light.dot(normals[texel]).max(0.0) + ambient;
                let matt = f64::from(albedo[texel][c]) * shading;
                match (texel + k) % 10 {
                    0 if spoilt => 0.0,
                    5 if spoilt => matt + 0.8,
                    _ => matt,
                }
            };
            let samples = (0..3 * size.texels()).map(|i| value(i) as f32).collect();
            Raster::new(size, 3, Samples::F32(samples)).unwrap()
        };
        let photographs = lights.iter().enumerate().map(photograph).collect();
        Planted { size, normals, albedo, photographs }
    }

    fn run(
        planted: &Planted,
        lights: &[(String, Direction)],
        options: StereoOptions,
        job: Job,
    ) -> Result<Stereo> {
        let load = |i: usize| Ok(planted.photographs[i].clone());
        photometric_stereo(StereoInput { lights, lamps: None, load: &load }, &options, &job)
    }

    /// The largest angle in degrees and the largest error of albedo.
    fn errors(planted: &Planted, found: &Stereo) -> (f64, f32) {
        let texels = 0..planted.size.texels();
        let angle = |t: usize| {
            let n = [0, 1, 2].map(|k| f64::from(found.normals.plane(k)[t]));
            let n = Direction::new(n[0], n[1], n[2]).unwrap();
            n.dot(planted.normals[t]).clamp(-1.0, 1.0).acos().to_degrees()
        };
        let off = |t: usize| {
            let each = (0..3).map(|c| (found.albedo.planes.plane(c)[t] - planted.albedo[t][c]).abs());
            each.fold(0.0, f32::max)
        };
        (texels.clone().map(angle).fold(0.0, f64::max), texels.map(off).fold(0.0, f32::max))
    }

    #[test]
    fn planted_normals_and_colours_are_found_by_every_estimator() {
        let lights = lights(12);
        let planted = planted(Size::new(7, 5), &lights, 0.0, false);
        for estimator in [Estimator::LeastSquares, Estimator::Trimmed, Estimator::Robust, Estimator::Shared] {
            let options = StereoOptions { estimator, ..StereoOptions::default() };
            let found = run(&planted, &lights, options, Job::default()).unwrap();
            let (angle, albedo) = errors(&planted, &found);
            assert!(angle < 0.1 && albedo < 1e-4, "{estimator:?} {angle} {albedo}");
            assert_eq!(found.undetermined, 0);
        }
    }

    #[test]
    fn shadows_and_highlights_are_seen_through_and_mislead_least_squares() {
        let lights = lights(30);
        let planted = planted(Size::new(9, 6), &lights, 0.0, true);
        let with = |estimator| {
            let options = StereoOptions { estimator, ..StereoOptions::default() };
            errors(&planted, &run(&planted, &lights, options, Job::default()).unwrap()).0
        };
        assert!(with(Estimator::Robust) < 0.5, "{}", with(Estimator::Robust));
        assert!(with(Estimator::LeastSquares) > 5.0);
    }

    #[test]
    fn a_constant_light_is_estimated_where_asked() {
        let lights = lights(15);
        let planted = planted(Size::new(5, 4), &lights, 0.15, false);
        let with = |ambient| {
            let options = StereoOptions { ambient, ..StereoOptions::default() };
            errors(&planted, &run(&planted, &lights, options, Job::default()).unwrap())
        };
        let (angle, albedo) = with(Ambient::Constant);
        assert!(angle < 0.1 && albedo < 1e-3, "{angle} {albedo}");
        assert!(with(Ambient::None).0 > 1.0);
    }

    #[test]
    fn near_lamps_light_every_texel_from_its_own_direction() {
        let size = Size::new(40, 30);
        let place = |i: usize| {
            let (sin, cos) = (0.7 * i as f64).sin_cos();
            [40.0 * cos, 40.0 * sin, 60.0 + 4.0 * (i % 3) as f64]
        };
        let lamps = LampPositions::new((0..9).map(place).collect(), (40, 30), 80.0).unwrap();
        let normal = Direction::from_angles(0.2, 1.0).to_array();
        let photograph = |k: usize| {
            let value = |i: usize| {
                let (light, share) = lamps.at(k, i % 40, i / 40);
                (0.5 * share * light.iter().zip(normal).map(|(l, n)| l * n).sum::<f64>()) as f32
            };
            Raster::new(size, 1, Samples::F32((0..size.texels()).map(value).collect())).unwrap()
        };
        let load = |k: usize| Ok(photograph(k));
        let lights: Vec<_> = (0..9).map(|k| (k.to_string(), lamps.direction(k))).collect();
        let with = |lamps| {
            let input = StereoInput { lights: &lights, lamps, load: &load };
            let options = StereoOptions { estimator: Estimator::LeastSquares, ..StereoOptions::default() };
            let found = photometric_stereo(input, &options, &Job::default()).unwrap();
            let off = |i: usize| {
                let cosine: f64 = (0..3).map(|k| f64::from(found.normals.plane(k)[i]) * normal[k]).sum();
                cosine.clamp(-1.0, 1.0).acos().to_degrees()
            };
            ((0..size.texels()).map(off).fold(0.0, f64::max), found.albedo.planes.plane(0)[0])
        };
        let (near, albedo) = with(Some(&lamps));
        assert!(near < 0.05 && (albedo - 0.5).abs() < 1e-3, "{near} {albedo}");
        assert!(with(None).0 > 5.0);
    }

    #[test]
    fn bands_and_threads_change_nothing() {
        let lights = lights(8);
        let planted = planted(Size::new(6, 11), &lights, 0.0, true);
        let whole = run(&planted, &lights, StereoOptions::default(), Job::default()).unwrap();
        // The result, and twice the bytes of two rows of eight photographs in three channels.
        let solved = (2 * size_of::<Solved>() + 4 * 6) * 6 * 11;
        let max_bytes = (solved + 2 * 2 * 6 * 8 * 3 * 4) as u64;
        let tight = Job::new(Limits { max_bytes, ..Limits::default() });
        let pool = rayon::ThreadPoolBuilder::new().num_threads(1).build().unwrap();
        assert_eq!(whole, pool.install(|| run(&planted, &lights, StereoOptions::default(), tight)).unwrap());
    }

    #[test]
    fn what_is_no_stereo_is_refused() {
        let all = lights(9);
        let planted = planted(Size::new(3, 3), &all, 0.0, false);
        let refused = |lights: &[(String, Direction)], ambient| {
            let options = StereoOptions { ambient, ..StereoOptions::default() };
            run(&planted, lights, options, Job::default()).unwrap_err().to_string()
        };
        assert!(refused(&all[..2], Ambient::None).contains("at least 3 lights"));
        assert!(refused(&all[..3], Ambient::Constant).contains("at least 4 lights"));
        let arc: Vec<_> =
            (0..9).map(|i| (String::new(), Direction::from_angles(0.1 * f64::from(i) - 0.4, 0.0))).collect();
        assert!(refused(&arc, Ambient::None).contains("in one plane"));
        let small = Raster::new(Size::new(1, 1), 3, Samples::F32(vec![0.0; 3])).unwrap();
        let load = |i: usize| Ok(if i == 4 { small.clone() } else { planted.photographs[i].clone() });
        let with = |load| StereoInput { lights: &all, lamps: None, load };
        let odd = photometric_stereo(with(&load), &StereoOptions::default(), &Job::default());
        assert!(odd.unwrap_err().to_string().contains("4.exr"));
        let black = |_: usize| Ok(small.clone());
        let found = photometric_stereo(with(&black), &StereoOptions::default(), &Job::default());
        assert_eq!(found.unwrap().undetermined, 1);
    }
}
