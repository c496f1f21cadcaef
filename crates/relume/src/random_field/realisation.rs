//! The endless plane of a model: any part of it.
//!
//! A level of the plane is divided into square cells at fixed places. The recursion of each cell starts from
//! zero, a margin before its edges, with the noise of its places. So a texel is a function of its position,
//! the model and the seed, exact to the bit, whatever part of the plane is requested, in any order and on any
//! number of threads. Where two cells meet, the remaining effects of their different starts differ by less
//! than [`super::stability::BURN_IN_ERROR`] of the deviation. A periodic plane has periodic noise.

use std::borrow::Cow;

use super::level::Level;
use super::neighbourhood::Reach;
use super::recursion::{Drive, LANES, Recursion, RecursionRun};
use super::structure::Structure;
use super::unevenness::Strengths;
use crate::error::Result;
use crate::job::Job;
use crate::numeric::pyramid::{self, Kernel};
use crate::parallel;
use crate::planes::Planes;
use crate::rect::Rect;
use crate::size::Size;

/// Side of a cell, in texels of its level.
pub const CELL: usize = 128;

/// The rectangle extended by a reach.
fn grown(rect: Rect, reach: Reach) -> Rect {
    let width = rect.size.width + reach.left + reach.right;
    let height = rect.size.height + reach.up + reach.down;
    Rect::new(rect.x - reach.left as i64, rect.y - reach.up as i64, Size::new(width, height))
}

/// The cells touched by a rectangle.
fn cells(rect: Rect) -> Rect {
    let cell = CELL as i64;
    let along = |start: i64, length: usize| {
        let first = start.div_euclid(cell) * cell;
        (first, ((start + length as i64 - first) as usize).next_multiple_of(CELL))
    };
    let ((x, width), (y, height)) = (along(rect.x, rect.size.width), along(rect.y, rect.size.height));
    Rect::new(x, y, Size::new(width, height))
}

/// The part of planes over `whole` that lies over `part`, which is inside it.
fn cut(planes: Planes, whole: Rect, part: Rect) -> Planes {
    if part == whole {
        return planes;
    }
    let (x, y) = ((part.x - whole.x) as usize, (part.y - whole.y) as usize);
    planes.crop(x, y, part.size).expect("the part lies inside")
}

/// The levels of an endless plane, ready to run.
#[derive(Debug)]
pub struct Realisation<'a> {
    levels: &'a [Level],
    recursions: Vec<Recursion>,
    kernel: &'a Kernel,
    structure: Option<&'a Structure>,
    seed: u64,
    period: Option<[i64; 2]>,
}

impl<'a> Realisation<'a> {
    /// The plane of these levels, the finest first, beside a structure, under a seed. With a period it repeats after as many
    /// texels of the finest level along x and y, which must be multiples of the factor to the power of the
    /// number of levels minus one.
    pub fn new(
        levels: &'a [Level],
        kernel: &'a Kernel,
        structure: Option<&'a Structure>,
        seed: u64,
        period: Option<[i64; 2]>,
    ) -> Self {
        let recursions =
            levels.iter().zip(0..).map(|(level, number)| Recursion::new(level, number)).collect();
        Self { levels, recursions, kernel, structure, seed, period }
    }

    /// The field over an area of the finest level.
    ///
    /// # Errors
    /// When the job is cancelled.
    pub fn field(&self, area: Rect, job: &Job) -> Result<Planes> {
        self.level(0, area, job)
    }

    /// A level of the Gaussian pyramid over an area: the expanded coarser level plus the band.
    fn level(&self, k: usize, area: Rect, job: &Job) -> Result<Planes> {
        let (level, cells, reach) = (&self.levels[k], cells(area), seen_around(&self.levels[k]));
        let run = grown(cells, margin(level));
        let seen = grown(run, reach);
        let expanded = (k + 1 < self.levels.len()).then(|| self.expanded(k, seen, job)).transpose()?;
        let known = self.known(k, seen, expanded.as_ref(), job)?;
        let drive = match &known {
            Some(known) if !level.coarse.is_empty() => Some(drive(level, known, reach, run.size)),
            _ => None,
        };
        let drive = drive.as_ref().map(|planes| Drive { planes, origin: run.origin() });
        let mut field = cut(self.band(k, cells, drive, job)?, cells, area);
        if let (Some(gain), Some(known)) = (&level.gain, &known) {
            let origin = [area.x - seen.x, area.y - seen.y].map(|v| v as usize);
            gain.multiply(&mut field, known, origin);
        }
        drop(known);
        if let Some(expanded) = expanded {
            pyramid::add(&mut field, &cut(expanded, seen, area));
        }
        Ok(field)
    }

    /// What is known of a level before its band: the structure at its resolution, and the expanded coarser level.
    fn known<'b>(
        &self,
        k: usize,
        area: Rect,
        expanded: Option<&'b Planes>,
        job: &Job,
    ) -> Result<Option<Cow<'b, Planes>>> {
        let level = &self.levels[k];
        let is_needed = !level.coarse.is_empty() || level.gain.is_some();
        let Some(structure) = self.structure.filter(|structure| is_needed && structure.predicts) else {
            return Ok(expanded.map(Cow::Borrowed));
        };
        let mut known = structure.reduced_window((self.kernel, k), area, self.seed, self.period, job)?;
        if let Some(expanded) = expanded {
            pyramid::add(&mut known, expanded);
        }
        Ok(Some(Cow::Owned(known)))
    }

    /// The level coarser than `k`, expanded over an area of level `k`.
    fn expanded(&self, k: usize, area: Rect, job: &Job) -> Result<Planes> {
        let (x, width) = pyramid::window_for(self.kernel, area.x, area.size.width);
        let (y, height) = pyramid::window_for(self.kernel, area.y, area.size.height);
        let coarse = self.level(k + 1, Rect::new(x, y, Size::new(width, height)), job)?;
        Ok(pyramid::expand_window(&coarse, self.kernel, [x, y], area.origin(), area.size))
    }

    /// The columns and rows of a level after which the plane repeats.
    fn period_of(&self, k: usize) -> Option<[i64; 2]> {
        let scale = (self.kernel.factor() as i64).pow(k as u32);
        self.period.map(|period| period.map(|side| side / scale))
    }

    /// The band of a level over whole cells.
    fn band(&self, k: usize, cells: Rect, drive: Option<Drive<'_>>, job: &Job) -> Result<Planes> {
        let m = self.levels[k].planes();
        let (columns, rows) = (cells.size.width / CELL, cells.size.height / CELL);
        let (level, period) = (&self.levels[k], self.period_of(k));
        let strengths = Strengths { steps: level.unevenness, level: k, seed: self.seed, period };
        let around = grown(cells, margin(level));
        let strengths = (level.unevenness > 0).then(|| strengths.over(around));
        let strength = strengths.as_ref().map(|planes| Drive { planes, origin: around.origin() });
        let run = CellRun {
            strength,
            recursion: &self.recursions[k],
            margin: level.burn_in,
            drive,
            seed: self.seed,
            period,
        };
        // As many rows of cells at a time as fill the lanes.
        let together = LANES.div_ceil(columns).min(rows);
        let mut band = Planes::zeros(cells.size, m);
        let parts = band.bands_mut(together * CELL * cells.size.width);
        parallel::try_for_each(parts.into_iter().enumerate(), |(part, mut planes)| -> Result<()> {
            let cells: Vec<Cell> = (0..planes[0].len() / (CELL * CELL))
                .map(|c| (c % columns, c / columns))
                .map(|(x, y)| Cell {
                    origin: [cells.x + (x * CELL) as i64, cells.y + ((part * together + y) * CELL) as i64],
                    at: (y * CELL) * cells.size.width + x * CELL,
                })
                .collect();
            cells.chunks(LANES).try_for_each(|some| {
                job.proceed()?;
                run.fill(some, &mut planes, cells_width(columns));
                Ok(())
            })
        })?;
        Ok(band)
    }
}

fn cells_width(columns: usize) -> usize {
    columns * CELL
}

/// The position of a cell on the plane, and that of its first texel in the output planes.
struct Cell {
    origin: [i64; 2],
    at: usize,
}

/// The common data of all cells of a level.
struct CellRun<'a> {
    recursion: &'a Recursion,
    margin: usize,
    drive: Option<Drive<'a>>,
    strength: Option<Drive<'a>>,
    seed: u64,
    period: Option<[i64; 2]>,
}

impl CellRun<'_> {
    /// Computes up to sixteen cells and writes them into planes of `width` columns.
    fn fill(&self, cells: &[Cell], planes: &mut [&mut [f32]], width: usize) {
        let margin = self.margin;
        // Lanes without a cell repeat the last one.
        let origins =
            std::array::from_fn(|l| cells[l.min(cells.len() - 1)].origin.map(|v| v - margin as i64));
        let run = RecursionRun {
            size: Size::new(margin + CELL + margin, margin + CELL),
            drive: self.drive,
            strength: self.strength,
            seed: self.seed,
            period: self.period,
        };
        let texel = planes.len() * LANES;
        self.recursion.run(&origins, &run, |y, row| {
            let Some(y) = y.checked_sub(margin) else { return };
            let row = &row[margin * texel..(margin + CELL) * texel];
            for (l, cell) in cells.iter().enumerate() {
                for (j, plane) in planes.iter_mut().enumerate() {
                    let out = &mut plane[cell.at + y * width..][..CELL];
                    out.iter_mut().zip(row[j * LANES + l..].iter().step_by(texel)).for_each(|(o, v)| *o = *v);
                }
            }
        });
    }
}

/// The margin computed around a cell.
fn margin(level: &Level) -> Reach {
    let texels = level.burn_in;
    Reach { left: texels, right: texels, up: texels, down: 0 }
}

/// How far beyond its own texels a level sees what is known: its coarse neighbours, and the gradient.
fn seen_around(level: &Level) -> Reach {
    let Reach { left, right, up, down } = Reach::of(&level.coarse);
    let rim = if level.gain.is_some() { 1 } else { 0 };
    Reach { left: left.max(rim), right: right.max(rim), up: up.max(rim), down: down.max(rim) }
}

/// The contribution of what is known to each texel of `size`; its planes extend farther
/// by `reach`.
fn drive(level: &Level, known: &Planes, reach: Reach, size: Size) -> Planes {
    let m = level.planes();
    let weights = level.weights.values(true);
    let mut planes = Planes::zeros(size, m);
    let source = known.size();
    for (j, plane) in planes.iter_mut().enumerate() {
        parallel::for_each(plane.chunks_exact_mut(size.width).enumerate(), |(y, row)| {
            for (t, o) in level.coarse.iter().enumerate() {
                let y = (y + reach.up).wrapping_add_signed(o.dy as isize);
                let x = reach.left.wrapping_add_signed(o.dx as isize);
                for i in 0..m {
                    let weight = weights[(t * m + i) * m + j];
                    let values = &known.plane(i)[source.index(x, y)..][..size.width];
                    row.iter_mut().zip(values).for_each(|(o, v)| *o += weight * v);
                }
            }
        });
    }
    planes
}
