//! What the maps of a material mean, by the words in their file names.
//!
//! Textures of materials come as sets of registered pictures; nothing in a PNG says which is which, so every
//! program goes by names: `Rock_4K-PNG_NormalGL.png`, `rock_nor_dx_2k.exr`, `height.png`. A name is split into words
//! at everything that is no letter or digit; the last word that is known decides (`base_height` is a height).

use std::path::Path;

use serde::Serialize;

use crate::names::named;

/// The direction of the second channel of a normal map.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum NormalY {
    /// To the top of the picture: OpenGL, glTF, Blender, Unity, Godot.
    #[default]
    Up,
    /// To the bottom: DirectX, Unreal, 3ds Max.
    Down,
}

named!(NormalY { Up => "up", Down => "down" });

impl NormalY {
    /// The direction that a file name says (`_dx`, `normaldx`, `directx`, or `_gl` and the like); `None` without
    /// such a word.
    pub fn of_name(path: &Path) -> Option<Self> {
        words(path).into_iter().rev().find_map(|word| match word.as_str() {
            "dx" | "normaldx" | "directx" => Some(Self::Down),
            "gl" | "normalgl" | "opengl" => Some(Self::Up),
            _ => None,
        })
    }

    /// The direction in words: `+Y, OpenGL`.
    pub fn in_words(self) -> &'static str {
        match self {
            Self::Up => "+Y, OpenGL",
            Self::Down => "-Y, DirectX",
        }
    }
}

/// The meaning of a map.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum MapRole {
    /// Colour under even light.
    Albedo,
    /// Unit normals, in whichever direction of Y.
    Normal,
    /// Height above some level.
    Height,
    /// Roughness of the surface.
    Roughness,
    /// Share of bare metal.
    Metallic,
    /// Anything else: occlusion, opacity, labels, photographs, functions.
    Other,
}

named!(MapRole {
    Albedo => "albedo",
    Normal => "normal",
    Height => "height",
    Roughness => "roughness",
    Metallic => "metallic",
    Other => "other",
});

const ALBEDO: [&str; 8] = ["albedo", "color", "colour", "diffuse", "diff", "basecolor", "base", "col"];
const NORMAL: [&str; 5] = ["normal", "normals", "nor", "normalgl", "normaldx"];
const HEIGHT: [&str; 6] = ["height", "heights", "displacement", "disp", "bump", "heightmap"];
const ROUGHNESS: [&str; 2] = ["roughness", "rough"];
const METALLIC: [&str; 4] = ["metallic", "metalness", "metallness", "metal"];
/// Words that name a map of another kind, so that `metal_base_ao.png` is no albedo.
const OTHER: [&str; 9] =
    ["ao", "ambientocclusion", "occlusion", "arm", "orm", "opacity", "alpha", "mask", "emission"];

impl MapRole {
    /// The meaning that a file name says; [`MapRole::Other`] without a known word.
    pub fn of_name(path: &Path) -> Self {
        let known: [(&[&str], Self); 6] = [
            (&ALBEDO, Self::Albedo),
            (&NORMAL, Self::Normal),
            (&HEIGHT, Self::Height),
            (&ROUGHNESS, Self::Roughness),
            (&METALLIC, Self::Metallic),
            (&OTHER, Self::Other),
        ];
        let role = |word: String| {
            known.iter().find(|(words, _)| words.contains(&word.as_str())).map(|(_, role)| *role)
        };
        words(path).into_iter().rev().find_map(role).unwrap_or(Self::Other)
    }
}

/// The lower-case words of a file name without its extension.
fn words(path: &Path) -> Vec<String> {
    let stem = path.file_stem().map(|s| s.to_string_lossy().to_ascii_lowercase()).unwrap_or_default();
    stem.split(|c: char| !c.is_ascii_alphanumeric()).map(str::to_owned).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn maps_are_known_by_the_last_word_in_their_names() {
        let roles = [
            ("A1_4K-PNG_Displacement.png", MapRole::Height),
            ("A1_4K-PNG_Color.png", MapRole::Albedo),
            ("A1_NormalGL.png", MapRole::Normal),
            ("rock_nor_dx_2k.exr", MapRole::Normal),
            ("rough_rock_diff_2k.jpg", MapRole::Albedo),
            ("rock_rough_2k.jpg", MapRole::Roughness),
            ("base_height.png", MapRole::Height),
            ("Metal014_4K-PNG_Metalness.png", MapRole::Metallic),
            ("metal_base_rough.png", MapRole::Roughness),
            ("base_ao.png", MapRole::Other),
            ("colorful.png", MapRole::Other),
            ("photograph.png", MapRole::Other),
        ];
        for (name, role) in roles {
            assert_eq!(MapRole::of_name(Path::new(name)), role, "{name}");
        }
    }

    #[test]
    fn the_direction_of_y_is_in_the_name_or_unknown() {
        let of = |name: &str| NormalY::of_name(Path::new(name));
        assert_eq!(of("rock_nor_dx_2k.exr"), Some(NormalY::Down));
        assert_eq!(of("A1_NormalDX.png"), Some(NormalY::Down));
        assert_eq!(of("normals_gl.png"), Some(NormalY::Up));
        assert_eq!(of("normals.png"), None);
    }
}
