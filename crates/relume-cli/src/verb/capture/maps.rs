//! Maps from files: the role of each file, and the meaning of its samples.
//!
//! Height, normal, roughness and metallic files hold data, not colours: integer codes are read as values from 0 to 1,
//! without decoding sRGB. If such a file is RGB, all but normals use its first channel.

use std::path::{Path, PathBuf};

use relume::capture::dome::ReliefBorder;
use relume::format::{HeightMap, MapRole, NormalY};
use relume::maps::SurfaceMaps;
use relume::workflow::map_export::heights_of_normals;
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
    /// What messages advise.
    pub named_by: NamedBy,
    /// The folder in which they were looked for.
    pub folder: Option<PathBuf>,
}

/// How a verb is told which file is which map.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub enum NamedBy {
    /// By options such as `--height`, or by names.
    #[default]
    Options,
    /// By the words in the names of the files alone.
    Names,
}

/// How maps are read.
#[derive(Debug, Clone, Copy, Default)]
pub struct Reading {
    /// Texels from the lowest to the highest code of heights, whatever is recorded.
    pub height_scale: Option<f64>,
    /// The direction of y of the normals, where no name or record says it.
    pub normal_y: Option<NormalY>,
    /// What lies beyond the borders, where heights that are missing are those of the normals.
    pub border: Option<ReliefBorder>,
}

/// Maps and what is known beside them.
#[derive(Debug)]
pub struct ReadMaps {
    /// The maps; heights are in texels.
    pub maps: SurfaceMaps,
    /// The opacity in the file of the colours.
    pub opacity: Option<Planes>,
    /// Where the heights come from.
    pub heights: HeightSource,
    /// The side of a texel, where the heights have it.
    pub mm_per_texel: Option<f64>,
}

/// Where heights come from.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum HeightSource {
    /// A map with its scale.
    Known,
    /// A map of which nothing says how high its highest code is.
    Guessed,
    /// A map whose recorded scale gave way to another.
    Overridden,
    /// The normals.
    Normals,
}

impl HeightSource {
    fn of(map: &HeightMap, reading: &Reading) -> Self {
        match (&map.scale, reading.height_scale) {
            (None, None) => Self::Guessed,
            (Some(_), Some(_)) => Self::Overridden,
            _ => Self::Known,
        }
    }
}

impl MapFiles {
    /// The maps in a folder, recognised by words in their names.
    ///
    /// # Errors
    /// A folder that cannot be read, or two files that both match one map.
    pub fn find(folder: &Path, named_by: NamedBy) -> Result<Self> {
        if !folder.is_dir() {
            return Err(Error::usage(
                "is neither a built-in material (sponge, weave, pebbles, leather, bark, marble, wood, clouds, fire) nor a folder of maps",
            )
            .at(folder));
        }
        let paths = pictures(folder)?;
        Ok(Self {
            height: only(&paths, MapRole::Height, named_by)?,
            albedo: only(&paths, MapRole::Albedo, named_by)?,
            normal: only(&paths, MapRole::Normal, named_by)?,
            roughness: only(&paths, MapRole::Roughness, named_by)?,
            metallic: only(&paths, MapRole::Metallic, named_by)?,
            named_by,
            folder: Some(folder.to_owned()),
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
            named_by: self.named_by,
            folder: self.folder.or(others.folder),
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

    /// Reads the maps; heights become texels. `foresee` refuses sizes of which no use can be made, once one is known.
    ///
    /// # Errors
    /// No height or albedo, a file that cannot be read, maps of differing sizes, and those of `foresee`.
    pub fn read(
        &self,
        reading: &Reading,
        foresee: &dyn Fn(Size) -> Result<()>,
        job: &Job,
    ) -> Result<ReadMaps> {
        check_scale(reading.height_scale)?;
        if self.height.is_none() && (self.normal.is_none() || reading.border.is_none()) {
            self.wanted(&self.height, "height")?;
        }
        let albedo_file = self.wanted(&self.albedo, "albedo")?;
        let height_map = self.height.as_deref().map(|path| input::height(path, job)).transpose()?;
        if let Some(map) = &height_map {
            let size = map.samples.size();
            job.check("the maps", size, self.bytes_per_texel() + READING)?;
            // The heights are held.
            let others = (self.bytes_per_texel() - 4) * size.texels() as u64;
            let _others = job.hold("the maps", others)?;
            foresee(size)?;
        }
        let raster = input::translucent(albedo_file, job)?;
        let (first, size) = match (&self.height, &height_map) {
            (Some(path), Some(map)) => (path.as_path(), map.samples.size()),
            _ => (albedo_file, raster.size()),
        };
        let check = |found: Size, path: &Path| match found == size {
            true => Ok(()),
            false => Err(Error::invalid(format!(
                "is {found} texels, but {} is {size}: all maps must have the same size",
                first.display(),
            ))
            .at(path)),
        };
        check(raster.size(), albedo_file)?;
        let (albedo, opacity) = (albedo(&raster, job)?, raster.opacity_plane());
        drop(raster);
        let normal = self.normal.as_deref().map(|path| {
            let map = input::normals(path, reading.normal_y, job)?;
            check(map.normals.size(), path).map(|()| map.normals)
        });
        let normal = normal.transpose()?;
        let share = |path: &Option<PathBuf>| -> Result<Option<Planes>> {
            let Some(path) = path.as_deref() else { return Ok(None) };
            let plane = data_plane(path, job)?;
            check(plane.size(), path).map(|()| Some(plane))
        };
        let (roughness, metallic) = (share(&self.roughness)?, share(&self.metallic)?);
        let mm_per_texel = height_map.as_ref().and_then(|map| map.scale?.mm_per_texel);
        let (height, heights) = match (&height_map, &normal, reading.border) {
            (Some(map), _, _) => (height(map, reading.height_scale, job)?, HeightSource::of(map, reading)),
            (None, Some(normals), Some(border)) => {
                (heights_of_normals(normals, border, job)?, HeightSource::Normals)
            }
            _ => unreachable!("heights or normals were asked for above"),
        };
        let maps = SurfaceMaps { height, albedo, normal, roughness, metallic };
        Ok(ReadMaps { maps, opacity, heights, mm_per_texel })
    }

    /// What all maps take.
    fn bytes_per_texel(&self) -> u64 {
        let planes = [
            (&self.height, 1),
            (&self.albedo, 3),
            (&self.normal, 3),
            (&self.roughness, 1),
            (&self.metallic, 1),
        ];
        let kept = planes.iter().filter(|(file, _)| file.is_some()).map(|(_, count)| 4 * count);
        kept.sum()
    }

    /// The file of a map that must be there.
    fn wanted<'a>(&self, file: &'a Option<PathBuf>, name: &str) -> Result<&'a Path> {
        file.as_deref().ok_or_else(|| {
            let error = Error::usage(match self.named_by {
                NamedBy::Options => {
                    format!("no {name} map: name a file with --{name}, or put the word into a file's name")
                }
                NamedBy::Names => {
                    let normals = if name == "height" {
                        " (or the word normal, for heights of the normals)"
                    } else {
                        ""
                    };
                    format!("no {name} map: put the word {name} into a file's name{normals}")
                }
            });
            match &self.folder {
                Some(folder) => error.at(folder),
                None => error,
            }
        })
    }
}

/// The bytes of a texel of a picture of colours while it is read.
const READING: u64 = 24;

/// The most texels between the lowest and the highest code.
const HIGHEST_SCALE: f64 = 65536.0;

fn check_scale(height_scale: Option<f64>) -> Result<()> {
    match height_scale.filter(|scale| *scale == 0.0 || !(-HIGHEST_SCALE..=HIGHEST_SCALE).contains(scale)) {
        None => Ok(()),
        Some(scale) => Err(Error::usage(format!(
            "--height-scale {scale}: expected a finite number of texels other than 0, at most {HIGHEST_SCALE} in size"
        ))),
    }
}

/// The pictures in a folder, in order of their names.
fn pictures(folder: &Path) -> Result<Vec<PathBuf>> {
    let mut paths = files(folder)?;
    paths.retain(|path| is_picture(path));
    Ok(paths)
}

/// The only file whose name says the role; +Y normals before -Y ones, EXR before others.
///
/// # Errors
/// Two files that both match.
pub fn only(paths: &[PathBuf], role: MapRole, named_by: NamedBy) -> Result<Option<PathBuf>> {
    let name = role.name();
    let rank = |path: &PathBuf| (NormalY::of_name(path) == Some(NormalY::Down), extension(path) != "exr");
    let mut found: Vec<&PathBuf> = paths.iter().filter(|path| MapRole::of_name(path) == role).collect();
    found.sort_by_key(|path| rank(path));
    match found.as_slice() {
        [first, second, ..] if rank(first) == rank(second) => {
            let advice = match named_by {
                NamedBy::Options => format!("name one with --{name}"),
                NamedBy::Names => "leave one of them in the folder".to_owned(),
            };
            Err(Error::usage(format!(
                "both this file and {} look like the {name} map: {advice}",
                second.display()
            ))
            .at(first))
        }
        _ => Ok(found.first().map(|path| (*path).clone())),
    }
}

/// The first channel of a map of data as stored, with the largest code at 1.
fn data_plane(path: &Path, job: &Job) -> Result<Planes> {
    let raster = input::data(path, job)?;
    let planes = raster.to_planes(raster.samples().space(), job)?;
    remark_data(&planes, &job.about(path));
    Ok(planes.truncated(1))
}

/// Says of a map of data, of which the first channel is taken from 0 to 1, what is lost.
pub fn remark_data(planes: &Planes, job: &Job) {
    /// Differences that JPEG makes of grey pictures are smaller.
    const COLORED: f32 = 0.03;
    let first = planes.plane(0);
    let differs = |k: usize| first.iter().zip(planes.plane(k)).any(|(a, b)| (a - b).abs() > COLORED);
    if (1..planes.count().min(3)).any(differs) {
        job.remark("its channels differ, and one value is needed: red is taken".to_owned());
    }
    let beyond = first.iter().filter(|v| !(0.0..=1.0).contains(*v)).count();
    if beyond > 0 {
        let percent = 100.0 * beyond as f64 / first.len() as f64;
        job.remark(format!("{percent:.1} % of its values are not from 0 to 1, and are limited to that"));
    }
}

fn height(map: &HeightMap, scale: Option<f64>, job: &Job) -> Result<Planes> {
    const WHAT: &str = "the heights";
    job.check(WHAT, map.samples.size(), 8)?;
    let heights = match scale {
        Some(texels) => HeightMap { scale: None, ..map.clone() }.texels(texels),
        None => input::texels(map),
    };
    heights.held(job, WHAT)
}

fn albedo(raster: &Raster, job: &Job) -> Result<Planes> {
    let planes = raster.to_planes(Space::Linear, job)?;
    if planes.count() == 3 {
        return Ok(planes);
    }
    let mut albedo = Planes::zeros_within(job, "the albedo map", raster.size(), 3)?;
    for (k, plane) in albedo.iter_mut().enumerate() {
        plane.copy_from_slice(planes.plane(k.min(planes.count() - 1)));
    }
    Ok(albedo)
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
        let files = MapFiles::find(folder.path(), NamedBy::Options)?;
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
        let (size, job) = (Size::new(2, 1), Job::default());
        let codes = Raster::new(size, 3, Samples::U8(vec![0, 128, 255, 51, 255, 0])).unwrap();
        let heights =
            HeightMap { samples: codes.to_planes(Space::Srgb, &job).unwrap().truncated(1), scale: None };
        assert_eq!(height(&heights, Some(10.0), &job).unwrap().as_slice(), [0.0, 2.0]);
        assert_eq!(height(&heights, None, &job).unwrap().as_slice()[1], (0.2f32 as f64 * 2.0 / 25.0) as f32);
        let scale = HeightScale { offset: -1.0, step: 20.0, mm_per_texel: None };
        let recorded = HeightMap { scale: Some(scale), ..heights };
        assert_eq!(height(&recorded, None, &job).unwrap().as_slice(), [-1.0, 3.0]);
        assert_eq!(height(&recorded, Some(10.0), &job).unwrap().as_slice(), [0.0, 2.0]);
        assert!((albedo(&codes, &job).unwrap().at(1, 0, 0) - 0.2158).abs() < 1e-4);
    }
}
