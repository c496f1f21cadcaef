//! The Roller: tiles of a regular texture that fit together in any random order without a seam.
//!
//! ```text
//! Exemplar --profile--> shifts --region--> origin and size --toroidal--> first tile
//!          --further--> regions that fit its border --ring--> further tiles --> TileSet
//! TileSet + seed --Endless--> any window of an infinite plane
//! ```
//!
//! M. Haindl, M. Hatka, "BTF Roller", Texture 2005, and "A Roller - Fast Sampling-Based Texture Synthesis
//! Algorithm", WSCG 2005. Everything works on index planes, and therefore on any reflectance field:
//!
//! - periods are found in the autocorrelation of all planes ([`crate::numeric::periods`]);
//! - [`profile`]: the difference of the exemplar from itself under each shift along an axis;
//! - [`oblique`]: cells that follow oblique periods;
//! - [`region`]: the part of the exemplar whose overlaps with its own shifts differ least;
//! - [`toroidal`]: two closed cuts through one corner turn it into a seamless tile;
//! - [`further`]: other parts that fit the border of the first tile;
//! - [`closed_cut`]: a closed cut joins each of them to that border;
//! - [`corners`]: for textures that do not repeat, tiles whose borders vary; [`template`]: the place of an
//!   exemplar that fits given texels best;
//! - [`seams`]: steps across the cuts compared with those inside;
//! - [`Endless`]: the plane of tiles, each chosen by a hash of the seed and its cell;
//! - [`lay()`]: a part of it as a source map.
//!
//! Deciding errors are sums of integers; the result does not depend on threads.

pub mod closed_cut;
pub mod corners;
pub mod further;
mod lay;
mod make;
pub mod oblique;
pub mod options;
pub mod profile;
pub mod region;
pub mod seams;
pub mod template;
mod tile_set;
pub mod toroidal;

pub use crate::numeric::endless::Endless;
pub use lay::lay;
pub use make::{RollReport, Rolled, roll};
pub use options::RollerOptions;
pub use seams::TileSeams;
pub use tile_set::TileSet;

#[cfg(test)]
mod tests {
    use crate::job::Job;
    use crate::numeric::random::{Purpose, Stream};
    use crate::planes::Planes;
    use crate::size::Size;
    use crate::synthesis::quantise::{Exemplar, Quantised};

    /// Random texels as codes.
    pub fn noise(size: Size, planes: usize, seed: u64) -> Quantised {
        let mut stream = Stream::new(seed, Purpose::Sample, [0]);
        let data = (0..size.texels() * planes).map(|_| stream.unit() as f32).collect();
        let index = Planes::from_vec(size, planes, data).unwrap();
        Quantised::new(&[Exemplar { index: &index, excluded: None }], &Job::default()).unwrap()
    }
}
