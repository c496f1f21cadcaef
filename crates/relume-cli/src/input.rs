//! Inputs by path, or `-` for standard input: each is opened and read once.

use std::path::{Path, PathBuf};
use std::sync::mpsc::{self, RecvTimeoutError, Sender};
use std::sync::{Mutex, MutexGuard, PoisonError};
use std::time::Duration;

use relume::format::{self, FieldFile, HeightMap, NormalMap, NormalY, Opened};
use relume::{Error, Job, Planes, Raster, Result, Size};

use crate::output::is_stream;
use crate::report::write_stderr;

/// How long a pipe may stay without data before it is named.
const SILENCE: Duration = Duration::from_secs(2);

/// The file that several verbs in sequence read as one input, and its path.
static KEPT: Mutex<Option<(PathBuf, Opened)>> = Mutex::new(None);

/// A file that [`open`] gives out without reading it again, for as long as this lives.
pub struct KeptInput(());

/// Reads a file for several verbs in sequence, one file at a time.
///
/// # Errors
/// As [`open`], and a file that does not fit into the memory.
pub fn keep(path: &Path, job: &Job) -> Result<KeptInput> {
    let opened = open(path, job)?;
    *kept() = Some((path.to_path_buf(), opened));
    Ok(KeptInput(()))
}

fn kept() -> MutexGuard<'static, Option<(PathBuf, Opened)>> {
    KEPT.lock().unwrap_or_else(PoisonError::into_inner)
}

impl Drop for KeptInput {
    fn drop(&mut self) {
        *kept() = None;
    }
}

/// Reads a file and recognises it by its content.
pub fn open(path: &Path, job: &Job) -> Result<Opened> {
    if let Some((_, opened)) = kept().as_ref().filter(|(kept, _)| kept == path) {
        return Ok(opened.clone());
    }
    let is_archive = path.extension().is_some_and(|e| e.eq_ignore_ascii_case("zip"));
    if is_archive && path.is_file() {
        return Err(format::of_light_and_view("a zip archive").at(path));
    }
    let _notice = is_pipe(path).then(|| Notice::of(path.to_path_buf()));
    match is_stream(path) {
        true => format::read(std::io::stdin().lock(), "standard input", job),
        false => format::open(path, job),
    }
}

/// Whether a path is a pipe by name, which is opened only when another program opens its other end.
fn is_pipe(path: &Path) -> bool {
    #[cfg(unix)]
    {
        use std::os::unix::fs::FileTypeExt;
        std::fs::metadata(path).is_ok_and(|metadata| metadata.file_type().is_fifo())
    }
    #[cfg(not(unix))]
    {
        let _ = path;
        false
    }
}

/// Says on standard error which pipe is waited for, unless it is dropped before.
struct Notice(#[expect(dead_code, reason = "its drop ends the wait")] Sender<()>);

impl Notice {
    fn of(path: PathBuf) -> Self {
        let (ends, wait) = mpsc::channel();
        // Without a thread for it the wait is a silent one.
        let _ = std::thread::Builder::new().spawn(move || {
            if wait.recv_timeout(SILENCE) == Err(RecvTimeoutError::Timeout) {
                write_stderr(&format!("relume: waiting for data from {}", path.display()));
            }
        });
        Self(ends)
    }
}

/// Reads a field: a `.ptm`, an EXR field, or any picture as a texture of constants.
pub fn field(path: &Path, job: &Job) -> Result<FieldFile> {
    open(path, job)?.into_field()
}

/// Reads a texture whose opacity the verb keeps.
pub fn exemplar(path: &Path, job: &Job) -> Result<FieldFile> {
    open(path, job)?.into_exemplar()
}

/// Reads an image that is registered with an exemplar: colours or data, as stored.
pub fn registered(path: &Path, job: &Job) -> Result<FieldFile> {
    open(path, job)?.into_registered()
}

/// Reads a picture of colours.
pub fn raster(path: &Path, job: &Job) -> Result<Raster> {
    open(path, job)?.into_raster()
}

/// Reads a picture of colours with its opacity.
pub fn translucent(path: &Path, job: &Job) -> Result<Raster> {
    open(path, job)?.into_translucent_raster()
}

/// Reads a picture of data, such as normals.
pub fn data(path: &Path, job: &Job) -> Result<Raster> {
    open(path, job)?.into_data()
}

/// Reads a height map with its recorded scale.
pub fn height(path: &Path, job: &Job) -> Result<HeightMap> {
    open(path, job)?.into_height()
}

/// Reads a normal map; `y` is the direction of its second channel where that is known otherwise.
pub fn normals(path: &Path, y: Option<NormalY>, job: &Job) -> Result<NormalMap> {
    open(path, job)?.into_normals(y)
}

/// Heights in texels; integer maps without a record are assumed to span a 25th of the width.
pub fn texels(map: &HeightMap) -> Planes {
    map.texels(map.samples.size().width as f64 / 25.0)
}

/// The planes of a guide, which must have the size of the image it covers.
pub fn guide(path: &Path, size: Size, job: &Job) -> Result<Planes> {
    let guide = registered(path, job)?.field.coefficients().clone();
    if guide.size() != size {
        return Err(Error::usage(format!(
            "the guide has {} texels, the image below it {size}: they must have the same size",
            guide.size()
        ))
        .at(path));
    }
    Ok(guide)
}

/// The painted texels of a mask; it must have the size of the image it masks.
pub fn mask(path: &Path, size: Size, job: &Job) -> Result<Vec<bool>> {
    let mask = open(path, job)?.into_mask()?;
    if mask.size != size {
        return Err(Error::invalid(format!(
            "the mask has {} texels, the image it masks {size}: they must have the same size",
            mask.size
        ))
        .at(path));
    }
    Ok(mask.painted)
}
