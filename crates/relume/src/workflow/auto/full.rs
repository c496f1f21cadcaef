//! The texture at the full size.
//!
//! What a trial shows need not hold at the full size: a piece grows into a verbatim copy, or blocks run into a part of
//! the exemplar that repeats. So the texture is measured again, as long as that does not cost much more than making it;
//! where it is a copy, or farther from the exemplar than its halves are from each other, the next best ways are taken
//! as well, and the nearest is kept.

use std::cmp::Ordering;

use super::{Exemplars, Numbered, Score, Try, largest_piece, score};
use crate::error::{Error, Result};
use crate::job::Job;
use crate::metric::texture::Reference;
use crate::size::Size;
use crate::synthesis::SourceMap;

/// The most textures of the full size.
const MOST: usize = 4;
/// Textures of more texels, in those of a trial, are only looked through for copies.
const MEASURED: usize = 4;
/// The distance up to which no further texture is made: that of the halves of the exemplar.
const NEAR: f64 = 1.0;

/// Whether textures of a size are measured again.
pub fn is_measured(size: Size, trial: Size) -> bool {
    size.texels() <= MEASURED * trial.texels()
}

/// The nearest of the best tries at the full size, and the number of that try.
pub fn make(
    tries: &mut [Try],
    trial: Size,
    references: &[Reference],
    exemplars: &Exemplars<'_>,
    job: &Job,
) -> Result<Numbered> {
    let mut best: Option<(Score, Numbered)> = None;
    let mut reason = None;
    for number in order(tries) {
        if tries.iter().filter(|one| one.full.is_some()).count() == MOST {
            break;
        }
        match tries[number].plan.run(exemplars.planes, job) {
            Ok(made) => {
                let score = measured(&made.map, trial, references, exemplars, job)?;
                tries[number].full = Some(score);
                if best.as_ref().is_none_or(|(least, _)| score.is_better_than(least)) {
                    best = Some((score, (number, made)));
                }
                if is_near(&score) {
                    break;
                }
            }
            Err(error) => reason = reason.or(Some(error)),
        }
        job.proceed()?;
    }
    // Nothing was made: report the first error.
    let reason = reason.or_else(|| tries.iter().find_map(|one| one.outcome.as_ref().err().cloned()));
    let reason = reason.unwrap_or_else(|| Error::usage("there was nothing to try"));
    best.map(|(_, made)| made).ok_or(reason)
}

/// The numbers of the tries that succeeded, the best first; of equals the first.
fn order(tries: &[Try]) -> Vec<usize> {
    let scores = tries.iter().enumerate();
    let mut order: Vec<(usize, Score)> =
        scores.filter_map(|(number, one)| Some((number, *one.outcome.as_ref().ok()?))).collect();
    order.sort_by(|(_, a), (_, b)| a.key().partial_cmp(&b.key()).unwrap_or(Ordering::Equal));
    order.into_iter().map(|(number, _)| number).collect()
}

fn measured(
    map: &SourceMap,
    trial: Size,
    references: &[Reference],
    exemplars: &Exemplars<'_>,
    job: &Job,
) -> Result<Score> {
    match is_measured(map.size(), trial) {
        true => score(map, references, exemplars, job),
        false => Ok(Score { appearance: None, largest_piece: Some(largest_piece(map)?) }),
    }
}

fn is_near(score: &Score) -> bool {
    !score.is_copy() && score.appearance.is_none_or(|appearance| appearance.distance <= NEAR)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::metric::texture::Appearance;
    use crate::numeric::random::{Purpose, Stream};
    use crate::planes::Planes;
    use crate::synthesis::{BlockOptions, Exemplar};
    use crate::workflow::Plan;

    fn tried(block: usize, size: Size, distance: f64) -> Try {
        let options = BlockOptions { size, block, overlap: block / 6, ..BlockOptions::default() };
        let [patches, colours, detail, direction, order, repetition] = [distance; 6];
        let appearance = Appearance { distance, patches, colours, detail, direction, order, repetition };
        let score = Score { appearance: Some(appearance), largest_piece: Some(0.1) };
        Try { plan: Plan::Quilting(options), outcome: Ok(score), full: None, seconds: 0.0 }
    }

    /// A former fault: what was no copy at the size of the trial was kept as a copy at the full size.
    #[test]
    fn a_copy_at_the_full_size_gives_way_to_the_next_best() {
        let mut random = Stream::new(3, Purpose::Sample, [0]);
        let own = Size::new(48, 48);
        let data = (0..own.texels()).map(|_| random.unit() as f32).collect();
        let index = Planes::from_vec(own, 1, data).unwrap();
        let planes = [Exemplar { index: &index, excluded: None }];
        let (exemplars, job) = (Exemplars { planes: &planes, files: &[] }, Job::default());
        let references = [Reference::new(&index, 1, &job).unwrap()];
        let size = Size::new(80, 80);
        let mut tries = vec![tried(12, size, 0.9), tried(46, size, 0.1)];
        let (kept, made) = make(&mut tries, own, &references, &exemplars, &job).unwrap();
        assert_eq!((kept, made.map.size()), (0, size));
        let pieces: Vec<bool> = tries.iter().map(|one| one.full.unwrap().is_copy()).collect();
        assert_eq!(pieces, [false, true]);
    }
}
