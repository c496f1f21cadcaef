//! Pictures of fields: relighting, and rendering on objects.

mod relight;
mod srgb8;
mod sweep;

pub use relight::{relight, relight_srgb8};
pub use srgb8::srgb8_from_linear;
pub use sweep::Sweep;
