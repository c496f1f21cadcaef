//! `relume maps`: the maps of a material under the names and in the packings of other programs.

use std::path::{Path, PathBuf};

use relume::capture::dome::ReliefBorder;
use relume::field::TexelModel;
use relume::workflow::map_export::{MapPreset, MaterialMaps, export_maps};
use relume::workflow::tiling::MeasuredTiling;
use relume::{Job, Result};
use serde_json::{Value, json};

use super::capture::maps::MapFiles;
use crate::context::Context;
use crate::output::Folder;
use crate::report::Report;
use crate::{args, input, normals};

/// Arguments of `relume maps`.
#[derive(Debug, clap::Args)]
#[command(after_help = "Examples:\n  relume maps wall -o unreal --preset unreal --name Wall --tile\n  \
                        relume maps coin.ptm -o coin_maps --preset gltf")]
pub struct Args {
    /// A folder of maps known by the words in their names (at least colour and height), or a texture of functions
    input: PathBuf,
    /// The folder to write
    #[arg(short, long, value_name = "DIR")]
    output: PathBuf,
    /// Whose names, packings, bit depths and direction of normals
    #[arg(long, value_parser = args::named::<MapPreset>())]
    preset: MapPreset,
    /// The name of the material in file names
    #[arg(long, default_value = "Material")]
    name: String,
    /// The material tiles: occlusion and heights wrap around, and every map is checked to tile
    #[arg(long)]
    tile: bool,
    /// Size of a texel in millimetres: heights are then recorded in millimetres
    #[arg(long, value_name = "MM", value_parser = args::texel_mm)]
    texel_mm: Option<f64>,
    /// Texels from the lowest to the highest code of a height map without a record [default: a 25th of the width]
    #[arg(long, value_name = "TEXELS")]
    height_scale: Option<f64>,
    #[command(flatten)]
    normal_maps: normals::Args,
}

/// Reads or derives the maps, and writes them.
pub fn run(args: &Args, context: &Context) -> Result<Report> {
    let job = &context.job;
    let folder = Folder::stage(&args.output, &[&args.input], context)?;
    let border = if args.tile { ReliefBorder::Wrap } else { ReliefBorder::Clamp };
    let is_web = args.input.join("info.json").is_file();
    let maps = if args.input.is_dir() && !is_web {
        let files = MapFiles::find(&args.input)?;
        MaterialMaps::of_maps(files.read(args.height_scale, args.normal_maps.normal_y, job)?, border, job)?
    } else {
        of_texture(&args.input, border, job).map_err(|e| e.at(&args.input))?
    };
    let tiling = args.tile.then(|| tiling(&maps));
    let mut store = |name: &str, bytes: &[u8]| folder.add(name, bytes);
    let written = export_maps(&maps, args.preset, &args.name, args.texel_mm, job, &mut store)?;
    let json = json!({ "preset": args.preset, "name": args.name, "maps": written, "tiling": tiling });
    folder.add("maps.json", format!("{json:#}\n").as_bytes())?;
    let outputs = folder.commit()?;
    let list: Vec<String> = written
        .iter()
        .map(|map| format!("  {}: {}, {} bits", map.file, map.channels.join(", "), map.bits))
        .collect();
    let shows = tiling.iter().flat_map(|maps| maps.iter()).filter(|map| map["shows"] == true);
    let warnings: Vec<String> = shows
        .map(|map| {
            format!("the {} map does not tile: its border may show", map["map"].as_str().unwrap_or(""))
        })
        .collect();
    let said = match (&tiling, warnings.is_empty()) {
        (Some(_), true) => "; every map tiles",
        _ => "",
    };
    let text = format!("{}: {} maps{said}\n{}", args.output.display(), written.len(), list.join("\n"));
    Ok(Report::new(text, json).with_outputs(outputs).with_warnings(warnings))
}

/// The maps of a texture: those that its texels hold, where they are facets, and otherwise derived ones.
fn of_texture(path: &Path, border: ReliefBorder, job: &Job) -> Result<MaterialMaps> {
    let opened = input::open(path, job)?;
    match opened.parametric()? {
        Some(models) if *models.model() == TexelModel::Ggx => MaterialMaps::of_facets(&models, border, job),
        _ => MaterialMaps::of_field(&opened.into_field()?.field, border, job),
    }
}

/// How well each map tiles.
fn tiling(maps: &MaterialMaps) -> Vec<Value> {
    let of = |(name, planes): (&'static str, &relume::Planes)| {
        let measured = MeasuredTiling::of_texture(planes);
        json!({ "map": name, "wrap": measured.wrap, "shows": measured.shows })
    };
    maps.planes().into_iter().map(of).collect()
}
