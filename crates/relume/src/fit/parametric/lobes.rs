//! Lobes with their derivatives: of pairs of light and view, or of the lights of one view.
//!
//! Parameters of a texel are its numbers ([`crate::field::parametric`]) with the logarithm of the exponent in its place. The
//! length of the weights, which the values leave open, is held by a weak condition and set afterwards.

use super::encoded::TexelReflectance;
use crate::direction::Directions;
use crate::numeric::levenberg_marquardt::NormalEquations;
use crate::space::Space;

/// Numbers of a lobe beside its colour.
pub(super) const FORM: usize = 4;

/// Exponents. Of more than 128 the lobe is narrower than usual measurements are apart.
const EXPONENTS: [f64; 2] = [0.5, 128.0];
/// The brightest colour.
const BRIGHTEST: f64 = 16.0;
/// The brightest peak of a lobe, six stops above the white of a photograph: what is brighter lies where no pair was
/// measured, as a narrow lobe between them may.
const BRIGHTEST_PEAK: f64 = 64.0;
/// The brightest colour of a texel's lobes of one view, in units of its brightest value over the cosine of the light: few lights
/// leave room for lobes between them that shine in one channel alone.
const BRIGHTEST_OF_TEXEL: f64 = 1.5;
/// That unit where the photograph is white: two stops more may hide behind it.
const BEHIND_WHITE: f64 = 4.0;
/// Lights lower than this cosine count as of it.
const LOWEST_COSINE: f64 = 0.1;
/// Weights, whose length is held by a weak condition.
const LARGEST_WEIGHT: f64 = 2.5;
/// The weight of that condition; the values do not depend on it.
const CONDITION: f64 = 0.03;

/// What the weights of lobes multiply.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Multiplied {
    /// Products of the components of light and view.
    Products,
    /// The components of the light.
    Light,
}

impl Multiplied {
    /// The square of the length of the weights during a fit.
    fn square_length(self) -> f64 {
        match self {
            Self::Products => 2.0,
            Self::Light => 1.0,
        }
    }

    /// The largest value of the sum of weights times what they multiply.
    fn largest(self, weights: &[f64]) -> f64 {
        match self {
            Self::Products => weights.iter().fold(0.0, |most: f64, w| most.max(w.abs())),
            Self::Light => weights.iter().map(|w| w * w).sum::<f64>().sqrt(),
        }
    }
}

/// Lobes at some pairs.
#[derive(Debug, Clone)]
pub(super) struct LobeModel {
    channels: usize,
    lobes: usize,
    /// For each pair what the weights multiply, and the cosine of the light.
    places: Vec<([f64; 3], f64)>,
    bounds: Vec<[f64; 2]>,
    multiplied: Multiplied,
    /// What the forms of lobes are held near to, if they are.
    typical: Option<TypicalLobes>,
}

/// The forms that are typical of a texture: the weights and the logarithm of the exponent of each lobe of the mean of its texels,
/// and what a deviation of 1 of each counts.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct TypicalLobes {
    pub forms: Vec<[f64; FORM]>,
    pub weights: [f64; FORM],
}

impl LobeModel {
    /// Of light and view.
    pub fn of_pairs(channels: usize, lobes: usize, pairs: &[Directions]) -> Self {
        let place = |pair: &Directions| {
            let (l, v) = (pair.light.to_array(), pair.view.to_array());
            ([l[0] * v[0], l[1] * v[1], l[2] * v[2]], l[2].max(0.0))
        };
        Self::new(channels, lobes, pairs.iter().map(place).collect(), Multiplied::Products)
    }

    /// Of the lights of one view.
    pub fn of_lights(channels: usize, lobes: usize, pairs: &[Directions]) -> Self {
        let place = |pair: &Directions| (pair.light.to_array(), pair.light.z().max(0.0));
        Self::new(channels, lobes, pairs.iter().map(place).collect(), Multiplied::Light)
    }

    fn new(channels: usize, lobes: usize, places: Vec<([f64; 3], f64)>, multiplied: Multiplied) -> Self {
        let mut bounds = vec![[0.0, BRIGHTEST]; channels];
        for _ in 0..lobes {
            bounds.extend(std::iter::repeat_n([0.0, BRIGHTEST], channels));
            bounds.extend([[-LARGEST_WEIGHT, LARGEST_WEIGHT]; 3]);
            bounds.push(EXPONENTS.map(f64::ln));
        }
        Self { channels, lobes, places, bounds, multiplied, typical: None }
    }

    /// The same with forms that are held near to these.
    pub fn held_near(self, typical: TypicalLobes) -> Self {
        Self { typical: Some(typical), ..self }
    }

    /// What forms are held near to, if they are.
    #[cfg(test)]
    pub fn typical(&self) -> Option<&TypicalLobes> {
        self.typical.as_ref()
    }

    /// The forms of parameters.
    pub fn forms(&self, parameters: &[f64]) -> Vec<[f64; FORM]> {
        self.lobes_of(parameters).map(|(_, form)| [form[0], form[1], form[2], form[3]]).collect()
    }

    /// Parameters from which lobes of these weights and exponents start, for the mean of the observed values.
    fn start(&self, brightness: &[f64], forms: &[([f64; 3], f64)]) -> Vec<f64> {
        let mut parameters: Vec<f64> = brightness.iter().map(|b| 0.6 * b).collect();
        for (weights, exponent) in forms.iter().take(self.lobes) {
            let length = weights.iter().map(|w| w * w).sum::<f64>().sqrt();
            let scale = self.multiplied.square_length().sqrt() / length;
            parameters.extend(brightness.iter().map(|b| 0.3 * b));
            parameters.extend(weights.iter().map(|w| w * scale));
            parameters.push(exponent.ln());
        }
        parameters
    }

    /// What the weights multiply where the observed values over the cosine are brightest.
    fn brightest(&self, observed: &[f32]) -> [f64; 3] {
        let value = |i: usize| {
            let sum: f32 = observed[i * self.channels..][..self.channels].iter().sum();
            f64::from(sum).powf(2.2) / self.places[i].1.max(0.1)
        };
        let best = (1..self.places.len()).fold(0, |best, i| if value(i) > value(best) { i } else { best });
        self.places[best].0
    }

    /// The brightest peak of a lobe in each channel, of a texel of these encoded values.
    fn brightest_peaks(&self, observed: &[f32]) -> Vec<f64> {
        let peak = |channel: usize| match self.multiplied {
            Multiplied::Products => BRIGHTEST_PEAK,
            Multiplied::Light => BRIGHTEST_OF_TEXEL * self.brightest_value(observed, channel),
        };
        (0..self.channels).map(peak).collect()
    }

    /// The brightest linear value over the cosine of the light in a channel of the encoded values of a texel.
    fn brightest_value(&self, observed: &[f32], channel: usize) -> f64 {
        let seen = observed.iter().skip(channel).step_by(self.channels);
        let value = |(y, (_, cosine)): (&f32, &([f64; 3], f64))| {
            let behind = if *y >= 1.0 { BEHIND_WHITE } else { 1.0 };
            behind * f64::from(Space::Srgb.to_linear(*y)) / cosine.max(LOWEST_COSINE)
        };
        seen.zip(&self.places).map(value).fold(0.0, f64::max)
    }

    /// The lobes of parameters: colour and form of each.
    fn lobes_of<'a>(&self, parameters: &'a [f64]) -> impl Iterator<Item = (&'a [f64], &'a [f64])> {
        let channels = self.channels;
        parameters[channels..].chunks_exact(channels + FORM).map(move |lobe| lobe.split_at(channels))
    }
}

impl TexelReflectance for LobeModel {
    fn channels(&self) -> usize {
        self.channels
    }

    fn bounds(&self) -> &[[f64; 2]] {
        &self.bounds
    }

    fn bounds_of_texel(&self, observed: &[f32]) -> Vec<[f64; 2]> {
        let (mut bounds, peaks) = (self.bounds.clone(), self.brightest_peaks(observed));
        for lobe in bounds[self.channels..].chunks_exact_mut(self.channels + FORM) {
            lobe.iter_mut().zip(&peaks).for_each(|(bound, peak)| bound[1] = bound[1].min(*peak));
        }
        bounds
    }

    fn values(&self, parameters: &[f64], i: usize, out: &mut [f64]) {
        let (place, cosine) = self.places[i];
        out.copy_from_slice(&parameters[..self.channels]);
        for (color, form) in self.lobes_of(parameters) {
            let sum = form[0] * place[0] + form[1] * place[1] + form[2] * place[2];
            if sum > 0.0 {
                let power = (form[3].exp() * sum.ln()).exp();
                out.iter_mut().zip(color).for_each(|(o, s)| *o += s * power);
            }
        }
        out.iter_mut().for_each(|o| *o *= cosine);
    }

    fn derivatives(&self, parameters: &[f64], i: usize, out: &mut [f64], derivatives: &mut [f64]) {
        let (place, cosine) = self.places[i];
        let (channels, n) = (self.channels, parameters.len());
        out.copy_from_slice(&parameters[..channels]);
        derivatives.fill(0.0);
        (0..channels).for_each(|c| derivatives[c * n + c] = cosine);
        for (k, (color, form)) in self.lobes_of(parameters).enumerate() {
            let sum = form[0] * place[0] + form[1] * place[1] + form[2] * place[2];
            if sum <= 0.0 {
                continue;
            }
            let (exponent, logarithm) = (form[3].exp(), sum.ln());
            let power = (exponent * logarithm).exp();
            let first = channels + k * (channels + FORM);
            for (c, s) in color.iter().enumerate() {
                out[c] += s * power;
                let row = &mut derivatives[c * n..][..n];
                row[first + c] = cosine * power;
                let by_sum = cosine * s * exponent * power / sum;
                (0..3).for_each(|axis| row[first + channels + axis] = by_sum * place[axis]);
                row[first + channels + 3] = cosine * s * power * logarithm * exponent;
            }
        }
        out.iter_mut().for_each(|o| *o *= cosine);
    }

    fn condition(&self, parameters: &[f64], mut equations: Option<&mut NormalEquations>) -> f64 {
        let mut squares = 0.0;
        for (k, (_, form)) in self.lobes_of(parameters).enumerate() {
            let length: f64 = form[..3].iter().map(|w| w * w).sum();
            let residual = CONDITION * (length - self.multiplied.square_length());
            squares += residual * residual;
            if let Some(equations) = &mut equations {
                let mut row = [0.0; super::encoded::MOST_PARAMETERS];
                let first = self.channels + k * (self.channels + FORM) + self.channels;
                (0..3).for_each(|axis| row[first + axis] = 2.0 * CONDITION * form[axis]);
                equations.add(residual, &row[..parameters.len()]);
            }
            let Some(TypicalLobes { forms, weights }) = &self.typical else { continue };
            for (j, weight) in weights.iter().enumerate() {
                let residual = weight * (form[j] - forms[k][j]);
                squares += residual * residual;
                if let Some(equations) = &mut equations {
                    let mut row = [0.0; super::encoded::MOST_PARAMETERS];
                    row[self.channels + k * (self.channels + FORM) + self.channels + j] = *weight;
                    equations.add(residual, &row[..parameters.len()]);
                }
            }
        }
        squares.sqrt()
    }

    fn starts(&self, observed: &[f32], brightness: &[f64]) -> Vec<Vec<f64>> {
        let up = [0.0, 0.0, 1.0];
        let forms = match self.multiplied {
            Multiplied::Products => {
                let (mirror, back) = ([-1.0, -1.0, 1.0], [1.0, 1.0, 1.0]);
                vec![
                    [(mirror, 5.0), (back, 5.0), (up, 1.0)],
                    [(up, 1.5), (mirror, 12.0), (back, 5.0)],
                    [(mirror, 30.0), (mirror, 2.0), (up, 1.0)],
                    [(back, 4.0), (up, 4.0), (mirror, 10.0)],
                ]
            }
            Multiplied::Light => {
                let top = self.brightest(observed);
                vec![
                    [(top, 2.0), (up, 1.0), (top, 1.0)],
                    [(top, 12.0), (top, 2.0), (up, 1.0)],
                    [(up, 1.0), (top, 6.0), (top, 30.0)],
                ]
            }
        };
        forms.iter().map(|forms| self.start(brightness, forms)).collect()
    }

    fn start_of_texel(&self, mean: &[f64], ratios: &[f64], _: &[f32]) -> Vec<f64> {
        let place =
            |k: usize| if k < self.channels { k } else { (k - self.channels) % (self.channels + FORM) };
        let scaled = |(k, p): (usize, &f64)| p * ratios.get(place(k)).unwrap_or(&1.0);
        mean.iter().enumerate().map(scaled).collect()
    }

    /// The largest weight is 1, or the length of those of a view, and colours are those of lobes at their brightest.
    fn numbers(&self, parameters: &[f64], observed: &[f32]) -> Vec<f32> {
        let mut numbers: Vec<f64> = parameters.to_vec();
        let peaks = self.brightest_peaks(observed);
        for lobe in numbers[self.channels..].chunks_exact_mut(self.channels + FORM) {
            let (color, form) = lobe.split_at_mut(self.channels);
            form[3] = form[3].exp();
            let largest = self.multiplied.largest(&form[..3]);
            if largest > 0.0 {
                let brightest = largest.powf(form[3]);
                form[..3].iter_mut().for_each(|w| *w /= largest);
                let peaks = color.iter_mut().zip(&peaks);
                peaks.for_each(|(s, peak)| *s = (*s * brightest).min(*peak));
            }
        }
        numbers.into_iter().map(|v| v as f32).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::direction::Direction;
    use crate::field::{ParametricField, TexelModel};
    use crate::planes::Planes;
    use crate::size::Size;

    #[test]
    fn no_lobe_is_brighter_between_measured_pairs_than_light_is() {
        let model = LobeModel::of_pairs(1, 1, &pairs());
        let numbers = model.numbers(&[0.2, 8.0, -2.5, 1.0, 0.5, 128.0f64.ln()], &[0.5; 40]);
        assert_eq!(numbers[1], BRIGHTEST_PEAK as f32, "8 times 2.5 to the power of 128");
        assert_eq!(numbers[2..5], [-1.0, 0.4, 0.2]);
        let usual = model.numbers(&[0.2, 0.5, -1.0, 1.0, 0.9, 5.0f64.ln()], &[0.5; 40]);
        assert!((usual[1] - 0.5).abs() < 1e-6, "{usual:?}");
    }

    #[test]
    fn a_lobe_of_one_view_is_hardly_brighter_than_its_texel() {
        let pairs = pairs();
        let model = LobeModel::of_lights(3, 1, &pairs);
        // Grey, but for one white value of the third channel.
        let mut observed = vec![0.5; 120];
        let at = |i: usize| f64::from(Space::Srgb.to_linear(0.5)) / pairs[i].light.z();
        let brightest = (0..40).map(at).fold(0.0, f64::max);
        observed[5] = 1.0;
        let bounds = model.bounds_of_texel(&observed);
        assert!((bounds[3][1] - 1.5 * brightest).abs() < 1e-9 && bounds[5][1] > 5.9, "{bounds:?}");
        assert_eq!(bounds[0], model.bounds()[0]);
        let parameters = [0.1, 0.1, 0.1, 3.0, 0.3, 3.0, 0.0, 0.2, 1.4, 50.0f64.ln()];
        let numbers = model.numbers(&parameters, &observed);
        assert!((f64::from(numbers[3]) - 1.5 * brightest).abs() < 1e-6, "{numbers:?}");
        assert!((f64::from(numbers[4]) - 1.5 * brightest).abs() < 1e-6 && numbers[5] > 5.9, "{numbers:?}");
    }

    fn pairs() -> Vec<Directions> {
        let direction = |i: usize| Direction::from_angles(0.12 * i as f64, 2.4 * i as f64);
        (0..40).map(|i| Directions { light: direction(i % 9), view: direction(i % 7 + 1) }).collect()
    }

    #[test]
    fn values_are_those_of_the_field_of_the_numbers() {
        let (pairs, parameters) = (pairs(), [0.2, 0.3, 0.5, -0.9, -1.1, 0.8, 1.2, 0.4, 0.7, 0.7, 0.9, 0.4]);
        let model = LobeModel::of_pairs(1, 2, &pairs);
        let parameters = &parameters[..11];
        let numbers = model.numbers(parameters, &[0.5; 40]);
        let planes = Planes::from_vec(Size::new(1, 1), numbers.len(), numbers).unwrap();
        let field = ParametricField::new(TexelModel::Lafortune { lobes: 2 }, 1, planes).unwrap();
        let mut out = [0.0];
        for (i, pair) in pairs.iter().enumerate() {
            model.values(parameters, i, &mut out);
            let shown = f64::from(field.evaluate(0, 0, *pair)[0]);
            assert!((out[0] - shown).abs() < 1e-5 * (1.0 + shown), "{i}: {} {shown}", out[0]);
        }
    }

    #[test]
    fn derivatives_are_those_of_small_steps() {
        let pairs = pairs();
        for (model, n) in [(LobeModel::of_pairs(3, 2, &pairs), 17), (LobeModel::of_lights(3, 1, &pairs), 10)]
        {
            let mut parameters: Vec<f64> = (0..n).map(|k| 0.2 + 0.07 * k as f64).collect();
            assert_eq!(model.bounds().len(), n);
            for i in 0..pairs.len() {
                let (mut out, mut derivatives) = ([0.0; 3], vec![0.0; 3 * n]);
                model.derivatives(&parameters, i, &mut out, &mut derivatives);
                for k in 0..n {
                    let (own, step) = (parameters[k], 1e-6);
                    let mut moved = [[0.0; 3]; 2];
                    parameters[k] = own + step;
                    model.values(&parameters, i, &mut moved[1]);
                    parameters[k] = own - step;
                    model.values(&parameters, i, &mut moved[0]);
                    parameters[k] = own;
                    for c in 0..3 {
                        let numeric = (moved[1][c] - moved[0][c]) / (2.0 * step);
                        let found = derivatives[c * n + k];
                        assert!((numeric - found).abs() < 1e-5 * (1.0 + found.abs()), "{i} {k} {c}");
                    }
                }
            }
        }
    }
}
