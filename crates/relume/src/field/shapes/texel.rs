//! Which photographs of a texel show it in shadow or in a highlight, by a matt surface fitted to all of them.
//!
//! The normal times the albedo is fitted to the linear brightness with weights 1 / (1 + (r / s)²) of the residuals r, which
//! shadows and highlights lose (iteratively reweighted least squares; P. W. Holland, R. E. Welsch, "Robust regression using
//! iteratively reweighted least-squares", Communications in Statistics A6, 1977), from those between the darkest third and
//! the brightest twelfth.

use crate::direction::Direction;
use crate::numeric::small::solve_spd;
use crate::space::Space;

/// The flag of a photograph in which a texel is lit.
pub(super) const LIT: u8 = 1;

/// The flag of a photograph that shows a highlight.
pub(super) const BRIGHT: u8 = 2;

/// Numbers of a channel of a texel: the value where lit as a polynomial of 1, x, y and z, and the means in shadow and in
/// highlights.
pub(super) const LEVELS: usize = 6;

/// Below this share of the matt surface's brightness a texel is in shadow.
const DARK_SHARE: f64 = 0.3;

/// Above this share it shows a highlight.
const BRIGHT_SHARE: f64 = 2.5;

/// The least brightness of a highlight.
const LEAST_HIGHLIGHT: f64 = 0.1;

/// The least brightness of a matt surface on which a highlight is told from noise.
const LEAST_MATT: f64 = 0.02;

/// Passes of the robust fit; later ones change few flags.
const PASSES: usize = 12;

/// The penalty that keeps a polynomial of few lit photographs small, in photographs.
const RIDGE: f64 = 0.02;

/// Levels without a contrast: no photograph shows a shadow, or a highlight.
pub(super) const NEVER_DARK: f32 = 1e6;
pub(super) const NEVER_BRIGHT: f32 = -1e6;

/// The functions of the polynomial for a light.
pub(super) fn terms(light: Direction) -> [f32; 4] {
    [1.0, light.x() as f32, light.y() as f32, light.z() as f32]
}

/// The working memory for one texel after another.
pub(super) struct TexelJudge<'a> {
    lights: &'a [Direction],
    channels: usize,
    space: Space,
    brightness: Vec<f64>,
    sorted: Vec<f64>,
    weights: Vec<f64>,
}

impl<'a> TexelJudge<'a> {
    pub fn new(lights: &'a [Direction], channels: usize, space: Space) -> Self {
        let zeros = vec![0.0; lights.len()];
        let (brightness, sorted, weights) = (zeros.clone(), zeros.clone(), zeros);
        Self { lights, channels, space, brightness, sorted, weights }
    }

    /// Writes the flag of each photograph and the levels of each channel, from the values `value(c n + i)` of channel c
    /// in photograph i of n.
    pub fn judge(&mut self, value: impl Fn(usize) -> f32, flags: &mut [u8], levels: &mut [f32]) {
        let n = self.lights.len();
        for (i, brightness) in self.brightness.iter_mut().enumerate() {
            let sum =
                (0..self.channels).map(|c| f64::from(self.space.to_linear(value(c * n + i)))).sum::<f64>();
            *brightness = sum / self.channels as f64;
        }
        let matt = self.matt_surface();
        for ((flag, light), brightness) in flags.iter_mut().zip(self.lights).zip(&self.brightness) {
            let expected = along(matt, *light);
            let is_bright = *brightness > BRIGHT_SHARE * expected
                && *brightness > LEAST_HIGHLIGHT
                && expected > LEAST_MATT;
            *flag = if *brightness > DARK_SHARE * expected { LIT } else { 0 }
                | if is_bright { BRIGHT } else { 0 };
        }
        for (c, levels) in levels.as_chunks_mut::<LEVELS>().0.iter_mut().enumerate() {
            *levels = self.levels(|i| f64::from(value(c * n + i)), flags);
        }
    }

    /// The normal times the albedo.
    fn matt_surface(&mut self) -> [f64; 3] {
        let n = self.lights.len();
        self.sorted.copy_from_slice(&self.brightness);
        self.sorted.sort_by(f64::total_cmp);
        let at = |share: f64| self.sorted[((share * n as f64) as usize).min(n - 1)];
        let (low, high, median) = (at(0.35), at(0.92), self.sorted[n / 2]);
        for (weight, brightness) in self.weights.iter_mut().zip(&self.brightness) {
            *weight = f64::from(u8::from((low..=high).contains(brightness)));
        }
        let mut matt = [0.0; 3];
        for _ in 0..PASSES {
            matt = self.weighted_surface();
            for ((weight, light), brightness) in
                self.weights.iter_mut().zip(self.lights).zip(&self.brightness)
            {
                let expected = along(matt, *light);
                let residual = (brightness - expected) / (0.1 * median + 0.05 * expected + 1e-3);
                *weight = if expected > 0.0 { 1.0 / (1.0 + residual * residual) } else { 0.0 };
            }
        }
        matt
    }

    /// The least-squares surface under the weights.
    fn weighted_surface(&self) -> [f64; 3] {
        let (mut squares, mut sums) = ([[0.0; 3]; 3], [0.0; 3]);
        for ((light, weight), brightness) in self.lights.iter().zip(&self.weights).zip(&self.brightness) {
            add_equation(&mut squares, &mut sums, light.to_array(), *weight, *brightness);
        }
        (0..3).for_each(|k| squares[k][k] += 1e-6);
        solve_spd(&squares, &sums).unwrap_or_default()
    }

    /// The levels of one channel.
    fn levels(&self, value: impl Fn(usize) -> f64, flags: &[u8]) -> [f32; LEVELS] {
        let (mut squares, mut sums) = ([[0.0; 4]; 4], [0.0; 4]);
        let (mut dark, mut bright) = ((0.0, 0.0), (0.0, 0.0));
        for (i, (light, flag)) in self.lights.iter().zip(flags).enumerate() {
            let value = value(i);
            if *flag == LIT {
                let [x, y, z] = light.to_array();
                add_equation(&mut squares, &mut sums, [1.0, x, y, z], 1.0, value);
            }
            let part = if *flag & BRIGHT != 0 { &mut bright } else { &mut dark };
            if *flag != LIT {
                *part = (part.0 + value, part.1 + 1.0);
            }
        }
        (0..4).for_each(|k| squares[k][k] += RIDGE);
        let lit = solve_spd(&squares, &sums).unwrap_or_default().map(|level| level as f32);
        let mean =
            |(sum, count): (f64, f64), none: f32| if count > 0.0 { (sum / count) as f32 } else { none };
        let [a, b, c, d] = lit;
        [a, b, c, d, mean(dark, NEVER_DARK), mean(bright, NEVER_BRIGHT)]
    }
}

/// The brightness of a matt surface under a light.
fn along(matt: [f64; 3], light: Direction) -> f64 {
    let light = light.to_array();
    (matt[0] * light[0] + matt[1] * light[1] + matt[2] * light[2]).max(0.0)
}

/// Adds an equation to the normal equations of a least-squares fit.
fn add_equation<const N: usize>(
    squares: &mut [[f64; N]; N],
    sums: &mut [f64; N],
    row: [f64; N],
    weight: f64,
    value: f64,
) {
    for j in 0..N {
        (0..=j).for_each(|k| squares[j][k] += weight * row[j] * row[k]);
        sums[j] += weight * row[j] * value;
    }
}
