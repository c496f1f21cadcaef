//! The report on a fit as one page with everything in it, and as JSON.

use std::fmt::Write;

use relume::render::Relighter;
use relume::workflow::quality::{ComparedWith, LightQuality, QualityReport, quality};
use relume::workflow::tested::ComparedPhotographs;
use relume::{Picture, Planes, ReflectanceField, Result, Size, Space};
use serde_json::{Value, json};

use super::Args;
use super::input::Inputs;
use crate::context::Context;
use crate::html::{escaped, picture_uri};
use crate::output::Outputs;

const TEMPLATE: &str = include_str!("quality.html");

/// Cells of the map of errors along its longer side.
const CELLS: usize = 256;

/// Lights of which pictures are shown, and their largest side in texels.
const SHOWN: usize = 3;
const SHOWN_SIDE: usize = 384;

/// Writes the page that was asked for, and returns the report.
pub(super) fn run(
    args: &Args,
    inputs: &Inputs,
    field: &ReflectanceField,
    fitted: &Value,
    outputs: &mut Outputs,
    context: &Context,
) -> Result<Option<QualityReport>> {
    let Some(path) = &args.report else { return Ok(None) };
    let (page, report) = page(args, inputs, field, fitted, context)?;
    outputs.write(path, page)?;
    Ok(Some(report))
}

fn page(
    args: &Args,
    inputs: &Inputs,
    field: &ReflectanceField,
    fitted: &Value,
    context: &Context,
) -> Result<(Vec<u8>, QualityReport)> {
    let load = |i: usize| inputs.photograph(i, &context.job);
    let lamps = inputs.lamps(field.basis());
    let mut photographs = ComparedPhotographs {
        pairs: inputs.pairs(),
        load: &load,
        lamps: lamps.as_ref(),
        mask: inputs.mask(),
        are_fitted: true,
        set_aside: Vec::new(),
    };
    let report = quality(field, &photographs, CELLS, &context.job).map_err(|e| e.at(inputs.place()))?;
    photographs.set_aside.clone_from(&report.set_aside);
    let json = json!(report);
    let left_out = |i: usize| fitted["lights"][i]["leave_one_out"]["psnr_db"].as_f64();
    let leverage = |i: usize| fitted["lights"][i]["leverage"].as_f64();
    let (map, map_high) = map_uri(&report)?;
    let rows: String =
        report.lights.iter().enumerate().map(|(i, l)| row(l, left_out(i), leverage(i))).collect();
    let fields = [
        ("capture", escaped(&args.capture.display().to_string())),
        ("basis", escaped(field.basis().name())),
        ("size", field.size().to_string()),
        ("count", report.lights.len().to_string()),
        ("facts", facts(&report, fitted)),
        ("warnings", warnings(&report, fitted)),
        ("hemisphere", hemisphere(&report)),
        ("map", map),
        ("map_high", format!("{map_high:.0}")),
        ("worst", worst(&report, &photographs, field, context)?),
        ("second", format!("left out, dB ({} values)", fitted["space"].as_str().unwrap_or("fitted"))),
        ("rows", rows),
        // A name with a tag must not end the script.
        ("json", json!({ "fit": fitted, "quality": json }).to_string().replace('<', "\\u003c")),
    ];
    let fill = |page: String, (name, value): &(&str, String)| page.replace(&format!("{{{{{name}}}}}"), value);
    let page = fields.iter().fold(TEMPLATE.to_owned(), fill).into_bytes();
    Ok((page, report))
}

fn decibels(value: Option<f64>) -> String {
    value.map_or("none".to_owned(), |db| format!("{db:.2}"))
}

fn facts(report: &QualityReport, fitted: &Value) -> String {
    let percent = |share: f64| format!("{:.1} %", 100.0 * share);
    let mut facts = vec![
        ("mean over photographs", crate::decibels::decibels(report.psnr_db)),
        ("each compared with", relit_caption(report.compared).to_owned()),
        (
            "each predicted from the others",
            match fitted["leave_one_out"]["psnr_db"].as_f64() {
                Some(db) => format!("{db:.2} dB ({} values)", fitted["space"].as_str().unwrap_or("fitted")),
                None => "not measured (--leave-one-out)".to_owned(),
            },
        ),
        (
            "condition number",
            fitted["condition_number"].as_f64().map_or("none".into(), |n| format!("{n:.1}")),
        ),
        ("in shadow", percent(report.shadow_share)),
        ("saturated", percent(report.saturated_share)),
        ("directions with a light within 20 degrees", percent(report.coverage.covered_share)),
        ("widest gap", format!("{:.0} degrees", report.coverage.widest_gap_deg)),
    ];
    if let Some(weight) = fitted["ridge"].as_f64() {
        facts.push(("ridge", format!("{weight}")));
    }
    if !report.set_aside.is_empty() {
        let names: Vec<&str> = report.set_aside.iter().map(|&i| report.lights[i].name.as_str()).collect();
        facts.push(("look wrong, and have no part in what the others give", names.join(", ")));
    }
    if report.exact > 0 {
        facts.push(("photographs without an error, left out of the mean", report.exact.to_string()));
    }
    if let Some(rule) = fitted["robust"].as_str().filter(|rule| *rule != "none") {
        facts.push(("robust fit", rule.to_owned()));
    }
    facts.iter().map(|(name, value)| format!("<dt>{name}</dt><dd>{}</dd>", escaped(value))).collect()
}

/// Those of the fit, and of the report.
fn warnings(report: &QualityReport, fitted: &Value) -> String {
    let of_fit = fitted["warnings"].as_array().into_iter().flatten().filter_map(Value::as_str);
    let all: Vec<&str> = of_fit.chain(report.warnings.iter().map(String::as_str)).collect();
    if all.is_empty() {
        return "<p>No photograph looks wrong, and the lights cover the hemisphere.</p>".to_owned();
    }
    let items: String = all.iter().map(|w| format!("<li>{}</li>", escaped(w))).collect();
    format!("<ul class=\"warnings\">{items}</ul>")
}

/// A drawing of the lights from above.
fn hemisphere(report: &QualityReport) -> String {
    let values = report.lights.iter().map(|light| light.psnr_db.min(99.0));
    let (low, high) =
        values.clone().fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), v| (l.min(v), h.max(v)));
    let mut svg = "<svg viewBox=\"-1.1 -1.1 2.2 2.2\" role=\"img\"><circle r=\"1\" fill=\"none\" stroke=\"#999\" \
                   stroke-width=\".008\"/><circle r=\".5\" fill=\"none\" stroke=\"#ddd\" stroke-width=\".006\"/><path d=\"M-1 \
                   0H1M0 -1V1\" stroke=\"#ddd\" stroke-width=\".006\"/>"
        .to_owned();
    for (light, value) in report.lights.iter().zip(values) {
        let [x, y, _] = light.direction;
        let share = if high > low { (value - low) / (high - low) } else { 1.0 };
        let ring = if light.doubts.is_empty() { "#fff" } else { "#000" };
        let _ = write!(
            svg,
            "<circle cx=\"{x:.4}\" cy=\"{:.4}\" r=\".035\" fill=\"hsl({:.0} 75% 45%)\" stroke=\"{ring}\" \
             stroke-width=\".012\"><title>{}: {value:.2} dB</title></circle>",
            -y,
            230.0 * share,
            escaped(&light.name)
        );
    }
    let [x, y, _] = report.coverage.gap;
    let _ = write!(
        svg,
        "<path transform=\"translate({x:.4} {:.4})\" d=\"M-.03 -.03L.03 .03M-.03 .03L.03 -.03\" stroke=\"#000\" \
         stroke-width=\".012\"/></svg><p class=\"dim\">{low:.2} to {high:.2} dB</p>",
        -y
    );
    svg
}

/// The map of errors as a picture, and the error that is white: that which 99 % do not exceed.
fn map_uri(report: &QualityReport) -> Result<(String, f32)> {
    let mut sorted = report.error_map.clone();
    sorted.sort_by(f32::total_cmp);
    let high = sorted[(sorted.len() - 1) * 99 / 100].max(1.0);
    let level = |value: f32| (value / high).clamp(0.0, 1.0);
    let [width, height] = report.map_size;
    // Black, red, yellow, white.
    let channel =
        |c: usize| report.error_map.iter().map(move |v| (3.0 * level(*v) - c as f32).clamp(0.0, 1.0));
    let planes = Planes::from_vec(Size::new(width, height), 3, (0..3).flat_map(channel).collect())?;
    Ok((picture_uri(&Picture { planes, space: Space::Srgb })?, high))
}

fn worst(
    report: &QualityReport,
    photographs: &ComparedPhotographs<'_>,
    field: &ReflectanceField,
    context: &Context,
) -> Result<String> {
    let relighter = Relighter::new(field, &context.job)?;
    let mut html = String::new();
    for &i in report.worst.iter().take(SHOWN) {
        let light = &report.lights[i];
        let photograph = small((photographs.load)(i)?.to_picture(Space::Srgb));
        let relit = small(photographs.relit(field, &relighter, i).to_space(Space::Srgb));
        let difference = difference(&photograph, &relit)?;
        let _ = write!(
            html,
            "<p>{}, {:.2} dB</p><div class=\"worst\">",
            escaped(&light.name),
            light.psnr_db.min(99.0)
        );
        let pictures = [
            (photograph, "the photograph"),
            (relit, relit_caption(report.compared)),
            (difference, "difference, grey where equal"),
        ];
        for (picture, caption) in pictures {
            let uri = picture_uri(&picture)?;
            let _ = write!(
                html,
                "<figure><img src=\"{uri}\" alt=\"\"><figcaption>{caption}</figcaption></figure>"
            );
        }
        html.push_str("</div>");
    }
    Ok(html)
}

/// What a photograph is shown beside.
fn relit_caption(compared: ComparedWith) -> &'static str {
    if compared == ComparedWith::Others { "what the others give under its light" } else { "the fit" }
}

/// A picture of at most [`SHOWN_SIDE`] texels along a side, of means of displayed values.
fn small(mut picture: Picture) -> Picture {
    let size = picture.size();
    picture.planes.as_mut_slice().iter_mut().for_each(|v| *v = v.clamp(0.0, 1.0));
    let step = size.width.max(size.height).div_ceil(SHOWN_SIDE);
    Picture { planes: picture.planes.reduced(step), ..picture }
}

fn difference(a: &Picture, b: &Picture) -> Result<Picture> {
    let pairs = a.planes.as_slice().iter().zip(b.planes.as_slice());
    let data = pairs.map(|(a, b)| (0.5 + a - b).clamp(0.0, 1.0)).collect();
    Ok(Picture { planes: Planes::from_vec(a.size(), a.planes.count(), data)?, space: Space::Srgb })
}

fn row(light: &LightQuality, left_out: Option<f64>, leverage: Option<f64>) -> String {
    let [x, y, z] = light.direction;
    let azimuth = y.atan2(x).to_degrees().rem_euclid(360.0);
    format!(
        "<tr><td>{}</td><td>{}</td><td>{}</td><td>{}</td><td>{:.0}°</td><td>{azimuth:.0}°</td><td>{:.1} %</td><td>{:.1} %\
         </td><td>{:.2}</td><td>{}</td></tr>",
        escaped(&light.name),
        decibels(Some(light.psnr_db)),
        decibels(left_out),
        leverage.map_or(String::new(), |h| format!("{h:.2}")),
        z.clamp(-1.0, 1.0).acos().to_degrees(),
        100.0 * light.shadow_share,
        100.0 * light.saturated_share,
        light.brightness_factor,
        escaped(&light.doubts.join("; "))
    )
}
