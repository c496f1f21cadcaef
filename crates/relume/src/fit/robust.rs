//! Fits of each texel by itself: robust ones, and those under near lamps, whose directions differ from texel to texel.
//!
//! In robust fits, photographs that do not follow the functions at a texel, because of its shadows and highlights, count
//! less there or not at all.
//!
//! - *trimmed*: the darkest quarter and the brightest tenth of the photographs at a texel, by luminance, are left out
//!   (Rousseeuw, "Least Median of Squares Regression", Journal of the American Statistical Association 79, 1984, for
//!   trimming; by rank rather than by residual as in Drew, Hel-Or, Malzbender, Hajari, "Robust estimation of surface
//!   properties and interpolation of shadow/specularity components", Image and Vision Computing 30, 2012).
//! - *reweighted*: iteratively reweighted least squares with the weights of Huber, min(1, k s / r), for the residual r over
//!   all channels, its scale s = 1.4826 median r, and k = 1.345 (Holland, Welsch, "Robust regression using iteratively
//!   reweighted least-squares", Communications in Statistics 6, 1977).
//!
//! The weighted normal equations are solved texel by texel, so all photographs are in memory. Where the photographs left do
//! not determine the functions, the texel keeps the coefficients of least squares.

use super::design::Design;
use super::levels::SampleLevels;
use super::products::BAND;
use crate::error::{Error, Result};
use crate::job::Job;
use crate::lamps::LampPositions;
use crate::names::Named;
use crate::numeric::Matrix;
use crate::parallel;
use crate::planes::Planes;
use crate::raster::Raster;

/// The shares of photographs that a trimmed fit leaves out.
const DARKEST: f64 = 0.25;
const BRIGHTEST: f64 = 0.1;

/// Rounds of reweighting: the coefficients change by less than a code of 8 bits after them.
const ROUNDS: usize = 8;

/// Residuals count in full up to this number of standard deviations.
const HUBER: f64 = 1.345;

/// From the median of absolute values to the standard deviation of a normal distribution.
const MEDIAN_TO_DEVIATION: f64 = 1.4826;

/// Residuals below this count in full: a quarter of a code of 8 bits.
const LEAST_SCALE: f64 = 0.001;

/// Which photographs count at a texel.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, serde::Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Robust {
    /// All alike: least squares.
    #[default]
    None,
    /// Neither the darkest quarter nor the brightest tenth.
    Trimmed,
    /// Those that differ much from the function less.
    Reweighted,
}

crate::names::named!(Robust { None => "none", Trimmed => "trimmed", Reweighted => "reweighted" });

/// What a fit of each texel by itself did.
#[derive(Debug, Clone, Copy, PartialEq, Eq, serde::Serialize)]
#[non_exhaustive]
pub struct TexelFitReport {
    /// Texels whose photographs determined the functions.
    pub refitted: usize,
    /// Texels that keep the coefficients of least squares, under near lamps those for directions from the middle, because
    /// the photographs left there do not determine the functions.
    pub kept: usize,
    /// The darkest photographs that a trimmed fit left out at each refitted texel.
    pub darkest_left_out: usize,
    /// The brightest.
    pub brightest_left_out: usize,
}

impl TexelFitReport {
    /// A reason to doubt the coefficients, if there is one.
    pub(super) fn warning(&self, robust: Robust) -> Option<String> {
        let all = self.refitted + self.kept;
        (self.kept > 0).then(|| {
            let rule = if robust == Robust::None { "near lamps" } else { robust.name() };
            format!(
                "{rule}: at {} of {all} texels the photographs left do not determine the functions, and these keep plain least \
                 squares: fewer functions or a ridge (--ridge auto) would do",
                self.kept
            )
        })
    }
}

/// The photographs of `count` that a trimmed fit leaves out at each texel: the darkest and the brightest.
fn left_out(count: usize) -> (usize, usize) {
    ((DARKEST * count as f64) as usize, (BRIGHTEST * count as f64) as usize)
}

/// Refuses to trim where fewer photographs would be left than there are functions.
pub(super) fn check(robust: Robust, design: &Design) -> Result<()> {
    if robust != Robust::Trimmed {
        return Ok(());
    }
    let (dark, bright) = left_out(design.lights());
    let left = design.lights() - dark - bright;
    if left >= design.functions() || design.penalty().is_some() {
        return Ok(());
    }
    Err(Error::invalid(format!(
        "a trimmed fit leaves {left} of {} photographs at each texel, and {} functions need as many: choose a basis of fewer, \
         a ridge, or a reweighted fit",
        design.lights(),
        design.functions()
    )))
}

/// How the photographs of a texel are fitted.
#[derive(Debug, Clone, Copy)]
pub(super) struct TexelRule<'a> {
    pub robust: Robust,
    /// Lamps whose light has another direction at each texel.
    pub lamps: Option<&'a LampPositions>,
    /// Texels outside stay as they are.
    pub mask: Option<&'a [bool]>,
}

/// Replaces the coefficients of least squares: plane c n + k is function k of channel c. `None` where nothing is asked for.
pub(super) fn refine(
    sums: &mut Planes,
    photographs: &[Raster],
    rule: TexelRule<'_>,
    design: &Design,
    levels: &SampleLevels,
    job: &Job,
) -> Result<Option<TexelFitReport>> {
    let Some(channels) = photographs.first().map(Raster::channels) else { return Ok(None) };
    let (n, width) = (design.functions(), sums.size().width);
    let bands = sums.bands_mut(BAND).into_iter().enumerate();
    let of_bands = parallel::try_map(bands, |(b, mut band)| {
        job.proceed()?;
        let texels = band[0].len();
        let mut values = vec![0.0f32; photographs.len() * channels * texels];
        for (row, (i, channel)) in values
            .chunks_exact_mut(texels)
            .zip((0..photographs.len()).flat_map(|i| (0..channels).map(move |channel| (i, channel))))
        {
            levels.channel(&photographs[i], channel, b * BAND, row);
        }
        let mut texel = TexelFit::new(design, rule, channels);
        let (mut refitted, mut kept) = (0, 0);
        for t in (0..texels).filter(|t| rule.mask.is_none_or(|mask| mask[b * BAND + t])) {
            texel.place((b * BAND + t) % width, (b * BAND + t) / width);
            texel.load(|i, channel| f64::from(values[(i * channels + channel) * texels + t]));
            let before = |c: usize, k: usize| f64::from(band[c * n + k][t]);
            if texel.solve(before) {
                for (k, plane) in band.iter_mut().take(channels * n).enumerate() {
                    plane[t] = texel.coefficients[k] as f32;
                }
                refitted += 1;
            } else {
                kept += 1;
            }
        }
        Ok((refitted, kept))
    })?;
    let (refitted, kept) = of_bands.into_iter().fold((0, 0), |a, b| (a.0 + b.0, a.1 + b.1));
    let trimmed = if rule.robust == Robust::Trimmed { left_out(photographs.len()) } else { (0, 0) };
    Ok(Some(TexelFitReport { refitted, kept, darkest_left_out: trimmed.0, brightest_left_out: trimmed.1 }))
}

/// The weighted fit of one texel.
struct TexelFit<'a> {
    design: &'a Design,
    rule: TexelRule<'a>,
    channels: usize,
    /// The values of the functions under each light here, where they differ from those of the design.
    functions: Vec<f64>,
    /// Photograph after photograph, the channels together.
    values: Vec<f64>,
    weights: Vec<f64>,
    /// Channel after channel.
    coefficients: Vec<f64>,
    order: Vec<usize>,
}

impl<'a> TexelFit<'a> {
    fn new(design: &'a Design, rule: TexelRule<'a>, channels: usize) -> Self {
        let lights = design.lights();
        Self {
            design,
            rule,
            channels,
            functions: Vec::new(),
            values: vec![0.0; lights * channels],
            weights: vec![1.0; lights],
            coefficients: vec![0.0; channels * design.functions()],
            order: Vec::with_capacity(lights),
        }
    }

    /// Takes the lights from their directions at a texel.
    fn place(&mut self, x: usize, y: usize) {
        let Some(lamps) = self.rule.lamps else { return };
        let n = self.design.functions();
        self.functions.resize(self.design.lights() * n, 0.0);
        for (i, functions) in self.functions.chunks_exact_mut(n).enumerate() {
            self.design.basis().weights_into(lamps.direction_at(i, x, y).into(), functions);
        }
    }

    /// The values of the functions under light `i` here.
    fn functions(&self, i: usize) -> &[f64] {
        match self.rule.lamps {
            None => self.design.values(i),
            Some(_) => &self.functions[i * self.design.functions()..][..self.design.functions()],
        }
    }

    fn load(&mut self, value: impl Fn(usize, usize) -> f64) {
        for (i, values) in self.values.chunks_exact_mut(self.channels).enumerate() {
            values.iter_mut().enumerate().for_each(|(channel, v)| *v = value(i, channel));
        }
    }

    /// Whether the photographs determine the functions.
    fn solve(&mut self, before: impl Fn(usize, usize) -> f64) -> bool {
        let n = self.design.functions();
        (0..self.coefficients.len()).for_each(|i| self.coefficients[i] = before(i / n, i % n));
        if self.rule.lamps.is_some() {
            self.weights.fill(1.0);
            if self.weighted().is_err() {
                return false;
            }
        }
        match self.rule.robust {
            Robust::None => self.rule.lamps.is_some(),
            Robust::Trimmed => {
                self.trim();
                self.weighted().is_ok()
            }
            Robust::Reweighted => (0..ROUNDS).all(|_| {
                self.reweight();
                self.weighted().is_ok()
            }),
        }
    }

    /// Weight 0 for the darkest and the brightest photographs, by the sum of the channels; ties by number.
    fn trim(&mut self) {
        let sum = |i: usize| self.values[i * self.channels..][..self.channels].iter().sum::<f64>();
        self.order.clear();
        self.order.extend(0..self.weights.len());
        self.order.sort_by(|&a, &b| sum(a).total_cmp(&sum(b)).then(a.cmp(&b)));
        let (dark, bright) = left_out(self.order.len());
        let kept = dark..self.order.len() - bright;
        for (rank, &i) in self.order.iter().enumerate() {
            self.weights[i] = f64::from(u8::from(kept.contains(&rank)));
        }
    }

    fn reweight(&mut self) {
        let n = self.design.functions();
        for i in 0..self.weights.len() {
            let functions = self.functions(i);
            let residual = |c: usize| {
                let coefficients = &self.coefficients[c * n..][..n];
                let relit: f64 = functions.iter().zip(coefficients).map(|(f, c)| f * c).sum();
                (self.values[i * self.channels + c] - relit).powi(2)
            };
            self.weights[i] = (0..self.channels).map(residual).sum::<f64>().sqrt();
        }
        let mut sorted = self.weights.clone();
        let middle = sorted.len() / 2;
        let (_, median, _) = sorted.select_nth_unstable_by(middle, f64::total_cmp);
        let limit = HUBER * (MEDIAN_TO_DEVIATION * *median).max(LEAST_SCALE);
        self.weights.iter_mut().for_each(|w| *w = if *w > limit { limit / *w } else { 1.0 });
    }

    /// Solves (A'WA + R) c = A'W p for all channels.
    fn weighted(&mut self) -> Result<()> {
        let n = self.design.functions();
        let mut normal = self.design.penalty().cloned().unwrap_or_else(|| Matrix::zeros(n, n));
        let mut right = vec![0.0; self.channels * n];
        for (i, &weight) in self.weights.iter().enumerate().filter(|(_, weight)| **weight > 0.0) {
            let functions = self.functions(i);
            for (j, &f) in functions.iter().enumerate() {
                let factor = weight * f;
                let row = &mut normal.row_mut(j)[..=j];
                row.iter_mut().zip(functions).for_each(|(sum, g)| *sum += factor * g);
                for c in 0..self.channels {
                    right[c * n + j] += factor * self.values[i * self.channels + c];
                }
            }
        }
        let factor = normal.cholesky()?;
        if (0..n).any(|j| factor[(j, j)].powi(2) <= LEAST_PIVOT * normal[(j, j)]) {
            return Err(Error::invalid("the photographs left do not determine the functions"));
        }
        for (right, out) in right.chunks_exact(n).zip(self.coefficients.chunks_exact_mut(n)) {
            solve_factored(&factor, right, out);
        }
        Ok(())
    }
}

/// The square of the least sine of the angle between a function and the others over the photographs left.
const LEAST_PIVOT: f64 = 1e-4;

/// Solves L L' x = b.
fn solve_factored(factor: &Matrix, right: &[f64], out: &mut [f64]) {
    let n = right.len();
    for i in 0..n {
        let known: f64 = (0..i).map(|j| factor[(i, j)] * out[j]).sum();
        out[i] = (right[i] - known) / factor[(i, i)];
    }
    for i in (0..n).rev() {
        let known: f64 = (i + 1..n).map(|j| factor[(j, i)] * out[j]).sum();
        out[i] = (out[i] - known) / factor[(i, i)];
    }
}

#[cfg(test)]
mod tests;
