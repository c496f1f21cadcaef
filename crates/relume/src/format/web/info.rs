//! What `info.json` says.

use serde_json::Value;

use crate::error::{Error, Result};
use crate::size::Size;

/// The functions of a folder.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum WebKind {
    Ptm,
    Hsh,
    Sh,
    /// With the width of the Gaussians.
    Rbf(f64),
    /// With the side of the grid.
    Bilinear(usize),
}

/// The arrangement of colours.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum WebColor {
    Rgb,
    Lrgb,
    /// Weights of tables of colours.
    Mrgb,
    /// The same in luma and chroma: so many pictures hold triples of them, the others luma alone.
    Mycc(usize),
}

/// The contents of `info.json`.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct WebInfo {
    pub size: Size,
    pub kind: WebKind,
    pub color: WebColor,
    /// The coefficients of a texel.
    pub planes: usize,
    pub lights: Vec<[f64; 3]>,
    /// For each coefficient.
    pub scale: Vec<f64>,
    pub bias: Vec<f64>,
    /// Of tables: for each coefficient.
    pub range: Vec<f64>,
    /// Of tables: plane after plane, the mean first.
    pub basis: Vec<u8>,
    pub is_linear: bool,
}

/// More coefficients are not believed.
const MOST_PLANES: u64 = 300;

impl WebInfo {
    pub(super) fn parse(bytes: &[u8]) -> Result<Self> {
        let json: Value = serde_json::from_slice(bytes).map_err(|e| {
            Error::invalid(format!("info.json is not JSON: line {}, column {}", e.line(), e.column()))
        })?;
        let info = Entries(&json);
        let kind = info.kind()?;
        let (color, planes) = info.colors()?;
        let is_table = matches!(kind, WebKind::Rbf(_) | WebKind::Bilinear(_));
        if is_table != matches!(color, WebColor::Mrgb | WebColor::Mycc(_)) {
            return Err(Error::unsupported(format!(
                "info.json has colours of the kind {} with functions of the type {}, which do not go together here",
                info.text("colorspace")?,
                info.text("type")?
            )));
        }
        let material = json.get("materials").and_then(|materials| materials.get(0)).unwrap_or(&Value::Null);
        let material = Entries(material);
        let lights = info.numbers("lights", None)?;
        let size = Size::new(info.whole("width", 1 << 24)?, info.whole("height", 1 << 24)?);
        let found = Self {
            size,
            kind,
            color,
            planes,
            lights: lights.chunks_exact(3).map(|l| [l[0], l[1], l[2]]).collect(),
            scale: material.numbers("scale", Some(planes))?,
            bias: material.numbers("bias", Some(planes))?,
            range: if is_table { material.numbers("range", Some(planes))? } else { Vec::new() },
            basis: if is_table { info.bytes("basis")? } else { Vec::new() },
            is_linear: json.get("colorprofile").and_then(Value::as_str) == Some("RGB"),
        };
        found.check_format(&json)?;
        Ok(found)
    }

    fn check_format(&self, json: &Value) -> Result<()> {
        match json.get("format").and_then(Value::as_str) {
            None | Some("jpg" | "jpeg") => Ok(()),
            Some(other) => Err(Error::unsupported(format!(
                "the planes of the folder are {} files: expected jpg",
                other.escape_debug()
            ))),
        }
    }

    /// The pictures that hold the coefficients.
    pub(super) fn pictures(&self) -> usize {
        self.planes.div_ceil(3)
    }
}

/// The entries of an object.
struct Entries<'a>(&'a Value);

impl Entries<'_> {
    fn entry(&self, name: &str) -> Result<&Value> {
        self.0.get(name).ok_or_else(|| Error::invalid(format!("info.json has no entry '{name}'")))
    }

    fn wrong(&self, name: &str, expected: &str) -> Error {
        Error::invalid(format!("the entry '{name}' of info.json is not {expected}"))
    }

    fn text(&self, name: &str) -> Result<String> {
        let text = self.entry(name)?.as_str().ok_or_else(|| self.wrong(name, "a text"))?;
        Ok(text.chars().take(40).collect::<String>().escape_debug().to_string())
    }

    fn whole(&self, name: &str, most: u64) -> Result<usize> {
        let number = self.entry(name)?.as_u64().filter(|n| (1..=most).contains(n));
        number
            .map(|n| n as usize)
            .ok_or_else(|| self.wrong(name, &format!("a whole number from 1 to {most}")))
    }

    /// Finite numbers, so many where that is known.
    fn numbers(&self, name: &str, count: Option<usize>) -> Result<Vec<f64>> {
        if count.is_none() && self.0.get(name).is_none() {
            return Ok(Vec::new());
        }
        let list = self.entry(name)?.as_array().ok_or_else(|| self.wrong(name, "a list"))?;
        let numbers: Option<Vec<f64>> =
            list.iter().map(|n| n.as_f64().filter(|n| n.is_finite() && n.abs() < 1e20)).collect();
        let numbers = numbers.ok_or_else(|| self.wrong(name, "a list of finite numbers"))?;
        match count.filter(|count| numbers.len() < *count) {
            Some(count) => Err(Error::invalid(format!(
                "the entry '{name}' of info.json has {} numbers: expected {count}, one for each coefficient",
                numbers.len()
            ))),
            None => Ok(numbers),
        }
    }

    fn bytes(&self, name: &str) -> Result<Vec<u8>> {
        let numbers = self.numbers(name, Some(0))?;
        let byte = |n: &f64| (n.fract() == 0.0 && (0.0..=255.0).contains(n)).then_some(*n as u8);
        let bytes: Option<Vec<u8>> = numbers.iter().map(byte).collect();
        bytes.ok_or_else(|| self.wrong(name, "a list of bytes"))
    }

    fn kind(&self) -> Result<WebKind> {
        match self.text("type")?.as_str() {
            "ptm" => Ok(WebKind::Ptm),
            "hsh" => Ok(WebKind::Hsh),
            "sh" => Ok(WebKind::Sh),
            "rbf" => {
                let sigma =
                    self.0.get("sigma").and_then(Value::as_f64).filter(|s| s.is_finite() && *s > 1e-6);
                sigma.map(WebKind::Rbf).ok_or_else(|| self.wrong("sigma", "a number above 0"))
            }
            "bilinear" | "bln" => match self.whole("resolution", 64)? {
                1 => Err(self.wrong("resolution", "a whole number from 2 to 64")),
                resolution => Ok(WebKind::Bilinear(resolution)),
            },
            "neural" => Err(Error::unsupported(
                "the folder holds a neural network (type neural), which is not read: export it as ptm, hsh or rbf",
            )),
            other => Err(Error::unsupported(format!(
                "the folder holds functions of the type {other}: expected ptm, hsh, sh, rbf or bilinear"
            ))),
        }
    }

    /// The arrangement, and the number of coefficients.
    fn colors(&self) -> Result<(WebColor, usize)> {
        let planes = || self.whole("nplanes", MOST_PLANES);
        match self.text("colorspace")?.as_str() {
            "rgb" => Ok((WebColor::Rgb, planes()?)),
            "lrgb" => Ok((WebColor::Lrgb, planes()?)),
            "mrgb" => Ok((WebColor::Mrgb, planes()?)),
            "mycc" => {
                let parts = self.numbers("yccplanes", Some(3))?;
                let whole = |n: &f64| n.fract() == 0.0 && (0.0..=MOST_PLANES as f64).contains(n);
                let total: f64 = parts[..3].iter().sum();
                if !parts[..3].iter().all(whole) || !(1.0..=MOST_PLANES as f64).contains(&total) {
                    return Err(self.wrong("yccplanes", "three whole numbers"));
                }
                Ok((WebColor::Mycc(parts[1] as usize), total as usize))
            }
            other => Err(Error::unsupported(format!(
                "the folder holds colours of the kind {other}: expected rgb, lrgb, mrgb or mycc"
            ))),
        }
    }
}
