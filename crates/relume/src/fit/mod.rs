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
//! | `product` | three channel functions to a luminance and a colour |
//! | `sample`, `residual`, `leave_one_out`, `report` | how well the result relights the photographs |
//! | `reference` | the slow and obvious fit against which the tests compare |

mod accumulate;
mod design;
pub mod learned;
mod leave_one_out;
mod levels;
mod product;
mod products;
pub mod reference;
mod report;
mod residual;
mod sample;
mod stream;

pub use report::{FitReport, LightReport, Residual};

use serde::Serialize;

use crate::direction::Direction;
use crate::error::{Error, Result};
use crate::field::{Basis, PlaneLayout, ReflectanceField};
use crate::job::Job;
use crate::planes::Planes;
use crate::raster::{LoadRaster, Raster};
use crate::space::Space;
use accumulate::accumulate;
use design::Design;
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
}

impl Default for FitOptions {
    fn default() -> Self {
        Self {
            basis: Basis::Ptm,
            layout: PlaneLayout::LRGB,
            space: Space::Srgb,
            report_texels: sample::KEPT_TEXELS,
            leave_one_out: false,
        }
    }
}

impl FitOptions {
    /// Checks the options before a photograph is read.
    ///
    /// # Errors
    /// When no texel is to be compared.
    pub fn validate(&self) -> Result<()> {
        if self.report_texels == 0 {
            return Err(Error::usage("the error report needs at least 1 texel, found 0"));
        }
        Ok(())
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
    let design = Design::new(&options.basis, &directions)?;
    job.start("fitting photographs", lights.len() as u64);
    let names = lights.iter().map(|(name, _)| name.as_str()).collect();
    let functions = options.basis.len();
    let sums = |channels: usize| (functions * channels).max(functions + channels);
    let stream = PhotographStream::open(names, load, sums, job)?;
    let layout = options.layout_for(stream.channels())?;
    let grid = Grid::new(stream.size(), options.report_texels);
    let planes = sums(stream.channels());
    let _sums = job.hold("the fit", 4 * (planes * stream.size().texels()) as u64)?;
    let _sample = job.hold("the sample for the error report", stream.sample_bytes(&grid))?;
    let levels = SampleLevels::new(options.space);
    // The coefficients on the grid, and for each photograph left out those without it.
    let copies = if options.leave_one_out { 2 + rayon::current_num_threads() } else { 1 };
    job.check_bytes("the error report", 4 * (planes * grid.texels() * copies) as u64)?;

    let (sums, kept) = sum_photographs(&stream, &design, &levels, &grid, job)?;
    let linear = options.leave_one_out.then(|| grid.planes(&sums));
    let coefficients = finish(sums, &layout, &design);

    let measured = report::FitMeasurement {
        lights,
        layout: &layout,
        grid: &grid,
        levels: &levels,
        design: &design,
        kept: &kept,
    };
    let report = measured.report(&stream, &grid.planes(&coefficients), linear.as_ref(), job)?;
    let field = ReflectanceField::new(options.basis.clone(), layout, options.space, coefficients)?;
    Ok(Fit { field: field.with_lights(directions), report })
}

/// The coefficients of every channel, and the texels of each photograph for the report where they are few
/// enough to keep.
fn sum_photographs(
    stream: &PhotographStream,
    design: &Design,
    levels: &SampleLevels,
    grid: &Grid,
    job: &Job,
) -> Result<(Planes, Vec<Raster>)> {
    let functions = design.functions();
    let channels = stream.channels();
    // One constant function in three channels needs three planes, but four as luminance and colour.
    let planes = (functions * channels).max(functions + channels);
    let mut sums = Planes::zeros(stream.size(), planes);
    let mut kept = Vec::new();
    stream.for_each_batch(job, |first, batch| {
        accumulate(&mut sums, design, first, batch, levels);
        if grid.is_kept() {
            kept.extend(batch.iter().map(|photograph| grid.raster(photograph)));
        }
        job.advance(batch.len() as u64)
    })?;
    Ok((sums, kept))
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
