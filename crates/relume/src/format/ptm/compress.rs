//! Writing the compressed formats: planes are predicted from others where that makes them smoother, and texels that
//! the loss of JPEG carries across the border of a byte are corrected by side information.

use super::header::{Header, to_text};
use super::jpeg::CORRECTION_BYTES;
use super::prediction::{PlaneReference, residual, restore, roughness};
use crate::error::Result;
use crate::format::jpeg;
use crate::job::Job;

/// A prediction has to leave at most so much of the roughness of a plane: a residual is noisier for JPEG than the
/// same roughness in a picture.
const WORTHWHILE: f64 = 0.8;

/// Bytes that came back farther off than this have wrapped around.
const WRAPPED: u8 = 64;

/// A plane as stored.
struct Stored {
    reference: Option<PlaneReference>,
    file: Vec<u8>,
    corrections: Vec<u8>,
}

/// The compressed form of a raw file in one of the formats that have one, RGB and LRGB of version 1.2.
pub(super) fn compressed(raw: &[u8], quality: u8, job: &Job) -> Result<Vec<u8>> {
    let header = Header::parse(raw)?;
    let texels = header.size.texels();
    let plane = |k: usize| -> Vec<u8> {
        let comb = header.layout.comb(k, texels);
        raw[header.payload + comb.start..].iter().step_by(comb.stride).copied().take(texels).collect()
    };
    let planes: Vec<Vec<u8>> = (0..header.layout.planes()).map(plane).collect();
    let tree = predictions(&planes, header.size.width, job)?;
    let mut decoded: Vec<Vec<u8>> = vec![Vec::new(); planes.len()];
    let mut stored: Vec<Option<Stored>> = planes.iter().map(|_| None).collect();
    for &(k, reference) in &tree {
        job.proceed()?;
        let (part, samples) = store(&planes[k], reference, &decoded, &header, quality, job)?;
        decoded[k] = samples;
        stored[k] = Some(part);
    }
    let stored: Vec<Stored> =
        stored.into_iter().map(|part| part.expect("the tree holds every plane")).collect();
    Ok(file(&header, &tree, &stored, quality))
}

/// The planes in the order of their coding, each with what predicts it best among those before it (Prim, "Shortest
/// connection networks and some generalizations", 1957).
fn predictions(planes: &[Vec<u8>], width: usize, job: &Job) -> Result<Vec<(usize, Option<PlaneReference>)>> {
    let mut best: Vec<(u64, Option<PlaneReference>)> =
        planes.iter().map(|plane| ((roughness(plane, width) as f64 * WORTHWHILE) as u64, None)).collect();
    let mut left: Vec<usize> = (0..planes.len()).collect();
    let mut tree = Vec::with_capacity(planes.len());
    while let Some(at) = (0..left.len()).min_by_key(|&i| best[left[i]].0) {
        job.proceed()?;
        let k = left.remove(at);
        tree.push((k, best[k].1));
        for &other in &left {
            for is_inverted in [false, true] {
                let cost = roughness(&residual(&planes[other], &planes[k], is_inverted), width);
                if cost < best[other].0 {
                    best[other] = (cost, Some(PlaneReference { plane: k, is_inverted }));
                }
            }
        }
    }
    Ok(tree)
}

/// Stores a plane, and the plane as a reader finds it.
fn store(
    plane: &[u8],
    reference: Option<PlaneReference>,
    decoded: &[Vec<u8>],
    header: &Header,
    quality: u8,
    job: &Job,
) -> Result<(Stored, Vec<u8>)> {
    let from = reference.map(|r| (&decoded[r.plane], r.is_inverted));
    let left = from.map_or_else(|| plane.to_vec(), |(from, inverted)| residual(plane, from, inverted));
    let file = jpeg::encode(&left, header.size, 1, quality)?;
    let mut samples = jpeg::decode(&file, job)?.samples;
    let mut corrections = Vec::new();
    if let Some((from, inverted)) = from {
        restore(&mut samples, from, inverted);
        for (at, (sample, &byte)) in samples.iter_mut().zip(plane).enumerate() {
            if sample.abs_diff(byte) > WRAPPED {
                *sample = byte;
                corrections.extend((at as u32).to_be_bytes());
                corrections.push(byte);
            }
        }
    }
    debug_assert!(corrections.len().is_multiple_of(CORRECTION_BYTES));
    Ok((Stored { reference, file, corrections }, samples))
}

fn file(
    header: &Header,
    tree: &[(usize, Option<PlaneReference>)],
    stored: &[Stored],
    quality: u8,
) -> Vec<u8> {
    let line = |number: &dyn Fn(usize) -> i64| {
        let numbers: Vec<String> = (0..stored.len()).map(|k| number(k).to_string()).collect();
        numbers.join(" ") + "\n"
    };
    let place = |k: usize| tree.iter().position(|&(plane, _)| plane == k).unwrap_or_default() as i64;
    let format = if stored.len() == 18 { "PTM_FORMAT_JPEG_RGB" } else { "PTM_FORMAT_JPEG_LRGB" };
    let mut text = to_text(format, header.size, &header.encoding);
    text += &format!("{quality}\n");
    text += &line(&|k| i64::from(stored[k].reference.is_some_and(|r| r.is_inverted)));
    text += &line(&|_| 0);
    text += &line(&|_| 0);
    text += &line(&place);
    text += &line(&|k| stored[k].reference.map_or(-1, |r| r.plane as i64));
    text += &line(&|k| stored[k].file.len() as i64);
    text += &line(&|k| stored[k].corrections.len() as i64);
    let parts = stored.iter().flat_map(|part| [&part.file[..], &part.corrections]);
    [text.as_bytes()].into_iter().chain(parts).collect::<Vec<_>>().concat()
}
