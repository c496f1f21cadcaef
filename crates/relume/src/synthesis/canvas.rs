//! The output under construction: quantised index planes, and the source of each texel.

use std::collections::BTreeMap;

use super::layout::PlacedBlock;
use super::quantise::{Exemplar, Quantised};
use super::source_map::{Part, SourceMap, Texel};
use crate::error::Result;
use crate::job::{Held, Job};
use crate::memory;
use crate::size::Size;

/// The codes and sources of the output. Blocks that cross an edge continue at the opposite one.
pub struct BlockCanvas {
    size: Size,
    planes: usize,
    codes: Vec<i16>,
    sources: Vec<Texel>,
    mixes: BTreeMap<usize, Vec<Part>>,
    held: Held,
}

/// What the output is called in a refusal.
const WHAT: &str = "the synthesised output";

impl BlockCanvas {
    /// An empty canvas.
    pub fn new(size: Size, planes: usize, job: &Job) -> Result<Self> {
        let bytes = Self::bytes_per_texel(planes);
        job.check(WHAT, size, bytes)?;
        Ok(Self {
            size,
            planes,
            codes: memory::zeros(WHAT, size.texels() * planes)?,
            sources: memory::zeros(WHAT, size.texels())?,
            mixes: BTreeMap::new(),
            held: job.hold(WHAT, bytes * size.texels() as u64)?,
        })
    }

    /// Memory of a texel without blends: its codes and its source, or at the end its source twice.
    fn bytes_per_texel(planes: usize) -> u64 {
        (size_of::<Texel>() + (planes * size_of::<i16>()).max(size_of::<Texel>())) as u64
    }

    /// The output texels of row `dy` of a block, in order.
    fn row(&self, block: &PlacedBlock, dy: usize) -> impl Iterator<Item = usize> + use<> {
        let (size, x) = (self.size, block.x);
        let y = (block.y + dy) % size.height;
        (0..block.neighbourhood.extent.width).map(move |dx| size.index((x + dx) % size.width, y))
    }

    /// The codes under a block, row by row; zeros where nothing is placed yet.
    pub fn patch(&self, block: &PlacedBlock) -> Vec<i16> {
        let extent = block.neighbourhood.extent;
        let mut patch = Vec::with_capacity(extent.texels() * self.planes);
        for texel in (0..extent.height).flat_map(|dy| self.row(block, dy)) {
            patch.extend_from_slice(&self.codes[texel * self.planes..][..self.planes]);
        }
        patch
    }

    /// The positions that would continue the texels at the middles of the filled sides of a block, and at its
    /// first corner.
    pub fn continuations(&self, block: &PlacedBlock) -> Vec<Texel> {
        let (shape, size) = (block.neighbourhood, self.size);
        let Size { width, height } = shape.extent;
        let (across, down) = (width / 2, height / 2);
        let probes = [(0, 0), (across, 0), (0, down), (width - 1, down), (across, height - 1)];
        let filled = probes.into_iter().filter(|&(dx, dy)| shape.contains(dx, dy));
        let source = |(dx, dy): (usize, usize)| {
            let texel = size.index((block.x + dx) % size.width, (block.y + dy) % size.height);
            let Texel { exemplar, y, x } = self.sources[texel];
            Some(Texel { exemplar, y: y.checked_sub(dy as u32)?, x: x.checked_sub(dx as u32)? })
        };
        let mut positions: Vec<Texel> = filled.filter_map(source).collect();
        positions.sort_unstable();
        positions.dedup();
        positions
    }

    /// Places the exemplar block at `position`; `weights` are its shares, texel by texel: 1 copies, 0 keeps
    /// the existing texel, values in between blend.
    pub fn paste(&mut self, block: &PlacedBlock, exemplars: &Quantised, position: Texel, weights: &[f32]) {
        let extent = block.neighbourhood.extent;
        let from = &exemplars.texels()[position.exemplar as usize];
        for dy in 0..extent.height {
            let run = from.run(position.x as usize, position.y as usize + dy, extent.width);
            let shares = &weights[dy * extent.width..][..extent.width];
            for (dx, (texel, &share)) in self.row(block, dy).zip(shares).enumerate() {
                let new = &run[dx * self.planes..][..self.planes];
                self.put(texel, new, position.offset(dx, dy), share);
            }
        }
    }

    /// Adds texel `source` with codes `new` and the given share to one output texel.
    fn put(&mut self, texel: usize, new: &[i16], source: Texel, share: f32) {
        let old = &mut self.codes[texel * self.planes..][..self.planes];
        if share <= 0.0 || (source == self.sources[texel] && share < 1.0 && !self.mixes.contains_key(&texel))
        {
            return;
        }
        if share >= 1.0 {
            old.copy_from_slice(new);
            self.sources[texel] = source;
            self.mixes.remove(&texel);
            return;
        }
        for (code, &new) in old.iter_mut().zip(new) {
            let change = share * f32::from(new - *code);
            *code += change.round() as i16;
        }
        let before = self.sources[texel];
        let parts = self.mixes.entry(texel).or_insert_with(|| vec![Part { source: before, weight: 1.0 }]);
        parts.iter_mut().for_each(|part| part.weight *= 1.0 - share);
        match parts.iter_mut().find(|part| part.source == source) {
            Some(part) => part.weight += share,
            None => parts.push(Part { source, weight: share }),
        }
    }

    /// The finished map of the upper left `size` texels.
    pub fn into_map(self, size: Size, exemplars: &[Exemplar<'_>]) -> SourceMap {
        drop(self.codes);
        let rows = self.sources.chunks_exact(self.size.width).take(size.height);
        let sources = rows.flat_map(|row| &row[..size.width]).copied().collect();
        let mut map = SourceMap::new(size, exemplars, sources);
        for (texel, parts) in &self.mixes {
            let (x, y) = (texel % self.size.width, texel / self.size.width);
            if x < size.width && y < size.height {
                map.push_mix(size.index(x, y), parts);
            }
        }
        map.holding(self.held)
    }
}
