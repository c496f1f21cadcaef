//! Captures: light files, folders of photographs, lights from mirror balls, and the virtual light dome.

pub mod balls;
pub mod develop;
pub mod dome;
mod finder;
mod folder;
pub mod lp;
pub mod pairs;
mod relightlab;

pub use folder::{Capture, Pairing, Photograph, holds_light_file, pictures_in};
