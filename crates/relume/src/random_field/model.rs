//! The whole model of a set of planes, and planes of any size from it.

use super::estimate::outside;
use super::joint_color::JointColor;
use super::level::Level;
use super::marginal::Marginal;
use super::mixing::Mixing;
use super::realisation::{CELL, Realisation};
use super::stability::BURN_INS;
use super::structure::Structure;
use crate::error::{Error, Result};
use crate::job::Job;
use crate::numeric::pyramid::{self, Kernel};
use crate::parallel;
use crate::planes::Planes;
use crate::rect::Rect;
use crate::size::Size;

/// A random field of d planes.
#[derive(Debug, Clone, PartialEq)]
pub struct Model {
    /// The distribution of the values of each plane that is no part of the colour.
    pub marginals: Vec<Marginal>,
    /// The joint distribution of three planes that hold a colour.
    pub color: Option<JointColor>,
    /// The normal scores of the planes as combinations of m components.
    pub mixing: Mixing,
    /// The factors that bring the scores of each plane to variance one.
    pub gains: Vec<f32>,
    /// The kernel of the pyramid.
    pub kernel: Kernel,
    /// The pyramid of the components, the finest level first.
    pub levels: Vec<Level>,
    /// The part of the components copied from tiles.
    pub structure: Option<Structure>,
}

/// The window, seed and period of a realisation.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct RealisationOptions {
    /// The top left texel of the window on the endless plane.
    pub origin: [i64; 2],
    /// Columns and rows.
    pub size: Size,
    /// Another seed gives another plane.
    pub seed: u64,
    /// The number of columns and rows after which the plane repeats, if it does.
    pub period: Option<Size>,
}

/// The largest distance of a position from (0, 0).
const FARTHEST: u64 = 1 << 40;

impl Model {
    /// The number of planes d.
    pub fn planes(&self) -> usize {
        self.mixing.own.len()
    }

    /// Whether detail depends on the place: on what is coarser there, on the structure, or on chance.
    pub fn has_local_detail(&self) -> bool {
        let is_predicted = self.structure.as_ref().is_some_and(|structure| structure.predicts);
        is_predicted || self.levels.iter().any(|level| level.gain.is_some() || level.unevenness > 0)
    }

    /// The texels of which the sides of a tile must be multiples, along x and y: the finest texels in one
    /// coarsest texel, and the tiles of the structure.
    pub fn tile_steps(&self) -> [usize; 2] {
        let step = self.kernel.factor().pow(self.levels.len().saturating_sub(1) as u32);
        let Some(structure) = &self.structure else { return [step; 2] };
        [structure.tile.width, structure.tile.height].map(|side| side / gcd(side, step) * step)
    }

    /// A part of the plane of the model.
    ///
    /// # Errors
    /// A period whose sides the pyramid does not divide, a position beyond 2^40 texels, or more memory than
    /// the limits allow.
    pub fn synthesize(&self, options: &RealisationOptions, job: &Job) -> Result<Planes> {
        self.check(options, job)?;
        let period = options.period.map(|period| [period.width as i64, period.height as i64]);
        let mut planes = self.scores(
            Rect::new(options.origin[0], options.origin[1], options.size),
            options.seed,
            period,
            job,
        )?;
        self.distribute(&mut planes);
        Ok(planes)
    }

    /// Normal scores, with a variance not yet exactly one.
    pub(super) fn scores(
        &self,
        area: Rect,
        seed: u64,
        period: Option<[i64; 2]>,
        job: &Job,
    ) -> Result<Planes> {
        let mut field = match self.levels.is_empty() {
            true => Planes::zeros(area.size, self.mixing.components()),
            false => Realisation::new(&self.levels, &self.kernel, self.structure.as_ref(), seed, period)
                .field(area, job)?,
        };
        if let Some(structure) = &self.structure {
            pyramid::add(&mut field, &structure.window(area, seed, period, job)?);
        }
        Ok(self.mixing.planes_of(&field))
    }

    /// Turns the scores of all planes into values.
    fn distribute(&self, planes: &mut Planes) {
        let single = outside(self.color.as_ref().map(|color| color.first), self.planes());
        for (k, marginal) in single.zip(&self.marginals) {
            let (gain, values) = (self.gains[k], marginal.values());
            parallel::for_each_value(planes.plane_mut(k), |_, v| *v = values(gain * *v));
        }
        if let Some(color) = &self.color {
            color.apply(planes, &self.gains);
        }
    }

    fn check(&self, options: &RealisationOptions, job: &Job) -> Result<()> {
        options.period.map_or(Ok(()), |period| self.check_period(period))?;
        if options.origin.iter().any(|v| v.unsigned_abs() > FARTHEST) {
            return Err(Error::usage(format!(
                "the place ({}, {}) is farther than 2^40 texels from the plane's origin",
                options.origin[0], options.origin[1]
            )));
        }
        job.check("the texture", options.size, 4 * self.planes() as u64)?;
        job.check_bytes("making the texture", realisation_bytes(options.size, self.bytes_per_texel()))
    }

    /// The working memory per texel, in bytes: the field, the expanded level, the drive, coarser levels and strengths; with a
    /// structure it and the sum of it and the expanded level.
    pub fn bytes_per_texel(&self) -> u64 {
        let each = if self.structure.is_some() { 6 } else { 4 };
        4 * (each * self.mixing.components() + 2 * self.planes() + 1) as u64
    }

    fn check_period(&self, period: Size) -> Result<()> {
        let Size { width, height } = period;
        let [across, down] = self.tile_steps();
        if width > 0 && height > 0 && width.is_multiple_of(across) && height.is_multiple_of(down) {
            return Ok(());
        }
        Err(Error::usage(format!(
            "a tile of {period} texels does not close: with this model's {} levels and tiles its sides must be \
             multiples of {across} and {down}, such as {}",
            self.levels.len(),
            Size::new(width.next_multiple_of(across), height.next_multiple_of(down))
        )))
    }
}

/// The memory of making `size` texels at so many bytes each, with the cells and margins around them.
pub fn realisation_bytes(size: Size, bytes_per_texel: u64) -> u64 {
    let around = CELL + 2 * BURN_INS[BURN_INS.len() - 1];
    let [width, height] = [size.width, size.height].map(|side| side.saturating_add(around) as u64);
    width.saturating_mul(height).saturating_mul(bytes_per_texel)
}

fn gcd(a: usize, b: usize) -> usize {
    if b == 0 { a } else { gcd(b, a % b) }
}
