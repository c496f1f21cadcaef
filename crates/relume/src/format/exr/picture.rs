//! EXR files as plain pictures: linear `R`, `G`, `B`, or a single grey channel.

use super::ExrDepth;
use super::container::{self, Layer};
use crate::error::{Error, Result};
use crate::picture::Picture;
use crate::raster::{Raster, Samples};

/// The picture in a layer: `R`, `G`, `B`, otherwise `Y`, otherwise the only channel.
pub(super) fn picture_of(layer: &Layer) -> Result<Raster> {
    let chosen = chosen(&layer.names).ok_or_else(|| no_picture(&layer.names))?;
    let size = layer.planes.size();
    let planes: Vec<&[f32]> = chosen.iter().map(|&k| layer.planes.plane(k)).collect();
    let samples = (0..size.texels()).flat_map(|texel| planes.iter().map(move |plane| plane[texel]));
    Raster::new(size, planes.len(), Samples::F32(samples.collect()))
}

/// Whether channels of these names are a picture.
pub(super) fn is_picture(names: &[String]) -> bool {
    chosen(names).is_some()
}

fn chosen(names: &[String]) -> Option<Vec<usize>> {
    let find = |name: &str| names.iter().position(|n| n == name);
    let rgb: Option<Vec<usize>> = ["R", "G", "B"].into_iter().map(find).collect();
    let grey = || find("Y").or((names.len() == 1).then_some(0)).map(|k| vec![k]);
    rgb.or_else(grey)
}

fn no_picture(names: &[String]) -> Error {
    let mut listed = names.iter().take(8).cloned().collect::<Vec<_>>().join(", ");
    if names.len() > 8 {
        listed.push_str(", ...");
    }
    Error::unsupported(format!(
        "the EXR file holds the channels {listed}: expected R, G and B, or Y, or a single channel"
    ))
}

/// The bytes of a picture with linear values.
pub(in crate::format) fn encode_picture(linear: &Picture, depth: ExrDepth) -> Result<Vec<u8>> {
    container::encode(&channel_names(linear.planes.count()), &linear.planes, depth, &[])
}

/// The channels of a plain picture.
fn channel_names(channels: usize) -> Vec<String> {
    let names: &[&str] = if channels == 1 { &["Y"] } else { &["R", "G", "B"] };
    names.iter().map(|&name| name.to_owned()).collect()
}
