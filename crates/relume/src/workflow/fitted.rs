//! The sizes that the options of a synthesis leave open, fitted to its exemplars ([`super::sizes`]).

use serde::Serialize;

use super::method::SynthesisMethod;
use super::options::SynthOptions;
use super::sizes::Room;
use crate::analysis::Extents;
use crate::synthesis::BlockOptions;
use crate::synthesis::pixel::{PatchMatchOptions, WeiLevoyOptions};

/// The sizes of a method that were not given, and what they follow from.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Advised {
    /// The lengths measured on each exemplar.
    pub extents: Vec<Extents>,
    /// The options that were chosen, by name.
    pub chosen: Vec<&'static str>,
}

impl SynthOptions {
    /// The sizes that the method has and that are not given.
    pub(super) fn open_sizes(&self) -> Vec<&'static str> {
        use SynthesisMethod::{Auto, EfrosLeung, Elements, Noise, PatchMatch, Quilting, Roller, WeiLevoy};
        let block = ("block", self.block.is_none());
        let overlap = ("overlap", self.overlap.is_none());
        let window = ("neighbourhood", self.neighbourhood.is_none());
        let levels = ("levels", self.levels.is_none());
        let sizes: &[(&'static str, bool)] = match self.method {
            Quilting if self.block.is_some() => &[],
            Quilting => &[block, overlap],
            EfrosLeung => &[window],
            WeiLevoy | PatchMatch => &[window, levels],
            Roller | Elements | Noise | Auto => &[],
        };
        sizes.iter().filter(|(_, is_open)| *is_open).map(|(name, _)| *name).collect()
    }

    /// The same with the smallest sizes in place of those left open, to check everything else.
    pub(super) fn tolerant(&self) -> Self {
        let open = self.open_sizes();
        let of = |name, given: Option<usize>, least: usize| given.or(open.contains(&name).then_some(least));
        Self {
            block: of("block", self.block, 2 * self.least_overlap()),
            overlap: of("overlap", self.overlap, self.least_overlap()),
            neighbourhood: of("neighbourhood", self.neighbourhood, 3),
            levels: of("levels", self.levels, 1),
            ..self.clone()
        }
    }

    /// The overlap that is given, or the least that has room for the feathering.
    fn least_overlap(&self) -> usize {
        // Absurd numbers are refused by the plan; twice of them must be a number.
        self.overlap.or(self.feather).unwrap_or(1).clamp(1, usize::MAX / 4)
    }

    /// The same with the sizes that are left open fitted to exemplars.
    pub fn fitted(&self, room: &Room) -> (Self, Advised) {
        let open = self.open_sizes();
        let fit = |name, given: Option<usize>, size: &dyn Fn() -> usize| {
            given.or_else(|| open.contains(&name).then(size))
        };
        let block = || room.block(self.least_overlap(), self.boundary, self.guidance.is_some());
        let block = fit("block", self.block, &block);
        let side = block.unwrap_or(0);
        let overlap =
            || BlockOptions::customary_overlap(side).max(self.least_overlap()).min((side / 2).max(1));
        let window = fit("neighbourhood", self.neighbourhood, &|| self.fitted_window(room));
        let levels = || room.levels(window.unwrap_or(1));
        let options = Self {
            block,
            overlap: fit("overlap", self.overlap, &overlap),
            neighbourhood: window,
            levels: fit("levels", self.levels, &levels),
            ..self.clone()
        };
        (options, Advised { extents: room.extents().to_vec(), chosen: open })
    }

    fn fitted_window(&self, room: &Room) -> usize {
        match self.method {
            SynthesisMethod::WeiLevoy => room.small_window(WeiLevoyOptions::default().window),
            SynthesisMethod::PatchMatch => room.small_window(PatchMatchOptions::default().window),
            _ => room.window(),
        }
    }
}
