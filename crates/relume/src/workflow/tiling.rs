//! How well a texture tiles, measured on the texture itself.
//!
//! The step from its last column to its first, and from its last row to its first, is compared with those
//! inside ([`crate::metric::texture::wrap`]). A border shows where its step is larger than nearly all inner
//! ones, and clearly larger than they are on the whole: mortar and yarns have large steps of their own.

use serde::Serialize;

use crate::error::Result;
use crate::job::Job;
use crate::metric::texture::wrap::{Wrap, wrap};
use crate::planes::Planes;
use crate::synthesis::{SourceMap, gather_index};

/// The share of inner lines with smaller steps from which a border may show: all but one in a hundred.
const UNUSUAL: f64 = 0.99;

/// The step across a border, divided by those inside, from which it may show.
const LARGE: f64 = 1.3;

/// The steps across the borders of a texture that was made to tile.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct MeasuredTiling {
    /// From the right border to the left one, and from the bottom to the top.
    pub wrap: [Wrap; 2],
    /// Whether a border is expected to be seen.
    pub shows: bool,
}

impl MeasuredTiling {
    /// Measures the texture that a map makes of index planes, one for each exemplar.
    ///
    /// # Errors
    /// As [`gather_index`].
    pub fn measure(map: &SourceMap, index: &[&Planes], job: &Job) -> Result<Self> {
        Ok(Self::of(wrap(&gather_index(map, index, job)?)))
    }

    /// Measures a texture.
    pub fn of_texture(planes: &Planes) -> Self {
        Self::of(wrap(planes))
    }

    /// The judgement of measured steps.
    fn of(wrap: [Wrap; 2]) -> Self {
        let shows = wrap.iter().any(|wrap| wrap.rank >= UNUSUAL && wrap.ratio > LARGE);
        Self { wrap, shows }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_border_shows_if_its_step_is_large_and_unusual() {
        let wrap = |ratio, rank| Wrap { ratio, rank };
        for (across, shows) in [(wrap(3.0, 1.0), true), (wrap(3.0, 0.9), false), (wrap(1.1, 1.0), false)] {
            assert_eq!(MeasuredTiling::of([wrap(1.0, 0.5), across]).shows, shows);
            assert_eq!(MeasuredTiling::of([across, wrap(1.0, 0.5)]).shows, shows);
        }
    }
}
