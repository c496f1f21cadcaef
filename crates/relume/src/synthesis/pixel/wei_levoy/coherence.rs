//! The search among few candidates: Ashikhmin, "Synthesizing Natural Textures", I3D 2001; Tong, Zhang,
//! Liu, Wang, Guo, Shum, "Synthesis of Bidirectional Texture Functions on Arbitrary Surfaces", SIGGRAPH
//! 2002 (k-coherence).
//!
//! A texel continues one of the pieces around it: each known neighbour, and the parent at the coarser level,
//! proposes the exemplar texel that would continue it. Candidates are those and, for each, the exemplar
//! texels with the most similar neighbourhoods, which are precomputed among all, or among those of its leaf
//! in a tree. With one candidate for each (Ashikhmin) nothing is precomputed.
//!
//! Where all pieces end at the edges of the exemplars, some texels drawn at random are compared.

use super::super::canvas::PixelCanvas;
use super::super::tsvq::Tsvq;
use super::super::vectors::{Vectors, squared_distance};
use super::neighbourhood::ScanSamples;
use crate::error::Result;
use crate::job::Job;
use crate::numeric::random::{Purpose, Stream};
use crate::parallel;
use crate::size::Size;
use crate::synthesis::source_map::Texel;

/// The number of texels drawn where no piece continues.
const DRAWN: usize = 64;

/// Marks exemplar texels without a neighbourhood.
const NONE: u32 = u32::MAX;

/// Candidates for every neighbourhood of the exemplars at one level.
#[derive(Debug)]
pub struct Coherence<'a> {
    samples: &'a ScanSamples,
    /// The offsets of the known neighbours.
    causal: &'a [(isize, isize)],
    /// The number of candidates of each neighbourhood.
    count: usize,
    /// For each neighbourhood, its own number and those of the nearest others; short sets end in `NONE`.
    sets: Vec<u32>,
    /// The size of each exemplar, and the number of each of its texels.
    numbers: Vec<(Size, Vec<u32>)>,
    draws: Draws,
}

/// The inputs of random draws at one level, besides the texel.
#[derive(Debug, Clone, Copy)]
pub struct Draws {
    /// The seed of the output.
    pub seed: u64,
    /// The number of the level, 0 the finest.
    pub level: u64,
}

/// The current state of the output.
#[derive(Debug, Clone, Copy)]
pub struct Here<'a> {
    /// The output at this level.
    pub canvas: &'a PixelCanvas,
    /// The output at the coarser level.
    pub coarser: Option<&'a PixelCanvas>,
    /// The texel to make.
    pub texel: usize,
}

impl<'a> Coherence<'a> {
    /// Candidates for samples of exemplars of the given sizes: `count` for each, found in the leaves of a
    /// tree of `codewords` leaves, or among all if that is 0.
    ///
    /// # Errors
    /// When that exceeds the limits.
    pub fn new(
        samples: &'a ScanSamples,
        causal: &'a [(isize, isize)],
        sizes: &[Size],
        (count, codewords): (usize, usize),
        draws: Draws,
        job: &Job,
    ) -> Result<Self> {
        let texels: usize = sizes.iter().map(|size| size.texels()).sum();
        let bytes = 4 * (texels as u64 + count as u64 * samples.places.len() as u64);
        job.check_bytes("the candidates of the exemplars' neighbourhoods", bytes)?;
        let mut numbers: Vec<(Size, Vec<u32>)> = sizes.iter().map(|s| (*s, vec![NONE; s.texels()])).collect();
        for (number, place) in samples.places.iter().enumerate() {
            let (size, numbers) = &mut numbers[place.exemplar as usize];
            numbers[size.index(place.x as usize, place.y as usize)] = number as u32;
        }
        let sets = sets(&samples.vectors, count, codewords, job)?;
        Ok(Self { samples, causal, count, sets, numbers, draws })
    }

    /// Memory besides the samples.
    pub fn bytes(&self) -> u64 {
        let numbers: usize = self.numbers.iter().map(|(_, numbers)| size_of_val(&**numbers)).sum();
        (size_of_val(&*self.sets) + numbers) as u64
    }

    /// The number of the nearest candidate, the first among equals, and its squared distance.
    pub fn near(&self, query: &[i16], here: Here<'_>) -> (usize, u64) {
        let mut candidates: Vec<u32> = self.continued(here).collect();
        candidates.sort_unstable();
        candidates.dedup();
        if candidates.is_empty() {
            let Draws { seed, level } = self.draws;
            let mut stream = Stream::new(seed, Purpose::ScanlineCandidates, [level, here.texel as u64]);
            candidates.extend((0..DRAWN).map(|_| stream.below(self.samples.places.len()) as u32));
        }
        let distance = |&number: &u32| {
            (squared_distance(query, self.samples.vectors.row(number as usize)), number as usize)
        };
        let (distance, number) = candidates.iter().map(distance).min().expect("there is a candidate");
        (number, distance)
    }

    /// The candidates of all continuations of a neighbour or the parent, with possible repetitions.
    fn continued(&self, here: Here<'_>) -> impl Iterator<Item = u32> {
        let (x, y) = here.canvas.place(here.texel);
        let neighbours = self.causal.iter().filter_map(move |&(dx, dy)| {
            let there = here.canvas.beside((x, y), dx, dy)?;
            here.canvas.source(there).moved(-dx, -dy)
        });
        let parent = here.coarser.map(|coarser| {
            let source = coarser.source(coarser.size().index(x / 2, y / 2));
            Texel { x: 2 * source.x, y: 2 * source.y, ..source }.offset(x % 2, y % 2)
        });
        let continuations = neighbours.chain(parent).filter_map(|place| self.number(place));
        continuations.flat_map(|number| self.set(number)).filter(|number| *number != NONE)
    }

    fn set(&self, number: u32) -> impl Iterator<Item = u32> {
        self.sets[number as usize * self.count..][..self.count].iter().copied()
    }

    fn number(&self, place: Texel) -> Option<u32> {
        let (size, numbers) = &self.numbers[place.exemplar as usize];
        let (x, y) = (place.x as usize, place.y as usize);
        let inside = x < size.width && y < size.height;
        Some(*numbers.get(size.index(x, y)).filter(|_| inside)?).filter(|number| *number != NONE)
    }
}

/// For each vector its own number and those of the `count - 1` nearest others.
fn sets(vectors: &Vectors, count: usize, codewords: usize, job: &Job) -> Result<Vec<u32>> {
    let all = || (0..vectors.count()).collect();
    let leaves: Vec<Vec<usize>> = match (count, codewords) {
        (1, _) => return Ok((0..vectors.count() as u32).collect()),
        (_, 0) => vec![all()],
        _ => {
            job.check_bytes("the tree of the neighbourhoods", Tsvq::bytes(vectors, codewords))?;
            Tsvq::new(vectors, codewords, job)?.leaves()
        }
    };
    let mut sets = vec![NONE; vectors.count() * count];
    for leaf in &leaves {
        let near = |&n: &usize| {
            job.proceed()?;
            Ok(nearest(vectors, leaf, n, count))
        };
        let found: Vec<Vec<u32>> = parallel::try_map(leaf.iter(), near)?;
        for (&number, found) in leaf.iter().zip(found) {
            sets[number * count..][..found.len()].copy_from_slice(&found);
        }
    }
    // Of equal vectors a leaf keeps one: the others have only themselves.
    sets.chunks_exact_mut(count).enumerate().for_each(|(n, set)| set[0] = n as u32);
    Ok(sets)
}

/// The numbers of the vectors of a leaf nearest to one of them, itself first.
fn nearest(vectors: &Vectors, leaf: &[usize], number: usize, count: usize) -> Vec<u32> {
    let others = leaf.iter().filter(|&&other| other != number);
    let mut near: Vec<(u64, u32)> = others
        .map(|&other| (squared_distance(vectors.row(number), vectors.row(other)), other as u32))
        .collect();
    if near.len() >= count {
        near.select_nth_unstable(count - 1);
        near.truncate(count - 1);
    }
    near.sort_unstable();
    std::iter::once(number as u32).chain(near.into_iter().map(|(_, other)| other)).collect()
}
