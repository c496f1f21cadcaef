//! Pictures of fields: relighting, and rendering on objects.

pub mod environment;
pub mod mesh;

mod highlight;
mod horizon;
mod material;
mod mip_map;
mod object;
mod pictures;
mod raster;
mod relief;
mod relight;
mod relighter;
mod scene;
mod shade;
mod shadow;
mod srgb8;
mod sweep;
mod vector;
mod view;

pub use environment::{
    Environment, EnvironmentLight, EnvironmentMethod, EnvironmentNodes, LampKind, relight_under,
};
pub use highlight::Specular;
pub use mesh::{Mesh, MeshVertices, Primitive};
pub use object::{render, render_relief};
pub use pictures::{Pictures, ShownForm};
pub use relief::MeshRelief;
pub use relight::{relight, relight_srgb8};
pub use relighter::Relighter;
pub use scene::{Camera, CastShadows, Light, RenderOptions, TexelShading};
pub use srgb8::srgb8_from_linear;
pub use sweep::Sweep;
pub use vector::Vec3;
