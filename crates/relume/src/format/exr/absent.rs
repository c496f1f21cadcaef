//! In place of reading and writing, in builds without the feature `exr`.

use std::collections::BTreeMap;
use std::io::{Read, Seek, Write};

use super::blocks::Head;
use super::container::Layer;
use crate::error::{Error, Result};
use crate::format::rows::Rows;
use crate::job::Job;
use crate::size::Size;

fn absent<T>() -> Result<T> {
    Err(Error::unsupported(
        "this build neither reads nor writes EXR files: use PNG or PTM, or build with the feature 'exr'",
    ))
}

pub(in crate::format) fn decode(_bytes: &[u8], _job: &Job) -> Result<Layer> {
    absent()
}

pub(in crate::format) fn head(_bytes: &[u8]) -> Result<(Vec<String>, BTreeMap<String, String>)> {
    absent()
}

pub(in crate::format) fn write_blocks(
    _head: &Head<'_>,
    _size: Size,
    _out: impl Read + Write + Seek,
    _rows: &mut Rows<'_>,
) -> Result<()> {
    absent()
}
