//! A folder of maps as one exemplar: which file is what, by the words in their names, and which have a say in the choice
//! of texels.

use std::fs;
use std::path::{Path, PathBuf};

use relume::format::{MapRole, NormalY, PackedMap};
use relume::workflow::Btf;
use relume::{Error, Named, Result};
use serde_json::{Value, json};

use crate::registered::written_as;
use crate::report::Report;
use crate::{normals, paths};

/// Extensions of pictures.
const EXTENSIONS: [&str; 9] = ["png", "jpg", "jpeg", "tif", "tiff", "exr", "pfm", "hdr", "pic"];
/// Extensions of pictures that are not read.
const UNREAD: [&str; 12] =
    ["bmp", "webp", "tga", "gif", "jp2", "jxl", "avif", "heic", "dds", "psd", "ktx", "ktx2"];
/// Files that relume itself writes beside maps.
const OWN_RECORDS: [&str; 3] = ["relume-files.json", "maps.json", "material.json"];

/// The maps in a folder.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct MapFolder {
    folder: PathBuf,
    /// The colours, to which all others are registered.
    pub color: PathBuf,
    /// Maps that have a say.
    pub compared: Vec<PathBuf>,
    /// Maps that say again what another one says: normals of the other convention, packed maps beside single ones.
    pub followed: Vec<PathBuf>,
    /// Files whose names say nothing.
    unknown: Vec<PathBuf>,
}

/// The error of a folder without a colour map, whose other files have names that say nothing.
fn without_color(unknown: &[PathBuf]) -> Error {
    let unread: Vec<String> =
        unknown.iter().filter(|path| is_unread_picture(path)).map(|path| name(path)).collect();
    if unread.is_empty() {
        return Error::usage(
            "holds no colour map that is known by its name, such as Wall_Color.png: name the exemplar itself, and the maps \
             registered with it after --apply",
        );
    }
    Error::unsupported(format!(
        "holds no colour map that is read; pictures of these formats are not: {} (export them as PNG, TIFF or EXR)",
        unread.join(", ")
    ))
}

impl MapFolder {
    /// The maps where the inputs of a verb are one folder of maps; `None` for files, photographs with their lights, textures of
    /// light and view, and web folders.
    ///
    /// # Errors
    /// A folder that cannot be read, one of pictures without a colour map, or two colour maps.
    pub fn of(inputs: &[PathBuf]) -> Result<Option<Self>> {
        let [folder] = inputs else { return Ok(None) };
        if !folder.is_dir() || relume::format::web::is_at(folder) || Btf::is_at(folder) {
            return Ok(None);
        }
        let files = files(folder)?;
        let is_color = |path: &PathBuf| is_picture(path) && MapRole::of_name(path) == MapRole::Albedo;
        if files.iter().any(|path| extension(path) == "lp") && !files.iter().any(is_color) {
            return Ok(None);
        }
        Self::among(folder, files).map(Some)
    }

    fn among(folder: &Path, files: Vec<PathBuf>) -> Result<Self> {
        let is_map = |path: &PathBuf| is_picture(path) && MapRole::of_name(path) != MapRole::Other;
        let (maps, unknown): (Vec<PathBuf>, Vec<PathBuf>) = files.into_iter().partition(is_map);
        let is_own = |path: &PathBuf| OWN_RECORDS.iter().any(|own| path.ends_with(own));
        let unknown: Vec<PathBuf> = unknown.into_iter().filter(|path| !is_own(path)).collect();
        let (colors, mut others): (Vec<PathBuf>, Vec<PathBuf>) =
            maps.into_iter().partition(|path| MapRole::of_name(path) == MapRole::Albedo);
        let color = match &colors[..] {
            [color] => color.clone(),
            [] => return Err(without_color(&unknown).at(folder)),
            [first, second, ..] => {
                return Err(Error::usage(format!(
                    "both this file and {} look like the colour map: name the exemplar itself, and the maps registered with \
                     it after --apply",
                    second.display()
                ))
                .at(first));
            }
        };
        others.sort_by_key(|path| rank(path));
        let (mut compared, mut followed) = (Vec::new(), Vec::new());
        let mut said: Vec<MapRole> = Vec::new();
        for path in others {
            let new: Vec<MapRole> = meanings(&path).into_iter().filter(|role| !said.contains(role)).collect();
            if new.is_empty() {
                followed.push(path)
            } else {
                compared.push(path)
            }
            said.extend(new);
        }
        compared.sort();
        followed.sort();
        Ok(Self { folder: folder.to_owned(), color, compared, followed, unknown })
    }

    /// The colour map's own output in a folder, in the format of `extension` or its own, which is PNG for JPEG.
    pub fn output(&self, folder: &Path, extension: Option<&str>) -> PathBuf {
        written_as(folder.join(self.color.file_name().unwrap_or_default()), extension)
    }

    /// The report of a verb, with what was recognised as what.
    pub fn describe(&self, mut report: Report) -> Report {
        let of = |path: &PathBuf, is_compared: bool| {
            json!({
                "file": paths::text(path),
                "role": MapRole::of_name(path),
                "channels": PackedMap::of_name(path).map(PackedMap::channels),
                "normal_y": NormalY::of_name(path),
                "compared": is_compared,
            })
        };
        let compared = std::iter::once(&self.color).chain(&self.compared).map(|path| of(path, true));
        let maps: Vec<Value> = compared.chain(self.followed.iter().map(|path| of(path, false))).collect();
        report.json["recognised"] = Value::Array(maps);
        report.json["unknown"] = self.unknown.iter().map(paths::text).collect();
        let all = std::iter::once(&self.color).chain(&self.compared).chain(&self.followed);
        let list: Vec<String> = all.map(|path| format!("{}: {}", name(path), in_words(path))).collect();
        report.text.push_str(&format!("\n{}: {}", self.folder.display(), list.join("; ")));
        report.with_warnings(self.twice().into_iter().chain(self.left_out()))
    }

    /// What is said of files that are no maps.
    fn left_out(&self) -> Vec<String> {
        let (unread, others): (Vec<&PathBuf>, Vec<&PathBuf>) =
            self.unknown.iter().partition(|path| is_unread_picture(path));
        let (unknown, others): (Vec<&PathBuf>, Vec<&PathBuf>) =
            others.into_iter().partition(|path| is_picture(path));
        let said = |paths: &[&PathBuf], what: &str, advice: &str| {
            let names: Vec<String> = paths.iter().map(|path| name(path)).collect();
            let folder = self.folder.display();
            (!names.is_empty())
                .then(|| format!("{folder}: {what}, and they are left out: {}{advice}", names.join(", ")))
        };
        let unread =
            said(&unread, "pictures of these formats are not read", " (export them as PNG, TIFF or EXR)");
        let unknown = said(&unknown, "the names say no map", " (--apply and --follow take them)");
        let others = said(&others, "these files are no pictures", "");
        [unread, unknown, others].into_iter().flatten().collect()
    }

    /// What is said of maps whose names say the same, of which one has no say.
    fn twice(&self) -> Vec<String> {
        let what = |path: &PathBuf| (MapRole::of_name(path), NormalY::of_name(path).unwrap_or_default());
        let with_say = |path: &PathBuf| self.compared.iter().find(|other| what(other) == what(path));
        let single = self.followed.iter().filter(|path| MapRole::of_name(path) != MapRole::Packed);
        let pairs = single.filter_map(|path| Some((path, with_say(path)?)));
        let said = pairs.map(|(path, other)| {
            let (path, other, what) = (name(path), name(other), in_words(path));
            format!("{other} and {path} are both named {what}: both are rearranged, and the first has a say in where texels go")
        });
        said.collect()
    }
}

/// What a map says, in words.
pub fn in_words(path: &Path) -> String {
    let role = MapRole::of_name(path);
    match (role, PackedMap::of_name(path), NormalY::of_name(path)) {
        (MapRole::Packed, Some(packed), _) => {
            let names: Vec<&str> = packed.channels().iter().map(|role| role.name()).collect();
            format!("{} packed", names.join(", "))
        }
        (MapRole::Normal, _, Some(y)) => normals::described(y),
        _ => role.name().to_owned(),
    }
}

/// The roles of the channels of a map; roughness and smoothness say the same.
fn meanings(path: &Path) -> Vec<MapRole> {
    let of_one = || vec![MapRole::of_name(path)];
    let channels = PackedMap::of_name(path).map_or_else(of_one, |packed| packed.channels().to_vec());
    let same = |role| if role == MapRole::Smoothness { MapRole::Roughness } else { role };
    channels.into_iter().filter(|role| *role != MapRole::Other).map(same).collect()
}

/// Single maps before packed ones, +Y normals before -Y ones, EXR before others.
fn rank(path: &Path) -> (bool, bool, bool, PathBuf) {
    let is_packed = MapRole::of_name(path) == MapRole::Packed;
    let is_down = NormalY::of_name(path) == Some(NormalY::Down);
    (is_packed, is_down, extension(path) != "exr", path.to_owned())
}

fn name(path: &Path) -> String {
    path.file_name().map(|name| name.to_string_lossy().into_owned()).unwrap_or_default()
}

/// Whether a file's extension is that of a picture.
pub fn is_picture(path: &Path) -> bool {
    EXTENSIONS.contains(&extension(path).as_str())
}

/// Whether a file's extension is that of a picture which is not read.
pub fn is_unread_picture(path: &Path) -> bool {
    UNREAD.contains(&extension(path).as_str())
}

/// The extension of a file in lower case.
pub fn extension(path: &Path) -> String {
    path.extension().map(|e| e.to_string_lossy().to_ascii_lowercase()).unwrap_or_default()
}

/// The files in a folder, in order of their names; hidden ones and folders have no part.
///
/// # Errors
/// A folder that cannot be read.
pub fn files(folder: &Path) -> Result<Vec<PathBuf>> {
    let unreadable = |e: &std::io::Error| Error::io("cannot read the folder", e).at(folder);
    let mut paths = Vec::new();
    for entry in fs::read_dir(folder).map_err(|e| unreadable(&e))? {
        paths.push(entry.map_err(|e| unreadable(&e))?.path());
    }
    let is_hidden = |path: &Path| path.file_name().is_some_and(|n| n.to_string_lossy().starts_with('.'));
    paths.retain(|path| !is_hidden(path) && !path.is_dir());
    paths.sort();
    Ok(paths)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn among(names: &[&str]) -> Result<MapFolder> {
        MapFolder::among(Path::new("wall"), names.iter().map(PathBuf::from).collect())
    }

    #[test]
    fn two_maps_that_are_named_the_same_are_said() {
        let twice = |names: &[&str]| among(names).unwrap().twice();
        let said = twice(&["a_Color.png", "a_Normal_Roughness.png", "a_Roughness.png"]);
        assert!(said.len() == 1 && said[0].contains("both named roughness"), "{said:?}");
        assert_eq!(twice(&["a_Color.png", "a_NormalGL.png", "a_NormalDX.png", "a_Rough.png"]), [""; 0]);
    }

    #[test]
    fn sets_of_every_library_are_known_by_their_names() {
        let sets: [(&[&str], usize); 5] = [
            (
                &[
                    "A_1K-PNG_Color.png",
                    "A_1K-PNG_NormalGL.png",
                    "A_1K-PNG_Roughness.png",
                    "A_1K-PNG_Opacity.png",
                ],
                3,
            ),
            (&["wall_diff_1k.png", "wall_nor_gl_1k.exr", "wall_rough_1k.png", "wall_ao_1k.png"], 3),
            (&["T_Wall_BC.png", "T_Wall_N.png", "T_Wall_ORM.png", "T_Wall_H.png"], 3),
            (&["Wall_BaseColor.png", "Wall_MaskMap.png", "Wall_Normal.png"], 2),
            (&["Wall_albedo.png", "Wall_orm.png", "Wall_normal.png", "Wall_height.png"], 3),
        ];
        for (names, compared) in sets {
            let set = among(names).unwrap();
            assert_eq!(set.color, Path::new(names[0]));
            assert_eq!((set.compared.len(), set.followed.len()), (compared, 0), "{names:?}");
            assert_eq!(set.unknown, Vec::<PathBuf>::new());
        }
    }

    #[test]
    fn what_is_said_twice_has_one_say_and_unknown_files_are_named() {
        let names = [
            "w_diff_1k.png",
            "w_nor_dx_1k.png",
            "w_nor_gl_1k.png",
            "w_rough_1k.png",
            "w_metal_1k.png",
            "w_ao_1k.png",
            "w_arm_1k.png",
            "w.blend",
            "w_preview.png",
            "maps.json",
        ];
        let set = among(&names).unwrap();
        assert_eq!(set.followed, ["w_arm_1k.png", "w_nor_dx_1k.png"].map(PathBuf::from));
        assert_eq!(set.unknown, ["w.blend", "w_preview.png"].map(PathBuf::from));
        let report = set.describe(Report::new("o", json!({})));
        let [unknown, others] = &report.warnings[..] else { panic!("{:?}", report.warnings) };
        assert!(unknown.contains("w_preview.png (--apply"), "{unknown}");
        assert!(others.contains("no pictures") && others.ends_with("w.blend"), "{others}");
        assert!(
            report.text.contains("w_arm_1k.png: occlusion, roughness, metallic packed"),
            "{}",
            report.text
        );
    }

    #[test]
    fn folders_without_one_colour_map_are_refused() {
        for (names, word) in
            [(&["a_normal.png"][..], "no colour map"), (&["a_diff.png", "b_col.png"], "both")]
        {
            let message = among(names).unwrap_err().to_string();
            assert!(message.contains(word), "{message}");
        }
    }
}
