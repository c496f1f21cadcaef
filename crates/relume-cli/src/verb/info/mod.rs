//! `relume info`: the contents of a file.

mod btf;
mod nonlinear;

use std::collections::BTreeSet;
use std::fmt::Write;
use std::path::PathBuf;

use relume::direction::Directions;
use relume::field::{Basis, NonlinearField};
use relume::format::{Content, FieldFile, FileOutline, HeightScale, MapRecord, tile_set};
use relume::workflow::Btf;
use relume::{Direction, Result};
use serde_json::{Value, json};

use crate::context::Context;
use crate::input;
use crate::report::{Report, counted};

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
        return btf::describe(&args.file, context);
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
            if let Some(outline) = opened.outline()? {
                return Ok(of_outline(&outline));
            }
            let own = opened.nonlinear()?.map(|(own, _)| own);
            if let Some(NonlinearField::Models(models)) = &own {
                return Ok(nonlinear::models(models));
            }
            let record = opened.record()?;
            let file = opened.into_field()?;
            let (mut text, mut value) = (text(&file), value(&file));
            text.extend(recorded(&record, &file));
            value["opacity"] = json!(file.opacity.is_some());
            value["record"] =
                json!({ "heights": record.heights.map(of_heights), "normal_y": record.normal_y });
            if let Some(NonlinearField::Clusters(clusters)) = &own {
                text = format!("{}\n{text}", nonlinear::clusters_in_words(clusters));
                value["clusters"] = nonlinear::clusters(clusters);
            }
            Ok(Report::new(text, value))
        }
    }
}

/// What a file says of its values, a line each.
fn recorded(record: &MapRecord, file: &FieldFile) -> Vec<String> {
    let heights = record.heights.map(|scale| {
        let mm = scale.mm_per_texel.map_or(String::new(), |mm| format!(", of {mm} mm each"));
        format!("recorded: heights, {:.4} + {:.4} times the value, in texels{mm}", scale.offset, scale.step)
    });
    let normals = record.normal_y.map(|y| format!("recorded: normals ({})", y.in_words()));
    let opacity = file.opacity.is_some().then(|| "with an opacity (alpha)".to_owned());
    [heights, normals, opacity].into_iter().flatten().map(|line| format!("\n{line}")).collect()
}

fn of_heights(scale: HeightScale) -> Value {
    json!({ "offset_texels": scale.offset, "step_texels": scale.step, "mm_per_texel": scale.mm_per_texel })
}

/// A file for other programs.
fn of_outline(outline: &FileOutline) -> Report {
    let mut text = outline.what.to_owned();
    for (name, said) in &outline.parts {
        let _ = write!(text, "\n  {name}: {said}");
    }
    let parts: Vec<Value> =
        outline.parts.iter().map(|(name, said)| json!({ "name": name, "holds": said })).collect();
    Report::new(text, json!({ "kind": outline.what, "parts": parts }))
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
        [] => text.push_str(&directions_of(field.basis())),
        lights => {
            text.push_str(&counted(lights.len(), "light"));
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
    let count = learned.pairs().len();
    let what = match (basis.depends_on_view(), count) {
        (true, 1) => "1 pair of light and view".to_owned(),
        (true, _) => format!("{count} pairs of light and view"),
        (false, _) => counted(count, "light"),
    };
    let [lights, views] =
        [pair_count(learned.pairs(), |pair| pair.light), pair_count(learned.pairs(), |pair| pair.view)];
    let grid = match basis.depends_on_view() {
        true if lights * views == learned.pairs().len() => format!(", {lights} lights x {views} views"),
        true => format!(", {} and {}", counted(lights, "light"), counted(views, "view")),
        false => String::new(),
    };
    format!("functions learned from {what}{grid}{rounded}")
}

/// The number of distinct lights or views.
fn pair_count(pairs: &[Directions], of: fn(&Directions) -> Direction) -> usize {
    let bits = |pair: &Directions| of(pair).to_array().map(f64::to_bits);
    pairs.iter().map(bits).collect::<BTreeSet<_>>().len()
}
