//! Values on the command line: sizes, lights, names.

use clap::builder::{PossibleValuesParser, TypedValueParser};
use relume::field::PlaneLayout;
use relume::format::TEXEL_MM;
use relume::numeric::lattice::{Lattice, length};
use relume::synthesis::roller::RollerOptions;
use relume::{Direction, Named, Size};

/// `512x512` or `512` for a square.
pub fn size(text: &str) -> Result<Size, String> {
    let number = |s: &str| s.trim().parse::<usize>().ok().filter(|n| *n > 0);
    let parsed = match text.split_once(['x', 'X']) {
        Some((w, h)) => number(w).zip(number(h)),
        None => number(text).map(|n| (n, n)),
    };
    parsed.map(|(width, height)| Size::new(width, height)).ok_or_else(|| {
        "expected a size such as 512x512 (width x height in texels, both at least 1)".to_owned()
    })
}

/// How colours are held: a function for each channel, or one times a colour.
pub fn color() -> impl TypedValueParser<Value = PlaneLayout> {
    PossibleValuesParser::new([PlaneLayout::LRGB.name(), PlaneLayout::RGB.name()])
        .map(|name| PlaneLayout::from_name(&name).expect("a possible value is a layout"))
}

/// `X,Y,Z`: a vector of any length towards the light; x right, y up, z to the viewer.
pub fn light(text: &str) -> Result<Direction, String> {
    let [x, y, z] = numbers(text).ok_or("expected a direction of three numbers such as 0.5,0.5,0.7")?;
    let direction = Direction::new(x, y, z).map_err(|e| e.to_string())?;
    if direction.z() < 0.0 {
        return Err("this light is below the surface: its third number must not be negative".to_owned());
    }
    Ok(direction)
}

/// As [`light`], towards the viewer.
pub fn view(text: &str) -> Result<Direction, String> {
    light(text).map_err(|e| e.replace("this light", "this view"))
}

/// The size of a texel in millimetres.
pub fn texel_mm(text: &str) -> Result<f64, String> {
    let expected = format!("expected millimetres from {:e} to {:e}", TEXEL_MM.start(), TEXEL_MM.end());
    text.trim().parse().ok().filter(|mm| TEXEL_MM.contains(mm)).ok_or(expected)
}

/// A number between two others, both allowed; `what` says what it is, such as "degrees".
pub fn within(least: f64, most: f64, what: &'static str) -> impl Fn(&str) -> Result<f64, String> + Clone {
    move |text| {
        let number = text.trim().parse::<f64>().ok().filter(|v| (least..=most).contains(v));
        number.ok_or_else(|| format!("expected {what} from {least} to {most}"))
    }
}

/// `N` comma-separated finite numbers.
pub fn numbers<const N: usize>(text: &str) -> Option<[f64; N]> {
    let parsed: Option<Vec<f64>> =
        text.split(',').map(|s| s.trim().parse::<f64>().ok().filter(|v| v.is_finite())).collect();
    parsed?.try_into().ok()
}

/// The shortest period that texels can show.
const SHORTEST_PERIOD: f64 = 2.0;

/// A lattice: `W,H` or `X,Y,X,Y`.
pub fn lattice(text: &str) -> Result<Lattice, String> {
    let (a, b) = match (numbers::<2>(text), numbers::<4>(text)) {
        (Some([w, h]), _) => ([w, 0.0], [0.0, h]),
        (_, Some([ax, ay, bx, by])) => ([ax, ay], [bx, by]),
        _ => return Err("expected two numbers such as 24,31.5, or four for two shifts".to_owned()),
    };
    let most = RollerOptions::LONGEST_PERIOD;
    if [a, b].as_flattened().iter().any(|shift| shift.abs() > most) {
        return Err(format!("expected shifts from -{most} to {most} texels"));
    }
    if let Some(short) = [a, b].map(length).into_iter().find(|l| *l > 0.0 && *l < SHORTEST_PERIOD) {
        return Err(format!(
            "a period of {short:.3} texels cannot be seen: expected at least {SHORTEST_PERIOD}"
        ));
    }
    let lattice = Lattice::new(a, b).ok_or("these shifts lie on one line: expected two that span an area")?;
    match lattice.basis().map(length).into_iter().find(|length| *length < SHORTEST_PERIOD) {
        Some(short) => Err(format!(
            "these shifts together repeat after {short:.3} texels: expected periods of at least {SHORTEST_PERIOD}"
        )),
        None => Ok(lattice),
    }
}

/// A member of a closed family, by its name.
pub fn named<T: Named + Send + Sync>() -> impl TypedValueParser<Value = T> {
    PossibleValuesParser::new(T::ALL.iter().map(|member| member.name()))
        .map(|name| T::from_name(&name).expect("a possible value is a member's name"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sizes_and_lights_parse_or_say_what_they_expect() {
        assert_eq!(size("640x480"), Ok(Size::new(640, 480)));
        assert_eq!(size("64"), Ok(Size::new(64, 64)));
        for bad in ["", "0x4", "4x", "-3x3", "4x4x4", "ax3", "99999999999999999999"] {
            assert!(size(bad).is_err(), "{bad}");
        }
        assert!((light("0,3,4").unwrap().z() - 0.8).abs() < 1e-12);
        for bad in ["0,0,0", "1,2", "nan,0,1", "0,0,-1", "1,2,3,4", "inf,0,1"] {
            assert!(light(bad).is_err(), "{bad}");
        }
    }
    #[test]
    fn periods_beyond_all_textures_are_refused_in_no_time() {
        assert!(lattice("24,31.5").is_ok() && lattice("-20,3,5,30").is_ok());
        for bad in
            ["1e-300,20", "1e300,1e-300", "1e300,1e300", "0.01,200", "5,0,5.5,0", "40,30,41,31", "1,2,3"]
        {
            assert!(lattice(bad).is_err(), "{bad}");
        }
        assert!(lattice("1e300,1e300").unwrap_err().contains("-131072 to 131072 texels"));
        assert!(lattice("5,0,5.5,0").unwrap_err().contains("on one line"));
    }
}
