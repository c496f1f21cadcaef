//! The opacity of pictures as files have it: an alpha channel beside the colours.

use super::meaning::Meaning;
use crate::job::Job;
use crate::planes::Planes;
use crate::raster::{Raster, Samples};
use crate::size::Size;

/// The remark on an opacity that a reader's caller has no use for.
pub(super) const OPACITY_UNUSED: &str =
    "its opacity (alpha) is not used here: transparent texels count with the values stored under them";

/// Splits texels of `channels` samples and an alpha into their samples and the alphas.
pub(super) fn split<T: Copy>(texels: &[T], channels: usize) -> (Vec<T>, Vec<T>) {
    let texels = texels.chunks_exact(channels + 1);
    let alphas = texels.clone().map(|texel| texel[channels]).collect();
    (texels.flat_map(|texel| &texel[..channels]).copied().collect(), alphas)
}

/// A picture without an opacity that says nothing of its texels: copies keep any alpha, which may be a channel of data.
pub(super) fn kept(raster: Raster, meaning: Meaning, job: &Job) -> Raster {
    match raster.opacity() {
        Some(alphas) if meaning != Meaning::Copies && !is_useful(alphas, job) => raster.without_opacity(),
        _ => raster,
    }
}

/// The alphas of texels as a plane from 0 to 1, where [`is_useful`].
pub(super) fn plane(size: Size, alphas: Samples, job: &Job) -> Option<Planes> {
    if !is_useful(&alphas, job) {
        return None;
    }
    let values = (0..alphas.len()).map(|i| alphas.value(i).clamp(0.0, 1.0)).collect();
    Planes::from_vec(size, 1, values).ok()
}

/// Whether alphas differ between texels. If all are opaque, there is no opacity; another constant says nothing
/// of the texels, so it is left out with a remark.
fn is_useful(alphas: &Samples, job: &Job) -> bool {
    let first = alphas.value(0);
    if (0..alphas.len()).any(|texel| alphas.value(texel) != first) {
        return true;
    }
    if first != 1.0 {
        job.remark(format!("all texels have the same opacity, {first:.3}: it is not used"));
    }
    false
}

/// Divides colours that were multiplied by their opacity (associated alpha); where the opacity is 0 they stay
/// as they are.
pub(super) fn divide(samples: &mut Samples, alphas: &Samples) {
    let channels = samples.len() / alphas.len().max(1);
    let opacity = |i: usize| alphas.value(i / channels);
    match samples {
        Samples::U8(s) => divide_codes(s, opacity, |code| (f32::from(code), 255.0), |value| value as u8),
        Samples::U16(s) => divide_codes(s, opacity, |code| (f32::from(code), 65535.0), |value| value as u16),
        Samples::F32(s) => s.chunks_exact_mut(channels).enumerate().for_each(|(texel, colors)| {
            let opacity = alphas.value(texel);
            colors.iter_mut().filter(|_| opacity > 0.0).for_each(|v| *v /= opacity);
        }),
    }
}

/// As [`divide`], one plane of colours.
pub(super) fn divide_plane(plane: &mut [f32], alphas: &Samples) {
    let values = plane.iter_mut().enumerate().map(|(texel, value)| (alphas.value(texel), value));
    values.filter(|(opacity, _)| *opacity > 0.0).for_each(|(opacity, value)| *value /= opacity);
}

fn divide_codes<T: Copy>(
    codes: &mut [T],
    opacity: impl Fn(usize) -> f32,
    value: impl Fn(T) -> (f32, f32),
    code: impl Fn(f32) -> T,
) {
    for (i, sample) in codes.iter_mut().enumerate().filter(|(i, _)| opacity(*i) > 0.0) {
        let (stored, most) = value(*sample);
        *sample = code((stored / opacity(i)).round().min(most));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn associated_colours_are_divided_and_transparent_ones_stay() {
        let alphas = Samples::U8(vec![255, 128, 0, 1]);
        let mut codes = Samples::U8(vec![200, 100, 9, 2]);
        divide(&mut codes, &alphas);
        assert_eq!(codes, Samples::U8(vec![200, 199, 9, 255]));
        let mut floats = Samples::F32(vec![0.5, 1.0, 3.0, 4.0]);
        divide(&mut floats, &Samples::F32(vec![0.5, 0.0]));
        assert_eq!(floats, Samples::F32(vec![1.0, 2.0, 3.0, 4.0]));
    }

    #[test]
    fn an_opacity_that_does_not_vary_is_none_of_colours_and_data() {
        let raster = || Raster::new(Size::new(2, 1), 1, Samples::U8(vec![1, 2])).unwrap();
        let with = |alphas: [u8; 2]| raster().with_opacity(Samples::U8(alphas.to_vec())).unwrap();
        for (alphas, remarks) in [([255, 255], 0), ([128, 128], 1), ([0, 0], 1)] {
            let job = Job::default();
            let found = kept(with(alphas), Meaning::Colors, &job);
            assert_eq!((found, job.remarks().len()), (raster(), remarks), "{alphas:?}");
            assert_eq!(kept(with(alphas), Meaning::Copies, &Job::default()), with(alphas));
        }
        let job = Job::default();
        let varying = kept(with([0, 255]), Meaning::Data, &job);
        assert!(varying.opacity().is_some() && job.remarks().is_empty());
    }
}
