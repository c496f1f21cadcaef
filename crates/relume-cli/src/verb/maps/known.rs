//! The maps of a folder for other programs: single maps, and channels of packed ones where there is no single map.

use std::path::{Path, PathBuf};

use relume::capture::dome::ReliefBorder;
use relume::format::{MapRole, NormalY, PackedMap};
use relume::workflow::map_export::MaterialMaps;
use relume::{Job, Planes, Result};

use crate::map_folder::{files, is_picture};
use crate::verb::capture::maps::MapFiles;

/// Reads the maps of a folder.
pub fn read(
    folder: &Path,
    height_scale: Option<f64>,
    y: Option<NormalY>,
    border: ReliefBorder,
    job: &Job,
) -> Result<MaterialMaps> {
    let mut maps = MapFiles::find(folder)?.read(height_scale, y, job)?;
    let pictures: Vec<PathBuf> = files(folder)?.into_iter().filter(|path| is_picture(path)).collect();
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
    let (occlusion, opacity) = (known(MapRole::Occlusion)?, known(MapRole::Opacity)?);
    MaterialMaps::of_known(maps, occlusion, opacity, border, job)
}

/// The plane of a role: of the first map of it, or a channel of a packed map.
fn known(pictures: &[PathBuf], role: MapRole, job: &Job) -> Result<Option<Planes>> {
    let single = pictures.iter().find(|path| MapRole::of_name(path) == role).map(|path| (path, 0));
    let packed = || {
        pictures.iter().find_map(|path| {
            let channels = PackedMap::of_name(path).filter(|_| MapRole::of_name(path) == MapRole::Packed)?;
            Some((path, channels.channels().iter().position(|channel| *channel == role)?))
        })
    };
    let Some((path, channel)) = single.or_else(packed) else { return Ok(None) };
    let file = crate::input::registered(path, job)?;
    let planes = file.field.coefficients();
    // The fourth channel is the opacity of a file, if it has any.
    let from = match file.opacity.as_ref().filter(|_| channel == 3) {
        Some(opacity) => opacity.plane(0),
        None => planes.plane(channel.min(planes.count() - 1)),
    };
    Planes::from_vec(planes.size(), 1, from.to_vec()).map(Some)
}

fn inverted(mut smoothness: Planes) -> Planes {
    smoothness.as_mut_slice().iter_mut().for_each(|v| *v = 1.0 - *v);
    smoothness
}
