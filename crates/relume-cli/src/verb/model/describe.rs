//! The description of a model.

use std::fmt::Write;

use relume::format::rlm;
use relume::random_field::level::Level;
use relume::random_field::neighbourhood::Offset;
use relume::random_field::{FieldModel, Fields, Model, ModelSource, Structure};
use relume::{Direction, Result};
use serde_json::{Value, json};

use crate::report::{Report, counted};

/// The contents and the size of a model.
pub fn describe(field: &FieldModel) -> Result<Report> {
    let bytes = rlm::encode(field)?.len() as u64;
    let models = field.fields.models();
    let text = format!(
        "random field, basis {}, colour {}, {} values{}{}\n{bytes} bytes; {} are {} bytes: 1 to {}",
        field.basis.name(),
        field.layout.name(),
        field.space,
        heights(field),
        models_text(field, &models),
        base(&field.source),
        field.source_bytes(),
        ratio(field.source_bytes() as f64 / bytes as f64),
    );
    let mut json = json!({
        "basis": field.basis.name(),
        "color": field.layout.name(),
        "space": field.space,
        "heights": field.heights,
        "bytes": bytes,
        "source": field.source,
        "source_bytes": field.source_bytes(),
        "ratio": field.source_bytes() as f64 / bytes as f64,
    });
    let mut values = models.iter().map(|(light, model)| model_value(*light, model));
    match &field.fields {
        Fields::Joint(_) => {
            for (name, value) in values.next().iter().flat_map(Value::as_object).flatten() {
                json[name] = value.clone();
            }
        }
        Fields::PerLight(_) => json["lights"] = values.collect(),
        Fields::Clusters(clusters) => {
            json["clusters"] = values.collect();
            json["range_map"] = json!(clusters.range.as_deref().map(|range| model_value(None, range)));
        }
    }
    let details = match &field.fields {
        // Twenty pictures are alike.
        Fields::Clusters(clusters) => {
            details(&clusters.range.iter().map(|range| (None, &**range)).collect::<Vec<_>>())
        }
        Fields::Joint(_) | Fields::PerLight(_) => details(&models),
    };
    Ok(Report::new(text + &details, json))
}

/// A ratio, with a decimal where it is small.
fn ratio(ratio: f64) -> String {
    if ratio < 10.0 { format!("{ratio:.1}") } else { format!("{ratio:.0}") }
}

fn heights(field: &FieldModel) -> String {
    match field.heights.map(|heights| heights.mm_per_texel) {
        None => String::new(),
        Some(None) => ", heights in texels".to_owned(),
        Some(Some(mm)) => format!(", heights of texels of {mm} mm"),
    }
}

fn models_text(field: &FieldModel, models: &[(Option<Direction>, &Model)]) -> String {
    let (_, first) = models[0];
    let count = match &field.fields {
        Fields::Joint(_) => String::new(),
        Fields::PerLight(_) => format!("a model for each of {}, ", counted(models.len(), "light")),
        Fields::Clusters(clusters) => {
            let range = if clusters.range.is_some() { "a range map and " } else { "" };
            format!("{range}a model for each of {} of photographs, ", counted(models.len(), "cluster"))
        }
    };
    format!(
        ": {count}{} of {}, {} of factor {}",
        counted(first.planes(), "plane"),
        counted(first.mixing.components(), "component"),
        counted(first.levels.len(), "level"),
        first.kernel.factor()
    )
}

/// Structure and levels, below a line for each light.
fn details(models: &[(Option<Direction>, &Model)]) -> String {
    let mut text = String::new();
    for (light, model) in models {
        if let Some([x, y, z]) = light.map(Direction::to_array) {
            let _ = write!(text, "\nlight {x:.4} {y:.4} {z:.4}");
        }
        if let Some(structure) = &model.structure {
            let tiles = if structure.tiles == 1 {
                "one tile".to_owned()
            } else {
                format!("{} tiles", structure.tiles)
            };
            let (tile, bytes) = (structure.tile, rlm::structure_bytes(structure));
            let _ = write!(text, "\n  structure: {tiles} of {tile} texels, {bytes} bytes");
        }
        for (k, level) in model.levels.iter().enumerate() {
            let _ = write!(
                text,
                "\n  level {k}: {}, {} in the coarser level, margin {}, log evidence {:.0} over {} texels",
                counted(level.neighbours.len(), "neighbour"),
                level.coarse.len(),
                level.burn_in,
                level.log_evidence,
                level.texels
            );
        }
    }
    text
}

fn model_value(light: Option<Direction>, model: &Model) -> Value {
    let levels: Vec<Value> = model.levels.iter().map(level_value).collect();
    let mut value = json!({
        "planes": model.planes(),
        "components": model.mixing.components(),
        "factor": model.kernel.factor(),
        "structure": model.structure.as_ref().map(structure_value),
        "levels": levels,
    });
    if let Some(light) = light {
        value["light"] = json!(light.to_array());
    }
    value
}

/// The data the model was made from, to which its ratio refers.
fn base(source: &ModelSource) -> String {
    let ModelSource { width, height, photographs, channels } = source;
    match photographs {
        0 => format!("the coefficients of the {width} x {height} texels it is made of, a byte each,"),
        1 => format!("the samples of the picture of {width} x {height} texels it is made of"),
        _ => format!(
            "the samples of the {photographs} photographs of {width} x {height} texels and {} it is made of",
            counted(*channels as usize, "channel")
        ),
    }
}

fn structure_value(structure: &Structure) -> Value {
    json!({
        "tiles": structure.tiles,
        "tile_width": structure.tile.width,
        "tile_height": structure.tile.height,
        "bytes": rlm::structure_bytes(structure),
    })
}

fn level_value(level: &Level) -> Value {
    let places = |offsets: &[Offset]| -> Vec<[i32; 2]> { offsets.iter().map(|o| [o.dx, o.dy]).collect() };
    json!({
        "neighbours": places(&level.neighbours),
        "coarse": places(&level.coarse),
        "margin": level.burn_in,
        "log_evidence": level.log_evidence,
        "texels": level.texels,
    })
}
