//! What files hold that are written for other programs, and read by none of the verbs as textures: previews in binary glTF,
//! textures in KTX2, arrays of NumPy, and folders of pages.

use std::borrow::Cow;
use std::io::{Cursor, Read};
use std::path::Path;

use serde_json::Value;
use zip::ZipArchive;

use crate::error::{Error, Result};

/// What such a file is, and its parts in the order in which they are listed.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct FileOutline {
    /// As in `a binary glTF`.
    pub what: &'static str,
    /// The name of each part, and what is said of it.
    pub parts: Vec<(String, String)>,
}

/// The parts listed at most.
const MOST_PARTS: usize = 64;

/// The bytes of the head of an array that are read: those of all that this program writes.
const ARRAY_HEAD: u64 = 1024;

const KTX2: &[u8] = b"\xabKTX 20\xbb\r\n\x1a\n";

/// The outline of the bytes of a file, if it is one of these.
///
/// # Errors
/// A file of such a kind that is damaged.
pub(super) fn outline(bytes: &[u8]) -> Result<Option<FileOutline>> {
    match bytes {
        _ if bytes.starts_with(b"glTF") => glb(bytes).map(Some),
        _ if bytes.starts_with(KTX2) => ktx2(bytes).map(Some),
        _ if bytes.starts_with(b"\x93NUMPY") => {
            let parts = vec![("array".to_owned(), array(bytes).ok_or_else(|| damaged("NPY"))?)];
            Ok(Some(FileOutline { what: "a NumPy array", parts }))
        }
        _ if bytes.starts_with(b"PK\x03\x04") => Ok(npz(bytes)),
        _ => Ok(None),
    }
}

/// The outline of a folder that `relume share` or `relume view` wrote: its textures.
///
/// # Errors
/// A description that is damaged.
pub(super) fn of_folder(folder: &Path) -> Result<Option<FileOutline>> {
    let mut parts = Vec::new();
    for number in 0..MOST_PARTS {
        let path = folder.join("textures").join(number.to_string()).join("share.json");
        let Ok(text) = std::fs::read(&path) else { break };
        let share: Value = serde_json::from_slice(&text)
            .map_err(|_| Error::invalid("the description of the texture is damaged").at(&path))?;
        let side = |k: usize| share["size"][k].as_u64().unwrap_or(0);
        let text = |value: &Value| value.as_str().unwrap_or("unknown").to_owned();
        parts.push((
            text(&share["title"]),
            format!(
                "{} x {} texels, basis {}, colour {}, {} values",
                side(0),
                side(1),
                text(&share["basis"]["name"]),
                text(&share["layout"]),
                text(&share["space"])
            ),
        ));
    }
    Ok((!parts.is_empty()).then_some(FileOutline { what: "a page with textures", parts }))
}

fn damaged(kind: &str) -> Error {
    Error::invalid(format!("the {kind} data is damaged or truncated: export the file again"))
}

fn word(bytes: &[u8], at: usize) -> Option<u32> {
    bytes.get(at..at + 4).map(|b| u32::from_le_bytes([b[0], b[1], b[2], b[3]]))
}

/// Meshes, materials and pictures by the description in the file.
fn glb(bytes: &[u8]) -> Result<FileOutline> {
    let broken = || damaged("GLB");
    let length = word(bytes, 12).ok_or_else(broken)? as usize;
    let text = bytes.get(20..20usize.saturating_add(length)).ok_or_else(broken)?;
    let root: Value = serde_json::from_slice(text).map_err(|_| broken())?;
    let list = |name: &str| root[name].as_array().cloned().unwrap_or_default();
    let name = |value: &Value| value["name"].as_str().unwrap_or("unnamed").to_owned();
    let mut parts = Vec::new();
    for mesh in list("meshes") {
        let primitives = mesh["primitives"].as_array().cloned().unwrap_or_default();
        let corners = |p: &Value| {
            let accessor = p["indices"].as_u64().or(p["attributes"]["POSITION"].as_u64())?;
            root["accessors"][accessor as usize]["count"].as_u64()
        };
        let triangles: u64 = primitives.iter().filter_map(corners).map(|count| count / 3).sum();
        parts.push((format!("mesh {}", name(&mesh)), format!("{triangles} triangles")));
    }
    for material in list("materials") {
        let alpha = material["alphaMode"].as_str().unwrap_or("OPAQUE").to_lowercase();
        let functions = &material["extensions"]["RELUME_reflectance"];
        let functions = if functions.is_object() { ", with functions of light" } else { "" };
        parts.push((format!("material {}", name(&material)), format!("{alpha}{functions}")));
    }
    for (k, image) in list("images").iter().enumerate() {
        let view = image["bufferView"].as_u64().map(|view| &root["bufferViews"][view as usize]["byteLength"]);
        let bytes = view.and_then(Value::as_u64).map_or(String::new(), |bytes| format!(", {bytes} bytes"));
        let kind = image["mimeType"].as_str().unwrap_or("of an unknown kind");
        parts.push((format!("picture {k}"), format!("{kind}{bytes}")));
    }
    parts.truncate(MOST_PARTS);
    Ok(FileOutline { what: "a binary glTF", parts })
}

/// Format, size and levels.
fn ktx2(bytes: &[u8]) -> Result<FileOutline> {
    let at = |place: usize| word(bytes, place).ok_or_else(|| damaged("KTX2"));
    let format = match at(12)? {
        9 => "one channel of 8 bits".to_owned(),
        16 => "two channels of 8 bits".to_owned(),
        23 | 37 => "data of 8 bits a channel".to_owned(),
        29 | 43 => "sRGB colours of 8 bits a channel".to_owned(),
        145 => "data in blocks of BC7".to_owned(),
        146 => "sRGB colours in blocks of BC7".to_owned(),
        other => format!("format {other} of Vulkan"),
    };
    let (width, height, levels) = (at(20)?, at(24)?, at(40)?);
    let parts = vec![("texture".to_owned(), format!("{width} x {height} texels, {levels} levels, {format}"))];
    Ok(FileOutline { what: "a KTX2 texture", parts })
}

/// The type and the shape of an array, as its head says them.
fn array(bytes: &[u8]) -> Option<String> {
    let length = usize::from(u16::from_le_bytes([*bytes.get(8)?, *bytes.get(9)?]));
    let head = std::str::from_utf8(bytes.get(10..10 + length)?).ok()?;
    let after = |key: &str| head.split_once(key).map(|(_, rest)| rest);
    let kind = after("'descr': '")?.split('\'').next()?;
    let shape = after("'shape': (")?.split(')').next()?.trim_end_matches(',');
    Some(format!("({shape}) of {kind}"))
}

/// The arrays of an archive of them; none of another archive.
fn npz(bytes: &[u8]) -> Option<FileOutline> {
    let mut archive = ZipArchive::new(Cursor::new(bytes)).ok()?;
    let names: Vec<String> =
        archive.file_names().map(|name| name.ok().map(Cow::into_owned)).collect::<Option<_>>()?;
    if names.is_empty() || !names.iter().all(|name| name.ends_with(".npy")) {
        return None;
    }
    let mut part = |name: &String| {
        let mut head = Vec::new();
        archive.by_name(name).ok()?.take(ARRAY_HEAD).read_to_end(&mut head).ok()?;
        Some((name.trim_end_matches(".npy").to_owned(), array(&head)?))
    };
    let parts = names.iter().take(MOST_PARTS).map(&mut part).collect::<Option<Vec<_>>>()?;
    Some(FileOutline { what: "an archive of NumPy arrays", parts })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn heads_are_read_and_damaged_ones_refused() {
        let npy = crate::format::npy::encode_f32(&[2, 3], &[0.0; 6]).unwrap();
        assert_eq!(outline(&npy).unwrap().unwrap().parts[0].1, "(2, 3) of <f4");
        assert_eq!(outline(b"other").unwrap(), None);
        for broken in
            [b"glTF".as_slice(), b"glTF\x02\0\0\0\xff\xff\0\0\xff\xff\xff\xffJSON", KTX2, b"\x93NUMPY\x01\0"]
        {
            assert!(outline(broken).unwrap_err().to_string().contains("damaged"), "{broken:?}");
        }
    }
}
