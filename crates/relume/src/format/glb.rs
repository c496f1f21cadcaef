//! Binary glTF 2.0 (ISO/IEC 12113:2022) of one object with one material, written.
//!
//! `docs/formats.md` specifies the extension `RELUME_reflectance`, which holds the functions of a texture.

use serde_json::{Map, Value, json};

use super::share::ShareFiles;
use crate::error::Result;
use crate::job::Job;
use crate::render::Mesh;

/// The extension of the material that holds functions of light.
pub const EXTENSION: &str = "RELUME_reflectance";

/// The kinds of numbers and the uses of buffers, by the numbers of OpenGL.
const FLOAT: u32 = 5126;
const UNSIGNED_INT: u32 = 5125;
const ARRAY_BUFFER: u32 = 34962;
const ELEMENT_ARRAY_BUFFER: u32 = 34963;
/// The opacity below which a texel of a translucent material is not there.
const CUTOFF: f64 = 0.5;

/// An object and its material.
#[derive(Debug)]
pub struct GlbPreview<'a> {
    /// The object.
    pub mesh: &'a Mesh,
    /// Repetitions of the texture along both directions.
    pub tiling: [f64; 2],
    /// Its one material.
    pub material: &'a GlbMaterial<'a>,
}

/// A material as the bytes of its pictures.
#[derive(Debug)]
pub struct GlbMaterial<'a> {
    /// For people.
    pub name: String,
    /// PNG, sRGB.
    pub base_color: Vec<u8>,
    /// Whether the base colour has opacity.
    pub is_translucent: bool,
    /// PNG, data.
    pub occlusion_roughness_metallic: Vec<u8>,
    /// PNG, data, +Y.
    pub normal: Vec<u8>,
    /// The functions of the texture.
    pub functions: Option<&'a ShareFiles>,
}

/// The binary part and what describes it.
#[derive(Debug, Default)]
struct GlbBuffer {
    bytes: Vec<u8>,
    views: Vec<Value>,
    accessors: Vec<Value>,
}

/// The file of a preview.
///
/// # Errors
/// The limits.
pub fn encode_glb(preview: &GlbPreview<'_>, job: &Job) -> Result<Vec<u8>> {
    let material = preview.material;
    let files = material.functions.map_or(0, |share| share.files.iter().map(|(_, b)| b.len()).sum());
    let pictures =
        material.base_color.len() + material.occlusion_roughness_metallic.len() + material.normal.len();
    let geometry = 64 * preview.mesh.positions().len() + 12 * preview.mesh.triangles().len();
    job.check_bytes("the preview", 2 * (files + pictures + 2 * geometry) as u64)?;
    let mut buffer = GlbBuffer::default();
    let primitive = buffer.primitive(preview);
    let images: Vec<Value> = [&material.base_color, &material.occlusion_roughness_metallic, &material.normal]
        .map(|png| json!({ "bufferView": buffer.view(png, None), "mimeType": "image/png" }))
        .into();
    let textures = [0, 1, 2].map(|image| json!({ "source": image, "sampler": 0 }));
    let described = described(material, &mut buffer);
    let mut root = json!({
        "asset": { "version": "2.0", "generator": concat!("relume ", env!("CARGO_PKG_VERSION")) },
        "scene": 0,
        "scenes": [{ "nodes": [0] }],
        "nodes": [{ "mesh": 0, "name": material.name }],
        "meshes": [{ "primitives": [primitive] }],
        "materials": [described],
        "textures": textures,
        "images": images,
        // Linear between texels and levels, repeated.
        "samplers": [{ "magFilter": 9729, "minFilter": 9987, "wrapS": 10497, "wrapT": 10497 }],
        "accessors": buffer.accessors,
        "bufferViews": buffer.views,
        "buffers": [{ "byteLength": buffer.bytes.len() }],
    });
    if material.functions.is_some() {
        root["extensionsUsed"] = json!([EXTENSION]);
    }
    Ok(container(&root, buffer.bytes))
}

fn described(material: &GlbMaterial<'_>, buffer: &mut GlbBuffer) -> Value {
    let mut described = json!({
        "name": material.name,
        "pbrMetallicRoughness": {
            "baseColorTexture": { "index": 0 },
            "metallicRoughnessTexture": { "index": 1 },
        },
        "occlusionTexture": { "index": 1 },
        "normalTexture": { "index": 2 },
    });
    if material.is_translucent {
        described["alphaMode"] = json!("MASK");
        described["alphaCutoff"] = json!(CUTOFF);
        described["doubleSided"] = json!(true);
    }
    if let Some(share) = material.functions {
        let view = |(name, bytes): &(String, Vec<u8>)| (name.clone(), json!(buffer.view(bytes, None)));
        let files: Map<String, Value> = share.files.iter().map(view).collect();
        described["extensions"] = json!({ EXTENSION: { "share": share.header, "files": files } });
    }
    described
}

impl GlbBuffer {
    /// Adds bytes at a multiple of four; returns the number of their view.
    fn view(&mut self, bytes: &[u8], target: Option<u32>) -> usize {
        self.bytes.resize(self.bytes.len().next_multiple_of(4), 0);
        let mut view = json!({ "buffer": 0, "byteOffset": self.bytes.len(), "byteLength": bytes.len() });
        if let Some(target) = target {
            view["target"] = json!(target);
        }
        self.bytes.extend(bytes);
        self.views.push(view);
        self.views.len() - 1
    }

    /// Adds vectors of floats; returns the number of their accessor.
    fn vectors<const N: usize>(&mut self, vectors: &[[f32; N]], has_bounds: bool) -> usize {
        let bytes: Vec<u8> = vectors.iter().flatten().flat_map(|v| v.to_le_bytes()).collect();
        let view = self.view(&bytes, Some(ARRAY_BUFFER));
        let kind = format!("VEC{N}");
        let mut accessor =
            json!({ "bufferView": view, "componentType": FLOAT, "count": vectors.len(), "type": kind });
        if has_bounds {
            let bound = |k: usize, of: fn(f32, f32) -> f32, from| vectors.iter().map(|v| v[k]).fold(from, of);
            accessor["min"] = (0..N).map(|k| json!(bound(k, f32::min, f32::INFINITY))).collect();
            accessor["max"] = (0..N).map(|k| json!(bound(k, f32::max, f32::NEG_INFINITY))).collect();
        }
        self.accessors.push(accessor);
        self.accessors.len() - 1
    }

    fn primitive(&mut self, preview: &GlbPreview<'_>) -> Value {
        let (mesh, tangents) = preview.mesh.with_tangents();
        let [across, down] = preview.tiling;
        // glTF has the first row of a picture at 0.
        let place =
            |[s, t]: &[f32; 2]| [(f64::from(*s) * across) as f32, ((1.0 - f64::from(*t)) * down) as f32];
        let places: Vec<[f32; 2]> = mesh.texcoords().iter().map(place).collect();
        let position = self.vectors(mesh.positions(), true);
        let normal = self.vectors(mesh.normals(), false);
        let tangent = self.vectors(&tangents, false);
        let texcoord = self.vectors(&places, false);
        let indices: Vec<u8> = mesh.triangles().iter().flatten().flat_map(|i| i.to_le_bytes()).collect();
        let view = self.view(&indices, Some(ELEMENT_ARRAY_BUFFER));
        let count = 3 * mesh.triangles().len();
        self.accessors.push(
            json!({ "bufferView": view, "componentType": UNSIGNED_INT, "count": count, "type": "SCALAR" }),
        );
        json!({
            "attributes": {
                "POSITION": position, "NORMAL": normal, "TANGENT": tangent, "TEXCOORD_0": texcoord,
            },
            "indices": self.accessors.len() - 1,
            "material": 0,
        })
    }
}

/// The header, the text padded by spaces and the buffer padded by zeros.
fn container(root: &Value, mut buffer: Vec<u8>) -> Vec<u8> {
    let mut text = root.to_string().into_bytes();
    text.resize(text.len().next_multiple_of(4), b' ');
    buffer.resize(buffer.len().next_multiple_of(4), 0);
    let length = 12 + 8 + text.len() + 8 + buffer.len();
    let mut file = b"glTF".to_vec();
    file.reserve(length);
    file.extend([2, length as u32].iter().flat_map(|word| word.to_le_bytes()));
    for (kind, chunk) in [(b"JSON", text), (b"BIN\0", buffer)] {
        file.extend((chunk.len() as u32).to_le_bytes());
        file.extend(kind);
        file.extend(chunk);
    }
    file
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::field::{Basis, PlaneLayout, ReflectanceField};
    use crate::format::share::planes::PlaneDepth;
    use crate::format::share::{ShareExtras, ShareHeader};
    use crate::format::{Depth, Encoding, FieldFile, decode_mesh};
    use crate::planes::Planes;
    use crate::render::Primitive;
    use crate::size::Size;
    use crate::space::Space;

    fn material<'a>(functions: Option<&'a ShareFiles>) -> GlbMaterial<'a> {
        GlbMaterial {
            name: "Wall".to_owned(),
            base_color: b"colours".to_vec(),
            is_translucent: false,
            occlusion_roughness_metallic: b"data".to_vec(),
            normal: b"normals!!".to_vec(),
            functions,
        }
    }

    /// The text and the binary part, as the standard reads them.
    fn parts(file: &[u8]) -> (Value, Vec<u8>) {
        let word = |at: usize| u32::from_le_bytes(file[at..at + 4].try_into().unwrap()) as usize;
        assert_eq!((&file[..4], word(4), word(8)), (&b"glTF"[..], 2, file.len()));
        let text = word(12);
        assert_eq!((&file[16..20], text % 4), (&b"JSON"[..], 0));
        let root = serde_json::from_slice(&file[20..20 + text]).unwrap();
        let at = 20 + text;
        assert_eq!((word(at) + at + 8, &file[at + 4..at + 8]), (file.len(), &b"BIN\0"[..]));
        (root, file[at + 8..].to_vec())
    }

    fn bytes_of<'a>(root: &Value, buffer: &'a [u8], view: &Value) -> &'a [u8] {
        let view = &root["bufferViews"][view.as_u64().unwrap() as usize];
        let [at, length] = ["byteOffset", "byteLength"].map(|name| view[name].as_u64().unwrap() as usize);
        assert_eq!(at % 4, 0);
        &buffer[at..at + length]
    }

    #[test]
    fn an_object_comes_back_with_its_repetitions_and_pictures() {
        for primitive in Primitive::ALL {
            let mesh = primitive.mesh();
            let preview = GlbPreview { mesh: &mesh, tiling: [3.0, 2.0], material: &material(None) };
            let file = encode_glb(&preview, &Job::default()).unwrap();
            let back = decode_mesh(&file, &Job::default()).unwrap();
            assert_eq!(back.triangles().len(), mesh.triangles().len());
            for (a, b) in back.triangles().iter().flatten().zip(mesh.triangles().iter().flatten()) {
                let (a, b) = (*a as usize, *b as usize);
                assert_eq!(back.positions()[a], mesh.positions()[b]);
                let [s, t] = mesh.texcoords()[b];
                let expected = [3.0 * s, 1.0 - 2.0 * (1.0 - t)];
                for (found, expected) in back.texcoords()[a].iter().zip(expected) {
                    assert!((found - expected).abs() < 1e-5);
                }
            }
            let (root, buffer) = parts(&file);
            let image = |k: usize| bytes_of(&root, &buffer, &root["images"][k]["bufferView"]);
            assert_eq!([image(0), image(1), image(2)], [&b"colours"[..], b"data", b"normals!!"]);
            assert_eq!(root["extensionsUsed"], Value::Null);
        }
    }

    #[test]
    fn tangents_are_unit_vectors_across_normals_in_the_direction_of_the_texture() {
        let mesh = Primitive::Plane.mesh();
        let (made, tangents) = mesh.with_tangents();
        assert_eq!(made.positions(), mesh.positions());
        assert!(tangents.iter().all(|t| *t == [1.0, 0.0, 0.0, 1.0]));
        for primitive in Primitive::ALL {
            let (mesh, tangents) = primitive.mesh().with_tangents();
            for (n, t) in mesh.normals().iter().zip(&tangents) {
                let dot: f32 = (0..3).map(|k| n[k] * t[k]).sum();
                let length: f32 = (0..3).map(|k| t[k] * t[k]).sum();
                assert!(dot.abs() < 1e-3 && (length - 1.0).abs() < 1e-3 && t[3].abs() == 1.0);
            }
        }
    }

    #[test]
    fn functions_are_the_share_files_in_views() {
        let size = Size::new(5, 4);
        let planes = Planes::from_vec(size, 18, (0..360).map(|i| i as f32 / 360.0).collect()).unwrap();
        let field = ReflectanceField::new(Basis::Ptm, PlaneLayout::RGB, Space::Srgb, planes).unwrap();
        let encoding = Encoding::Picture(Depth::Sixteen);
        let file = FieldFile { field, opacity: None, encoding, record: Default::default(), models: None };
        let share =
            ShareFiles::new(&file, &ShareExtras::default(), PlaneDepth::Half, &Job::default()).unwrap();
        let mesh = Primitive::Plane.mesh();
        let preview = GlbPreview { mesh: &mesh, tiling: [1.0; 2], material: &material(Some(&share)) };
        let (root, buffer) = parts(&encode_glb(&preview, &Job::default()).unwrap());
        assert_eq!(root["extensionsUsed"], json!(["RELUME_reflectance"]));
        let extension = &root["materials"][0]["extensions"]["RELUME_reflectance"];
        let header: ShareHeader = serde_json::from_value(extension["share"].clone()).unwrap();
        assert_eq!(header, share.header);
        for (name, bytes) in &share.files {
            assert_eq!(bytes_of(&root, &buffer, &extension["files"][name]), bytes);
        }
    }
}
