//! The page of the gallery: one file with all pictures embedded.

use std::fmt::Write;

use serde_json::Value;

use super::Args;
use super::entry::{DISTANCE, GalleryEntry, GalleryExemplar};
use crate::html::escaped;

const TEMPLATE: &str = include_str!("page.html");

/// The page as HTML.
pub fn html(exemplars: &[GalleryExemplar], args: &Args) -> String {
    let sections: String =
        exemplars.iter().enumerate().map(|(number, exemplar)| section(number, exemplar)).collect();
    let fields = [
        ("folder", escaped(&args.folder.display().to_string())),
        ("seed", args.seed.to_string()),
        ("summary", summary(exemplars)),
        ("sections", sections),
    ];
    fields
        .iter()
        .fold(TEMPLATE.to_owned(), |page, (name, value)| page.replace(&format!("{{{{{name}}}}}"), value))
}

/// The table of distances in appearance.
fn summary(exemplars: &[GalleryExemplar]) -> String {
    let mut html = "<table><thead><tr><th></th>".to_owned();
    for entry in exemplars.first().map_or(&[][..], |first| &first.entries) {
        let _ = write!(html, "<th>{}</th>", escaped(&entry.method));
    }
    html.push_str("</tr></thead><tbody>");
    for (number, exemplar) in exemplars.iter().enumerate() {
        let _ = write!(html, "<tr><th><a href=\"#e{number}\">{}</a></th>", escaped(&exemplar.name));
        exemplar.entries.iter().for_each(|entry| html.push_str(&cell(entry)));
        html.push_str("</tr>");
    }
    html + "</tbody></table>"
}

fn cell(entry: &GalleryEntry) -> String {
    let class = if entry.is_best {
        " class=\"best\""
    } else if entry.is_copy() {
        " class=\"copy\""
    } else {
        ""
    };
    let why = escaped(entry.error.as_deref().unwrap_or_default());
    match entry.figure(DISTANCE) {
        Some(distance) => format!("<td{class}>{distance:.2}</td>"),
        None => format!("<td class=\"none\" title=\"{why}\">none</td>"),
    }
}

/// An exemplar with its textures.
fn section(number: usize, exemplar: &GalleryExemplar) -> String {
    let mut html = format!("<section id=\"e{number}\"><h2>{}</h2>", escaped(&exemplar.name));
    let _ = write!(html, "<p class=\"dim\">{}</p>", about(exemplar));
    html.push_str("<div class=\"row\">");
    let size = format!("{} x {}", exemplar.width, exemplar.height);
    let widest = exemplar.width.max(exemplar.output_width).max(1);
    // Both at one scale: texels of the exemplar as large as those of its textures.
    let picture = |name: &str, jpeg: Option<&str>, width: usize| picture(name, jpeg, width, widest);
    let own = picture("exemplar", exemplar.preview.as_deref(), exemplar.width);
    html.push_str(&figure("exemplar", &own, "", &size, ""));
    for entry in &exemplar.entries {
        let class = if entry.is_best { "best" } else { "" };
        let shown = picture(&entry.method, entry.preview.as_deref(), exemplar.output_width);
        html.push_str(&figure(&entry.method, &shown, class, &figures(entry), &entry.command));
    }
    html + "</div></section>"
}

/// The analysis of an exemplar.
fn about(exemplar: &GalleryExemplar) -> String {
    let text = |place: &str| exemplar.analysis.pointer(place).and_then(Value::as_str).map(escaped);
    let mut html = text("/advice/reason").or(text("/error")).unwrap_or_default();
    let warnings = exemplar.analysis["warning_codes"].as_array().map(Vec::as_slice).unwrap_or_default();
    for warning in warnings.iter().filter_map(Value::as_str) {
        let _ = write!(html, " <span class=\"warning\">{}</span>", escaped(&warning.replace('_', " ")));
    }
    let (width, height) = (exemplar.output_width, exemplar.output_height);
    if let Some(command) = &exemplar.factored {
        let _ =
            write!(html, "<br>Photographs under light and view, factored: <code>{}</code>", escaped(command));
    }
    let _ = write!(html, "<br>Textures of {width} x {height} texels.");
    html
}

/// A picture of a texture as wide as its share of the widest one.
fn picture(name: &str, preview: Option<&str>, width: usize, widest: usize) -> String {
    let share = 100.0 * width as f64 / widest as f64;
    match preview {
        Some(jpeg) => format!(
            "<img style=\"width: {share:.4}%\" alt=\"{}\" src=\"data:image/jpeg;base64,{jpeg}\">",
            escaped(name)
        ),
        None => "<div class=\"missing\">no texture</div>".to_owned(),
    }
}

fn figure(name: &str, picture: &str, class: &str, caption: &str, title: &str) -> String {
    format!(
        "<figure class=\"{class}\" title=\"{}\">{picture}<figcaption><b>{}</b> {caption}</figcaption></figure>",
        escaped(title),
        escaped(name)
    )
}

/// The figures of a texture, or the reason why there are none, as HTML.
fn figures(entry: &GalleryEntry) -> String {
    if let Some(error) = &entry.error {
        return format!("<span class=\"error\">{}</span>", escaped(error));
    }
    let number = |place: &str, digits: usize| {
        entry.figure(place).map_or("none".to_owned(), |value| format!("{value:.digits$}"))
    };
    let time = entry
        .times
        .processor_seconds
        .map_or(format!("{:.2} s", entry.times.seconds), |processor| format!("{processor:.2} processor s"));
    let mut rows = vec![
        ("appearance", number(DISTANCE, 2)),
        ("patches", number("/mean/sliced", 4)),
        ("spectrum", format!("{} dB", number("/mean/spectrum_db", 2))),
        ("steerable pyramid", number("/mean/steerable", 4)),
        ("autocorrelation", number("/mean/autocorrelation", 3)),
        (
            "wrap",
            format!("{}, {}", number("/wrap/right_to_left/ratio", 2), number("/wrap/bottom_to_top/ratio", 2)),
        ),
    ];
    if let Some(piece) = entry.largest_piece {
        rows.push(("cuts", number("/seams/ratio", 2)));
        rows.push((
            "coverage, evenness",
            format!("{}, {}", number("/copying/coverage", 2), number("/copying/evenness", 2)),
        ));
        rows.push(("largest piece", format!("{:.0} %", 100.0 * piece)));
    }
    let mut html = time;
    if let Some(chosen) = &entry.chosen {
        let _ = write!(html, "<br><code>{}</code>", escaped(chosen));
    }
    html.push_str("<dl>");
    for (name, value) in rows {
        let _ = write!(html, "<dt>{name}</dt><dd>{value}</dd>");
    }
    html + "</dl>"
}
