//! Captures: light files, folders of photographs, and the virtual light dome.

pub mod dome;
mod finder;
mod folder;
pub mod lp;
pub mod pairs;

pub use folder::{Capture, Pairing, Photograph};
