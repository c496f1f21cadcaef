//! Blocks of BC7 in mode 6: one line of sixteen colours with opacity between two ends.
//!
//! "Khronos Data Format Specification" 1.3, 20 (BPTC). An end has seven bits in each channel and one more that its
//! channels share. The line is the principal axis of the texels; its ends are then fitted to the places chosen on it, by least
//! squares, as long as that helps. Opaque blocks share an odd bit, so that an opacity of 255 comes back as it was.

/// Texels of a block, row by row.
pub(super) type BlockTexels = [[u8; 4]; 16];

/// The places of the sixteen colours on the line, in 64ths.
const PLACES: [u8; 16] = [0, 4, 9, 13, 17, 21, 26, 30, 34, 38, 43, 47, 51, 55, 60, 64];

/// Times that the ends are fitted to the places.
const FITS: usize = 2;

/// Steps towards the principal axis.
const AXIS_STEPS: usize = 4;

type Texel4 = [f32; 4];

/// A block, and the sum of its squared errors.
#[derive(Debug, Clone, Copy)]
struct LineBlock {
    ends: [[u8; 4]; 2],
    indices: [u8; 16],
    error: u32,
}

/// The block of some texels, and the sum of its squared errors in all channels.
pub(super) fn encode(texels: &BlockTexels) -> ([u8; 16], u32) {
    let is_opaque = texels.iter().all(|texel| texel[3] == 255);
    let colors: [Texel4; 16] = texels.map(|texel| texel.map(f32::from));
    let [first, last] = line(&colors);
    let mut best = coded(texels, [first, last], is_opaque);
    for _ in 0..FITS {
        if best.error == 0 {
            break;
        }
        let Some(ends) = fitted(&colors, &best.indices) else { break };
        let next = coded(texels, ends, is_opaque);
        if next.error >= best.error {
            break;
        }
        best = next;
    }
    (packed(&best), best.error)
}

fn dot(a: Texel4, b: Texel4) -> f32 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2] + a[3] * b[3]
}

/// The ends of the texels along their principal axis.
fn line(colors: &[Texel4; 16]) -> [Texel4; 2] {
    let mean: Texel4 = std::array::from_fn(|c| colors.iter().map(|color| color[c]).sum::<f32>() / 16.0);
    let from_mean = colors.map(|color| std::array::from_fn::<f32, 4, _>(|c| color[c] - mean[c]));
    let covariance: [Texel4; 4] =
        std::array::from_fn(|a| std::array::from_fn(|b| from_mean.iter().map(|d| d[a] * d[b]).sum()));
    // The row of the channel that varies most is near the axis.
    let most = (1..4).fold(0, |most, c| if covariance[c][c] > covariance[most][most] { c } else { most });
    let mut axis = covariance[most];
    for _ in 0..AXIS_STEPS {
        let length = dot(axis, axis).sqrt();
        if length < 1e-6 {
            return [mean; 2];
        }
        let unit = axis.map(|a| a / length);
        axis = covariance.map(|row| dot(row, unit));
    }
    let length = dot(axis, axis).sqrt().max(1e-6);
    let unit = axis.map(|a| a / length);
    let places = from_mean.map(|d| dot(d, unit));
    let least = places.iter().fold(f32::INFINITY, |a, &b| a.min(b));
    let largest = places.iter().fold(f32::NEG_INFINITY, |a, &b| a.max(b));
    [least, largest].map(|place| std::array::from_fn(|c| mean[c] + place * unit[c]))
}

/// The ends of the least squared error for given places.
fn fitted(colors: &[Texel4; 16], indices: &[u8; 16]) -> Option<[Texel4; 2]> {
    let (mut aa, mut ab, mut bb) = (0.0, 0.0, 0.0);
    let (mut a_color, mut b_color) = ([0.0f32; 4], [0.0f32; 4]);
    for (color, &index) in colors.iter().zip(indices) {
        let b = f32::from(PLACES[usize::from(index)]) / 64.0;
        let a = 1.0 - b;
        (aa, ab, bb) = (aa + a * a, ab + a * b, bb + b * b);
        for c in 0..4 {
            a_color[c] += a * color[c];
            b_color[c] += b * color[c];
        }
    }
    let determinant = aa * bb - ab * ab;
    if determinant < 1e-3 {
        return None;
    }
    let first = std::array::from_fn(|c| (bb * a_color[c] - ab * b_color[c]) / determinant);
    let last = std::array::from_fn(|c| (aa * b_color[c] - ab * a_color[c]) / determinant);
    Some([first, last])
}

/// An end in eight bits, the last of which all channels share.
fn quantised(end: Texel4, is_opaque: bool) -> [u8; 4] {
    let with = |bit: u8| -> [u8; 4] {
        end.map(|v| 2 * ((v - f32::from(bit)) * 0.5 + 0.5).clamp(0.0, 127.0) as u8 + bit)
    };
    let error = |codes: [u8; 4]| -> f32 {
        end.iter().zip(codes).map(|(v, code)| (v - f32::from(code)).powi(2)).sum()
    };
    let (even, odd) = (with(0), with(1));
    if is_opaque || error(odd) <= error(even) { odd } else { even }
}

fn coded(texels: &BlockTexels, ends: [Texel4; 2], is_opaque: bool) -> LineBlock {
    let ends = ends.map(|end| quantised(end, is_opaque));
    let palette: BlockTexels = PLACES.map(|place| {
        std::array::from_fn(|c| {
            let (a, b, w) = (u32::from(ends[0][c]), u32::from(ends[1][c]), u32::from(place));
            (((64 - w) * a + w * b + 32) >> 6) as u8
        })
    });
    let start = ends[0].map(f32::from);
    let along: Texel4 = std::array::from_fn(|c| f32::from(ends[1][c]) - start[c]);
    let squared = dot(along, along);
    let factor = if squared > 0.0 { 15.0 / squared } else { 0.0 };
    let mut error = 0;
    let indices = texels.map(|texel| {
        let place = dot(std::array::from_fn(|c| f32::from(texel[c]) - start[c]), along) * factor;
        let index = (place + 0.5).clamp(0.0, 15.0) as u8;
        error += squared_distance(texel, palette[usize::from(index)]);
        index
    });
    LineBlock { ends, indices, error }
}

/// The sum of the squared differences of two texels.
pub(super) fn squared_distance(a: [u8; 4], b: [u8; 4]) -> u32 {
    a.into_iter().zip(b).map(|(a, b)| u32::from(a.abs_diff(b)).pow(2)).sum()
}

/// The bits of a block. The highest bit of the first index is not stored: it is 0 after an exchange of the ends.
fn packed(coded: &LineBlock) -> [u8; 16] {
    let is_exchanged = coded.indices[0] >= 8;
    let [a, b] = if is_exchanged { [coded.ends[1], coded.ends[0]] } else { coded.ends };
    // Seven bits of the mode, of which the last is set.
    let (mut bits, mut at) = (1u128 << 6, 7);
    let mut put = |value: u8, count: u32| {
        bits |= u128::from(value) << at;
        at += count;
    };
    for c in 0..4 {
        put(a[c] >> 1, 7);
        put(b[c] >> 1, 7);
    }
    put(a[0] & 1, 1);
    put(b[0] & 1, 1);
    for (i, &index) in coded.indices.iter().enumerate() {
        put(if is_exchanged { 15 - index } else { index }, if i == 0 { 3 } else { 4 });
    }
    bits.to_le_bytes()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::numeric::random::{Purpose, Stream};

    /// The texels of a block, by the decoder of the crate.
    fn decoded(block: &[u8; 16]) -> BlockTexels {
        let mut back = [0; 64];
        let variant =
            block_compression::CompressionVariant::BC7(block_compression::BC7Settings::opaque_basic());
        block_compression::decode::decompress_blocks_as_rgba8(variant, 4, 4, block, &mut back);
        std::array::from_fn(|i| back[4 * i..4 * i + 4].try_into().unwrap())
    }

    #[test]
    fn blocks_have_the_error_that_is_said_by_another_decoder() {
        let mut random = Stream::new(15, Purpose::Sample, [0]);
        for round in 0..500 {
            let (base, slope) = (random.below(200), random.below(60));
            let is_opaque = round % 2 == 0;
            let texels: BlockTexels = std::array::from_fn(|_| {
                let along = random.below(slope.max(1));
                let noise: [usize; 4] = std::array::from_fn(|_| random.below(1 + round % 9));
                let channel = |c: usize| (base + along * (c + 1) / 3 + noise[c]).min(255) as u8;
                [channel(0), channel(1), channel(2), if is_opaque { 255 } else { channel(3) }]
            });
            let (block, error) = encode(&texels);
            let back = decoded(&block);
            let found: u32 = texels.iter().zip(back).map(|(a, b)| squared_distance(*a, b)).sum();
            assert_eq!(found, error, "round {round}");
            assert!(!is_opaque || back.iter().all(|texel| texel[3] == 255), "round {round}");
            assert!(error < 16 * 4 * 60, "round {round}: {error}");
        }
    }

    #[test]
    fn lines_of_colours_come_back_within_two_codes() {
        let texels: BlockTexels =
            std::array::from_fn(|i| [10 + 15 * i as u8, 240 - 14 * i as u8, 7 * i as u8, 255]);
        let back = decoded(&encode(&texels).0);
        for (a, b) in texels.iter().flatten().zip(back.iter().flatten()) {
            assert!(a.abs_diff(*b) <= 2, "{a} {b}");
        }
    }
}
