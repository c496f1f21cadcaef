//! The normal distribution.

/// The probability that a standard normal variable is at most `x`, to about 1e-15 for |x| up to 7;
/// 0 and 1 beyond 8. G. Marsaglia, "Evaluating the Normal Distribution", Journal of Statistical
/// Software 11(4), 2004: 1/2 + phi(x) (x + x^3/3 + x^5/(3 5) + ...).
pub fn cumulative(x: f64) -> f64 {
    if x.abs() > 8.0 {
        return if x > 0.0 { 1.0 } else { 0.0 };
    }
    let (mut sum, mut term, mut odd) = (x, x, 1.0);
    loop {
        odd += 2.0;
        term *= x * x / odd;
        let next = sum + term;
        if next == sum {
            break;
        }
        sum = next;
    }
    0.5 + sum * density(x)
}

/// The inverse of [`cumulative`] for probabilities from 1e-12 to 1 - 1e-12, by Newton's method: above 0 the
/// distribution is concave, so steps from 0 never overshoot.
pub fn quantile(probability: f64) -> f64 {
    let upper = probability.max(1.0 - probability);
    let mut x = 0.0;
    for _ in 0..MOST_STEPS {
        let step = (upper - cumulative(x)) / density(x);
        x += step;
        if step < 1e-13 {
            break;
        }
    }
    if probability < 0.5 { -x } else { x }
}

/// Newton's method reaches 7 from 0 in thirty steps; further steps would only repeat rounding errors.
const MOST_STEPS: usize = 40;

fn density(x: f64) -> f64 {
    (-0.5 * x * x).exp() / std::f64::consts::TAU.sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_distribution_is_the_integral_of_the_density() {
        let (mut sum, steps) = (0.0, 16_000);
        let h = 16.0 / f64::from(steps);
        for i in 0..steps {
            let x = -8.0 + f64::from(i) * h;
            // Simpson's rule.
            sum += h / 6.0 * (density(x) + 4.0 * density(x + 0.5 * h) + density(x + h));
            assert!((cumulative(x + h) - sum).abs() < 1e-12, "{x}");
        }
        assert_eq!((cumulative(9.0), cumulative(-9.0)), (1.0, 0.0));
    }

    #[test]
    fn quantiles_invert_it() {
        for p in [1e-9, 1e-4, 0.02, 0.3, 0.5, 0.77, 0.999, 1.0 - 1e-9] {
            assert!((cumulative(quantile(p)) - p).abs() < 1e-12);
        }
    }
}
