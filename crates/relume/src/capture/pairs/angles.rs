//! The four angles in the name of a photograph: `tl` and `pl` are the polar angle and the azimuth of the light, `tv`
//! and `pv` those of the view, in degrees, in any order, separated by spaces, `_` or `-`.

use std::fmt;

use crate::direction::{Direction, Directions};
use crate::error::{Error, Result};

/// Parts of a degree that are told apart.
const PARTS: f64 = 10_000.0;

/// What the four angles are called.
const TOKENS: [&str; 4] = ["tv", "pv", "tl", "pl"];

/// Polar angle and azimuth of view and light, in ten-thousandths of a degree.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub(super) struct PairAngles([i64; 4]);

impl PairAngles {
    pub fn new(light: (i64, i64), view: (i64, i64)) -> Self {
        Self([view.0, view.1, light.0, light.1])
    }

    /// The angles of directions, rounded.
    pub fn of_directions(pair: Directions) -> Self {
        let angles = |d: Direction| {
            let parts = |radians: f64| (radians.to_degrees() * PARTS).round() as i64;
            let polar = parts(d.polar_rad());
            (polar, turned(polar, parts(d.azimuth_rad())))
        };
        Self::new(angles(pair.light), angles(pair.view))
    }

    /// The angles in a name with an extension, if it holds each of the four exactly once.
    pub fn of_name(name: &str) -> Option<Self> {
        let (stem, _) = name.rsplit_once('.').filter(|_| is_picture(name))?;
        if is_range(stem) {
            return None;
        }
        let mut angles = [None; 4];
        for word in stem.split([' ', '_', '-']) {
            let Some((place, degrees)) = token(word) else { continue };
            if angles[place].replace((degrees * PARTS).round() as i64).is_some() {
                return None;
            }
        }
        let [tv, pv, tl, pl] = angles;
        let (tv, tl) = (tv?, tl?);
        Some(Self([tv, turned(tv, pv?), tl, turned(tl, pl?)]))
    }

    /// The polar angle and azimuth of the light.
    pub fn light(&self) -> (i64, i64) {
        (self.0[2], self.0[3])
    }

    /// The polar angle and azimuth of the view.
    pub fn view(&self) -> (i64, i64) {
        (self.0[0], self.0[1])
    }

    /// The unit vectors.
    ///
    /// # Errors
    /// Polar angles above 90 degrees.
    pub fn directions(&self) -> Result<Directions> {
        let direction = |(polar, azimuth): (i64, i64), of: &str| {
            let degrees = polar as f64 / PARTS;
            if degrees > 90.0 {
                return Err(Error::invalid(format!(
                    "the polar angle of the {of} is {degrees} degrees: expected 0 (straight above) to 90"
                )));
            }
            Ok(Direction::from_angles(degrees.to_radians(), (azimuth as f64 / PARTS).to_radians()))
        };
        Ok(Directions { light: direction(self.light(), "light")?, view: direction(self.view(), "view")? })
    }
}

/// Whether a name is that of a picture.
pub(super) fn is_picture(name: &str) -> bool {
    const KNOWN: [&str; 8] = ["jpg", "jpeg", "png", "hdr", "exr", "tif", "tiff", "pfm"];
    let extension = name.rsplit_once('.').map(|(_, extension)| extension.to_ascii_lowercase());
    extension.is_some_and(|extension| KNOWN.contains(&extension.as_str()))
}

/// Whether a number follows an angle after a dash, as in `tl0-15`: an angle below zero, or two of them, and not one that is
/// separated from the next word.
fn is_range(stem: &str) -> bool {
    let words: Vec<&str> = stem.split([' ', '_']).collect();
    words.iter().any(|word| {
        let parts: Vec<&str> = word.split('-').collect();
        let is_number = |part: &str| !part.is_empty() && part.chars().all(|c| c.is_ascii_digit() || c == '.');
        parts.len() == 2 && token(parts[0]).is_some() && is_number(parts[1])
    })
}

/// As in names: `tl15 pl60 tv0 pv0`.
impl fmt::Display for PairAngles {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let [tv, pv, tl, pl] = self.0.map(|angle| angle as f64 / PARTS);
        write!(f, "tl{tl} pl{pl} tv{tv} pv{pv}")
    }
}

/// The azimuth within a turn; zero at the zenith, which has none.
fn turned(polar: i64, azimuth: i64) -> i64 {
    if polar == 0 { 0 } else { azimuth.rem_euclid((360.0 * PARTS) as i64) }
}

/// Which angle a word is, and its degrees.
fn token(word: &str) -> Option<(usize, f64)> {
    let name = word.get(..2)?.to_ascii_lowercase();
    let place = TOKENS.iter().position(|token| *token == name)?;
    let number = &word[2..];
    let is_number = number.starts_with(|c: char| c.is_ascii_digit())
        && number.chars().all(|c| c.is_ascii_digit() || c == '.');
    number.parse().ok().filter(|degrees: &f64| is_number && *degrees < 1e6).map(|degrees| (place, degrees))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn of(name: &str) -> Option<String> {
        PairAngles::of_name(name).map(|angles| angles.to_string())
    }

    #[test]
    fn names_of_all_sets_are_understood() {
        let ubo = of("00008 tl000 pl000 tv030 pv060.jpg");
        assert_eq!(ubo.as_deref(), Some("tl0 pl0 tv30 pv60"));
        assert_eq!(of("00008_tl015_pl060_tv030_pv000.JPEG").as_deref(), Some("tl15 pl60 tv30 pv0"));
        assert_eq!(of("tv11.5_pv0_tl20.25_pl10.exr").as_deref(), Some("tl20.25 pl10 tv11.5 pv0"));
        assert_eq!(of("TL75-PL-TV0-PV1.png"), None);
        assert_eq!(of("tl75 pl360 tv0 pv90.hdr").as_deref(), Some("tl75 pl0 tv0 pv0"));
        for other in [
            "tl1 pl2 tv3.png",
            "tl1 pl2 tv3 pv4.txt",
            "tl1 tl2 pl2 tv3 pv4.png",
            "tl1e3 pl2 tv3 pv4.png",
            "tl0-15 pl2 tv3 pv4.png",
            "tl-15 pl2 tv3 pv4.png",
            "x",
        ] {
            assert_eq!(of(other), None, "{other}");
        }
    }

    #[test]
    fn angles_come_back_from_their_directions() {
        for name in ["tl15 pl60 tv30 pv0", "tl0 pl0 tv75 pv345", "tl20.25 pl10 tv11.5 pv0"] {
            let angles = PairAngles::of_name(&format!("{name}.png")).unwrap();
            assert_eq!(PairAngles::of_directions(angles.directions().unwrap()).to_string(), name);
        }
    }

    #[test]
    fn directions_are_those_of_the_angles_and_below_the_surface_is_refused() {
        let pair = PairAngles::of_name("tl90 pl90 tv60 pv180.png").unwrap().directions().unwrap();
        assert!(pair.light.y() > 1.0 - 1e-12 && (pair.view.z() - 0.5).abs() < 1e-12);
        assert!((pair.view.x() + 0.75f64.sqrt()).abs() < 1e-12);
        let below =
            PairAngles::of_name("tl95 pl90 tv60 pv180.png").unwrap().directions().unwrap_err().to_string();
        assert!(below.contains("light is 95 degrees"), "{below}");
    }
}
