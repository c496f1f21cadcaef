//! The outputs of one command, which appear together or not at all.
//!
//! A verb claims every output before it works ([`Outputs::file`], [`Folder::stage`]): missing folders are
//! made, and a temporary is created beside each place, so that what cannot be written is refused at once.
//! Bytes go into the temporaries; [`Outputs::commit`] makes all of them durable and renames them, and takes
//! all renames back when one fails.

mod file_list;
mod folder;
mod folder_or_archive;
mod kind;
mod place;
mod temporary;
mod within;

use std::fs::{self, File};
use std::io::{self, Write};
use std::path::{Path, PathBuf};

use relume::{Error, Result};

use crate::context::Context;
pub use crate::paths::is_stream;
use crate::report::write_stdout;
pub use file_list::CaptureFiles;
pub use folder::Folder;
pub use folder_or_archive::{FolderOrArchive, KeepFile, is_archive};
pub use kind::expect;
use temporary::{HeldRegistry, MadeFolders, hold};
pub use temporary::{Temporary, folder_of, remove_all};

/// The files that one command writes.
#[derive(Debug)]
pub struct Outputs {
    force: bool,
    files: Vec<Output>,
    folders: MadeFolders,
}

/// One output.
#[derive(Debug)]
struct Output {
    /// As it was named.
    path: PathBuf,
    /// The file with its bytes until it is put in place; `None` for standard output.
    temporary: Option<Temporary>,
    /// The bytes for standard output.
    stream: Vec<u8>,
}

impl Outputs {
    /// No outputs yet.
    pub fn new(context: &Context) -> Self {
        Self { force: context.force, files: Vec::new(), folders: MadeFolders::default() }
    }

    /// Outputs that may replace files.
    pub fn replacing() -> Self {
        Self { force: true, files: Vec::new(), folders: MadeFolders::default() }
    }

    /// Claims an output before any work is done for it.
    ///
    /// # Errors
    /// An output that exists without `--force`, is named twice, is a folder, a device or one of `inputs`, or
    /// whose folder cannot be created or written.
    pub fn file(&mut self, path: &Path, inputs: &[&Path]) -> Result<()> {
        let temporary = if is_stream(path) { None } else { Some(self.stage(path, inputs)?) };
        if self.files.iter().any(|other| is_same(&other.path, path)) {
            return Err(Error::usage("is named for two outputs of this command: choose another").at(path));
        }
        self.files.push(Output { path: path.to_owned(), temporary, stream: Vec::new() });
        Ok(())
    }

    fn stage(&mut self, path: &Path, inputs: &[&Path]) -> Result<Temporary> {
        refuse_kind(path)?;
        refuse_input(path, inputs)?;
        if !self.force && fs::symlink_metadata(path).is_ok() {
            return Err(Error::usage("exists already: give --force to overwrite it").at(path));
        }
        make_folder(path, &mut self.folders)?;
        Temporary::file(folder_of(path)).map_err(|e| Error::io("cannot write into its folder", &e).at(path))
    }

    /// Writes the bytes of a claimed output.
    ///
    /// # Panics
    /// When it was not claimed.
    pub fn write(&mut self, path: &Path, bytes: Vec<u8>) -> Result<()> {
        let output = self.claimed(path);
        match &mut output.temporary {
            None => output.stream = bytes,
            Some(temporary) => temporary.file_mut().write_all(&bytes).map_err(|e| unwritable(&e, path))?,
        }
        Ok(())
    }

    /// Writes the bytes of a claimed file by a function that may seek in it: for files larger than memory.
    ///
    /// # Panics
    /// When it was not claimed, or is standard output.
    pub fn write_with(&mut self, path: &Path, write: impl FnOnce(&mut File) -> Result<()>) -> Result<()> {
        let temporary = self.claimed(path).temporary.as_mut();
        write(temporary.expect("streams are written at once").file_mut()).map_err(|e| e.at(path))
    }

    fn claimed(&mut self, path: &Path) -> &mut Output {
        let output = self.files.iter_mut().find(|output| output.path == path);
        output.expect("outputs are claimed before they are written")
    }

    /// Puts all outputs in their places and returns their names. On failure none is left, and whatever
    /// `--force` replaced is restored.
    pub fn commit(mut self) -> Result<Vec<PathBuf>> {
        let names = self.files.iter().map(|output| output.path.clone()).collect();
        for output in &self.files {
            let synced = output.temporary.as_ref().map_or(Ok(()), Temporary::sync);
            synced.map_err(|e| unwritable(&e, &output.path))?;
        }
        for output in self.files.iter_mut().filter(|output| output.temporary.is_none()) {
            write_stdout(&std::mem::take(&mut output.stream))?;
        }
        // No signal ends the program between two renames.
        let mut held = hold();
        let mut placed: Vec<Placed> = Vec::new();
        let files = std::mem::take(&mut self.files);
        let mut staged = files.into_iter().filter_map(|output| Some((output.path, output.temporary?)));
        let failure = staged.by_ref().find_map(|(path, temporary)| {
            match Placed::new(path, temporary, self.force, &mut held) {
                Ok(done) => {
                    placed.push(done);
                    None
                }
                Err(error) => Some(error),
            }
        });
        if let Some(error) = failure {
            placed.into_iter().rev().for_each(|done| done.undo(&mut held));
            staged.for_each(|(_, temporary)| temporary.discard(&mut held));
            drop(held);
            return Err(error);
        }
        let mut folders: Vec<PathBuf> = placed.iter().map(|done| folder_of(&done.path).to_owned()).collect();
        placed.into_iter().for_each(|done| done.keep(&mut held));
        std::mem::take(&mut self.folders).keep(&mut held);
        drop(held);
        folders.dedup();
        folders.iter().for_each(|folder| sync_folder(folder));
        Ok(names)
    }
}

/// An output in its place, and how to undo it.
struct Placed {
    path: PathBuf,
    /// The replaced file.
    replaced: Option<Temporary>,
}

impl Placed {
    fn new(path: PathBuf, temporary: Temporary, force: bool, held: &mut HeldRegistry) -> Result<Self> {
        let exists = fs::symlink_metadata(&path).is_ok();
        // On file systems without hard links, a replaced file cannot be restored.
        let replaced = if force && exists { Temporary::link(&path, held).ok() } else { None };
        let done = if force {
            fs::rename(temporary.path(), &path)
        } else {
            place::rename_new(temporary.path(), &path)
        };
        match done {
            Ok(()) => {
                temporary.release(held);
                Ok(Self { path, replaced })
            }
            Err(error) => {
                temporary.discard(held);
                replaced.into_iter().for_each(|replaced| replaced.discard(held));
                Err(if error.kind() == io::ErrorKind::AlreadyExists {
                    Error::usage("has come into being meanwhile: give --force to overwrite it").at(path)
                } else {
                    unwritable(&error, &path)
                })
            }
        }
    }

    fn undo(self, held: &mut HeldRegistry) {
        match self.replaced {
            // The place holds one of the files in any case, so a failure here adds nothing.
            Some(replaced) if fs::rename(replaced.path(), &self.path).is_ok() => replaced.release(held),
            Some(replaced) => replaced.discard(held),
            None => {
                let _ = fs::remove_file(&self.path);
            }
        }
    }

    fn keep(self, held: &mut HeldRegistry) {
        self.replaced.into_iter().for_each(|replaced| replaced.discard(held));
    }
}

/// Refuses an output that is one of the inputs.
pub fn refuse_input(output: &Path, inputs: &[&Path]) -> Result<()> {
    if inputs.iter().any(|input| !is_stream(input) && is_same(input, output)) {
        return Err(Error::usage("is an input of this command: choose another output").at(output));
    }
    Ok(())
}

/// Refuses folders, and anything that is neither file nor folder.
fn refuse_kind(path: &Path) -> Result<()> {
    let there = fs::metadata(path);
    let is_stream_by_path =
        ["/dev/fd", "/dev/stdout", "/dev/stderr", "/proc"].iter().any(|own| path.starts_with(own));
    if there.as_ref().is_ok_and(fs::Metadata::is_dir) || path.file_name().is_none() {
        return Err(Error::usage("is a folder: name a file to write").at(path));
    }
    if is_stream_by_path || there.is_ok_and(|there| !there.is_file()) {
        return Err(
            Error::usage("is a device or a pipe: name a file to write, or - for standard output").at(path)
        );
    }
    Ok(())
}

/// Creates the folder of an output if it is missing.
fn make_folder(path: &Path, folders: &mut MadeFolders) -> Result<()> {
    let folder = folder_of(path);
    let around = folder.ancestors().find(|around| fs::symlink_metadata(around).is_ok());
    if let Some(file) = around.filter(|around| !around.is_dir()) {
        return Err(Error::usage(format!("cannot be written: {} is not a folder", file.display())).at(path));
    }
    folders.make(folder).map_err(|e| Error::io("cannot make its folder", &e).at(path))
}

/// Whether two paths name the same file, which need not exist.
fn is_same(a: &Path, b: &Path) -> bool {
    let real = |path: &Path| {
        fs::canonicalize(path).ok().or_else(|| {
            let folder = fs::canonicalize(folder_of(path)).ok()?;
            Some(folder.join(path.file_name()?))
        })
    };
    a == b || real(a).zip(real(b)).is_some_and(|(a, b)| a == b)
}

fn unwritable(error: &io::Error, path: &Path) -> Error {
    Error::io("cannot write the file", error).at(path)
}

/// Makes a rename durable where the system allows syncing a folder.
fn sync_folder(folder: &Path) {
    if let Ok(handle) = File::open(folder) {
        // Some file systems refuse to sync folders; the file itself is synced already.
        let _ = handle.sync_all();
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Two outputs with their bytes; something appears at the place of the second before they are put there.
    fn failing(folder: &Path, force: bool) -> Error {
        let [a, b] = ["a", "b"].map(|name| folder.join(name));
        let mut outputs = Outputs { force, files: Vec::new(), folders: MadeFolders::default() };
        for path in [&a, &b] {
            outputs.file(path, &[]).unwrap();
            outputs.write(path, b"new".to_vec()).unwrap();
        }
        fs::create_dir(&b).unwrap();
        let error = outputs.commit().unwrap_err();
        fs::remove_dir(&b).unwrap();
        error
    }

    #[test]
    fn when_a_second_output_fails_the_first_is_not_left() {
        let folder = tempfile::tempdir().unwrap();
        let error = failing(folder.path(), false);
        assert!(error.to_string().contains("meanwhile"), "{error}");
        assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 0);
    }

    #[test]
    fn when_a_second_output_fails_what_force_replaced_is_back() {
        let folder = tempfile::tempdir().unwrap();
        fs::write(folder.path().join("a"), "old").unwrap();
        failing(folder.path(), true);
        assert_eq!(fs::read_to_string(folder.path().join("a")).unwrap(), "old");
        assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 1);
    }
}
