//! `relume share`: a texture as a page to send, a folder for a web server or one file that opens from disk.

use std::ffi::OsStr;
use std::path::{Path, PathBuf};

use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use relume::{Error, Result};
use serde_json::{Value, json};

use crate::context::Context;
use crate::evaluated;
use crate::output::{Folder, Outputs, is_stream};
use crate::report::Report;
use crate::viewer::{
    self, Delivery, PageData, PageSceneArgs, PlaneArgs, Preparation, Prepared, Scene, TextureSource,
};

/// Arguments of `relume share`.
#[derive(Debug, clap::Args)]
#[command(after_help = "Examples:\n  relume share wool.ptm -o wool-page\n  \
                        relume share wool.ptm --single-file -o wool.html\n  \
                        relume share wool.ptm woven.ptm -o both --title \"Two cloths\" --mm-per-texel 0.05,0.1")]
pub struct Args {
    /// Textures: .ptm, .exr fields, pictures, tiles, .rlm models; several, 16 at most, are compared side by side
    #[arg(required = true, num_args = 1.., value_name = "FILE")]
    files: Vec<PathBuf>,
    /// The folder to write, for a web server; with --single-file the .html file
    #[arg(short, long, value_name = "OUT")]
    output: PathBuf,
    /// Write one HTML file that holds everything and opens from disk
    #[arg(long)]
    single_file: bool,
    /// Title of the page [default: the name of the first file]
    #[arg(long, value_name = "TEXT", value_parser = page_title)]
    title: Option<String>,
    /// The address at which the page will be: links to it then show a picture on other sites
    #[arg(long, value_name = "URL", value_parser = web_address)]
    url: Option<String>,
    #[command(flatten)]
    planes: PlaneArgs,
    #[command(flatten)]
    scene: PageSceneArgs,
    #[command(flatten)]
    evaluated: evaluated::Args,
}

fn page_title(text: &str) -> Result<String, String> {
    if text.trim().is_empty() {
        return Err(
            "expected a text that can be seen; without --title it is the name of the first file".to_owned()
        );
    }
    Ok(text.to_owned())
}

fn web_address(text: &str) -> Result<String, String> {
    let (_, rest) = ["https://", "http://"]
        .iter()
        .find_map(|scheme| Some((scheme, text.strip_prefix(scheme)?)))
        .ok_or("expected an address such as https://example.org/textures/wool")?;
    if rest.is_empty() || rest.contains(|c: char| c.is_whitespace() || "?#".contains(c)) {
        return Err("expected the address of a folder, without a query".to_owned());
    }
    Ok(text.to_owned())
}

/// Reads the textures, and writes the page.
pub fn run(args: &Args, context: &Context) -> Result<Report> {
    let sources = sources(args)?;
    check_output(args)?;
    let inputs: Vec<&Path> = args.files.iter().map(PathBuf::as_path).chain(args.scene.files()).collect();
    if args.single_file {
        let mut outputs = Outputs::new(context);
        outputs.file(&args.output, &inputs)?;
        let scene = args.scene.read(&context.job)?;
        let textures = textures(args, sources, &scene, context)?;
        let bytes = textures.iter().flat_map(|t| &t.files).map(|(_, bytes)| bytes.len() as u64).sum::<u64>();
        // In base64 for the data, the data as text, and the page around it.
        context.job.check_bytes("the page", 4 * bytes.div_ceil(3) * 4)?;
        let in_base64 =
            |t: &Prepared| t.entry(json!({ "files": t.in_base64(), "annotations": t.annotations }));
        let mut data = page_data(args, &textures, in_base64);
        data.mesh = scene
            .mesh
            .map(|(title, bytes)| json!({ "title": title, "bytes": STANDARD.encode(bytes) }))
            .into();
        let page = viewer::single_page(&data).into_bytes();
        let bytes = page.len();
        outputs.write(&args.output, page)?;
        return Ok(report(args, &textures, bytes).with_outputs(outputs.commit()?));
    }
    let folder = Folder::stage(&args.output, &inputs, context)?;
    let scene = args.scene.read(&context.job)?;
    let textures = textures(args, sources, &scene, context)?;
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
    let entry = |t: &Prepared| t.entry(json!({ "folder": place_of(t), "annotations": t.annotations }));
    let mut data = page_data(args, &textures, entry);
    if let Some((title, bytes)) = &scene.mesh {
        add(viewer::MESH_NAME, bytes)?;
        data.mesh = json!({ "title": title, "file": viewer::MESH_NAME });
    }
    add("index.html", viewer::folder_page(&data).as_bytes())?;
    add(viewer::SCRIPT_NAME, viewer::SCRIPT.as_bytes())?;
    add(viewer::ELEMENT_NAME, viewer::ELEMENT.as_bytes())?;
    add(viewer::STYLE_NAME, viewer::STYLE.as_bytes())?;
    add(viewer::THUMBNAIL_NAME, &textures[0].thumbnail)?;
    let report = report(args, &textures, bytes);
    Ok(report.with_outputs(folder.commit()?))
}

/// A page in one file is an HTML file by its name, and a folder is none.
fn check_output(args: &Args) -> Result<()> {
    let is_html = |e: &OsStr| e.eq_ignore_ascii_case("html") || e.eq_ignore_ascii_case("htm");
    let error = match (args.single_file, args.output.extension().is_some_and(is_html)) {
        (false, true) => "would be a folder: add --single-file for one HTML file, or name a folder",
        (true, false) if !is_stream(&args.output) => {
            "would be one HTML file: name it .html, or leave --single-file out for a folder"
        }
        _ => return Ok(()),
    };
    Err(Error::usage(error).at(&args.output))
}

/// The textures, under the title of the page where it is given and there is one, and under the names of the files otherwise.
fn sources(args: &Args) -> Result<Vec<TextureSource<'_>>> {
    let mut sources = viewer::sources(&args.files, &args.planes)?;
    if let ([source], Some(title)) = (&mut sources[..], &args.title) {
        source.title.clone_from(title);
    }
    Ok(sources)
}

/// The folder of texture `i` beside the page.
fn place(i: usize) -> String {
    format!("textures/{i}/")
}

fn textures(
    args: &Args,
    sources: Vec<TextureSource>,
    scene: &Scene,
    context: &Context,
) -> Result<Vec<Prepared>> {
    let environment = scene.environment.as_ref();
    let delivery = Delivery::Stored;
    let preparation = Preparation { planes: &args.planes, evaluated: &args.evaluated, environment, delivery };
    sources.into_iter().map(|source| preparation.prepared(source, &context.job)).collect()
}

fn page_data(
    args: &Args,
    textures: &[Prepared],
    entry: impl FnMut(&Prepared) -> serde_json::Value,
) -> PageData {
    let title = args.title.clone().unwrap_or_else(|| textures[0].title.clone());
    PageData {
        title,
        textures: textures.iter().map(entry).collect(),
        mesh: Value::Null,
        url: args.url.clone(),
    }
}

fn report(args: &Args, textures: &[Prepared], bytes: usize) -> Report {
    let what = if args.single_file { "open it in a browser" } else { "for a web server" };
    let text = format!("{}: {:.1} MB, {what}", args.output.display(), bytes as f64 / 1e6);
    let titles: Vec<&str> = textures.iter().map(|t| t.title.as_str()).collect();
    Report::new(text, json!({ "textures": titles, "bytes": bytes, "single_file": args.single_file }))
}
