//! `relume gallery`: all methods of synthesis on each exemplar of a folder, measured, on one page.
//!
//! Every entry is made and measured by the verbs of the program (`synth`, `compare --texture`), so the
//! commands on the page reproduce it. A method that fails or refuses becomes an entry with its message.

mod entry;
mod page;
mod table;

use std::path::{Path, PathBuf};

use relume::workflow::{Btf, SynthesisMethod};
use relume::{Error, Named, Result, Size};
use serde_json::json;

use crate::args;
use crate::context::Context;
use crate::output::{self, Folder};
use crate::paths;
use crate::report::Report;
use entry::GalleryExemplar;

/// Extensions of files that may be exemplars.
const ENDINGS: [&str; 10] = ["png", "jpg", "jpeg", "tif", "tiff", "exr", "pfm", "hdr", "pic", "ptm"];

/// Extensions of textures of light and view, which are factored first.
const SETS: [&str; 2] = ["zip", "btf"];

/// Arguments of `relume gallery`.
#[derive(Debug, clap::Args)]
#[command(
    after_help = "Example:\n  relume gallery exemplars -o gallery --size 256 --methods quilting,auto\n\
                        then open gallery/index.html in a browser. docs/measures.md says what the figures mean."
)]
pub struct Args {
    /// A folder of exemplars: .ptm, .exr or pictures, and textures of light and view (.zip, .btf, or folders of
    /// photographs), which are factored into 16 functions first; other files in it are ignored
    folder: PathBuf,
    /// The folder to write: index.html, gallery.json, gallery.csv, and a folder of textures for each
    /// exemplar
    #[arg(short, long, value_name = "DIR")]
    output: PathBuf,
    /// Width and height of the textures in texels [default: twice those of the exemplar]
    #[arg(long, value_name = "WxH", value_parser = args::size)]
    size: Option<Size>,
    /// The methods to run
    #[arg(long, value_name = "NAMES", value_delimiter = ',', value_parser = args::named::<SynthesisMethod>())]
    #[arg(default_values = SynthesisMethod::ALL.iter().map(|method| method.name()))]
    methods: Vec<SynthesisMethod>,
    /// Another seed gives other textures
    #[arg(long, value_name = "N", default_value_t = 0)]
    seed: u64,
    /// Number of lights under which functions are compared
    #[arg(long, value_name = "N", default_value_t = 5, value_parser = clap::value_parser!(u16).range(1..=1000))]
    lights: u16,
}

/// Makes everything, and writes the page and the tables.
pub fn run(args: &Args, context: &Context) -> Result<Report> {
    let mut methods = args.methods.clone();
    methods.sort_by_key(|method| SynthesisMethod::ALL.iter().position(|known| known == method));
    methods.dedup();
    if methods.len() < args.methods.len() {
        return Err(Error::usage("--methods names a method twice: name each once"));
    }
    let files = files(&args.folder)?;
    let folder = Folder::stage(&args.output, &[&args.folder], context)?;
    let mut exemplars = Vec::new();
    for (number, file) in files.iter().enumerate() {
        let place = format!("{}/{} ", number + 1, files.len());
        exemplars.push(GalleryExemplar::run(file, args, &folder, &place, context)?);
    }
    context.bar.set_part(String::new());
    let entries = exemplars.iter().flat_map(|exemplar| &exemplar.entries);
    let (all, made) = (entries.clone().count(), entries.clone().filter(|entry| entry.file.is_some()).count());
    if made == 0 {
        let why = entries.filter_map(|entry| entry.error.as_deref()).next().unwrap_or_default();
        return Err(
            Error::invalid(format!("no texture could be made of any exemplar: {why}")).at(&args.folder)
        );
    }
    let missing = (made < all).then(|| format!("{} of {all} textures could not be made", all - made));
    let json = json!({
        "page": paths::text(args.output.join("index.html")),
        "seed": args.seed,
        "exemplars": exemplars,
    });
    folder.add("gallery.json", format!("{json:#}\n").as_bytes())?;
    folder.add("gallery.csv", table::csv(&exemplars).as_bytes())?;
    folder.add("index.html", page::html(&exemplars, args).as_bytes())?;
    let written = folder.commit()?;
    let index = args.output.join("index.html");
    let text = format!("{}Open {} in a browser.", table::text(&exemplars), index.display());
    Ok(Report::new(text, json).with_outputs(written).with_warnings(missing))
}

/// The exemplars of a folder, by name.
fn files(folder: &Path) -> Result<Vec<PathBuf>> {
    if output::is_stream(folder) {
        return Err(Error::usage("exemplars are read from a folder: name one instead of -"));
    }
    if folder.is_file() {
        return Err(Error::usage("is a file: name a folder of exemplars").at(folder));
    }
    let failed = |e: &std::io::Error| Error::io("cannot read the folder", e).at(folder);
    let entries = std::fs::read_dir(folder).map_err(|e| failed(&e))?;
    let paths = entries.map(|entry| entry.map(|entry| entry.path()).map_err(|e| failed(&e)));
    let mut paths = paths.collect::<Result<Vec<PathBuf>>>()?;
    let ending = |path: &Path| path.extension().map(|e| e.to_string_lossy().to_lowercase());
    let is_file = |path: &Path| !path.is_dir() && ending(path).is_some_and(|e| ENDINGS.contains(&e.as_str()));
    let is_set = |path: &Path| {
        Btf::is_at(path) && (path.is_dir() || ending(path).is_some_and(|e| SETS.contains(&&*e)))
    };
    paths.retain(|path| is_file(path) || is_set(path));
    paths.sort();
    if paths.is_empty() {
        let endings = ENDINGS.into_iter().chain(SETS).collect::<Vec<_>>().join(", .");
        let message = format!("holds no exemplar: expected files that end in .{endings}");
        return Err(Error::usage(message).at(folder));
    }
    Ok(paths)
}
