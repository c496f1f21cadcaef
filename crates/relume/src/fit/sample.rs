//! The texels at which a fit is compared with its photographs: a regular grid, or every so-manieth within a mask.

use crate::error::{Error, Result};
use crate::planes::Planes;
use crate::raster::{Raster, Samples};
use crate::size::Size;

/// Grids of at most this many texels are kept from each streamed photograph; for larger ones the photographs
/// are read again.
pub(super) const KEPT_TEXELS: usize = 65_536;

/// Every `step`-th texel of every `step`-th row, centred in the picture.
#[derive(Debug, Clone)]
pub(super) struct Grid {
    full: Size,
    step: usize,
    first: (usize, usize),
    size: Size,
    /// The texels of a mask instead, and how many are inside it.
    chosen: Option<(Vec<usize>, usize)>,
}

impl Grid {
    /// The finest grid of at most `most` texels; all texels of a smaller picture.
    pub fn new(full: Size, most: usize) -> Self {
        let mut step = 1;
        while full.width.div_ceil(step) * full.height.div_ceil(step) > most.max(1) {
            step += 1;
        }
        let size = Size::new(full.width.div_ceil(step), full.height.div_ceil(step));
        let margin = |side: usize, count: usize| (side - 1 - (count - 1) * step) / 2;
        let first = (margin(full.width, size.width), margin(full.height, size.height));
        Self { full, step, first, size, chosen: None }
    }

    /// As [`Grid::new`], of the texels inside a mask if there is one.
    ///
    /// # Errors
    /// A mask of another size, and one without a texel.
    pub fn within(full: Size, most: usize, mask: Option<&[bool]>) -> Result<Self> {
        let Some(mask) = mask else { return Ok(Self::new(full, most)) };
        let inside = mask.iter().filter(|inside| **inside).count();
        if mask.len() != full.texels() || inside == 0 {
            return Err(Error::invalid(format!(
                "the mask has {} texels, {inside} of them inside, and the photographs {full}: expected as many, and some \
                 inside",
                mask.len()
            )));
        }
        let every = inside.div_ceil(most.max(1));
        let texels = mask.iter().enumerate().filter(|(_, inside)| **inside).map(|(i, _)| i);
        let chosen: Vec<usize> = texels.step_by(every).collect();
        let size = Size::new(chosen.len(), 1);
        Ok(Self { full, step: 1, first: (0, 0), size, chosen: Some((chosen, inside)) })
    }

    /// The number of texels of the grid.
    pub fn texels(&self) -> usize {
        self.size.texels()
    }

    /// The number of texels of the picture.
    pub fn full_texels(&self) -> usize {
        self.full.texels()
    }

    /// The number of texels of the picture inside the mask; all without one.
    pub fn inside_texels(&self) -> usize {
        self.chosen.as_ref().map_or(self.full.texels(), |(_, inside)| *inside)
    }

    /// The bytes of the list of texels.
    pub fn bytes(&self) -> u64 {
        self.chosen.as_ref().map_or(0, |(chosen, _)| size_of_val(chosen.as_slice()) as u64)
    }

    /// Whether it has few enough texels to keep them from every photograph.
    pub fn is_kept(&self) -> bool {
        self.texels() <= KEPT_TEXELS
    }

    /// The texels of the grid in planes.
    pub fn planes(&self, planes: &Planes) -> Planes {
        let data = planes.iter().flat_map(|plane| self.indices().map(|i| plane[i])).collect();
        Planes::from_vec(self.size, planes.count(), data).expect("one sample a texel of every plane")
    }

    /// The texels of the grid in a photograph, in its bit depth.
    pub fn raster(&self, raster: &Raster) -> Raster {
        let samples = match raster.samples() {
            Samples::U8(s) => Samples::U8(self.pick(s, raster.channels())),
            Samples::U16(s) => Samples::U16(self.pick(s, raster.channels())),
            Samples::F32(s) => Samples::F32(self.pick(s, raster.channels())),
        };
        Raster::new(self.size, raster.channels(), samples).expect("as many samples as the grid has")
    }

    /// The column and row of each texel of the grid in the picture.
    pub fn places(&self) -> impl Iterator<Item = (usize, usize)> {
        self.indices().map(|index| (index % self.full.width, index / self.full.width))
    }

    fn indices(&self) -> impl Iterator<Item = usize> {
        let (x0, y0) = self.first;
        let place = move |k: usize| match &self.chosen {
            Some((chosen, _)) => chosen[k],
            None => {
                let (i, j) = (k % self.size.width, k / self.size.width);
                self.full.index(x0 + i * self.step, y0 + j * self.step)
            }
        };
        (0..self.size.texels()).map(place)
    }

    fn pick<T: Copy>(&self, samples: &[T], channels: usize) -> Vec<T> {
        let mut picked = Vec::with_capacity(self.texels() * channels);
        self.indices().for_each(|i| picked.extend_from_slice(&samples[i * channels..][..channels]));
        picked
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn grids_lie_inside_and_hold_no_more_than_asked() {
        for (w, h) in [(1, 1), (7, 5), (1024, 1), (1, 333), (64, 64), (100, 3)] {
            for most in [1, 2, 10, 100, 5000] {
                let grid = Grid::new(Size::new(w, h), most);
                let indices: Vec<usize> = grid.indices().collect();
                assert!(indices.len() == grid.texels() && (1..=most).contains(&indices.len()));
                assert!(indices.is_sorted_by(|a, b| a < b) && indices.iter().all(|&i| i < w * h));
                assert!(w * h > most || indices.len() == w * h);
            }
        }
    }

    #[test]
    fn within_a_mask_there_are_only_its_texels() {
        let size = Size::new(30, 20);
        let mask: Vec<bool> = (0..600).map(|i| i % 30 < 10).collect();
        for most in [1, 7, 100, 199, 200, 5000] {
            let grid = Grid::within(size, most, Some(&mask)).unwrap();
            let indices: Vec<usize> = grid.indices().collect();
            assert!(indices.len() == grid.texels() && (1..=most).contains(&indices.len()));
            assert!(indices.is_sorted_by(|a, b| a < b) && indices.iter().all(|&i| mask[i]));
            assert!(most < 200 || indices.len() == 200);
            assert_eq!((grid.inside_texels(), grid.full_texels()), (200, 600));
        }
        assert!(
            Grid::within(size, 9, Some(&mask[1..])).is_err()
                && Grid::within(size, 9, Some(&[false; 600])).is_err()
        );
    }

    #[test]
    fn planes_and_photographs_are_sampled_at_the_same_texels() {
        let size = Size::new(11, 7);
        let grid = Grid::new(size, 9);
        let raster = Raster::new(size, 1, Samples::U8((0..77).collect())).unwrap();
        let planes = Planes::from_vec(size, 1, (0..77u8).map(f32::from).collect()).unwrap();
        let thinned = grid.raster(&raster);
        let Samples::U8(codes) = thinned.samples() else { panic!("the depth is kept") };
        let values: Vec<f32> = codes.iter().copied().map(f32::from).collect();
        assert_eq!(values, grid.planes(&planes).as_slice());
        assert_eq!(codes.len(), 6);
    }
}
