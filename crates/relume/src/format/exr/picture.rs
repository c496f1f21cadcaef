//! EXR files as plain pictures: linear `R`, `G`, `B`, or a single grey channel.

use super::ExrDepth;
use super::container::{self, Layer};
use super::field::is_field;
use crate::error::{Error, Result};
use crate::job::Job;
use crate::picture::Picture;
use crate::raster::{Raster, Samples};

/// The linear picture in an EXR file.
pub(in crate::format) fn decode_picture(bytes: &[u8], job: &Job) -> Result<Raster> {
    let layer = container::decode(bytes, job)?;
    if is_field(&layer) {
        return Err(Error::unsupported(
            "the EXR file holds a texture of functions: expected a picture; relight it to make one",
        ));
    }
    picture_of(&layer)
}

/// The picture in a layer: `R`, `G`, `B`, else `Y`, else the only channel there is.
pub(super) fn picture_of(layer: &Layer) -> Result<Raster> {
    let find = |name: &str| layer.names.iter().position(|n| n == name);
    let rgb: Option<Vec<usize>> = ["R", "G", "B"].into_iter().map(find).collect();
    let grey = || find("Y").or((layer.names.len() == 1).then_some(0)).map(|k| vec![k]);
    let chosen = rgb.or_else(grey).ok_or_else(|| no_picture(&layer.names))?;
    let size = layer.planes.size();
    let planes: Vec<&[f32]> = chosen.iter().map(|&k| layer.planes.plane(k)).collect();
    let samples = (0..size.texels()).flat_map(|texel| planes.iter().map(move |plane| plane[texel]));
    Raster::new(size, planes.len(), Samples::F32(samples.collect()))
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
