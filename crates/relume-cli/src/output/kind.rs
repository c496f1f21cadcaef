//! The kind of an output by its name: a file is not written under the name of another kind.

use std::path::Path;

use relume::{Error, Result};

use super::is_stream;

/// The extensions of files that the program reads or writes, which are no names of folders.
const FILES: [&str; 24] = [
    "btf", "exr", "gif", "glb", "hdr", "hsh", "htm", "html", "jpeg", "jpg", "json", "ktx2", "lp", "mp4",
    "npy", "npz", "pfm", "png", "ptm", "rlm", "rti", "tif", "tiff", "zip",
];

fn has(path: &Path, extensions: &[&str]) -> bool {
    extensions.iter().any(|of| path.extension().is_some_and(|e| e.eq_ignore_ascii_case(of)))
}

/// Refuses the name of a file whose kind is fixed when it is that of another one; standard output has none.
///
/// # Errors
/// Another extension than those given, or none.
pub fn expect(path: &Path, what: &str, extensions: &[&str]) -> Result<()> {
    if is_stream(path) || has(path, extensions) {
        return Ok(());
    }
    let names: Vec<String> = extensions.iter().map(|extension| format!(".{extension}")).collect();
    Err(Error::usage(format!("would be {what}: name a file that ends in {}", names.join(" or "))).at(path))
}

/// Refuses the name of a file where a folder is written, unless there is such a folder.
///
/// # Errors
/// A name with the extension of a file.
pub fn expect_folder(path: &Path) -> Result<()> {
    if !has(path, &FILES) || path.is_dir() {
        return Ok(());
    }
    Err(Error::usage("is the name of a file, and a folder is written: name a folder").at(path))
}
