//! Maps from files: the role of each file, and the meaning of its samples.
//!
//! Height, normal, roughness and metallic files hold data, not colours: integer codes are read as values from 0 to 1,
//! without decoding sRGB. If such a file is RGB, all but normals use its first channel.

use std::path::{Path, PathBuf};

use relume::format::{HeightMap, MapRole, NormalY};
use relume::maps::SurfaceMaps;
use relume::{Error, Job, Named, Planes, Raster, Result, Size, Space};

use crate::input;
use crate::map_folder::{extension, files, is_picture};

/// The files of the available maps.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct MapFiles {
    /// One channel.
    pub height: Option<PathBuf>,
    /// Colours.
    pub albedo: Option<PathBuf>,
    /// Three channels.
    pub normal: Option<PathBuf>,
    /// One channel.
    pub roughness: Option<PathBuf>,
    /// One channel.
    pub metallic: Option<PathBuf>,
}

impl MapFiles {
    /// The maps in a folder, recognised by words in their names.
    ///
    /// # Errors
    /// A folder that cannot be read, or two files that both match one map.
    pub fn find(folder: &Path) -> Result<Self> {
        if !folder.is_dir() {
            return Err(Error::usage(
                "is neither a built-in material (sponge, weave, pebbles, leather, bark, marble, wood, clouds, fire) nor a folder of maps",
            )
            .at(folder));
        }
        let paths = pictures(folder)?;
        Ok(Self {
            height: only(&paths, MapRole::Height)?,
            albedo: only(&paths, MapRole::Albedo)?,
            normal: only(&paths, MapRole::Normal)?,
            roughness: only(&paths, MapRole::Roughness)?,
            metallic: only(&paths, MapRole::Metallic)?,
        })
    }

    /// The pictures in a folder that are none of these maps.
    ///
    /// # Errors
    /// A folder that cannot be read.
    pub fn unused(&self, folder: &Path) -> Result<Vec<PathBuf>> {
        let used = [&self.height, &self.albedo, &self.normal, &self.roughness, &self.metallic];
        let mut others = pictures(folder)?;
        others.retain(|path| !used.iter().any(|map| map.as_ref() == Some(path)));
        Ok(others)
    }

    /// These files, completed by the others.
    pub fn or(self, others: Self) -> Self {
        Self {
            height: self.height.or(others.height),
            albedo: self.albedo.or(others.albedo),
            normal: self.normal.or(others.normal),
            roughness: self.roughness.or(others.roughness),
            metallic: self.metallic.or(others.metallic),
        }
    }

    /// These files, where they are enough without a folder.
    ///
    /// # Errors
    /// The option that is missing.
    pub fn whole(self) -> Result<Self> {
        let missing = match (&self.height, &self.albedo) {
            (Some(_), Some(_)) => return Ok(self),
            (Some(_), None) => "an albedo map: give --albedo FILE",
            (None, Some(_)) => "a height map: give --height FILE",
            (None, None) => {
                "maps: name a built-in material or a folder of maps, or give --height and --albedo"
            }
        };
        Err(Error::usage(format!("a capture needs {missing}")))
    }

    /// Reads the maps; heights become texels.
    ///
    /// # Errors
    /// No height or albedo, a file that cannot be read, or maps of differing sizes.
    pub fn read(&self, height_scale: Option<f64>, y: Option<NormalY>, job: &Job) -> Result<SurfaceMaps> {
        if let Some(scale) = height_scale.filter(|scale| !scale.is_finite()) {
            return Err(Error::usage(format!("--height-scale {scale}: expected a finite number of texels")));
        }
        let (height_file, albedo_file) = (wanted(&self.height, "height")?, wanted(&self.albedo, "albedo")?);
        let height = height(&input::height(height_file, job)?, height_scale);
        let check = |size: Size, path: &Path| {
            if size == height.size() {
                return Ok(());
            }
            Err(Error::invalid(format!(
                "is {size} texels, but {} is {}: all maps must have the same size",
                height_file.display(),
                height.size()
            ))
            .at(path))
        };
        let same_size = |path: &Path, raster: Result<Raster>| {
            let raster = raster?;
            check(raster.size(), path)?;
            Ok(raster)
        };
        let data = |path: &Path| same_size(path, input::data(path, job));
        let albedo = albedo(&same_size(albedo_file, input::raster(albedo_file, job))?);
        let normal = match &self.normal {
            Some(path) => {
                let map = input::normals(path, y, job)?;
                check(map.normals.size(), path)?;
                Some(map.normals)
            }
            None => None,
        };
        let share = |path: &Option<PathBuf>| -> Result<Option<Planes>> {
            path.as_deref().map(|path| Ok(first_channel(&data(path)?))).transpose()
        };
        let (roughness, metallic) = (share(&self.roughness)?, share(&self.metallic)?);
        Ok(SurfaceMaps { height, albedo, normal, roughness, metallic })
    }
}

/// The pictures in a folder, in order of their names.
fn pictures(folder: &Path) -> Result<Vec<PathBuf>> {
    let mut paths = files(folder)?;
    paths.retain(|path| is_picture(path));
    Ok(paths)
}

fn wanted<'a>(file: &'a Option<PathBuf>, name: &str) -> Result<&'a Path> {
    file.as_deref().ok_or_else(|| {
        Error::usage(format!("no {name} map: name a file with --{name}, or put the word into a file's name"))
    })
}

/// The only file whose name says the role; +Y normals before -Y ones, EXR before others.
fn only(paths: &[PathBuf], role: MapRole) -> Result<Option<PathBuf>> {
    let name = role.name();
    let rank = |path: &PathBuf| (NormalY::of_name(path) == Some(NormalY::Down), extension(path) != "exr");
    let mut found: Vec<&PathBuf> = paths.iter().filter(|path| MapRole::of_name(path) == role).collect();
    found.sort_by_key(|path| rank(path));
    match found.as_slice() {
        [first, second, ..] if rank(first) == rank(second) => Err(Error::usage(format!(
            "both this file and {} look like the {name} map: name one with --{name}",
            second.display()
        ))
        .at(first)),
        _ => Ok(found.first().map(|path| (*path).clone())),
    }
}

/// The samples as stored, with the largest code at 1.
fn data(raster: &Raster) -> Planes {
    raster.to_picture(raster.samples().space()).planes
}

fn first_channel(raster: &Raster) -> Planes {
    let planes = data(raster);
    let mut first = Planes::zeros(raster.size(), 1);
    first.plane_mut(0).copy_from_slice(planes.plane(0));
    first
}

fn height(map: &HeightMap, scale: Option<f64>) -> Planes {
    match scale {
        Some(texels) => HeightMap { scale: None, ..map.clone() }.texels(texels),
        None => input::texels(map),
    }
}

fn albedo(raster: &Raster) -> Planes {
    let planes = raster.to_picture(Space::Linear).planes;
    let mut albedo = Planes::zeros(raster.size(), 3);
    for (k, plane) in albedo.iter_mut().enumerate() {
        plane.copy_from_slice(planes.plane(k.min(planes.count() - 1)));
    }
    albedo
}

#[cfg(test)]
mod tests {
    use super::*;
    use relume::Samples;
    use relume::format::HeightScale;
    use std::fs;

    fn choose(names: &[&str]) -> Result<Vec<Option<String>>> {
        let folder = tempfile::tempdir().unwrap();
        names.iter().for_each(|name| fs::write(folder.path().join(name), "").unwrap());
        let files = MapFiles::find(folder.path())?;
        let name =
            |file: Option<PathBuf>| file.map(|f| f.file_name().unwrap().to_string_lossy().into_owned());
        Ok([files.height, files.albedo, files.normal, files.roughness].map(name).to_vec())
    }

    #[test]
    fn maps_are_known_by_the_words_in_their_names() {
        let expect = |names: [&str; 4]| Ok(names.map(|n| Some(n.to_owned())).to_vec());
        let ambient =
            ["A1_4K-PNG_Displacement.png", "A1_4K-PNG_Color.png", "A1_NormalGL.png", "A1_Roughness.png"];
        let others = ["A1_NormalDX.png", "A1_AmbientOcclusion.png", "A1_Metalness.png", "notes_height.txt"];
        assert_eq!(choose(&[&ambient[..], &others[..]].concat()), expect(ambient));
        let haven = ["rock_disp_2k.png", "rock_diff_2k.jpg", "rock_nor_gl_2k.exr", "rock_rough_2k.jpg"];
        assert_eq!(choose(&haven), expect(haven));
        assert_eq!(choose(&["normals_gl.png", "normals.exr"]).unwrap()[2].as_deref(), Some("normals.exr"));
        assert_eq!(choose(&["colorful.png"]).unwrap(), [None, None, None, None]);
        let message = choose(&["height.png", "disp.png"]).unwrap_err().to_string();
        assert!(message.contains("disp.png") && message.contains("height.png"), "{message}");
    }

    #[test]
    fn samples_mean_data_in_maps_of_data_and_light_in_albedo() {
        let size = Size::new(2, 1);
        let codes = Raster::new(size, 3, Samples::U8(vec![0, 128, 255, 51, 255, 0])).unwrap();
        let heights = HeightMap { samples: first_channel(&codes), scale: None };
        assert_eq!(height(&heights, Some(10.0)).as_slice(), [0.0, 2.0]);
        assert_eq!(height(&heights, None).as_slice()[1], (0.2f32 as f64 * 2.0 / 25.0) as f32);
        let scale = HeightScale { offset: -1.0, step: 20.0, mm_per_texel: None };
        let recorded = HeightMap { scale: Some(scale), ..heights };
        assert_eq!(height(&recorded, None).as_slice(), [-1.0, 3.0]);
        assert_eq!(height(&recorded, Some(10.0)).as_slice(), [0.0, 2.0]);
        assert!((albedo(&codes).at(1, 0, 0) - 0.2158).abs() < 1e-4);
    }
}
