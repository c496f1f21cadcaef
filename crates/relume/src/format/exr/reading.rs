//! Reading EXR files.

use std::collections::BTreeMap;
use std::io::Cursor;

use ::exr::block::reader::Reader;
use ::exr::meta::attribute::Chromaticities;
use ::exr::meta::header::Header;
use ::exr::prelude::{
    AttributeValue, Compression, FlatSamples, LayerAttributes, ReadChannels, ReadLayers, SampleType, Vec2,
};

use super::ExrDepth;
use super::container::Layer;
use crate::error::{Error, Result};
use crate::format::kind::{Kind, damaged};
use crate::format::{finite, plausible};
use crate::job::Job;
use crate::planes::Planes;
use crate::size::Size;

/// Reads the first part of a file, with all its channels, as floats.
pub(in crate::format) fn decode(bytes: &[u8], job: &Job) -> Result<Layer> {
    let reader = ::exr::block::read(Cursor::new(bytes), false).map_err(unreadable)?;
    check_header(&reader, bytes.len() as u64, job)?;
    remark_on(reader.headers(), job);
    let image = ::exr::prelude::read()
        .no_deep_data()
        .largest_resolution_level()
        .all_channels()
        .first_valid_layer()
        .all_attributes();
    // The decoder has a pool of its own, of all processors.
    let image = if rayon::current_num_threads() > 1 { image } else { image.non_parallel() };
    let image = image.from_chunks(reader).map_err(unreadable)?;
    let layer = image.layer_data;
    let size = Size::new(layer.size.width(), layer.size.height());
    let channels = layer.channel_data.list;
    let half = channels.iter().all(|channel| matches!(channel.sample_data, FlatSamples::F16(_)));
    let mut samples = Vec::with_capacity(size.texels() * channels.len());
    channels.iter().for_each(|channel| append(&mut samples, &channel.sample_data));
    let names: Vec<String> = channels.iter().map(|channel| channel.name.to_string()).collect();
    let texels = size.texels().max(1);
    finite::check(&samples, size, |i| &names[i / texels], |i| i % texels)?;
    Ok(Layer {
        names,
        planes: Planes::from_vec(size, channels.len(), samples)?,
        depth: if half { ExrDepth::Half } else { ExrDepth::Float },
        attributes: texts(&layer.attributes),
    })
}

/// Remarks on what the texels do not show: further parts, and primaries other than those of sRGB.
fn remark_on(headers: &[Header], job: &Job) {
    if headers.len() > 1 {
        job.remark(format!("the EXR file has {} parts: the first is used", headers.len()));
    }
    let first = headers.first().and_then(|header| header.shared_attributes.chromaticities);
    let Some(Chromaticities { red, green, blue, white }) = first else { return };
    let near = |Vec2(x, y): Vec2<f32>, (u, v): (f32, f32)| (x - u).abs().max((y - v).abs()) <= 0.005;
    let rec709 =
        [(red, (0.64, 0.33)), (green, (0.30, 0.60)), (blue, (0.15, 0.06)), (white, (0.3127, 0.3290))];
    if !rec709.into_iter().all(|(found, expected)| near(found, expected)) {
        job.remark("its primaries are not those of sRGB: its values are taken as if they were");
    }
}

/// Refuses unsupported files, and sizes over the limits, before samples are allocated.
fn check_header(reader: &Reader<Cursor<&[u8]>>, found: u64, job: &Job) -> Result<()> {
    let header = reader.headers().first().ok_or_else(|| Error::invalid("the EXR file holds no picture"))?;
    if header.deep {
        return Err(Error::unsupported("the EXR file holds deep data: flatten it first"));
    }
    let channels = &header.channels.list;
    if let Some(channel) = channels.iter().find(|channel| channel.sampling != Vec2(1, 1)) {
        return Err(Error::unsupported(format!(
            "the EXR channel '{}' is stored at a lower resolution: expected full resolution",
            channel.name
        )));
    }
    // The samples of the decoder and ours are held at the same time.
    let stored = |kind: SampleType| if kind == SampleType::F16 { 2 } else { 4 };
    let bytes_per_texel: u64 = channels.iter().map(|channel| 4 + stored(channel.sample_type)).sum();
    let size = Size::new(header.layer_size.width(), header.layer_size.height());
    job.check("the EXR picture", size, bytes_per_texel)?;
    // Eight bytes in the table of offsets for each block, and what compression by itself bounds.
    plausible::check("EXR", size, 8 * header.chunk_count as u64, found, 1)?;
    let samples: u64 = channels.iter().map(|channel| stored(channel.sample_type)).sum();
    let needed = size.texels() as u64 * samples;
    match header.compression {
        Compression::Uncompressed | Compression::RLE | Compression::ZIP1 | Compression::ZIP16 => {
            plausible::check("EXR", size, needed, found, plausible::DEFLATE)
        }
        _ => Ok(()),
    }
}

fn append(out: &mut Vec<f32>, samples: &FlatSamples) {
    match samples {
        FlatSamples::F16(s) => out.extend(s.iter().map(|v| v.to_f32())),
        FlatSamples::F32(s) => out.extend_from_slice(s),
        FlatSamples::U32(s) => out.extend(s.iter().map(|&v| v as f32)),
    }
}

/// The names of the channels of the first part of a file and its non-standard text attributes, without its
/// samples.
pub(in crate::format) fn head(bytes: &[u8]) -> Result<(Vec<String>, BTreeMap<String, String>)> {
    let reader = ::exr::block::read(Cursor::new(bytes), false).map_err(unreadable)?;
    let header = reader.headers().first().ok_or_else(|| Error::invalid("the EXR file holds no picture"))?;
    let names = header.channels.list.iter().map(|channel| channel.name.to_string()).collect();
    Ok((names, texts(&header.own_attributes)))
}

fn texts(attributes: &LayerAttributes) -> BTreeMap<String, String> {
    let texts = attributes.other.iter().filter_map(|(name, value)| match value {
        AttributeValue::Text(text) => Some((name.to_string(), text.to_string())),
        _ => None,
    });
    texts.collect()
}

fn unreadable(error: ::exr::error::Error) -> Error {
    match error {
        ::exr::error::Error::NotSupported(_) => Error::unsupported(
            "the EXR data is stored in a way that is not read (deep, or by a rare compression): export one flat \
             layer with ZIP compression",
        ),
        _ => damaged(Kind::Exr),
    }
}
