//! A texture at one resolution after another, without the accidents of sampling.
//!
//! A pyramid keeps every second texel of a smoothed texture. What repeats with two to three of the texels kept is sampled
//! at a few places of its period only, so the values of a coarse level change when the texture is moved by a few
//! texels: a facade differed from itself. Therefore each resolution keeps as many texels as the finest one, under a
//! kernel with gaps (M. Holschneider et al., A real-time algorithm for signal analysis with the help of the wavelet
//! transform, 1989), up to four texels for one of its own along each side, and neighbours are so many texels apart.
//! Samples of the values do not lie on a lattice either.

use super::pyramid;
use crate::planes::Planes;
use crate::size::Size;

/// The most texels kept along a side for one texel of a resolution.
const KEPT: usize = 4;

/// A texture at one resolution.
#[derive(Debug, Clone)]
pub(super) struct Resolution {
    /// The smoothed texels.
    pub(super) planes: Planes,
    /// How many of them neighbours are apart.
    pub(super) step: usize,
}

impl Resolution {
    /// The texture as it is.
    pub(super) fn finest(planes: &Planes) -> Self {
        Self { planes: planes.clone(), step: 1 }
    }

    /// The same at half the resolution.
    pub(super) fn coarser(&self) -> Self {
        let Self { ref planes, step } = *self;
        let stride = if step < KEPT { 1 } else { 2 };
        Self { planes: pyramid::smoothed(planes, step, stride), step: 2 * step / stride }
    }

    /// The size of the texture at this resolution, rounded up.
    pub(super) fn size(&self) -> Size {
        let Size { width, height } = self.planes.size();
        Size::new(width.div_ceil(self.step), height.div_ceil(self.step))
    }
}

/// The numbers of at most `most` texels: all of them, or those of a sequence that covers the area evenly and shares no
/// period with it (M. Roberts, The unreasonable effectiveness of quasirandom sequences, 2018).
pub(super) fn sampled(size: Size, most: usize) -> impl Iterator<Item = usize> {
    /// The fractional parts of the powers -1 and -2 of the real root of x^3 = x + 1, times 2^64.
    const STEPS: [u64; 2] = [13_925_035_116_211_876_495, 10_511_698_010_929_265_436];
    let texels = size.texels();
    let along = |side: usize, i: usize, step: u64| {
        let place = (i as u64).wrapping_mul(step);
        ((u128::from(place) * side as u128) >> 64) as usize
    };
    (0..texels.min(most)).map(move |i| match texels <= most {
        true => i,
        false => size.index(along(size.width, i, STEPS[0]), along(size.height, i, STEPS[1])),
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn values_of_a_resolution_do_not_depend_on_where_the_texture_begins() {
        // A period of 32 texels is two texels of the fifth level.
        let wave = |offset: usize| {
            let value = |i: usize| ((i % 128 + offset) as f32 / 32.0 * std::f32::consts::TAU).cos();
            let size = Size::new(128, 128);
            let mut level = Resolution::finest(
                &Planes::from_vec(size, 1, (0..size.texels()).map(value).collect()).unwrap(),
            );
            for _ in 0..4 {
                level = level.coarser();
            }
            assert_eq!((level.size(), level.step), (Size::new(8, 8), 4));
            let inner = level.planes.crop(8, 8, Size::new(16, 16)).unwrap();
            inner.as_slice().iter().map(|v| f64::from(v.abs())).sum::<f64>() / 256.0
        };
        let (a, b) = (wave(0), wave(8));
        assert!((a / b - 1.0).abs() < 0.1, "{a} {b}");
    }

    #[test]
    fn samples_cover_all_columns_and_rows_evenly() {
        let size = Size::new(512, 256);
        assert_eq!(sampled(size, 1 << 17).collect::<Vec<_>>(), (0..1 << 17).collect::<Vec<_>>());
        let mut columns = [0usize; 512];
        for texel in sampled(size, 16_384) {
            assert!(texel < size.texels());
            columns[texel % 512] += 1;
        }
        assert!(columns.iter().all(|n| (28..=36).contains(n)), "{columns:?}");
    }
}
