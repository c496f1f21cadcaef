//! Synthesis: from index planes to the source of each output texel.
//!
//! ```text
//! Exemplar --quantise--> codes --+
//! BlockOptions --layout--> blocks --search--> candidates --draw--> block --cut | alpha--> SourceMap
//!                                                     SourceMap + fields --gather--> field
//! ```
//!
//! - [`synthesize`] makes the map; [`options`] defines its options;
//! - [`quantise`]: exemplars as integers; [`positions`]: possible positions of blocks;
//! - [`layout`]: positions and order of blocks; [`neighbourhood`]: their filled part; `former`: what they should not copy;
//! - [`search`]: a family of exact searches;
//! - [`guidance`]: maps that an output follows; [`search::guided`]: guided search for blocks;
//! - [`cut`] and [`alpha`]: joining a block to the existing texels;
//! - [`pixel`]: methods that place one texel after another;
//! - [`fill`]: holes and borders replaced by copies;
//! - [`roller`]: tiles of regular textures that fit together in any order;
//! - [`elements`]: whole elements of a regular material in random order;
//! - [`noise`]: endless stochastic textures, without a source map;
//! - [`source_map`]: the result; [`gather()`] applies it to anything registered with the exemplars.
//!
//! All decisions are on integers, and each block has its own random stream, so the result does not depend on
//! threads or processors.

pub mod alpha;
mod blocks;
mod canvas;
pub mod cut;
pub mod elements;
pub mod fill;
mod former;
mod gather;
pub mod guidance;
pub mod layout;
pub mod neighbourhood;
pub mod noise;
pub mod options;
pub mod pixel;
pub mod positions;
pub mod quantise;
mod report;
pub mod roller;
pub mod search;
pub mod source_map;

pub use blocks::synthesize;
pub use gather::{gather, gather_index};
pub use guidance::Guidance;
pub use options::{Blend, BlockOptions, Boundary, Tolerance};
pub use quantise::Exemplar;
pub use report::{Placement, RejectionCurve, StageTimes, Synthesis, SynthesisReport};
pub use source_map::{Part, SourceMap, Texel};
