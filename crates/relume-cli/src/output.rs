//! Outputs that appear whole or not at all: written beside their place, synced, renamed.

use std::fs::{self, File};
use std::io::Write;
use std::path::{Component, Path, PathBuf};

use relume::{Error, Result};
use tempfile::{Builder, NamedTempFile, TempDir};

use crate::context::Context;
use crate::report::write_stdout;

/// Whether a path means standard input or output.
pub fn is_stream(path: &Path) -> bool {
    path.as_os_str() == "-"
}

/// Refuses an output before any work is done for it: one that exists without `--force`, one that
/// is an input, one in a folder that does not exist.
pub fn check(output: &Path, inputs: &[&Path], context: &Context) -> Result<()> {
    if is_stream(output) {
        return Ok(());
    }
    if output.is_dir() {
        return Err(Error::usage("is a folder: name a file to write").at(output));
    }
    let same = |input: &&&Path| match (fs::canonicalize(input), fs::canonicalize(output)) {
        (Ok(a), Ok(b)) => a == b,
        _ => false,
    };
    if inputs.iter().any(|input| same(&input)) {
        return Err(Error::usage("is an input of this command: choose another output").at(output));
    }
    refuse_existing(output, context)?;
    let folder = parent(output);
    if !folder.is_dir() {
        return Err(Error::usage(format!("the folder {} does not exist: create it first", folder.display()))
            .at(output));
    }
    Ok(())
}

fn refuse_existing(output: &Path, context: &Context) -> Result<()> {
    if !context.force && fs::symlink_metadata(output).is_ok() {
        return Err(Error::usage("exists already: give --force to overwrite it").at(output));
    }
    Ok(())
}

fn parent(path: &Path) -> &Path {
    match path.parent() {
        Some(folder) if !folder.as_os_str().is_empty() => folder,
        _ => Path::new("."),
    }
}

/// Writes a whole file, or standard output where the path is `-`.
pub fn write(output: &Path, bytes: &[u8], context: &Context) -> Result<()> {
    if is_stream(output) {
        return write_stdout(bytes);
    }
    write_with(output, context, |file| {
        file.write_all(bytes).map_err(|e| Error::io("cannot write the file", &e).at(output))
    })
}

/// Writes a file by a function that may go back in it: for what is larger than memory.
pub fn write_with(
    output: &Path,
    context: &Context,
    write: impl FnOnce(&mut File) -> Result<()>,
) -> Result<()> {
    let failed = |error: &std::io::Error| Error::io("cannot write the file", error).at(output);
    let folder = parent(output);
    let mut file = named_temporary(folder).map_err(|e| failed(&e))?;
    write(file.as_file_mut()).map_err(|e| e.at(output))?;
    file.as_file().sync_all().map_err(|e| failed(&e))?;
    let placed = if context.force { file.persist(output) } else { file.persist_noclobber(output) };
    placed.map_err(|e| failed(&e.error))?;
    sync_folder(folder);
    Ok(())
}

/// A temporary file with the permissions a new file would have.
fn named_temporary(folder: &Path) -> std::io::Result<NamedTempFile> {
    let mut builder = Builder::new();
    builder.prefix(".relume-").suffix(".tmp");
    #[cfg(unix)]
    builder.permissions(std::os::unix::fs::PermissionsExt::from_mode(0o666));
    builder.tempfile_in(folder)
}

/// Makes a rename durable where the system allows syncing a folder.
fn sync_folder(folder: &Path) {
    if let Ok(handle) = File::open(folder) {
        // Some file systems refuse to sync folders; the file itself is synced already.
        let _ = handle.sync_all();
    }
}

/// A folder of outputs, staged beside its place and moved there by [`Folder::commit`].
#[derive(Debug)]
pub struct Folder {
    target: PathBuf,
    stage: TempDir,
}

impl Folder {
    /// Stages a folder; one that exists and is not empty needs `--force`, which replaces files of
    /// the same names and leaves all others.
    pub fn stage(target: &Path, context: &Context) -> Result<Self> {
        if is_stream(target) {
            return Err(Error::usage("a folder of files cannot go to standard output: name a folder"));
        }
        if target.exists() && !target.is_dir() {
            return Err(Error::usage("is a file: name a folder to write into").at(target));
        }
        let occupied = fs::read_dir(target).is_ok_and(|mut entries| entries.next().is_some());
        if occupied && !context.force {
            return Err(
                Error::usage("exists already and is not empty: give --force to write into it").at(target)
            );
        }
        let folder = parent(target);
        let mut builder = Builder::new();
        builder.prefix(".relume-").suffix(".tmp");
        #[cfg(unix)]
        builder.permissions(std::os::unix::fs::PermissionsExt::from_mode(0o777));
        let stage =
            builder.tempdir_in(folder).map_err(|e| Error::io("cannot create the folder", &e).at(target))?;
        Ok(Self { target: target.to_path_buf(), stage })
    }

    /// Where the folder's files are until it is committed.
    pub fn path(&self) -> &Path {
        self.stage.path()
    }

    /// Adds a file by its path within the folder.
    ///
    /// # Panics
    /// When the name leaves the folder; names are the program's own.
    pub fn add(&self, name: impl AsRef<Path>, bytes: &[u8]) -> Result<()> {
        let name = name.as_ref();
        assert!(name.components().all(|c| matches!(c, Component::Normal(_))), "names stay in the folder");
        let path = self.stage.path().join(name);
        let written = fs::create_dir_all(parent(&path))
            .and_then(|()| File::create(&path))
            .and_then(|mut file| file.write_all(bytes).and_then(|()| file.sync_all()));
        written.map_err(|e| Error::io("cannot write the file", &e).at(self.target.join(name)))
    }

    /// Moves everything to its place: the whole folder at once where there was none.
    pub fn commit(self) -> Result<()> {
        let Self { target, stage } = self;
        let failed = |error: std::io::Error| Error::io("cannot put the folder in place", &error).at(&target);
        // An empty folder may be there already; removing one that is not empty fails, as it should.
        let _ = fs::remove_dir(&target);
        if !target.exists() {
            let staged = stage.keep();
            fs::rename(&staged, &target).map_err(failed)?;
        } else {
            move_files(stage.path(), &target).map_err(failed)?;
        }
        sync_folder(parent(&target));
        Ok(())
    }
}

/// Moves all files below one folder to the same places below another.
fn move_files(from: &Path, to: &Path) -> std::io::Result<()> {
    fs::create_dir_all(to)?;
    for entry in fs::read_dir(from)? {
        let entry = entry?;
        let place = to.join(entry.file_name());
        if entry.file_type()?.is_dir() {
            move_files(&entry.path(), &place)?;
        } else {
            fs::rename(entry.path(), place)?;
        }
    }
    Ok(())
}
