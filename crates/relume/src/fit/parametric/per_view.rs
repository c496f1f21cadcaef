//! A function of the light for each view: the photographs of one view are in memory at a time.

use super::encoded::TexelReflectance;
use super::lobes::LobeModel;
use super::texels::FromMean;
use crate::direction::{Direction, Directions};
use crate::error::{Error, Result};
use crate::field::{Basis, PerViewModel, PlaneLayout, ViewFunction};
use crate::fit::levels::SampleLevels;
use crate::fit::sample::Grid;
use crate::fit::stream::PhotographStream;
use crate::fit::{FitOptions, fit};
use crate::job::Job;
use crate::parallel;
use crate::planes::Planes;
use crate::raster::Raster;
use crate::space::Space;

/// Steps of the fit of a texel to one view.
const STEPS: usize = 8;
/// Texels of a task.
const PART: usize = 1 << 10;

/// The photographs of the views.
pub(super) struct ViewSet<'a> {
    pub stream: &'a PhotographStream<'a>,
    pub pairs: &'a [(String, Directions)],
    /// Of each pair whether it takes part.
    pub takes_part: &'a (dyn Fn(usize) -> bool + Sync),
    pub grid: &'a Grid,
}

/// One view: its direction, and the numbers of its photographs, with those that take no part at the end.
struct ViewPhotographs {
    direction: Direction,
    photographs: Vec<usize>,
    taking_part: usize,
}

impl ViewSet<'_> {
    /// The model of the views that take part.
    pub fn model(&self, function: &ViewFunction) -> Result<PerViewModel> {
        let views = self.views();
        let used: Vec<Direction> = views.iter().filter(|v| v.taking_part > 0).map(|v| v.direction).collect();
        PerViewModel::new(&used, function.clone())
    }

    /// Fits the function to each view, and keeps the texels of the grid of every photograph.
    pub fn fit(&self, function: &ViewFunction, planes: &mut Planes, job: &Job) -> Result<Vec<Raster>> {
        let (channels, size) = (self.stream.channels(), self.stream.size());
        let own = function.numbers(channels);
        let views = self.views();
        let most = views.iter().map(|view| view.photographs.len()).max().unwrap_or(0);
        let _held = job.hold(
            "the photographs of one view",
            self.stream.bytes() / self.pairs.len() as u64 * most as u64,
        )?;
        job.start("fitting views", views.len() as u64);
        let mut kept: Vec<Option<Raster>> = vec![None; self.pairs.len()];
        let mut number = 0;
        for view in &views {
            let read = |i: &usize| job.proceed().and_then(|()| self.stream.read(*i));
            let read = parallel::try_map(view.photographs.iter(), read)?;
            for (i, photograph) in view.photographs.iter().zip(&read) {
                kept[*i] = Some(self.grid.raster(photograph));
            }
            let (used, pairs) = (&read[..view.taking_part], self.pairs_of(view));
            if used.is_empty() {
                job.advance(1)?;
                continue;
            }
            let first = number * own * size.texels();
            let out = &mut planes.as_mut_slice()[first..][..own * size.texels()];
            match function {
                ViewFunction::Basis(basis, space) => linear(basis, *space, &pairs, used, out, job)?,
                ViewFunction::Lobes(lobes) => {
                    let model = LobeModel::of_lights(channels, *lobes, &directions(&pairs));
                    of_lobes(&model, used, self.grid, out, job)?;
                }
            }
            number += 1;
            job.advance(1)?;
        }
        Ok(kept.into_iter().flatten().collect())
    }

    fn views(&self) -> Vec<ViewPhotographs> {
        let mut views: Vec<ViewPhotographs> = Vec::new();
        for part in [true, false] {
            for i in (0..self.pairs.len()).filter(|i| (self.takes_part)(*i) == part) {
                let direction = self.pairs[i].1.view;
                let view = match views.iter().position(|view| view.direction == direction) {
                    Some(known) => &mut views[known],
                    None => {
                        views.push(ViewPhotographs { direction, photographs: Vec::new(), taking_part: 0 });
                        let last = views.len() - 1;
                        &mut views[last]
                    }
                };
                view.photographs.push(i);
                view.taking_part += usize::from(part);
            }
        }
        views
    }

    /// The names and directions of the photographs of a view that take part.
    fn pairs_of(&self, view: &ViewPhotographs) -> Vec<(String, Directions)> {
        view.photographs[..view.taking_part].iter().map(|&i| self.pairs[i].clone()).collect()
    }
}

fn directions(pairs: &[(String, Directions)]) -> Vec<Directions> {
    pairs.iter().map(|(_, pair)| *pair).collect()
}

/// Functions of the light by least squares.
fn linear(
    basis: &Basis,
    space: Space,
    pairs: &[(String, Directions)],
    photographs: &[Raster],
    out: &mut [f32],
    job: &Job,
) -> Result<()> {
    let lights: Vec<(String, Direction)> =
        pairs.iter().map(|(name, pair)| (name.clone(), pair.light)).collect();
    let options = FitOptions {
        basis: basis.clone(),
        layout: PlaneLayout::RGB,
        space,
        report_texels: 1,
        ..FitOptions::default()
    };
    let load = |i: usize| Ok(photographs[i].clone());
    // The errors of all views are reported together.
    let fitted = fit(&lights, &load, &options, &job.unheard()).map_err(|error| {
        Error::usage(format!("the {} photographs of the view of {}: {error}", pairs.len(), pairs[0].0))
    })?;
    out.copy_from_slice(fitted.field.coefficients().as_slice());
    Ok(())
}

/// Lobes of the light, from those of the mean of all texels.
fn of_lobes(
    model: &LobeModel,
    photographs: &[Raster],
    grid: &Grid,
    out: &mut [f32],
    job: &Job,
) -> Result<()> {
    let (channels, texels) = (model.channels(), photographs[0].size().texels());
    let levels = SampleLevels::new(Space::Srgb);
    let mean = mean_of(photographs, grid, &levels);
    let from = FromMean::new(model, &mean, STEPS);
    let length = photographs.len() * channels;
    let numbers = out.len() / texels;
    let of_part = |part: usize| {
        job.proceed()?;
        let count = PART.min(texels - part * PART);
        let mut rows = vec![0.0; length * count];
        for (row, values) in rows.chunks_exact_mut(count).enumerate() {
            levels.channel(&photographs[row / channels], row % channels, part * PART, values);
        }
        let mut found = Vec::with_capacity(count * numbers);
        let mut observed = vec![0.0; length];
        for texel in 0..count {
            observed.iter_mut().enumerate().for_each(|(row, value)| *value = rows[row * count + texel]);
            found.extend(from.fit(&observed));
        }
        Ok(found)
    };
    let parts = parallel::try_map(0..texels.div_ceil(PART), of_part)?;
    for (texel, found) in parts.iter().flat_map(|part| part.chunks_exact(numbers)).enumerate() {
        found.iter().enumerate().for_each(|(k, number)| out[k * texels + texel] = *number);
    }
    Ok(())
}

/// The mean of the texels of a grid, all channels of a photograph adjacent.
pub(super) fn mean_of(photographs: &[Raster], grid: &Grid, levels: &SampleLevels) -> Vec<f32> {
    let mean = |photograph: &Raster| {
        let part = if photograph.size().texels() == grid.texels() {
            photograph.clone()
        } else {
            grid.raster(photograph)
        };
        let mut values = vec![0.0; grid.texels()];
        let channel = |c: usize| {
            levels.channel(&part, c, 0, &mut values);
            (values.iter().map(|v| f64::from(*v)).sum::<f64>() / values.len() as f64) as f32
        };
        (0..part.channels()).map(channel).collect::<Vec<f32>>()
    };
    parallel::map(photographs.iter(), mean).concat()
}
