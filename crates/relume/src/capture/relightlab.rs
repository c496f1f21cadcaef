//! Project files (`.relight`) and dome files (`.dome`) of RelightLab: JSON with the photographs' names and the
//! directions or positions of the lamps, vectors as objects of x, y and z in the frame of this crate.
//!
//! A project names its photographs (`images` with `filename`, `direction` or `position`, and the `folder` they are in)
//! and may hold a dome. A dome has lamps only (`directions`, `positions`, `positions3d` or `positionsSphere`), which
//! belong to photographs in the order of their names. Positions are in the unit of the file (centimetres in old ones,
//! millimetres in new ones), and only their directions are used. Photographs marked `skip` are left out.

use serde_json::Value;

use super::lp::{Listed, LpEntry, raised};
use crate::direction::Direction;
use crate::error::{Error, Result};

/// The lamps of a file, with names or without.
#[derive(Debug, Clone, PartialEq)]
pub(super) enum ProjectLights {
    /// Photographs by name.
    Named(Vec<LpEntry>),
    /// Lamps in the order of the names of the photographs.
    InOrder(Vec<LpEntry>),
}

/// Reads a project or a dome.
pub(super) fn parse(bytes: &[u8]) -> Result<ProjectLights> {
    let json: Value = serde_json::from_slice(bytes).map_err(|e| {
        Error::invalid(format!("the file is not JSON ({e}): expected a project or dome of RelightLab"))
    })?;
    match json.get("images").and_then(Value::as_array) {
        Some(images) if !images.is_empty() => named(images, &json).map(ProjectLights::Named),
        _ => {
            let vectors = lamps(&json).or_else(|| lamps(json.get("dome")?)).ok_or_else(|| {
                Error::invalid(
                    "the file names neither `images` nor `directions` or `positions`: expected a project or dome of \
                     RelightLab",
                )
            })?;
            let entry = |(i, vector)| entry(String::new(), vector, i + 1);
            Ok(ProjectLights::InOrder(vectors.into_iter().enumerate().map(entry).collect::<Result<_>>()?))
        }
    }
}

/// The lamps of a project, by the names of their photographs.
fn named(images: &[Value], project: &Value) -> Result<Vec<LpEntry>> {
    let folder = project.get("folder").and_then(Value::as_str).unwrap_or_default();
    let of_dome = project.get("dome").and_then(lamps).filter(|lamps| lamps.len() == images.len());
    let mut entries = Vec::new();
    for (i, image) in images.iter().enumerate() {
        if image.get("skip").and_then(Value::as_bool).unwrap_or(false) {
            continue;
        }
        let name = image.get("filename").and_then(Value::as_str).unwrap_or_default();
        let own = ["position", "direction"].iter().find_map(|key| vector(image.get(*key)?));
        let lamp = own.filter(|v| v.iter().any(|c| *c != 0.0)).or(of_dome.as_ref().map(|lamps| lamps[i]));
        let lamp = lamp.filter(|_| !name.is_empty()).ok_or_else(|| {
            Error::invalid(format!(
                "image {} has no `filename`, or neither `direction` nor `position`",
                i + 1
            ))
        })?;
        let path = if folder.is_empty() { name.to_owned() } else { format!("{folder}/{name}") };
        entries.push(entry(path, lamp, i + 1)?);
    }
    Ok(entries)
}

fn entry(name: String, listed: [f64; 3], line: usize) -> Result<LpEntry> {
    let [x, y, z] = listed;
    let told = |e: Error| Error::invalid(format!("the lamp of image {line}: {}", e.message()));
    let light = Direction::new(x, y, z).map_err(told)?;
    let Listed { light, is_raised } = raised(light).ok_or_else(|| {
        Error::invalid(format!("the lamp of image {line} at ({x}, {y}, {z}) is not above the surface"))
    })?;
    Ok(LpEntry { raw_name: name.clone().into_bytes(), name, light, vector: listed, is_raised, line })
}

/// The lamps of a dome: its places before its directions.
fn lamps(dome: &Value) -> Option<Vec<[f64; 3]>> {
    let configuration = dome.get("lightConfiguration").and_then(Value::as_str).unwrap_or_default();
    let keys = match configuration.to_lowercase().as_str() {
        "lights3d" => ["positions3d", "positions", "directions"],
        "spherical" => ["positionsSphere", "directions", "positions"],
        _ => ["directions", "positions", "positions3d"],
    };
    keys.iter().find_map(|key| {
        let vectors = dome.get(*key)?.as_array()?.iter().map(vector).collect::<Option<Vec<_>>>()?;
        (!vectors.is_empty()).then_some(vectors)
    })
}

/// A vector as an object of x, y and z, or as a list of three.
fn vector(value: &Value) -> Option<[f64; 3]> {
    match value {
        Value::Object(_) => {
            let of = |key: &str| value.get(key).and_then(Value::as_f64);
            Some([of("x")?, of("y")?, of("z")?])
        }
        Value::Array(list) => {
            let numbers = list.iter().map(Value::as_f64).collect::<Option<Vec<f64>>>()?;
            numbers.try_into().ok()
        }
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn projects_name_photographs_and_domes_list_lamps() {
        let project = br#"{"application": "RelightLab", "folder": "jpg", "images": [
            {"filename": "a.jpg", "direction": {"x": 0, "y": 0, "z": 2}},
            {"filename": "b.jpg", "skip": true},
            {"filename": "c.jpg", "position": {"x": 30, "y": 0, "z": 40}}]}"#;
        let ProjectLights::Named(entries) = parse(project).unwrap() else { panic!("names are given") };
        let names: Vec<_> = entries.iter().map(|e| e.name.as_str()).collect();
        assert_eq!(names, ["jpg/a.jpg", "jpg/c.jpg"]);
        assert!((entries[1].light.x() - 0.6).abs() < 1e-12);
        let dome =
            br#"{"lightConfiguration": "directional", "directions": [{"x":0,"y":0.6,"z":0.8},[0,0,1]]}"#;
        let ProjectLights::InOrder(lamps) = parse(dome).unwrap() else { panic!("a dome has no names") };
        assert_eq!(lamps.len(), 2);
        assert!((lamps[0].light.y() - 0.6).abs() < 1e-12);
    }

    #[test]
    fn a_project_whose_images_have_no_lamps_takes_those_of_its_dome() {
        let project = br#"{"images": [{"filename": "a.jpg"}], "dome": {"positions3d": [[3, 0, 4]],
            "lightConfiguration": "lights3d"}}"#;
        let ProjectLights::Named(entries) = parse(project).unwrap() else { panic!("names are given") };
        assert!((entries[0].light.z() - 0.8).abs() < 1e-12);
    }

    #[test]
    fn what_is_no_project_is_refused_in_words() {
        let refused = |text: &str| parse(text.as_bytes()).unwrap_err().to_string();
        assert!(refused("3\na 0 0 1").contains("is not JSON"));
        assert!(refused("{}").contains("names neither"));
        assert!(refused(r#"{"images": [{"filename": "a.jpg"}]}"#).contains("image 1 has no"));
        assert!(refused(r#"{"directions": [[0, 0, -1]]}"#).contains("not above the surface"));
    }
}
