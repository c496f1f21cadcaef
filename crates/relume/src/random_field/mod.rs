//! A material in a few kilobytes: causal autoregressive (CAR) random fields on a pyramid.
//!
//! ```text
//! planes --marginal--> normal scores --mixing--> components --pyramid--> bands
//!        bands --statistics, selection--> levels --stability--> Model        (estimate)
//! Model  --noise, recursion, realisation--> bands --pyramid, mixing, marginal--> planes of any size
//! ```
//!
//! After Haindl, Filip, Arnold, "BTF Image Space Utmost Compression and Modelling Method" (2004): a texture
//! is a Laplacian pyramid, and each band is a Gaussian field in which a texel is a weighted sum of earlier
//! neighbours in raster order, of all planes, plus noise. The model stores the weights. Planes may be colours
//! or the index planes of a field under moving light.
//!
//! We extend it in four ways. A level is predicted from the expanded coarser level as well, because
//! neighbouring bands of a pyramid are correlated and independent ones lose contrast. The distribution of
//! every plane is preserved by a monotone curve. The neighbours of a level, in itself and in the coarser
//! level, are chosen freely by the exact evidence. And a model that is unstable or has too long a memory is
//! never used.
//!
//! | module | content |
//! |---|---|
//! | [`marginal`], [`histogram`] | distributions of values |
//! | [`conditional`], [`joint_color`] | joint distributions of colours |
//! | [`mixing`] | planes as combinations of uncorrelated components |
//! | [`neighbourhood`] | the texels from which a texel is predicted |
//! | [`statistics`] | inner products of shifted planes |
//! | [`normal_wishart`] | posterior, evidence, likelihood |
//! | [`selection`] | neighbours chosen by evidence |
//! | [`stability`] | spectral radius, burn-in |
//! | [`local_gain`], [`unevenness`] | the strength of detail from place to place |
//! | [`level`], [`model`] | the data of a model |
//! | [`structure`] | compressed tiles of the periodic part |
//! | [`estimate`](mod@estimate), [`candidates`], [`combine`](mod@combine), [`field_model`], [`per_light`], [`clusters`] | estimation |
//! | [`curves`] | the evidence as a picture |
//! | [`noise`], [`recursion`], [`realisation`] | synthesis |
//! | [`character`](mod@character) | whether a random field suits a material |
//!
//! A fifth extension is for materials that repeat: [`combine`](fn@combine) uses tiles of them, made by any
//! method that copies, as a structure of a few kilobytes, and models the residual.
//!
//! Limits: a Gaussian field has a spectrum and a distribution but no shapes: stones, blades of grass and
//! weaves become noise of the right colour and grain. Bands of a decimated pyramid are assumed to be
//! stationary, which they are only from one coarse texel to the next.

pub mod candidates;
pub mod character;
pub mod clusters;
pub mod combine;
pub mod conditional;
pub mod curves;
pub mod estimate;
pub mod field_model;
pub mod histogram;
mod innovations;
pub mod joint_color;
pub mod level;
mod levels;
pub mod local_gain;
pub mod marginal;
pub mod mixing;
pub mod model;
pub mod neighbourhood;
pub mod noise;
pub mod normal_wishart;
mod octets;
pub mod per_light;
pub mod realisation;
pub mod recursion;
pub mod selection;
pub mod stability;
pub mod statistics;
pub mod structure;
pub mod unevenness;

pub use character::{Character, character};
pub use clusters::{MOST_IMAGE_CLUSTERS, PhotographClusters};
pub use combine::{Budget, combine};
pub use estimate::{LevelReport, ModelOptions, estimate};
pub use field_model::{FieldModel, Fields, Heights, ModelSource, combine_field, model_field};
pub use model::{Model, RealisationOptions, realisation_bytes};
pub use per_light::{LightModel, model_lights};
pub use selection::SelectionOrder;
pub use structure::{Structure, Tiles};
