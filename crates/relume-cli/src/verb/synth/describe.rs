//! The report of `relume synth`: what the method did, and how it was chosen.

use std::fmt::Write;
use std::path::{Path, PathBuf};

use relume::analysis::{Extents, Warning};
use relume::metric::texture::Appearance;
use relume::synthesis::elements::{ElementOptions, ElementsLaid};
use relume::synthesis::pixel::patch_match::Optimised;
use relume::synthesis::pixel::wei_levoy::Scanned;
use relume::synthesis::pixel::{EfrosLeungOptions, Growth, PatchMatchOptions, WeiLevoyOptions};
use relume::synthesis::roller::Rolled;
use relume::synthesis::{BlockOptions, Boundary, SourceMap, StageTimes, SynthesisReport};
use relume::workflow::auto::{Choice, Score, Try};
use relume::workflow::fitted::Advised;
use relume::workflow::method::LaidTiles;
use relume::workflow::tiling::MeasuredTiling;
use relume::workflow::{MethodReport, Outcome, Plan, SynthOptions, SynthesisMethod};
use relume::{Named, Size};
use serde_json::{Value, json};

use crate::report::{Report, counted};
use crate::tiling::with_tiling;
use crate::verb::analyze;
use relume::format::tile_set::in_words;

/// The report of the texture written to `output` as `asked`, from these files, and of how well it tiles.
pub fn describe(
    output: &Path,
    asked: &SynthOptions,
    (outcome, tiling): &(Outcome, Option<MeasuredTiling>),
    files: &[PathBuf],
) -> Report {
    let map = &outcome.made.map;
    let texels = |how: String, special: Value| texel_report(output, asked, map.size(), &how, &special);
    let report = match (&outcome.plan, &outcome.made.how) {
        (Plan::Quilting(options), MethodReport::Quilting(report, times)) => {
            block_report(output, options, map, report, times)
        }
        (Plan::EfrosLeung(options), MethodReport::EfrosLeung(growth)) => {
            texels(growth_in_words(options, growth), growth_as_json(options, growth))
        }
        (Plan::WeiLevoy(options, _), MethodReport::WeiLevoy(scanned)) => {
            texels(scan_in_words(options, scanned), scan_as_json(options, scanned))
        }
        (Plan::PatchMatch(options), MethodReport::PatchMatch(optimised)) => {
            texels(optimisation_in_words(options, optimised), optimisation_as_json(options, optimised))
        }
        (Plan::Roller(laid), MethodReport::Roller(rolled)) => roller_report(output, laid, rolled),
        (Plan::Elements(options), MethodReport::Elements(laid)) => elements_report(output, options, laid),
        _ => unreachable!("a plan's result is of its own method"),
    };
    let remedy = "try another --seed or --method, or make it without --tile and close it by relume tileable";
    let report = with_tiling(report, tiling.as_ref(), remedy);
    let report = match &outcome.advised {
        Some(advised) => with_advised(report, advised, tiling.map(|_| map.size())),
        None => report,
    };
    match &outcome.choice {
        Some(choice) => with_choice(report, choice, files),
        None => report,
    }
}

/// The report with the sizes that were fitted to the exemplars, and what they follow from; `tile` is the size of a texture that
/// was made to tile.
fn with_advised(mut report: Report, advised: &Advised, tile: Option<Size>) -> Report {
    let lengths = |extents: &Extents| {
        let feature = match extents.feature {
            Some(feature) => format!("features of {feature:.1} texels"),
            None => "features as large as half the exemplar".to_owned(),
        };
        let period = extents.period.map(|period| format!(" and periods of {period:.1}"));
        feature + &period.unwrap_or_default()
    };
    let each: Vec<String> = advised.extents.iter().map(lengths).collect();
    let _ = write!(report.text, "\n{} fitted to {}", advised.chosen.join(" and "), each.join(", "));
    report.json["advised"] = json!(advised);
    let warning = advised.extents.iter().find_map(Extents::warning);
    let broken = tile.and_then(|size| advised.extents.iter().find_map(|found| found.whole_repeats(size)).map(|whole| {
        format!(
            "the pattern does not repeat a whole number of times in {size} texels, so it breaks or bends somewhere: --size {}x{} holds whole periods, \
             and --method roller makes tiles of them",
            whole.width, whole.height
        )
    }));
    report.with_warnings(warning.map(Warning::sentence)).with_warnings(broken)
}

fn block_report(
    output: &Path,
    options: &BlockOptions,
    map: &SourceMap,
    how: &SynthesisReport,
    times: &StageTimes,
) -> Report {
    let drawn = how.placements.len().saturating_sub(1).max(1);
    let candidates = how.candidates as f64 / drawn as f64;
    let is_closed = options.boundary == Boundary::Torus;
    let text = format!(
        "{}: {} texels from {} x {} blocks of {}, drawn from {} positions, {candidates:.1} candidates a \
         block",
        output.display(),
        map.size(),
        how.columns,
        how.rows,
        options.block,
        how.positions,
    );
    let json = json!({
        "width": map.size().width,
        "height": map.size().height,
        "block": options.block,
        "overlap": options.overlap,
        "blend": options.blend,
        "feather": options.feather,
        "tile": is_closed,
        "seed": options.seed,
        "blended_texels": map.mix_count(),
        "search": options.search,
        "times": times,
        "synthesis": how,
    });
    Report::new(text, json)
}

fn growth_in_words(options: &EfrosLeungOptions, growth: &Growth) -> String {
    format!(
        "grown texel by texel from windows of {}, drawn from {} positions, {:.1} candidates a texel",
        options.window,
        growth.positions,
        growth.candidates as f64 / growth.texels.max(1) as f64
    )
}

fn growth_as_json(options: &EfrosLeungOptions, growth: &Growth) -> Value {
    json!({ "window": options.window, "epsilon": options.epsilon, "synthesis": growth })
}

fn scan_in_words(options: &WeiLevoyOptions, scanned: &Scanned) -> String {
    format!(
        "row by row at {} from windows of {}, near ones of {}",
        counted(options.levels, "level"),
        options.window,
        counted(scanned.neighbourhoods, "neighbourhood")
    )
}

fn scan_as_json(options: &WeiLevoyOptions, scanned: &Scanned) -> Value {
    let WeiLevoyOptions { window, levels, search, .. } = *options;
    json!({ "window": window, "levels": levels, "search": search, "synthesis": scanned })
}

fn optimisation_in_words(options: &PatchMatchOptions, optimised: &Optimised) -> String {
    format!(
        "improved up to {} at {} by patches of {}, matched to {}",
        counted(options.rounds, "time"),
        counted(optimised.levels, "level"),
        options.window,
        counted(optimised.positions, "position")
    )
}

fn optimisation_as_json(options: &PatchMatchOptions, optimised: &Optimised) -> Value {
    json!({
        "window": options.window,
        "levels": optimised.levels,
        "rounds": options.rounds,
        "uniformity": options.uniformity,
        "synthesis": optimised,
    })
}

/// The report of a pixel method.
fn texel_report(output: &Path, asked: &SynthOptions, size: Size, how: &str, special: &Value) -> Report {
    let closed = asked.boundary == Boundary::Torus
        || (asked.method == SynthesisMethod::PatchMatch && !asked.follow_trend);
    let text = format!("{}: {size} texels {how}", output.display());
    let mut json = json!({
        "width": size.width,
        "height": size.height,
        "method": asked.method.name(),
        "tile": closed,
        "seed": asked.seed,
    });
    for (name, value) in special.as_object().into_iter().flatten() {
        json[name] = value.clone();
    }
    Report::new(text, json)
}

fn roller_report(output: &Path, laid: &LaidTiles, rolled: &Rolled) -> Report {
    let (count, tile, cells) = (rolled.tiles.count(), rolled.tiles.tile(), rolled.tiles.cells());
    let good = rolled.report.is_acceptable();
    let text = format!(
        "{}: {} texels of {} in random order; {}",
        output.display(),
        laid.size,
        in_words(count, cells),
        if good { "seams are acceptable" } else { "seams may be seen" }
    );
    let json = json!({
        "width": laid.size.width,
        "height": laid.size.height,
        "method": "roller",
        "tile": laid.boundary == Boundary::Torus,
        "seed": laid.seed,
        "tiles": count,
        "tile_width": tile.width,
        "tile_height": tile.height,
        "cells": cells,
        "acceptable": good,
        "roller": rolled.report,
    });
    Report::new(text, json)
}

fn elements_report(output: &Path, options: &ElementOptions, laid: &ElementsLaid) -> Report {
    let [[ax, ay], [bx, by]] = laid.lattice.basis();
    let elements = match laid.elements {
        1 => "the one whole element, repeated".to_owned(),
        count => format!("{count} elements in random order"),
    };
    let text = format!(
        "{}: {} texels of {}, one at each point of ({ax:.1}, {ay:.1}) and ({bx:.1}, {by:.1}); \
         {} % of the usual difference between elements along their outline{}",
        output.display(),
        options.size,
        elements,
        (100.0 * laid.joint_contrast).round(),
        if laid.has_joints() { "" } else { ": no joints were found, and cuts may be seen" }
    );
    let json = json!({
        "width": options.size.width,
        "height": options.size.height,
        "method": "elements",
        "tile": options.boundary == Boundary::Torus,
        "seed": options.seed,
        "elements": laid,
    });
    Report::new(text, json)
}

/// The report of the kept texture, and how it was chosen.
fn with_choice(kept: Report, choice: &Choice, files: &[PathBuf]) -> Report {
    let mut text = format!("{}\n{}", kept.text, choice.advice.reason);
    for (file, found) in files.iter().zip(&choice.analyses) {
        if files.len() > 1 {
            let _ = write!(text, "\n{}", file.display());
        }
        let _ = write!(text, "\n{}", analyze::describe(found));
    }
    let (count, trial) = (choice.tries.len(), choice.trial);
    if choice.follows_trend {
        text.push_str("\nthe texture changes from side to side as the exemplar does (--follow-trend)");
    }
    let _ = write!(text, "\nmade {count} of {trial} texels, kept the nearest to the exemplar (*):");
    for (number, one) in choice.tries.iter().enumerate() {
        text.push_str(&line(one, choice.follows_trend, number == choice.kept));
    }
    text.extend(passed_over(choice).map(|why| format!("\n{why}")));
    let mut json = kept.json;
    json["auto"] = json!({
        "analyses": choice.analyses,
        "advice": choice.advice,
        "trial_width": choice.trial.width,
        "trial_height": choice.trial.height,
        "follows_trend": choice.follows_trend,
        "tries": choice.tries.iter().map(|one| try_as_json(one, choice.follows_trend)).collect::<Vec<_>>(),
        "kept": choice.kept,
        "options": command(&choice.tries[choice.kept].plan, choice.follows_trend),
    });
    let kept_try = &choice.tries[choice.kept];
    let far =
        kept_try.full.or(kept_try.outcome.as_ref().ok().copied()).and_then(|score| far_from_exemplar(&score));
    let warnings = choice.analyses.iter().flat_map(analyze::warnings).chain(far);
    Report::new(text, json).with_warnings(kept.warnings.into_iter().chain(warnings))
}

/// Why tries that are nearer than the one kept were not, if there are any.
fn passed_over(choice: &Choice) -> Option<String> {
    let distance = |one: &Try| one.outcome.as_ref().ok()?.appearance.map(|appearance| appearance.distance);
    let kept = distance(&choice.tries[choice.kept])?;
    let nearer = choice.tries.iter().filter(|one| distance(one).is_some_and(|distance| distance < kept));
    let (copies, others): (Vec<&Try>, Vec<&Try>) =
        nearer.partition(|one| one.outcome.as_ref().is_ok_and(Score::is_copy));
    let copied = "copy more than half of the exemplar in one piece";
    let why = match (copies.is_empty(), others.is_empty()) {
        (true, true) => return None,
        (false, true) => copied.to_owned(),
        (true, false) => format!("are farther at the full size, or {copied}"),
        (false, false) => format!("{copied}, or are farther at the full size"),
    };
    Some(format!("nearer ones were not kept: they {why}"))
}

/// Says that even the nearest texture is not near.
fn far_from_exemplar(score: &Score) -> Option<String> {
    /// In units of the distance between the halves of an exemplar.
    const FAR: f64 = 1.5;
    let distance =
        score.appearance.map(|appearance| appearance.distance).filter(|distance| *distance > FAR)?;
    Some(format!(
        "the nearest texture is {distance:.1} times as far from the exemplar as the halves of the exemplar are from \
         each other: look at it, and try a larger or more even sample"
    ))
}

/// The options that reproduce the texture of a suggested plan.
fn command(plan: &Plan, follows_trend: bool) -> String {
    let (method, seed) = (plan.method().name(), plan.seed());
    let options = match plan {
        Plan::Quilting(o) => format!("--block {} --overlap {} --seed {seed}", o.block, o.overlap),
        Plan::Roller(laid) => format!("--method {method} --tiles {} --seed {seed}", laid.options.tiles),
        Plan::Elements(_) => format!("--method {method} --seed {seed}"),
        Plan::WeiLevoy(WeiLevoyOptions { window, levels, .. }, _)
        | Plan::PatchMatch(PatchMatchOptions { window, levels, .. }) => {
            format!("--method {method} --neighbourhood {window} --levels {levels} --seed {seed}")
        }
        Plan::EfrosLeung(o) => format!("--method {method} --neighbourhood {} --seed {seed}", o.window),
    };
    if follows_trend { options + " --follow-trend" } else { options }
}

fn try_as_json(one: &Try, follows_trend: bool) -> Value {
    let score = one.outcome.as_ref().ok();
    json!({
        "options": command(&one.plan, follows_trend),
        "appearance": score.and_then(|s| s.appearance),
        "largest_piece": score.and_then(|s| s.largest_piece),
        "full": one.full.map(|s| json!({ "appearance": s.appearance, "largest_piece": s.largest_piece })),
        "error": one.outcome.as_ref().err().map(ToString::to_string),
        "seconds": one.seconds,
    })
}

fn line(one: &Try, follows_trend: bool, is_kept: bool) -> String {
    let trial = match &one.outcome {
        Ok(score) => score_in_words(score).unwrap_or_else(|| "not measured".to_owned()),
        Err(error) => error.to_string(),
    };
    let full = one.full.as_ref().and_then(score_in_words).map(|score| format!("; at the full size {score}"));
    let mark = if is_kept { "*" } else { " " };
    let (command, full) = (command(&one.plan, follows_trend), full.unwrap_or_default());
    format!("\n {mark} {command:<38} {trial}, {:.1} s{full}", one.seconds)
}

fn score_in_words(score: &Score) -> Option<String> {
    let piece = format!("largest piece {:.0} % of the exemplar", 100.0 * score.largest_piece?);
    Some(match score.appearance {
        Some(Appearance { distance, .. }) => format!("distance {distance:.2}, {piece}"),
        None => piece,
    })
}
