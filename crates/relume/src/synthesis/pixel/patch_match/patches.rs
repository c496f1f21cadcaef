//! The patches of the exemplars at one level, and their distances from patches of the output.
//!
//! The codes are read directly from the exemplars, which fit the caches; a table of patches would not.
//! Distances are exact; they are abandoned as soon as they reach a limit.

use super::super::canvas::PixelCanvas;
use super::super::pyramid::ExemplarLevel;
use super::super::vectors::LANES;
use crate::error::Result;
use crate::job::Job;
use crate::synthesis::positions::Positions;
use crate::synthesis::quantise::{IndexTexels, MAX_CODE};
use crate::synthesis::source_map::Texel;

/// Side of the blocks over which the use of the exemplars is counted.
const BLOCK: usize = 4;

/// Rows between two checks of the limit.
const PATIENCE: usize = 3;

/// Registers of a piece of a row: the squares of `PATIENCE` of them fit 32 bits.
const PIECE: usize = (u32::MAX / (2 * (MAX_CODE as u32).pow(2))) as usize / PATIENCE;

/// A piece of a row of a patch.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
struct Piece {
    /// The row.
    dy: usize,
    /// The first code, relative to that of the row.
    start: usize,
    /// The number of codes.
    length: usize,
}

impl Piece {
    /// The number of codes it occupies in a patch of the output: whole registers.
    fn padded(&self) -> usize {
        self.length.next_multiple_of(LANES)
    }
}

/// One exemplar: possible positions of patches, and its blocks.
#[derive(Debug)]
struct PatchArea {
    /// Whether a patch may begin at each texel.
    allowed: Vec<bool>,
    /// The number of its first block.
    first_block: usize,
    /// Blocks in a row.
    columns: usize,
}

/// The patches of the exemplars at one level, named by their top-left texels.
#[derive(Debug)]
pub struct ExemplarPatches<'a> {
    level: &'a ExemplarLevel,
    window: usize,
    positions: Positions,
    areas: Vec<PatchArea>,
    pieces: Vec<Piece>,
    block_count: usize,
    blocks_in_use: usize,
    reach: usize,
}

impl<'a> ExemplarPatches<'a> {
    /// All patches inside the exemplars without excluded texels.
    ///
    /// # Errors
    /// When there is none, or the limits are exceeded.
    pub fn new(level: &'a ExemplarLevel, window: usize, job: &Job) -> Result<Self> {
        let positions = level.positions(window)?;
        let sizes: Vec<_> = level.exemplars.texels().iter().map(IndexTexels::size).collect();
        let texels = sizes.iter().map(|size| size.texels() as u64).sum();
        job.check_bytes("the places of the exemplars' patches", texels)?;
        let mut block_count = 0;
        let mut area = |size: &crate::size::Size| {
            let (first_block, columns) = (block_count, size.width.div_ceil(BLOCK));
            block_count += columns * size.height.div_ceil(BLOCK);
            PatchArea { allowed: vec![false; size.texels()], first_block, columns }
        };
        let areas = sizes.iter().map(&mut area).collect();
        let reach = sizes.iter().map(|size| size.width.max(size.height)).max().expect("there is an exemplar");
        let pieces = pieces(window, level.exemplars.planes());
        let mut patches =
            Self { level, window, positions, areas, pieces, block_count, blocks_in_use: 0, reach };
        patches.allow();
        Ok(patches)
    }

    /// Marks the possible positions of patches, and counts the blocks that contain their middles.
    fn allow(&mut self) {
        let mut used = vec![false; self.block_count];
        for corner in self.positions.iter() {
            used[self.block(corner)] = true;
            let exemplar = corner.exemplar as usize;
            let size = self.level.exemplars.texels()[exemplar].size();
            self.areas[exemplar].allowed[size.index(corner.x as usize, corner.y as usize)] = true;
        }
        self.blocks_in_use = used.into_iter().filter(|used| *used).count();
    }

    /// The number of patches.
    pub fn count(&self) -> usize {
        self.positions.count()
    }

    /// The patch of the given number.
    pub fn nth(&self, number: usize) -> Texel {
        self.positions.nth(number)
    }

    /// All patches in order.
    pub fn iter(&self) -> impl Iterator<Item = Texel> {
        self.positions.iter()
    }

    /// The level of the exemplars.
    pub fn level(&self) -> &'a ExemplarLevel {
        self.level
    }

    /// Texels along a side.
    pub fn window(&self) -> usize {
        self.window
    }

    /// Texels from the middle to an edge.
    pub fn radius(&self) -> usize {
        self.window / 2
    }

    /// The longest side of an exemplar.
    pub fn reach(&self) -> usize {
        self.reach
    }

    /// The number of blocks of the exemplars, and of those that contain the middle of a patch.
    pub fn blocks(&self) -> (usize, usize) {
        (self.block_count, self.blocks_in_use)
    }

    /// The number of the block that contains the middle of a patch.
    pub fn block(&self, corner: Texel) -> usize {
        let area = &self.areas[corner.exemplar as usize];
        let (x, y) = (corner.x as usize + self.radius(), corner.y as usize + self.radius());
        area.first_block + y / BLOCK * area.columns + x / BLOCK
    }

    /// The patch `dx` to the right and `dy` down of another, if there is one.
    pub fn moved(&self, corner: Texel, dx: isize, dy: isize) -> Option<Texel> {
        corner.moved(dx, dy).filter(|corner| self.contains(*corner))
    }

    /// The patch around a texel, or the nearest one inside the exemplar; `None` if that contains excluded
    /// texels.
    pub fn around(&self, middle: Texel) -> Option<Texel> {
        let size = self.level.exemplars.texels()[middle.exemplar as usize].size();
        let first = |at: u32, side: usize| {
            let last = side.checked_sub(self.window)?;
            Some((at as usize).saturating_sub(self.radius()).min(last) as u32)
        };
        let corner = Texel { x: first(middle.x, size.width)?, y: first(middle.y, size.height)?, ..middle };
        Some(corner).filter(|corner| self.contains(*corner))
    }

    /// Whether a patch begins at a texel.
    pub fn contains(&self, corner: Texel) -> bool {
        let size = self.level.exemplars.texels()[corner.exemplar as usize].size();
        let (x, y) = (corner.x as usize, corner.y as usize);
        x < size.width && y < size.height && self.areas[corner.exemplar as usize].allowed[size.index(x, y)]
    }

    /// Sets `patch` to the patch of the output around a position, on a torus.
    pub fn of_output(&self, canvas: &PixelCanvas, place: (usize, usize), patch: &mut Vec<i16>) {
        patch.clear();
        let radius = self.radius().cast_signed();
        let planes = self.level.exemplars.planes();
        for dy in -radius..=radius {
            canvas.append_row(place, (-radius, dy), self.window, patch);
            let row = patch.len() - self.window * planes;
            patch.resize(row + (self.window * planes).next_multiple_of(LANES), 0);
        }
    }

    /// The squared distance of a patch of the output and one of the exemplars; `None` if it is `limit` or
    /// more.
    #[inline(always)]
    pub fn distance(
        &self,
        patch: &[i16],
        corner: Texel,
        limit: u64,
        squares: impl Fn(&mut [u32; LANES / 2], &[i16], &[i16], usize),
    ) -> Option<u64> {
        let exemplar = &self.level.exemplars.texels()[corner.exemplar as usize];
        let (mut rest, mut distance) = (patch, 0u64);
        for few in self.pieces.chunks(PATIENCE) {
            let mut sums = [0u32; LANES / 2];
            for piece in few {
                let start = exemplar.start(corner.x as usize, corner.y as usize + piece.dy) + piece.start;
                let (ours, others) = rest.split_at(piece.padded());
                squares(&mut sums, ours, &exemplar.codes()[start..][..piece.padded()], piece.length);
                rest = others;
            }
            for sum in sums {
                distance += u64::from(sum);
            }
            if distance >= limit {
                return None;
            }
        }
        Some(distance)
    }
}

/// The rows of patches in pieces.
fn pieces(window: usize, planes: usize) -> Vec<Piece> {
    let length = window * planes;
    let row = |dy| {
        let starts = (0..length).step_by(PIECE * LANES);
        starts.map(move |start| Piece { dy, start, length: (length - start).min(PIECE * LANES) })
    };
    (0..window).flat_map(row).collect()
}

/// Adds the squared differences of the first `length` codes of two pieces, in AVX2 instructions.
#[cfg(target_arch = "x86_64")]
#[inline(always)]
pub fn avx2(simd: pulp::x86::V3, sums: &mut [u32; LANES / 2], a: &[i16], b: &[i16], length: usize) {
    use std::arch::x86_64::__m256i;
    /// Ones, then zeros: a register from 16 - n on keeps n codes.
    const KEEP: [i16; 2 * LANES] = {
        let mut keep = [0; 2 * LANES];
        let mut i = 0;
        while i < LANES {
            keep[i] = -1;
            i += 1;
        }
        keep
    };
    let (a, b) = (pulp::as_arrays::<LANES, i16>(a).0, pulp::as_arrays::<LANES, i16>(b).0);
    let mut total: __m256i = bytemuck::must_cast(*sums);
    for (n, (a, b)) in a.iter().zip(b).enumerate() {
        let mut difference = simd.avx2._mm256_sub_epi16(bytemuck::must_cast(*a), bytemuck::must_cast(*b));
        let left = length - n * LANES;
        if left < LANES {
            let mut keep = [0i16; LANES];
            keep.copy_from_slice(&KEEP[LANES - left..][..LANES]);
            difference = simd.avx2._mm256_and_si256(difference, bytemuck::must_cast(keep));
        }
        total = simd.avx2._mm256_add_epi32(total, simd.avx2._mm256_madd_epi16(difference, difference));
    }
    *sums = bytemuck::must_cast(total);
}

/// The same without special instructions.
pub fn portable(sums: &mut [u32; LANES / 2], a: &[i16], b: &[i16], length: usize) {
    for (i, (a, b)) in a.iter().zip(b).take(length).enumerate() {
        let difference = i32::from(a - b);
        sums[i % (LANES / 2)] += (difference * difference).unsigned_abs();
    }
}
