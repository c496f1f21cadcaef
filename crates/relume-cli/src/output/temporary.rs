//! Temporary files and folders beside their final places: named, locked, and removed however the work ends.
//!
//! A temporary is called `.relume-PROCESS-NUMBER.tmp` and locked by the process that owns it (an advisory
//! lock, which the system releases when the process ends). A temporary that can be locked therefore has no
//! owner any more and is removed by the next run that writes into its folder. The registry lists the
//! temporaries of this process, so that a signal can remove them ([`remove_all`]).

use std::fs::{self, File, OpenOptions};
use std::io;
use std::path::{Path, PathBuf};
use std::sync::{Mutex, MutexGuard, PoisonError};

/// The outputs that this process has created and not yet put in place.
#[derive(Debug, Default)]
struct Registry {
    /// Temporaries; those of folders count as one.
    temporaries: Vec<PathBuf>,
    /// Folders created for outputs, outer ones first; kept only if an output is put into them.
    folders: Vec<PathBuf>,
    /// Folders already searched for leftovers of other runs.
    searched: Vec<PathBuf>,
    /// The number of the next temporary.
    next: u64,
}

static REGISTRY: Mutex<Registry> =
    Mutex::new(Registry { temporaries: Vec::new(), folders: Vec::new(), searched: Vec::new(), next: 0 });

/// While this is held, nothing is created, put in place or removed by others.
#[derive(Debug)]
pub struct HeldRegistry(MutexGuard<'static, Registry>);

/// Waits until no other thread creates outputs or puts them in place.
pub fn hold() -> HeldRegistry {
    HeldRegistry(REGISTRY.lock().unwrap_or_else(PoisonError::into_inner))
}

/// Removes every temporary of this process and the empty folders created for outputs. Nothing is created as
/// long as the guard lives.
pub fn remove_all() -> HeldRegistry {
    let mut held = hold();
    for path in std::mem::take(&mut held.0.temporaries) {
        remove(&path);
    }
    for folder in std::mem::take(&mut held.0.folders).iter().rev() {
        // One that others have filled since stays.
        let _ = fs::remove_dir(folder);
    }
    held
}

/// A file or folder of this process that is removed unless it is put in place.
#[derive(Debug)]
pub struct Temporary {
    path: PathBuf,
    /// The open file, or folder if the system can open one; its lock shows that the owner is alive.
    handle: Option<File>,
}

impl Temporary {
    /// An empty file with the permissions of a new file.
    ///
    /// # Errors
    /// When the folder cannot be written.
    pub fn file(folder: &Path) -> io::Result<Self> {
        Self::create(folder, |path| {
            OpenOptions::new().read(true).write(true).create_new(true).open(path).map(Some)
        })
    }

    /// An empty folder.
    ///
    /// # Errors
    /// When the folder around it cannot be written.
    pub fn folder(folder: &Path) -> io::Result<Self> {
        // Some systems cannot open folders, hence cannot lock them.
        Self::create(folder, |path| fs::create_dir(path).map(|()| File::open(path).ok()))
    }

    /// A hard link to an existing file, so that it can be restored.
    ///
    /// # Errors
    /// When the file system has no hard links.
    pub fn link(file: &Path, held: &mut HeldRegistry) -> io::Result<Self> {
        Self::create_held(folder_of(file), held, |path| {
            fs::hard_link(file, path).map(|()| File::open(path).ok())
        })
    }

    fn create(folder: &Path, make: impl Fn(&Path) -> io::Result<Option<File>>) -> io::Result<Self> {
        let mut held = hold();
        if !held.0.searched.iter().any(|searched| searched == folder) {
            held.0.searched.push(folder.to_owned());
            remove_stale(folder);
        }
        Self::create_held(folder, &mut held, make)
    }

    fn create_held(
        folder: &Path,
        held: &mut HeldRegistry,
        make: impl Fn(&Path) -> io::Result<Option<File>>,
    ) -> io::Result<Self> {
        loop {
            held.0.next += 1;
            let path = folder.join(format!(".relume-{}-{}.tmp", std::process::id(), held.0.next));
            let handle = match make(&path) {
                Ok(handle) => handle,
                Err(error) if error.kind() == io::ErrorKind::AlreadyExists => continue,
                Err(error) => return Err(error),
            };
            if handle.as_ref().is_some_and(|handle| is_taken(handle, &path)) {
                continue;
            }
            held.0.temporaries.push(path.clone());
            return Ok(Self { path, handle });
        }
    }

    /// Its path.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// The open file.
    ///
    /// # Panics
    /// If it is a folder that could not be opened.
    pub fn file_mut(&mut self) -> &mut File {
        self.handle.as_mut().expect("a temporary file is open")
    }

    /// Makes its bytes durable.
    pub fn sync(&self) -> io::Result<()> {
        self.handle.as_ref().map_or(Ok(()), File::sync_all)
    }

    /// Releases it: it has been put in place under another name.
    pub fn release(mut self, held: &mut HeldRegistry) {
        held.0.temporaries.retain(|path| *path != self.path);
        self.path = PathBuf::new();
    }

    /// Removes it while the registry is held.
    pub fn discard(mut self, held: &mut HeldRegistry) {
        let path = std::mem::take(&mut self.path);
        held.0.temporaries.retain(|other| *other != path);
        remove(&path);
    }
}

impl Drop for Temporary {
    fn drop(&mut self) {
        if !self.path.as_os_str().is_empty() {
            // A signal waits until it is gone.
            let mut held = hold();
            held.0.temporaries.retain(|path| *path != self.path);
            remove(&self.path);
        }
    }
}

/// Folders created for outputs, removed again if no output is put into them.
#[derive(Debug, Default)]
pub struct MadeFolders(Vec<PathBuf>);

impl MadeFolders {
    /// Creates a folder and its missing parents.
    ///
    /// # Errors
    /// When one of them cannot be created.
    pub fn make(&mut self, folder: &Path) -> io::Result<()> {
        let missing = folder
            .ancestors()
            .take_while(|around| !around.as_os_str().is_empty() && fs::symlink_metadata(around).is_err());
        let missing: Vec<PathBuf> = missing.map(Path::to_owned).collect();
        let mut held = hold();
        for folder in missing.into_iter().rev() {
            match fs::create_dir(&folder) {
                Ok(()) => {
                    held.0.folders.push(folder.clone());
                    self.0.push(folder);
                }
                // Another process was faster.
                Err(error) if error.kind() == io::ErrorKind::AlreadyExists => {}
                Err(error) => return Err(error),
            }
        }
        Ok(())
    }

    /// Keeps the folders: they hold outputs now.
    pub fn keep(mut self, held: &mut HeldRegistry) {
        let kept = std::mem::take(&mut self.0);
        held.0.folders.retain(|folder| !kept.contains(folder));
    }
}

impl Drop for MadeFolders {
    fn drop(&mut self) {
        if self.0.is_empty() {
            return;
        }
        let mut held = hold();
        held.0.folders.retain(|folder| !self.0.contains(folder));
        for folder in self.0.iter().rev() {
            // One that others have filled since stays.
            let _ = fs::remove_dir(folder);
        }
    }
}

/// The folder that holds a path.
pub fn folder_of(path: &Path) -> &Path {
    match path.parent() {
        Some(folder) if !folder.as_os_str().is_empty() => folder,
        _ => Path::new("."),
    }
}

/// Locks a new temporary; tells whether another process took it for a stale one in between.
fn is_taken(handle: &File, path: &Path) -> bool {
    match handle.try_lock() {
        Ok(()) => fs::symlink_metadata(path).is_err(),
        Err(fs::TryLockError::WouldBlock) => true,
        // Without locks, nothing is ever considered stale.
        Err(fs::TryLockError::Error(_)) => false,
    }
}

/// Removes the temporaries in a folder whose owners have ended.
fn remove_stale(folder: &Path) {
    for entry in fs::read_dir(folder).into_iter().flatten().flatten() {
        let is_plain = entry.file_type().is_ok_and(|kind| kind.is_file() || kind.is_dir());
        if !is_plain || !is_temporary(&entry.file_name().to_string_lossy()) {
            continue;
        }
        // The lock is kept until the temporary is gone.
        if let Some(handle) = File::open(entry.path()).ok().filter(|handle| handle.try_lock().is_ok()) {
            remove(&entry.path());
            drop(handle);
        }
    }
}

/// Whether a name is `.relume-PROCESS-NUMBER.tmp`.
pub fn is_temporary(name: &str) -> bool {
    let inner = name.strip_prefix(".relume-").and_then(|name| name.strip_suffix(".tmp"));
    let numbers = inner.and_then(|inner| inner.split_once('-'));
    let is_number = |text: &str| !text.is_empty() && text.bytes().all(|b| b.is_ascii_digit());
    numbers.is_some_and(|(process, number)| is_number(process) && is_number(number))
}

/// Removes a file, or a folder with all its contents; missing ones are fine.
fn remove(path: &Path) {
    // Others may write into a folder while it is removed: a few rounds are enough.
    for _ in 0..8 {
        let removed = match fs::symlink_metadata(path) {
            // An empty folder goes even where no file can be opened any more.
            Ok(kind) if kind.is_dir() => fs::remove_dir(path).or_else(|_| fs::remove_dir_all(path)),
            Ok(_) => fs::remove_file(path),
            Err(_) => return,
        };
        if removed.is_ok() {
            return;
        }
        make_writable(path);
    }
}

/// Lets the folders of a tree give up their entries: those of an old output may be read-only.
fn make_writable(path: &Path) {
    #[cfg(unix)]
    {
        use std::os::unix::fs::PermissionsExt;
        if fs::symlink_metadata(path).is_ok_and(|kind| kind.is_dir()) {
            let _ = fs::set_permissions(path, fs::Permissions::from_mode(0o700));
            let entries = fs::read_dir(path).into_iter().flatten().flatten();
            entries.for_each(|entry| make_writable(&entry.path()));
        }
    }
    #[cfg(not(unix))]
    let _ = path;
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_a_kill_left_is_removed_and_what_a_living_process_owns_is_not() {
        let folder = tempfile::tempdir().unwrap();
        let left = folder.path().join(".relume-4000000000-7.tmp");
        fs::create_dir(&left).unwrap();
        fs::write(left.join("half.png"), "half").unwrap();
        let others = [".relume-abc.tmp", "relume-1-2.tmp", ".relume-1-2.tmp.png"];
        others.iter().for_each(|name| fs::write(folder.path().join(name), "").unwrap());
        let owned = folder.path().join(".relume-4000000000-8.tmp");
        let handle = File::create(&owned).unwrap();
        handle.lock().unwrap();
        let own = Temporary::file(folder.path()).unwrap();
        assert!(!left.exists() && owned.exists() && own.path().exists());
        remove_stale(folder.path());
        assert!(own.path().exists(), "a run must not remove what it owns itself");
        assert!(others.iter().all(|name| folder.path().join(name).exists()));
        drop(handle);
        remove_stale(folder.path());
        assert!(!owned.exists());
    }

    #[cfg(unix)]
    #[test]
    fn a_tree_with_read_only_folders_is_removed() {
        use std::os::unix::fs::PermissionsExt;
        let folder = tempfile::tempdir().unwrap();
        let tree = Temporary::folder(folder.path()).unwrap();
        let inner = tree.path().join("a/b");
        fs::create_dir_all(&inner).unwrap();
        fs::write(inner.join("f"), "").unwrap();
        for closed in [&inner, &tree.path().join("a"), tree.path()] {
            fs::set_permissions(closed, fs::Permissions::from_mode(0o555)).unwrap();
        }
        drop(tree);
        assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 0);
    }

    #[test]
    fn folders_made_for_outputs_go_again_unless_they_are_kept() {
        let folder = tempfile::tempdir().unwrap();
        let deep = folder.path().join("a/b/c");
        let mut made = MadeFolders::default();
        made.make(&deep).unwrap();
        assert!(deep.is_dir());
        drop(made);
        assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 0);
        let mut made = MadeFolders::default();
        made.make(&deep).unwrap();
        made.keep(&mut hold());
        assert!(deep.is_dir());
    }
}
