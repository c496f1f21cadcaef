//! `relume roll`: tiles of a regular texture that fit together in any order.

use std::fmt::Write;
use std::path::{Path, PathBuf};

use relume::field::{Domain, IndexSpace, Metric};
use relume::format::tile_set::{in_words, sidecar, sidecar_path};
use relume::format::{Encoding, FieldFile, FieldFormat, PictureFormat, encode_translucent, exr};
use relume::numeric::lattice::Lattice;
use relume::numeric::periods::Pattern;
use relume::synthesis::roller::{RollReport, Rolled, RollerOptions, roll};
use relume::synthesis::{Boundary, Exemplar};
use relume::{Error, ReflectanceField, Result};
use serde_json::json;

use crate::context::Context;
use crate::output::Outputs;
use crate::rearranged;
use crate::registered::{Registered, compared, read_registered};
use crate::report::Report;
use crate::{args, gathered, input, opacity, output, rearranged_btf};

/// Arguments of `relume roll`.
#[derive(Debug, clap::Args)]
#[command(after_help = "Examples:\n  relume roll wool.ptm -k 4 -o tiles.ptm\n  \
                        relume synth tiles.ptm --size 65536x65536 -o cloth.ptm\n  \
                        relume synth tiles.ptm --window -200,1000,512,512 -o part.ptm")]
pub struct Args {
    /// The exemplar: a .ptm, an .exr field, or a picture; - is standard input
    file: PathBuf,
    /// The tiles to write, one below the other: .exr, or another format with FILE.json beside it
    #[arg(short, long, value_name = "FILE")]
    output: PathBuf,
    /// Number of tiles K; each takes about a K-th of the exemplar
    #[arg(short = 'k', long, value_name = "K", default_value_t = 1)]
    tiles: usize,
    /// Texels by which tiles overlap their continuation, and width of their common border [default: a
    /// sixteenth of the smaller side of the exemplar]
    #[arg(long, value_name = "N")]
    overlap: Option<usize>,
    /// The periods, instead of measured ones: W,H in texels, or two shifts X,Y,X,Y to the right and down
    #[arg(long, value_name = "W,H", value_parser = args::lattice, allow_hyphen_values = true)]
    period: Option<Lattice>,
    /// Make rectangles, which other programs can repeat as well, even where oblique tiles follow oblique
    /// periods better
    #[arg(long)]
    upright: bool,
    /// Texels that may not be used: white in a mask as large as the exemplar
    #[arg(long, value_name = "MASK")]
    exclude: Option<PathBuf>,
    #[command(flatten)]
    rearranged: rearranged::Args,
}

/// Makes tiles and writes them.
pub fn run(args: &Args, context: &Context) -> Result<Report> {
    let inputs: Vec<&Path> = std::iter::once(&*args.file).chain(args.exclude.as_deref()).collect();
    let mut outputs = Outputs::new(context);
    let applied = args.rearranged.claim(&inputs, &[&args.output], 1, &mut outputs)?;
    for path in std::iter::once(&*args.output).chain(applied.iter().map(|job| &*job.output)) {
        claim_tiles(path, &inputs, &mut outputs)?;
    }
    let options = RollerOptions {
        tiles: args.tiles,
        overlap: args.overlap,
        pattern: args.period.map(Pattern::Lattice),
        oblique: !args.upright,
        vary: true,
        ..RollerOptions::default()
    };
    options.validate()?;
    args.rearranged.refuse_joined("tiles share their borders as copies only")?;
    let file = input::exemplar(&args.file, &context.job)?;
    let images = read_registered(applied, std::slice::from_ref(&file), context)?;
    let sets = args.rearranged.btfs(&args.output)?;
    let btfs = rearranged_btf::open_all(&sets, file.field.size(), context)?;
    let rolled = make(args, &file, &images, &options, context)?;
    let map = rolled.tiles.map();
    let made = gathered::gather(map, std::slice::from_ref(&file), &args.file, context)?;
    let mut files = tiles(&args.output, &made, &rolled, &file, context)?;
    for one in &images {
        let made = args.rearranged.gathered(map, one, Boundary::Open, context)?;
        files.extend(tiles(&one.applied.output, &made, &rolled, &one.files[0], context)?);
    }
    files.extend(args.rearranged.source_map(rolled.tiles.map(), context)?);
    for (path, bytes) in files {
        outputs.write(&path, bytes)?;
    }
    let sets = rearranged_btf::write_all(&sets, &btfs, map, &mut outputs, context)?;
    let written = outputs.commit()?;
    let report = report(&args.output, &options, &rolled);
    Ok(args.rearranged.describe(&images, report).with_lines(&sets).with_outputs(written))
}

/// Refuses a file that cannot hold tiles, and claims its companion.
fn claim_tiles(path: &Path, inputs: &[&Path], outputs: &mut Outputs) -> Result<()> {
    if output::is_stream(path) {
        return Err(Error::usage("a set of tiles is one or two files: name one instead of -"));
    }
    if let Some(beside) = sidecar_path(path) {
        outputs.file(&beside, inputs)?;
    }
    if matches!(FieldFormat::from_path(path)?, FieldFormat::Picture(PictureFormat::Jpeg { .. })) {
        let message = "JPEG changes texels, so tiles would not share a border: name the file .png";
        return Err(Error::usage(message).at(path));
    }
    Ok(())
}

/// The files of one set of tiles.
fn tiles(
    path: &Path,
    made: &ReflectanceField,
    rolled: &Rolled,
    from: &FieldFile,
    context: &Context,
) -> Result<Vec<(PathBuf, Vec<u8>)>> {
    let bytes = encode(made, rolled, from, FieldFormat::from_path(path)?, context).map_err(|e| e.at(path))?;
    let beside = sidecar_path(path).map(|beside| {
        (beside, sidecar(rolled.tiles.count(), rolled.tiles.cells(), rolled.tiles.corners(), &bytes))
    });
    Ok(std::iter::once((path.to_owned(), bytes)).chain(beside).collect())
}

fn make(
    args: &Args,
    file: &FieldFile,
    images: &[Registered],
    options: &RollerOptions,
    context: &Context,
) -> Result<Rolled> {
    let space = IndexSpace::new(&file.field, Metric::Function, Domain::Hemisphere)?;
    let files = std::slice::from_ref(file);
    let index = gathered::index(files, &compared(images), &space, context)?.swap_remove(0);
    let mask = |path: &PathBuf| input::mask(path, index.size(), &context.job);
    let excluded = args.exclude.as_ref().map(mask).transpose()?;
    let excluded = opacity::excluded(file, &args.file, excluded, context);
    roll(&Exemplar { index: &index, excluded: excluded.as_deref() }, options, &context.job)
        .map_err(|e| e.at(&args.file))
}

/// The file of the tiles, in the encoding of the exemplar.
fn encode(
    field: &ReflectanceField,
    rolled: &Rolled,
    file: &FieldFile,
    format: FieldFormat,
    context: &Context,
) -> Result<Vec<u8>> {
    let opacity = opacity::gathered(rolled.tiles.map(), std::slice::from_ref(file), context)?;
    let opacity = opacity.as_ref();
    match format.in_depth_of(&file.encoding) {
        FieldFormat::Exr(depth) => {
            let tiles = &rolled.tiles;
            let (count, cells, corners) = (tiles.count(), tiles.cells(), tiles.corners());
            exr::encode_tiles(field, opacity, count, cells, corners, depth, &context.job)
        }
        FieldFormat::Ptm if !matches!(file.encoding, Encoding::Ptm(_)) => {
            encode_translucent(field, opacity, format, None, &context.job)
        }
        format => encode_translucent(field, opacity, format, Some(&file.encoding), &context.job),
    }
}

fn report(output: &Path, options: &RollerOptions, rolled: &Rolled) -> Report {
    let (tiles, how) = (&rolled.tiles, &rolled.report);
    let text = format!(
        "{}: {} texels; {}",
        output.display(),
        in_words(tiles.count(), tiles.cells()),
        quality(how, options.oblique)
    );
    let json = json!({
        "tiles": tiles.count(),
        "tile_width": tiles.tile().width,
        "tile_height": tiles.tile().height,
        "cells": tiles.cells(),
        "corner_colors": tiles.corners(),
        "acceptable": how.is_acceptable(),
        "options": options,
        "roller": how,
    });
    Report::new(text, json)
}

/// The periods of the texture and the fit of the tiles, in words.
fn quality(how: &RollReport, oblique: bool) -> String {
    let worst = how.seams.iter().map(|seams| seams.ratio()).fold(0.0, f64::max);
    let large = how.seams.iter().map(|seams| seams.large).fold(0.0, f64::max);
    let mut text = repeats(how);
    if let Some(first) = &how.first {
        let _ = write!(text, "; the overlaps differ by {:.0} % of unrelated texels", 100.0 * first.mismatch);
    }
    let _ = write!(
        text,
        "; steps across cuts are {worst:.2} of natural ones, {:.0} % of them large",
        100.0 * large
    );
    text.push_str(if how.is_acceptable() { ": acceptable" } else { ": seams may be seen" });
    if how.periods.pattern == Pattern::None {
        let _ = write!(text, "\nThe texture does not repeat, and {}", grid_in_words(how));
    } else if !how.whole_periods {
        text.push_str("\nNo whole periods fit: give a larger exemplar");
        text.push_str(if oblique { "" } else { ", or leave --upright out" });
    }
    text
}

/// What shows the tiles of a texture that does not repeat.
fn grid_in_words(how: &RollReport) -> String {
    if how.first.is_none() {
        return "so the borders of the tiles vary: no part is common to all of them".to_owned();
    }
    format!(
        "{:.0} % of each tile returns in every cell, which shows as rows: 16 or more tiles (-k 16) have borders that \
         vary, and relume synth without tiles may suit it better",
        100.0 * how.common
    )
}

fn repeats(how: &RollReport) -> String {
    match how.periods.pattern {
        Pattern::None => "no period was found".to_owned(),
        Pattern::Stripes([x, y]) => format!("stripes repeat after ({x:.1}, {y:.1})"),
        Pattern::Lattice(lattice) => {
            let [[ax, ay], [bx, by]] = lattice.basis();
            format!("it repeats after ({ax:.1}, {ay:.1}) and ({bx:.1}, {by:.1})")
        }
    }
}
