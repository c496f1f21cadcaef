//! Photographs under light and view, by their names and the first of them.

use std::fmt::Write;
use std::path::Path;

use relume::capture::pairs::PairEntry;
use relume::direction::Directions;
use relume::workflow::{Btf, Missing};
use relume::{Direction, Result};
use serde_json::json;

use crate::context::Context;
use crate::report::{Report, counted};

/// Describes photographs under light and view by their names and the first of them.
pub(super) fn describe(path: &Path, context: &Context) -> Result<Report> {
    let btf = Btf::open(path, Missing::Fill, &context.job)?;
    let list = btf.list();
    let first = btf.photograph(0, &context.job)?;
    let (size, channels) = (first.size(), first.channels());
    let largest = |of: fn(&Directions) -> Direction| {
        let polar = |entry: &PairEntry| of(&entry.directions).polar_rad().to_degrees();
        list.entries.iter().map(polar).fold(0.0, f64::max)
    };
    let (light_deg, view_deg) = (largest(|pair| pair.light), largest(|pair| pair.view));
    let mut text = format!(
        "{} of {size}, {}, under {} (to {light_deg:.1} degrees) and {} (to {view_deg:.1} degrees)",
        counted(list.entries.len(), "photograph"),
        counted(channels, "channel"),
        counted(list.lights, "light"),
        counted(list.views, "view")
    );
    if list.lights * list.views != list.entries.len() + list.missing_count {
        text.push_str(", single pairs and no grid");
    }
    if let Some(stored) = btf.stored() {
        let _ = write!(text, "\nstored as {stored}");
    }
    if list.missing_count > 0 {
        let _ = write!(
            text,
            "\n{} of a full grid {} missing, first {}",
            list.missing_count,
            if list.missing_count == 1 { "is" } else { "are" },
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
        "stored": btf.stored().map(|stored| json!({
            "kind": format!("{:?}", stored.kind).to_lowercase(),
            "functions": stored.components,
            "bits": stored.scalar.bits(),
        })),
    });
    Ok(Report::new(text, value))
}
