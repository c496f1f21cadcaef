//! A palette of 256 colours by median cut.
//!
//! Heckbert, "Color Image Quantization for Frame Buffer Display", SIGGRAPH 1982: a box of colours is split at
//! the median of its longest side until there are enough boxes. Here the box with the largest product of
//! squared side and number of texels is split next, since its error is the largest. Colours are counted in
//! bins of 6 bits per channel.

use std::cmp::Reverse;

/// Bits per channel of a bin.
const BITS: u32 = 6;
const BINS: usize = 1 << (3 * BITS);

/// Colours and the palette entry of each bin that occurs.
pub(super) struct Palette {
    colors: Vec<[u8; 3]>,
    entries: Vec<u8>,
}

/// A colour and the number of its occurrences.
#[derive(Clone, Copy)]
struct Counted {
    color: [u8; 3],
    count: u64,
}

impl Palette {
    /// The 256 greys in order; bins are not used.
    pub(super) fn greys() -> Self {
        Self { colors: (0..=255).map(|grey| [grey; 3]).collect(), entries: Vec::new() }
    }

    /// At most 256 colours for these texels.
    pub(super) fn of_colors<'a>(texels: impl Iterator<Item = &'a [u8; 3]>) -> Self {
        let mut occurring = occurring(texels);
        let mut boxes = vec![occurring.as_mut_slice()];
        while boxes.len() < 256 {
            let spreads = boxes.iter().map(|colors| spread(colors)).enumerate();
            let Some((i, _)) = spreads.filter(|&(_, s)| s > 0).max_by_key(|&(i, s)| (s, Reverse(i))) else {
                break;
            };
            let (left, right) = split(std::mem::take(&mut boxes[i]));
            boxes[i] = left;
            boxes.push(right);
        }
        let colors: Vec<[u8; 3]> = boxes.iter().map(|colors| mean(colors)).collect();
        let mut entries = vec![0; BINS];
        for counted in boxes.iter().flat_map(|colors| colors.iter()) {
            entries[bin(&counted.color)] = nearest(&colors, counted.color);
        }
        Self { colors, entries }
    }

    /// Red, green and blue of all entries.
    pub(super) fn bytes(&self) -> Vec<u8> {
        self.colors.concat()
    }

    /// The entry of a colour from which the palette was made.
    pub(super) fn index_of(&self, color: &[u8; 3]) -> u8 {
        self.entries[bin(color)]
    }
}

fn bin(color: &[u8; 3]) -> usize {
    color.iter().fold(0, |bin, &c| (bin << BITS) | usize::from(c >> (8 - BITS)))
}

/// The mean colour of each occupied bin; it lies in its bin.
fn occurring<'a>(texels: impl Iterator<Item = &'a [u8; 3]>) -> Vec<Counted> {
    let mut sums = vec![[0u64; 4]; BINS];
    for texel in texels {
        let sum = &mut sums[bin(texel)];
        sum.iter_mut().zip(texel).for_each(|(s, &c)| *s += u64::from(c));
        sum[3] += 1;
    }
    let used = sums.into_iter().filter(|sum| sum[3] > 0);
    used.map(|[r, g, b, n]| Counted { color: [r, g, b].map(|s| ((s + n / 2) / n) as u8), count: n }).collect()
}

/// The longest side of a box of colours, and its length.
fn longest_side(colors: &[Counted]) -> (usize, u64) {
    let length = |axis: usize| {
        let values = colors.iter().map(|c| u64::from(c.color[axis]));
        values.clone().max().unwrap_or(0) - values.min().unwrap_or(0)
    };
    let axis = (0..3).max_by_key(|&axis| (length(axis), Reverse(axis))).unwrap_or(0);
    (axis, length(axis))
}

fn spread(colors: &[Counted]) -> u64 {
    colors.iter().map(|c| c.count).sum::<u64>().saturating_mul(longest_side(colors).1.pow(2))
}

/// Splits a box of at least two colours at the median texel of its longest side.
fn split(colors: &mut [Counted]) -> (&mut [Counted], &mut [Counted]) {
    let (axis, _) = longest_side(colors);
    colors.sort_by_key(|c| (c.color[axis], c.color));
    let half = colors.iter().map(|c| c.count).sum::<u64>() / 2;
    let mut seen = 0;
    let median = colors.iter().position(|c| {
        seen += c.count;
        seen > half
    });
    let at = median.unwrap_or(0).clamp(1, colors.len() - 1);
    colors.split_at_mut(at)
}

fn mean(colors: &[Counted]) -> [u8; 3] {
    let total = colors.iter().map(|c| c.count).sum::<u64>().max(1);
    std::array::from_fn(|axis| {
        let sum: u64 = colors.iter().map(|c| c.count * u64::from(c.color[axis])).sum();
        ((sum + total / 2) / total) as u8
    })
}

fn nearest(colors: &[[u8; 3]], color: [u8; 3]) -> u8 {
    let distance = |other: &[u8; 3]| -> u32 {
        other.iter().zip(color).map(|(&a, b)| u32::from(a.abs_diff(b)).pow(2)).sum()
    };
    (0..colors.len()).min_by_key(|&i| distance(&colors[i])).unwrap_or(0) as u8
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::numeric::random::{Purpose, Stream};

    fn squared_errors(texels: &[[u8; 3]]) -> Vec<u32> {
        let palette = Palette::of_colors(texels.iter());
        let error = |t: &[u8; 3]| -> u32 {
            let found = palette.colors[usize::from(palette.index_of(t))];
            found.iter().zip(t).map(|(&a, &b)| u32::from(a.abs_diff(b)).pow(2)).sum()
        };
        texels.iter().map(error).collect()
    }

    #[test]
    fn few_colours_are_exact() {
        let texels: Vec<[u8; 3]> =
            (0..2000u32).map(|i| [(i % 5 * 60) as u8, (i % 7 * 40) as u8, (i % 3 * 120) as u8]).collect();
        assert!(squared_errors(&texels).iter().all(|&e| e == 0));
        assert_eq!(squared_errors(&[[9, 8, 7]]), [0]);
    }

    #[test]
    fn many_colours_are_near() {
        let mut random = Stream::new(1, Purpose::Sample, [0]);
        let texels: Vec<[u8; 3]> =
            (0..60_000).map(|_| std::array::from_fn(|_| random.below(256) as u8)).collect();
        let errors = squared_errors(&texels);
        let mean = errors.iter().map(|&e| f64::from(e)).sum::<f64>() / errors.len() as f64;
        // 256 cubes of side 255 / 256^(1/3) have an error of side^2 / 4 on average.
        let cubes = (255.0 / 256f64.cbrt()).powi(2) / 4.0;
        assert!(mean < 1.3 * cubes, "{mean} against {cubes}");
    }
}
