//! Windows of the plane of a random-field model.

use std::sync::Arc;

use super::bands::{BandLayout, Cost, RowBands};
use super::{Drawing, FileTarget, PlaneWindow};
use crate::error::{Error, Result};
use crate::field::ReflectanceField;
use crate::format::{
    Depth, ExrDepth, FieldFormat, HeightFormat, PictureFormat, PtmEncoding, Streamed, encode_field,
    encode_height_with,
};
use crate::job::Job;
use crate::random_field::realisation::CELL;
use crate::random_field::{FieldModel, RealisationOptions};
use crate::size::Size;
use crate::space::Space;

/// The plane of a model.
#[derive(Debug, Clone, Copy)]
pub struct ModelPlane<'a> {
    /// The model.
    pub model: &'a FieldModel,
    /// Seed of the random values.
    pub seed: u64,
    /// The size after which the plane repeats, if it does.
    pub period: Option<Size>,
}

impl<'a> ModelPlane<'a> {
    /// The format of files without a name: a picture for constants, otherwise the lossless format.
    pub fn customary_format(&self) -> FieldFormat {
        if self.model.basis.len() == 1 && self.model.space == Space::Srgb {
            FieldFormat::Picture(PictureFormat::Png(Depth::Eight))
        } else {
            FieldFormat::Exr(ExrDepth::Float)
        }
    }

    /// A window as a field.
    ///
    /// # Errors
    /// Windows beyond the limits, and periods that the model does not allow.
    pub fn part(&self, window: &PlaneWindow, job: &Job) -> Result<ReflectanceField> {
        let PlaneWindow { x, y, size } = *window;
        let options = RealisationOptions { origin: [x, y], size, seed: self.seed, period: self.period };
        self.model.synthesize(&options, job)
    }

    /// A window of a model of heights, with its record.
    ///
    /// # Errors
    /// A model of something else, and limits exceeded.
    pub fn height_drawing(
        &self,
        window: PlaneWindow,
        format: HeightFormat,
        job: &Job,
    ) -> Result<Drawing<'a>> {
        let heights = self.model.heights.ok_or_else(|| Error::usage("is not a model of a height map"))?;
        let field = self.part(&window, job)?;
        encode_height_with(field.coefficients(), heights.mm_per_texel, format, job).map(Drawing::whole)
    }

    /// A window of anything but a height map: in bands, or as a whole if the format is not written in rows.
    ///
    /// # Errors
    /// A format that cannot hold the functions, and limits exceeded.
    pub fn drawing(self, window: PlaneWindow, target: &FileTarget, job: &'a Job) -> Result<Drawing<'a>> {
        match (target.format, target.tile) {
            (
                FieldFormat::Picture(
                    PictureFormat::Jpeg { .. }
                    | PictureFormat::Tiff(_)
                    | PictureFormat::Pfm
                    | PictureFormat::Radiance,
                ),
                None,
            ) => encode_field(&self.part(&window, job)?, target.format, None, job).map(Drawing::whole),
            _ => self.in_bands(window, target, job),
        }
    }

    /// The scale of a `.ptm` is that of the reference window of the model, so that a texel has the same bytes
    /// in every window.
    fn in_bands(self, window: PlaneWindow, target: &FileTarget, job: &'a Job) -> Result<Drawing<'a>> {
        let format = target.format;
        let scale = match format {
            FieldFormat::Ptm => Some(PtmEncoding::chosen(&self.model.reference_window(job)?)?),
            _ => None,
        };
        let encoded = move |field: &ReflectanceField| Streamed::made(field, format, scale.as_ref(), job);
        let head = target.laid(encoded(&self.model.texel()?)?)?;
        let stored = head.lanes().iter().map(|lane| lane.bytes_per_texel).sum();
        let cost = Cost { stored, made: self.model.bytes_per_texel() };
        let cut = BandLayout::new(&window, CELL, target.tile, cost, job)?;
        let make = move |part: &PlaneWindow| encoded(&self.part(part, job)?);
        let mut bands = RowBands::new(window, cut, Box::new(make));
        let rows = move |lane: usize, x: usize, y: usize, row: &mut [u8]| bands.row(lane, x, y, row);
        Ok(Drawing::of_rows(Arc::new(head), window.size, job, Box::new(rows)))
    }
}
