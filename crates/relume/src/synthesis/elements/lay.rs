//! A texture laid from whole elements, as a source map.

use serde::Serialize;

use super::agreement::{CellGrid, PlaceCopies, texel_at};
use super::arrange::ElementOrder;
use super::joints::{self, GroundedOutline};
use super::options::ElementOptions;
use super::outline::Outline;
use super::whole::elements;
use crate::error::{Error, Result};
use crate::job::Job;
use crate::numeric::lattice::{Lattice, length};
use crate::numeric::periods;
use crate::parallel;
use crate::size::Size;
use crate::synthesis::options::Boundary;
use crate::synthesis::quantise::{Exemplar, Quantised};
use crate::synthesis::source_map::{SourceMap, Texel};

/// How a texture was laid.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct ElementsLaid {
    /// The lattice of the elements.
    pub lattice: Lattice,
    /// The number of different elements.
    pub elements: usize,
    /// How unlike joints the places along the outline are, as a fraction of the mean of all places: near 0 along
    /// joints, near 1 where the material has none.
    pub joint_contrast: f64,
}

impl ElementsLaid {
    /// The contrast above which the outline follows no joints.
    const NO_JOINTS: f64 = 0.5;

    /// Whether the outline runs along joints.
    pub fn has_joints(&self) -> bool {
        self.joint_contrast <= Self::NO_JOINTS
    }
}

/// Working memory for each place of a cell: two outlines with their heights, and the places that wait for the flood.
const OUTLINE_BYTES: u64 = 2 * (16 + 8) + 8 * 48;

/// Lays the whole elements of an exemplar in random order. The result depends on the exemplar and the options
/// only.
///
/// # Errors
/// When the options are invalid, no lattice is found, the exemplar shows no element whole, the output has to
/// tile and is not a whole number of periods, or the limits are exceeded.
pub fn lay(
    exemplar: &Exemplar<'_>,
    options: &ElementOptions,
    job: &Job,
) -> Result<(SourceMap, ElementsLaid)> {
    options.validate()?;
    job.check("the source map", options.size, size_of::<Texel>() as u64)?;
    let quantised = Quantised::new(std::slice::from_ref(exemplar), job)?;
    let _codes = job.hold("the codes of the exemplar", quantised.bytes())?;
    let lattice = lattice(exemplar, options, job)?;
    let (texels, size) = (&quantised.texels()[0], exemplar.index.size());
    job.proceed()?;
    let none_whole = || {
        Error::usage(format!(
            "the exemplar of {size} shows no element whole: give one that holds at least two by two, or crop it \
             along the joints"
        ))
    };
    if lattice.cell_area() > size.texels() as f64 {
        return Err(none_whole());
    }
    let grid = CellGrid::new(lattice);
    job.check("the outline of the elements", grid.size, OUTLINE_BYTES)?;
    let copies = PlaceCopies::new(texels, exemplar.excluded, &grid);
    let GroundedOutline { outline, height, contrast } = joints::lowest(&copies, &grid, job)?;
    if options.lattice.is_none() && contrast > ElementsLaid::NO_JOINTS {
        return Err(Error::usage(
            "the lattice that was measured has no joints to cut along: give the right one, or use another method",
        ));
    }
    let whole = elements(size, exemplar.excluded, &grid, &outline, &height);
    if whole.is_empty() {
        return Err(none_whole());
    }
    let closing = Closing::new(&lattice, options)?;
    let order = ElementOrder::new(
        &grid.cells_over(options.size, outline.reach()),
        whole.len(),
        closing.sides,
        options.seed,
    );
    let made =
        Laying { size, excluded: exemplar.excluded, grid, outline: &outline, whole: &whole, closing, order };
    let copies = made.copies(options, job)?;
    let report = ElementsLaid { lattice, elements: whole.len(), joint_contrast: contrast };
    Ok((SourceMap::new(options.size, std::slice::from_ref(exemplar), copies), report))
}

/// The given lattice, or the one that is measured, certain or not.
fn lattice(exemplar: &Exemplar<'_>, options: &ElementOptions, job: &Job) -> Result<Lattice> {
    if let Some(lattice) = options.lattice {
        return Ok(lattice);
    }
    let found = periods::of(exemplar.index, job)?;
    let lattice = found.likely_lattice().ok_or_else(|| {
        Error::usage("no lattice of elements was found in the exemplar: give a larger one, or another method")
    })?;
    ElementOptions { lattice: Some(lattice), ..options.clone() }.validate()?;
    Ok(lattice)
}

/// How an output closes on itself: the numbers of periods along its sides, and the factors by which positions
/// on it are stretched to hold them.
#[derive(Debug, Clone, Copy)]
struct Closing {
    stretch: [f64; 2],
    sides: Option<[[i64; 2]; 2]>,
}

/// The largest deviation of the sides of a tiling output from whole periods, in texels.
const NEARLY_WHOLE: f64 = 0.75;

impl Closing {
    fn new(lattice: &Lattice, options: &ElementOptions) -> Result<Self> {
        let (w, h) = (options.size.width as f64, options.size.height as f64);
        if options.boundary == Boundary::Open {
            return Ok(Self { stretch: [1.0; 2], sides: None });
        }
        let near = [[w, 0.0], [0.0, h]].map(|side| (lattice.nearest(side), side));
        if near.iter().any(|(point, side)| length([point[0] - side[0], point[1] - side[1]]) > NEARLY_WHOLE) {
            let [[ax, ay], [bx, by]] = lattice.basis();
            return Err(Error::usage(format!(
                "an output of {} texels cannot tile: its sides must be whole periods of ({ax:.2}, {ay:.2}) and \
                 ({bx:.2}, {by:.2}) to {NEARLY_WHOLE} texels",
                options.size
            )));
        }
        let numbers = |point: [f64; 2]| lattice.coordinates(point).map(|c| c.round() as i64);
        let [(right, _), (down, _)] = near;
        let stretch = [right[0] / w, down[1] / h];
        Ok(Self { stretch, sides: Some([numbers(right), numbers(down)]) })
    }
}

struct Laying<'a> {
    size: Size,
    excluded: Option<&'a [bool]>,
    grid: CellGrid,
    outline: &'a Outline,
    whole: &'a [[i64; 2]],
    closing: Closing,
    order: ElementOrder,
}

impl Laying<'_> {
    fn copies(&self, options: &ElementOptions, job: &Job) -> Result<Vec<Texel>> {
        let mut copies = vec![Texel::default(); options.size.texels()];
        parallel::try_for_each(copies.chunks_mut(options.size.width).enumerate(), |(y, row)| {
            job.proceed()?;
            for (x, copy) in row.iter_mut().enumerate() {
                *copy = self.source([x as f64, y as f64]);
            }
            Ok(())
        })?;
        Ok(copies)
    }

    /// The source of a texel of the output.
    fn source(&self, at: [f64; 2]) -> Texel {
        let (cell, place) = self.grid.place([0, 1].map(|k| at[k] * self.closing.stretch[k]));
        let owner = self.outline.owner[place];
        let cell = [cell[0] + owner[0], cell[1] + owner[1]];
        let element = self.whole[self.order.element(cell)];
        let (from, to) = (self.point(element), self.point(cell));
        let there = [0, 1].map(|k| at[k] + (from[k] - to[k] / self.closing.stretch[k]).round());
        self.usable(there).unwrap_or_else(|| self.another(there))
    }

    /// The lattice point of a cell.
    fn point(&self, cell: [i64; 2]) -> [f64; 2] {
        self.grid.lattice.point(cell.map(|c| c as f64))
    }

    fn usable(&self, position: [f64; 2]) -> Option<Texel> {
        let (x, y) = texel_at(self.size, position)?;
        let is_free = self.excluded.is_none_or(|mask| !mask[self.size.index(x, y)]);
        is_free.then_some(Texel { exemplar: 0, y: y as u32, x: x as u32 })
    }

    /// For the remains of a joint outside of the exemplar: the nearest copy of its place inside.
    fn another(&self, there: [f64; 2]) -> Texel {
        let steps = (-2..=2).flat_map(|j: i64| (-2..=2).map(move |i: i64| [i, j]));
        let mut near: Vec<[f64; 2]> = steps.map(|cells| self.point(cells).map(f64::round)).collect();
        near.sort_by(|a, b| length(*a).total_cmp(&length(*b)));
        let copy = |shift: &[f64; 2]| self.usable([there[0] + shift[0], there[1] + shift[1]]);
        let nearest = || {
            let inside = |c: f64, side: usize| c.round().clamp(0.0, side as f64 - 1.0) as u32;
            Texel { exemplar: 0, y: inside(there[1], self.size.height), x: inside(there[0], self.size.width) }
        };
        near.iter().find_map(copy).unwrap_or_else(nearest)
    }
}
