//! Names, packings and bit depths of each program.

use serde::Serialize;

use crate::format::ktx2::TextureFormat;
use crate::format::{HeightFormat, NormalY};
use crate::names::named;

/// The program, or the library of materials, whose names and packings are used.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum MapPreset {
    /// `Name_1K-PNG_Color.png` and so on, one map a file, both normal maps.
    AmbientCg,
    /// `name_diff_1k.png` and so on, one map a file and `arm`, both normal maps.
    PolyHaven,
    /// Base colour, occlusion with roughness and metallic, normal with +Y.
    Gltf,
    /// `T_Name_BC`, `N` with -Y, `ORM`, `H`.
    Unreal,
    /// Base colour, mask map (metallic, occlusion, detail, smoothness), normal with +Y, height.
    Unity,
    /// Albedo, ORM, normal with +Y, height.
    Godot,
    /// One map a file, normal with +Y, displacement as floats.
    Blender,
}

named!(MapPreset {
    AmbientCg => "ambientcg",
    PolyHaven => "polyhaven",
    Gltf => "gltf",
    Unreal => "unreal",
    Unity => "unity",
    Godot => "godot",
    Blender => "blender",
});

/// The contents of a file.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum MapContent {
    /// Colours, with the opacity as a fourth channel where a program expects it there.
    Color {
        /// Whether it does.
        translucent: bool,
    },
    Normal(NormalY),
    Height(HeightFormat),
    /// One plane of data alone.
    Single(DataMap),
    /// Planes of data as channels.
    Packed(&'static [DataMap]),
}

/// A plane of data.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum DataMap {
    Occlusion,
    Roughness,
    Smoothness,
    Metallic,
    /// Everything is shown of details that a program adds.
    Detail,
    Opacity,
    /// The reflectance at normal incidence, 0.5 of most materials.
    Specular,
}

/// The resolution as libraries of materials write it.
fn resolution(side: usize, thousand: char) -> String {
    if side >= 1024 { format!("{}{thousand}", (side + 512) / 1024) } else { format!("{side}px") }
}

/// The maps of a preset, by the words in their names.
fn maps_of(preset: MapPreset) -> Vec<(&'static str, MapContent)> {
    use DataMap::{Detail, Metallic, Occlusion, Opacity, Roughness, Smoothness, Specular};
    use MapContent::{Height, Normal, Packed, Single};
    const ORM: &[DataMap] = &[Occlusion, Roughness, Metallic];
    const MASK: &[DataMap] = &[Metallic, Occlusion, Detail, Smoothness];
    let (up, down, png) = (Normal(NormalY::Up), Normal(NormalY::Down), Height(HeightFormat::Png));
    let (opaque, translucent) =
        (MapContent::Color { translucent: false }, MapContent::Color { translucent: true });
    let [rough, metal, ao, opacity, spec] = [Roughness, Metallic, Occlusion, Opacity, Specular].map(Single);
    match preset {
        MapPreset::AmbientCg => vec![
            ("Color", opaque),
            ("NormalGL", up),
            ("NormalDX", down),
            ("Roughness", rough),
            ("Metalness", metal),
            ("Displacement", png),
            ("AmbientOcclusion", ao),
            ("Opacity", opacity),
            ("Specular", spec),
        ],
        MapPreset::PolyHaven => vec![
            ("diff", opaque),
            ("nor_gl", up),
            ("nor_dx", down),
            ("rough", rough),
            ("metal", metal),
            ("disp", png),
            ("ao", ao),
            ("arm", Packed(ORM)),
            ("opacity", opacity),
            ("spec", spec),
        ],
        MapPreset::Gltf => {
            vec![("baseColor", translucent), ("occlusionRoughnessMetallic", Packed(ORM)), ("normal", up)]
        }
        MapPreset::Unreal => {
            vec![("BC", translucent), ("N", down), ("ORM", Packed(ORM)), ("H", png), ("S", spec)]
        }
        MapPreset::Unity => {
            vec![("BaseColor", translucent), ("MaskMap", Packed(MASK)), ("Normal", up), ("Height", png)]
        }
        MapPreset::Godot => {
            vec![("albedo", translucent), ("orm", Packed(ORM)), ("normal", up), ("height", png)]
        }
        MapPreset::Blender => vec![
            ("BaseColor", opaque),
            ("Roughness", rough),
            ("Metallic", metal),
            ("Normal_GL", up),
            ("Displacement", Height(HeightFormat::Exr)),
            ("AO", ao),
            ("Opacity", opacity),
            ("Specular", spec),
        ],
    }
}

impl MapPreset {
    /// Whether it has a map of heights.
    pub fn has_heights(self) -> bool {
        maps_of(self).iter().any(|(_, content)| matches!(content, MapContent::Height(_)))
    }
}

/// The files of a preset.
pub(super) fn files(
    preset: MapPreset,
    name: &str,
    side: usize,
    textures: TextureFormat,
) -> Vec<(String, MapContent)> {
    let lower = name.to_ascii_lowercase();
    let file = |(word, content): (&str, MapContent)| {
        let extension = match content {
            MapContent::Height(HeightFormat::Exr) => "exr",
            MapContent::Height(HeightFormat::Png) => "png",
            _ => textures.extension(),
        };
        let stem = match preset {
            MapPreset::AmbientCg => format!(
                "{name}_{}-{}_{word}",
                resolution(side, 'K'),
                textures.extension().to_ascii_uppercase()
            ),
            MapPreset::PolyHaven => format!("{lower}_{word}_{}", resolution(side, 'k')),
            MapPreset::Unreal => format!("T_{name}_{word}"),
            _ => format!("{name}_{word}"),
        };
        (format!("{stem}.{extension}"), content)
    };
    maps_of(preset).into_iter().map(file).collect()
}

impl DataMap {
    pub(super) fn name(self) -> &'static str {
        match self {
            Self::Occlusion => "occlusion",
            Self::Roughness => "roughness",
            Self::Smoothness => "smoothness",
            Self::Metallic => "metallic",
            Self::Detail => "detail",
            Self::Opacity => "opacity",
            Self::Specular => "specular",
        }
    }
}
