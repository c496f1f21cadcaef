//! A MaterialX document beside the maps.
//!
//! Version 1.39 of the specification, with the surface of OpenPBR 1.1 (Academy Software Foundation). Heights are not
//! connected: their scale depends on the scene.

use std::fmt::Write;

use super::presets::DataMap;
use super::slots::{MapSlot, MaterialSlots};
use crate::format::NormalY;

/// The document of a material.
pub(super) fn document(name: &str, slots: &MaterialSlots<'_>) -> String {
    let mut graph = DocumentGraph {
        id: identifier(name),
        nodes: String::new(),
        outputs: String::new(),
        inputs: String::new(),
    };
    if let Some(file) = slots.color() {
        graph.color(file, slots.opacity().is_some_and(|slot| slot.file == file));
    }
    let data = [("base_metalness", DataMap::Metallic), ("specular_roughness", DataMap::Roughness)];
    for (input, map) in data {
        slots.data(map).iter().for_each(|slot| graph.data(input, slot));
    }
    slots.opacity().iter().for_each(|slot| graph.data("geometry_opacity", slot));
    slots.normal().iter().for_each(|(file, y)| graph.normal(file, *y));
    graph.document()
}

/// A name as both kinds of documents allow it.
pub(super) fn identifier(name: &str) -> String {
    let kept: String = name.chars().map(|c| if c.is_ascii_alphanumeric() { c } else { '_' }).collect();
    if kept.starts_with(|c: char| c.is_ascii_digit()) { format!("_{kept}") } else { kept }
}

/// The parts of a document.
struct DocumentGraph {
    id: String,
    nodes: String,
    outputs: String,
    /// Those of the surface.
    inputs: String,
}

impl DocumentGraph {
    fn color(&mut self, file: &str, is_translucent: bool) {
        let kind = if is_translucent { "color4" } else { "color3" };
        self.image("base_color_image", kind, file, " colorspace=\"srgb_texture\"");
        let last = if is_translucent {
            self.node(
                "convert",
                "base_color_rgb",
                "color3",
                &[("in", kind, "nodename=\"base_color_image\"")],
            );
            "base_color_rgb"
        } else {
            "base_color_image"
        };
        self.connect("base_color", "color3", last);
    }

    fn data(&mut self, input: &str, slot: &MapSlot) {
        let image = format!("{input}_image");
        let mut last = image.clone();
        if slot.channels == 1 {
            self.image(&image, "float", &slot.file, "");
        } else {
            let kind = if slot.channels == 3 { "vector3" } else { "vector4" };
            self.image(&image, kind, &slot.file, "");
            last = format!("{input}_channel");
            let (from, index) = (format!("nodename=\"{image}\""), format!("value=\"{}\"", slot.channel));
            self.node("extract", &last, "float", &[("in", kind, &from), ("index", "integer", &index)]);
        }
        if slot.inverted {
            let from = format!("nodename=\"{last}\"");
            last = format!("{input}_inverted");
            self.node("invert", &last, "float", &[("in", "float", &from)]);
        }
        self.connect(input, "float", &last);
    }

    fn normal(&mut self, file: &str, y: NormalY) {
        self.image("normal_image", "vector3", file, "");
        let mut inputs = vec![("in", "vector3", "nodename=\"normal_image\"")];
        if y == NormalY::Down {
            inputs.push(("scale", "vector2", "value=\"1, -1\""));
        }
        self.node("normalmap", "normal_direction", "vector3", &inputs);
        self.connect("geometry_normal", "vector3", "normal_direction");
    }

    fn image(&mut self, name: &str, kind: &str, file: &str, space: &str) {
        let value = format!("value=\"{file}\"{space}");
        self.node("image", name, kind, &[("file", "filename", &value)]);
    }

    fn node(&mut self, category: &str, name: &str, kind: &str, inputs: &[(&str, &str, &str)]) {
        let _ = writeln!(self.nodes, "    <{category} name=\"{name}\" type=\"{kind}\">");
        for (input, kind, what) in inputs {
            let _ = writeln!(self.nodes, "      <input name=\"{input}\" type=\"{kind}\" {what} />");
        }
        let _ = writeln!(self.nodes, "    </{category}>");
    }

    /// Feeds an input of the surface by a node.
    fn connect(&mut self, input: &str, kind: &str, node: &str) {
        let _ = writeln!(self.outputs, "    <output name=\"{input}\" type=\"{kind}\" nodename=\"{node}\" />");
        let _ = writeln!(
            self.inputs,
            "    <input name=\"{input}\" type=\"{kind}\" nodegraph=\"NG_{}\" output=\"{input}\" />",
            self.id
        );
    }

    fn document(&self) -> String {
        let Self { id, nodes, outputs, inputs } = self;
        format!(
            "<?xml version=\"1.0\"?>\n<materialx version=\"1.39\" colorspace=\"lin_rec709\">\n  \
             <nodegraph name=\"NG_{id}\">\n{nodes}{outputs}  </nodegraph>\n  \
             <open_pbr_surface name=\"SR_{id}\" type=\"surfaceshader\">\n{inputs}  </open_pbr_surface>\n  \
             <surfacematerial name=\"{id}\" type=\"material\">\n    \
             <input name=\"surfaceshader\" type=\"surfaceshader\" nodename=\"SR_{id}\" />\n  \
             </surfacematerial>\n</materialx>\n"
        )
    }
}
