//! The codes of a structure as bytes: each code is a few decisions of a range coder, with probabilities that
//! depend on the surrounding codes already known.
//!
//! A wavelet coefficient is large where its neighbours, the coefficient at its position one scale coarser,
//! and that of the previous component are large (as in J. Shapiro, "Embedded Image Coding Using Zerotrees of
//! Wavelet Coefficients", IEEE Trans. Signal Processing 41, 1993, and D. Taubman, "High Performance Scalable
//! Image Compression with EBCOT", IEEE Trans. Image Processing 9, 2000). `docs/formats.md` specifies the
//! bytes.

use crate::error::{Error, Result};
use crate::job::Job;
use crate::numeric::range_coder::{Chance, Decoder, Encoder};
use crate::numeric::wavelet;
use crate::random_field::Structure;
use crate::random_field::structure::MOST_CODE;
use crate::size::Size;

/// Magnitudes below this are coded in unary; the remainder of larger ones is an Elias gamma code.
const COUNTED: usize = 15;

/// The codes of a structure as bytes.
pub(super) fn encode(structure: &Structure) -> Vec<u8> {
    let mut encoder = Encoder::default();
    let mut codes = structure.codes.clone();
    let mut chances = Chances::default();
    each(structure, &mut codes, |code, context| {
        chances.code(code, context, &mut |bit, chance| {
            encoder.put(bit, chance);
            bit
        })
    });
    encoder.into_bytes()
}

/// The number of bytes of a structure in a file.
pub fn structure_bytes(structure: &Structure) -> usize {
    encode(structure).len() + HEADER_BITS.div_ceil(8) + 2 * structure.components()
}

/// Bits of a structure apart from its codes and steps: sides, tiles, scales and length.
pub(super) const HEADER_BITS: usize = 3 * 16 + 4 + 32;

/// Decodes the codes of a structure that has none yet.
///
/// # Errors
/// Bytes missing or too many; more memory than the limits allow.
pub(super) fn decode(bytes: &[u8], mut structure: Structure, job: &Job) -> Result<Structure> {
    let planes = structure.tiles * structure.components();
    job.check("the structure", structure.tile, 12 * planes as u64)?;
    let mut codes = vec![0; structure.tile.texels() * planes];
    let (mut decoder, mut chances) = (Decoder::new(bytes), Chances::default());
    each(&structure, &mut codes, |_, context| chances.code(0, context, &mut |_, chance| decoder.get(chance)));
    if decoder.read() != bytes.len() {
        return Err(Error::invalid(format!(
            "the codes of the model's structure take {} bytes, but there are {}",
            decoder.read(),
            bytes.len()
        )));
    }
    structure.codes = codes;
    Ok(structure)
}

/// Replaces all codes by the results of `code`, which gets each code and its context, in their order: tile
/// after tile, component after component, the averages first and then from coarse differences to fine ones.
fn each(structure: &Structure, codes: &mut [i32], mut code: impl FnMut(i32, CodingContext) -> i32) {
    let (texels, width) = (structure.tile.texels(), structure.tile.width);
    let bands = bands(structure.tile, structure.scales);
    for plane in 0..structure.tiles * structure.components() {
        let (known, own) = codes.split_at_mut(plane * texels);
        let own = &mut own[..texels];
        let has_before = !plane.is_multiple_of(structure.components());
        let before = has_before.then(|| &known[known.len() - texels..]);
        for band in &bands {
            for (x, y) in (0..band.size.height).flat_map(|y| (0..band.size.width).map(move |x| (x, y))) {
                let place = (band.y + y) * width + band.x + x;
                let context = CodingContext {
                    around: class(band.around(own, width, x, y), [0, 2, 4, 8]),
                    above: class(band.above(own, width, x, y), [0, 1, i32::MAX, i32::MAX]),
                    before: class(before.map_or(0, |codes| codes[place].abs()), [0, 1, i32::MAX, i32::MAX]),
                };
                own[place] = code(own[place], context);
            }
        }
    }
}

/// The number of bounds that a number exceeds.
fn class(number: i32, bounds: [i32; 4]) -> usize {
    bounds.iter().filter(|bound| number > **bound).count()
}

/// The context of a code, in classes.
#[derive(Debug, Clone, Copy)]
struct CodingContext {
    around: usize,
    above: usize,
    before: usize,
}

/// A rectangle of coefficients of one kind.
#[derive(Debug, Clone, Copy)]
struct Band {
    x: usize,
    y: usize,
    size: Size,
    /// The same kind one scale coarser.
    above: Option<(usize, usize, Size)>,
}

impl Band {
    /// Twice the magnitudes of the left and the upper neighbour plus those of the upper corners.
    fn around(&self, codes: &[i32], width: usize, x: usize, y: usize) -> i32 {
        let at = |dx: isize, dy: isize| {
            let (x, y) = (x.checked_add_signed(dx), y.checked_add_signed(dy));
            match (x, y) {
                (Some(x), Some(y)) if x < self.size.width => codes[(self.y + y) * width + self.x + x].abs(),
                _ => 0,
            }
        };
        (2 * at(-1, 0).min(8) + 2 * at(0, -1).min(8)) + at(-1, -1).min(8) + at(1, -1).min(8)
    }

    /// The magnitude of the coefficient at this position one scale coarser.
    fn above(&self, codes: &[i32], width: usize, x: usize, y: usize) -> i32 {
        let Some((left, top, size)) = self.above else { return 0 };
        if size.texels() == 0 {
            return 0;
        }
        let (x, y) = ((x / 2).min(size.width - 1), (y / 2).min(size.height - 1));
        codes[(top + y) * width + left + x].abs()
    }
}

/// The averages, then, for each scale from the coarsest on, the differences along x, along y and along both.
fn bands(tile: Size, scales: usize) -> Vec<Band> {
    let sizes = wavelet::sizes(tile, scales);
    let mut bands = vec![Band { x: 0, y: 0, size: sizes[scales], above: None }];
    for k in (0..scales).rev() {
        let (whole, low) = (sizes[k], sizes[k + 1]);
        let (right, below) = (whole.width - low.width, whole.height - low.height);
        for (x, y, size) in [
            (low.width, 0, Size::new(right, low.height)),
            (0, low.height, Size::new(low.width, below)),
            (low.width, low.height, Size::new(right, below)),
        ] {
            let coarser = (k + 1 < scales).then(|| bands[bands.len() - 3]);
            bands.push(Band { x, y, size, above: coarser.map(|band| (band.x, band.y, band.size)) });
        }
    }
    bands
}

/// The probabilities of all decisions.
#[derive(Debug)]
struct Chances {
    /// Whether a code is not 0, by context.
    some: [[[Chance; 3]; 3]; 5],
    negative: Chance,
    /// Whether a magnitude is larger than 1, 2, ..., by whether the surrounding codes are large.
    larger: [[Chance; COUNTED]; 5],
    /// The number of bits of the remainder of a large magnitude.
    longer: [Chance; 32],
    bit: Chance,
}

impl Default for Chances {
    fn default() -> Self {
        let new = Chance::default();
        Self {
            some: [[[new; 3]; 3]; 5],
            negative: new,
            larger: [[new; COUNTED]; 5],
            longer: [new; 32],
            bit: new,
        }
    }
}

/// Makes one decision: writes the given one, or reads one.
type Decide<'a> = &'a mut dyn FnMut(bool, &mut Chance) -> bool;

impl Chances {
    /// Writes a code, or reads one; returns the code written or read.
    fn code(&mut self, code: i32, context: CodingContext, decide: Decide<'_>) -> i32 {
        let CodingContext { around, above, before } = context;
        if !decide(code != 0, &mut self.some[around][above][before]) {
            return 0;
        }
        let negative = decide(code < 0, &mut self.negative);
        let mut size = 1;
        while size < COUNTED && decide(code.unsigned_abs() as usize > size, &mut self.larger[around][size]) {
            size += 1;
        }
        if size == COUNTED {
            size +=
                self.rest(code.unsigned_abs() as usize - COUNTED.min(code.unsigned_abs() as usize), decide);
        }
        let size = (size as i32).min(MOST_CODE);
        if negative { -size } else { size }
    }

    /// A number from 0 as the Elias gamma code of one more.
    fn rest(&mut self, number: usize, decide: Decide<'_>) -> usize {
        let number = number + 1;
        let mut bits = 0;
        while bits < 24 && decide(number >> (bits + 1) != 0, &mut self.longer[bits]) {
            bits += 1;
        }
        let low = (0..bits)
            .rev()
            .fold(1, |value, i| value << 1 | usize::from(decide(number >> i & 1 == 1, &mut self.bit)));
        low - 1
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::limits::Limits;
    use crate::numeric::random::{Purpose, Stream};
    use proptest::prelude::*;

    fn structure(tile: Size, tiles: usize, components: usize, scales: usize, seed: u64) -> Structure {
        let mut stream = Stream::new(seed, Purpose::Sample, [0]);
        let code = |_| {
            let size = stream.unit().powi(12) * f64::from(MOST_CODE);
            (if stream.unit() < 0.5 { size } else { -size }) as i32
        };
        let codes = (0..tile.texels() * tiles * components).map(code).collect();
        Structure { tile, tiles, scales, predicts: true, steps: vec![0.5; components], codes }
    }

    proptest! {
        #[test]
        fn codes_come_back_and_no_byte_may_be_missing_or_too_many(
            (w, h, tiles, components, scales) in (1usize..24, 1usize..20, 1usize..3, 1usize..4, 0usize..4), seed: u64,
        ) {
            let whole = structure(Size::new(w, h), tiles, components, scales, seed);
            let (bytes, job) = (encode(&whole), Job::default());
            let empty = Structure { codes: Vec::new(), ..whole.clone() };
            prop_assert_eq!(decode(&bytes, empty.clone(), &job).unwrap(), whole);
            prop_assert!(decode(&bytes[..bytes.len() - 1], empty.clone(), &job).is_err());
            prop_assert!(decode(&[&bytes[..], &[0]].concat(), empty, &job).is_err());
        }
    }

    #[test]
    fn bands_pave_the_tile() {
        for (tile, scales) in [(Size::new(13, 9), 3), (Size::new(1, 7), 2), (Size::new(16, 16), 0)] {
            let mut seen = vec![0; tile.texels()];
            for band in bands(tile, scales) {
                for y in band.y..band.y + band.size.height {
                    seen[tile.index(band.x, y)..][..band.size.width].iter_mut().for_each(|n| *n += 1);
                }
            }
            assert!(seen.iter().all(|&n| n == 1), "{tile} {scales}");
        }
    }

    #[test]
    fn tiles_larger_than_the_limits_are_refused() {
        let empty = Structure { codes: Vec::new(), ..structure(Size::new(1 << 13, 1 << 13), 0, 1, 3, 0) };
        let empty = Structure { tiles: 8, ..empty };
        let tight = Job::new(Limits { max_bytes: 1 << 20, ..Limits::default() });
        assert!(decode(&[0; 9], empty, &tight).is_err());
    }
}
