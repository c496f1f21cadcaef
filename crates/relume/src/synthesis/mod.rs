//! Synthesis: from index planes to a map of where each output texel comes from.
//!
//! ```text
//! Exemplar --quantise--> codes --+
//! BlockOptions --layout--> blocks --search--> candidates --draw--> block --cut | alpha--> SourceMap
//!                                                     SourceMap + fields --gather--> field
//! ```
//!
//! - [`synthesize`] makes the map; [`options`] says what can be asked for;
//! - [`quantise`]: exemplars as integers; [`positions`]: where blocks may be taken from;
//! - [`layout`]: where blocks go and in which order; [`neighbourhood`]: what is there already;
//! - [`search`]: a family of exact searches;
//! - [`guidance`]: maps that an output follows; [`search::guided`]: how blocks do;
//! - [`cut`] and [`alpha`]: joining a block to what is there;
//! - [`pixel`]: methods that place one texel after another;
//! - [`fill`]: holes and borders replaced by copies;
//! - [`roller`]: another method, for regular textures: tiles that can be laid in any order;
//! - [`noise`]: for stochastic textures: endless, without a source map;
//! - [`source_map`]: the result; [`gather()`] applies it to anything registered with the exemplars.
//!
//! Everything that decides is an integer, and each block has its own random stream, so the result
//! does not depend on threads or processors.

pub mod alpha;
mod blocks;
mod canvas;
pub mod cut;
pub mod fill;
mod gather;
pub mod guidance;
pub mod layout;
pub mod neighbourhood;
pub mod noise;
pub mod options;
pub mod pixel;
pub mod positions;
pub mod quantise;
pub mod roller;
pub mod search;
pub mod source_map;

pub use blocks::{Placement, RejectionCurve, StageTimes, Synthesis, SynthesisReport, synthesize};
pub use gather::gather;
pub use guidance::Guidance;
pub use options::{Blend, BlockOptions, Boundary, Tolerance};
pub use quantise::Exemplar;
pub use source_map::{Part, SourceMap, Texel};
