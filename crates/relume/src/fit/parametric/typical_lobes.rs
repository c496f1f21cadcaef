//! The forms of lobes that are typical of a texture, near which those of its texels are held.
//!
//! Lobes explain little of deep relief, and a texel has few values near the horizon; so a lobe may take any form where it explains
//! nothing, and shine between the measured pairs: single texels far brighter than those around them. Forms of the mean of
//! all texels are determined well. The weight of a deviation is that of facets ([`super::typical`]): a deviation by [`SPREAD`] counts
//! as much as what is left of all values of a texel, so nothing is held where lobes explain the texels. Photographs left out are
//! predicted better so. Lobes of single views are not held: theirs lie along the normals of the texels, and those left out are
//! predicted worse; their colours have bounds instead ([`super::lobes`]).

use super::STEPS;
use super::encoded::fit_texel;
use super::lobes::{FORM, LobeModel, TypicalLobes};
use super::texels::FromMean;
use crate::numeric::levenberg_marquardt::LevenbergMarquardt;
use crate::parallel;

/// The deviation of a weight, and of the logarithm of the exponent, that counts as much as all residuals of a texel.
const SPREAD: [f64; FORM] = [1.0, 1.0, 1.0, 2.0];

/// The model with lobes held near those of the mean; the texels of a sample say by how much.
pub(super) fn with_typical_lobes(model: LobeModel, mean: &[f32], sample: &[Vec<f32>]) -> LobeModel {
    let from = FromMean::new(&model, mean, STEPS);
    let squares = |observed: &Vec<f32>| {
        let mut parameters = from.start(observed);
        let mut minimiser = LevenbergMarquardt::new(parameters.len());
        fit_texel(&model, &mut minimiser, &mut parameters, observed, STEPS)
    };
    let squares: Vec<f64> = parallel::map(sample.iter(), squares);
    let residual = (squares.iter().sum::<f64>() / squares.len().max(1) as f64).sqrt();
    let weights = std::array::from_fn(|k| residual / SPREAD[k]);
    let forms = model.forms(from.parameters());
    model.held_near(TypicalLobes { forms, weights })
}

#[cfg(test)]
mod tests {
    use super::super::encoded::TexelReflectance;
    use super::*;
    use crate::direction::{Direction, Directions};
    use crate::numeric::random::{Purpose, Stream};

    /// Lights and views above 50 degrees, and those near the horizon that are not measured.
    fn pairs(polar: [f64; 3]) -> Vec<Directions> {
        let all: Vec<Direction> = polar
            .into_iter()
            .flat_map(|polar| (0..6).map(move |k| Direction::from_angles(polar, 1.05 * f64::from(k))))
            .collect();
        all.iter()
            .flat_map(|view| all.iter().map(|light| Directions { light: *light, view: *view }))
            .collect()
    }

    /// Encoded values of a matt surface with shadows at random places, which no lobe explains.
    fn shadowed(pairs: &[Directions], texels: usize) -> Vec<Vec<f32>> {
        let texel = |t: usize| {
            let mut stream = Stream::new(5, Purpose::Sample, [t as u64]);
            let value = |pair: &Directions| {
                let lit = if stream.unit() < 0.3 { 0.1 } else { 0.5 };
                (lit * pair.light.z()).powf(1.0 / 2.2) as f32
            };
            pairs.iter().map(value).collect()
        };
        (0..texels).map(texel).collect()
    }

    #[test]
    fn a_texel_does_not_shine_where_nothing_was_measured() {
        let (measured, beyond) = (pairs([0.2, 0.5, 0.85]), pairs([1.1, 1.25, 1.35]));
        let texels = shadowed(&measured, 40);
        let mean = super::super::sampled::mean_of_texels(&texels);
        let free = LobeModel::of_pairs(1, 2, &measured);
        let held = with_typical_lobes(free.clone(), &mean, &texels);
        let brightest = |model: &LobeModel| {
            let from = FromMean::new(model, &mean, STEPS);
            let shown = |observed: &Vec<f32>| {
                let numbers: Vec<f64> = from.fit(observed).into_iter().map(f64::from).collect();
                let lobes = LobeModel::of_pairs(1, 2, &beyond);
                let mut parameters = numbers;
                // Exponents are parameters as logarithms.
                [5, 10].into_iter().for_each(|k| parameters[k] = parameters[k].ln());
                let mut out = [0.0];
                (0..beyond.len()).fold(0.0f64, |most, i| {
                    lobes.values(&parameters, i, &mut out);
                    most.max(out[0])
                })
            };
            texels.iter().map(shown).fold(0.0, f64::max)
        };
        let (free, held) = (brightest(&free), brightest(&held));
        assert!(held < 0.5 * free && held < 1.0, "{held}, and {free} where nothing is held");
    }

    #[test]
    fn nothing_is_held_where_lobes_explain_the_texels() {
        let pairs = pairs([0.2, 0.5, 0.85]);
        let matt: Vec<f32> = pairs
            .iter()
            .map(|pair| crate::space::Space::Srgb.from_linear(0.4 * pair.light.z() as f32))
            .collect();
        let held =
            with_typical_lobes(LobeModel::of_pairs(1, 1, &pairs), &matt, &[matt.clone(), matt.clone()]);
        let weight = held.typical().map_or(f64::NAN, |typical| typical.weights[0]);
        assert!(weight < 0.02, "{weight}");
    }
}
