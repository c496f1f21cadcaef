//! Maps for other programs, read by decoders of others: names, packings, bit depths, and marks of colour.

use std::collections::BTreeMap;
use std::io::Cursor;

use relume::capture::dome::ReliefBorder;
use relume::procedural::{Material, MaterialOptions};
use relume::workflow::map_export::{ExportOptions, MapPreset, MaterialMaps, WrittenMap, export_maps};
use relume::{Job, Limits, Named, Planes, Size};

fn maps() -> MaterialMaps {
    let options = MaterialOptions { size: Size::new(48, 40), feature: 16.0, ..MaterialOptions::default() };
    let mut maps = Material::Pebbles.make(&options, &Job::default()).unwrap();
    let ramp = (0..48 * 40).map(|i| (i % 48) as f32 / 47.0).collect();
    maps.metallic = Some(Planes::from_vec(Size::new(48, 40), 1, ramp).unwrap());
    MaterialMaps::of_maps(maps, ReliefBorder::Wrap, &Job::default()).unwrap()
}

fn written(
    maps: &MaterialMaps,
    preset: MapPreset,
    mm: Option<f64>,
) -> (BTreeMap<String, Vec<u8>>, Vec<WrittenMap>) {
    let mut files = BTreeMap::new();
    let mut store = |name: &str, bytes: &[u8]| {
        files.insert(name.to_owned(), bytes.to_vec());
        Ok(())
    };
    let options = ExportOptions { mm_per_texel: mm, ..ExportOptions::new(preset, "Wall") };
    let list = export_maps(maps, &options, &Job::default(), &mut store).unwrap();
    (files, list)
}

/// The header of a PNG file and its samples.
fn png(bytes: &[u8]) -> (png::Info<'static>, Vec<u8>) {
    let mut reader = png::Decoder::new(Cursor::new(bytes)).read_info().unwrap();
    let mut samples = vec![0; reader.output_buffer_size().unwrap()];
    reader.next_frame(&mut samples).unwrap();
    (reader.info().clone().into_owned_info(), samples)
}

trait IntoOwned {
    fn into_owned_info(self) -> png::Info<'static>;
}

impl IntoOwned for png::Info<'_> {
    fn into_owned_info(self) -> png::Info<'static> {
        let mut info = png::Info::with_size(self.width, self.height);
        (info.bit_depth, info.color_type, info.srgb, info.source_gamma) =
            (self.bit_depth, self.color_type, self.srgb, self.source_gamma);
        info.uncompressed_latin1_text = self.uncompressed_latin1_text;
        info
    }
}

#[test]
fn every_preset_has_its_names() {
    let maps = maps();
    let expected: [(MapPreset, &[&str]); 7] = [
        (
            MapPreset::AmbientCg,
            &[
                "Wall_48px-PNG_AmbientOcclusion.png",
                "Wall_48px-PNG_Color.png",
                "Wall_48px-PNG_Displacement.png",
                "Wall_48px-PNG_Metalness.png",
                "Wall_48px-PNG_NormalDX.png",
                "Wall_48px-PNG_NormalGL.png",
                "Wall_48px-PNG_Roughness.png",
            ],
        ),
        (
            MapPreset::PolyHaven,
            &[
                "wall_ao_48px.png",
                "wall_arm_48px.png",
                "wall_diff_48px.png",
                "wall_disp_48px.png",
                "wall_metal_48px.png",
                "wall_nor_dx_48px.png",
                "wall_nor_gl_48px.png",
                "wall_rough_48px.png",
            ],
        ),
        (MapPreset::Gltf, &["Wall_baseColor.png", "Wall_normal.png", "Wall_occlusionRoughnessMetallic.png"]),
        (MapPreset::Unreal, &["T_Wall_BC.png", "T_Wall_H.png", "T_Wall_N.png", "T_Wall_ORM.png"]),
        (MapPreset::Unity, &["Wall_BaseColor.png", "Wall_Height.png", "Wall_MaskMap.png", "Wall_Normal.png"]),
        (MapPreset::Godot, &["Wall_albedo.png", "Wall_height.png", "Wall_normal.png", "Wall_orm.png"]),
        (
            MapPreset::Blender,
            &[
                "Wall_AO.png",
                "Wall_BaseColor.png",
                "Wall_Displacement.exr",
                "Wall_Metallic.png",
                "Wall_Normal_GL.png",
                "Wall_Roughness.png",
            ],
        ),
    ];
    assert_eq!(expected.len(), MapPreset::ALL.len());
    for (preset, names) in expected {
        let (files, list) = written(&maps, preset, None);
        assert_eq!(files.keys().map(String::as_str).collect::<Vec<_>>(), names);
        assert_eq!(files.len(), list.len());
    }
}

#[test]
fn packings_depths_and_marks_are_those_of_the_program() {
    let maps = maps();
    let planes: BTreeMap<&str, &Planes> = maps.planes().into_iter().collect();
    let code =
        |name: &str, texel: usize| (planes[name].plane(0)[texel].clamp(0.0, 1.0) * 255.0).round() as u8;
    let (files, _) = written(&maps, MapPreset::Unreal, None);
    let (info, samples) = png(&files["T_Wall_ORM.png"]);
    assert_eq!((info.bit_depth, info.color_type), (png::BitDepth::Eight, png::ColorType::Rgb));
    assert!(info.srgb.is_none() && info.source_gamma.is_none());
    for texel in [0, 47, 1000, 1919] {
        let expected = [code("occlusion", texel), code("roughness", texel), code("metallic", texel)];
        assert!((0..3).all(|c| samples[3 * texel + c].abs_diff(expected[c]) <= 1), "{texel}");
    }
    assert!(png(&files["T_Wall_BC.png"]).0.srgb.is_some());
    let (files, _) = written(&maps, MapPreset::Unity, None);
    let (info, samples) = png(&files["Wall_MaskMap.png"]);
    assert_eq!(info.color_type, png::ColorType::Rgba);
    for texel in [3, 700, 1500] {
        let expected =
            [code("metallic", texel), code("occlusion", texel), 255, 255 - code("roughness", texel)];
        assert!((0..4).all(|c| samples[4 * texel + c].abs_diff(expected[c]) <= 1), "{texel}");
    }
}

#[test]
fn both_normal_maps_have_16_bits_and_opposite_y_and_say_so() {
    let (files, list) = written(&maps(), MapPreset::AmbientCg, None);
    let [gl, dx] = ["GL", "DX"].map(|y| png(&files[&format!("Wall_48px-PNG_Normal{y}.png")]));
    assert_eq!((gl.0.bit_depth, dx.0.bit_depth), (png::BitDepth::Sixteen, png::BitDepth::Sixteen));
    let green =
        |samples: &[u8], texel: usize| u16::from_be_bytes([samples[6 * texel + 2], samples[6 * texel + 3]]);
    let mut varied = 0;
    for texel in 0..48 * 40 {
        let (a, b) = (green(&gl.1, texel), green(&dx.1, texel));
        assert!((u32::from(a) + u32::from(b)).abs_diff(65535) <= 1, "{a} {b}");
        varied += usize::from(a.abs_diff(b) > 1000);
    }
    assert!(varied > 100, "{varied}");
    let said = |info: &png::Info<'_>| info.uncompressed_latin1_text[0].text.clone();
    assert_eq!((said(&gl.0).as_str(), said(&dx.0).as_str()), ("up", "down"));
    let labels: Vec<_> = list.iter().filter_map(|map| map.normal_y).map(Named::name).collect();
    assert_eq!(labels, ["up", "down"]);
}

#[test]
fn heights_record_their_range_in_millimetres() {
    let (files, list) = written(&maps(), MapPreset::PolyHaven, Some(0.25));
    let (info, _) = png(&files["wall_disp_48px.png"]);
    assert_eq!((info.bit_depth, info.color_type), (png::BitDepth::Sixteen, png::ColorType::Grayscale));
    let text = &info.uncompressed_latin1_text[0].text;
    assert!(text.ends_with(" mm"), "{text}");
    let entry = list.iter().find(|map| map.unit.is_some()).unwrap();
    assert_eq!(entry.unit, Some("mm"));
    let [low, high] = entry.range.unwrap();
    let recorded: Vec<f64> = text.split(' ').take(2).map(|n| n.parse().unwrap()).collect();
    assert!((recorded[0] - low).abs() < 1e-3 && (recorded[1] - high).abs() < 1e-3 && high > low);
}

#[test]
fn occlusion_is_open_on_a_plane_and_darker_in_a_pit() {
    let size = Size::new(32, 32);
    let options = MaterialOptions { size, ..MaterialOptions::default() };
    let mut flat = Material::Sponge.make(&options, &Job::default()).unwrap();
    flat.height.as_mut_slice().fill(2.0);
    let open = MaterialMaps::of_maps(flat.clone(), ReliefBorder::Wrap, &Job::default()).unwrap();
    let occlusion = |maps: &MaterialMaps, texel: usize| {
        maps.planes().into_iter().find(|(name, _)| *name == "occlusion").unwrap().1.plane(0)[texel]
    };
    assert!((occlusion(&open, 500) - 1.0).abs() < 1e-3);
    for (i, v) in flat.height.as_mut_slice().iter_mut().enumerate() {
        let (x, y) = ((i % 32) as f32 - 16.0, (i / 32) as f32 - 16.0);
        *v = if x.hypot(y) < 4.0 { -8.0 } else { 0.0 };
    }
    let pit = MaterialMaps::of_maps(flat.clone(), ReliefBorder::Wrap, &Job::default()).unwrap();
    assert!(occlusion(&pit, 16 * 32 + 16) < 0.5, "{}", occlusion(&pit, 16 * 32 + 16));
    assert!(occlusion(&pit, 0) > 0.95);
    // One that is known is taken as it is, and costs no memory for the sky; it must fit.
    let plane = |side: usize| Some(Planes::from_vec(Size::new(side, 32), 1, vec![0.25; 32 * side]).unwrap());
    let short = Job::new(Limits { max_bytes: 8 * 1024, ..Limits::default() });
    let known = |occlusion| MaterialMaps::of_known(flat.clone(), occlusion, None, ReliefBorder::Wrap, &short);
    assert_eq!(occlusion(&known(plane(32)).unwrap(), 16 * 32 + 16), 0.25);
    assert!(known(None).unwrap_err().to_string().contains("ambient occlusion"));
    let error = known(plane(31)).unwrap_err().to_string();
    assert!(error.contains("the occlusion has 31 x 32 texels"), "{error}");
}

#[test]
fn names_that_are_no_part_of_a_file_name_are_refused() {
    for name in ["", "a/b", "..", "a b"] {
        let mut store = |_: &str, _: &[u8]| Ok(());
        let options = ExportOptions::new(MapPreset::Gltf, name);
        let error = export_maps(&maps(), &options, &Job::default(), &mut store).unwrap_err();
        assert!(error.message().contains("name of a material"), "{error}");
    }
}
