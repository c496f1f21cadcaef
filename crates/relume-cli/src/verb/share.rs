//! `relume share`: a texture as a page to send, a folder for a web server or one file that opens from disk.

use std::path::{Path, PathBuf};

use relume::Result;
use serde_json::json;

use crate::context::Context;
use crate::evaluated;
use crate::output::{Folder, Outputs};
use crate::report::Report;
use crate::viewer::{self, Delivery, PageData, PlaneArgs, Prepared};

/// Arguments of `relume share`.
#[derive(Debug, clap::Args)]
#[command(after_help = "Examples:\n  relume share wool.ptm -o wool-page\n  \
                        relume share wool.ptm --single-file -o wool.html\n  \
                        relume share wool.ptm woven.ptm -o both --title \"Two cloths\"")]
pub struct Args {
    /// Textures: .ptm, .exr fields, pictures, tiles, .rlm models; several are compared side by side
    #[arg(required = true, num_args = 1..=16, value_name = "FILE")]
    files: Vec<PathBuf>,
    /// The folder to write, for a web server; with --single-file the .html file
    #[arg(short, long, value_name = "OUT")]
    output: PathBuf,
    /// Write one HTML file that holds everything and opens from disk
    #[arg(long)]
    single_file: bool,
    /// Title of the page [default: the name of the first file]
    #[arg(long, value_name = "TEXT")]
    title: Option<String>,
    #[command(flatten)]
    planes: PlaneArgs,
    #[command(flatten)]
    evaluated: evaluated::Args,
}

/// Reads the textures, and writes the page.
pub fn run(args: &Args, context: &Context) -> Result<Report> {
    let inputs: Vec<&Path> = args.files.iter().map(PathBuf::as_path).collect();
    if args.single_file {
        let mut outputs = Outputs::new(context);
        outputs.file(&args.output, &inputs)?;
        let textures = textures(args, context)?;
        let bytes = textures.iter().flat_map(|t| &t.files).map(|(_, bytes)| bytes.len() as u64).sum::<u64>();
        // In base64 for the data, the data as text, and the page around it.
        context.job.check_bytes("the page", 4 * bytes.div_ceil(3) * 4)?;
        let in_base64 = |t: &Prepared| json!({ "title": t.title, "files": t.in_base64() });
        let data = page_data(args, &textures, in_base64);
        let page = viewer::single_page(&data).into_bytes();
        let bytes = page.len();
        outputs.write(&args.output, page)?;
        return Ok(report(args, &textures, bytes).with_outputs(outputs.commit()?));
    }
    let folder = Folder::stage(&args.output, &inputs, context)?;
    let textures = textures(args, context)?;
    let mut bytes = 0;
    let mut add = |name: &str, content: &[u8]| {
        bytes += content.len();
        folder.add(name, content)
    };
    for (i, texture) in textures.iter().enumerate() {
        for (name, content) in &texture.files {
            add(&format!("{}{name}", place(i)), content)?;
        }
    }
    let place_of = |t: &Prepared| textures.iter().position(|other| std::ptr::eq(other, t)).map(place);
    let data = page_data(args, &textures, |t| json!({ "title": t.title, "folder": place_of(t) }));
    add("index.html", viewer::folder_page(&data).as_bytes())?;
    add(viewer::SCRIPT_NAME, viewer::SCRIPT.as_bytes())?;
    add(viewer::STYLE_NAME, viewer::STYLE.as_bytes())?;
    add(viewer::THUMBNAIL_NAME, &textures[0].thumbnail)?;
    let report = report(args, &textures, bytes);
    Ok(report.with_outputs(folder.commit()?))
}

/// The folder of texture `i` beside the page.
fn place(i: usize) -> String {
    format!("textures/{i}/")
}

fn textures(args: &Args, context: &Context) -> Result<Vec<Prepared>> {
    let title = |i: usize| args.title.as_deref().filter(|_| i == 0 && args.files.len() == 1);
    let read = |(i, path): (usize, &PathBuf)| {
        viewer::prepared(path, title(i), &args.planes, &args.evaluated, Delivery::Stored, &context.job)
    };
    args.files.iter().enumerate().map(read).collect()
}

fn page_data(
    args: &Args,
    textures: &[Prepared],
    entry: impl FnMut(&Prepared) -> serde_json::Value,
) -> PageData {
    let title = args.title.clone().unwrap_or_else(|| textures[0].title.clone());
    PageData { title, textures: textures.iter().map(entry).collect() }
}

fn report(args: &Args, textures: &[Prepared], bytes: usize) -> Report {
    let what = if args.single_file { "open it in a browser" } else { "for a web server" };
    let text = format!("{}: {:.1} MB, {what}", args.output.display(), bytes as f64 / 1e6);
    let titles: Vec<&str> = textures.iter().map(|t| t.title.as_str()).collect();
    Report::new(text, json!({ "textures": titles, "bytes": bytes, "single_file": args.single_file }))
}
