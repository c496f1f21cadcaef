//! `PTM_FORMAT_LUM`: functions of luminance with two constant colour differences, and a matrix.
//!
//! No file of this kind is known to exist. The matrix is taken row by row: red, green and blue in 0..255 are its rows
//! times (L, Cr, Cb, 1). The values are linear in the coefficients, so three functions hold them.

use super::PtmEncoding;
use super::WHITE;
use crate::error::Result;
use crate::field::{Basis, PlaneLayout, ReflectanceField};
use crate::job::Job;
use crate::planes::Planes;
use crate::space::Space;

/// The plane of the constant function.
const CONSTANT: usize = 5;

/// The field of six planes of luminance, of Cr and of Cb, with the encoding chosen for it.
pub(super) fn field(
    planes: &Planes,
    matrix: &[f32; 16],
    job: &Job,
) -> Result<(ReflectanceField, PtmEncoding)> {
    job.remark(
        "no other file of the format PTM_FORMAT_LUM is known: its matrix was taken as red, green and blue of \
         (L, Cr, Cb, 1)",
    );
    let mut colored = Planes::zeros_within(job, "the texture map", planes.size(), 18)?;
    for channel in 0..3 {
        let row = &matrix[4 * channel..][..4];
        for k in 0..6 {
            let luminance = planes.plane(k).iter().zip(planes.plane(6).iter().zip(planes.plane(7)));
            let out = colored.plane_mut(6 * channel + k).iter_mut().zip(luminance);
            out.for_each(|(out, (l, (cr, cb)))| {
                let constant = row[1] * cr + row[2] * cb + row[3] / WHITE as f32;
                *out = row[0] * l + if k == CONSTANT { constant } else { 0.0 };
            });
        }
    }
    let field = ReflectanceField::new(Basis::Ptm, PlaneLayout::RGB, Space::Srgb, colored)?;
    let encoding = PtmEncoding::chosen(&field)?;
    Ok((field, encoding))
}
