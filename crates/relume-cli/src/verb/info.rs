//! `relume info`: the contents of a file.

use std::fmt::Write;
use std::path::PathBuf;

use relume::capture::pairs::PairEntry;
use relume::direction::Directions;
use relume::field::{Basis, ParametricField};
use relume::format::{Content, FieldFile, tile_set};
use relume::workflow::{Btf, Missing};
use relume::{Direction, Result};
use serde_json::{Value, json};

use crate::context::Context;
use crate::input;
use crate::report::Report;

/// The most numbers of reflectance models that are listed.
const MOST_NAMED: usize = 32;

/// Arguments of `relume info`.
#[derive(Debug, clap::Args)]
#[command(after_help = "Example:\n  relume info wool.ptm\n  relume info --json wool.exr")]
pub struct Args {
    /// A .ptm, an .exr field, a picture, a tile set, or a model; or a folder or .zip of photographs under light and view;
    /// - is standard input
    file: PathBuf,
}

/// Reads the file and describes it.
pub fn run(args: &Args, context: &Context) -> Result<Report> {
    if Btf::is_at(&args.file) {
        return btf(args, context);
    }
    let opened = input::open(&args.file, &context.job)?;
    match opened.content() {
        Content::Model => super::model::describe(&opened.into_model()?),
        Content::Tiles => {
            let set = opened.into_tiles()?;
            let tiles = tile_set::in_words(set.count, &set.cells);
            let (text, mut value) = (text(&set.file), value(&set.file));
            value["tiles"] = json!({ "count": set.count, "cells": set.cells });
            Ok(Report::new(format!("a set of {tiles}\n{text}"), value))
        }
        _ => {
            if let Some(models) = opened.parametric()? {
                return Ok(of_models(&models));
            }
            let file = opened.into_field()?;
            Ok(Report::new(text(&file), value(&file)))
        }
    }
}

/// Describes photographs under light and view by their names and the first of them.
fn btf(args: &Args, context: &Context) -> Result<Report> {
    let btf = Btf::open(&args.file, Missing::Fill, &context.job)?;
    let list = btf.list();
    let first = btf.photograph(0, &context.job)?;
    let (size, channels) = (first.size(), first.channels());
    let largest = |of: fn(&Directions) -> Direction| {
        let polar = |entry: &PairEntry| of(&entry.directions).polar_rad().to_degrees();
        list.entries.iter().map(polar).fold(0.0, f64::max)
    };
    let (light_deg, view_deg) = (largest(|pair| pair.light), largest(|pair| pair.view));
    let mut text = format!(
        "{} photographs of {size}, {channels} channels, under {} lights (to {light_deg:.1} degrees) and {} views (to \
         {view_deg:.1} degrees)",
        list.entries.len(),
        list.lights,
        list.views
    );
    if list.missing_count > 0 {
        let _ = write!(
            text,
            "\n{} of a full grid are missing, first {}",
            list.missing_count,
            list.missing.join(", ")
        );
    }
    let value = json!({
        "basis": "photographs",
        "color": if channels == 1 { "luminance" } else { "rgb" },
        "space": first.samples().space(),
        "width": size.width,
        "height": size.height,
        "photographs": list.entries.len(),
        "channels": channels,
        "light_count": list.lights,
        "view_count": list.views,
        "light_polar_deg": light_deg,
        "view_polar_deg": view_deg,
        "missing": list.missing_count,
    });
    Ok(Report::new(text, value))
}

fn value(file: &FieldFile) -> Value {
    let field = &file.field;
    let planes: Vec<Value> = field
        .plane_names()
        .into_iter()
        .enumerate()
        .map(|(k, name)| {
            let (low, high) = field.coefficients().range(k);
            json!({ "name": name, "min": low, "max": high })
        })
        .collect();
    let lights: Vec<[f64; 3]> = field.lights().iter().map(|light| light.to_array()).collect();
    json!({
        "width": field.size().width,
        "height": field.size().height,
        "basis": field.basis(),
        "color": field.layout(),
        "space": field.space(),
        "encoding": file.encoding,
        "planes": planes,
        "lights": lights,
    })
}

/// The numbers of reflectance models.
fn of_models(models: &ParametricField) -> Report {
    let mut text = format!(
        "{} texels, reflectance model {}, {} numbers a texel, {} values",
        models.size(),
        models.model().name(),
        models.planes().count(),
        models.model().space()
    );
    for (k, name) in models.plane_names().iter().enumerate().take(MOST_NAMED) {
        let (low, high) = models.planes().range(k);
        let _ = write!(text, "\n  {name:<14} {low:>10.4} to {high:>8.4}");
    }
    if models.planes().count() > MOST_NAMED {
        let _ = write!(text, "\n  and {} more", models.planes().count() - MOST_NAMED);
    }
    let plane = |(k, name): (usize, String)| {
        let (low, high) = models.planes().range(k);
        json!({ "name": name, "min": low, "max": high })
    };
    let planes: Vec<Value> = models.plane_names().into_iter().enumerate().map(plane).collect();
    let value = json!({
        "width": models.size().width,
        "height": models.size().height,
        "model": models.model().name(),
        "color": if models.channels() == 1 { "luminance" } else { "rgb" },
        "space": models.model().space(),
        "planes": planes,
    });
    Report::new(text, value)
}

fn text(file: &FieldFile) -> String {
    let field = &file.field;
    let mut text = format!(
        "{} texels, basis {}, colour {}, {} values, {}\n",
        field.size(),
        field.basis().name(),
        field.layout().name(),
        field.space(),
        file.encoding
    );
    for (k, name) in field.plane_names().into_iter().enumerate() {
        let (low, high) = field.coefficients().range(k);
        let _ = writeln!(text, "  {name:<12} {low:>10.4} to {high:>8.4}");
    }
    match field.lights() {
        [] => text.push_str(&directions_of(field.basis())),
        lights => {
            let _ = write!(text, "{} lights", lights.len());
            for light in lights {
                let [x, y, z] = light.to_array();
                let _ = write!(text, "\n  {x:>8.4} {y:>8.4} {z:>8.4}");
            }
        }
    }
    text
}

/// The directions of the photographs that learned functions know.
fn directions_of(basis: &Basis) -> String {
    let Basis::Learned(learned) = basis else { return "lights not recorded".to_owned() };
    let rounded = if learned.packed().is_some() { ", rounded to integers" } else { "" };
    let what = if basis.depends_on_view() { "pairs of light and view" } else { "lights" };
    format!("functions learned from {} {what}{rounded}", learned.pairs().len())
}
