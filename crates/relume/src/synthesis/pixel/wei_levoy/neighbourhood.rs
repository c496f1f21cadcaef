//! Neighbourhoods as vectors: the causal half of a window at one level, and 3 x 3 texels around the
//! parent at the next coarser one.

use super::super::canvas::PixelCanvas;
use super::super::pyramid::ExemplarLevel;
use super::super::vectors::{Vectors, padded};
use crate::error::{Error, Result};
use crate::job::{Held, Job};
use crate::synthesis::positions::Positions;
use crate::synthesis::quantise::IndexTexels;
use crate::synthesis::source_map::Texel;

/// Consecutive texels of one row: offset in columns and rows of the first, and their number.
type TapRow = ((isize, isize), usize);

/// The compared texels.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct ScanNeighbourhood {
    window: usize,
    causal: Vec<TapRow>,
    coarser: Vec<TapRow>,
    /// The texel itself and the next ones, whose guides are compared.
    ahead: Vec<TapRow>,
    guides: usize,
}

impl ScanNeighbourhood {
    /// The causal half of a window, and the surroundings of the parent if there is one; with guides, also
    /// those of the texel itself and the next ones.
    pub fn new(window: usize, has_parent: bool, guides: usize) -> Self {
        let radius = (window / 2).cast_signed();
        let above = (-radius..0).map(|dy| ((-radius, dy), window));
        let causal = above.chain([((-radius, 0), window / 2)]).collect();
        let coarser = if has_parent { (-1..=1).map(|dy| ((-1, dy), 3)).collect() } else { Vec::new() };
        let ahead = if guides > 0 { vec![((0, 0), 2), ((-1, 1), 3)] } else { Vec::new() };
        Self { window, causal, coarser, ahead, guides }
    }

    /// The offsets of the texels done before a given one.
    pub fn causal(&self) -> Vec<(isize, isize)> {
        let row = |&((dx, dy), length): &TapRow| (dx..dx + length.cast_signed()).map(move |dx| (dx, dy));
        self.causal.iter().flat_map(row).collect()
    }

    /// The number of codes compared, for exemplars of the given number of planes.
    fn codes(&self, planes: usize) -> usize {
        let texels: usize = self.causal.iter().chain(&self.coarser).map(|(_, length)| length).sum();
        let ahead: usize = self.ahead.iter().map(|(_, length)| length).sum();
        texels * planes + ahead * self.guides
    }

    /// Sets `vector` to that of an output texel, on tori.
    pub fn of_output(
        &self,
        canvas: &PixelCanvas,
        coarser: Option<&PixelCanvas>,
        texel: usize,
        vector: &mut Vec<i16>,
    ) {
        vector.clear();
        let (x, y) = canvas.place(texel);
        for &(offset, length) in &self.causal {
            canvas.append_row((x, y), offset, length, vector);
        }
        if let Some(coarser) = coarser {
            for &(offset, length) in &self.coarser {
                coarser.append_row((x / 2, y / 2), offset, length, vector);
            }
        }
        for &((dx, dy), length) in &self.ahead {
            for dx in dx..dx + length.cast_signed() {
                let there = canvas.beside((x, y), dx, dy).expect("a torus has no edge");
                vector.extend_from_slice(canvas.guide_codes(there));
            }
        }
        vector.resize(padded(vector.len()), 0);
    }

    /// The vector of an exemplar texel whose windows lie inside at both levels.
    fn of_exemplar(
        &self,
        level: &IndexTexels,
        coarser: Option<&IndexTexels>,
        (x, y): (usize, usize),
    ) -> Vec<i16> {
        let mut vector = Vec::new();
        let mut append = |texels: &IndexTexels, (x, y): (usize, usize), rows: &[TapRow]| {
            for &((dx, dy), length) in rows {
                let (x, y) = (x.wrapping_add_signed(dx), y.wrapping_add_signed(dy));
                vector.extend_from_slice(texels.run(x, y, length));
            }
        };
        append(level, (x, y), &self.causal);
        coarser.into_iter().for_each(|texels| append(texels, (x / 2, y / 2), &self.coarser));
        for &((dx, dy), length) in &self.ahead {
            let (x, y) = (x.wrapping_add_signed(dx), y.wrapping_add_signed(dy));
            let planes = level.run(x, y, 1).len();
            let texels = level.run(x, y, length).chunks_exact(planes);
            texels.for_each(|texel| vector.extend_from_slice(&texel[planes - self.guides..]));
        }
        vector
    }
}

/// All neighbourhoods of the exemplars at one level.
#[derive(Debug)]
pub struct ScanSamples {
    /// The vectors.
    pub vectors: Vectors,
    /// The texels at their centres.
    pub places: Vec<Texel>,
    _held: Held,
}

impl ScanSamples {
    /// The neighbourhoods of the texels whose windows are inside and contain nothing excluded, at this level
    /// and the coarser one.
    ///
    /// # Errors
    /// When there is none, or the limits are exceeded.
    pub fn new(
        neighbourhood: &ScanNeighbourhood,
        level: &ExemplarLevel,
        coarser: Option<&ExemplarLevel>,
        job: &Job,
    ) -> Result<Self> {
        let radius = neighbourhood.window / 2;
        let positions = level.positions(neighbourhood.window)?;
        let length = neighbourhood.codes(level.exemplars.planes());
        let bytes = positions.count() * (padded(length) * size_of::<i16>() + size_of::<Texel>());
        let held = job.hold("the neighbourhoods of the exemplars", bytes as u64)?;
        let parents = coarser.map(|level| level.positions(3)).transpose()?;
        let vectors = Vectors::with_capacity(length, positions.count());
        let mut samples = Self { vectors, places: Vec::with_capacity(positions.count()), _held: held };
        for run in positions.runs() {
            job.proceed()?;
            for corner in (0..run.length).map(|x| run.first.offset(x, 0)) {
                let place = corner.offset(radius, radius);
                let parent = Texel { x: place.x / 2, y: place.y / 2, ..place }.moved(-1, -1);
                let allowed = |parents: &Positions| parent.is_some_and(|corner| parents.contains(corner));
                if parents.as_ref().is_none_or(allowed) {
                    samples.push(neighbourhood, level, coarser, place);
                }
            }
        }
        if samples.places.is_empty() {
            return Err(Error::usage(
                "the masks leave no neighbourhood at some level: exclude less or choose fewer levels",
            ));
        }
        Ok(samples)
    }

    fn push(
        &mut self,
        neighbourhood: &ScanNeighbourhood,
        level: &ExemplarLevel,
        coarser: Option<&ExemplarLevel>,
        place: Texel,
    ) {
        let exemplar = place.exemplar as usize;
        let texels = &level.exemplars.texels()[exemplar];
        let coarser = coarser.map(|level| &level.exemplars.texels()[exemplar]);
        let at = (place.x as usize, place.y as usize);
        self.vectors.push(&neighbourhood.of_exemplar(texels, coarser, at));
        self.places.push(place);
    }
}
