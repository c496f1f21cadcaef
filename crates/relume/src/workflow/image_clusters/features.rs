//! What photographs are grouped by: the distributions of their CIE L*, a* and b*, in a few principal components.

use crate::lab;
use crate::numeric::{Matrix, eigen};
use crate::raster::{Raster, Samples};
use crate::space::Space;

/// Classes of a distribution.
const CLASSES: usize = 32;

/// The range of L*, and that of a* and b*.
const LIGHTNESS: [f64; 2] = [0.0, 100.0];
const OPPONENT: [f64; 2] = [-60.0, 60.0];

/// The share of the variance that the components keep, and how many they are at most.
const KEPT: f64 = 0.98;
const MOST_COMPONENTS: usize = 16;

/// The texels of a photograph at most that are looked at.
const TEXELS: usize = 1024;

/// What is kept of a photograph.
pub(super) struct PhotographFeatures {
    /// The cumulative histograms of L*, a* and b*.
    pub distribution: Vec<f64>,
    /// The mean of its encoded values.
    pub brightness: f64,
    /// Encoded values of texels on a grid, as codes of 8 bits.
    pub texels: Vec<u8>,
    /// Whether these differ: a random field needs a picture that varies.
    pub varies: bool,
}

impl PhotographFeatures {
    pub fn of(photograph: &Raster) -> Self {
        let (channels, count) = (photograph.channels(), photograph.size().texels());
        let step = count.div_ceil(TEXELS).max(1);
        let samples = photograph.samples();
        let encoded = |i: usize| match samples {
            Samples::F32(_) => Space::Linear.to_srgb(samples.value(i)).clamp(0.0, 1.0),
            Samples::U8(_) | Samples::U16(_) => samples.value(i),
        };
        let chosen = (0..count).step_by(step);
        let values: Vec<f32> =
            chosen.flat_map(|t| (0..channels).map(move |c| t * channels + c)).map(encoded).collect();
        let mut histograms = vec![0.0; 3 * CLASSES];
        for texel in values.chunks_exact(channels) {
            let linear =
                std::array::from_fn(|c| f64::from(Space::Srgb.to_linear(texel[c.min(channels - 1)])));
            let ranges = [LIGHTNESS, OPPONENT, OPPONENT];
            for ((k, value), [low, high]) in lab::from_linear(linear).into_iter().enumerate().zip(ranges) {
                let place = ((value - low) / (high - low) * CLASSES as f64).clamp(0.0, CLASSES as f64 - 1.0);
                histograms[k * CLASSES + place as usize] += 1.0;
            }
        }
        let texels = (values.len() / channels) as f64;
        for histogram in histograms.chunks_exact_mut(CLASSES) {
            let mut sum = 0.0;
            for class in histogram {
                sum += *class / texels;
                *class = sum;
            }
        }
        let brightness = values.iter().map(|v| f64::from(*v)).sum::<f64>() / values.len() as f64;
        let texels: Vec<u8> = values.iter().map(|v| (255.0 * v.clamp(0.0, 1.0)).round() as u8).collect();
        let varies = texels.chunks_exact(channels).any(|texel| *texel != texels[..channels]);
        Self { distribution: histograms, brightness, texels, varies }
    }

    /// The bytes of all that is kept of a photograph.
    pub fn bytes(channels: usize) -> u64 {
        (8 * 3 * CLASSES + TEXELS * channels) as u64
    }
}

/// The coordinates of distributions along their principal axes, and the number of these.
pub(super) fn components(photographs: &[PhotographFeatures]) -> (Vec<f64>, usize) {
    let (n, count) = (3 * CLASSES, photographs.len() as f64);
    let mut mean = vec![0.0; n];
    for photograph in photographs {
        mean.iter_mut().zip(&photograph.distribution).for_each(|(m, v)| *m += v / count);
    }
    let from_mean = |photograph: &PhotographFeatures| -> Vec<f64> {
        photograph.distribution.iter().zip(&mean).map(|(v, m)| v - m).collect()
    };
    let mut covariance = Matrix::zeros(n, n);
    for photograph in photographs {
        let own = from_mean(photograph);
        for (j, a) in own.iter().enumerate().filter(|(_, a)| **a != 0.0) {
            covariance.row_mut(j).iter_mut().zip(&own).for_each(|(sum, b)| *sum += a * b);
        }
    }
    let (values, axes) = eigen::symmetric(&covariance);
    let total: f64 = values.iter().filter(|v| **v > 0.0).sum();
    let mut sum = 0.0;
    let needed = values.iter().take_while(|value| {
        let goes_on = sum < KEPT * total;
        sum += **value;
        goes_on
    });
    let kept = needed.count().clamp(1, MOST_COMPONENTS);
    let coordinates = |photograph: &PhotographFeatures| {
        let own = from_mean(photograph);
        (0..kept).map(|j| axes.row(j).iter().zip(&own).map(|(a, v)| a * v).sum()).collect::<Vec<f64>>()
    };
    (photographs.iter().flat_map(coordinates).collect(), kept)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::size::Size;

    fn plain(color: [u8; 3]) -> Raster {
        let samples = (0..24).flat_map(|_| color).collect();
        Raster::new(Size::new(6, 4), 3, Samples::U8(samples)).unwrap()
    }

    #[test]
    fn distributions_of_colours_are_apart_as_the_colours_are() {
        let all = [[200, 40, 40], [190, 42, 38], [40, 40, 200], [128, 128, 128]].map(plain);
        let features: Vec<PhotographFeatures> = all.iter().map(PhotographFeatures::of).collect();
        assert!((features[3].brightness - 128.0 / 255.0).abs() < 1e-6);
        assert_eq!(features[3].texels, vec![128; 72]);
        for feature in &features {
            assert!(feature.distribution.chunks_exact(CLASSES).all(|h| (h[CLASSES - 1] - 1.0).abs() < 1e-9));
        }
        let (coordinates, n) = components(&features);
        let apart = |a: usize, b: usize| -> f64 {
            (0..n).map(|j| (coordinates[a * n + j] - coordinates[b * n + j]).powi(2)).sum()
        };
        assert!(apart(0, 1) < 0.2 * apart(0, 3) && apart(0, 3) < apart(0, 2), "{coordinates:?}");
    }
}
