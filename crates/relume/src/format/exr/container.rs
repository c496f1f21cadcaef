//! Named planes in an EXR file.

use std::collections::BTreeMap;
use std::io::Cursor;

use super::ExrDepth;
use super::blocks::{Head, write_samples};
use super::codec::write_blocks;
use super::count_clipped;
use crate::error::{Error, Result};
use crate::job::Job;
use crate::memory;
use crate::planes::Planes;

/// Room for a usual head of a file.
const HEAD_BYTES: usize = 1 << 14;

/// The first part of an EXR file.
#[derive(Debug, Clone)]
pub(super) struct Layer {
    /// A name for each plane, in the alphabetical order of the file.
    pub names: Vec<String>,
    pub planes: Planes,
    /// Half if every channel is half.
    pub depth: ExrDepth,
    /// Text attributes that are not part of the standard.
    pub attributes: BTreeMap<String, String>,
}

/// The bytes of a file with a channel for each plane, and text attributes.
pub(super) fn encode(
    names: &[String],
    planes: &Planes,
    depth: ExrDepth,
    texts: &[(&str, String)],
    job: &Job,
) -> Result<Vec<u8>> {
    check_names(names, planes.count())?;
    let mut order: Vec<usize> = (0..names.len()).collect();
    order.sort_by(|&a, &b| names[a].cmp(&names[b]));
    let sorted: Vec<String> = order.iter().map(|&k| names[k].clone()).collect();
    let width = planes.size().width;
    let mut rows = |channel: usize, _: usize, y: usize, row: &mut [u8]| {
        job.proceed()?;
        write_samples(&planes.plane(order[channel])[y * width..][..width], depth, row);
        Ok(())
    };
    let footprint = depth.footprint(planes.size(), planes.count() as u64);
    job.check_bytes("writing the EXR file", footprint.peak)?;
    count_clipped(planes, depth, job);
    // What compression cannot shorten is stored as it is.
    let file = memory::with_capacity("the EXR file", footprint.kept as usize + HEAD_BYTES)?;
    let mut out = Cursor::new(file);
    let head = Head { names: sorted, depth, texts: texts.to_vec(), tile: None };
    write_blocks(&head, planes.size(), &mut out, &mut rows)?;
    Ok(out.into_inner())
}

fn check_names(names: &[String], planes: usize) -> Result<()> {
    if names.len() != planes || planes == 0 {
        return Err(Error::usage(format!("{planes} planes cannot have {} channel names", names.len())));
    }
    let repeated = names.iter().enumerate().find(|(i, name)| name.is_empty() || names[..*i].contains(name));
    match repeated {
        Some((_, name)) => Err(Error::usage(format!("the channel name '{name}' is empty or given twice"))),
        None => Ok(()),
    }
}
