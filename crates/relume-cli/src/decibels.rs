//! Signal-to-noise ratios in words.

/// The most polar angles that are listed each by itself.
const MOST_ANGLES: usize = 12;

/// The range of angles that are put together beyond that, in degrees.
const RANGE_DEG: f64 = 10.0;

/// A ratio in decibels with two digits; equal pictures have none.
pub fn decibels(db: f64) -> String {
    if db.is_finite() { format!("{db:.2} dB") } else { "equal".to_owned() }
}

/// Errors by a polar angle: the degrees, the number of photographs, and the sum over them of what `said` takes a mean of.
/// Where angles are many, as of random directions, those within ten degrees are one, of which photographs without an error (with an
/// infinite sum) take no part.
pub fn by_polar_angle(what: &str, angles: &[(f64, usize, f64)], said: impl Fn(f64) -> String) -> String {
    let mut groups: Vec<(String, usize, f64)> = Vec::new();
    let ranges = angles.len() > MOST_ANGLES;
    for &(degrees, count, sum) in angles {
        let name = match ranges {
            true => {
                let first = RANGE_DEG * (degrees / RANGE_DEG).floor();
                format!("{first:.0}-{:.0}", first + RANGE_DEG)
            }
            false => format!("{degrees}"),
        };
        let (count, sum) = if sum.is_finite() { (count, sum) } else { (0, 0.0) };
        match groups.last_mut().filter(|(last, ..)| *last == name) {
            Some((_, all, total)) => (*all, *total) = (*all + count, *total + sum),
            None => groups.push((name, count, sum)),
        }
    }
    let each: Vec<String> = groups
        .iter()
        .map(|(name, count, sum)| {
            let text = said(if *count == 0 { f64::INFINITY } else { sum / *count as f64 });
            format!("{name}: {}", text.strip_suffix(" dB").unwrap_or(&text))
        })
        .collect();
    format!("dB by the polar angle of the {what}: {}", each.join(", "))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn many_angles_are_put_together_by_the_number_of_their_photographs() {
        let few = by_polar_angle("view", &[(0.0, 1, 40.0), (15.5, 2, 60.0)], decibels);
        assert_eq!(few, "dB by the polar angle of the view: 0: 40.00, 15.5: 30.00");
        let mut many: Vec<(f64, usize, f64)> = (0..20).map(|k| (f64::from(k), 1, 20.0)).collect();
        many[3] = (3.0, 9, 9.0 * 40.0);
        many.extend([(20.0, 2, f64::INFINITY), (20.5, 1, 30.0), (74.9, 1, f64::INFINITY)]);
        let text = by_polar_angle("light", &many, decibels);
        assert_eq!(
            text,
            "dB by the polar angle of the light: 0-10: 30.00, 10-20: 20.00, 20-30: 30.00, 70-80: equal"
        );
    }
}
