//! The structure of a model: how its tiles are made, and of how many bytes.

use super::model::{FittedModel, ModelRequest, PICTURE_BYTES, StructureSource};
use crate::error::{ErrorKind, Result};
use crate::field::{Domain, IndexSpace, Metric, ReflectanceField};
use crate::format::rlm;
use crate::job::Job;
use crate::numeric::lattice::Lattice;
use crate::numeric::periods::{self, Pattern};
use crate::planes::Planes;
use crate::random_field::{Budget, Tiles, combine_field};
use crate::rect::Rect;
use crate::size::Size;
use crate::synthesis::roller::{RollerOptions, roll};
use crate::synthesis::{BlockOptions, Boundary, Exemplar, SourceMap, gather, synthesize};

/// The bytes of a structure that keeps a model to [`PICTURE_BYTES`]: at least, and at most.
const SMALL_STRUCTURE: [usize; 2] = [400, 1400];

/// The periods along a side of the tile of such a structure.
const FEW_PERIODS: f64 = 2.0;

/// Tiles of a texture for a structure.
struct StructureTiles {
    map: SourceMap,
    source: StructureSource,
    /// What the map copies from.
    texels: ReflectanceField,
}

impl ModelRequest {
    /// Structure and detail of a material that repeats, or that is to be modelled so.
    pub(super) fn combined(&self, field: &ReflectanceField, job: &Job) -> Result<FittedModel> {
        let space = index_space(field)?;
        // What follows the search for tiles.
        job.check_bytes("the planes to model", self.options.bytes(field.size(), space.planes()))?;
        let index = space.index_planes_within(field, job, "the index of the exemplar")?;
        let (map, source) = self.tiles(&index, job)?;
        let bytes = self.structure_bytes.unwrap_or_else(|| general_bytes(&space));
        self.with_structure(field, &StructureTiles { map, source, texels: field.clone() }, bytes, job)
    }

    /// Structure and detail of a picture that repeats, in [`PICTURE_BYTES`]: a tile of two periods, from the middle. `None`
    /// for other textures, for requests that ask for other tiles or bytes, and where there is no such tile.
    pub(super) fn combined_of_few_periods(
        &self,
        field: &ReflectanceField,
        job: &Job,
    ) -> Result<Option<FittedModel>> {
        if self.structure_bytes.is_some() || self.tiles > 1 || field.basis().len() > 1 {
            return Ok(None);
        }
        let space = index_space(field)?;
        let index = space.index_planes_within(field, job, "the index of the exemplar")?;
        let Pattern::Lattice(lattice) = periods::of(&index, job)?.pattern else { return Ok(None) };
        let part = few_periods(&lattice, field.size());
        if part.size == field.size() {
            return Ok(None);
        }
        let crop = |planes: &Planes| planes.crop(part.x as usize, part.y as usize, part.size);
        let exemplar = Exemplar { index: &crop(&index)?, excluded: None };
        let options = RollerOptions { pattern: Some(Pattern::Lattice(lattice)), ..RollerOptions::default() };
        let rolled = match roll(&exemplar, &options, job) {
            Err(error) if error.kind() == ErrorKind::Usage => return Ok(None),
            rolled => rolled?,
        };
        let source = StructureSource::Roller { count: 1, tile: rolled.tiles.tile() };
        let texels = field.with_coefficients(crop(field.coefficients())?)?;
        let tiles = StructureTiles { map: rolled.tiles.map().clone(), source, texels };
        let [_, most] = SMALL_STRUCTURE;
        self.within_picture_bytes(field, &tiles, most, job).map(Some)
    }

    /// Structure and detail of a material without periods: a picture in [`PICTURE_BYTES`], measured by the
    /// plain model.
    pub(super) fn combined_within(
        &self,
        field: &ReflectanceField,
        plain: &FittedModel,
        job: &Job,
    ) -> Result<FittedModel> {
        let space = index_space(field)?;
        let index = space.index_planes_within(field, job, "the index of the exemplar")?;
        let (map, block) = block_tile(Exemplar { index: &index, excluded: None }, job)?;
        let source = StructureSource::Blocks { tile: index.size(), block };
        let tiles = StructureTiles { map, source, texels: field.clone() };
        if let Some(bytes) = self.structure_bytes {
            return self.with_structure(field, &tiles, bytes, job);
        }
        if field.basis().len() > 1 {
            return self.with_structure(field, &tiles, general_bytes(&space), job);
        }
        let [least, most] = SMALL_STRUCTURE;
        let left = PICTURE_BYTES.saturating_sub(rlm::encode(&plain.model)?.len());
        self.within_picture_bytes(field, &tiles, left.clamp(least, most), job)
    }

    /// Structure and detail, the structure of so many bytes, or as many fewer as keep the model to [`PICTURE_BYTES`].
    fn within_picture_bytes(
        &self,
        field: &ReflectanceField,
        tiles: &StructureTiles,
        bytes: usize,
        job: &Job,
    ) -> Result<FittedModel> {
        let fitted = self.with_structure(field, tiles, bytes, job)?;
        let over = rlm::encode(&fitted.model)?.len().saturating_sub(PICTURE_BYTES);
        if over == 0 {
            return Ok(fitted);
        }
        let [least, _] = SMALL_STRUCTURE;
        let fewer = bytes.saturating_sub(over + over / 8 + 8).max(least / 2);
        self.with_structure(field, tiles, fewer, job)
    }

    fn with_structure(
        &self,
        field: &ReflectanceField,
        tiles: &StructureTiles,
        bytes: usize,
        job: &Job,
    ) -> Result<FittedModel> {
        let texels = gather(&tiles.map, &[&tiles.texels], job)?;
        let laid = Tiles { texels: &texels, size: tiles.source.tile() };
        let budget = Budget { bytes, cost: &rlm::structure_bytes };
        let (model, levels) = combine_field(field, laid, &budget, &self.options, job)?;
        Ok(FittedModel { model, levels: vec![levels], structure: Some(tiles.source), likeness: None })
    }

    /// Tiles by the Roller, or, where their seams would show, one synthesised from blocks on a torus.
    fn tiles(&self, index: &Planes, job: &Job) -> Result<(SourceMap, StructureSource)> {
        let exemplar = Exemplar { index, excluded: None };
        let pattern = self.period.map(Pattern::Lattice);
        let options = RollerOptions { tiles: self.tiles, pattern, ..RollerOptions::default() };
        let rolled = roll(&exemplar, &options, job)?;
        if rolled.report.is_acceptable() || self.tiles > 1 || pattern.is_some() {
            let (tile, count) = (rolled.tiles.tile(), rolled.tiles.count());
            return Ok((rolled.tiles.map().clone(), StructureSource::Roller { count, tile }));
        }
        let (map, block) = block_tile(exemplar, job)?;
        Ok((map, StructureSource::Blocks { tile: index.size(), block }))
    }
}

/// The most bytes of a structure in general.
fn general_bytes(space: &IndexSpace) -> usize {
    3000 + 900 * space.planes()
}

/// A tile as large as the exemplar, of blocks of a quarter of its side on a torus, and that side.
fn block_tile(exemplar: Exemplar<'_>, job: &Job) -> Result<(SourceMap, usize)> {
    let size = exemplar.index.size();
    let block = (size.width.min(size.height) / 4).max(8);
    let options = BlockOptions {
        size,
        block,
        overlap: BlockOptions::customary_overlap(block),
        boundary: Boundary::Torus,
        ..BlockOptions::default()
    };
    Ok((synthesize(&[exemplar], &options, job)?.map, block))
}

/// The space in which tiles are compared.
fn index_space(field: &ReflectanceField) -> Result<IndexSpace> {
    IndexSpace::new(field, Metric::Function, Domain::Hemisphere)
}

/// The middle of a texture, as large as a tile of two cells of its lattice and its overlap need.
fn few_periods(lattice: &Lattice, size: Size) -> Rect {
    let [a, b] = lattice.basis();
    let side = |axis: usize, whole: usize| {
        let tile = FEW_PERIODS * (a[axis].abs() + b[axis].abs());
        // The overlap is a sixteenth of the smaller side.
        ((tile * 17.0 / 16.0).ceil() as usize + 2).min(whole)
    };
    let part = Size::new(side(0, size.width), side(1, size.height));
    let at = |whole: usize, part: usize| ((whole - part) / 2) as i64;
    Rect::new(at(size.width, part.width), at(size.height, part.height), part)
}
