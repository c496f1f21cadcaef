//! Samples of a picture file as values in the space of a fit.

use std::sync::OnceLock;

use crate::raster::{Raster, Samples};
use crate::space::Space;

/// Tables of the values of integer codes in one space.
#[derive(Debug)]
pub(super) struct SampleLevels {
    space: Space,
    codes8: [f32; 256],
    codes16: OnceLock<Vec<f32>>,
}

impl SampleLevels {
    pub fn new(space: Space) -> Self {
        let codes8 = std::array::from_fn(|code| encoded_to(space, code as f32 / 255.0));
        Self { space, codes8, codes16: OnceLock::new() }
    }

    /// The space of the values.
    pub fn space(&self) -> Space {
        self.space
    }

    /// The values of one channel of consecutive texels, starting with `first`.
    pub fn channel(&self, raster: &Raster, channel: usize, first: usize, out: &mut [f32]) {
        let step = raster.channels();
        let start = first * step + channel;
        match raster.samples() {
            Samples::U8(s) => strided(&s[start..], step, out, |code| self.codes8[usize::from(code)]),
            Samples::U16(s) => {
                let table = self.codes16.get_or_init(|| {
                    (0..=u16::MAX).map(|code| encoded_to(self.space, f32::from(code) / 65535.0)).collect()
                });
                strided(&s[start..], step, out, |code| table[usize::from(code)]);
            }
            Samples::F32(s) => strided(&s[start..], step, out, |value| self.space.from_linear(value)),
        }
    }
}

/// An sRGB-encoded value in `space`.
fn encoded_to(space: Space, encoded: f32) -> f32 {
    match space {
        Space::Srgb => encoded,
        Space::Linear => Space::Srgb.to_linear(encoded),
    }
}

fn strided<T: Copy>(samples: &[T], step: usize, out: &mut [f32], value: impl Fn(T) -> f32) {
    let texels = samples.chunks(step);
    out.iter_mut().zip(texels).for_each(|(out, texel)| *out = value(texel[0]));
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::size::Size;

    #[test]
    fn values_are_those_of_the_raster_as_a_picture() {
        let size = Size::new(3, 2);
        let samples = [
            Samples::U8((0..18).map(|i| i * 14).collect()),
            Samples::U16((0..18).map(|i| i * 3800).collect()),
            Samples::F32((0..18).map(|i| i as f32 / 9.0 - 0.5).collect()),
        ];
        for (samples, space) in
            samples.into_iter().flat_map(|s| [(s.clone(), Space::Srgb), (s, Space::Linear)])
        {
            let raster = Raster::new(size, 3, samples).unwrap();
            let picture = raster.to_picture(space);
            for channel in 0..3 {
                let mut values = [0.0; 4];
                SampleLevels::new(space).channel(&raster, channel, 2, &mut values);
                assert_eq!(values, picture.planes.plane(channel)[2..]);
            }
        }
    }
}
