//! What every `.btf` file begins with: the signature, a description of the measurement, the measured directions
//! and the size.

use super::source::BtfCursor;
use crate::direction::{Direction, Directions};
use crate::error::{Error, Result};
use crate::size::Size;

/// The bytes of a signature.
const SIGNATURE: usize = 10;

/// The kind of data in a file.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[non_exhaustive]
pub enum BonnKind {
    /// Decorrelated full matrix factorisation: one for each channel of another colour model.
    Dfmf,
    /// Full matrix factorisation.
    Fmf,
    /// A factorisation for each view.
    Pvf,
    /// The values themselves.
    Bdi,
}

/// How a file begins: the signature, the kind, and whether rotations and a header of its own follow.
pub(super) struct Signature {
    pub(super) text: &'static str,
    pub(super) kind: BonnKind,
    pub(super) rotations: bool,
    pub(super) extended: bool,
}

/// All signatures; a longer one stands before the one that it begins with.
const SIGNATURES: [Signature; 7] = [
    Signature { text: "!DFMF08FCR", kind: BonnKind::Dfmf, rotations: true, extended: false },
    Signature { text: "!FMF12FCER", kind: BonnKind::Fmf, rotations: true, extended: true },
    Signature { text: "!FMF06FCR", kind: BonnKind::Fmf, rotations: true, extended: false },
    Signature { text: "!FMF06FC", kind: BonnKind::Fmf, rotations: false, extended: false },
    Signature { text: "!PVF06FCR", kind: BonnKind::Pvf, rotations: true, extended: false },
    Signature { text: "!PVF06FC", kind: BonnKind::Pvf, rotations: false, extended: false },
    Signature { text: "!BDIF06R2!", kind: BonnKind::Bdi, rotations: false, extended: false },
];

/// The description of the measurement and of the values.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct BtfHead {
    pub(super) kind: BonnKind,
    pub(super) extended: bool,
    pub(super) channels: Vec<String>,
    pub(super) has_cosine: bool,
    pub(super) pixels_per_mm: f32,
    pub(super) sampling: BtfSampling,
    pub(super) size: Size,
}

/// The measured directions: for each view its lights.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct BtfSampling {
    /// View after view, with the lights of each in order.
    pub(super) pairs: Vec<Directions>,
    /// The first pair of each view, and the number of pairs.
    pub(super) starts: Vec<usize>,
}

impl BtfSampling {
    pub(super) fn views(&self) -> usize {
        self.starts.len() - 1
    }

    pub(super) fn lights(&self, view: usize) -> usize {
        self.starts[view + 1] - self.starts[view]
    }

    /// The view and the light of a pair, as numbers.
    pub(super) fn place(&self, pair: usize) -> (usize, usize) {
        let view = self.starts.partition_point(|&start| start <= pair) - 1;
        (view, pair - self.starts[view])
    }
}

/// The most channels that are read: more than any camera has, and few enough that counts stay small.
const MOST_CHANNELS: u32 = 4096;

/// The bytes of the longest name of a channel.
const LONGEST_NAME: usize = 64;

/// Angles beyond the horizon by no more than this are rounding errors of `f32`.
const BELOW_HORIZON: f32 = 1e-4;

impl BtfHead {
    /// Reads up to the data of the kind.
    pub(super) fn read(cursor: &mut BtfCursor) -> Result<Self> {
        let signature = signature(cursor)?;
        let (channels, has_cosine, pixels_per_mm) = meta(cursor)?;
        let sampling = sampling(cursor)?;
        let width = cursor.u32("the width")? as usize;
        let size = Size::new(width, cursor.u32("the height")? as usize);
        cursor.job().check("the BTF image", size, 4 * channels.len() as u64)?;
        if signature.rotations {
            skip_rotations(cursor)?;
        }
        let Signature { kind, extended, .. } = *signature;
        Ok(Self { kind, extended, channels, has_cosine, pixels_per_mm, sampling, size })
    }

    /// The number of values of a texel: pairs times channels.
    pub(super) fn values(&self) -> u64 {
        self.sampling.pairs.len() as u64 * self.channels.len() as u64
    }
}

fn signature(cursor: &mut BtfCursor) -> Result<&'static Signature> {
    let start = cursor.bytes("its signature", SIGNATURE as u64)?;
    let found = SIGNATURES.iter().find(|signature| start.starts_with(signature.text.as_bytes()));
    let found = found.ok_or_else(|| {
        Error::unsupported(format!(
            "a BTF file that begins with '{}' is not read: expected {}",
            String::from_utf8_lossy(&start).escape_debug(),
            SIGNATURES.map(|signature| signature.text).join(", ")
        ))
    })?;
    // Shorter signatures end earlier.
    cursor.rewind(SIGNATURE - found.text.len());
    Ok(found)
}

/// The names of channels, the cosine flag, and the resolution.
fn meta(cursor: &mut BtfCursor) -> Result<(Vec<String>, bool, f32)> {
    const WHAT: &str = "its description";
    let start = cursor.at();
    let (length, version) = (cursor.u32(WHAT)?, cursor.u32(WHAT)?);
    cursor.skip(WHAT, 3 * 80)?;
    let pixels_per_mm = cursor.f32(WHAT)?;
    cursor.skip(WHAT, 3 * 4)?;
    let has_cosine = version > 1 && cursor.u32(WHAT)? != 0;
    if version > 2 {
        let text = cursor.u32(WHAT)?;
        cursor.skip("the XML text", u64::from(text))?;
    }
    let mut channels = vec!["R".to_owned(), "G".to_owned(), "B".to_owned()];
    if version > 3 {
        channels = channel_names(cursor)?;
    }
    let read = cursor.at() - start;
    if read != u64::from(length) {
        return Err(Error::invalid(format!(
            "the description in the BTF file says it has {length} bytes, and version {version} has {read} here: the \
             file is damaged"
        )));
    }
    Ok((channels, has_cosine, pixels_per_mm))
}

fn channel_names(cursor: &mut BtfCursor) -> Result<Vec<String>> {
    let count = cursor.u32("the number of channels")?;
    if count == 0 || count > MOST_CHANNELS {
        return Err(Error::invalid(format!(
            "the BTF file says it has {count} channels: expected 1 to {MOST_CHANNELS}"
        )));
    }
    let name = |number| {
        let length = cursor.u32("the name of a channel")?;
        let name = cursor.text("the name of a channel", u64::from(length))?;
        if name.len() <= LONGEST_NAME && !name.chars().any(char::is_control) {
            return Ok(name);
        }
        Err(Error::invalid(format!(
            "the name of channel {number} in the BTF file is not a text of at most {LONGEST_NAME} bytes: it is damaged"
        )))
    };
    (0..count).map(name).collect()
}

fn sampling(cursor: &mut BtfCursor) -> Result<BtfSampling> {
    let views = cursor.u32("the number of views")?;
    // Two angles and the number of lights.
    cursor.expect("its views", 12 * u64::from(views))?;
    let (mut pairs, mut starts) = (Vec::new(), vec![0]);
    for number in 0..views {
        let angles = [cursor.f32("a view")?, cursor.f32("a view")?];
        let view = direction(angles, || format!("view {number}"))?;
        let lights = cursor.u32("the number of lights")?;
        let bytes = cursor.bytes("the lights of a view", 8 * u64::from(lights))?;
        cursor
            .job()
            .check_bytes("the directions of the BTF", 2 * 48 * (pairs.len() as u64 + u64::from(lights)))?;
        for (light, b) in bytes.chunks_exact(8).enumerate() {
            let angle = |i: usize| f32::from_le_bytes([b[i], b[i + 1], b[i + 2], b[i + 3]]);
            let named = || format!("light {light} of view {number}");
            pairs.push(Directions { light: direction([angle(0), angle(4)], named)?, view });
        }
        starts.push(pairs.len());
    }
    if pairs.is_empty() {
        return Err(Error::invalid("the BTF file has no pair of light and view: it is damaged"));
    }
    Ok(BtfSampling { pairs, starts })
}

fn direction([polar, azimuth]: [f32; 2], named: impl Fn() -> String) -> Result<Direction> {
    let above = (0.0..=std::f32::consts::FRAC_PI_2 + BELOW_HORIZON).contains(&polar);
    if above && azimuth.is_finite() {
        return Ok(Direction::from_angles(
            f64::from(polar).min(std::f64::consts::FRAC_PI_2),
            f64::from(azimuth),
        ));
    }
    Err(Error::invalid(format!(
        "{} of the BTF file has the angles {polar} and {azimuth} in radians: expected a polar angle from 0 to pi/2",
        named()
    )))
}

/// Rotations of the texture, which no value depends on.
pub(super) fn skip_rotations(cursor: &mut BtfCursor) -> Result<()> {
    let count = cursor.u32("the number of rotations")?;
    cursor.skip("the rotations", 36 * u64::from(count))
}
