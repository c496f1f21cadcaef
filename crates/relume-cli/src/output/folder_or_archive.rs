//! Files in a folder or, where the name of the output ends in `.zip`, in an archive that unpacks to such a folder.

use std::io::BufWriter;
use std::path::{Path, PathBuf};

use relume::Result;
use relume::format::ZipArchive;

use super::{Folder, Outputs};
use crate::context::Context;
use crate::paths;

/// Keeps a file by its path within the folder, with forward slashes.
pub type KeepFile<'a> = dyn FnMut(&str, &[u8]) -> Result<()> + 'a;

/// A claimed folder, or an archive.
#[derive(Debug)]
pub enum FolderOrArchive {
    /// A folder of files.
    Folder(Folder),
    /// One file; its name is that of the folder inside.
    Archive(Outputs, PathBuf),
}

/// Whether a name is that of a zip archive.
pub fn is_archive(path: &Path) -> bool {
    path.extension().is_some_and(|extension| extension.eq_ignore_ascii_case("zip"))
}

impl FolderOrArchive {
    /// Claims the output before any work is done for it.
    ///
    /// # Errors
    /// As [`Folder::stage`] and [`Outputs::file`].
    pub fn claim(path: &Path, inputs: &[&Path], context: &Context) -> Result<Self> {
        if !is_archive(path) {
            return Folder::stage(path, inputs, context).map(Self::Folder);
        }
        let mut outputs = Outputs::new(context);
        outputs.file(path, inputs)?;
        Ok(Self::Archive(outputs, path.to_path_buf()))
    }

    /// Puts the files of `produce` into their place, all of them or none. Returns what `produce` does, and the name
    /// of the output.
    ///
    /// # Errors
    /// Errors of `produce` and of the system.
    pub fn write<T>(self, produce: impl FnOnce(&mut KeepFile) -> Result<T>) -> Result<(T, Vec<PathBuf>)> {
        match self {
            Self::Folder(folder) => {
                let made = produce(&mut |name, bytes| folder.add(name, bytes))?;
                Ok((made, folder.commit()?))
            }
            Self::Archive(mut outputs, path) => {
                let mut made = None;
                outputs.write_with(&path, |file| {
                    let mut archive = ZipArchive::new(BufWriter::new(file), root_of(&path));
                    made = Some(produce(&mut |name, bytes| archive.add(name, bytes))?);
                    archive.finish().map(drop)
                })?;
                Ok((made.expect("produced, or an error before"), outputs.commit()?))
            }
        }
    }
}

/// The folder in an archive: the name of its file.
fn root_of(path: &Path) -> String {
    let stem = Path::new(path.file_stem().unwrap_or_default());
    stem.to_str().map_or_else(|| paths::percent_encoded(stem), str::to_owned)
}
