//! Where the joints are, and the outline along them.
//!
//! Joints look alike everywhere, and elements do not. So the variance over the copies of a place is small in joints;
//! but of two or three copies it is small by chance elsewhere too. And all joints have one colour: the distance from
//! it needs no copies, but the colour is not known. Each of these is a height of the ground on which the outline is
//! the lowest line: the variance, and the distance from several colours of places of small variance. The outline is
//! taken that lies the lowest relative to its own ground.

use super::agreement::{CellGrid, PlaceCopies};
use super::outline::{Outline, along_joints};
use crate::error::Result;
use crate::job::Job;

/// The part of the places, those of the least variance, whose colours may be that of joints.
const ALIKE: usize = 4;
/// The most places examined for colours.
const EXAMINED: usize = 512;
/// The number of colours tried.
const COLOURS: usize = 6;

/// An outline with the height of the ground at each place.
#[derive(Debug, Clone, PartialEq)]
pub struct GroundedOutline {
    /// The outline.
    pub outline: Outline,
    /// How unlike a joint each place is.
    pub height: Vec<f64>,
    /// The mean height along the outline as a fraction of the mean of all places.
    pub contrast: f64,
}

impl GroundedOutline {
    fn new(grid: &CellGrid, height: Vec<f64>) -> Self {
        let outline = along_joints(grid, &height);
        let contrast = outline.joint_contrast(grid, &height);
        Self { outline, height, contrast }
    }
}

/// The outline along the joints.
///
/// # Errors
/// When the job is cancelled.
pub fn lowest(copies: &PlaceCopies<'_>, grid: &CellGrid, job: &Job) -> Result<GroundedOutline> {
    let variance = copies.variance();
    let colours = colours(copies, &variance);
    let mut lowest = GroundedOutline::new(grid, variance);
    for colour in &colours {
        job.proceed()?;
        let other = GroundedOutline::new(grid, copies.distance_from(colour));
        if other.contrast < lowest.contrast {
            lowest = other;
        }
    }
    Ok(lowest)
}

/// Colours of places of small variance that differ as much as possible: each is the farthest from those before it
/// (T. F. Gonzalez, Clustering to minimize the maximum intercluster distance, 1985), the first that of the least
/// variance.
fn colours(copies: &PlaceCopies<'_>, variance: &[f64]) -> Vec<Vec<f64>> {
    let mut places: Vec<usize> = (0..variance.len()).collect();
    places.sort_by(|&a, &b| variance[a].total_cmp(&variance[b]).then(a.cmp(&b)));
    places.truncate(variance.len().div_ceil(ALIKE));
    let step = places.len().div_ceil(EXAMINED);
    let examined = places.into_iter().step_by(step.max(1));
    let all: Vec<Vec<f64>> = examined.filter_map(|place| Some(copies.moments(place)?.means)).collect();
    let distance = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(p, q)| (p - q).powi(2)).sum::<f64>();
    let mut chosen: Vec<Vec<f64>> = all.first().cloned().into_iter().collect();
    while !chosen.is_empty() && chosen.len() < COLOURS.min(all.len()) {
        let apart =
            |colour: &Vec<f64>| chosen.iter().map(|c| distance(c, colour)).fold(f64::INFINITY, f64::min);
        let farthest = all.iter().max_by(|a, b| apart(a).total_cmp(&apart(b)));
        let Some(colour) = farthest.filter(|colour| apart(colour) > 0.0).cloned() else { break };
        chosen.push(colour);
    }
    chosen
}
