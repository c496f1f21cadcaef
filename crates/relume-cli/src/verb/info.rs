//! `relume info`: the contents of a file.

use std::fmt::Write;
use std::path::PathBuf;

use relume::Result;
use relume::format::{Content, FieldFile, tile_set};
use serde_json::{Value, json};

use crate::context::Context;
use crate::input;
use crate::report::Report;

/// Arguments of `relume info`.
#[derive(Debug, clap::Args)]
#[command(after_help = "Example:\n  relume info wool.ptm\n  relume info --json wool.exr")]
pub struct Args {
    /// A .ptm, an .exr field, a picture, a tile set, or a model; - is standard input
    file: PathBuf,
}

/// Reads the file and describes it.
pub fn run(args: &Args, context: &Context) -> Result<Report> {
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
            let file = opened.into_field()?;
            Ok(Report::new(text(&file), value(&file)))
        }
    }
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
        [] => text.push_str("lights not recorded"),
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
