//! The table of a model of clusters of photographs as bits: for each pair of light and view the cluster and how many times
//! as bright its picture is.
//!
//! A cluster is that of the light before (a bit), else that of the view before (a bit), else written; a brightness is a Rice
//! code of the difference to the light before.

use super::bits::{BitReader, BitWriter, Rice};
use super::functions::{COUNTS, read_directions, write_directions};
use crate::error::{Error, Result};
use crate::field::PackedFunctions;
use crate::job::Job;
use crate::random_field::MOST_IMAGE_CLUSTERS;
use crate::random_field::clusters::is_table;

/// Bits of the number of a cluster.
const LABEL: u32 = 8;

/// The largest brightness of a pair, in steps.
const BRIGHTEST: i32 = 1 << 12;

/// Writes a table.
///
/// # Errors
/// Functions that are no table of clusters.
pub(super) fn write_table(bits: &mut BitWriter, table: &PackedFunctions) -> Result<()> {
    if !is_table(table) {
        return Err(Error::usage("the functions of clusters are not zero at the pairs of others"));
    }
    let [lights, views] = [&table.lights, &table.views].map(Vec::len);
    for (count, width) in [lights, views].into_iter().zip(COUNTS) {
        if count >= 1 << width {
            return Err(Error::usage(format!("{count} lights or views are more than a model holds")));
        }
        bits.bits(count as u32, width);
    }
    bits.bits(table.steps.len() as u32, LABEL);
    bits.float(table.steps[0]);
    write_directions(bits, table);
    let (labels, gains) = entries(table);
    let mut rice = Rice::new();
    for pair in 0..labels.len() {
        let (light, view) = (pair % lights, pair / lights);
        let same = [
            light > 0 && labels[pair - 1] == labels[pair],
            view > 0 && labels[pair - lights] == labels[pair],
        ];
        bits.bits(u32::from(same[0]), 1);
        if !same[0] {
            bits.bits(u32::from(same[1]), 1);
            if !same[1] {
                bits.bits(labels[pair] as u32, LABEL);
            }
        }
        bits.rice(gains[pair] - if light > 0 { gains[pair - 1] } else { 0 }, &mut rice);
    }
    Ok(())
}

/// The cluster of each pair, and its brightness in steps.
fn entries(table: &PackedFunctions) -> (Vec<usize>, Vec<i32>) {
    let pairs = table.lights.len() * table.views.len();
    let mut found = (vec![0; pairs], vec![0; pairs]);
    for (k, codes) in table.codes.chunks_exact(pairs).enumerate() {
        for (pair, code) in codes.iter().enumerate().filter(|(_, code)| **code != 0) {
            (found.0[pair], found.1[pair]) = (k, *code);
        }
    }
    found
}

/// Reads a table.
///
/// # Errors
/// Bits missing, more memory than the limits allow, and numbers that are not those of a table.
pub(super) fn read_table(bits: &mut BitReader<'_>, job: &Job) -> Result<PackedFunctions> {
    let [lights, views] = [bits.bits(COUNTS[0])? as usize, bits.bits(COUNTS[1])? as usize];
    let clusters = bits.bits(LABEL)? as usize;
    let step = bits.float("step")?;
    let pairs = lights as u64 * views as u64;
    // Each takes two bits at least.
    if pairs == 0 || 2 * pairs > bits.left() as u64 || !(1..=MOST_IMAGE_CLUSTERS).contains(&clusters) {
        return Err(Error::invalid(format!(
            "a table of {clusters} clusters for {lights} lights and {views} views does not fit the {} bits that are left of \
             the model",
            bits.left()
        )));
    }
    job.check_bytes("the table of clusters", (4 * clusters as u64 + 24) * pairs)?;
    let all = read_directions(bits, lights + views)?;
    let pairs = pairs as usize;
    let (mut labels, mut gains) = (vec![0; pairs], vec![0; pairs]);
    let mut rice = Rice::new();
    for pair in 0..pairs {
        let (light, view) = (pair % lights, pair / lights);
        let known = |has: bool, at: usize| {
            if has { Ok(at) } else { Err(Error::invalid("the table of clusters begins with nothing")) }
        };
        labels[pair] = if bits.bits(1)? == 1 {
            labels[known(light > 0, pair.wrapping_sub(1))?]
        } else if bits.bits(1)? == 1 {
            labels[known(view > 0, pair.wrapping_sub(lights))?]
        } else {
            bits.bits(LABEL)? as usize
        };
        gains[pair] = if light > 0 { gains[pair - 1] } else { 0i32 }.saturating_add(bits.rice(&mut rice)?);
        if labels[pair] >= clusters || !(1..=BRIGHTEST).contains(&gains[pair]) {
            return Err(Error::invalid(format!(
                "pair {pair} of the table of clusters has the cluster {} of {clusters} at {} steps",
                labels[pair], gains[pair]
            )));
        }
    }
    let mut codes = vec![0; clusters * pairs];
    (0..pairs).for_each(|pair| codes[labels[pair] * pairs + pair] = gains[pair]);
    let (lights, views) = all.split_at(lights);
    let steps = vec![step; clusters];
    Ok(PackedFunctions { lights: lights.to_vec(), views: views.to_vec(), channels: 1, steps, codes })
}
