//! Photographs of a texture under pairs of light and view, identified by the angles in their names: the sets of
//! UBO2003, ATRIUM, UTIA and the spectral one of Bonn, as folders or archives.

mod angles;

use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};

use super::finder::{is_hidden, list, listing};
use crate::direction::{Direction, Directions};
use crate::error::{Error, Result};
use crate::words::counted;
use angles::PairAngles;

/// Folders below the one opened that are searched for photographs.
const DEEPEST: usize = 6;

/// The most folders in which a photograph is searched to tell what a folder holds.
const MOST_FOLDERS: usize = 1000;

/// A photograph and its directions.
#[derive(Debug, Clone, PartialEq)]
pub struct PairEntry {
    /// The number of its name in the list that was given; `None` of a pair without a photograph.
    pub index: Option<usize>,
    /// The name, without folders.
    pub name: String,
    /// Towards light and viewer.
    pub directions: Directions,
}

/// The photographs of a texture of light and view, ordered by the polar angle and azimuth of the view, then of
/// the light.
#[derive(Debug, Clone, PartialEq)]
pub struct PairList {
    /// Each photograph.
    pub entries: Vec<PairEntry>,
    /// Distinct directions of light.
    pub lights: usize,
    /// Distinct directions of view.
    pub views: usize,
    /// The first pairs of a light and a view that have no photograph, and the number of all of them. None for
    /// sets that are no grid: fewer than half of the pairs exist.
    pub missing: Vec<String>,
    /// How many pairs are missing.
    pub missing_count: usize,
    /// Pictures whose names do not hold the four angles, and which are left out.
    pub unnamed: Vec<String>,
}

impl PairList {
    /// The photographs among the paths of a folder or archive, with `/` between folders; others are left out.
    /// `None` where no name has the four angles.
    ///
    /// # Errors
    /// Angles that are not those of a hemisphere, and two photographs of one pair.
    pub fn of_paths<'a>(paths: impl IntoIterator<Item = &'a str>) -> Result<Option<Self>> {
        let mut found: BTreeMap<PairAngles, PairEntry> = BTreeMap::new();
        let mut unnamed = Vec::new();
        for (index, path) in paths.into_iter().enumerate() {
            let name = path.rsplit(['/', '\\']).next().unwrap_or(path);
            if name.starts_with('.') {
                continue;
            }
            let Some(angles) = PairAngles::of_name(name) else {
                unnamed.extend((angles::is_picture(name) && !is_truth(path)).then(|| name.to_owned()));
                continue;
            };
            let directions = angles.directions().map_err(|e| Error::invalid(format!("{name}: {e}")))?;
            let entry = PairEntry { index: Some(index), name: name.to_owned(), directions };
            if let Some(other) = found.insert(angles, entry) {
                return Err(Error::invalid(format!(
                    "{} and {name} have the same directions: a pair of light and view has one photograph",
                    other.name
                )));
            }
        }
        if found.is_empty() {
            return Ok(None);
        }
        let lights: BTreeSet<_> = found.keys().map(PairAngles::light).collect();
        let views: BTreeSet<_> = found.keys().map(PairAngles::view).collect();
        let (missing, missing_count) = missing(&found, &lights, &views);
        let (lights, views) = (lights.len(), views.len());
        let entries = found.into_values().collect();
        Ok(Some(Self { entries, lights, views, missing, missing_count, unnamed }))
    }

    /// The list of pairs that have no names of their own; each is named by its angles.
    pub fn of_directions(pairs: &[Directions]) -> Self {
        let angles: Vec<PairAngles> = pairs.iter().map(|pair| PairAngles::of_directions(*pair)).collect();
        let entry = |(index, (pair, angles)): (usize, (&Directions, &PairAngles))| PairEntry {
            index: Some(index),
            name: angles.to_string(),
            directions: *pair,
        };
        Self {
            entries: pairs.iter().zip(&angles).enumerate().map(entry).collect(),
            lights: angles.iter().map(PairAngles::light).collect::<BTreeSet<_>>().len(),
            views: angles.iter().map(PairAngles::view).collect::<BTreeSet<_>>().len(),
            missing: Vec::new(),
            missing_count: 0,
            unnamed: Vec::new(),
        }
    }

    /// What is to be said of pictures that are left out.
    pub fn left_out(&self) -> Option<String> {
        let (first, count) = (self.unnamed.first()?, self.unnamed.len());
        Some(match count {
            1 => format!("the picture {first} has no angles of light and view in its name, and is left out"),
            _ => format!(
                "{count} pictures have no angles of light and view in their names, and are left out: {}",
                first_names(&self.unnamed)
            ),
        })
    }

    /// With the missing pairs of a grid among the others, in their order; they are named by their angles.
    #[must_use]
    pub fn filled(self) -> Self {
        if self.missing_count == 0 {
            return self;
        }
        let of = |direction: fn(&Directions) -> Direction| -> BTreeMap<(i64, i64), Direction> {
            let key = |directions: &Directions| {
                PairAngles::of_directions(Directions::from(direction(directions))).light()
            };
            self.entries.iter().map(|e| (key(&e.directions), direction(&e.directions))).collect()
        };
        let (lights, views) = (of(|pair| pair.light), of(|pair| pair.view));
        let absent = |light: Direction, view: Direction| {
            let directions = Directions { light, view };
            let name = PairAngles::of_directions(directions).to_string();
            PairEntry { index: None, name, directions }
        };
        let all = views.values().flat_map(|view| lights.values().map(|light| absent(*light, *view)));
        let mut found: BTreeMap<PairAngles, PairEntry> =
            all.map(|entry| (PairAngles::of_directions(entry.directions), entry)).collect();
        found.extend(self.entries.into_iter().map(|e| (PairAngles::of_directions(e.directions), e)));
        let (entries, missing) = (found.into_values().collect(), Vec::new());
        Self { entries, missing, missing_count: 0, ..self }
    }

    /// What is to be said of photographs that are missing from a grid: how many.
    pub fn absent(&self) -> Option<String> {
        let of = format!("of the {} photographs of a full grid", self.lights * self.views);
        match self.missing_count {
            0 => None,
            1 => Some(format!("1 {of} is missing")),
            count => Some(format!("{count} {of} are missing")),
        }
    }

    /// Refuses pairs that are not every light with every view.
    ///
    /// # Errors
    /// When they are not; `what` needs them.
    pub fn check_grid(&self, what: &str) -> Result<()> {
        if self.lights * self.views == self.entries.len() + self.missing_count {
            return Ok(());
        }
        Err(Error::usage(format!(
            "{} of {} and {} are not every light with every view, which {what} needs: `relume fit` learns functions of any \
             pairs, in an .exr",
            counted(self.entries.len(), "pair"),
            counted(self.lights, "light"),
            counted(self.views, "view")
        )))
    }

    /// Refuses a grid of lights and views in which photographs are missing.
    ///
    /// # Errors
    /// When any is.
    pub fn check_complete(&self) -> Result<()> {
        if self.missing_count == 0 {
            return Ok(());
        }
        Err(Error::invalid(format!(
            "{} of the {} photographs of {} and {} are missing ({}){}: add them, or let `relume fit SET -o TEXTURE.exr --missing \
             fill` interpolate them from the others",
            self.missing_count,
            self.views * self.lights,
            counted(self.views, "view"),
            counted(self.lights, "light"),
            match self.missing_count - self.missing.len() {
                0 => self.missing.join(", "),
                more => format!("{} and {more} more", self.missing.join(", ")),
            },
            self.left_out().map_or(String::new(), |left_out| format!("; {left_out}")),
        )))
    }
}

/// The first missing pairs of a grid, and their number.
fn missing(
    found: &BTreeMap<PairAngles, PairEntry>,
    lights: &BTreeSet<(i64, i64)>,
    views: &BTreeSet<(i64, i64)>,
) -> (Vec<String>, usize) {
    let count = lights.len() * views.len() - found.len();
    // Where each light and each view occurs once, there is no grid either, however few.
    let are_single = found.len() > 1 && found.len() == lights.len() && found.len() == views.len();
    if are_single || 2 * count > lights.len() * views.len() {
        return (Vec::new(), 0);
    }
    let all = views.iter().flat_map(|view| lights.iter().map(|light| PairAngles::new(*light, *view)));
    let absent = all.filter(|angles| !found.contains_key(angles)).take(3);
    (absent.map(|angles| angles.to_string()).collect(), count)
}

/// Whether a picture is part of the truth that a virtual measurement writes beside its images.
fn is_truth(path: &str) -> bool {
    path.rsplit(['/', '\\']).nth(1) == Some("truth")
}

/// The paths of all files in a folder and the folders below it, with `/` between folders, relative to it.
///
/// # Errors
/// Folders that cannot be listed.
pub fn files_below(folder: &Path) -> Result<Vec<(String, PathBuf)>> {
    let mut files = Vec::new();
    gather(folder, "", DEEPEST, &mut files)?;
    Ok(files)
}

/// Whether a folder, without a light file in itself, holds a photograph with the four angles in its name. The search
/// ends at the first one, or after a thousand folders.
pub fn is_set(folder: &Path) -> bool {
    let is_light_file = |path: &Path| path.extension().is_some_and(|e| e.eq_ignore_ascii_case("lp"));
    let Ok(names) = list(folder) else { return false };
    if names.iter().any(|name| is_light_file(Path::new(name)) && !is_hidden(name)) {
        return false;
    }
    let mut waiting = vec![(folder.to_path_buf(), DEEPEST)];
    for _ in 0..MOST_FOLDERS {
        let Some((folder, depth)) = waiting.pop() else { return false };
        for name in list(&folder).unwrap_or_default().into_iter().filter(|name| !is_hidden(name)) {
            let path = folder.join(&name);
            match path.is_dir() {
                true if depth > 0 => waiting.push((path, depth - 1)),
                true => {}
                false if PairAngles::of_name(&name.to_string_lossy()).is_some() => return true,
                false => {}
            }
        }
    }
    false
}

fn gather(folder: &Path, prefix: &str, depth: usize, files: &mut Vec<(String, PathBuf)>) -> Result<()> {
    for name in list(folder)?.into_iter().filter(|name| !is_hidden(name)) {
        let (path, text) = (folder.join(&name), format!("{prefix}{}", name.to_string_lossy()));
        if path.is_dir() {
            if depth > 0 {
                gather(&path, &format!("{text}/"), depth - 1, files)?;
            }
        } else {
            files.push((text, path));
        }
    }
    Ok(())
}

/// What a folder or archive without angles in its names holds, for a message.
pub fn first_names(names: &[String]) -> String {
    listing(names)
}

#[cfg(test)]
mod tests;
