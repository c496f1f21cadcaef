//! Writing of factored `.btf` files within the limits of the most used reader, the header `btf.hh` of the BTF
//! extractor (Z. Velinov, Free BTF Library, 2016): as many views as lights, three channels, colour model 0 or 11, one
//! size of numbers, values without the cosine, and less than 4 GiB. That reader clamps values to 0..1 and shows rows
//! from the bottom up.

use super::color_model::BtfColorModel;
use super::factors::{BtfFactors, FactorShape};
use super::grid::ViewLightGrid;
use super::{BtfScalar, CHANNELS};
use crate::direction::Directions;
use crate::error::{Error, Result};
use crate::job::Job;
use crate::memory;
use crate::planes::Planes;
use crate::size::Size;

/// The bytes of a `.btf` file of one factorisation for all channels (FMF). The functions depend on pair and channel
/// ([`FactorShape::Functions`], three channels), in the order of `pairs`, which may be any; values do not contain the
/// cosine ([`BtfFactors::without_cosine`]).
///
/// # Errors
/// What the usual reader cannot read, named; numbers beyond the range of `scalar`; limits.
pub fn encode_fmf(
    pairs: &[Directions],
    factors: &BtfFactors,
    scalar: BtfScalar,
    job: &Job,
) -> Result<Vec<u8>> {
    let grid = square_grid(pairs)?;
    check_factors("the factors", factors, FactorShape::Functions, pairs.len() * CHANNELS)?;
    let mut out = begun(b"!FMF12FCER", &grid, factors.coefficients.size(), &[factors], scalar, job)?;
    // Version 2 of the extended header: values as they are, no height map.
    out.push(2);
    put(&mut out, &[0, 0, 0]);
    put(&mut out, &[factors.count() as u32]);
    put_matrix(&mut out, &grid, factors, CHANNELS, scalar)?;
    Ok(out)
}

/// The bytes of a `.btf` file of a factorisation for each channel of a colour model (DFMF): those of
/// [`BtfColorModel::Rgb`], or of [`BtfColorModel::LogYRatios`]. The functions depend on the pair
/// ([`FactorShape::Coefficients`], one channel), in the order of `pairs`, which may be any; values do not contain the
/// cosine.
///
/// # Errors
/// As [`encode_fmf`], and for other colour models.
pub fn encode_dfmf(
    pairs: &[Directions],
    channels: &[BtfFactors; CHANNELS],
    model: BtfColorModel,
    scalar: BtfScalar,
    job: &Job,
) -> Result<Vec<u8>> {
    if !matches!(model, BtfColorModel::Rgb | BtfColorModel::LogYRatios) {
        return Err(Error::unsupported(format!(
            "colour model {} is not written: the usual reader of .btf files knows 0 and 11",
            model.number()
        )));
    }
    let (grid, size) = (square_grid(pairs)?, channels[0].coefficients.size());
    for (factors, name) in channels.iter().zip(NAMES) {
        check_factors(
            &format!("the factors of channel '{name}'"),
            factors,
            FactorShape::Coefficients,
            pairs.len(),
        )?;
        if factors.coefficients.size() != size {
            return Err(Error::invalid(format!(
                "the coefficients of channel '{name}' have {} texels, and those of others {size}",
                factors.coefficients.size()
            )));
        }
    }
    let all: Vec<&BtfFactors> = channels.iter().collect();
    let mut out = begun(b"!DFMF08FCR", &grid, size, &all, scalar, job)?;
    put(&mut out, &[channels.iter().map(BtfFactors::count).max().unwrap_or(0) as u32, model.number()]);
    // The mean and the matrix of a model that has none.
    put_floats(&mut out, &[0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0]);
    for factors in channels {
        put_matrix(&mut out, &grid, factors, 1, scalar)?;
    }
    Ok(out)
}

const NAMES: [&str; CHANNELS] = ["R", "G", "B"];

/// Refuses pairs that a file of common or of decorrelated factors cannot hold.
///
/// # Errors
/// Unless each view has each light once, and there are as many views as lights.
pub fn check_square(pairs: &[Directions]) -> Result<()> {
    square_grid(pairs).map(drop)
}

/// Refuses pairs that a file of factors for each view cannot hold.
///
/// # Errors
/// Unless each view has each light once.
pub fn check_grid(pairs: &[Directions]) -> Result<()> {
    ViewLightGrid::of(pairs).map(drop)
}

fn square_grid(pairs: &[Directions]) -> Result<ViewLightGrid> {
    let grid = ViewLightGrid::of(pairs)?;
    if grid.views.len() != grid.lights.len() {
        return Err(Error::unsupported(format!(
            "the texture has {} views and {} lights: the usual reader of .btf files needs as many views as lights",
            grid.views.len(),
            grid.lights.len()
        )));
    }
    Ok(grid)
}

pub(super) fn check_factors(
    named: &str,
    factors: &BtfFactors,
    shape: FactorShape,
    rows: usize,
) -> Result<()> {
    let (count, planes) = (factors.count(), factors.coefficients.count());
    let fits =
        factors.shape == shape && planes == count && count > 0 && factors.functions.len() == rows * count;
    if fits {
        return Ok(());
    }
    Err(Error::invalid(format!(
        "{named} have {count} singular values, {planes} planes and {} values of functions that depend on {}: expected \
         as many planes as singular values, and {rows} values for each",
        factors.functions.len(),
        match factors.shape {
            FactorShape::Functions => "pair and channel",
            FactorShape::Coefficients => "the pair",
        }
    )))
}

/// The head of the file, with room for the rest.
pub(super) fn begun(
    signature: &[u8],
    grid: &ViewLightGrid,
    size: Size,
    factors: &[&BtfFactors],
    scalar: BtfScalar,
    job: &Job,
) -> Result<Vec<u8>> {
    let directions = (grid.views.len() as u64).saturating_mul(12 + 8 * grid.lights.len() as u64);
    let numbers =
        factors.iter().map(|f| (f.count() + f.functions.len() + f.coefficients.as_slice().len()) as u64);
    let bytes = numbers.sum::<u64>().saturating_mul(scalar.bytes()).saturating_add(directions + 1024);
    // That reader reserves room for all channels for each matrix, in 32 bits.
    let reserved = factors.iter().map(|f| f.functions.len().max(f.coefficients.as_slice().len()) as u64);
    let reserved = reserved.max().unwrap_or(0).saturating_mul(CHANNELS as u64 * scalar.bytes());
    if bytes.max(reserved) >= 1 << 32 {
        return Err(Error::unsupported(format!(
            "the .btf file would have {bytes} bytes and its reader would reserve {reserved} for a matrix: the usual \
             reader counts up to 4 GiB; use fewer components or halves"
        )));
    }
    job.proceed()?;
    job.check_bytes("the BTF file", bytes)?;
    let mut out = memory::with_capacity("the BTF file", bytes as usize)?;
    out.extend_from_slice(signature);
    put_description(&mut out);
    put(&mut out, &[grid.views.len() as u32]);
    for view in &grid.views {
        put_floats(&mut out, view);
        put(&mut out, &[grid.lights.len() as u32]);
        put_floats(&mut out, grid.lights.as_flattened());
    }
    put(&mut out, &[size.width as u32, size.height as u32]);
    // No rotations.
    put(&mut out, &[0]);
    Ok(out)
}

/// Version 4 of the description: no names of instruments, one texel a millimetre, no cosine, no XML, channels R, G
/// and B.
fn put_description(out: &mut Vec<u8>) {
    let start = out.len();
    put(out, &[0, 4]);
    out.extend_from_slice(&[0; 3 * 80]);
    put_floats(out, &[1.0, 1.0, 1.0, 1.0]);
    put(out, &[0, 0, CHANNELS as u32]);
    for name in NAMES {
        put(out, &[name.len() as u32]);
        out.extend_from_slice(name.as_bytes());
    }
    let length = (out.len() - start) as u32;
    out[start..start + 4].copy_from_slice(&length.to_le_bytes());
}

/// The size of a number, those of the matrix, and S, U and S V, with `values` rows of U for each pair.
fn put_matrix(
    out: &mut Vec<u8>,
    grid: &ViewLightGrid,
    factors: &BtfFactors,
    values: usize,
    scalar: BtfScalar,
) -> Result<()> {
    let (count, texels) = (factors.count(), factors.coefficients.size().texels());
    out.push(scalar.bytes() as u8);
    put(out, &[count as u32, (grid.order.len() * values) as u32, texels as u32]);
    let width = values * count;
    let rows = grid.order.iter().flat_map(|&pair| &factors.functions[pair * width..][..width]);
    let too_large = |what: &str| {
        Error::unsupported(format!(
            "{what} of the factors has a number that is not finite, or beyond 65,504 and so beyond halves: write floats"
        ))
    };
    scalar.encode_into(factors.singular.iter().copied(), out).ok_or_else(|| too_large("S"))?;
    scalar.encode_into(rows.copied(), out).ok_or_else(|| too_large("U"))?;
    scalar.encode_into(texel_rows(&factors.coefficients), out).ok_or_else(|| too_large("SxV"))
}

/// The coefficients of texel after texel.
pub(super) fn texel_rows(planes: &Planes) -> impl Iterator<Item = f32> {
    let (texels, count) = (planes.size().texels(), planes.count());
    (0..texels * count).map(move |i| planes.as_slice()[i % count * texels + i / count])
}

pub(super) fn put(out: &mut Vec<u8>, numbers: &[u32]) {
    numbers.iter().for_each(|number| out.extend_from_slice(&number.to_le_bytes()));
}

fn put_floats(out: &mut Vec<u8>, numbers: &[f32]) {
    numbers.iter().for_each(|number| out.extend_from_slice(&number.to_le_bytes()));
}
