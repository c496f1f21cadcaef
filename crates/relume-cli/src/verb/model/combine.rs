//! Options of models of regular materials: a compressed set of tiles, and a random field for the residual.

use relume::numeric::lattice::Lattice;
use relume::workflow::model::Combine;

use crate::args;

/// Arguments for structure and detail.
#[derive(Debug, clap::Args)]
#[group(skip)]
pub struct CombineArgs {
    /// Model the structure by compressed tiles and only the detail by the random field: always, never, or
    /// (auto) where the material is regular or a sample made by the random field alone does not look like it,
    /// in textures at least 64 texels wide
    #[arg(long, default_value = "auto", value_parser = args::named::<Combine>())]
    pub combine: Combine,
    /// The most bytes for the tiles [default: 3000, plus 900 for each plane of the functions
    /// of all colours; for pictures that are not regular as many as keep the model to 2000]
    #[arg(long, value_name = "BYTES")]
    pub structure_bytes: Option<usize>,
    /// Number of tiles; more of them repeat less visibly and share the bytes
    #[arg(long, value_name = "K", default_value_t = 1)]
    pub tiles: usize,
    /// The periods of the texture, instead of measured ones, followed by the tiles: W,H in texels, or two shifts
    /// X,Y,X,Y to the right and down
    #[arg(long, value_name = "W,H", value_parser = args::lattice, allow_hyphen_values = true)]
    pub period: Option<Lattice>,
}
