//! Full matrix factorisations, of all channels together (FMF) or of each channel of a colour model (DFMF).
//!
//! FMF: rows are values of a pair and a channel, columns texels; or, transposed, rows are channels of texels and
//! columns pairs. DFMF: for each channel a matrix of pairs and texels, or texels and pairs. The number of rows says
//! which.

use super::color_model::{BtfColorModel, EPSILON};
use super::factor::FactorMatrix;
use super::header::BtfHead;
use super::source::BtfCursor;
use crate::error::{Error, Result};
use crate::planes::Planes;

/// What the rows of a matrix are.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum RowsOf {
    /// Pairs, or values of a pair and a channel.
    Pairs,
    /// Texels, or channels of texels: the matrix is transposed.
    Texels,
}

/// One matrix for all channels.
#[derive(Debug)]
pub(super) struct Fmf {
    pub(super) matrix: FactorMatrix,
    pub(super) rows: RowsOf,
    /// Values are logarithms.
    pub(super) logarithms: bool,
}

/// A matrix for each channel of a colour model.
#[derive(Debug)]
pub(super) struct Dfmf {
    pub(super) model: BtfColorModel,
    pub(super) channels: Vec<(FactorMatrix, RowsOf)>,
}

impl Fmf {
    pub(super) fn read(head: &BtfHead, cursor: &mut BtfCursor) -> Result<Self> {
        let logarithms = head.extended && extension(cursor)?;
        cursor.u32("the number of components")?;
        let channels = head.channels.len();
        let named = "the matrix";
        let matrix = FactorMatrix::read(cursor, named)?;
        let (pairs, texels) = (head.sampling.pairs.len(), head.size.texels());
        let rows = rows_of(&matrix, named, [pairs * channels, texels], [texels * channels, pairs], head)?;
        Ok(Self { matrix, rows, logarithms })
    }

    /// The image of a pair, in all channels.
    pub(super) fn image(&self, pair: usize, planes: &mut Planes) {
        let channels = planes.count();
        for (channel, plane) in planes.iter_mut().enumerate() {
            match self.rows {
                RowsOf::Pairs => self.matrix.along_row(pair * channels + channel, plane),
                RowsOf::Texels => self.matrix.along_column(pair, channel, channels, plane),
            }
            if self.logarithms {
                plane.iter_mut().for_each(|value| *value = value.exp() - EPSILON);
            }
        }
    }
}

/// The extended header: whether values are logarithms; a height map, which is skipped.
fn extension(cursor: &mut BtfCursor) -> Result<bool> {
    const WHAT: &str = "the extended header";
    let version = cursor.u8(WHAT)?;
    if version > 2 {
        return Err(Error::unsupported(format!(
            "version {version} of the extended header of a BTF file is not read: expected 0, 1 or 2"
        )));
    }
    let logarithms = version >= 1 && cursor.u32(WHAT)? != 0;
    if version >= 2 {
        let texels = u64::from(cursor.u32(WHAT)?) * u64::from(cursor.u32(WHAT)?);
        if texels > 0 {
            cursor.skip("the height map", texels.saturating_mul(2))?;
            cursor.job().remark("the height map of the BTF file is not used");
        }
    }
    Ok(logarithms)
}

impl Dfmf {
    pub(super) fn read(head: &BtfHead, cursor: &mut BtfCursor) -> Result<Self> {
        cursor.u32("the number of components")?;
        let model = BtfColorModel::read(cursor, head.channels.len())?;
        if model == BtfColorModel::SpectralLinear {
            cursor.job().remark(
                "the colour model 6 of the BTF file is decoded as by the library of its authors, although the sum of \
                 its channels is then not that of the file",
            );
        }
        let (pairs, texels) = (head.sampling.pairs.len(), head.size.texels());
        let channel = |name: &String| {
            let named = format!("channel '{name}'");
            let matrix = FactorMatrix::read(cursor, &named)?;
            let rows = rows_of(&matrix, &named, [pairs, texels], [texels, pairs], head)?;
            Ok((matrix, rows))
        };
        let channels = head.channels.iter().map(channel).collect::<Result<_>>()?;
        Ok(Self { model, channels })
    }

    /// The image of a pair, in all channels.
    pub(super) fn image(&self, pair: usize, planes: &mut Planes) {
        for ((matrix, rows), plane) in self.channels.iter().zip(planes.iter_mut()) {
            match rows {
                RowsOf::Pairs => matrix.along_row(pair, plane),
                RowsOf::Texels => matrix.along_column(pair, 0, 1, plane),
            }
        }
        if self.model == BtfColorModel::Rgb {
            return;
        }
        let mut texel = vec![0.0; planes.count()];
        let mut channels: Vec<&mut [f32]> = planes.iter_mut().collect();
        for i in 0..channels.first().map_or(0, |plane| plane.len()) {
            texel.iter_mut().zip(&channels).for_each(|(value, plane)| *value = plane[i]);
            self.model.decode(&mut texel);
            channels.iter_mut().zip(&texel).for_each(|(plane, value)| plane[i] = *value);
        }
    }
}

/// Which way round a matrix is, by its rows and columns.
fn rows_of(
    matrix: &FactorMatrix,
    named: &str,
    by_pairs: [usize; 2],
    by_texels: [usize; 2],
    head: &BtfHead,
) -> Result<RowsOf> {
    match [matrix.rows, matrix.columns] {
        shape if shape == by_pairs => Ok(RowsOf::Pairs),
        shape if shape == by_texels => Ok(RowsOf::Texels),
        [rows, columns] => Err(Error::invalid(format!(
            "{named} in the BTF file has {rows} x {columns} values: expected {} x {} or {} x {} for {} pairs of light \
             and view and {} texels",
            by_pairs[0],
            by_pairs[1],
            by_texels[0],
            by_texels[1],
            head.sampling.pairs.len(),
            head.size
        ))),
    }
}
