//! Binary glTF 2.0 (ISO/IEC 12113:2022): the triangles of the default scene, placed by its nodes.
//!
//! Accessors are read here, with every range checked, because a library that trusts them would
//! stop the program on a bad file. Quantised ones (KHR_mesh_quantization) are read; sparse and
//! compressed ones, and buffers outside the file, are refused by name; so are lines and points.

use gltf::accessor::{DataType, Dimensions};
use gltf::{Accessor, Document, Gltf, Node, Primitive, Semantic};

use super::MeshParts;
use crate::error::{Error, Result};
use crate::job::Job;
use crate::render::Mesh;

/// The deepest nesting of nodes; a deeper tree is a loop or an attack.
const MAX_DEPTH: usize = 64;
/// The most nodes in total, since nodes may be referenced repeatedly.
const MAX_NODES: usize = 100_000;

pub(super) fn decode(bytes: &[u8], job: &Job) -> Result<Mesh> {
    check_length(bytes)?;
    let Gltf { document, blob } = Gltf::from_slice_without_validation(bytes).map_err(|e| broken(&e))?;
    let mut root = document.into_json();
    check_extensions(&root.extensions_required)?;
    // Those that are left do not concern the triangles, and the library refuses all but its own.
    root.extensions_required.clear();
    check_positions(&root)?;
    add_bounds(&mut root);
    let document = Document::from_json(root).map_err(|e| broken(&e))?;
    let blob = blob.as_deref().ok_or_else(|| Error::unsupported("the glTF file has no binary part"))?;
    let scene = document.default_scene().or_else(|| document.scenes().next());
    let scene = scene.ok_or_else(|| Error::invalid("the glTF file has no scene"))?;
    let mut reader = GlbReader { blob, job, parts: MeshParts::default(), nodes: 0 };
    for node in scene.nodes() {
        reader.node(&node, &IDENTITY, 0)?;
    }
    reader.parts.into_mesh()
}

/// The length in the header must cover the header and lie within the file.
fn check_length(bytes: &[u8]) -> Result<()> {
    let length = bytes.get(8..12).map_or(0, |b| u32::from_le_bytes([b[0], b[1], b[2], b[3]]) as usize);
    if length < 20 || length > bytes.len() {
        return Err(Error::invalid(format!(
            "the glTF header announces {length} bytes, but the file has {}: it may be truncated",
            bytes.len()
        )));
    }
    Ok(())
}

/// The check of positions in the library assumes that their accessor exists.
fn check_positions(root: &gltf::json::Root) -> Result<()> {
    let primitives = root.meshes.iter().flat_map(|mesh| &mesh.primitives);
    let accessors = primitives.flat_map(|primitive| primitive.attributes.values()).map(|index| index.value());
    match accessors.into_iter().find(|&index| index >= root.accessors.len()) {
        Some(index) => Err(Error::invalid(format!(
            "an attribute names accessor {index}, but there are {}",
            root.accessors.len()
        ))),
        None => Ok(()),
    }
}

/// The bounds of positions, without which the library refuses a file: some programs leave them out, and nothing uses them here.
fn add_bounds(root: &mut gltf::json::Root) {
    for accessor in &mut root.accessors {
        let bounds = || serde_json::Value::from(vec![0.0; 3]);
        accessor.min.get_or_insert_with(bounds);
        accessor.max.get_or_insert_with(bounds);
    }
}

/// Refuses what the triangles cannot be read without.
fn check_extensions(required: &[String]) -> Result<()> {
    /// Extensions by how their names begin: of looks, which the texture replaces, and the quantised numbers.
    const KNOWN: [&str; 7] = [
        "KHR_mesh_quantization",
        "KHR_materials_",
        "KHR_texture_",
        "EXT_texture_",
        "MSFT_texture_",
        "KHR_lights_",
        "KHR_xmp",
    ];
    let unknown = required.iter().find(|name| !KNOWN.iter().any(|known| name.starts_with(known)));
    let Some(name) = unknown else { return Ok(()) };
    let kind = match name.as_str() {
        "KHR_draco_mesh_compression" => "Draco compression",
        "EXT_meshopt_compression" | "KHR_meshopt_compression" => "meshopt compression",
        _ => "a glTF extension",
    };
    let name: String = name.chars().filter(|c| !c.is_control()).take(60).collect();
    Err(Error::unsupported(format!(
        "the mesh needs {kind} ({name}), which is not read: export it without compression and extensions"
    )))
}

/// What the library complains of, in words of the format.
fn broken(error: &gltf::Error) -> Error {
    use gltf::binary::Error as Binary;
    match error {
        gltf::Error::Binary(Binary::Version(version)) => {
            Error::unsupported(format!("glTF {version} is not read: export the mesh as binary glTF 2.0"))
        }
        gltf::Error::Deserialize(error) => Error::invalid(format!(
            "the JSON part of the glTF file breaks its rules at line {}, column {}",
            error.line(),
            error.column()
        )),
        gltf::Error::Validation(errors) => {
            let place = errors.first().map_or_else(String::new, |(path, _)| format!(" at {path}"));
            let place: String = place.chars().filter(|c| !c.is_control()).take(120).collect();
            Error::invalid(format!("the JSON part of the glTF file breaks the rules of glTF 2.0{place}"))
        }
        _ => Error::invalid("the glTF file's chunks are broken: it may be truncated"),
    }
}

/// Columns of an affine map, the translation last.
type Transform = [[f32; 4]; 4];

const IDENTITY: Transform =
    [[1.0, 0.0, 0.0, 0.0], [0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0], [0.0, 0.0, 0.0, 1.0]];

fn times(a: &Transform, b: &Transform) -> Transform {
    std::array::from_fn(|c| std::array::from_fn(|r| (0..4).map(|k| a[k][r] * b[c][k]).sum()))
}

/// A point transformed by a map.
fn moved(m: &Transform, p: [f32; 3]) -> [f32; 3] {
    std::array::from_fn(|r| m[0][r] * p[0] + m[1][r] * p[1] + m[2][r] * p[2] + m[3][r])
}

/// A normal transformed by a map: by the cofactors of its linear part, so that it remains perpendicular.
fn turned(m: &Transform, n: [f32; 3]) -> [f32; 3] {
    let cross = |a: [f32; 4], b: [f32; 4]| -> [f32; 3] {
        [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
    };
    let cofactors = [cross(m[1], m[2]), cross(m[2], m[0]), cross(m[0], m[1])];
    let mirror: f32 = (0..3).map(|r| m[0][r] * cofactors[0][r]).sum();
    std::array::from_fn(|r| mirror.signum() * (0..3).map(|c| cofactors[c][r] * n[c]).sum::<f32>())
}

struct GlbReader<'a> {
    blob: &'a [u8],
    job: &'a Job,
    parts: MeshParts,
    nodes: usize,
}

impl GlbReader<'_> {
    fn node(&mut self, node: &Node, parent: &Transform, depth: usize) -> Result<()> {
        self.nodes += 1;
        if depth > MAX_DEPTH || self.nodes > MAX_NODES {
            return Err(Error::limit(format!(
                "the glTF scene has more than {MAX_NODES} nodes, or more than {MAX_DEPTH} below one another"
            )));
        }
        let world = times(parent, &node.transform().matrix());
        for primitive in node.mesh().iter().flat_map(gltf::Mesh::primitives) {
            let place = format!("node {}, primitive {}", node.index(), primitive.index());
            self.primitive(&primitive, &world)
                .map_err(|e| Error::new(e.kind(), format!("{place}: {}", e.message())))?;
        }
        node.children().try_for_each(|child| self.node(&child, &world, depth + 1))
    }

    fn primitive(&mut self, primitive: &Primitive, world: &Transform) -> Result<()> {
        let corners = corners_of(primitive.mode())?;
        let positions: Vec<[f32; 3]> = self.floats(&required(primitive, Semantic::Positions)?)?;
        let texcoords: Vec<[f32; 2]> = self.floats(&required(primitive, Semantic::TexCoords(0))?)?;
        let normals: Vec<[f32; 3]> = match primitive.get(&Semantic::Normals) {
            Some(accessor) => self.floats(&accessor)?,
            None => vec![[0.0; 3]; positions.len()],
        };
        let count = positions.len();
        if texcoords.len() != count || normals.len() != count {
            return Err(Error::invalid("positions, normals and texture coordinates differ in number"));
        }
        let indices = match primitive.indices() {
            Some(accessor) => self.indices(&accessor)?,
            None => (0..u32::try_from(count).unwrap_or(u32::MAX)).collect(),
        };
        if let Some(i) = indices.iter().find(|&&i| i as usize >= count) {
            return Err(Error::invalid(format!("a triangle refers to vertex {i}, but there are {count}")));
        }
        let first = u32::try_from(self.parts.positions.len() + count)
            .map(|end| end - count as u32)
            .map_err(|_| Error::limit("the mesh has more than 4,294,967,295 vertices"))?;
        self.parts.positions.extend(positions.into_iter().map(|p| moved(world, p)));
        self.parts.normals.extend(normals.into_iter().map(|n| turned(world, n)));
        // glTF counts t from the top.
        self.parts.texcoords.extend(texcoords.into_iter().map(|[s, t]| [s, 1.0 - t]));
        let triangles = (0..).map(corners).map_while(|t| {
            Some([first + indices.get(t[0])?, first + indices.get(t[1])?, first + indices.get(t[2])?])
        });
        self.parts.triangles.extend(triangles);
        self.parts.check(self.job)
    }

    fn floats<const N: usize>(&self, accessor: &Accessor) -> Result<Vec<[f32; N]>> {
        let dimensions = if N == 3 { Dimensions::Vec3 } else { Dimensions::Vec2 };
        if accessor.dimensions() != dimensions {
            return Err(Error::invalid(format!(
                "an attribute is {:?}, expected {dimensions:?}",
                accessor.dimensions()
            )));
        }
        let normalized = accessor.normalized();
        let (largest, size) = match accessor.data_type() {
            DataType::F32 => (1.0, 4),
            DataType::U8 => (255.0, 1),
            DataType::I8 => (127.0, 1),
            DataType::U16 => (65535.0, 2),
            DataType::I16 => (32767.0, 2),
            DataType::U32 => {
                return Err(Error::unsupported("attributes of 32-bit whole numbers are not read"));
            }
        };
        let stored = |b: &[u8]| match accessor.data_type() {
            DataType::F32 | DataType::U32 => f32::from_le_bytes([b[0], b[1], b[2], b[3]]),
            DataType::U8 => f32::from(b[0]),
            DataType::I8 => f32::from(b[0] as i8),
            DataType::U16 => f32::from(u16::from_le_bytes([b[0], b[1]])),
            DataType::I16 => f32::from(i16::from_le_bytes([b[0], b[1]])),
        };
        let read = |b: &[u8]| if normalized { (stored(b) / largest).max(-1.0) } else { stored(b) };
        let elements = self.elements(accessor, N * size)?;
        Ok(elements.map(|e| std::array::from_fn(|k| read(&e[k * size..(k + 1) * size]))).collect())
    }

    fn indices(&self, accessor: &Accessor) -> Result<Vec<u32>> {
        let size = match (accessor.data_type(), accessor.dimensions()) {
            (DataType::U8, Dimensions::Scalar) => 1,
            (DataType::U16, Dimensions::Scalar) => 2,
            (DataType::U32, Dimensions::Scalar) => 4,
            (other, _) => {
                return Err(Error::invalid(format!(
                    "the indices of a mesh are of type {other:?}: expected whole numbers without a sign"
                )));
            }
        };
        let value = |bytes: &[u8]| bytes.iter().rev().fold(0u32, |sum, &b| sum << 8 | u32::from(b));
        Ok(self.elements(accessor, size)?.map(value).collect())
    }

    /// The bytes of each element, `size` each, after checking that all lie in the file.
    fn elements(&self, accessor: &Accessor, size: usize) -> Result<impl Iterator<Item = &[u8]>> {
        let index = accessor.index();
        if accessor.sparse().is_some() {
            return Err(Error::unsupported(format!(
                "accessor {index} is sparse, which is not read: export the mesh without sparse accessors"
            )));
        }
        let view = accessor.view();
        let view = view.ok_or_else(|| Error::unsupported(format!("accessor {index} has no data")))?;
        if !matches!(view.buffer().source(), gltf::buffer::Source::Bin) {
            return Err(Error::unsupported("a buffer lies outside the file: save the mesh as one .glb"));
        }
        let (count, stride) = (accessor.count(), view.stride().unwrap_or(size));
        let end = view.offset().checked_add(view.length()).filter(|_| stride >= size);
        let bytes = end.and_then(|end| self.blob.get(view.offset()..end));
        let needed = count
            .checked_sub(1)
            .and_then(|steps| steps.checked_mul(stride))
            .and_then(|n| n.checked_add(size));
        let bytes = bytes
            .zip(needed)
            .and_then(|(bytes, needed)| bytes.get(accessor.offset()..accessor.offset().checked_add(needed)?));
        let bytes = bytes.ok_or_else(|| {
            Error::invalid(format!(
                "accessor {} reaches beyond the binary part of the file",
                accessor.index()
            ))
        })?;
        self.job.check_bytes("the mesh", 12 * count as u64)?;
        Ok((0..count).map(move |i| &bytes[i * stride..i * stride + size]))
    }
}

/// The places among the indices of the corners of each triangle.
fn corners_of(mode: gltf::mesh::Mode) -> Result<fn(usize) -> [usize; 3]> {
    use gltf::mesh::Mode;
    match mode {
        Mode::Triangles => Ok(|i| [3 * i, 3 * i + 1, 3 * i + 2]),
        Mode::TriangleStrip => Ok(|i| [i, i + 1 + i % 2, i + 2 - i % 2]),
        Mode::TriangleFan => Ok(|i| [i + 1, i + 2, 0]),
        Mode::Points | Mode::Lines | Mode::LineLoop | Mode::LineStrip => Err(Error::unsupported(
            "points and lines are not read, only triangles: export the surfaces alone",
        )),
    }
}

fn required<'a>(primitive: &Primitive<'a>, semantic: Semantic) -> Result<Accessor<'a>> {
    primitive.get(&semantic).ok_or_else(|| {
        let hint =
            if semantic == Semantic::TexCoords(0) { ": unwrap the mesh before exporting it" } else { "" };
        Error::unsupported(format!("the attribute {} is missing{hint}", semantic.to_string()))
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A triangle, written by hand from the specification: JSON and binary chunks.
    fn triangle(node: &str, length_of_indices: usize) -> Vec<u8> {
        edited(node, length_of_indices, "", "")
    }

    /// The same with a piece of its JSON replaced.
    fn edited(node: &str, length_of_indices: usize, from: &str, to: &str) -> Vec<u8> {
        let mut bin = Vec::new();
        for value in [0.0f32, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 1.0, 1.0, 1.0, 0.0, 0.0] {
            bin.extend(value.to_le_bytes());
        }
        bin.extend([0u8, 0, 1, 0, 2, 0, 0, 0]);
        let mut json = format!(
            r#"{{"asset":{{"version":"2.0"}},"scene":0,"scenes":[{{"nodes":[0]}}],"nodes":[{{"mesh":0{node}}}],
            "meshes":[{{"primitives":[{{"attributes":{{"POSITION":0,"TEXCOORD_0":1}},"indices":2}}]}}],
            "buffers":[{{"byteLength":68}}],
            "bufferViews":[{{"buffer":0,"byteOffset":0,"byteLength":36}},{{"buffer":0,"byteOffset":36,"byteLength":24}},
            {{"buffer":0,"byteOffset":60,"byteLength":{length_of_indices}}}],
            "accessors":[{{"bufferView":0,"componentType":5126,"count":3,"type":"VEC3","min":[0,0,0],"max":[1,1,0]}},
            {{"bufferView":1,"componentType":5126,"count":3,"type":"VEC2"}},
            {{"bufferView":2,"componentType":5123,"count":3,"type":"SCALAR"}}]}}"#
        )
        .replacen(from, to, 1)
        .into_bytes();
        json.resize(json.len().next_multiple_of(4), b' ');
        let mut out = b"glTF".to_vec();
        let total = 12 + 8 + json.len() + 8 + bin.len();
        out.extend([2u32.to_le_bytes(), (total as u32).to_le_bytes()].concat());
        for (kind, data) in [(b"JSON", &json), (b"BIN\0", &bin)] {
            out.extend((data.len() as u32).to_le_bytes());
            out.extend(kind);
            out.extend(data);
        }
        out
    }

    fn decoded(bytes: &[u8]) -> Result<Mesh> {
        decode(bytes, &Job::default())
    }

    #[test]
    fn a_triangle_is_placed_by_its_node_with_t_turned() {
        let mesh = decoded(&triangle(r#","translation":[1,2,3],"scale":[2,2,-2]"#, 6)).unwrap();
        assert_eq!(mesh.positions(), [[1.0, 2.0, 3.0], [3.0, 2.0, 3.0], [1.0, 4.0, 3.0]]);
        assert_eq!(mesh.texcoords(), [[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]]);
        assert_eq!(mesh.triangles(), [[0, 1, 2]]);
    }

    #[test]
    fn positions_need_no_bounds() {
        let without = edited("", 6, r#","min":[0,0,0],"max":[1,1,0]"#, "");
        assert_eq!(decoded(&without).unwrap(), decoded(&triangle("", 6)).unwrap());
    }

    #[test]
    fn normals_stay_at_right_angles_under_uneven_scales() {
        let mut m = IDENTITY;
        m[0][0] = 4.0;
        let n = turned(&m, [1.0, 1.0, 0.0]);
        // The surface through (1, -1, 0) goes to (4, -1, 0).
        assert_eq!(n[0] * 4.0 - n[1], 0.0);
        m[2][2] = -1.0;
        assert_eq!(turned(&m, [0.0, 0.0, 1.0]).map(f32::signum)[2], -1.0);
    }

    #[test]
    fn ranges_beyond_the_file_and_loops_are_refused() {
        let error = decoded(&triangle("", 5)).unwrap_err().to_string();
        assert!(error.contains("accessor 2 reaches beyond"), "{error}");
        let error = decoded(&triangle(r#","children":[0]"#, 6)).unwrap_err().to_string();
        assert!(error.contains("64 below one another"), "{error}");
    }

    #[test]
    fn an_accessor_that_claims_more_than_the_file_holds_is_refused() {
        let bomb = edited("", 6, r#""count":3"#, r#""count":4294967295"#);
        let error = decoded(&bomb).unwrap_err().to_string();
        assert!(error.contains("accessor 0 reaches beyond"), "{error}");
    }

    #[test]
    fn no_truncation_or_changed_byte_panics() {
        let good = triangle("", 6);
        for end in 0..good.len() {
            assert!(decoded(&good[..end]).is_err());
        }
        for at in 0..good.len() {
            for value in [0, 9, b'9', 0xff] {
                let mut bad = good.clone();
                bad[at] = value;
                let _ = decoded(&bad);
            }
        }
    }

    #[test]
    fn what_is_not_read_is_named_in_the_terms_of_the_format() {
        let required = |name: &str| {
            let asset = r#""asset":"#;
            edited("", 6, asset, &format!(r#""extensionsRequired":["{name}"],{asset}"#))
        };
        let message = |bytes: &[u8]| decoded(bytes).unwrap_err().to_string();
        let draco = message(&required("KHR_draco_mesh_compression"));
        assert!(
            draco.contains("Draco compression (KHR_draco_mesh_compression), which is not read"),
            "{draco}"
        );
        assert!(message(&required("EXT_meshopt_compression")).contains("meshopt"));
        assert!(message(&required("ODD_shapes")).contains("a glTF extension (ODD_shapes)"));
        assert!(decoded(&required("KHR_texture_transform")).is_ok());
        assert!(decoded(&required("KHR_mesh_quantization")).is_ok());
        let sparse = r#""sparse":{"count":1,"indices":{"bufferView":2,"componentType":5123},"values":{"bufferView":1}},"#;
        let sparse = edited("", 6, r#""componentType":5126,"#, &format!(r#"{sparse}"componentType":5126,"#));
        assert!(message(&sparse).contains("accessor 0 is sparse"), "{}", message(&sparse));
        let lines = edited("", 6, r#""indices":2"#, r#""indices":2,"mode":1"#);
        assert!(message(&lines).contains("node 0, primitive 0: points and lines are not read"));
        let json = edited("", 6, r#""scene":0"#, r#""scene":{}"#);
        assert!(message(&json).contains("breaks its rules at line 1, column"), "{}", message(&json));
        let rules = edited("", 6, r#""mesh":0"#, r#""mesh":7"#);
        assert!(message(&rules).contains("rules of glTF 2.0 at nodes[0].mesh"), "{}", message(&rules));
        let mut first_version = triangle("", 6);
        first_version[4] = 1;
        assert!(message(&first_version).contains("glTF 1 is not read"), "{}", message(&first_version));
    }

    #[test]
    fn strips_and_fans_keep_their_turn() {
        let strip = corners_of(gltf::mesh::Mode::TriangleStrip).unwrap();
        assert_eq!([strip(0), strip(1), strip(2)], [[0, 1, 2], [1, 3, 2], [2, 3, 4]]);
        let fan = corners_of(gltf::mesh::Mode::TriangleFan).unwrap();
        assert_eq!([fan(0), fan(1)], [[1, 2, 0], [2, 3, 0]]);
        let strip = edited("", 6, r#""indices":2"#, r#""indices":2,"mode":5"#);
        assert_eq!(decoded(&strip).unwrap().triangles(), [[0, 1, 2]]);
    }

    #[test]
    fn quantised_coordinates_are_read() {
        // From byte 14 on, the halves of 1.0, six of zeros, and the halves of 1.0: 0x3f80, 0 and so on.
        let of = |kind: &str| edited("", 6, r#""componentType":5126,"count":3,"type":"VEC3""#, kind);
        let bytes = of(r#""byteOffset":14,"componentType":5122,"normalized":true,"count":3,"type":"VEC3""#);
        let half = 16256.0 / 32767.0;
        assert_eq!(decoded(&bytes).unwrap().positions(), [[half, 0.0, 0.0], [0.0; 3], [0.0, 0.0, half]]);
        // From byte 12 on, the bytes of 1.0: 0, 0, -128, 63.
        let bytes = of(r#""byteOffset":12,"componentType":5120,"count":3,"type":"VEC3""#);
        assert_eq!(decoded(&bytes).unwrap().positions()[..2], [[0.0, 0.0, -128.0], [63.0, 0.0, 0.0]]);
    }
}
