//! Lights and views left out of a fit, to measure how well the functions are interpolated.

use std::cmp::Ordering;

use crate::direction::{Direction, Directions};
use crate::error::{Error, Result};
use crate::words::counted;

/// The most distinct lights, and views, of which some can be left out; directions within this cosine are one.
const SAME_COSINE: f64 = 1.0 - 1e-9;

/// Which pairs take part in a fit.
#[derive(Debug)]
pub(super) struct HeldOut {
    all: Vec<Directions>,
    out: Vec<bool>,
}

impl HeldOut {
    /// Leaves out every `step`-th light and every `step`-th view, in the order of their polar angles and azimuths:
    /// a pair with either.
    ///
    /// # Errors
    /// When no pair is left.
    pub fn new(pairs: &[Directions], step: Option<usize>) -> Result<Self> {
        if pairs.is_empty() {
            return Err(Error::usage("a fit needs at least one photograph, found none"));
        }
        let mut out = vec![false; pairs.len()];
        if let Some(step) = step {
            let lights = sorted(pairs.iter().map(|pair| pair.light));
            let views = sorted(pairs.iter().map(|pair| pair.view));
            let is_out = |sorted: &[Direction], direction| place(sorted, direction) % step == step - 1;
            for (out, pair) in out.iter_mut().zip(pairs) {
                *out = is_out(&lights, pair.light) || is_out(&views, pair.view);
            }
            if !out.contains(&true) {
                return Err(Error::usage(format!(
                    "of {} and {} each {step}th is none: leave out each {}th at most to measure anything",
                    counted(lights.len(), "light"),
                    counted(views.len(), "view"),
                    lights.len().max(views.len())
                )));
            }
        }
        if out.iter().all(|out| *out) {
            return Err(Error::usage(format!(
                "of {} pairs of light and view none is left for the fit: leave out fewer",
                pairs.len()
            )));
        }
        Ok(Self { all: pairs.to_vec(), out })
    }

    /// Whether a pair is left out.
    pub fn is_out(&self, pair: usize) -> bool {
        self.out[pair]
    }

    /// For each pair its place among those that take part.
    pub fn places(&self) -> Vec<Option<usize>> {
        let mut next = 0..;
        self.out.iter().map(|out| if *out { None } else { next.next() }).collect()
    }

    /// The number of pairs that take part.
    pub fn kept(&self) -> usize {
        self.out.iter().filter(|out| !**out).count()
    }

    /// The pairs that take part, in order.
    pub fn pairs(&self) -> Vec<Directions> {
        let kept = self.all.iter().zip(&self.out).filter(|(_, out)| !**out);
        kept.map(|(pair, _)| *pair).collect()
    }
}

/// The distinct directions, by polar angle and then azimuth.
pub(super) fn sorted(directions: impl Iterator<Item = Direction>) -> Vec<Direction> {
    let mut all: Vec<Direction> = directions.collect();
    all.sort_by(|a, b| order(*a, *b));
    all.dedup_by(|a, b| a.dot(*b) > SAME_COSINE);
    all
}

/// The index of the nearest of some directions.
pub(super) fn place(directions: &[Direction], direction: Direction) -> usize {
    let nearer = |best: (usize, f64), (i, d): (usize, &Direction)| {
        let cosine = d.dot(direction);
        if cosine > best.1 { (i, cosine) } else { best }
    };
    directions.iter().enumerate().fold((0, f64::NEG_INFINITY), nearer).0
}

/// Angles rounded to a millionth of a radian, so that rings of equal polar angles stay together.
fn order(a: Direction, b: Direction) -> Ordering {
    let key = |d: Direction| {
        let rounded = |angle: f64| (angle * 1e6).round() as i64;
        (rounded(d.polar_rad()), rounded(d.azimuth_rad()))
    };
    key(a).cmp(&key(b))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pairs_with_a_light_or_view_left_out_take_no_part() {
        let ring = |i: usize| Direction::from_angles(0.5, i as f64);
        let pairs: Vec<Directions> =
            (0..6).flat_map(|v| (0..6).map(move |l| Directions { light: ring(l), view: ring(v) })).collect();
        let all = HeldOut::new(&pairs, None).unwrap();
        assert_eq!((all.kept(), all.pairs()), (36, pairs.clone()));
        let third = HeldOut::new(&pairs, Some(3)).unwrap();
        // Lights and views 2 and 5 are left out.
        assert_eq!(third.kept(), 16);
        assert!(third.is_out(2) && third.is_out(12) && !third.is_out(0) && !third.is_out(7));
        let one = [pairs[0]];
        let error = HeldOut::new(&one, Some(2)).unwrap_err();
        assert!(error.to_string().contains("1 light and 1 view"), "{error}");
        assert!(HeldOut::new(&pairs, Some(6)).is_ok());
        let error = HeldOut::new(&pairs, Some(7)).unwrap_err();
        assert!(error.to_string().contains("6 lights and 6 views"), "{error}");
        let error = HeldOut::new(&[pairs[1]], Some(1)).unwrap_err();
        assert!(error.to_string().contains("none is left"), "{error}");
    }
}
