//! Values beyond the range of the file or measure that takes them: counted, so that clipping is said.

/// The values beyond a range, and the least and the largest of all.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Clipping {
    values: u64,
    outside: u64,
    low: f32,
    high: f32,
}

/// What clips values, and to which range.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) enum Clipper {
    /// Integer codes of pictures: 0 to 1.
    Codes,
    /// Half floats.
    Halves,
    /// The errors of a fit, and files that show it: values above white.
    White,
}

/// A difference that no one sees: half a step of 8 bits.
const UNSEEN: f32 = 0.5 / 255.0;

/// The share of values from which clipping is said where none is far outside.
const NOTABLE_SHARE: f64 = 1e-3;

impl Clipper {
    /// The values that are kept, to what no one sees.
    const fn bounds(self) -> [f32; 2] {
        match self {
            Self::Codes => [-UNSEEN, 1.0 + UNSEEN],
            Self::Halves => [-65504.0, 65504.0],
            Self::White => [f32::NEG_INFINITY, 1.0 + UNSEEN],
        }
    }

    /// Whether a few values beyond the range are to be said.
    fn is_far(self, low: f32, high: f32) -> bool {
        match self {
            Self::Codes | Self::White => low <= -1.0 && self == Self::Codes || high >= 2.0,
            Self::Halves => true,
        }
    }
}

impl Default for Clipping {
    fn default() -> Self {
        Self { values: 0, outside: 0, low: f32::INFINITY, high: f32::NEG_INFINITY }
    }
}

impl Clipping {
    /// Counts values; NaN is outside every range.
    pub(crate) fn of(values: &[f32], clipper: Clipper) -> Self {
        let [least, most] = clipper.bounds();
        let mut all = Self { values: values.len() as u64, ..Self::default() };
        for &value in values {
            all.outside += u64::from(!(least <= value && value <= most));
            all.low = all.low.min(value);
            all.high = all.high.max(value);
        }
        all
    }

    /// The values of both.
    #[must_use]
    pub(crate) fn and(self, other: Self) -> Self {
        Self {
            values: self.values + other.values,
            outside: self.outside + other.outside,
            low: self.low.min(other.low),
            high: self.high.max(other.high),
        }
    }

    /// What is to be said of it, if anything.
    pub(crate) fn sentence(&self, clipper: Clipper) -> Option<String> {
        let share = self.outside as f64 / self.values.max(1) as f64;
        if self.outside == 0 || (share < NOTABLE_SHARE && !clipper.is_far(self.low, self.high)) {
            return None;
        }
        let (percent, range) = (percent(share), format!("{} to {}", short(self.low), short(self.high)));
        Some(match clipper {
            Clipper::Codes => format!(
                "{percent} of the values are outside 0..1 ({range}) and were clipped, since integer files hold no \
                 others: an .exr keeps them"
            ),
            Clipper::Halves => format!(
                "{percent} of the values are beyond the 65504 of 16-bit floats ({range}) and were clipped: 32-bit floats \
                 keep them"
            ),
            Clipper::White => format!(
                "{percent} of the samples of the photographs are brighter than white (1; up to {}): errors are measured \
                 with them cut off, and only an .exr of linear values shows them; divide all photographs by one number",
                short(self.high)
            ),
        })
    }
}

fn percent(share: f64) -> String {
    match 100.0 * share {
        percent if percent < 0.01 => "less than 0.01 %".to_owned(),
        percent if percent < 1.0 => format!("{percent:.2} %"),
        percent => format!("{percent:.1} %"),
    }
}

/// A number in at most a few digits.
fn short(value: f32) -> String {
    match value.abs() {
        large if large >= 1e5 => format!("{value:.2e}"),
        _ => format!("{}", (f64::from(value) * 1000.0).round() / 1000.0),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn many_values_outside_or_a_few_far_outside_are_said() {
        let said = |values: &[f32], clipper| Clipping::of(values, clipper).sentence(clipper);
        let mut values = vec![0.5; 10_000];
        assert_eq!(said(&values, Clipper::Codes), None);
        values[3] = 1.2;
        values[4] = 1.0 + 0.4 / 255.0;
        assert_eq!(said(&values, Clipper::Codes), None, "one of ten thousand, a little outside");
        values[5] = 1e6;
        let text = said(&values, Clipper::Codes).unwrap();
        assert!(text.starts_with("0.02 % of the values are outside 0..1 (0.5 to 1.00e6)"), "{text}");
        assert!(said(&values, Clipper::Halves).unwrap().contains("65504"));
        assert!(said(&values, Clipper::White).unwrap().contains("brighter than white"));
        values.fill(-0.25);
        let text = said(&values, Clipper::Codes).unwrap();
        assert!(text.starts_with("100.0 % of the values are outside 0..1 (-0.25 to -0.25)"), "{text}");
        assert_eq!(said(&values, Clipper::White), None);
        values.fill(f32::NAN);
        assert!(said(&values, Clipper::Codes).is_some());
    }

    #[test]
    fn parts_add_up_in_any_order() {
        let (a, b) = (Clipping::of(&[0.0, 2.0], Clipper::Codes), Clipping::of(&[-3.0], Clipper::Codes));
        assert_eq!(a.and(b), b.and(a));
        assert_eq!(a.and(b), Clipping::of(&[0.0, 2.0, -3.0], Clipper::Codes));
    }
}
