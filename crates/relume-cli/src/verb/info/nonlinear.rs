//! Textures that are not linear in the numbers of their texels.

use std::fmt::Write;

use relume::field::{ClusteredField, ParametricField};
use serde_json::{Value, json};

use crate::report::Report;

/// The most numbers of reflectance models that are listed.
const MOST_NAMED: usize = 32;

/// What is said of texels in clusters before the functions of their linear form.
pub(super) fn clusters_in_words(field: &ClusteredField) -> String {
    format!(
        "texels in {} clusters of {} axes: {} numbers a texel, read as the {} functions that follow",
        field.spaces().clusters(),
        field.spaces().axes(),
        field.planes().count(),
        field.spaces().functions()
    )
}

/// The same for programs.
pub(super) fn clusters(field: &ClusteredField) -> Value {
    let labels = field.planes().plane(0);
    let texels = |cluster: usize| labels.iter().filter(|label| **label == cluster as f32).count();
    let sizes: Vec<usize> = (0..field.spaces().clusters()).map(texels).collect();
    json!({ "count": field.spaces().clusters(), "axes": field.spaces().axes(), "texels": sizes })
}

/// The numbers of reflectance models.
pub(super) fn models(models: &ParametricField) -> Report {
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
