//! A model from bytes.

use super::bits::{BitReader, Rice};
use super::functions::read_functions;
use super::table::read_table;
use super::{Edition, HEADER, SIGNATURE, VERSIONS, WITH_LOCAL_DETAIL, checksum, structure};
use crate::error::{Error, Result};
use crate::field::{Basis, PlaneLayout};
use crate::job::Job;
use crate::names::Named;
use crate::numeric::pyramid::Kernel;
use crate::random_field::conditional::{CODES, Conditional};
use crate::random_field::joint_color::JointColor;
use crate::random_field::level::{Level, MAX_CODE, Weights};
use crate::random_field::local_gain::{LocalGain, NODES};
use crate::random_field::marginal::{KNOTS, Marginal, STEPS};
use crate::random_field::mixing::Mixing;
use crate::random_field::neighbourhood::{Offset, all_around, causal};
use crate::random_field::stability::BURN_INS;
use crate::random_field::structure::MOST_SCALES;
use crate::random_field::{
    FieldModel, Fields, Heights, LightModel, Model, ModelSource, PhotographClusters, Structure,
};
use crate::size::Size;
use crate::space::Space;

/// The model in the bytes of a file.
///
/// # Errors
/// Another kind or version of file; bytes missing, altered or too many; numbers that are not a valid model;
/// more memory than the limits allow.
pub fn decode(bytes: &[u8], job: &Job) -> Result<FieldModel> {
    let mut bits = BitReader::new(body(bytes)?);
    let edition @ Edition { version, .. } = edition(bytes[4]);
    // Of learned functions only the place is known yet.
    let named = |name: &str| match name {
        LEARNED if version >= VERSIONS[4] => Some(None),
        other => Basis::from_name(other).map(Some),
    };
    let basis = name(&mut bits, "basis", named)?;
    let layout = name(&mut bits, "colour model", layout_of_name)?;
    let space = name(&mut bits, "space", Space::from_name)?;
    let mut number = || bits.bits(32);
    let (width, height, photographs, channels) = (number()?, number()?, number()?, number()?);
    let source = ModelSource { width, height, photographs, channels };
    let basis = match basis {
        Some(basis) if version < VERSIONS[4] => basis,
        Some(basis) => {
            return Err(Error::invalid(format!(
                "a model of version {version} has learned functions, and this one has the basis {}",
                basis.name()
            )));
        }
        None if version == VERSIONS[5] => Basis::Learned(read_table(&mut bits, job)?.unpacked()?),
        None => Basis::Learned(read_functions(&mut bits, job)?.unpacked()?),
    };
    if version == VERSIONS[5] {
        let fields = Fields::Clusters(read_clusters(&mut bits, basis.len(), edition, job)?);
        return whole(FieldModel { basis, layout, space, source, heights: None, fields }, bits.left());
    }
    let kind = if version >= VERSIONS[2] { read_kind(&mut bits)? } else { ModelKind::default() };
    let mut fields = read_fields(&mut bits, edition, &kind.lights, job)?;
    if let Fields::Joint(model) = &mut fields {
        let has_structure = version == VERSIONS[1] || version >= VERSIONS[2] && bits.bits(1)? == 1;
        if has_structure {
            model.structure = Some(read_structure(&mut bits, model.mixing.components(), edition, job)?);
        }
    }
    let field =
        whole(FieldModel { basis, layout, space, source, heights: kind.heights, fields }, bits.left())?;
    if kind.heights.is_some() && (&field.basis, &field.layout) != (&Basis::Constant, &PlaneLayout::LUMINANCE)
    {
        return Err(Error::invalid(
            "the model's values are heights, and it has more than one plane of constants",
        ));
    }
    Ok(field)
}

/// A model whose parts fit, with nothing after it.
fn whole(field: FieldModel, left: usize) -> Result<FieldModel> {
    if left >= 8 {
        return Err(Error::invalid(format!("{left} bits follow the model's last number")));
    }
    if !field.is_whole() {
        let models = field.fields.models();
        return Err(Error::invalid(format!(
            "{} models, the first of {} planes, do not make a {} field of basis {}",
            models.len(),
            models[0].1.planes(),
            field.layout.name(),
            field.basis.name()
        )));
    }
    Ok(field)
}

/// A model for each cluster, and the range map with its structure.
fn read_clusters(
    bits: &mut BitReader<'_>,
    clusters: usize,
    edition: Edition,
    job: &Job,
) -> Result<PhotographClusters> {
    let models = (0..clusters).map(|_| read_model(bits, edition, job)).collect::<Result<Vec<Model>>>()?;
    if bits.bits(1)? == 0 {
        return Ok(PhotographClusters { models, range: None });
    }
    let mut range = read_model(bits, edition, job)?;
    if bits.bits(1)? == 1 {
        range.structure = Some(read_structure(bits, range.mixing.components(), edition, job)?);
    }
    Ok(PhotographClusters { models, range: Some(Box::new(range)) })
}

/// The meaning of the values, and the lights in the unit disk; none for a joint model.
#[derive(Default)]
struct ModelKind {
    heights: Option<Heights>,
    lights: Vec<[f32; 2]>,
}

fn read_kind(bits: &mut BitReader<'_>) -> Result<ModelKind> {
    let heights = match bits.bits(2)? {
        0 => None,
        1 => Some(Heights { mm_per_texel: None }),
        2 => {
            let mm = f64::from_bits(u64::from(bits.bits(32)?) << 32 | u64::from(bits.bits(32)?));
            if !(mm > 0.0 && mm.is_finite()) {
                return Err(Error::invalid(format!(
                    "the model's texels measure {mm} mm: expected more than 0"
                )));
            }
            Some(Heights { mm_per_texel: Some(mm) })
        }
        other => {
            return Err(Error::invalid(format!("the values of the model have the unknown kind {other}")));
        }
    };
    let count = bits.bits(8)?;
    let lights =
        (0..count).map(|_| Ok([bits.float("light")?, bits.float("light")?])).collect::<Result<_>>()?;
    Ok(ModelKind { heights, lights })
}

fn read_fields(bits: &mut BitReader<'_>, edition: Edition, lights: &[[f32; 2]], job: &Job) -> Result<Fields> {
    if lights.is_empty() {
        return Ok(Fields::Joint(Box::new(read_model(bits, edition, job)?)));
    }
    let model = |&disk: &[f32; 2]| Ok(LightModel { disk, model: read_model(bits, edition, job)? });
    lights.iter().map(model).collect::<Result<_>>().map(Fields::PerLight)
}

/// The edition that a file names.
fn edition(number: u8) -> Edition {
    Edition { version: number & !WITH_LOCAL_DETAIL, has_local_detail: number & WITH_LOCAL_DETAIL != 0 }
}

/// The data after the header, whose checksum is verified.
fn body(bytes: &[u8]) -> Result<&[u8]> {
    if !bytes.starts_with(&SIGNATURE) {
        return Err(Error::unsupported("the file is not a random-field model: it does not begin with RLM"));
    }
    let (header, body) = bytes.split_at_checked(HEADER).ok_or_else(|| {
        Error::invalid(format!("the model ends inside its header, at byte {}", bytes.len()))
    })?;
    if !VERSIONS.contains(&edition(header[4]).version) {
        return Err(Error::unsupported(format!(
            "the model is of version {}: this program reads versions {} to {}",
            header[4],
            VERSIONS[0],
            VERSIONS[VERSIONS.len() - 1]
        )));
    }
    let word = |at: usize| u32::from_le_bytes([header[at], header[at + 1], header[at + 2], header[at + 3]]);
    if body.len() as u64 != u64::from(word(9)) {
        return Err(Error::invalid(format!(
            "the model's header announces {} bytes, but {} follow: the file is truncated or not a model",
            word(9),
            body.len()
        )));
    }
    let sum = checksum(&bytes[9..]);
    if sum != word(5) {
        return Err(Error::invalid(format!(
            "the model's checksum is {sum:08x}, but its header says {:08x}: the file was altered",
            word(5)
        )));
    }
    Ok(body)
}

/// The name of a basis of learned functions.
const LEARNED: &str = "learned";

/// The layout of a name; channels with common coefficients are those of a colour.
fn layout_of_name(name: &str) -> Option<PlaneLayout> {
    let shared = PlaneLayout::shared(["R", "G", "B"]).ok().filter(|layout| layout.name() == name);
    shared.or_else(|| PlaneLayout::from_name(name))
}

/// The characters of an unknown name in a message.
const LONGEST_NAME: usize = 40;

fn name<T>(bits: &mut BitReader<'_>, what: &str, known: impl Fn(&str) -> Option<T>) -> Result<T> {
    let length = bits.bits(8)?;
    let bytes = (0..length).map(|_| Ok(bits.bits(8)? as u8)).collect::<Result<Vec<u8>>>()?;
    let text = String::from_utf8_lossy(&bytes);
    known(&text).ok_or_else(|| {
        let shown: String =
            text.chars().take(LONGEST_NAME).map(|c| if c.is_control() { '?' } else { c }).collect();
        Error::unsupported(format!("the model's {what} '{shown}' is not known: read it with a later version"))
    })
}

fn read_model(bits: &mut BitReader<'_>, edition: Edition, job: &Job) -> Result<Model> {
    let Edition { version, has_local_detail } = edition;
    let (planes, factor, levels) = (bits.bits(16)? as usize, bits.bits(8)? as usize, bits.bits(8)? as usize);
    let kernel =
        Kernel::new(factor).map_err(|e| Error::invalid(format!("the model is damaged: {}", e.message())))?;
    let own = (0..planes).map(|_| Ok(bits.bits(1)? == 1)).collect::<Result<Vec<bool>>>()?;
    let components: Vec<usize> = own
        .iter()
        .scan(0, |sum, &own| {
            *sum += usize::from(own);
            Some(*sum)
        })
        .collect();
    let m = components.last().copied().unwrap_or(0);
    if m == 0 || levels == 0 || factor.checked_pow(levels as u32).is_none_or(|texels| texels > 1 << 24) {
        return Err(Error::invalid(format!(
            "a model of {m} components, {levels} levels and a factor of {factor} is impossible"
        )));
    }
    let weights = floats(bits, components.iter().sum(), "mixing", job)?;
    let gains = (0..planes).map(|_| bits.half("gain")).collect::<Result<_>>()?;
    let color = if version >= VERSIONS[3] { read_color(bits, planes)? } else { None };
    let single = planes - if color.is_some() { 3 } else { 0 };
    let marginals = (0..single).map(|_| read_marginal(bits)).collect::<Result<_>>()?;
    let mut levels = (0..levels).map(|_| read_level(bits, m, job)).collect::<Result<Vec<Level>>>()?;
    if has_local_detail {
        for level in &mut levels {
            level.unevenness = bits.bits(8)? as u8;
            level.gain = read_gain(bits)?;
        }
    }
    let mixing = Mixing { own, weights };
    Ok(Model { marginals, color, mixing, gains, kernel, levels, structure: None })
}

/// `count` floats; the bits are checked before memory is allocated.
fn floats(bits: &mut BitReader<'_>, count: usize, what: &str, job: &Job) -> Result<Vec<f32>> {
    job.check_bytes("the model", 4 * count as u64)?;
    (0..count).map(|_| bits.float(what)).collect()
}

fn read_marginal(bits: &mut BitReader<'_>) -> Result<Marginal> {
    let is_curve = bits.bits(1)? == 1;
    let (first, second) = (bits.float("distribution")?, bits.float("distribution")?);
    if !is_curve {
        return Ok(Marginal::Normal { mean: first, deviation: second });
    }
    let (mut code, mut rice) = (0i32, Rice::new());
    let mut codes = Box::new([0u16; KNOTS]);
    for place in &mut codes[1..] {
        let step = bits.rice(&mut rice)?;
        code += step.clamp(-1, i32::from(STEPS) + 1);
        if step < 0 || code > i32::from(STEPS) {
            return Err(Error::invalid(
                "the curve of a distribution does not rise from its least to its greatest value",
            ));
        }
        *place = code as u16;
    }
    Ok(Marginal::Curve { low: first, high: second, codes })
}

fn read_color(bits: &mut BitReader<'_>, planes: usize) -> Result<Option<JointColor>> {
    if bits.bits(1)? == 0 {
        return Ok(None);
    }
    let first = bits.bits(16)? as usize;
    if first + 3 > planes {
        return Err(Error::invalid(format!(
            "the model's colour begins in plane {first}, and there are only {planes} planes"
        )));
    }
    let lightness = read_marginal(bits)?;
    let opponents = [read_conditional(bits, 1)?, read_conditional(bits, 2)?];
    Ok(Some(JointColor { first, lightness, opponents }))
}

fn read_conditional(bits: &mut BitReader<'_>, parents: usize) -> Result<Conditional> {
    let (low, high) = (bits.float("colour")?, bits.float("colour")?);
    let [nodes, knots] = Conditional::grid(parents);
    let (mut across, mut up) = (Rice::new(), Rice::new());
    let mut codes: Vec<u8> = Vec::with_capacity(nodes * knots);
    for i in 0..nodes * knots {
        let rises = i % knots > 0;
        let step = bits.rice(if rises { &mut up } else { &mut across })?;
        let before = if rises {
            codes[i - 1]
        } else if i == 0 {
            0
        } else {
            codes[i - knots]
        };
        let code = i32::from(before).saturating_add(step);
        if rises && step < 0 || !(0..=i32::from(CODES)).contains(&code) {
            return Err(Error::invalid(
                "the quantiles of the model's colour do not rise from its least to its greatest value",
            ));
        }
        codes.push(code as u8);
    }
    Ok(Conditional { parents, low, high, codes })
}

fn read_level(bits: &mut BitReader<'_>, m: usize, job: &Job) -> Result<Level> {
    let margin = bits.bits(3)? as usize;
    let burn_in = *BURN_INS
        .get(margin)
        .ok_or_else(|| Error::invalid(format!("the margin of the model has the unknown number {margin}")))?;
    let (log_evidence, texels) = (bits.float("evidence")?, bits.bits(32)?);
    let neighbours = read_mask(bits, causal)?;
    let coarse = read_mask(bits, all_around)?;
    let noise = floats(bits, m * (m + 1) / 2, "noise", job)?;
    let mut steps = |count: usize| (0..count).map(|_| bits.half("step")).collect::<Result<Vec<f32>>>();
    let (rows, columns) = (steps(2 * m)?, steps(m)?);
    let count = (neighbours.len() + coarse.len()) * m * m;
    job.check_bytes("the model", 4 * count as u64)?;
    let (mut own, mut other) = (Rice::new(), Rice::new());
    let codes = (0..count).map(|i| {
        let code = bits.rice(if i / m % m == i % m { &mut own } else { &mut other })?;
        Ok(code.clamp(-MAX_CODE, MAX_CODE))
    });
    let codes = codes.collect::<Result<_>>()?;
    let weights = Weights { codes, rows, columns, causal: neighbours.len() };
    Ok(Level { neighbours, coarse, weights, noise, gain: None, unevenness: 0, burn_in, log_evidence, texels })
}

fn read_gain(bits: &mut BitReader<'_>) -> Result<Option<LocalGain>> {
    if bits.bits(1)? == 0 {
        return Ok(None);
    }
    let (deviation, gradient) = (bits.half("gain")?, bits.half("gain")?);
    if !(deviation > 0.0 && gradient > 0.0) {
        return Err(Error::invalid(format!(
            "the gains of the model are for a deviation of {deviation} and a gradient of {gradient}: both must be more than 0"
        )));
    }
    let (mut steps, mut code, mut codes) = (Rice::new(), i32::from(LocalGain::ONE), [0; NODES]);
    for place in &mut codes {
        code = code.saturating_add(bits.rice(&mut steps)?);
        *place = u8::try_from(code).map_err(|_| {
            Error::invalid(format!("the gains of the model have the code {code}: expected 0 to 255"))
        })?;
    }
    Ok(Some(LocalGain { deviation, gradient, codes }))
}

fn read_structure(bits: &mut BitReader<'_>, m: usize, edition: Edition, job: &Job) -> Result<Structure> {
    let mut number = || Ok(bits.bits(16)? as usize);
    let (tile, tiles) = (Size::new(number()?, number()?), number()?);
    let scales = bits.bits(4)? as usize;
    if tile.texels() == 0 || tiles == 0 || scales > MOST_SCALES {
        return Err(Error::invalid(format!(
            "{tiles} tiles of {tile} texels with {scales} scales are not a valid structure"
        )));
    }
    let steps = (0..m).map(|_| bits.half("structure")).collect::<Result<Vec<f32>>>()?;
    let length = bits.bits(32)? as usize;
    if length > bits.left() / 8 {
        return Err(Error::invalid(format!(
            "the codes of the model's structure need {length} bytes, but {} are left",
            bits.left() / 8
        )));
    }
    let codes = (0..length).map(|_| Ok(bits.bits(8)? as u8)).collect::<Result<Vec<u8>>>()?;
    let predicts = edition.has_local_detail;
    structure::decode(&codes, Structure { tile, tiles, scales, predicts, steps, codes: Vec::new() }, job)
}

fn read_mask(bits: &mut BitReader<'_>, family: fn(usize) -> Vec<Offset>) -> Result<Vec<Offset>> {
    let count = bits.bits(9)? as usize;
    let mut offsets = Vec::new();
    for offset in family(count) {
        if bits.bits(1)? == 1 {
            offsets.push(offset);
        }
    }
    Ok(offsets)
}
