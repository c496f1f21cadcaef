//! The half of some values that lie nearest to each other.

/// The median and the width of the shortest half, an estimate of where most values lie whatever the others do (Andrews, Bickel,
/// Hampel, Huber, Rogers, Tukey, "Robust Estimates of Location", 1972); `None` without a value. The values are sorted.
pub fn shorth(values: &mut [f64]) -> Option<(f64, f64)> {
    values.sort_by(f64::total_cmp);
    let half = values.len().div_ceil(2);
    let width = |first: usize| values[first + half - 1] - values[first];
    let nearest = (0..values.len().checked_sub(half)? + 1)
        .filter(|_| half > 0)
        .min_by(|a, b| width(*a).total_cmp(&width(*b)))?;
    Some((values[nearest + half / 2], width(nearest)))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_lies_apart_has_no_say() {
        let mut values = [9.0, 1.0, 1.2, -40.0, 1.1, 7.0, 1.3];
        let (middle, width) = shorth(&mut values).unwrap();
        assert!((middle - 1.2).abs() < 1e-12 && (width - 0.3).abs() < 1e-12, "{middle} {width}");
        assert_eq!(shorth(&mut [3.0]), Some((3.0, 0.0)));
        assert_eq!(shorth(&mut []), None);
    }
}
