//! Values of a sample of the texels under all photographs.

use crate::fit::levels::SampleLevels;
use crate::raster::Raster;

/// At most this many texels, on a regular grid, decide what is typical of all.
pub(super) const SAMPLE_TEXELS: usize = 49;

/// Whether nothing is to be seen.
pub(super) fn is_black(photograph: &Raster) -> bool {
    (0..photograph.samples().len()).all(|k| photograph.samples().value(k) <= 0.0)
}

/// The mean of some texels, value by value.
pub(super) fn mean_of_texels(texels: &[Vec<f32>]) -> Vec<f32> {
    let length = texels.first().map_or(0, Vec::len);
    let mean = |k: usize| texels.iter().map(|texel| f64::from(texel[k])).sum::<f64>() / texels.len() as f64;
    (0..length).map(|k| mean(k) as f32).collect()
}

/// The encoded values of each texel of small photographs, all channels of a photograph adjacent.
pub(super) fn texel_values(photographs: &[&Raster], levels: &SampleLevels) -> Vec<Vec<f32>> {
    let texels = photographs.first().map_or(0, |photograph| photograph.size().texels());
    let mut values = vec![Vec::with_capacity(3 * photographs.len()); texels];
    let mut row = vec![0.0; texels];
    for (photograph, channel) in photographs.iter().flat_map(|p| (0..p.channels()).map(move |c| (p, c))) {
        levels.channel(photograph, channel, 0, &mut row);
        values.iter_mut().zip(&row).for_each(|(texel, value)| texel.push(*value));
    }
    values
}
