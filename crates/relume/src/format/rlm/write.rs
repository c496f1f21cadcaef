//! A model as bytes.

use super::bits::{BitWriter, Rice};
use super::functions::write_functions;
use super::table::write_table;
use super::{Edition, HEADER, MOST_CANDIDATES, SIGNATURE, VERSIONS, WITH_LOCAL_DETAIL, checksum, structure};
use crate::error::{Error, Result};
use crate::field::{Basis, PlaneLayout};
use crate::random_field::conditional::Conditional;
use crate::random_field::joint_color::JointColor;
use crate::random_field::level::Level;
use crate::random_field::local_gain::LocalGain;
use crate::random_field::marginal::Marginal;
use crate::random_field::neighbourhood::{Offset, all_around, causal};
use crate::random_field::stability::BURN_INS;
use crate::random_field::{FieldModel, Fields, LightModel, Model, PhotographClusters, Structure};

/// The bytes of the file of a model.
///
/// # Errors
/// A model of learned functions that are not [packed](crate::field::PackedFunctions), or of named channels; a neighbourhood larger than the file can represent, which
/// no fitted model has.
pub fn encode(field: &FieldModel) -> Result<Vec<u8>> {
    check_kind(&field.basis, &field.layout)?;
    let mut bits = BitWriter::default();
    for name in [field.basis.name(), field.layout.name(), &field.space.to_string()] {
        bits.bits(name.len() as u32, 8);
        name.bytes().for_each(|byte| bits.bits(u32::from(byte), 8));
    }
    let source = &field.source;
    for number in [source.width, source.height, source.photographs, source.channels] {
        bits.bits(number, 32);
    }
    let edition @ Edition { version, .. } = edition(field);
    if let Basis::Learned(learned) = &field.basis {
        let packed =
            learned.packed().ok_or_else(|| Error::usage("the functions of the model are not packed"))?;
        match &field.fields {
            Fields::Clusters(_) => write_table(&mut bits, packed)?,
            Fields::Joint(_) | Fields::PerLight(_) => write_functions(&mut bits, packed)?,
        }
    }
    if let Fields::Clusters(clusters) = &field.fields {
        write_clusters(&mut bits, clusters, edition)?;
        return Ok(with_header(edition, &bits.into_bytes()));
    }
    if version >= VERSIONS[2] {
        write_kind(&mut bits, field);
    }
    for (_, model) in field.fields.models() {
        write_model(&mut bits, model, edition)?;
    }
    if let Fields::Joint(model) = &field.fields {
        if version >= VERSIONS[2] {
            bits.bits(u32::from(model.structure.is_some()), 1);
        }
        model.structure.as_ref().map_or(Ok(()), |structure| write_structure(&mut bits, structure))?;
    }
    Ok(with_header(edition, &bits.into_bytes()))
}

/// Refuses models of textures that the file cannot describe.
///
/// # Errors
/// Channels that form no grey or colour.
pub fn check_kind(basis: &Basis, layout: &PlaneLayout) -> Result<()> {
    if layout.is_named() {
        return Err(Error::unsupported(format!(
            "a .rlm file holds models of luminance or colour, not of {} {}",
            layout.name(),
            basis.name()
        )));
    }
    Ok(())
}

/// The lowest edition that can hold a model.
fn edition(field: &FieldModel) -> Edition {
    let range = match &field.fields {
        Fields::Clusters(clusters) => clusters.range.as_deref(),
        Fields::Joint(_) | Fields::PerLight(_) => None,
    };
    let models = field.fields.models().into_iter().map(|(_, model)| model);
    Edition { version: version(field), has_local_detail: models.chain(range).any(Model::has_local_detail) }
}

/// The lowest version that can hold a model.
fn version(field: &FieldModel) -> u8 {
    if let Fields::Clusters(_) = &field.fields {
        return VERSIONS[5];
    }
    if matches!(field.basis, Basis::Learned(_)) {
        return VERSIONS[4];
    }
    if field.fields.models().iter().any(|(_, model)| model.color.is_some()) {
        return VERSIONS[3];
    }
    match &field.fields {
        Fields::Joint(model) if field.heights.is_none() => VERSIONS[usize::from(model.structure.is_some())],
        _ => VERSIONS[2],
    }
}

/// The meaning of the values, and the lights.
fn write_kind(bits: &mut BitWriter, field: &FieldModel) {
    let size = field.heights.map(|heights| heights.mm_per_texel);
    bits.bits(
        match size {
            None => 0,
            Some(None) => 1,
            Some(Some(_)) => 2,
        },
        2,
    );
    if let Some(Some(mm)) = size {
        let number = mm.to_bits();
        [(number >> 32) as u32, number as u32].iter().for_each(|&half| bits.bits(half, 32));
    }
    let lights: &[LightModel] = if let Fields::PerLight(lights) = &field.fields { lights } else { &[] };
    bits.bits(lights.len() as u32, 8);
    lights.iter().flat_map(|light| light.disk).for_each(|number| bits.float(number));
}

/// A model for each cluster, and the range map with its structure.
fn write_clusters(bits: &mut BitWriter, clusters: &PhotographClusters, edition: Edition) -> Result<()> {
    clusters.models.iter().try_for_each(|model| write_model(bits, model, edition))?;
    bits.bits(u32::from(clusters.range.is_some()), 1);
    let Some(range) = &clusters.range else { return Ok(()) };
    write_model(bits, range, edition)?;
    bits.bits(u32::from(range.structure.is_some()), 1);
    range.structure.as_ref().map_or(Ok(()), |structure| write_structure(bits, structure))
}

fn write_model(bits: &mut BitWriter, model: &Model, edition: Edition) -> Result<()> {
    let Edition { version, has_local_detail } = edition;
    bits.bits(model.planes() as u32, 16);
    bits.bits(model.kernel.factor() as u32, 8);
    bits.bits(model.levels.len() as u32, 8);
    model.mixing.own.iter().for_each(|&own| bits.bits(u32::from(own), 1));
    model.mixing.weights.iter().for_each(|&weight| bits.float(weight));
    model.gains.iter().for_each(|&gain| bits.half(gain));
    if version >= VERSIONS[3] {
        write_color(bits, model.color.as_ref());
    }
    model.marginals.iter().for_each(|marginal| write_marginal(bits, marginal));
    model.levels.iter().try_for_each(|level| write_level(bits, level))?;
    if has_local_detail {
        for level in &model.levels {
            bits.bits(u32::from(level.unevenness), 8);
            write_gain(bits, level.gain.as_ref());
        }
    }
    Ok(())
}

fn with_header(edition: Edition, body: &[u8]) -> Vec<u8> {
    let version = edition.version + if edition.has_local_detail { WITH_LOCAL_DETAIL } else { 0 };
    let length = (body.len() as u32).to_le_bytes();
    let sum = checksum(&[&length[..], body].concat()).to_le_bytes();
    let mut bytes = Vec::with_capacity(HEADER + body.len());
    for part in [&SIGNATURE[..], &[version], &sum, &length, body] {
        bytes.extend_from_slice(part);
    }
    bytes
}

fn write_marginal(bits: &mut BitWriter, marginal: &Marginal) {
    match marginal {
        Marginal::Normal { mean, deviation } => {
            bits.bits(0, 1);
            bits.float(*mean);
            bits.float(*deviation);
        }
        Marginal::Curve { low, high, codes } => {
            bits.bits(1, 1);
            bits.float(*low);
            bits.float(*high);
            let mut rice = Rice::new();
            for pair in codes.windows(2) {
                bits.rice(i32::from(pair[1]) - i32::from(pair[0]), &mut rice);
            }
        }
    }
}

fn write_color(bits: &mut BitWriter, color: Option<&JointColor>) {
    bits.bits(u32::from(color.is_some()), 1);
    let Some(color) = color else { return };
    bits.bits(color.first as u32, 16);
    write_marginal(bits, &color.lightness);
    for opponent in &color.opponents {
        bits.float(opponent.low);
        bits.float(opponent.high);
        let [_, knots] = Conditional::grid(opponent.parents);
        // The lowest quantiles of neighbouring nodes are alike, and so are the steps between quantiles.
        let (mut across, mut up, mut before) = (Rice::new(), Rice::new(), 0);
        for (i, code) in opponent.codes.iter().map(|&code| i32::from(code)).enumerate() {
            if i % knots == 0 {
                let first = if i == 0 { 0 } else { i32::from(opponent.codes[i - knots]) };
                bits.rice(code - first, &mut across);
            } else {
                bits.rice(code - before, &mut up);
            }
            before = code;
        }
    }
}

fn write_level(bits: &mut BitWriter, level: &Level) -> Result<()> {
    let margin = BURN_INS.iter().position(|&texels| texels == level.burn_in);
    let margin = margin.ok_or_else(|| Error::usage("a file cannot hold the margin of this level"))?;
    bits.bits(margin as u32, 3);
    bits.float(level.log_evidence);
    bits.bits(level.texels, 32);
    write_mask(bits, &level.neighbours, causal)?;
    write_mask(bits, &level.coarse, all_around)?;
    level.noise.iter().for_each(|&number| bits.float(number));
    level.weights.rows.iter().chain(&level.weights.columns).for_each(|&step| bits.half(step));
    let m = level.planes();
    // The past of a plane itself differs statistically from that of the others.
    let (mut own, mut other) = (Rice::new(), Rice::new());
    for (i, &code) in level.weights.codes.iter().enumerate() {
        bits.rice(code, if i / m % m == i % m { &mut own } else { &mut other });
    }
    Ok(())
}

fn write_gain(bits: &mut BitWriter, gain: Option<&LocalGain>) {
    bits.bits(u32::from(gain.is_some()), 1);
    let Some(gain) = gain else { return };
    bits.half(gain.deviation);
    bits.half(gain.gradient);
    let (mut steps, mut before) = (Rice::new(), i32::from(LocalGain::ONE));
    for code in gain.codes.map(i32::from) {
        bits.rice(code - before, &mut steps);
        before = code;
    }
}

fn write_structure(bits: &mut BitWriter, of: &Structure) -> Result<()> {
    let numbers = [of.tile.width, of.tile.height, of.tiles].map(u16::try_from);
    let [Ok(width), Ok(height), Ok(tiles)] = numbers else {
        return Err(Error::usage(format!(
            "{} tiles of {} are more than a model can hold: sides and number are at most 65535",
            of.tiles, of.tile
        )));
    };
    [width, height, tiles].iter().for_each(|&number| bits.bits(u32::from(number), 16));
    bits.bits(of.scales as u32, 4);
    of.steps.iter().for_each(|&step| bits.half(step));
    let codes = structure::encode(of);
    bits.bits(codes.len() as u32, 32);
    codes.iter().for_each(|&byte| bits.bits(u32::from(byte), 8));
    Ok(())
}

/// Which of the first `count` neighbours are present.
fn write_mask(bits: &mut BitWriter, offsets: &[Offset], family: fn(usize) -> Vec<Offset>) -> Result<()> {
    let all = family(MOST_CANDIDATES);
    let last = offsets.last().map_or(Some(0), |last| all.iter().position(|o| o == last).map(|i| i + 1));
    let in_order = |n: usize| all[..n].iter().filter(|o| offsets.contains(o)).eq(offsets);
    let count = last.filter(|&n| in_order(n)).ok_or_else(|| {
        Error::usage(format!(
            "a neighbourhood is not made of the nearest {MOST_CANDIDATES} neighbours in order"
        ))
    })?;
    bits.bits(count as u32, 9);
    all[..count].iter().for_each(|o| bits.bits(u32::from(offsets.contains(o)), 1));
    Ok(())
}
