//! `relume procedural`: the maps of a built-in material.

use std::path::PathBuf;

use relume::capture::dome::ReliefBorder;
use relume::capture::dome::relief::Relief;
use relume::format::{Depth, HeightFormat, PictureFormat, encode_height, encode_picture};
use relume::maps::SurfaceMaps;
use relume::procedural::{Material, MaterialOptions, Tiling};
use relume::{Error, Picture, Planes, Result, Space};
use serde_json::{Value, json};

use super::material::MaterialArgs;
use crate::context::Context;
use crate::normals;
use crate::output::Folder;
use crate::report::Report;

/// Arguments of `relume procedural`.
#[derive(Debug, clap::Args)]
#[command(after_help = "Examples:\n  relume procedural marble -o marble --tile\n  \
                        relume procedural wood -o wood --cut end --size 512x512\n  \
                        relume procedural fire -o fire --phi -0.25")]
pub struct Args {
    /// The material: sponge, weave, pebbles, leather, bark, marble, wood, clouds or fire
    material: String,
    /// The folder to write: albedo.png, height.png (16 bits, range recorded), roughness.png,
    /// normals_gl.png, material.json
    #[arg(short, long, value_name = "DIR")]
    output: PathBuf,
    /// Make the maps periodic, so that they repeat without a seam
    #[arg(long)]
    tile: bool,
    #[command(flatten)]
    options: MaterialArgs,
}

/// Makes the maps and writes them.
pub fn run(args: &Args, context: &Context) -> Result<Report> {
    let material = Material::from_name(&args.material).ok_or_else(|| {
        let names = Material::ALL.map(Material::name).join(", ");
        Error::usage(format!("there is no material '{}': choose one of {names}", args.material))
    })?;
    let tiling = if args.tile { Tiling::Torus } else { Tiling::Free };
    let options = args.options.options(tiling);
    let folder = Folder::stage(&args.output, &[], context)?;
    let maps = material.make(&options, &context.job)?;
    write(&maps, tiling, &folder)?;
    let json = description(args, material, &options, &maps);
    folder.add("material.json", format!("{json:#}\n").as_bytes())?;
    let written = folder.commit()?;
    let (low, high) = maps.height.range(0);
    let text = format!(
        "{}: {}, {} texels, heights {low:.2} to {high:.2} texels",
        args.output.display(),
        material.name(),
        maps.size()
    );
    Ok(Report::new(text, json).with_outputs(written))
}

fn write(maps: &SurfaceMaps, tiling: Tiling, folder: &Folder) -> Result<()> {
    let border = if tiling == Tiling::Torus { ReliefBorder::Wrap } else { ReliefBorder::Clamp };
    let albedo = Picture { planes: maps.albedo.clone(), space: Space::Linear };
    folder.add("albedo.png", &encode_picture(&albedo, PictureFormat::Png(Depth::Eight))?)?;
    folder.add("height.png", &encode_height(&maps.height, None, HeightFormat::Png)?)?;
    if let Some(roughness) = &maps.roughness {
        folder.add(
            "roughness.png",
            &encode_picture(&data(roughness.clone()), PictureFormat::Png(Depth::Eight))?,
        )?;
    }
    let normals = Relief::new(&maps.height, border).normals();
    folder.add("normals_gl.png", &normals::encode(&normals, PictureFormat::Png(Depth::Sixteen))?)
}

/// Data as a picture, declared as encoded, so that the codes are the values themselves.
fn data(planes: Planes) -> Picture {
    Picture { planes, space: Space::Srgb }
}

fn description(args: &Args, material: Material, options: &MaterialOptions, maps: &SurfaceMaps) -> Value {
    let (low, high) = maps.height.range(0);
    json!({
        "material": material.name(),
        "width": options.size.width,
        "height": options.size.height,
        "seed": options.seed,
        "feature_texels": options.feature,
        "tile": args.tile,
        "height_texels": { "file": "height.png", "lowest": low, "highest": high },
        "albedo_srgb": "albedo.png",
        "roughness": "roughness.png",
        "normals_y_up": "normals_gl.png",
    })
}
