//! `relume tileable`: a texture made to tile by refilling a band along its border.

use std::path::PathBuf;

use relume::Result;
use relume::synthesis::fill::{FillMethod, tileable};
use relume::synthesis::{Boundary, Exemplar};
use serde_json::json;

use super::fill::How;
use crate::context::Context;
use crate::map_folder::MapFolder;
use crate::report::Report;

/// Arguments of `relume tileable`.
#[derive(Debug, Clone, clap::Args)]
#[command(after_help = "Example:\n  relume tileable gravel.png -o tile.png --band 24")]
pub struct Args {
    /// A .ptm, an .exr field, or a picture; - is standard input. Or a folder of maps known by the words in their names,
    /// written into the folder of --output under their own names
    file: PathBuf,
    /// Width in texels of the band along each edge that is refilled [default: an eighth of the shorter side]
    #[arg(long, value_name = "N")]
    band: Option<usize>,
    #[command(flatten)]
    how: How,
}

/// Fills the band and writes all requested outputs.
pub fn run(args: &Args, context: &Context) -> Result<Report> {
    let Some(set) = MapFolder::of(std::slice::from_ref(&args.file))? else { return refilled(args, context) };
    let mut args = args.clone();
    args.how.output = args.how.rearranged.take_set(&set, &args.how.output)?;
    args.file.clone_from(&set.color);
    Ok(set.describe(refilled(&args, context)?))
}

fn refilled(args: &Args, context: &Context) -> Result<Report> {
    let claimed = args.how.claim(&[&args.file], context)?;
    let texture = args.how.read(&args.file, claimed, context)?;
    let size = texture.index.size();
    let band = args.band.unwrap_or_else(|| (size.width.min(size.height) / 8).max(1));
    let exemplar = Exemplar { index: &texture.index, excluded: texture.excluded.as_deref() };
    // The band is filled with what lies in it too.
    let none = vec![false; size.texels()];
    let options = args.how.options(FillMethod::Bridges, Boundary::Torus, &texture, &none, context)?;
    let (map, growth) = tileable(exemplar, band, &options, &context.job)?;
    let what = format!("of a band of {band} along the border");
    let special = json!({ "band": band, "tile": true });
    args.how.finish(texture, Boundary::Torus, (&map, &growth), &what, special, context)
}
