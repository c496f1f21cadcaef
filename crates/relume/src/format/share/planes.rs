//! The coefficient planes of a shared texture: codes of 8 bits where those of a file are kept exactly or were asked
//! for, half floats (11 significant bits) otherwise.

use flate2::Compression;
use flate2::write::GzEncoder;
use half::f16;
use std::io::Write;

use super::header::{PlaneGroup, PlaneStorage};
use crate::error::Result;
use crate::field::{PlaneRole, ReflectanceField};
use crate::format::{Depth, Encoding, PictureFormat, encode_picture_with};
use crate::job::Job;
use crate::names::named;
use crate::picture::Picture;
use crate::planes::Planes;
use crate::space::Space;

/// Planes of a file: red, green and blue of a PNG.
const TOGETHER: usize = 3;

/// The storage asked for.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum PlaneDepth {
    /// The codes of files of 8 bits as they are, anything else as half floats.
    #[default]
    Kept,
    /// 8 bits between the least and the greatest coefficient of each plane.
    Eight,
    /// Half floats.
    Half,
}

named!(PlaneDepth { Kept => "kept", Eight => "8", Half => "half" });

/// The planes of a field, stored.
#[derive(Debug)]
pub(super) struct SharedPlanes {
    pub groups: Vec<PlaneGroup>,
    pub files: Vec<(String, Vec<u8>)>,
    /// The largest difference from the field.
    pub error: f32,
}

/// The value of code 0 and the difference between codes.
#[derive(Debug, Clone, Copy)]
pub(super) struct LinearCodes {
    pub scale: f32,
    pub offset: f32,
}

impl LinearCodes {
    /// Those from the least to the greatest value.
    pub fn between((low, high): (f32, f32)) -> Self {
        Self { scale: ((high - low) / 255.0).max(f32::MIN_POSITIVE), offset: low }
    }

    pub fn code(self, value: f32) -> f32 {
        ((value - self.offset) / self.scale).round().clamp(0.0, 255.0)
    }

    pub fn value(self, code: f32) -> f32 {
        self.scale * code + self.offset
    }
}

impl SharedPlanes {
    /// The coefficients of a field.
    pub fn new(field: &ReflectanceField, stored: &Encoding, depth: PlaneDepth, job: &Job) -> Result<Self> {
        Self::of(field.coefficients(), |k| steps(field, k, stored, depth), job)
    }

    /// Planes of values from -`most` to `most`: as codes of that range, unless half floats are asked for.
    pub fn symmetric(planes: &Planes, most: f32, depth: PlaneDepth, job: &Job) -> Result<Self> {
        let steps = LinearCodes { scale: 2.0 * most / 255.0, offset: -most };
        Self::of(planes, |_| (depth != PlaneDepth::Half).then_some(steps), job)
    }

    fn of(planes: &Planes, steps: impl Fn(usize) -> Option<LinearCodes>, job: &Job) -> Result<Self> {
        let count = planes.count();
        job.check("the shared planes", planes.size(), 16 * TOGETHER as u64)?;
        let mut made = Self { groups: Vec::new(), files: Vec::new(), error: 0.0 };
        job.start("storing planes", count as u64);
        for first in (0..count).step_by(TOGETHER) {
            let some = first..(first + TOGETHER).min(count);
            let steps: Option<Vec<LinearCodes>> = some.clone().map(&steps).collect();
            match steps {
                // A PNG has one channel or three.
                Some(steps) if steps.len() == TOGETHER => made.add_codes(planes, first, &steps, job)?,
                Some(steps) => {
                    for (k, step) in some.clone().zip(steps) {
                        made.add_codes(planes, k, &[step], job)?;
                    }
                }
                None => made.add_halves(planes, first, some.len()),
            }
            job.advance(some.len() as u64)?;
        }
        Ok(made)
    }

    fn add_codes(&mut self, planes: &Planes, first: usize, steps: &[LinearCodes], job: &Job) -> Result<()> {
        let mut codes = Planes::zeros(planes.size(), steps.len());
        for (k, (step, plane)) in steps.iter().zip(codes.iter_mut()).enumerate() {
            for (code, &value) in plane.iter_mut().zip(planes.plane(first + k)) {
                let nearest = step.code(value);
                self.error = self.error.max((step.value(nearest) - value).abs());
                *code = nearest / 255.0;
            }
        }
        let file = format!("planes-{first}.png");
        self.files.push((file.clone(), encode_codes(&codes, job)?));
        self.groups.push(PlaneGroup {
            file,
            storage: PlaneStorage::Png,
            first,
            count: steps.len(),
            scale: steps.iter().map(|s| s.scale).collect(),
            offset: steps.iter().map(|s| s.offset).collect(),
        });
        Ok(())
    }

    fn add_halves(&mut self, planes: &Planes, first: usize, count: usize) {
        let texels = planes.size().texels();
        let values = &planes.as_slice()[first * texels..][..count * texels];
        let error = |&v: &f32| (f16::from_f32(v).to_f32() - v).abs();
        self.error = values.iter().map(error).fold(self.error, f32::max);
        let file = format!("planes-{first}.f16.gz");
        self.files.push((file.clone(), halves(values)));
        let (scale, offset) = (Vec::new(), Vec::new());
        self.groups.push(PlaneGroup { file, storage: PlaneStorage::Half, first, count, scale, offset });
    }
}

/// The codes that hold plane `k`; `None` for half floats.
pub(super) fn steps(
    field: &ReflectanceField,
    k: usize,
    stored: &Encoding,
    depth: PlaneDepth,
) -> Option<LinearCodes> {
    let unit = LinearCodes { scale: 1.0 / 255.0, offset: 0.0 };
    match (depth, stored) {
        (PlaneDepth::Half, _) => None,
        (PlaneDepth::Eight, _) => Some(LinearCodes::between(field.coefficients().range(k))),
        (PlaneDepth::Kept, Encoding::Ptm(encoding)) => {
            Some(match field.layout().roles(field.basis().len())[k] {
                PlaneRole::Coefficient { function, .. } | PlaneRole::Shared { function } => {
                    let scale = encoding.scale[function] / 255.0;
                    LinearCodes { scale, offset: -encoding.bias[function] * scale }
                }
                PlaneRole::Color { .. } => unit,
            })
        }
        (PlaneDepth::Kept, Encoding::Picture(Depth::Eight)) => Some(unit),
        (PlaneDepth::Kept, _) => None,
    }
}

/// One or three planes from 0 to 1 as a PNG of 8 bits.
pub(super) fn encode_codes(planes: &Planes, job: &Job) -> Result<Vec<u8>> {
    let picture = Picture { planes: planes.clone(), space: Space::Srgb };
    encode_picture_with(&picture, PictureFormat::Png(Depth::Eight), job)
}

/// Values as compressed half floats.
pub(super) fn halves(values: &[f32]) -> Vec<u8> {
    let bytes: Vec<u8> = values.iter().flat_map(|&v| f16::from_f32(v).to_le_bytes()).collect();
    compressed(&bytes)
}

/// Values as compressed single-precision floats.
pub(super) fn floats<'a>(values: impl IntoIterator<Item = &'a f32>) -> Vec<u8> {
    let bytes: Vec<u8> = values.into_iter().flat_map(|v| v.to_le_bytes()).collect();
    compressed(&bytes)
}

/// As a gzip file (RFC 1952), quickly: halves of photographs hardly compress.
pub(super) fn compressed(bytes: &[u8]) -> Vec<u8> {
    let mut encoder = GzEncoder::new(Vec::new(), Compression::fast());
    encoder.write_all(bytes).and_then(|()| encoder.finish()).expect("memory takes all bytes")
}
