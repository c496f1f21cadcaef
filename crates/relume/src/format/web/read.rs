//! A folder to a field.

use super::info::{WebColor, WebInfo, WebKind};
use super::tables::{Tables, learned};
use super::{INFO_FILE, functions, tiles};
use crate::error::{Error, Result};
use crate::field::refit::refit;
use crate::field::{Basis, PlaneLayout, ReflectanceField};
use crate::format::folder::ReadFile;
use crate::job::Job;
use crate::memory;
use crate::numeric::Matrix;
use crate::parallel;
use crate::planes::Planes;
use crate::space::Space;

/// The field of a folder, of which `read` gives the files.
///
/// # Errors
/// A folder that is incomplete or damaged, with the file at fault; functions and arrangements that are not read, by name.
pub(in crate::format) fn decode(read: &ReadFile<'_>, job: &Job) -> Result<ReflectanceField> {
    let text = read(INFO_FILE)?.ok_or_else(|| Error::invalid("the folder has no info.json"))?;
    let info = WebInfo::parse(&text)?;
    // The bytes of all pictures, and the coefficients of the folder and of the field.
    job.check("the web folder", info.size, (3 * info.pictures() + 8 * (info.planes + 1)) as u64)?;
    let stored = coefficients(&info, read, job)?;
    let space = if info.is_linear { Space::Linear } else { Space::Srgb };
    let field = match info.kind {
        WebKind::Rbf(_) | WebKind::Bilinear(_) => of_tables(&info, &stored, space, job)?,
        _ => of_functions(&info, &stored, space, job)?,
    };
    let lights = info.lights.iter().filter_map(|&[x, y, z]| crate::Direction::new(x, y, z).ok());
    Ok(field.with_lights(lights.collect()))
}

/// The coefficients of the folder, one plane each.
fn coefficients(info: &WebInfo, read: &ReadFile<'_>, job: &Job) -> Result<Planes> {
    let tiles = tiles::find(info.size, info.pictures(), read)?;
    let mut planes = Planes::zeros_within(job, "the planes of the folder", info.size, info.planes)?;
    let texels = info.size.texels();
    parallel::try_for_each(planes.as_mut_slice().chunks_mut(3 * texels).enumerate(), |(picture, group)| {
        job.proceed()?;
        let samples = tiles::picture(&tiles, picture, info.size, read, job)?;
        for (c, plane) in group.chunks_exact_mut(texels).enumerate() {
            let k = 3 * picture + c;
            let value = |byte: u8| ((f64::from(byte) / 255.0 - info.bias[k]) * info.scale[k]) as f32;
            let values: [f32; 256] = std::array::from_fn(|byte| value(byte as u8));
            let bytes = samples.iter().skip(c).step_by(3);
            plane.iter_mut().zip(bytes).for_each(|(out, &byte)| *out = values[usize::from(byte)]);
        }
        Ok(())
    })?;
    Ok(planes)
}

/// Functions that a basis spans.
fn of_functions(info: &WebInfo, stored: &Planes, space: Space, job: &Job) -> Result<ReflectanceField> {
    let is_product = info.color == WebColor::Lrgb;
    let count = if is_product { info.planes.saturating_sub(3) } else { info.planes / 3 };
    let (name, matrix) = spanned(info, count)?;
    let basis = Basis::from_name(&name).ok_or_else(|| not_read(info, count))?;
    let matrix = match matrix {
        Some(functions) => Some(refit(&basis, count, functions)?),
        None => None,
    };
    let layout = if is_product { PlaneLayout::LRGB } else { PlaneLayout::RGB };
    let mut planes =
        Planes::zeros_within(job, "the functions of the folder", info.size, layout.planes(basis.len()))?;
    let n = basis.len();
    // The stored plane of a function: colours come first in a product, and are interleaved otherwise.
    let source = |channel: usize, k: usize| if is_product { 3 + k } else { 3 * k + channel };
    parallel::for_each(planes.as_mut_slice().chunks_mut(info.size.texels()).enumerate(), |(plane, out)| {
        if is_product && plane >= n {
            out.copy_from_slice(stored.plane(plane - n));
            return;
        }
        let (channel, function) = (plane / n, plane % n);
        match &matrix {
            None => out.copy_from_slice(stored.plane(source(channel, function))),
            Some(matrix) => combine(out, matrix.row(function), |k| stored.plane(source(channel, k))),
        }
    });
    ReflectanceField::new(basis, layout, space, planes)
}

type Functions = fn(crate::Direction, &mut [f64]);

/// The basis of so many functions of a type, and the functions where they are not those of the basis in its order.
fn spanned(info: &WebInfo, count: usize) -> Result<(String, Option<Functions>)> {
    let polynomial = [(3, "linear"), (6, "ptm"), (10, "cubic"), (15, "quartic")];
    match info.kind {
        WebKind::Hsh => Ok((format!("hsh{count}"), None)),
        WebKind::Ptm => {
            let name =
                polynomial.iter().find(|(terms, _)| *terms == count).map(|(_, name)| (*name).to_owned());
            Ok((name.ok_or_else(|| not_read(info, count))?, Some(functions::monomials)))
        }
        // Polynomials in x, y and z: in harmonics of the same degree where that basis is there.
        WebKind::Sh if count == 9 => Ok(("sh9".to_owned(), Some(functions::spherical))),
        _ => Err(not_read(info, count)),
    }
}

fn not_read(info: &WebInfo, count: usize) -> Error {
    let (what, expected) = match info.kind {
        WebKind::Ptm => ("polynomials", "6"),
        WebKind::Hsh => ("hemispherical harmonics", "9"),
        _ => ("spherical harmonics", "9"),
    };
    Error::unsupported(format!("folders of {count} {what} are not read: expected {expected}"))
}

/// out = sum_k row_k plane_k
fn combine<'a>(out: &mut [f32], row: &[f64], plane: impl Fn(usize) -> &'a [f32]) {
    out.fill(0.0);
    for (k, &factor) in row.iter().enumerate().filter(|(_, factor)| **factor != 0.0) {
        out.iter_mut().zip(plane(k)).for_each(|(out, &value)| *out += factor as f32 * value);
    }
}

/// Tables, as functions with a value for each channel.
fn of_tables(info: &WebInfo, stored: &Planes, space: Space, job: &Job) -> Result<ReflectanceField> {
    let tables = Tables::of(info)?;
    let (learned, matrix) = learned(&tables)?;
    let mut planes = Planes::zeros_within(job, "the functions of the folder", info.size, matrix.rows())?;
    let mut ones = memory::zeros::<f32>("the mean of the folder", info.size.texels())?;
    ones.fill(1.0);
    fill(&mut planes, &matrix, &ones, stored);
    let layout = PlaneLayout::shared(["R", "G", "B"])?;
    ReflectanceField::new(Basis::Learned(learned), layout, space, planes)
}

fn fill(planes: &mut Planes, matrix: &Matrix, ones: &[f32], stored: &Planes) {
    let texels = planes.size().texels();
    parallel::for_each(planes.as_mut_slice().chunks_mut(texels).enumerate(), |(function, out)| {
        combine(out, matrix.row(function), |k| k.checked_sub(1).map_or(ones, |k| stored.plane(k)));
    });
}
