//! Workflows: combinations of stages. The top layer of the library, which may name every stage and
//! [`mod@format`](crate::format), and is named by nothing in the library.
//!
//! | file | content |
//! |---|---|
//! | [`front`] | the shortest way through the library |
//! | [`files`] | reading and writing fields and pictures by file name |
//! | [`mod@capture`] | captures of a virtual dome as files |
//! | [`gonioreflectometer`] | images for pairs of light and view as files |
//! | [`options`] | the options of a synthesis, and the resulting plan |
//! | [`fitted`] | options whose open sizes are fitted to exemplars |
//! | [`sizes`] | sizes of blocks and windows that fit |
//! | [`method`] | methods of synthesis as plans, with one way to run them |
//! | [`per_view`](mod@per_view) | factorisations for each view |
//! | [`packed`] | learned functions packed for a model |
//! | [`metric`] | metrics by name |
//! | [`model`] | models of functions jointly, of structure and detail, or of single lights |
//! | [`model_surface`] | normals and colours of textures of any form |
//! | [`image_clusters`] | random fields of clusters of photographs, and a range map |
//! | [`likeness`] | whether what a model makes looks like the material |
//! | [`btf`](mod@btf) | textures of light and view on disk |
//! | [`btf_comparison`] | textures of functions compared with photographs under light and view |
//! | [`convert`](mod@convert) | textures in other functions, space or colours, and what that loses |
//! | [`convert_models`](mod@convert_models) | reflectance models in functions of light, and what that loses |
//! | [`comparison`] | textures compared under several lights |
//! | [`decorrelated`](mod@decorrelated) | factorisations of decorrelated colours |
//! | [`quality`] | how far a fit can be trusted, and which photographs look wrong |
//! | [`share`] | textures as web pages load them |
//! | [`shared_noise`] | endless noise as web pages load it |
//! | [`auto`] | textures made in several ways, of which the nearest to the exemplar is kept |
//! | `trend` | textures that change from side to side as their exemplar does |
//! | [`map_export`] | the maps of a material under the names and in the packings of other programs |
//! | [`map_set`] | the maps of a material as one exemplar |
//! | [`tested`] | fitted textures under lights that took no part in the fit |
//! | [`tiling`] | how well a texture tiles, measured on it |
//! | [`memory`] | the memory of whole jobs, known before they begin |
//! | [`endless`] | windows of endless planes, of any size, written row by row |

pub mod auto;
pub mod btf;
pub mod btf_comparison;
pub mod capture;
pub mod comparison;
pub mod convert;
pub mod convert_models;
pub mod decorrelated;
pub mod endless;
pub mod files;
pub mod fitted;
pub mod front;
pub mod gonioreflectometer;
pub mod image_clusters;
pub mod likeness;
pub mod map_export;
pub mod map_set;
pub mod memory;
pub mod method;
pub mod metric;
pub mod model;
mod model_structure;
pub mod model_surface;
pub mod options;
pub mod packed;
pub mod per_view;
pub mod quality;
pub mod share;
pub mod shared_noise;
pub mod sizes;
pub mod tested;
pub mod tiling;
mod trend;

pub use auto::Exemplars;
pub use btf::{Btf, Missing};
pub use map_set::RegisteredMap;
pub use method::{MadeTexture, MethodReport, Plan, SynthesisMethod};
pub use metric::NamedMetric;
pub use options::{Approach, Outcome, SynthOptions};
