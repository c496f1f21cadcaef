//! Applying a source map to anything registered with the exemplars.

use super::source_map::SourceMap;
use crate::error::{Error, Result};
use crate::field::{Domain, IndexSpace, Metric, ReflectanceField};
use crate::job::Job;
use crate::parallel;
use crate::planes::Planes;
use crate::size::Size;

/// The output of a map applied to fields, one for each exemplar of the map and of the same size.
///
/// Copied texels keep their coefficients bit by bit. Blended ones are the weighted sum of the functions; if
/// those are a luminance times a colour, the product nearest to the sum, by the distance over the hemisphere.
///
/// # Errors
/// When the fields are not registered with the exemplars or not of one kind, or the output exceeds
/// the limits.
pub fn gather(map: &SourceMap, fields: &[&ReflectanceField], job: &Job) -> Result<ReflectanceField> {
    let first = check(map, fields)?;
    let planes: Vec<&Planes> = fields.iter().map(|field| field.coefficients()).collect();
    let mut output = copied(map, &planes, job)?;
    if map.mix_count() > 0 {
        place(map, &blend(map, fields, job)?, &mut output);
    }
    first.with_coefficients(output)
}

/// The index planes of the output of a map, from those of its exemplars; blended texels are weighted sums.
///
/// # Errors
/// When the planes are not registered with the exemplars, or the output exceeds the limits.
pub fn gather_index(map: &SourceMap, index: &[&Planes], job: &Job) -> Result<Planes> {
    let sizes = index.iter().map(|planes| planes.size());
    if index.is_empty() || !sizes.eq(map.exemplars().iter().copied()) {
        return Err(Error::usage("index planes are gathered by a map of exemplars of other sizes"));
    }
    let mut output = copied(map, index, job)?;
    if map.mix_count() > 0 {
        place(map, &weighted_sums(map, index), &mut output);
    }
    Ok(output)
}

/// The planes of the dominant source of every texel.
fn copied(map: &SourceMap, planes: &[&Planes], job: &Job) -> Result<Planes> {
    let mut output = Planes::zeros_within(job, "the synthesised field", map.size(), planes[0].count())?;
    parallel::for_each(
        output.as_mut_slice().chunks_exact_mut(map.size().texels()).enumerate(),
        |(k, plane)| {
            for (value, from) in plane.iter_mut().zip(map.copies()) {
                *value = planes[from.exemplar as usize].at(k, from.x as usize, from.y as usize);
            }
        },
    );
    Ok(output)
}

/// Puts the blended texels into their places.
fn place(map: &SourceMap, blended: &Planes, output: &mut Planes) {
    for (k, plane) in output.iter_mut().enumerate() {
        map.mixes().zip(blended.plane(k)).for_each(|((texel, _), value)| plane[texel] = *value);
    }
}

/// Checks that fields match a map and each other, and returns the first.
fn check<'a>(map: &SourceMap, fields: &[&'a ReflectanceField]) -> Result<&'a ReflectanceField> {
    if fields.len() != map.exemplars().len() {
        return Err(Error::usage(format!(
            "the source map was made from {} exemplars, found {} fields to apply it to",
            map.exemplars().len(),
            fields.len()
        )));
    }
    let first = *fields.first().ok_or_else(|| Error::usage("a source map needs a field to be applied to"))?;
    for (number, (field, size)) in fields.iter().zip(map.exemplars()).enumerate() {
        if field.size() != *size {
            return Err(Error::usage(format!(
                "the field that the source map is applied to has {} texels, exemplar {} has {size}: they must be \
                 registered, texel by texel",
                field.size(),
                number + 1
            )));
        }
        let same = first.check_kind(field, "the first");
        same.map_err(|e| Error::usage(format!("field {} {e}", number + 1)))?;
    }
    Ok(first)
}

/// The coefficients of the blended texels alone, in their order, as planes of one row.
fn blend(map: &SourceMap, fields: &[&ReflectanceField], job: &Job) -> Result<Planes> {
    if !fields[0].layout().is_product() {
        let planes: Vec<&Planes> = fields.iter().map(|field| field.coefficients()).collect();
        return Ok(weighted_sums(map, &planes));
    }
    let space = IndexSpace::new(fields[0], Metric::Function, Domain::Hemisphere)?;
    let texels: usize = fields.iter().map(|field| field.size().texels()).sum();
    // Index planes of the fields; of the blended texels those, their coefficients, and a copy of these.
    let blended = space.planes() + 2 * fields[0].coefficients().count();
    const WHAT: &str = "blending functions";
    job.check_bytes(WHAT, 4 * (texels * space.planes() + map.mix_count() * blended) as u64)?;
    let index = fields.iter().map(|field| space.index_planes_within(field, job, WHAT));
    let index: Vec<Planes> = index.collect::<Result<_>>()?;
    let sums = weighted_sums(map, &index.iter().collect::<Vec<_>>());
    Ok(space.field(fields[0], &sums)?.coefficients().clone())
}

/// The weighted sum of the shares of each blended texel.
fn weighted_sums(map: &SourceMap, exemplars: &[&Planes]) -> Planes {
    let size = Size::new(map.mix_count(), 1);
    let mut sums = Planes::zeros(size, exemplars[0].count());
    parallel::for_each(sums.as_mut_slice().chunks_exact_mut(size.width).enumerate(), |(k, plane)| {
        for (sum, (_, parts)) in plane.iter_mut().zip(map.mixes()) {
            let value = |part: &super::Part| {
                let from = part.source;
                let value = exemplars[from.exemplar as usize].at(k, from.x as usize, from.y as usize);
                f64::from(part.weight) * f64::from(value)
            };
            *sum = parts.iter().map(value).sum::<f64>() as f32;
        }
    });
    sums
}
