//! `relume procedural`: the maps of a built-in material.

use std::path::PathBuf;

use relume::capture::dome::ReliefBorder;
use relume::capture::dome::relief::Relief;
use relume::format::{
    Depth, HeightFormat, NormalY, PictureFormat, encode_data_map, encode_height_with, encode_normals,
    encode_picture_with,
};
use relume::maps::SurfaceMaps;
use relume::procedural::{Material, MaterialOptions, Tiling};
use relume::{Error, Footprint, Job, Picture, Result, Size, Space};
use serde_json::{Value, json};

use super::material::MaterialArgs;
use crate::context::Context;
use crate::output::Folder;
use crate::report::Report;
use crate::{args, normals};

/// Arguments of `relume procedural`.
#[derive(Debug, clap::Args)]
#[command(after_help = "Examples:\n  relume procedural marble -o marble --tile\n  \
                        relume procedural wood -o wood --cut end --size 512x512\n  \
                        relume procedural fire -o fire --phi -0.25")]
pub struct Args {
    /// The material: sponge, weave, pebbles, leather, bark, marble, wood, clouds or fire
    material: String,
    /// The folder to write: albedo.png, height.png (16 bits, range recorded), roughness.png,
    /// normals_gl.png (or normals_dx.png), material.json
    #[arg(short, long, value_name = "DIR")]
    output: PathBuf,
    /// Make the maps periodic, so that they repeat without a seam
    #[arg(long)]
    tile: bool,
    /// Direction of the green channel of the normal map: up (normals_gl.png) or down (normals_dx.png)
    #[arg(long, value_name = "Y", default_value = "up", value_parser = args::named::<NormalY>())]
    normal_y: NormalY,
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
    context.job.check_bytes("the maps and their files", footprint(options.size).peak)?;
    let maps = material.make(&options, &context.job)?;
    write(&maps, tiling, args.normal_y, &folder, &context.job)?;
    let json = description(args, material, &options, &maps);
    folder.add("material.json", format!("{json:#}\n").as_bytes())?;
    let written = folder.commit()?;
    let (low, high) = maps.height.range(0);
    let text = format!(
        "{}: {}, {} texels, heights {low:.2} to {high:.2} texels, {}",
        args.output.display(),
        material.name(),
        maps.size(),
        normals::described(args.normal_y)
    );
    Ok(Report::new(text, json).with_outputs(written))
}

/// The file of the normals.
fn normals_file(y: NormalY) -> &'static str {
    match y {
        NormalY::Up => "normals_gl.png",
        NormalY::Down => "normals_dx.png",
    }
}

/// The memory of the maps and of writing them: the relief with its continuation, and normals made of it, take the
/// most.
fn footprint(size: Size) -> Footprint {
    let relief = Footprint::of_texels(size, 12 + 12, 12);
    let normals = PictureFormat::Png(Depth::Sixteen).normals_footprint(size);
    MaterialOptions::footprint(size).then(relief.then(normals))
}

fn write(maps: &SurfaceMaps, tiling: Tiling, y: NormalY, folder: &Folder, job: &Job) -> Result<()> {
    let border = if tiling == Tiling::Torus { ReliefBorder::Wrap } else { ReliefBorder::Clamp };
    let albedo = Picture { planes: maps.albedo.clone(), space: Space::Linear };
    folder.add("albedo.png", &encode_picture_with(&albedo, PictureFormat::Png(Depth::Eight), job)?)?;
    folder.add("height.png", &encode_height_with(&maps.height, None, HeightFormat::Png, job)?)?;
    if let Some(roughness) = &maps.roughness {
        folder.add("roughness.png", &encode_data_map(roughness, Depth::Eight, job)?)?;
    }
    let normals = Relief::new(&maps.height, border).normals();
    folder.add(normals_file(y), &encode_normals(&normals, y, PictureFormat::Png(Depth::Sixteen), job)?)
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
        "normals": normals_file(args.normal_y),
        "normal_y": args.normal_y,
    })
}
