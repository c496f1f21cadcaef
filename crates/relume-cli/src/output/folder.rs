//! A folder of outputs, which appears completely or not at all.
//!
//! It is staged beside its final place. If there is no folder yet, or an empty one, it is renamed there; an
//! existing folder needs `--force` and is exchanged in one step, so that old and new files are never seen
//! mixed. Files that relume wrote into the old folder, according to [`FileList`], are removed with it; all
//! other files are carried over. If a folder cannot be exchanged, its entries are ([`within`]).

use std::fs::{self, File};
use std::io::{self, Write};
use std::path::{Component, Path, PathBuf};
use std::sync::{Mutex, PoisonError};

use relume::{Error, ErrorKind, Result, Stamp};

use super::file_list::{self, FileList};
use super::temporary::{HeldRegistry, MadeFolders, Temporary, folder_of, hold, is_temporary};
use super::{is_stream, make_folder, place, refuse_input, sync_folder, within};
use crate::context::Context;

/// A folder of outputs.
#[derive(Debug)]
pub struct Folder {
    /// As it was named.
    target: PathBuf,
    /// The same without links.
    place: PathBuf,
    stage: Temporary,
    made: MadeFolders,
    replaces: bool,
    written: Mutex<FileList>,
}

impl Folder {
    /// Stages a folder, which must not be one of `inputs`; an existing one that is not empty needs `--force`.
    pub fn stage(target: &Path, inputs: &[&Path], context: &Context) -> Result<Self> {
        refuse(target, inputs, context.force)?;
        let mut made = MadeFolders::default();
        let place = place_of(target);
        make_folder(&place, &mut made).map_err(|e| e.at(target))?;
        let around = if is_fixed(&place) { &place } else { folder_of(&place) };
        let stage = Temporary::folder(around)
            .map_err(|e| Error::io("cannot make a folder beside it", &e).at(target))?;
        let written = Mutex::default();
        Ok(Self { target: target.to_path_buf(), place, stage, made, replaces: context.force, written })
    }

    /// The location of the files until the folder is committed.
    pub fn path(&self) -> &Path {
        self.stage.path()
    }

    /// A temporary folder, removed when the guard drops.
    pub fn scratch(&self) -> Result<Temporary> {
        Temporary::folder(self.path())
            .map_err(|e| Error::io("cannot make a folder in it", &e).at(&self.target))
    }

    /// Adds a file by its path within the folder.
    ///
    /// # Panics
    /// When the name leaves the folder; names are the program's own.
    pub fn add(&self, name: impl AsRef<Path>, bytes: &[u8]) -> Result<()> {
        let name = name.as_ref();
        assert!(name.components().all(|c| matches!(c, Component::Normal(_))), "names stay in the folder");
        let path = self.stage.path().join(name);
        // Nothing is created any more while a signal has the folder removed.
        let held = hold();
        let created = fs::create_dir_all(folder_of(&path)).and_then(|()| File::create(&path));
        drop(held);
        let written = created.and_then(|mut file| file.write_all(bytes).and_then(|()| file.sync_all()));
        written.map_err(|e| Error::io("cannot write the file", &e).at(self.target.join(name)))?;
        self.written.lock().unwrap_or_else(PoisonError::into_inner).add(name, Stamp::of(bytes));
        Ok(())
    }

    /// Puts the folder in its place, and says its name.
    ///
    /// # Errors
    /// Where another has come there meanwhile, or a file that is carried over is in the way of a new one.
    pub fn commit(self) -> Result<Vec<PathBuf>> {
        let Self { target, place, stage, made, replaces, written } = self;
        let failed = |error: &io::Error| Error::io("cannot put the folder in place", error).at(&target);
        let written = written.into_inner().unwrap_or_else(PoisonError::into_inner);
        let list = written.completed(stage.path()).map_err(|e| failed(&e))?;
        file_list::write(stage.path(), &list).map_err(|e| failed(&e))?;
        let own = FileList::read(&place);
        if replaces && place.is_dir() {
            carry_over(&place, stage.path(), &own).map_err(|e| e.at(&target))?;
        }
        if !is_fixed(&place) {
            keep_permissions(&place, stage.path());
        }
        // No signal ends the program between two renames.
        let mut held = hold();
        if let Err(error) = put(stage, &place, &own, replaces, &mut held) {
            drop(held);
            return Err(match error.kind() {
                io::ErrorKind::AlreadyExists | io::ErrorKind::DirectoryNotEmpty => {
                    Error::usage("has come into being meanwhile: give --force to replace it").at(&target)
                }
                _ => failed(&error),
            });
        }
        made.keep(&mut held);
        drop(held);
        sync_folder(folder_of(&place));
        Ok(vec![target])
    }
}

/// Renames the staged folder to its place, or exchanges it for what is there.
fn put(
    stage: Temporary,
    place: &Path,
    own: &FileList,
    replaces: bool,
    held: &mut HeldRegistry,
) -> io::Result<()> {
    let done = if is_fixed(place) {
        within::move_in(stage.path(), place, &own.top_entries(), replaces)
    } else if is_occupied(place) && replaces {
        let mut aside = place.as_os_str().to_owned();
        aside.push(format!(".relume-{}.old", std::process::id()));
        place::exchange(stage.path(), place, Path::new(&aside))
    } else {
        let renamed = place::rename_folder(stage.path(), place);
        if renamed.is_ok() {
            stage.release(held);
            return renamed;
        }
        renamed
    };
    // The stage holds the old files now, or the new ones that found no place.
    stage.discard(held);
    done
}

/// Refuses a folder before any work is done for it.
fn refuse(target: &Path, inputs: &[&Path], force: bool) -> Result<()> {
    if is_stream(target) {
        return Err(Error::usage("a folder of files cannot go to standard output: name a folder"));
    }
    if target.exists() && !target.is_dir() {
        return Err(Error::usage("is a file: name a folder to write into").at(target));
    }
    if target.is_dir() && !is_writable(target) {
        let message = "is read-only for this user: make it writable, or name another folder";
        return Err(Error::new(ErrorKind::Io, message).at(target));
    }
    super::kind::expect_folder(target)?;
    if is_occupied(target) && !force {
        return Err(Error::usage(
            "exists already and is not empty: give --force to replace what relume wrote there",
        )
        .at(target));
    }
    refuse_input(target, inputs)?;
    inputs.iter().try_for_each(|input| refuse_replaced(target, input))
}

/// Refuses a folder with an input that relume wrote there, and would replace with the folder.
fn refuse_replaced(target: &Path, input: &Path) -> Result<()> {
    let (Ok(folder), Ok(file)) = (fs::canonicalize(target), fs::canonicalize(input)) else { return Ok(()) };
    match file.strip_prefix(&folder) {
        Ok(name) if FileList::read(&folder).holds(name) => Err(Error::usage(format!(
            "holds {}, an input of this command, and would be replaced: name another folder",
            input.display()
        ))
        .at(target)),
        _ => Ok(()),
    }
}

/// Whether this user may add entries to a folder and remove them.
fn is_writable(folder: &Path) -> bool {
    #[cfg(unix)]
    {
        rustix::fs::access(folder, rustix::fs::Access::WRITE_OK).is_ok()
    }
    #[cfg(not(unix))]
    {
        let _ = folder;
        true
    }
}

/// Gives a new folder the permissions of the one whose place it takes, if there is one. A file system without
/// permissions refuses it, and has none to keep.
fn keep_permissions(old: &Path, new: &Path) {
    let _ = fs::metadata(old).and_then(|old| fs::set_permissions(new, old.permissions()));
}

/// Whether a folder cannot be renamed without harm: the current one, one around it, or a mounted file
/// system.
fn is_fixed(place: &Path) -> bool {
    fs::canonicalize(place).is_ok_and(|real| {
        is_mounted(&real) || std::env::current_dir().is_ok_and(|here| here.starts_with(&real))
    })
}

/// Whether another file system begins at a folder.
fn is_mounted(real: &Path) -> bool {
    #[cfg(unix)]
    {
        use std::os::unix::fs::MetadataExt;
        let device = |path: &Path| fs::metadata(path).ok().map(|there| there.dev());
        real.parent().is_none_or(|around| device(around) != device(real))
    }
    #[cfg(not(unix))]
    {
        let _ = real;
        false
    }
}

fn is_occupied(folder: &Path) -> bool {
    let is_own = |name: &std::ffi::OsStr| is_temporary(&name.to_string_lossy());
    fs::read_dir(folder).is_ok_and(|entries| entries.flatten().any(|entry| !is_own(&entry.file_name())))
}

/// The folder itself where its name is a link to it.
fn place_of(target: &Path) -> PathBuf {
    fs::canonicalize(target).unwrap_or_else(|_| target.to_path_buf())
}

/// Gives the files of an old folder that relume did not write a second name in the new one, or copies
/// them: whatever ends the program, they are in the folder that stays.
fn carry_over(old: &Path, new: &Path, own: &FileList) -> Result<()> {
    let tops = own.top_entries();
    // Where entries are exchanged one by one, those that are not touched stay where they are.
    let stays = |name: &Path| {
        let top = name.iter().next().unwrap_or_default();
        is_fixed(old) && !new.join(top).exists() && !tops.iter().any(|own| own == top)
    };
    let mut folders = Vec::new();
    for name in file_list::walk(old).map_err(|e| Error::io("cannot read the folder", &e))? {
        let is_folder = fs::symlink_metadata(old.join(&name)).is_ok_and(|from| from.is_dir());
        if is_folder {
            folders.push(name.clone());
        }
        if own.holds(&name) || stays(&name) {
            continue;
        }
        let (from, to) = (old.join(&name), new.join(&name));
        let there = fs::symlink_metadata(&to);
        match there {
            Ok(there) if there.is_dir() == is_folder => continue,
            Ok(_) => return Err(in_the_way(&name)),
            Err(_) => {}
        }
        let carried = if is_folder {
            fs::create_dir(&to)
        } else {
            fs::hard_link(&from, &to).or_else(|_| fs::copy(&from, &to).map(|_| ()))
        };
        carried.map_err(|e| Error::io(format!("cannot carry {} over", name.display()), &e))?;
    }
    // Inner folders first: one that is read-only takes no more entries.
    for name in folders.iter().rev().filter(|name| new.join(name).is_dir()) {
        keep_permissions(&old.join(name), &new.join(name));
    }
    Ok(())
}

fn in_the_way(name: &Path) -> Error {
    Error::usage(format!("holds {}, which is in the way and not relume's: move it", name.display()))
}
