//! Neighbourhoods as vectors: the causal half of a window at one level, and 3 x 3 texels around the
//! parent at the next coarser one.

use super::super::lattice::Lattice;
use super::super::pyramid::Level;
use super::super::vectors::{Vectors, padded};
use crate::error::{Error, Result};
use crate::limits::Limits;
use crate::synthesis::positions::Positions;
use crate::synthesis::quantise::IndexTexels;
use crate::synthesis::source_map::Texel;

/// Which texels are compared, as offsets in columns and rows.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Neighbourhood {
    window: usize,
    causal: Vec<(isize, isize)>,
    coarser: Vec<(isize, isize)>,
}

impl Neighbourhood {
    /// The causal half of a window, and the parent's surroundings where there is a parent.
    pub fn new(window: usize, has_parent: bool) -> Self {
        let square =
            |radius: isize| (-radius..=radius).flat_map(move |y| (-radius..=radius).map(move |x| (x, y)));
        let radius = (window / 2).cast_signed();
        let causal = square(radius).take_while(|offset| *offset != (0, 0)).collect();
        let coarser = if has_parent { square(1).collect() } else { Vec::new() };
        Self { window, causal, coarser }
    }

    /// The number of texels compared.
    fn texels(&self) -> usize {
        self.causal.len() + self.coarser.len()
    }

    /// The vector of an output texel, on tori.
    pub fn of_output(&self, lattice: &Lattice, coarser: Option<&Lattice>, texel: usize) -> Vec<i16> {
        let planes = lattice.codes(texel).len();
        let mut vector = Vec::with_capacity(padded(self.texels() * planes));
        let (x, y) = lattice.place(texel);
        append(&mut vector, lattice, (x, y), &self.causal);
        if let Some(coarser) = coarser {
            append(&mut vector, coarser, (x / 2, y / 2), &self.coarser);
        }
        vector.resize(padded(vector.len()), 0);
        vector
    }

    /// The vector of an exemplar texel whose window lies inside, none where the parent's does not.
    fn of_exemplar(
        &self,
        level: &IndexTexels,
        coarser: Option<&IndexTexels>,
        (x, y): (usize, usize),
    ) -> Option<Vec<i16>> {
        let mut vector = Vec::new();
        for (texels, (x, y), offsets) in
            [(Some(level), (x, y), &self.causal), (coarser, (x / 2, y / 2), &self.coarser)]
        {
            let Some(texels) = texels else { continue };
            for &(dx, dy) in offsets {
                let x = x.checked_add_signed(dx).filter(|&x| x < texels.size().width)?;
                let y = y.checked_add_signed(dy).filter(|&y| y < texels.size().height)?;
                vector.extend_from_slice(texels.run(x, y, 1));
            }
        }
        Some(vector)
    }
}

/// Appends the codes around a place of a torus.
fn append(vector: &mut Vec<i16>, lattice: &Lattice, place: (usize, usize), offsets: &[(isize, isize)]) {
    for &(dx, dy) in offsets {
        let there = lattice.beside(place, dx, dy).expect("a torus has no edge");
        vector.extend_from_slice(lattice.codes(there));
    }
}

/// All neighbourhoods of the exemplars at one level.
#[derive(Debug)]
pub struct Samples {
    /// The vectors.
    pub vectors: Vectors,
    /// The texels around which they lie.
    pub places: Vec<Texel>,
}

impl Samples {
    /// The neighbourhoods of the texels whose windows lie inside and hold nothing excluded, at this
    /// level and the coarser one.
    ///
    /// # Errors
    /// When there is none, or the limits are exceeded.
    pub fn new(
        neighbourhood: &Neighbourhood,
        level: &Level,
        coarser: Option<&Level>,
        limits: &Limits,
    ) -> Result<Self> {
        let radius = neighbourhood.window / 2;
        let positions = level.positions(neighbourhood.window)?;
        let length = neighbourhood.texels() * level.exemplars.planes();
        let bytes = positions.count() * (padded(length) * size_of::<i16>() + size_of::<Texel>());
        limits.check_bytes("the neighbourhoods of the exemplars and their tree", 3 * bytes as u64)?;
        let parents = coarser.map(|level| level.positions(3)).transpose()?;
        let mut samples =
            Self { vectors: Vectors::with_capacity(length, positions.count()), places: Vec::new() };
        for run in positions.runs() {
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

    fn push(&mut self, neighbourhood: &Neighbourhood, level: &Level, coarser: Option<&Level>, place: Texel) {
        let exemplar = place.exemplar as usize;
        let texels = &level.exemplars.texels()[exemplar];
        let coarser = coarser.map(|level| &level.exemplars.texels()[exemplar]);
        let at = (place.x as usize, place.y as usize);
        if let Some(vector) = neighbourhood.of_exemplar(texels, coarser, at) {
            self.vectors.push(&vector);
            self.places.push(place);
        }
    }
}
