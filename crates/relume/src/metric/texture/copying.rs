//! How a synthesised texture uses its exemplar: too little of it, or whole pieces repeatedly.
//!
//! - coverage: the share of exemplar texels used at least once;
//! - evenness: 2^H divided by the number of exemplar texels, where H is the entropy in bits of the
//!   distribution of sources (C. Shannon 1948): 1 if all are used equally, 1/n if only one of n is;
//! - the largest number of uses of one texel, and the longest row or column of texels copied verbatim;
//! - pieces: largest and mean number of connected texels copied with one shift; verbatim copying shows as a
//!   piece as large as the exemplar.
//!
//! None of them is good or bad by itself: a regular texture must repeat, and a method that copies single
//! texels has small pieces and may still copy garbage.

use serde::Serialize;

use super::sources::{Source, Sources};
use crate::size::Size;

/// How the exemplar is used.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Copying {
    /// The share of exemplar texels in use.
    pub coverage: f64,
    /// The entropy of the sources in bits.
    pub entropy_bits: f64,
    /// 2^entropy divided by the number of exemplar texels, at most 1.
    pub evenness: f64,
    /// The number of uses of the most used texel.
    pub most_used: u64,
    /// The texels of the longest row or column copied verbatim.
    pub longest_run: usize,
    /// The texels of the largest connected piece copied with one shift.
    pub largest_piece: usize,
    /// The mean number of texels of a piece.
    pub mean_piece: f64,
}

/// Measures how the exemplars are used.
pub fn copying(sources: &Sources<'_>) -> Copying {
    let counts = counts(sources);
    let total = sources.texels().len() as f64;
    let used = counts.iter().filter(|count| **count > 0);
    let entropy_bits = -used.clone().map(|&n| n as f64 / total * (n as f64 / total).log2()).sum::<f64>();
    let pieces = pieces(sources);
    Copying {
        coverage: used.count() as f64 / counts.len() as f64,
        // With only one texel in use: -0 is 0.
        entropy_bits: entropy_bits.max(0.0),
        evenness: (entropy_bits.exp2() / counts.len() as f64).min(1.0),
        most_used: counts.iter().copied().max().unwrap_or(0),
        longest_run: longest_run(sources),
        largest_piece: pieces.iter().copied().max().unwrap_or(0),
        mean_piece: total / pieces.len().max(1) as f64,
    }
}

/// The number of uses of each texel of all exemplars.
fn counts(sources: &Sources<'_>) -> Vec<u64> {
    let mut starts = vec![0];
    sources.exemplars().iter().for_each(|size| starts.push(starts[starts.len() - 1] + size.texels()));
    let mut counts = vec![0; starts[starts.len() - 1]];
    for &Source { exemplar, x, y } in sources.texels() {
        let exemplar = exemplar as usize;
        counts[starts[exemplar] + sources.exemplars()[exemplar].index(x as usize, y as usize)] += 1;
    }
    counts
}

fn longest_run(sources: &Sources<'_>) -> usize {
    let Size { width, height } = sources.size();
    let (mut across, mut down) = (vec![1usize; width * height], vec![1usize; width * height]);
    for (here, there, step) in sources.neighbours() {
        if sources.continues(here, there, step) {
            let runs = if step.0 == 1 { &mut across } else { &mut down };
            runs[there] = runs[here] + 1;
        }
    }
    across.into_iter().chain(down).max().unwrap_or(0)
}

/// The sizes of the connected pieces: neighbours that continue each other are in one piece (union-find, R.
/// Tarjan 1975).
fn pieces(sources: &Sources<'_>) -> Vec<usize> {
    let mut parents: Vec<usize> = (0..sources.texels().len()).collect();
    for (here, there, step) in sources.neighbours() {
        if sources.continues(here, there, step) {
            let (a, b) = (root(&mut parents, here), root(&mut parents, there));
            parents[a.max(b)] = a.min(b);
        }
    }
    let mut sizes = vec![0; parents.len()];
    for texel in 0..parents.len() {
        sizes[root(&mut parents, texel)] += 1;
    }
    sizes.retain(|&size| size > 0);
    sizes
}

fn root(parents: &mut [usize], mut texel: usize) -> usize {
    while parents[texel] != texel {
        parents[texel] = parents[parents[texel]];
        texel = parents[texel];
    }
    texel
}

#[cfg(test)]
mod tests {
    use super::super::seams::seams;
    use super::*;
    use crate::planes::Planes;

    fn source(x: usize, y: usize) -> Source {
        Source { exemplar: 0, x: x as u32, y: y as u32 }
    }

    const EXEMPLAR: [Size; 1] = [Size::new(8, 6)];

    #[test]
    fn a_verbatim_copy_is_one_piece_of_everything() {
        let texels: Vec<Source> = (0..48).map(|i| source(i % 8, i / 8)).collect();
        let found = copying(&Sources::new(EXEMPLAR[0], &texels, &EXEMPLAR).unwrap());
        assert_eq!((found.coverage, found.most_used, found.longest_run), (1.0, 1, 8));
        assert_eq!((found.largest_piece, found.mean_piece), (48, 48.0));
        assert!((found.evenness - 1.0).abs() < 1e-12 && (found.entropy_bits - 48f64.log2()).abs() < 1e-12);
    }

    #[test]
    fn one_texel_everywhere_is_the_least_use_there_is() {
        let texels = vec![source(3, 2); 35];
        let found = copying(&Sources::new(Size::new(7, 5), &texels, &EXEMPLAR).unwrap());
        assert_eq!((found.most_used, found.longest_run, found.largest_piece), (35, 1, 1));
        assert!((found.coverage - 1.0 / 48.0).abs() < 1e-12 && (found.evenness - 1.0 / 48.0).abs() < 1e-12);
        assert_eq!(found.entropy_bits, 0.0);
    }

    #[test]
    fn tiles_have_their_pieces_and_cuts_in_between() {
        // Two tiles of 4 x 6 side by side, twice the left half of the exemplar.
        let texels: Vec<Source> = (0..48).map(|i| source(i % 8 % 4, i / 8)).collect();
        let sources = Sources::new(EXEMPLAR[0], &texels, &EXEMPLAR).unwrap();
        let found = copying(&sources);
        assert_eq!((found.coverage, found.most_used, found.largest_piece), (0.5, 2, 24));
        assert_eq!((found.mean_piece, found.longest_run), (24.0, 6));
        // The value is the column, so that a step inside is 1 along x, 0 along y, and 3 across the cut.
        let planes = Planes::from_vec(EXEMPLAR[0], 1, texels.iter().map(|s| s.x as f32).collect()).unwrap();
        let seams = seams(&planes, &sources).unwrap();
        assert_eq!((seams.cuts, seams.across), (6, 3.0));
        let inside = (36.0 / (36.0 + 40.0f64)).sqrt();
        assert!((seams.inside - inside).abs() < 1e-12 && (seams.ratio - 3.0 / inside).abs() < 1e-12);
    }

    #[test]
    fn sources_outside_the_exemplar_are_refused() {
        let texels = [source(8, 0)];
        let error = Sources::new(Size::new(1, 1), &texels, &EXEMPLAR).unwrap_err();
        assert!(error.message().contains("(8, 0)"), "{error}");
        assert!(Sources::new(Size::new(2, 1), &texels, &EXEMPLAR).is_err());
        let other = [Source { exemplar: 1, x: 0, y: 0 }];
        assert!(Sources::new(Size::new(1, 1), &other, &EXEMPLAR).is_err());
        let sources = [source(0, 0)];
        let sources = Sources::new(Size::new(1, 1), &sources, &EXEMPLAR).unwrap();
        assert!(seams(&Planes::zeros(Size::new(2, 1), 1), &sources).is_err());
    }
}
