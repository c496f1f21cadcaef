//! Options of models of regular materials: a compressed set of tiles, and a random field for what it
//! leaves out.

use relume::workflow::model::Combine;

use crate::args;

/// Arguments for structure and detail.
#[derive(Debug, clap::Args)]
#[group(skip)]
pub struct CombineArgs {
    /// Copy the structure from compressed tiles and model only the detail: where the material is regular and
    /// 64 texels wide or more, always, or never
    #[arg(long, default_value = "auto", value_parser = args::named::<Combine>())]
    pub combine: Combine,
    /// Bytes that the tiles may take [default: 3000, and 900 for each plane of colour or function]
    #[arg(long, value_name = "BYTES")]
    pub structure_bytes: Option<usize>,
    /// How many tiles; more of them repeat less visibly and share the bytes
    #[arg(long, value_name = "K", default_value_t = 1)]
    pub tiles: usize,
}
