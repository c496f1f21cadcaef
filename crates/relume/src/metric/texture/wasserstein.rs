//! The Wasserstein-1 distance of two sets of numbers: the least mean displacement that turns one into the
//! other, equal to the area between their quantile functions (C. Villani, Topics in Optimal Transportation,
//! 2003, theorem 2.18).

/// The distance of two lists in increasing order, which may differ in length.
///
/// # Panics
/// When a list is empty.
pub fn distance(a: &[f32], b: &[f32]) -> f64 {
    assert!(!a.is_empty() && !b.is_empty(), "distributions have values");
    let (n, m) = (a.len() as u64, b.len() as u64);
    // Quantile functions are steps at i / n and j / m: all breaks are integer multiples of 1 / (n m).
    let (mut i, mut j, mut at, mut area) = (0u64, 0u64, 0u64, 0.0);
    while i < n && j < m {
        let next = ((i + 1) * m).min((j + 1) * n);
        let apart = f64::from(a[i as usize]) - f64::from(b[j as usize]);
        area += apart.abs() * (next - at) as f64;
        i += u64::from(next == (i + 1) * m);
        j += u64::from(next == (j + 1) * n);
        at = next;
    }
    area / (n as f64 * m as f64)
}

/// Sorts values in increasing order.
pub fn sorted(mut values: Vec<f32>) -> Vec<f32> {
    values.sort_unstable_by(f32::total_cmp);
    values
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    /// The slow truth: both lists repeated to a common length and paired in order.
    fn paired(a: &[f32], b: &[f32]) -> f64 {
        let long = |list: &[f32], times: usize| -> Vec<f32> {
            list.iter().flat_map(|&v| std::iter::repeat_n(v, times)).collect()
        };
        let (long_a, long_b) = (long(a, b.len()), long(b, a.len()));
        let ways = long_a.iter().zip(&long_b).map(|(x, y)| (f64::from(*x) - f64::from(*y)).abs());
        ways.sum::<f64>() / long_a.len() as f64
    }

    proptest! {
        #[test]
        fn merging_steps_equals_pairing(
            a in prop::collection::vec(-5.0f32..5.0, 1..30),
            b in prop::collection::vec(-5.0f32..5.0, 1..30),
        ) {
            let (a, b) = (sorted(a), sorted(b));
            let truth = paired(&a, &b);
            prop_assert!((distance(&a, &b) - truth).abs() < 1e-9);
            prop_assert!((distance(&b, &a) - truth).abs() < 1e-9);
        }
    }

    #[test]
    fn a_shift_is_its_own_distance() {
        let a = sorted((0..100).map(|i| (i * 37 % 100) as f32).collect());
        let b: Vec<f32> = a.iter().map(|v| v + 2.5).collect();
        assert!((distance(&a, &b) - 2.5).abs() < 1e-12);
        assert_eq!(distance(&a, &a), 0.0);
    }
}
