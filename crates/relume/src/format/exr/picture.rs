//! EXR files as plain pictures: linear colours or greys, with an opacity.
//!
//! By the convention of the format the colours of a file with an opacity are multiplied by it (associated
//! alpha; "Technical Introduction to OpenEXR", Academy Software Foundation); they are divided on reading and
//! multiplied on writing.

use super::ExrDepth;
use super::channels::{self, ChosenChannels};
use super::container::{self, Layer};
use crate::error::Result;
use crate::format::meaning::Meaning;
use crate::format::opacity;
use crate::job::Job;
use crate::picture::Picture;
use crate::planes::Planes;
use crate::raster::{Raster, Samples};

/// The picture in a layer. Channels that are not part of it become a remark.
pub(super) fn picture_of(layer: &Layer, meaning: Meaning, job: &Job) -> Result<Raster> {
    let chosen = channels::choose(&layer.names, meaning != Meaning::Colors);
    let ChosenChannels { colors, opacity, unused } = chosen.ok_or_else(|| channels::unclear(&layer.names))?;
    if !unused.is_empty() {
        let taken: Vec<String> = colors.iter().map(|&k| layer.names[k].clone()).collect();
        job.remark(format!(
            "of the EXR channels {} are used: {} are not",
            channels::listed(&taken),
            channels::listed(&unused)
        ));
    }
    let size = layer.planes.size();
    let planes: Vec<&[f32]> = colors.iter().map(|&k| layer.planes.plane(k)).collect();
    let texels = (0..size.texels()).flat_map(|texel| planes.iter().map(move |plane| plane[texel]));
    let mut samples = Samples::F32(texels.collect());
    let alphas = opacity.map(|k| Samples::F32(layer.planes.plane(k).to_vec()));
    if let Some(alphas) = &alphas {
        opacity::divide(&mut samples, alphas);
    }
    let raster = Raster::new(size, planes.len(), samples)?;
    match alphas {
        Some(alphas) => raster.with_opacity(alphas),
        None => Ok(raster),
    }
}

/// Planes multiplied by an opacity.
pub(super) fn multiplied(planes: &Planes, opacity: &Planes) -> Planes {
    let mut out = planes.clone();
    for plane in out.iter_mut() {
        plane.iter_mut().zip(opacity.plane(0)).filter(|(_, o)| **o > 0.0).for_each(|(v, o)| *v *= o);
    }
    out
}

/// The bytes of a picture with linear values.
pub(in crate::format) fn encode_picture(linear: &Picture, depth: ExrDepth, job: &Job) -> Result<Vec<u8>> {
    container::encode(&channel_names(linear.planes.count()), &linear.planes, depth, &[], job)
}

/// The channels of a plain picture.
fn channel_names(channels: usize) -> Vec<String> {
    let names: &[&str] = if channels == 1 { &["Y"] } else { &["R", "G", "B"] };
    names.iter().map(|&name| name.to_owned()).collect()
}
