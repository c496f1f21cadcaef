//! The maps of a folder for other programs: single maps, and channels of packed ones where there is no single map.

use std::path::{Path, PathBuf};

use relume::format::{MapRole, PackedMap};
use relume::workflow::map_export::MaterialMaps;
use relume::{Job, Named, Planes, Result, Size};

use crate::map_folder::{files, is_picture, is_unread_picture};
use crate::paths;
use crate::verb::capture::maps::{HeightSource, MapFiles, NamedBy, ReadMaps, Reading, only, remark_data};

/// Roles that have no place among the maps of a material.
const WITHOUT_PLACE: [MapRole; 3] = [MapRole::Other, MapRole::Emission, MapRole::Specular];

/// The maps of a folder.
pub struct KnownMaps {
    pub maps: MaterialMaps,
    /// The side of a texel, where the heights have it.
    pub mm_per_texel: Option<f64>,
    /// Whether there is a map of heights.
    pub has_heights: bool,
    /// What was taken from where and left out.
    pub said: Vec<String>,
}

/// Reads the maps of a folder, of a size that `foresee` takes.
pub fn read(
    folder: &Path,
    reading: &Reading,
    foresee: &dyn Fn(Size) -> Result<()>,
    job: &Job,
) -> Result<KnownMaps> {
    let border = reading.border.unwrap_or_default();
    let read = MapFiles::find(folder, NamedBy::Names)?.read(reading, foresee, job)?;
    let ReadMaps { mut maps, opacity: of_colors, heights, mm_per_texel } = read;
    let has_heights = heights != HeightSource::Normals;
    let all = files(folder)?;
    let pictures: Vec<PathBuf> = all.iter().filter(|path| is_picture(path)).cloned().collect();
    let known = |role| known(&pictures, role, job);
    if maps.roughness.is_none() {
        maps.roughness = match known(MapRole::Roughness)? {
            Some(roughness) => Some(roughness),
            None => known(MapRole::Smoothness)?.map(inverted),
        };
    }
    if maps.metallic.is_none() {
        maps.metallic = known(MapRole::Metallic)?;
    }
    let (occlusion, opacity) = (known(MapRole::Occlusion)?, known(MapRole::Opacity)?.or(of_colors));
    let said = [
        of_heights(heights, maps.height.size().width),
        opacity.as_ref().and_then(of_opacity),
        left_out(&pictures),
        unread(&all),
    ];
    let maps = MaterialMaps::of_known(maps, occlusion, opacity, border, job)?;
    Ok(KnownMaps { maps, mm_per_texel, has_heights, said: said.into_iter().flatten().collect() })
}

/// What is said of heights whose scale is not recorded.
fn of_heights(source: HeightSource, width: usize) -> Option<String> {
    match source {
        HeightSource::Known => None,
        HeightSource::Guessed => Some(format!(
            "nothing records how high the heights are: a 25th of the width, {:.1} texels, is assumed; --height-scale says it",
            width as f64 / 25.0
        )),
        HeightSource::Overridden => {
            Some("the height map holds its heights: --height-scale took the place of them".to_owned())
        }
        HeightSource::Normals => {
            Some("there is no height map: the heights are those of the normals".to_owned())
        }
    }
}

fn of_opacity(opacity: &Planes) -> Option<String> {
    let is_clear = opacity.as_slice().iter().all(|share| *share <= 0.0);
    is_clear.then(|| "the opacity is 0 everywhere: nothing of the material will be seen".to_owned())
}

fn left_out(pictures: &[PathBuf]) -> Option<String> {
    let is_left_out = |path: &&PathBuf| WITHOUT_PLACE.contains(&MapRole::of_name(path));
    listed(pictures.iter().filter(is_left_out)).map(|names| format!("not used, by their names: {names}"))
}

fn unread(files: &[PathBuf]) -> Option<String> {
    listed(files.iter().filter(|path| is_unread_picture(path)))
        .map(|names| format!("not read, by their formats: {names}; export them as PNG, TIFF or EXR"))
}

/// The names of files, if there are any.
fn listed<'a>(files: impl Iterator<Item = &'a PathBuf>) -> Option<String> {
    let names: Vec<String> = files.filter_map(|path| path.file_name()).map(paths::text).collect();
    (!names.is_empty()).then(|| names.join(", "))
}

/// The plane of a role: of the map of it, or a channel of a packed map.
fn known(pictures: &[PathBuf], role: MapRole, job: &Job) -> Result<Option<Planes>> {
    let single = only(pictures, role, NamedBy::Names)?.map(|path| (path, 0));
    let packed = || {
        pictures.iter().find_map(|path| {
            let channels = PackedMap::of_name(path).filter(|_| MapRole::of_name(path) == MapRole::Packed)?;
            Some((path.clone(), channels.channels().iter().position(|channel| *channel == role)?))
        })
    };
    let is_single = single.is_some();
    let Some((path, channel)) = single.or_else(packed) else { return Ok(None) };
    let file = crate::input::registered(&path, job)?;
    let planes = file.field.coefficients();
    // The fourth channel is the alpha of a file, and so is a map of the opacity that has one of its own.
    let is_opacity = is_single && role == MapRole::Opacity;
    let is_alpha = |alpha: &&Planes| channel == 3 || (is_opacity && !alpha.is_constant());
    let from = match file.opacity.as_ref().filter(is_alpha) {
        Some(alpha) => alpha.plane(0),
        None if channel == 3 && planes.count() == 3 => {
            job.about(&path).remark(format!("has no alpha, which would be the {}", role.name()));
            return Ok(None);
        }
        None => planes.plane(channel.min(planes.count() - 1)),
    };
    let plane = Planes::from_vec(planes.size(), 1, from.to_vec())?;
    remark_data(if is_single && channel == 0 { planes } else { &plane }, &job.about(&path));
    Ok(Some(plane))
}

fn inverted(mut smoothness: Planes) -> Planes {
    smoothness.as_mut_slice().iter_mut().for_each(|v| *v = 1.0 - *v);
    smoothness
}
