//! What the maps of a material mean, by the words in their file names.
//!
//! Textures of materials come as sets of registered pictures; nothing in a PNG says which is which, so every
//! program goes by names: `Rock_4K-PNG_NormalGL.png`, `rock_nor_dx_2k.exr`, `height.png`. A name is split into words
//! at everything that is no letter or digit; the last word that is known decides (`base_height` is a height).

use std::path::Path;

use serde::Serialize;

use crate::names::{Named, named};

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
    /// The direction that a file name says (`_dx`, `normaldx`, `directx`, or `_gl` and the like, or `T_Name_N`, which is
    /// Unreal's); `None` without such a word.
    pub fn of_name(path: &Path) -> Option<Self> {
        if unreal_letters(&words(path)) == Some("n") {
            return Some(Self::Down);
        }
        words(path).into_iter().rev().find_map(|word| match word.as_str() {
            "dx" | "normaldx" | "directx" | "normaldirectx" => Some(Self::Down),
            "gl" | "ogl" | "normalgl" | "opengl" | "normalopengl" => Some(Self::Up),
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
    /// One minus the roughness.
    Smoothness,
    /// Share of bare metal.
    Metallic,
    /// Ambient light that reaches the surface.
    Occlusion,
    /// Share of the surface that is there.
    Opacity,
    /// Light of the surface's own.
    Emission,
    /// Reflectance of highlights.
    Specular,
    /// Several of these as channels of one picture: [`PackedMap`].
    Packed,
    /// Anything else: labels, photographs, functions.
    Other,
}

named!(MapRole {
    Albedo => "albedo",
    Normal => "normal",
    Height => "height",
    Roughness => "roughness",
    Smoothness => "smoothness",
    Metallic => "metallic",
    Occlusion => "occlusion",
    Opacity => "opacity",
    Emission => "emission",
    Specular => "specular",
    Packed => "packed",
    Other => "other",
});

/// The words that name each map.
const WORDS: [(MapRole, &[&str]); 11] = [
    (
        MapRole::Albedo,
        &[
            "albedo",
            "color",
            "colour",
            "diffuse",
            "diff",
            "basecolor",
            "basecolour",
            "base",
            "col",
            "albedotransparency",
        ],
    ),
    (
        MapRole::Normal,
        &["normal", "normals", "nor", "norm", "nrm", "normalgl", "normaldx", "normalopengl", "normaldirectx"],
    ),
    (MapRole::Height, &["height", "heights", "displacement", "disp", "bump", "heightmap"]),
    (MapRole::Roughness, &["roughness", "rough", "rgh"]),
    (MapRole::Smoothness, &["smoothness", "smooth", "glossiness", "gloss"]),
    (MapRole::Metallic, &["metallic", "metalness", "metallness", "metal", "met"]),
    (MapRole::Occlusion, &["ao", "ambientocclusion", "occlusion"]),
    (MapRole::Opacity, &["opacity", "alpha", "transparency", "opac"]),
    (MapRole::Emission, &["emission", "emissive"]),
    (MapRole::Specular, &["specular", "spec"]),
    (MapRole::Other, &["mask", "detail", "id", "preview", "thumbnail", "translucent", "translucency"]),
];

impl MapRole {
    /// Whether a map holds numbers from 0 to 1 that are no colours.
    pub fn is_data(self) -> bool {
        match self {
            Self::Height | Self::Roughness | Self::Smoothness | Self::Metallic => true,
            Self::Occlusion | Self::Opacity | Self::Specular | Self::Packed => true,
            Self::Albedo | Self::Normal | Self::Emission | Self::Other => false,
        }
    }

    /// The meaning that a file name says; [`MapRole::Other`] without a known word.
    pub fn of_name(path: &Path) -> Self {
        let words = words(path);
        if let Some(letters) = unreal_letters(&words) {
            return match letters {
                "bc" | "d" => Self::Albedo,
                "n" => Self::Normal,
                "h" => Self::Height,
                "r" => Self::Roughness,
                "m" => Self::Metallic,
                "s" => Self::Specular,
                _ => Self::Emission,
            };
        }
        let role = |word: &String| {
            let single =
                || WORDS.iter().find(|(_, words)| words.contains(&word.as_str())).map(|(role, _)| *role);
            PackedMap::of_word(word).map(|_| Self::Packed).or_else(single)
        };
        words.iter().rev().find_map(role).unwrap_or(Self::Other)
    }
}

/// The last word of `T_Name_N` and the like, by which programs that use Unreal call maps; such short words mean nothing
/// in other names.
fn unreal_letters(words: &[String]) -> Option<&str> {
    let (first, last) = (words.first()?, words.last()?.as_str());
    let is_known = ["bc", "d", "n", "h", "r", "m", "s", "e"].contains(&last);
    (words.len() > 2 && first == "t" && is_known).then_some(last)
}

/// Maps as the channels of one picture.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum PackedMap {
    /// Occlusion, roughness, metallic: ORM, ARM.
    Orm,
    /// Roughness, metallic, occlusion.
    Rma,
    /// Metallic, roughness, occlusion.
    Mra,
    /// Nothing, roughness, metallic: glTF.
    MetallicRoughness,
    /// Metallic, occlusion, detail, and smoothness as the opacity: Unity's mask map.
    Mask,
    /// Metallic, and smoothness as the opacity: Unity.
    MetallicSmoothness,
}

named!(PackedMap {
    Orm => "orm",
    Rma => "rma",
    Mra => "mra",
    MetallicRoughness => "metallicroughness",
    Mask => "maskmap",
    MetallicSmoothness => "metallicsmoothness",
});

impl PackedMap {
    /// The packing that a file name says.
    pub fn of_name(path: &Path) -> Option<Self> {
        words(path).iter().rev().find_map(|word| Self::of_word(word))
    }

    fn of_word(word: &str) -> Option<Self> {
        match word {
            "arm" | "occlusionroughnessmetallic" | "aoroughnessmetallic" => Some(Self::Orm),
            "mask" => None,
            word => Self::from_name(word),
        }
    }

    /// What the channels hold, red first, the opacity last.
    pub fn channels(self) -> &'static [MapRole] {
        use MapRole::{Metallic, Occlusion, Other, Roughness, Smoothness};
        match self {
            Self::Orm => &[Occlusion, Roughness, Metallic],
            Self::Rma => &[Roughness, Metallic, Occlusion],
            Self::Mra => &[Metallic, Roughness, Occlusion],
            Self::MetallicRoughness => &[Other, Roughness, Metallic],
            Self::Mask => &[Metallic, Occlusion, Other, Smoothness],
            Self::MetallicSmoothness => &[Metallic, Metallic, Metallic, Smoothness],
        }
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
            ("base_ao.png", MapRole::Occlusion),
            ("rock_arm_2k.png", MapRole::Packed),
            ("T_Wall_ORM.png", MapRole::Packed),
            ("T_Wall_BC.png", MapRole::Albedo),
            ("T_Wall_N.png", MapRole::Normal),
            ("T_Wall_H.png", MapRole::Height),
            ("T_Wall_S.png", MapRole::Specular),
            ("wall_spec_1k.png", MapRole::Specular),
            ("a_n.png", MapRole::Other),
            ("Wall_MaskMap.png", MapRole::Packed),
            ("Wall_occlusionRoughnessMetallic.png", MapRole::Packed),
            ("Wall_MetallicSmoothness.png", MapRole::Packed),
            ("Wall_Opacity.png", MapRole::Opacity),
            ("colour_mask.png", MapRole::Other),
            ("colorful.png", MapRole::Other),
            ("photograph.png", MapRole::Other),
        ];
        for (name, role) in roles {
            assert_eq!(MapRole::of_name(Path::new(name)), role, "{name}");
        }
    }

    /// Every name that `relume maps` gives is understood when the folder is read again.
    #[test]
    fn packed_maps_say_what_their_channels_hold() {
        let of = |name: &str| PackedMap::of_name(Path::new(name)).map(PackedMap::channels);
        let orm: &[MapRole] = &[MapRole::Occlusion, MapRole::Roughness, MapRole::Metallic];
        for name in
            ["T_Wall_ORM.png", "wall_arm_1k.png", "Wall_occlusionRoughnessMetallic.png", "Wall_orm.png"]
        {
            assert_eq!(of(name), Some(orm), "{name}");
        }
        let mask = [MapRole::Metallic, MapRole::Occlusion, MapRole::Other, MapRole::Smoothness];
        assert_eq!(of("Wall_MaskMap.png"), Some(&mask[..]));
        assert_eq!(of("wall_mask.png"), None);
    }

    #[test]
    fn the_direction_of_y_is_in_the_name_or_unknown() {
        let of = |name: &str| NormalY::of_name(Path::new(name));
        assert_eq!(of("rock_nor_dx_2k.exr"), Some(NormalY::Down));
        assert_eq!(of("A1_NormalDX.png"), Some(NormalY::Down));
        assert_eq!(of("normals_gl.png"), Some(NormalY::Up));
        assert_eq!(of("T_Wall_N.png"), Some(NormalY::Down));
        assert_eq!(of("normals.png"), None);
    }
}
