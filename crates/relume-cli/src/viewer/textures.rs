//! Files as the page loads them.

use std::path::Path;

use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use relume::format::share::planes::PlaneDepth;
use relume::format::share::{HEADER_NAME, ShareFiles};
use relume::format::{Content, Encoding, ExrDepth, FieldFile, MapRecord};
use relume::workflow::share::{ShareOptions, share, share_tiles, thumbnail};
use relume::{Job, Named, Result};
use serde_json::{Map, Value};

use crate::{args, evaluated, input, paths};

/// How textures are stored for the page.
#[derive(Debug, clap::Args)]
pub struct PlaneArgs {
    /// Storage of coefficients: kept (8-bit codes of .ptm files and pictures as they are, half floats for others), 8
    /// (bits), or half (floats)
    #[arg(long, value_name = "DEPTH", value_parser = args::named::<PlaneDepth>(), default_value = PlaneDepth::default().name())]
    planes: PlaneDepth,
    /// Side of a texel in millimetres, for the scale bar and the ruler
    #[arg(long, value_name = "MM", value_parser = args::texel_mm)]
    mm_per_texel: Option<f64>,
}

/// A texture, ready for the page.
#[derive(Debug)]
pub struct Prepared {
    /// A name for people.
    pub title: String,
    /// Its files by name.
    pub files: Vec<(String, Vec<u8>)>,
    /// A small picture as a JPEG file.
    pub thumbnail: Vec<u8>,
}

impl Prepared {
    /// The files in base64 by their names.
    pub fn in_base64(&self) -> Value {
        let files = self.files.iter().map(|(name, bytes)| (name.clone(), STANDARD.encode(bytes).into()));
        Value::Object(files.collect::<Map<String, Value>>())
    }
}

/// Reads a file: a texture, tiles, a picture, or a model, of which a tile is made.
pub fn prepared(
    path: &Path,
    title: Option<&str>,
    planes: &PlaneArgs,
    evaluated: &evaluated::Args,
    job: &Job,
) -> Result<Prepared> {
    let named = || path.file_stem().map_or_else(|| "texture".to_owned(), paths::text);
    let title = title.map_or_else(named, str::to_owned);
    let options =
        ShareOptions { title: title.clone(), depth: planes.planes, mm_per_texel: planes.mm_per_texel };
    let opened = input::open(path, job)?;
    let (shared, thumbnail) = match opened.content() {
        Content::Tiles => {
            let set = opened.into_tiles()?;
            (share_tiles(&set, &options, job), thumbnail(&set.file.field, job))
        }
        Content::Model => {
            let field = evaluated.tile(&opened.into_model()?, job).map_err(|e| e.at(path))?;
            let (encoding, record) = (Encoding::Exr(ExrDepth::Float), MapRecord::default());
            let file = FieldFile { field, opacity: None, encoding, record };
            (share(&file, &options, job), thumbnail(&file.field, job))
        }
        _ => {
            let file = opened.into_field()?;
            (share(&file, &options, job), thumbnail(&file.field, job))
        }
    };
    let shared: ShareFiles = shared.map_err(|e| e.at(path))?;
    let header = (HEADER_NAME.to_owned(), shared.header_bytes());
    let files = std::iter::once(header).chain(shared.files).collect();
    Ok(Prepared { title, files, thumbnail: thumbnail.map_err(|e| e.at(path))? })
}
