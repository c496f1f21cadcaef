//! Registered maps of a surface: the input of a virtual capture and the output of a procedural material.

use crate::error::{Error, Result};
use crate::planes::Planes;
use crate::size::Size;

/// Height, colour, and optional normal, roughness and metallic maps of one surface, all of the same size.
#[derive(Debug, Clone, PartialEq)]
pub struct SurfaceMaps {
    /// One plane: height in **texels** above an arbitrary level, so that slopes are dimensionless.
    pub height: Planes,
    /// Three planes: linear diffuse reflectance in 0..1.
    pub albedo: Planes,
    /// Three planes: unit normals (x right, y up, z out); derived from the height when absent.
    pub normal: Option<Planes>,
    /// One plane: GGX roughness in 0..1 (the square root of alpha); 1 where absent.
    pub roughness: Option<Planes>,
    /// One plane: the share of bare metal in 0..1, whose colour is the albedo; 0 where absent.
    pub metallic: Option<Planes>,
}

impl SurfaceMaps {
    /// Width and height.
    pub fn size(&self) -> Size {
        self.height.size()
    }

    /// Checks that each map has the right number of planes and that all have the same size.
    pub fn validate(&self) -> Result<()> {
        let maps = [
            ("height", Some(&self.height), 1),
            ("albedo", Some(&self.albedo), 3),
            ("normal", self.normal.as_ref(), 3),
            ("roughness", self.roughness.as_ref(), 1),
            ("metallic", self.metallic.as_ref(), 1),
        ];
        for (name, map, count) in maps.into_iter().filter_map(|(n, m, c)| m.map(|m| (n, m, c))) {
            if map.size() != self.size() {
                return Err(Error::invalid(format!(
                    "the {name} map is {} texels, the height map {}: all maps must have the same size",
                    map.size(),
                    self.size()
                )));
            }
            if map.count() != count {
                return Err(Error::invalid(format!(
                    "the {name} map has {} channels, expected {count}",
                    map.count()
                )));
            }
        }
        Ok(())
    }
}
