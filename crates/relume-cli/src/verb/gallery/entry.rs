//! One exemplar with the textures made from it by all methods, and one such texture.

use std::ffi::{OsStr, OsString};
use std::fs;
use std::path::{Path, PathBuf};

use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use relume::workflow::auto::LARGEST_PIECE;
use relume::workflow::{Btf, SynthesisMethod};
use relume::{Error, ErrorKind, Named, Result, Size};
use serde::Serialize;
use serde_json::Value;

use super::Args;
use crate::clock::{Times, timed};
use crate::context::Context;
use crate::input;
use crate::output::Folder;
use crate::verb::run_typed;

/// The light of the pictures on the page: from the upper left, so that relief shows.
const LIGHT: &str = "--light=-0.45,0.45,0.77";
/// The texture of photographs under light and view, and the functions that it has.
const FACTORED: &str = "factored.exr";
const FUNCTIONS: usize = 16;
/// The place of the distance by which textures are ranked in the report of `relume compare --texture`.
pub const DISTANCE: &str = "/mean/appearance/distance";

/// An exemplar and its textures.
#[derive(Debug, Serialize)]
pub struct GalleryExemplar {
    /// The name of its file.
    pub name: String,
    /// Of photographs under light and view, the command that makes the texture of learned functions that the methods are
    /// given.
    pub factored: Option<String>,
    pub width: usize,
    pub height: usize,
    /// The size of the textures.
    pub output_width: usize,
    pub output_height: usize,
    /// The report of `relume analyze`, or the reason why there is none.
    pub analysis: Value,
    pub entries: Vec<GalleryEntry>,
    /// A JPEG of it in base64, for the page alone.
    #[serde(skip)]
    pub preview: Option<String>,
}

/// A texture, or the reason why there is none.
#[derive(Debug, Serialize)]
pub struct GalleryEntry {
    pub method: String,
    /// The command that makes it.
    pub command: String,
    /// The options chosen by the method itself.
    pub chosen: Option<String>,
    /// The time to make it, without measuring.
    #[serde(flatten)]
    pub times: Times,
    /// The file of the texture in the folder of the gallery.
    pub file: Option<String>,
    /// The message that explains a missing texture or measure.
    pub error: Option<String>,
    /// The report of `relume compare --texture`.
    pub measures: Option<Value>,
    /// The largest piece copied verbatim, as a fraction of the exemplar.
    pub largest_piece: Option<f64>,
    /// Whether it is the nearest to the exemplar in appearance, verbatim copies excluded.
    pub is_best: bool,
    #[serde(skip)]
    pub preview: Option<String>,
}

impl GalleryExemplar {
    /// Runs all methods on a file; `place` is its position among the files.
    pub fn run(file: &Path, args: &Args, stage: &Folder, place: &str, context: &Context) -> Result<Self> {
        let name = file.file_name().unwrap_or(file.as_os_str());
        context.bar.set_part(format!("{place}{} ", name.to_string_lossy()));
        let folder = stage.path().join(name);
        fs::create_dir(&folder).map_err(|e| Error::io("cannot create the folder", &e).at(&folder))?;
        let scratch = stage.scratch()?;
        let set = Btf::is_at(file).then(|| FactoredSet::new(file, name, &folder, context)).transpose();
        let file = if let Ok(Some(set)) = &set { set.texture.as_path() } else { file };
        // Read once for all verbs; where that fails, each entry says so.
        let kept = input::keep(file, &context.job);
        let size = set.as_ref().map_err(Error::clone).and(kept.as_ref().map_err(Error::clone));
        let size = size.and_then(|_| input::exemplar(file, &context.job)).map(|read| read.field.size());
        let set = set.as_ref().ok().and_then(Option::as_ref);
        let source = set.map_or_else(|| name.to_string_lossy().into_owned(), |set| set.name.clone());
        let doubled = |side: &Size| Size::new(2 * side.width, 2 * side.height);
        let output = args.size.or(size.as_ref().ok().map(doubled)).unwrap_or(Size::new(0, 0));
        let trial = Trial {
            file,
            source,
            set: name.to_string_lossy().into_owned(),
            folder: &folder,
            scratch: scratch.path(),
            output,
            args,
            context,
        };
        let analysis = trial.kept(run_typed(words(&["analyze", "--"], &[file]), context))?;
        let mut exemplar = Self {
            name: name.to_string_lossy().into_owned(),
            factored: set.map(|set| set.command.clone()),
            width: size.as_ref().map_or(0, |size| size.width),
            height: size.as_ref().map_or(0, |size| size.height),
            output_width: output.width,
            output_height: output.height,
            analysis: analysis.map_or_else(|e| serde_json::json!({ "error": e.to_string() }), |r| r.json),
            entries: Vec::new(),
            preview: trial.kept(trial.preview(file))?.ok(),
        };
        for method in &args.methods {
            context.bar.set_part(format!("{place}{} {} ", exemplar.name, method.name()));
            let entry = match &size {
                Ok(size) => trial.entry(*method, *size)?,
                Err(error) => GalleryEntry::failed(method.name(), String::new(), error.to_string()),
            };
            exemplar.entries.push(entry);
        }
        exemplar.mark_best();
        Ok(exemplar)
    }

    fn mark_best(&mut self) {
        let rivals = self.entries.iter_mut().filter(|entry| !entry.is_copy());
        let near = rivals.filter_map(|entry| entry.figure(DISTANCE).map(|distance| (distance, entry)));
        if let Some((_, best)) = near.min_by(|a, b| a.0.total_cmp(&b.0)) {
            best.is_best = true;
        }
    }
}

/// Photographs under light and view as a texture of learned functions.
struct FactoredSet {
    texture: PathBuf,
    /// The texture in the folder of the gallery.
    name: String,
    command: String,
}

impl FactoredSet {
    /// Learns the functions.
    fn new(set: &Path, name: &OsStr, folder: &Path, context: &Context) -> Result<Self> {
        let texture = folder.join(FACTORED);
        let rank = FUNCTIONS.to_string();
        let mut typed = words(&["fit", "--rank", &rank, "--half", "-o"], &[&texture]);
        typed.extend(words(&["--"], &[set]));
        run_typed(typed, context)?;
        let (name, set) = (format!("{}/{FACTORED}", name.to_string_lossy()), name.to_string_lossy());
        let command = format!("relume fit --rank {rank} --half -o {name} {set}");
        Ok(Self { texture, name, command })
    }
}

impl GalleryEntry {
    fn failed(method: &str, command: String, error: String) -> Self {
        Self {
            method: method.to_owned(),
            command,
            chosen: None,
            times: Times { seconds: 0.0, processor_seconds: None },
            file: None,
            error: Some(error),
            measures: None,
            largest_piece: None,
            is_best: false,
            preview: None,
        }
    }

    /// A figure by its path in the measures.
    pub fn figure(&self, pointer: &str) -> Option<f64> {
        self.measures.as_ref()?.pointer(pointer)?.as_f64()
    }

    /// Whether it is a verbatim copy of most of the exemplar.
    pub fn is_copy(&self) -> bool {
        self.largest_piece.is_some_and(|piece| piece > LARGEST_PIECE)
    }
}

/// The input of all methods.
struct Trial<'a> {
    file: &'a Path,
    /// Its name in commands.
    source: String,
    /// The name of its folder in the gallery.
    set: String,
    folder: &'a Path,
    scratch: &'a Path,
    output: Size,
    args: &'a Args,
    context: &'a Context,
}

impl Trial<'_> {
    fn entry(&self, how: SynthesisMethod, exemplar: Size) -> Result<GalleryEntry> {
        let method = how.name();
        let (size, seed) =
            (format!("{}x{}", self.output.width, self.output.height), self.args.seed.to_string());
        let texture = format!("{method}.{}", self.ending());
        let options = ["synth", "--method", method, "--size", &size, "--seed", &seed];
        let command = format!("relume {} -o {texture} {}", options.join(" "), self.source);
        let (target, sources) = (self.folder.join(&texture), self.scratch.join(format!("{method}.npy")));
        let mut typed = words(&options, &[]);
        typed.extend(words(&["-o"], &[&target]));
        let has_sources = how.has_source_map();
        if has_sources {
            typed.extend(words(&["--source-map"], &[&sources]));
        }
        typed.extend(words(&["--"], &[self.file]));
        let (made, times) = timed(|| run_typed(typed, self.context));
        let made = match self.kept(made)? {
            Ok(report) => report.json,
            Err(error) => {
                return Ok(GalleryEntry {
                    times,
                    ..GalleryEntry::failed(method, command, self.sentence(&error))
                });
            }
        };
        let measures = self.kept(self.measures(&target, has_sources.then_some(&sources)))?;
        let piece = |measures: &Value| measures.pointer("/copying/largest_piece")?.as_f64();
        Ok(GalleryEntry {
            method: method.to_owned(),
            command,
            chosen: made.pointer("/auto/options").and_then(Value::as_str).map(str::to_owned),
            times,
            file: Some(format!("{}/{texture}", self.set)),
            error: measures.as_ref().err().map(|e| self.sentence(e)),
            largest_piece: measures.as_ref().ok().and_then(piece).map(|n| n / exemplar.texels() as f64),
            measures: measures.ok(),
            is_best: false,
            preview: self.kept(self.preview(&target))?.ok(),
        })
    }

    /// A result that the page can hold, also where it is a refusal.
    ///
    /// # Errors
    /// Errors that end the gallery: it was cancelled, or its own files cannot be written.
    fn kept<T>(&self, result: Result<T>) -> Result<Result<T>> {
        let stage = self.folder.parent().unwrap_or(self.folder);
        match result {
            Err(error) if error.kind() == ErrorKind::Cancelled => Err(error),
            Err(error)
                if error.kind() == ErrorKind::Io
                    && error.path().is_some_and(|path| path.starts_with(stage)) =>
            {
                Err(Error::new(ErrorKind::Io, self.sentence(&error)))
            }
            result => Ok(result),
        }
    }

    fn measures(&self, texture: &Path, sources: Option<&std::path::PathBuf>) -> Result<Value> {
        let lights = self.args.lights.to_string();
        let mut typed = words(&["compare", "--texture", "--lights", &lights], &[]);
        if let Some(sources) = sources {
            typed.extend(words(&["--source-map"], &[sources]));
        }
        typed.extend(words(&["--"], &[self.file, texture]));
        Ok(run_typed(typed, self.context)?.json)
    }

    /// The message of an error, with the final names of the files.
    fn sentence(&self, error: &Error) -> String {
        let stage = self.folder.parent().unwrap_or(self.folder);
        error.to_string().replace(&*stage.to_string_lossy(), &self.args.output.to_string_lossy())
    }

    /// A JPEG of a texture under one light, in base64.
    fn preview(&self, texture: &Path) -> Result<String> {
        let number = fs::read_dir(self.scratch).map_or(0, Iterator::count);
        let picture = self.scratch.join(format!("{number}.jpg"));
        let mut typed = words(&["relight", LIGHT, "-o"], &[&picture]);
        typed.extend(words(&["--"], &[texture]));
        run_typed(typed, self.context)?;
        let bytes = fs::read(&picture).map_err(|e| Error::io("cannot read the file", &e).at(&picture))?;
        Ok(STANDARD.encode(bytes))
    }

    /// The file extension that preserves all data of an exemplar: JPEG and TIFF become PNG.
    fn ending(&self) -> &'static str {
        let ending = self.file.extension().map(|e| e.to_string_lossy().to_lowercase());
        match ending.as_deref() {
            Some("ptm") => "ptm",
            Some("exr") => "exr",
            _ => "png",
        }
    }
}

fn words(texts: &[&str], paths: &[&Path]) -> Vec<OsString> {
    texts.iter().map(OsString::from).chain(paths.iter().map(OsString::from)).collect()
}
