//! A folder that cannot be exchanged: the current one, a parent of it, or a mounted file system. Its entries
//! are exchanged one by one, and all steps are undone when one fails.

use std::ffi::OsString;
use std::fs;
use std::io;
use std::path::Path;

use super::place;

/// A step, with the entry that it moved.
enum Step {
    /// New and old entry were exchanged.
    Exchanged(OsString),
    /// A new entry was moved in.
    In(OsString),
    /// An old entry was moved out.
    Out(OsString),
}

/// Moves the entries of `stage`, a folder within `place`, to `place`, and the entries that they replace or
/// that are `outdated` into the stage.
///
/// # Errors
/// An entry that already exists, unless it may be replaced. Nothing has moved then.
pub fn move_in(stage: &Path, place: &Path, outdated: &[OsString], replaces: bool) -> io::Result<()> {
    let mut steps = Vec::new();
    let moved = new_entries(stage).and_then(|new| {
        for name in &new {
            steps.push(step_in(stage, place, name, replaces)?);
        }
        for name in outdated.iter().filter(|name| !new.contains(name) && place.join(name).exists()) {
            fs::rename(place.join(name), stage.join(name))?;
            steps.push(Step::Out(name.clone()));
        }
        Ok(())
    });
    if moved.is_err() {
        steps.iter().rev().for_each(|step| undo(step, stage, place));
    }
    moved
}

fn new_entries(stage: &Path) -> io::Result<Vec<OsString>> {
    let mut names =
        fs::read_dir(stage)?.map(|entry| Ok(entry?.file_name())).collect::<io::Result<Vec<OsString>>>()?;
    names.sort();
    Ok(names)
}

fn step_in(stage: &Path, place: &Path, name: &OsString, replaces: bool) -> io::Result<Step> {
    let (new, old) = (stage.join(name), place.join(name));
    if fs::symlink_metadata(&old).is_err() {
        fs::rename(&new, &old)?;
        return Ok(Step::In(name.clone()));
    }
    if !replaces {
        return Err(io::ErrorKind::AlreadyExists.into());
    }
    let mut aside = name.clone();
    aside.push(".old");
    place::exchange(&new, &old, &stage.join(aside))?;
    Ok(Step::Exchanged(name.clone()))
}

/// Undoes a step; if that fails too, the entry stays where it is.
fn undo(step: &Step, stage: &Path, place: &Path) {
    let _ = match step {
        Step::Exchanged(name) => place::exchange(&place.join(name), &stage.join(name), &stage.join("aside")),
        Step::In(name) => fs::rename(place.join(name), stage.join(name)),
        Step::Out(name) => fs::rename(stage.join(name), place.join(name)),
    };
}

#[cfg(test)]
mod tests {
    use super::*;

    fn write(path: &Path, text: &str) {
        fs::create_dir_all(path.parent().unwrap()).unwrap();
        fs::write(path, text).unwrap();
    }

    #[test]
    fn entries_are_exchanged_or_all_stay() {
        let folder = tempfile::tempdir().unwrap();
        let (place, stage) = (folder.path(), folder.path().join("stage"));
        write(&place.join("b/one"), "old");
        write(&place.join("gone"), "old");
        write(&stage.join("a"), "new");
        write(&stage.join("b/one"), "new");
        let text = |name: &str| fs::read_to_string(place.join(name)).unwrap();
        let refused = move_in(&stage, place, &["gone".into()], false).unwrap_err();
        assert_eq!(refused.kind(), io::ErrorKind::AlreadyExists);
        assert!(!place.join("a").exists() && text("b/one") == "old" && text("stage/a") == "new");
        move_in(&stage, place, &["gone".into()], true).unwrap();
        assert!(text("a") == "new" && text("b/one") == "new" && !place.join("gone").exists());
        assert!(text("stage/b/one") == "old");
    }
}
