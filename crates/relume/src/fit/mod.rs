//! Fitting: from photographs under known lights to coefficients.
//!
//! The coefficients of each texel are the least-squares solution of A c = p, where row i of A holds the
//! values of the functions under light i, and p the values of the texel in the photographs (Malzbender, Gelb,
//! Wolters, "Polynomial Texture Maps", SIGGRAPH 2001, section 3.2). A is the same for all texels, so its
//! pseudo-inverse is computed once and a fit is one matrix product. The photographs are streamed: they are
//! decoded in parallel in batches, added to the sums and dropped. The memory is that of the sums and one
//! batch, whatever the number of photographs; only the sample of texels for the error report grows with it,
//! by at most 65,536 texels per photograph.
//!
//! | file | content |
//! |---|---|
//! | `design` | the matrix A, its factorisation, and the reasons why lights may not suffice |
//! | `levels` | samples of a file as values in the space of the fit |
//! | `stream` | photographs one batch at a time, checked against the first |
//! | `accumulate`, `products` | sums += pseudo-inverse x photographs, vectorised |
//! | `learned/` | functions of light and view learned from the photographs themselves |
//! | `parametric/` | the parameters of a reflectance model for each texel |
//! | `held_out`, `pair_errors` | pairs of light and view left out, and the errors on all of them |
//! | `product` | three channel functions to a luminance and a colour |
//! | `ridge` | a penalty on rough functions, chosen by leaving photographs out |
//! | `robust` | photographs that do not follow the functions at a texel left out, or counted less |
//! | `exposed` | photographs that are black, or white over most of the surface |
//! | `sample`, `residual`, `leave_one_out`, `report` | how well the result relights the photographs |
//! | `reference` | the slow and obvious fit against which the tests compare |

mod accumulate;
mod design;
mod exposed;
mod held_out;
pub mod learned;
mod leave_one_out;
mod levels;
mod pair_errors;
pub mod parametric;
mod product;
mod products;
pub mod reference;
mod report;
mod residual;
mod ridge;
mod robust;
mod sample;
mod stream;

pub use report::{FitReport, LightReport, Residual};
pub use ridge::Ridge;
pub use robust::{Robust, TexelFitReport};

use serde::Serialize;

use crate::direction::Direction;
use crate::error::{Error, Result};
use crate::field::{Basis, PlaneLayout, ReflectanceField};
use crate::job::Job;
use crate::lamps::LampPositions;
use crate::planes::Planes;
use crate::raster::{LoadRaster, Raster};
use crate::size::Size;
use crate::space::Space;
use accumulate::accumulate;
use design::Design;
use exposed::Exposed;
use levels::SampleLevels;
use sample::Grid;
use stream::PhotographStream;

/// The options of a fit.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct FitOptions {
    /// The functions of light direction.
    pub basis: Basis,
    /// [`PlaneLayout::LRGB`] or [`PlaneLayout::RGB`]. Grey photographs always give
    /// [`PlaneLayout::LUMINANCE`].
    pub layout: PlaneLayout,
    /// The space of the fitted values. Integer samples are encoded and are decoded for
    /// [`Space::Linear`]; floating-point samples are linear and are encoded for [`Space::Srgb`].
    pub space: Space,
    /// At most this many texels, on a regular grid, are compared with the photographs; all texels of smaller
    /// photographs. Beyond 65,536 the photographs are read a second time.
    pub report_texels: usize,
    /// Whether to measure also how well each photograph is predicted by all the others.
    pub leave_one_out: bool,
    /// The penalty on rough functions.
    pub ridge: Ridge,
    /// Which photographs count at a texel. All are in memory unless all count.
    pub robust: Robust,
    /// The places of near lamps over the texels, whose light comes from its own direction at each texel; their fall-off
    /// is undone in the photographs. All photographs are in memory then.
    #[serde(skip)]
    pub lamps: Option<LampPositions>,
    /// The texels that belong to the surface: others are not measured. Photographs are black there.
    #[serde(skip)]
    pub mask: Option<Vec<bool>>,
}

impl Default for FitOptions {
    fn default() -> Self {
        Self {
            basis: Basis::Ptm,
            layout: PlaneLayout::LRGB,
            space: Space::Srgb,
            report_texels: sample::KEPT_TEXELS,
            leave_one_out: false,
            ridge: Ridge::None,
            robust: Robust::None,
            lamps: None,
            mask: None,
        }
    }
}

impl FitOptions {
    /// Checks the options before a photograph is read.
    ///
    /// # Errors
    /// When no texel is to be compared; a ridge whose weight is not positive; a ridge or a robust fit of photographs that
    /// are interpolated; predictions from other photographs of a robust fit.
    pub fn validate(&self) -> Result<()> {
        if self.report_texels == 0 {
            return Err(Error::usage("the error report needs at least 1 texel, found 0"));
        }
        self.ridge.validate()?;
        let is_plain = self.ridge == Ridge::None && self.robust == Robust::None;
        if !is_plain && self.basis.roughness().is_none() {
            return Err(Error::usage(format!(
                "the basis {} keeps the photographs as they are: a ridge and robust fits are for polynomials and harmonics",
                self.basis.name()
            )));
        }
        if self.lamps.is_some() && matches!(self.basis, Basis::Interpolated(_)) {
            return Err(Error::usage(
                "photographs that are interpolated have one light each: fit polynomials or harmonics to those of near lamps",
            ));
        }
        if self.leave_one_out && self.lamps.is_some() {
            return Err(Error::usage(
                "predictions of each photograph from the others are those of one light for all texels: ask for them \
                 without near lamps",
            ));
        }
        if self.leave_one_out && self.robust != Robust::None {
            return Err(Error::usage(
                "predictions of each photograph from the others are those of least squares: ask for them without a \
                 robust fit",
            ));
        }
        Ok(())
    }

    /// Whether each texel is fitted by itself, to all photographs.
    fn needs_all(&self) -> bool {
        self.robust != Robust::None || self.lamps.is_some()
    }

    /// The layout for photographs with that many channels.
    fn layout_for(&self, channels: usize) -> Result<PlaneLayout> {
        if channels == 1 {
            return Ok(PlaneLayout::LUMINANCE);
        }
        if self.layout == PlaneLayout::RGB || self.layout == PlaneLayout::LRGB {
            return Ok(self.layout.clone());
        }
        Err(Error::usage(format!(
            "the photographs are coloured: fit them as lrgb or rgb, not as {}",
            self.layout.name()
        )))
    }
}

/// A fitted field and its relighting errors.
#[derive(Debug, Clone)]
pub struct Fit {
    /// The result.
    pub field: ReflectanceField,
    /// Its errors.
    pub report: FitReport,
}

/// Refuses lights that do not determine the functions of a basis, as [`fit`] does before it reads a photograph.
///
/// # Errors
/// The reason, in words.
pub fn check_lights(basis: &Basis, lights: &[Direction]) -> Result<()> {
    Design::new(basis, lights).map(|_| ())
}

/// Fits photographs under known lights: `lights` names each photograph and its light, and
/// `load(i)` reads the i-th. The result is the same at any number of threads.
///
/// # Errors
/// Lights that do not determine the functions (before any photograph is read), errors of `load`, photographs
/// that differ in size or channels, samples that are not finite, and sizes beyond the limits of the job.
pub fn fit(
    lights: &[(String, Direction)],
    load: &LoadRaster,
    options: &FitOptions,
    job: &Job,
) -> Result<Fit> {
    options.validate()?;
    let directions: Vec<Direction> = lights.iter().map(|(_, light)| *light).collect();
    let mut design = Design::new(&options.basis, &directions)?;
    if options.ridge == Ridge::None {
        robust::check(options.robust, &design)?;
    }
    job.start("fitting photographs", lights.len() as u64);
    let names = lights.iter().map(|(name, _)| name.as_str()).collect();
    let sums = |channels: usize| planes_of_sums(&options.basis, channels);
    let stream = PhotographStream::open(names, load, sums, job)?;
    let layout = options.layout_for(stream.channels())?;
    let grid = Grid::within(stream.size(), options.report_texels, options.mask.as_deref())?;
    let planes = sums(stream.channels());
    let _sums = job.hold("the fit", 4 * (planes * stream.size().texels()) as u64)?;
    let _sample = job.hold("the sample for the error report", kept_bytes(&stream, &grid) + grid.bytes())?;
    let levels = SampleLevels::new(options.space);
    job.check_bytes("the error report", 4 * (planes * grid.texels() * report_copies(options)) as u64)?;

    let all = if options.needs_all() { stream.bytes() } else { 0 };
    let _all = job.hold("all photographs, which robust fits and near lamps need together,", all)?;
    let SummedPhotographs { mut sums, kept, sampled, all, exposed } =
        sum_photographs(&stream, &design, &levels, &grid, options, job)?;
    let exposure = exposed.warnings(&stream)?;
    if let Some(ridged) = ridged(&design, options, &sampled, &levels)? {
        ridge::apply(&mut sums, stream.channels(), &design, &ridged);
        design = ridged;
    }
    robust::check(options.robust, &design)?;
    let mask = options.mask.as_deref();
    let rule = robust::TexelRule { robust: options.robust, lamps: options.lamps.as_ref(), mask };
    let texel_fit = robust::refine(&mut sums, &all, rule, &design, &levels, job)?;
    let linear = options.leave_one_out.then(|| grid.planes(&sums));
    let coefficients = finish(sums, &layout, &design);

    let measured = report::FitMeasurement {
        lights,
        layout: &layout,
        grid: &grid,
        levels: &levels,
        design: &design,
        robust: options.robust,
        texel_fit,
        lamps: options.lamps.as_ref(),
        kept: &kept,
    };
    let mut report = measured.report(&stream, &grid.planes(&coefficients), linear.as_ref(), job)?;
    report.warnings.extend(exposure);
    let field = ReflectanceField::new(options.basis.clone(), layout, options.space, coefficients)?;
    Ok(Fit { field: field.with_lights(directions), report })
}

/// Refuses photographs of a size, with some channels, that cannot be fitted within the memory.
///
/// # Errors
/// [`ErrorKind::Limit`](crate::ErrorKind::Limit).
pub fn check_memory(
    (size, channels): (Size, usize),
    photographs: usize,
    options: &FitOptions,
    job: &Job,
) -> Result<()> {
    let planes = planes_of_sums(&options.basis, channels);
    let grid = options.report_texels.min(size.texels());
    // Developed samples are floats.
    let sample = if grid <= sample::KEPT_TEXELS { 4 * grid * channels * photographs } else { 0 };
    let all = if options.needs_all() { 4 * size.texels() * channels * photographs } else { 0 };
    let report = 4 * planes * grid * report_copies(options);
    job.check_bytes("the fit and its report", (4 * planes * size.texels() + sample + all + report) as u64)
}

/// The bytes of the texels of a grid in all photographs, where they are few enough to keep.
fn kept_bytes(stream: &PhotographStream, grid: &Grid) -> u64 {
    if grid.is_kept() { stream.sample_bytes(grid) } else { 0 }
}

/// The planes of the sums of photographs with some channels: of one constant function in three channels three, but four as luminance
/// and colour.
fn planes_of_sums(basis: &Basis, channels: usize) -> usize {
    let functions = basis.len();
    (functions * channels).max(functions + channels)
}

/// The coefficients on the grid of the report, and for each photograph left out those without it.
fn report_copies(options: &FitOptions) -> usize {
    if options.leave_one_out { 2 + rayon::current_num_threads() } else { 1 }
}

/// What a pass over the photographs leaves.
struct SummedPhotographs {
    /// The coefficients of every channel.
    sums: Planes,
    /// The texels of each photograph for the report, where they are few enough to keep.
    kept: Vec<Raster>,
    /// Those from which a ridge is chosen.
    sampled: Vec<Raster>,
    /// The photographs, where each texel is fitted by itself.
    all: Vec<Raster>,
    /// Those that are black or white.
    exposed: Exposed,
}

fn sum_photographs(
    stream: &PhotographStream,
    design: &Design,
    levels: &SampleLevels,
    grid: &Grid,
    options: &FitOptions,
    job: &Job,
) -> Result<SummedPhotographs> {
    let planes = planes_of_sums(&options.basis, stream.channels());
    let (mut kept, mut sampled, mut all) = (Vec::new(), Vec::new(), Vec::new());
    let mut exposed = Exposed::default();
    let mut sums = Planes::zeros(stream.size(), planes);
    let sample = Grid::new(stream.size(), ridge::SAMPLE_TEXELS);
    stream.for_each_batch(job, |first, batch| {
        accumulate(&mut sums, design, first, batch, levels);
        for (i, photograph) in (first..).zip(batch) {
            let picked = grid.raster(photograph);
            exposed.look(i, photograph, &picked);
            if grid.is_kept() {
                kept.push(picked);
            }
        }
        if options.ridge == Ridge::LeaveOneOut {
            sampled.extend(batch.iter().map(|photograph| sample.raster(photograph)));
        }
        if options.needs_all() {
            all.extend_from_slice(batch);
        }
        job.advance(batch.len() as u64)
    })?;
    Ok(SummedPhotographs { sums, kept, sampled, all, exposed })
}

/// The design with the ridge that was asked for.
fn ridged(
    design: &Design,
    options: &FitOptions,
    sampled: &[Raster],
    levels: &SampleLevels,
) -> Result<Option<Design>> {
    let Some(roughness) = options.basis.roughness() else { return Ok(None) };
    let weight = match options.ridge {
        Ridge::None => None,
        Ridge::Weight(weight) => Some(weight),
        Ridge::LeaveOneOut => ridge::best_weight(design, &roughness, sampled, levels)?,
    };
    weight.map(|weight| design.with_ridge(&roughness, weight)).transpose()
}

/// The coefficient planes of a layout from those of every channel.
fn finish(mut sums: Planes, layout: &PlaneLayout, design: &Design) -> Planes {
    if layout.is_product() {
        product::to_products(&mut sums, design);
    }
    sums.truncated(layout.planes(design.functions()))
}

#[cfg(test)]
mod tests;
