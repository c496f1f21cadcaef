//! The page of the demo: one file with all pictures embedded, around the pages of the viewer beside it.

use std::fmt::Write;
use std::fs;
use std::path::Path;

use relume::format::{Depth, PictureFormat, encode_picture, open, read_field};
use relume::{Error, Picture, Planes, Result, Size, Space};
use serde_json::Value;

use super::Args;
use super::viewers::Viewers;
use crate::context::Context;
use crate::html::png_uri;

const TEMPLATE: &str = include_str!("page.html");

/// The view in which the cloth of light and view is first seen.
const CLOTH: &str =
    "object=cloth&amp;repeat=2&amp;near=1.2&amp;azimuth=-30&amp;elevation=10&amp;lights=-0.3,0.5,ffffff,1.2";

/// What the page says of fits.
#[derive(Debug)]
pub struct DemoFits<'a> {
    /// Of the photographs under moving light.
    pub light: &'a Value,
    /// Of those under light and view.
    pub light_view: &'a Value,
}

/// Decibels in words.
fn decibels(value: &Value) -> String {
    value.as_f64().map_or("no".to_owned(), |db| format!("{db:.1}"))
}

/// Fills the template from the files of the folder.
pub fn write(
    folder: &Path,
    args: &Args,
    fits: &DemoFits<'_>,
    commands: &[String],
    viewers: &Viewers,
    context: &Context,
) -> Result<String> {
    let small = read_field(&folder.join("small.ptm"), &context.job)?.field;
    let large = read_field(&folder.join("large.ptm"), &context.job)?.field;
    let tiles = open(&folder.join("tiles.ptm"), &context.job)?.into_tiles()?;
    let lights = fits.light["lights"].as_array().map(Vec::as_slice).unwrap_or_default();
    let worst = lights.iter().filter_map(|l| l["psnr_db"].as_f64()).fold(f64::INFINITY, f64::min);
    write_source_picture(folder, small.size(), context)?;
    let fields = [
        ("lights", args.lights.to_string()),
        ("exemplar", small.size().to_string()),
        ("size", large.size().to_string()),
        ("material", args.material.clone()),
        ("psnr", decibels(&fits.light["error"]["psnr_db"])),
        ("worst", format!("{worst:.1}")),
        ("tiles", tiles.count.to_string()),
        ("tile", tiles.cells.bounds().to_string()),
        ("noise_size", viewers.noise_size.to_string()),
        ("noise_planes", viewers.noise_planes.to_string()),
        ("light_view_functions", fits.light_view["functions"].to_string()),
        ("light_view_photographs", fits.light_view["fitted"]["pairs"].to_string()),
        ("light_view_psnr", decibels(&fits.light_view["error"]["psnr_db"])),
        ("light_view_place", CLOTH.to_owned()),
        ("commands", commands.join("\n")),
    ];
    let fields = fields.into_iter().chain(rows(folder, args)?);
    let filled =
        |page: String, (name, value): (&str, String)| page.replace(&format!("{{{{{name}}}}}"), &value);
    Ok(fields.fold(TEMPLATE.to_owned(), filled))
}

/// The rows of pictures by their names in the template.
fn rows(folder: &Path, args: &Args) -> Result<Vec<(&'static str, String)>> {
    let figures = |files: &[(&str, &str)]| figures(folder, files);
    let photographs = photographs(folder, args.lights)?;
    let photographs: Vec<(&str, &str)> =
        photographs.iter().map(|(file, text)| (file.as_str(), text.as_str())).collect();
    Ok(vec![
        ("photographs", figures(&photographs)?),
        (
            "fitted",
            figures(&[
                ("orbit.png", "relit, the light going round"),
                ("normals_gl.png", "normals, +Y: green points up"),
                ("albedo.png", "each texel at its brightest"),
            ])?,
        ),
        (
            "synthesis",
            figures(&[
                ("large.png", "the large texture; it tiles"),
                ("source.png", "where each texel comes from: red is x, green is y in the small one"),
            ])?,
        ),
        (
            "comparison",
            figures(&[
                ("sphere.png", "reflectance texture"),
                ("sphere_plain.png", "one photograph as a plain texture"),
                ("cloth.png", "reflectance texture on cloth"),
            ])?,
        ),
        (
            "views",
            figures(&[
                ("view_above.png", "from straight above"),
                ("view_left.png", "from the left"),
                ("view_right.png", "from the right"),
                ("view_below.png", "from the lower edge"),
            ])?,
        ),
    ])
}

/// Four photographs spread over the lights, with captions.
fn photographs(folder: &Path, lights: u32) -> Result<Vec<(String, String)>> {
    let path = folder.join("capture/lights.lp");
    let text = fs::read(&path).map_err(|e| Error::io("cannot read", &e).at(&path))?;
    let entries = relume::capture::lp::parse(&text).map_err(|e| e.at(&path))?;
    let wanted = [0, lights as usize / 3, lights as usize * 2 / 3, lights as usize - 1];
    let caption = |light: relume::Direction| {
        let [x, y, z] = light.to_array();
        format!("light {x:.2}, {y:.2}, {z:.2}")
    };
    let chosen = wanted.into_iter().filter_map(|i| entries.get(i));
    Ok(chosen.map(|entry| (format!("capture/{}", entry.name), caption(entry.light))).collect())
}

/// Pictures with captions.
fn figures(folder: &Path, files: &[(&str, &str)]) -> Result<String> {
    let mut html = String::new();
    for (file, caption) in files {
        let uri = data_uri(&folder.join(file))?;
        let _ = write!(
            html,
            "<figure><img alt=\"{caption}\" src=\"{uri}\"><figcaption>{caption}</figcaption></figure>"
        );
    }
    Ok(html)
}

fn data_uri(path: &Path) -> Result<String> {
    let bytes = fs::read(path).map_err(|e| Error::io("cannot read", &e).at(path))?;
    Ok(png_uri(&bytes))
}

/// Writes the source map as colours, as a PNG.
fn write_source_picture(folder: &Path, exemplar: Size, context: &Context) -> Result<()> {
    let path = folder.join("source.npy");
    let array = open(&path, &context.job)?.into_array()?;
    let mut planes = Planes::zeros(array.size, 3);
    for (k, side) in [exemplar.width, exemplar.height].into_iter().enumerate() {
        let sources = array.values.iter().skip(k).step_by(array.components);
        planes.plane_mut(k).iter_mut().zip(sources).for_each(|(out, &v)| *out = v as f32 / side as f32);
    }
    let bytes = encode_picture(&Picture { planes, space: Space::Srgb }, PictureFormat::Png(Depth::Eight))?;
    let source = folder.join("source.png");
    fs::write(&source, bytes).map_err(|e| Error::io("cannot write", &e).at(&source))
}
