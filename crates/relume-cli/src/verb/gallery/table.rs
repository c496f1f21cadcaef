//! The figures of the gallery as tables: for people, and as comma-separated values (RFC 4180).

use std::fmt::Write;

use super::entry::{DISTANCE, GalleryEntry, GalleryExemplar};

/// Figures of a texture: their names and their paths in the report of `relume compare --texture`.
pub const FIGURES: [(&str, &str); 13] = [
    ("appearance", DISTANCE),
    ("patches", "/mean/sliced"),
    ("patches_worst", "/worst/sliced"),
    ("histogram", "/mean/histogram"),
    ("autocorrelation", "/mean/autocorrelation"),
    ("spectrum_db", "/mean/spectrum_db"),
    ("steerable", "/mean/steerable"),
    ("wrap_x", "/wrap/right_to_left/ratio"),
    ("wrap_y", "/wrap/bottom_to_top/ratio"),
    ("cuts_share", "/seams/share"),
    ("cuts_ratio", "/seams/ratio"),
    ("coverage", "/copying/coverage"),
    ("evenness", "/copying/evenness"),
];

/// All figures, a line for each texture.
pub fn csv(exemplars: &[GalleryExemplar]) -> String {
    let names: Vec<&str> = FIGURES.iter().map(|(name, _)| *name).collect();
    let mut text = format!(
        "exemplar,method,chosen,seconds,processor_seconds,{},largest_piece,copy,best,error\r\n",
        names.join(",")
    );
    for exemplar in exemplars {
        for entry in &exemplar.entries {
            let fields: Vec<String> = line(exemplar, entry).iter().map(|field| quoted(field)).collect();
            let _ = write!(text, "{}\r\n", fields.join(","));
        }
    }
    text
}

fn line(exemplar: &GalleryExemplar, entry: &GalleryEntry) -> Vec<String> {
    let number = |value: Option<f64>| value.map_or(String::new(), |v| v.to_string());
    let mut fields = vec![
        exemplar.name.clone(),
        entry.method.clone(),
        entry.chosen.clone().unwrap_or_default(),
        entry.times.seconds.to_string(),
        number(entry.times.processor_seconds),
    ];
    fields.extend(FIGURES.iter().map(|(_, place)| number(entry.figure(place))));
    fields.push(number(entry.largest_piece));
    fields.extend([entry.is_copy().to_string(), entry.is_best.to_string()]);
    fields.push(entry.error.clone().unwrap_or_default());
    fields
}

/// A field in quotation marks where needed.
fn quoted(field: &str) -> String {
    if field.contains([',', '"', '\r', '\n']) {
        return format!("\"{}\"", field.replace('"', "\"\""));
    }
    field.to_owned()
}

/// The distances in appearance, a line for each exemplar; each line ends in a break.
pub fn text(exemplars: &[GalleryExemplar]) -> String {
    let mut text =
        "distance from the exemplar in appearance; * the nearest, = a verbatim copy, - no texture\n"
            .to_owned();
    let names = exemplars.iter().map(|exemplar| exemplar.name.chars().count());
    let width = names.max().unwrap_or(0).max(8);
    let methods = exemplars.first().map_or(&[][..], |first| &first.entries);
    let _ = write!(text, "{:<width$}", "");
    methods.iter().for_each(|entry| {
        let _ = write!(text, " {:>11}", entry.method);
    });
    for exemplar in exemplars {
        let _ = write!(text, "\n{:<width$}", exemplar.name);
        for entry in &exemplar.entries {
            let mark = match (entry.is_best, entry.is_copy()) {
                (true, _) => "*",
                (_, true) => "=",
                _ => " ",
            };
            let distance = entry.figure(DISTANCE).map_or("-".to_owned(), |d| format!("{d:.2}"));
            let _ = write!(text, " {distance:>10}{mark}");
        }
    }
    text.push('\n');
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn fields_are_quoted_where_they_must_be() {
        assert_eq!(quoted("plain text"), "plain text");
        assert_eq!(quoted("a,b"), "\"a,b\"");
        assert_eq!(quoted("say \"no\"\n"), "\"say \"\"no\"\"\n\"");
    }
}
