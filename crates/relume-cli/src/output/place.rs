//! Renames that put outputs in their places: without replacing, or in exchange for an existing folder.

use std::fs;
use std::io;
use std::path::Path;

/// Moves a file to its place, which must be free.
///
/// # Errors
/// [`io::ErrorKind::AlreadyExists`] if something has appeared there meanwhile.
pub fn rename_new(from: &Path, to: &Path) -> io::Result<()> {
    #[cfg(any(target_os = "linux", target_os = "macos"))]
    match renamed(from, to, rustix::fs::RenameFlags::NOREPLACE) {
        Err(error) if is_unknown(&error) => {}
        done => return done,
    }
    match fs::hard_link(from, to) {
        Ok(()) => fs::remove_file(from),
        Err(error) if error.kind() == io::ErrorKind::AlreadyExists => Err(error),
        // A file system without hard links: it remains to check first.
        Err(_) if fs::symlink_metadata(to).is_ok() => Err(io::ErrorKind::AlreadyExists.into()),
        Err(_) => fs::rename(from, to),
    }
}

/// Moves a folder to its place, which must be free or an empty folder.
///
/// # Errors
/// If a file or a folder that is not empty has appeared there meanwhile.
pub fn rename_folder(from: &Path, to: &Path) -> io::Result<()> {
    // Not all systems rename over an empty folder; one that is not empty is not removed here.
    if cfg!(not(unix)) {
        let _ = fs::remove_dir(to);
    }
    if fs::symlink_metadata(to).is_ok_and(|there| !there.is_dir()) {
        return Err(io::ErrorKind::AlreadyExists.into());
    }
    fs::rename(from, to)
}

/// Exchanges two folders, in one step if the system supports it. Otherwise the folder at `place` is
/// temporarily called `aside`.
///
/// # Errors
/// If they cannot be exchanged; both are then unchanged.
pub fn exchange(new: &Path, place: &Path, aside: &Path) -> io::Result<()> {
    #[cfg(any(target_os = "linux", target_os = "macos"))]
    match renamed(new, place, rustix::fs::RenameFlags::EXCHANGE) {
        Err(error) if is_unknown(&error) => {}
        done => return done,
    }
    fs::rename(place, aside)?;
    if let Err(error) = fs::rename(new, place) {
        fs::rename(aside, place)?;
        return Err(error);
    }
    fs::rename(aside, new)
}

#[cfg(any(target_os = "linux", target_os = "macos"))]
fn renamed(from: &Path, to: &Path, how: rustix::fs::RenameFlags) -> io::Result<()> {
    rustix::fs::renameat_with(rustix::fs::CWD, from, rustix::fs::CWD, to, how).map_err(io::Error::from)
}

/// Whether the kernel or the file system does not support this kind of rename.
#[cfg(any(target_os = "linux", target_os = "macos"))]
fn is_unknown(error: &io::Error) -> bool {
    use rustix::io::Errno;
    let unknown = [Errno::INVAL, Errno::NOSYS, Errno::NOTSUP, Errno::OPNOTSUPP];
    unknown.iter().any(|errno| error.raw_os_error() == Some(errno.raw_os_error()))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn nothing_is_replaced_that_came_there_meanwhile() {
        let folder = tempfile::tempdir().unwrap();
        let at = |name: &str| folder.path().join(name);
        fs::write(at("new"), "new").unwrap();
        fs::write(at("old"), "old").unwrap();
        assert_eq!(rename_new(&at("new"), &at("old")).unwrap_err().kind(), io::ErrorKind::AlreadyExists);
        assert_eq!(fs::read_to_string(at("old")).unwrap(), "old");
        rename_new(&at("new"), &at("free")).unwrap();
        assert!(!at("new").exists() && at("free").exists());

        fs::create_dir(at("stage")).unwrap();
        fs::create_dir_all(at("full/inner")).unwrap();
        assert!(rename_folder(&at("stage"), &at("full")).is_err());
        assert!(rename_folder(&at("stage"), &at("old")).is_err());
        fs::create_dir(at("empty")).unwrap();
        rename_folder(&at("stage"), &at("empty")).unwrap();
        assert!(!at("stage").exists() && at("full/inner").exists());
    }

    #[test]
    fn folders_change_places() {
        let folder = tempfile::tempdir().unwrap();
        let at = |name: &str| folder.path().join(name);
        fs::create_dir_all(at("a/inside_a")).unwrap();
        fs::create_dir_all(at("b/inside_b")).unwrap();
        exchange(&at("a"), &at("b"), &at("aside")).unwrap();
        assert!(at("a/inside_b").exists() && at("b/inside_a").exists() && !at("aside").exists());
        assert!(exchange(&at("a"), &at("missing"), &at("aside")).is_err());
        assert!(at("a/inside_b").exists());
    }
}
