//! The positions and the order of blocks, as data.
//!
//! Blocks are placed row by row. With open edges they are `block - overlap` apart, and the last ones extend
//! past the output, whose margin is cut off at the end: so all blocks are complete, and few shapes of
//! neighbourhood occur. On a torus of side s there are n = ceil(s / (block - overlap)) of them at floor(i s /
//! n), so that overlaps differ by at most a texel and are at least the requested one; the last block of a row
//! meets the first one, and the last row the first row.
//!
//! The content of a block depends on the earlier blocks that it overlaps, at most its eight neighbours.
//! Blocks without such a chain between them can be made at the same time: a *wave* holds all blocks with
//! chains of equal length. With open edges that is the skewed diagonal i + 2 j (a block also meets the one
//! above to the right). On a torus the block that closes a row would delay the whole next row; therefore row
//! j starts at column j, and its closing block lies beside its start.

use super::neighbourhood::{Margins, Neighbourhood};
use super::options::{BlockOptions, Boundary};
use super::source_map::Texel;
use crate::error::Result;
use crate::job::Job;
use crate::size::Size;

/// One block of the output.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct PlacedBlock {
    /// Its number, row by row, and that of its random stream.
    pub number: usize,
    /// Left column in the output.
    pub x: usize,
    /// Top row in the output.
    pub y: usize,
    /// The part of it already filled by earlier blocks.
    pub neighbourhood: Neighbourhood,
}

/// All blocks of an output.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct BlockLayout {
    /// The texels covered by the blocks: those of the output, and with open edges possibly more.
    pub size: Size,
    /// Blocks in each row.
    pub columns: usize,
    /// Rows of blocks.
    pub rows: usize,
    /// The blocks in sequential order.
    pub sequence: Vec<PlacedBlock>,
    /// Indices into the sequence, in waves of blocks that do not depend on each other.
    pub waves: Vec<Vec<usize>>,
}

impl BlockLayout {
    /// The blocks of valid options.
    ///
    /// # Errors
    /// When the output or the number of its blocks exceeds the limits.
    pub fn new(options: &BlockOptions, job: &Job) -> Result<Self> {
        job.check("the synthesised output", options.size, size_of::<Texel>() as u64)?;
        let columns = BlockSpacing::new(options.size.width, options);
        let rows = BlockSpacing::new(options.size.height, options);
        let bytes_per_block = (size_of::<PlacedBlock>() + 3 * size_of::<usize>()) as u64;
        let bytes = (columns.count() as u64 * rows.count() as u64).saturating_mul(bytes_per_block);
        job.check_bytes("the plan of so many blocks", bytes)?;
        let mut sequence = Vec::with_capacity(columns.count() * rows.count());
        for row in 0..rows.count() {
            let start = if options.boundary == Boundary::Torus { row % columns.count() } else { 0 };
            for order in 0..columns.count() {
                let column = (start + order) % columns.count();
                let (left, right) = columns.margins(column, order);
                let (top, bottom) = rows.margins(row, row);
                sequence.push(PlacedBlock {
                    number: row * columns.count() + column,
                    x: columns.starts[column],
                    y: rows.starts[row],
                    neighbourhood: Neighbourhood {
                        extent: Size::new(options.block, options.block),
                        margins: Margins { left, top, right, bottom },
                    },
                });
            }
        }
        let waves = waves(&sequence, columns.count(), rows.count(), options.boundary);
        let size = Size::new(columns.covered(), rows.covered());
        Ok(Self { size, columns: columns.count(), rows: rows.count(), sequence, waves })
    }
}

/// The blocks along one side of the output.
struct BlockSpacing {
    side: usize,
    block: usize,
    boundary: Boundary,
    starts: Vec<usize>,
}

impl BlockSpacing {
    fn new(side: usize, options: &BlockOptions) -> Self {
        let BlockOptions { block, overlap, boundary, .. } = *options;
        let step = block - overlap;
        let starts = match boundary {
            Boundary::Open => (0..1 + side.saturating_sub(block).div_ceil(step)).map(|i| i * step).collect(),
            Boundary::Torus => {
                let count = torus_count(side, block, step);
                (0..count).map(|i| i * side / count).collect()
            }
        };
        Self { side, block, boundary, starts }
    }

    fn count(&self) -> usize {
        self.starts.len()
    }

    /// Texels that the blocks cover.
    fn covered(&self) -> usize {
        match self.boundary {
            Boundary::Open => self.starts[self.count() - 1] + self.block,
            Boundary::Torus => self.side,
        }
    }

    /// The overlap of block `i` with the one before it.
    fn overlap_before(&self, i: usize) -> usize {
        let before = self.starts[(i + self.count() - 1) % self.count()];
        self.block - (self.starts[i] + self.side - before) % self.side
    }

    /// Filled margins before and after block `i`, which is the `order`-th to be placed.
    fn margins(&self, i: usize, order: usize) -> (usize, usize) {
        let before = if order > 0 { self.overlap_before(i) } else { 0 };
        let closes = self.boundary == Boundary::Torus && order + 1 == self.count();
        let after = if closes { self.overlap_before((i + 1) % self.count()) } else { 0 };
        (before, after)
    }
}

/// The number of blocks around a torus. A block may meet only its two neighbours, whose starts are at least
/// floor(2 side / count) apart; where a large overlap on a small side would violate that, fewer blocks
/// overlap less.
fn torus_count(side: usize, block: usize, step: usize) -> usize {
    let fitting = |count: &usize| 2 * side / count >= block;
    (2..=side.div_ceil(step)).rev().find(fitting).unwrap_or(2)
}

/// Groups the sequence by the length of the longest chain of overlapping earlier blocks.
fn waves(sequence: &[PlacedBlock], columns: usize, rows: usize, boundary: Boundary) -> Vec<Vec<usize>> {
    let mut level: Vec<Option<usize>> = vec![None; columns * rows];
    let mut waves: Vec<Vec<usize>> = Vec::new();
    for (index, block) in sequence.iter().enumerate() {
        let (column, row) = (block.number % columns, block.number / columns);
        let earlier = near(row, rows, boundary)
            .flat_map(|r| near(column, columns, boundary).map(move |c| (c, r)))
            .filter_map(|(c, r)| level[r * columns + c]);
        let own = earlier.max().map_or(0, |before| before + 1);
        level[block.number] = Some(own);
        if own == waves.len() {
            waves.push(Vec::new());
        }
        waves[own].push(index);
    }
    waves
}

/// i - 1, i and i + 1 where they exist.
fn near(i: usize, count: usize, boundary: Boundary) -> impl Iterator<Item = usize> {
    let (before, after) = match boundary {
        Boundary::Torus => (Some((i + count - 1) % count), Some((i + 1) % count)),
        Boundary::Open => (i.checked_sub(1), Some(i + 1).filter(|next| *next < count)),
    };
    [before, Some(i), after].into_iter().flatten()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::limits::Limits;
    use proptest::prelude::*;

    fn plan(options: &BlockOptions) -> BlockLayout {
        BlockLayout::new(options, &Job::default()).unwrap()
    }

    fn texels(block: &PlacedBlock, size: Size) -> impl Iterator<Item = (usize, bool)> + use<> {
        let block = *block;
        let shape = block.neighbourhood;
        let at =
            move |x: usize, y: usize| size.index((block.x + x) % size.width, (block.y + y) % size.height);
        (0..shape.extent.height)
            .flat_map(move |y| (0..shape.extent.width).map(move |x| (at(x, y), shape.contains(x, y))))
    }

    fn options() -> impl Strategy<Value = BlockOptions> {
        let sizes = (2usize..20, 1usize..90, 1usize..70, any::<bool>());
        (sizes, 0usize..100).prop_map(|((block, width, height, torus), overlap)| {
            let (least, boundary) = if torus { (block, Boundary::Torus) } else { (1, Boundary::Open) };
            BlockOptions {
                size: Size::new(width.max(least), height.max(least)),
                block,
                overlap: 1 + overlap % (block / 2),
                boundary,
                ..BlockOptions::default()
            }
        })
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(400))]

        #[test]
        fn neighbourhoods_are_what_earlier_blocks_filled_and_all_is_covered(options in options()) {
            prop_assert!(options.validate().is_ok());
            let layout = plan(&options);
            let mut filled = vec![false; layout.size.texels()];
            for block in &layout.sequence {
                let before: Vec<(usize, bool)> = texels(block, layout.size).collect();
                for (texel, expected) in &before {
                    prop_assert_eq!(filled[*texel], *expected, "{:?}", block);
                }
                before.iter().for_each(|(texel, _)| filled[*texel] = true);
            }
            prop_assert!(filled.into_iter().all(|f| f));
        }

        #[test]
        fn waves_keep_the_order_of_blocks_that_touch(options in options()) {
            let layout = plan(&options);
            let mut wave_of = vec![usize::MAX; layout.sequence.len()];
            for (number, wave) in layout.waves.iter().enumerate() {
                wave.iter().for_each(|&index| wave_of[index] = number);
            }
            let mut latest = vec![None; layout.size.texels()];
            for (index, block) in layout.sequence.iter().enumerate() {
                for (texel, _) in texels(block, layout.size) {
                    prop_assert!(latest[texel].is_none_or(|before| before < wave_of[index]));
                    latest[texel] = Some(wave_of[index]);
                }
            }
        }

        #[test]
        fn overlaps_are_at_least_those_asked_for(options in options()) {
            // Up to a third of the block, and always on outputs of at least two blocks.
            prop_assume!(3 * options.overlap <= options.block);
            prop_assume!(options.size.width.min(options.size.height) >= 2 * options.block);
            for block in plan(&options).sequence {
                let Margins { left, top, right, bottom } = block.neighbourhood.margins;
                prop_assert!([left, top, right, bottom].iter().all(|m| *m == 0 || *m >= options.overlap));
            }
        }
    }

    #[test]
    fn waves_are_skewed_diagonals() {
        let options =
            BlockOptions { size: Size::new(90, 60), block: 12, overlap: 2, ..BlockOptions::default() };
        let layout = plan(&options);
        for (number, wave) in layout.waves.iter().enumerate() {
            for &index in wave {
                let block = layout.sequence[index];
                assert_eq!(number, block.number % layout.columns + 2 * (block.number / layout.columns));
            }
        }
        let torus = plan(&BlockOptions { boundary: Boundary::Torus, ..options });
        assert!(torus.waves.len() < torus.sequence.len() / 2, "rows of a torus overlap in time");
    }

    #[test]
    fn blocks_beyond_the_limits_are_refused() {
        let options =
            BlockOptions { size: Size::new(4000, 4000), block: 2, overlap: 1, ..Default::default() };
        let job = Job::new(Limits { max_bytes: 1 << 29, ..Limits::default() });
        assert!(job.check("the output alone", options.size, 12).is_ok());
        assert!(BlockLayout::new(&options, &job).unwrap_err().message().contains("blocks"));
    }
}
