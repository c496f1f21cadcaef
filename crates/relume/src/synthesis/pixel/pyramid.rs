//! Exemplars at decreasing resolution.

use crate::error::{Error, Result};
use crate::job::Job;
use crate::size::Size;
use crate::synthesis::guidance::Guided;
use crate::synthesis::positions::Positions;
use crate::synthesis::quantise::{Exemplar, HalvingWindow, IndexTexels, Quantised};

/// One resolution of the exemplars.
#[derive(Debug)]
pub struct ExemplarLevel {
    /// Their codes.
    pub exemplars: Quantised,
    /// Their excluded texels.
    pub masks: Vec<Option<Vec<bool>>>,
}

impl ExemplarLevel {
    /// The possible positions of windows at this resolution.
    pub fn positions(&self, window: usize) -> Result<Positions> {
        let sizes = self.exemplars.texels().iter().map(|texels| texels.size());
        let areas: Vec<_> = sizes.zip(self.masks.iter().map(Option::as_deref)).collect();
        Positions::of_areas(&areas, window, "window")
    }

    /// The memory of codes and masks.
    pub fn bytes(&self) -> u64 {
        self.exemplars.bytes() + self.masks.iter().flatten().map(|mask| mask.len() as u64).sum::<u64>()
    }

    fn halved(&self) -> Self {
        let sizes = self.exemplars.texels().iter().map(|texels| texels.size());
        let masks = self.masks.iter().zip(sizes);
        let masks = masks.map(|(mask, size)| mask.as_ref().map(|mask| halved_mask(mask, size))).collect();
        Self { exemplars: self.exemplars.halved(&self.masks), masks }
    }
}

/// `levels` resolutions of exemplars, the finest first.
///
/// # Errors
/// When the exemplars cannot be quantised, a window does not fit the coarsest of them, or the
/// limits are exceeded.
pub fn pyramid(
    exemplars: &[Exemplar<'_>],
    levels: usize,
    window: usize,
    job: &Job,
) -> Result<Vec<ExemplarLevel>> {
    Ok(guided_pyramid(&Guided::new(exemplars, None, Size::new(0, 0), job)?, levels, window, job)?.0)
}

/// Refuses exemplars too small for a window at the coarsest level.
fn check_levels(exemplars: &[Exemplar<'_>], levels: usize, window: usize) -> Result<()> {
    for (number, exemplar) in exemplars.iter().enumerate() {
        let size = exemplar.index.size();
        let coarsest = (1..levels).fold(size, |size, _| halved_size(size));
        if coarsest.width.min(coarsest.height) < window {
            return Err(Error::usage(format!(
                "exemplar {} of {size} texels is {coarsest} at the coarsest of {levels} levels, where windows \
                 of {window} do not fit: choose fewer levels or a smaller window",
                number + 1
            )));
        }
    }
    Ok(())
}

/// The resolutions of exemplars with guides, and of the guide of the output.
///
/// # Errors
/// As [`pyramid`].
pub(in crate::synthesis) fn guided_pyramid(
    guided: &Guided<'_>,
    levels: usize,
    window: usize,
    job: &Job,
) -> Result<(Vec<ExemplarLevel>, Vec<Option<IndexTexels>>)> {
    check_levels(guided.exemplars(), levels, window)?;
    let (exemplars, target) = guided.interleaved(job)?;
    let masks = guided.exemplars().iter().map(|exemplar| exemplar.excluded.map(<[bool]>::to_vec)).collect();
    let (mut pyramid, mut targets) = (vec![ExemplarLevel { exemplars, masks }], vec![target]);
    for level in 1..levels {
        let (exemplars, target) = (pyramid[level - 1].halved(), &targets[level - 1]);
        let target = target.as_ref().map(|target| target.halved(None));
        pyramid.push(exemplars);
        targets.push(target);
    }
    Ok((pyramid, targets))
}

/// The size of the next coarser level: half, rounded up.
pub fn halved_size(size: Size) -> Size {
    Size::new(size.width.div_ceil(2), size.height.div_ceil(2))
}

/// A coarser texel is excluded if more than half of what it averages is, by weight. Marks much smaller than a
/// coarser texel thus vanish, so that a few of them leave places for windows at every level.
fn halved_mask(mask: &[bool], size: Size) -> Vec<bool> {
    let coarse = halved_size(size);
    let whole: i32 = HalvingWindow::WEIGHTS.iter().sum();
    let excluded = |(x, y)| {
        let used: i32 = HalvingWindow::new(size, x, y).weights(mask).iter().sum();
        2 * used < whole
    };
    let texels = (0..coarse.height).flat_map(|y| (0..coarse.width).map(move |x| (x, y)));
    texels.map(excluded).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::numeric::random::{Purpose, Stream};
    use crate::planes::Planes;

    #[test]
    fn coarser_texels_are_rounded_means_of_texels_that_are_not_excluded() {
        for (width, height, planes) in [(8, 6, 3), (7, 5, 2), (1, 9, 1)] {
            let size = Size::new(width, height);
            let mut stream = Stream::new(4, Purpose::Sample, [(width * height) as u64]);
            let data = (0..size.texels() * planes).map(|_| stream.below(256) as f32).collect();
            let index = Planes::from_vec(size, planes, data).unwrap();
            let mask: Vec<bool> = (0..size.texels()).map(|_| stream.below(3) == 0).collect();
            let exemplars = [Exemplar { index: &index, excluded: Some(&mask) }];
            let levels = pyramid(&exemplars, 2, 1, &Job::default()).unwrap();
            let [fine, coarse] = [0, 1].map(|level| &levels[level].exemplars.texels()[0]);
            assert_eq!(coarse.size(), halved_size(size));
            for (x, y) in
                (0..coarse.size().height).flat_map(|y| (0..coarse.size().width).map(move |x| (x, y)))
            {
                let kernel = [(-1, 1), (0, 3), (1, 3), (2, 1)];
                let at = |center: usize, by: isize, length: usize| {
                    (2 * center as isize + by).clamp(0, length as isize - 1) as usize
                };
                let (mut sums, mut used) = (vec![0; planes], 0);
                for ((dx, a), (dy, b)) in kernel.iter().flat_map(|a| kernel.iter().map(move |b| (a, b))) {
                    let (fx, fy) = (at(x, *dx, width), at(y, *dy, height));
                    if !mask[size.index(fx, fy)] {
                        let codes = fine.run(fx, fy, 1);
                        sums.iter_mut().zip(codes).for_each(|(sum, &code)| *sum += a * b * i32::from(code));
                        used += a * b;
                    }
                }
                let mean = |sum: &i32| (f64::from(*sum) / f64::from(used) + 0.5).floor() as i16;
                if used > 0 {
                    assert_eq!(coarse.run(x, y, 1), sums.iter().map(mean).collect::<Vec<_>>());
                }
                let excluded = levels[1].masks[0].as_ref().unwrap()[coarse.size().index(x, y)];
                assert_eq!(excluded, used < 32);
            }
        }
    }

    /// Twenty marks of a few texels, a hundredth of an exemplar, once left no place for windows at the coarser
    /// levels.
    #[test]
    fn small_marks_leave_places_at_every_level() {
        let size = Size::new(128, 128);
        let index = Planes::zeros(size, 1);
        let is_marked = |t: usize| t % 128 % 29 < 3 && t / 128 % 31 < 3;
        let mask: Vec<bool> = (0..size.texels()).map(is_marked).collect();
        let exemplars = [Exemplar { index: &index, excluded: Some(&mask) }];
        for level in pyramid(&exemplars, 4, 9, &Job::default()).unwrap().iter().skip(2) {
            assert!(level.positions(9).unwrap().count() > 0);
        }
    }

    #[test]
    fn windows_that_do_not_fit_the_coarsest_level_are_refused() {
        let index = Planes::zeros(Size::new(40, 37), 1);
        let exemplars = [Exemplar { index: &index, excluded: None }];
        let error = pyramid(&exemplars, 4, 7, &Job::default()).unwrap_err();
        assert!(error.message().contains("5 x 5") && error.message().contains("fewer levels"), "{error}");
        assert_eq!(pyramid(&exemplars, 4, 5, &Job::default()).unwrap().len(), 4);
    }
}
