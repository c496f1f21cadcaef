//! The integers of learned functions as bits: each is predicted from those before it, and the difference is a Rice code.
//!
//! The middle channel is predicted from the light before, the view before and both, by the median rule of LOCO-I
//! (Weinberger, Seroussi, Sapiro 2000); the other channels from the middle one and its difference to them at the light
//! before.

use super::bits::{BitReader, BitWriter, Rice};
use crate::error::{Error, Result};
use crate::field::PackedFunctions;
use crate::field::basis::{MOST_PACKED, WeightedDirection};
use crate::job::Job;

/// Bits of the numbers of lights, views, channels and functions.
pub(super) const COUNTS: [u32; 4] = [16, 16, 8, 16];

/// The bytes of packed functions in a file.
pub fn functions_bytes(functions: &PackedFunctions) -> usize {
    encode_functions(functions).map_or(usize::MAX, |bytes| bytes.len())
}

/// Packed functions as bytes.
///
/// # Errors
/// More lights, views, channels or functions than the bytes can count.
pub fn encode_functions(functions: &PackedFunctions) -> Result<Vec<u8>> {
    let mut bits = BitWriter::default();
    write_functions(&mut bits, functions)?;
    Ok(bits.into_bytes())
}

/// The packed functions of [`encode_functions`].
///
/// # Errors
/// Bytes missing, more memory than the limits allow, and numbers that are not those of functions.
pub fn decode_functions(bytes: &[u8], job: &Job) -> Result<PackedFunctions> {
    read_functions(&mut BitReader::new(bytes), job)
}

/// Writes functions.
///
/// # Errors
/// More lights, views, channels or functions than the file can count.
pub(super) fn write_functions(bits: &mut BitWriter, functions: &PackedFunctions) -> Result<()> {
    let counts = [functions.lights.len(), functions.views.len(), functions.channels, functions.steps.len()];
    for (count, width) in counts.into_iter().zip(COUNTS) {
        if count >= 1 << width {
            return Err(Error::usage(format!(
                "{count} lights, views, channels or functions are more than a model holds"
            )));
        }
        bits.bits(count as u32, width);
    }
    write_directions(bits, functions);
    functions.steps.iter().for_each(|&step| bits.float(step));
    let mut codes = functions.codes.clone();
    each(&mut codes, counts, |code, predicted, state| {
        bits.rice(code - predicted, state);
        Ok(code)
    })
}

/// Reads functions.
///
/// # Errors
/// Bits missing, more memory than the limits allow, and numbers that are not those of functions.
pub(super) fn read_functions(bits: &mut BitReader<'_>, job: &Job) -> Result<PackedFunctions> {
    let mut counts = [0; 4];
    for (count, width) in counts.iter_mut().zip(COUNTS) {
        *count = bits.bits(width)? as usize;
    }
    let [lights, views, channels, functions] = counts;
    let integers = counts.iter().fold(1u64, |product, &count| product.saturating_mul(count as u64));
    // Each takes a bit at least.
    if integers == 0 || integers > bits.left() as u64 {
        return Err(Error::invalid(format!(
            "{functions} functions of {channels} channels for {lights} lights and {views} views do not fit the {} bits \
             that are left of the model",
            bits.left()
        )));
    }
    job.check_bytes("the functions of the model", 24 * integers)?;
    let all = read_directions(bits, lights + views)?;
    let steps = (0..functions).map(|_| bits.float("step")).collect::<Result<Vec<f32>>>()?;
    let mut codes = vec![0; integers as usize];
    each(&mut codes, counts, |_, predicted, state| {
        let code = predicted.saturating_add(bits.rice(state)?);
        if code.saturating_abs() > MOST_PACKED {
            return Err(Error::invalid(format!(
                "the value {code} of a function of the model is out of range"
            )));
        }
        Ok(code)
    })?;
    let (lights, views) = all.split_at(lights);
    Ok(PackedFunctions { lights: lights.to_vec(), views: views.to_vec(), channels, steps, codes })
}

/// Writes the lights, then the views.
pub(super) fn write_directions(bits: &mut BitWriter, functions: &PackedFunctions) {
    for WeightedDirection { disk: [x, y], weight } in functions.lights.iter().chain(&functions.views) {
        [x, y, weight].iter().for_each(|&&number| bits.float(number));
    }
}

/// Reads so many directions.
///
/// # Errors
/// Bits missing, and numbers that are not finite.
pub(super) fn read_directions(bits: &mut BitReader<'_>, count: usize) -> Result<Vec<WeightedDirection>> {
    let mut direction = || {
        let disk = [bits.float("direction")?, bits.float("direction")?];
        Ok(WeightedDirection { disk, weight: bits.float("weight")? })
    };
    (0..count).map(|_| direction()).collect()
}

/// Replaces all integers, in order, by the results of `code`, which gets each, its prediction and the state of its kind.
fn each(
    codes: &mut [i32],
    [lights, views, channels, _]: [usize; 4],
    mut code: impl FnMut(i32, i32, &mut Rice) -> Result<i32>,
) -> Result<()> {
    let middle = channels / 2;
    let others: Vec<usize> = (0..channels).filter(|c| *c != middle).collect();
    for function in codes.chunks_exact_mut(lights * views * channels) {
        let (mut first, mut rest) = (Rice::new(), Rice::new());
        for (view, light) in (0..views).flat_map(|view| (0..lights).map(move |light| (view, light))) {
            let place = (view * lights + light) * channels;
            let predicted = median(function, [place + middle, lights * channels, channels], [view, light]);
            let found = code(function[place + middle], predicted, &mut first)?;
            function[place + middle] = found;
            for &c in &others {
                let before = place.wrapping_sub(channels);
                let apart = if light > 0 { function[before + c] - function[before + middle] } else { 0 };
                function[place + c] = code(function[place + c], found + apart, &mut rest)?;
            }
        }
    }
    Ok(())
}

/// The median of the integer of the light before, that of the view before, and their sum less that of both.
fn median(codes: &[i32], [place, row, step]: [usize; 3], [view, light]: [usize; 2]) -> i32 {
    match (view > 0, light > 0) {
        (false, false) => 0,
        (false, true) => codes[place - step],
        (true, false) => codes[place - row],
        (true, true) => {
            let (a, b, both) = (codes[place - step], codes[place - row], codes[place - row - step]);
            (a + b - both).clamp(a.min(b), a.max(b))
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::field::basis::learned_of_channels_example;

    fn packed(channels: usize, step: f32) -> PackedFunctions {
        let learned = learned_of_channels_example(channels, 20, 15, 3);
        PackedFunctions::new(&learned, &[step; 3]).unwrap()
    }

    #[test]
    fn functions_come_back_to_the_bit() {
        for functions in [packed(1, 1e-4), packed(3, 1e-3), packed(2, 0.1)] {
            let mut bits = BitWriter::default();
            write_functions(&mut bits, &functions).unwrap();
            let bytes = bits.into_bytes();
            assert_eq!(bytes.len(), functions_bytes(&functions));
            let found = read_functions(&mut BitReader::new(&bytes), &Job::default()).unwrap();
            assert_eq!(found, functions);
            for length in 0..bytes.len() {
                assert!(read_functions(&mut BitReader::new(&bytes[..length]), &Job::default()).is_err());
            }
        }
    }

    #[test]
    fn predictions_save_bits() {
        let functions = packed(3, 1e-4);
        let mut shuffled = functions.clone();
        // The same integers in another order, in which neighbours are far apart.
        let n = shuffled.codes.len();
        shuffled.codes = (0..n).map(|i| functions.codes[i * 7919 % n]).collect();
        assert!(functions_bytes(&functions) < functions_bytes(&shuffled) * 9 / 10);
    }

    #[test]
    fn functions_that_do_not_fit_are_refused_before_memory_is_taken() {
        let mut bits = BitWriter::default();
        [65535u32, 65535, 255, 65535].into_iter().zip(COUNTS).for_each(|(n, width)| bits.bits(n, width));
        (0..40).for_each(|_| bits.float(0.5));
        let error = read_functions(&mut BitReader::new(&bits.into_bytes()), &Job::default()).unwrap_err();
        assert!(error.to_string().contains("do not fit"), "{error}");
    }
}
