//! Windows of the plane of noise from an exemplar.

use std::sync::Arc;

use super::bands::{BandLayout, Cost, RowBands};
use super::{Drawing, FileTarget, PlaneWindow};
use crate::error::Result;
use crate::field::ReflectanceField;
use crate::field::{Domain, IndexSpace, Metric};
use crate::format::{Encoding, FieldFile, FieldFormat, MapRole, PtmEncoding, Streamed};
use crate::job::Job;
use crate::planes::Planes;
use crate::synthesis::noise::{Noise, NoiseOptions};
use crate::workflow::map_set::{is_normal_map, normals_of_slopes, slopes_of_normals};

/// Rows of bands and columns of pieces are multiples of this.
const CELL: usize = 64;

/// The plane of noise from an exemplar.
#[derive(Debug)]
pub struct NoisePlane<'a> {
    file: &'a FieldFile,
    coordinates: NoiseCoordinates,
    noise: Noise,
}

/// What is blended.
#[derive(Debug)]
enum NoiseCoordinates {
    /// Functions, or colours.
    Functions(IndexSpace),
    /// The slopes of normals: blended normals would be too short, and renormalised ones too flat.
    Slopes,
}

impl<'a> NoisePlane<'a> {
    /// Models an exemplar; `role` is what it means.
    ///
    /// # Errors
    /// Options without meaning, an exemplar unsuitable for noise, and limits exceeded.
    pub fn new(file: &'a FieldFile, role: MapRole, options: &NoiseOptions, job: &Job) -> Result<Self> {
        let coordinates = NoiseCoordinates::of(&file.field, role)?;
        let noise = Noise::new(&coordinates.forward(&file.field, job)?, options, job)?;
        Ok(Self { file, coordinates, noise })
    }

    /// The model.
    pub fn noise(&self) -> &Noise {
        &self.noise
    }

    /// A window of the plane, in bands of rows or of the tiles of the file.
    ///
    /// # Errors
    /// A format that cannot hold the functions, and bands beyond the limits.
    pub fn drawing<'b>(
        &'b self,
        window: PlaneWindow,
        target: &FileTarget,
        job: &'b Job,
    ) -> Result<Drawing<'b>> {
        let (field, format) = (&self.file.field, target.format);
        let scale = self.scale(format)?;
        let head = target.laid(Streamed::made(field, format, scale.as_ref(), job)?)?;
        let stored = head.lanes().iter().map(|lane| lane.bytes_per_texel).sum();
        // Index planes twice, and those of the field.
        let made = 4 * (2 * self.coordinates.planes() + field.coefficients().count()) as u64;
        let cut = BandLayout::new(&window, CELL, target.tile, Cost { stored, made }, job)?;
        let make = move |part: &PlaneWindow| {
            let index = self.noise.window(part.x, part.y, part.size, job)?;
            Streamed::made(&self.coordinates.backward(field, &index)?, format, scale.as_ref(), job)
        };
        let mut bands = RowBands::new(window, cut, Box::new(make));
        let rows = move |lane: usize, x: usize, y: usize, row: &mut [u8]| bands.row(lane, x, y, row);
        Ok(Drawing::of_rows(Arc::new(head), window.size, job, Box::new(rows)))
    }

    /// The scale of a `.ptm`: that of the exemplar, or one chosen for it. It is the same for all bands.
    fn scale(&self, format: FieldFormat) -> Result<Option<PtmEncoding>> {
        match (format, self.file.encoding) {
            (FieldFormat::Ptm, Encoding::Ptm(stored)) => Ok(Some(stored)),
            (FieldFormat::Ptm, _) => PtmEncoding::chosen(&self.file.field).map(Some),
            _ => Ok(None),
        }
    }
}

impl NoiseCoordinates {
    fn of(field: &ReflectanceField, role: MapRole) -> Result<Self> {
        match is_normal_map(field, role) {
            true => Ok(Self::Slopes),
            false => IndexSpace::new(field, Metric::Function, Domain::Hemisphere).map(Self::Functions),
        }
    }

    fn planes(&self) -> usize {
        match self {
            Self::Functions(space) => space.planes(),
            Self::Slopes => 2,
        }
    }

    fn forward(&self, field: &ReflectanceField, job: &Job) -> Result<Planes> {
        const WHAT: &str = "the index of the exemplar";
        match self {
            Self::Functions(space) => space.index_planes_within(field, job, WHAT),
            Self::Slopes => slopes_of_normals(field)?.held(job, WHAT),
        }
    }

    fn backward(&self, like: &ReflectanceField, index: &Planes) -> Result<ReflectanceField> {
        match self {
            Self::Functions(space) => space.field(like, index),
            Self::Slopes => normals_of_slopes(like, index),
        }
    }
}
