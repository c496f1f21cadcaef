//! A USD layer beside the maps: a material of the preview surface (Pixar, "UsdPreviewSurface Specification", version 2.6)
//! with a texture reader for each file.

use std::fmt::Write;

use super::materialx::identifier;
use super::presets::DataMap;
use super::slots::{MapSlot, MaterialSlots};
use crate::format::NormalY;

/// The layer of a material.
pub(super) fn layer(name: &str, slots: &MaterialSlots<'_>) -> String {
    let id = identifier(name);
    let mut parts = LayerParts { id: &id, inputs: String::new(), shaders: String::new() };
    if let Some(file) = slots.color() {
        parts.input("color3f", "diffuseColor", "base_color", "rgb");
        parts.texture("base_color", file, "sRGB", "rgb", None);
    }
    let data = [
        ("roughness", slots.data(DataMap::Roughness)),
        ("metallic", slots.data(DataMap::Metallic)),
        ("occlusion", slots.data(DataMap::Occlusion)),
        ("opacity", slots.opacity()),
    ];
    for (input, slot) in data {
        slot.iter().for_each(|slot| parts.data(input, slot));
    }
    // Normals with -Y would need a scale that the specification does not allow.
    if let Some((file, NormalY::Up)) = slots.normal() {
        let turned = ["(2, 2, 2, 1)", "(-1, -1, -1, 0)"];
        parts.input("normal3f", "normal", "normal", "rgb");
        parts.texture("normal", file, "raw", "rgb", Some(turned));
    }
    parts.layer()
}

/// The parts of a layer.
struct LayerParts<'a> {
    id: &'a str,
    /// Of the surface.
    inputs: String,
    shaders: String,
}

impl LayerParts<'_> {
    fn data(&mut self, input: &str, slot: &MapSlot) {
        let output = ["r", "g", "b", "a"][slot.channel];
        self.input("float", input, input, output);
        let turned = slot.inverted.then_some(["(-1, -1, -1, -1)", "(1, 1, 1, 1)"]);
        // Of the colours only the fourth channel is data, which no space changes.
        let space = if slot.channels == 4 && !slot.inverted { "auto" } else { "raw" };
        self.texture(input, &slot.file, space, output, turned);
    }

    fn input(&mut self, kind: &str, input: &str, shader: &str, output: &str) {
        let _ = writeln!(
            self.inputs,
            "        {kind} inputs:{input}.connect = </{}/{shader}_texture.outputs:{output}>",
            self.id
        );
    }

    fn texture(&mut self, name: &str, file: &str, space: &str, output: &str, turned: Option<[&str; 2]>) {
        let kind = if output == "rgb" { "float3" } else { "float" };
        let scaled = turned.map_or(String::new(), |[scale, bias]| {
            format!("        float4 inputs:scale = {scale}\n        float4 inputs:bias = {bias}\n")
        });
        let _ = write!(
            self.shaders,
            "\n    def Shader \"{name}_texture\"\n    {{\n        uniform token info:id = \"UsdUVTexture\"\n        \
             asset inputs:file = @./{file}@\n        token inputs:sourceColorSpace = \"{space}\"\n        \
             token inputs:wrapS = \"repeat\"\n        token inputs:wrapT = \"repeat\"\n{scaled}        \
             float2 inputs:st.connect = </{}/st.outputs:result>\n        {kind} outputs:{output}\n    }}\n",
            self.id
        );
    }

    fn layer(&self) -> String {
        let Self { id, inputs, shaders } = self;
        format!(
            "#usda 1.0\n(\n    defaultPrim = \"{id}\"\n    metersPerUnit = 1\n    upAxis = \"Y\"\n)\n\n\
             def Material \"{id}\"\n{{\n    token outputs:surface.connect = </{id}/surface.outputs:surface>\n\n    \
             def Shader \"surface\"\n    {{\n        uniform token info:id = \"UsdPreviewSurface\"\n{inputs}        \
             token outputs:surface\n    }}\n\n    def Shader \"st\"\n    {{\n        \
             uniform token info:id = \"UsdPrimvarReader_float2\"\n        string inputs:varname = \"st\"\n        \
             float2 outputs:result\n    }}\n{shaders}}}\n"
        )
    }
}
