//! Light directions spread evenly over the dome: a spherical Fibonacci lattice (R. Swinbank, R. J.
//! Purser, Fibonacci grids, Q. J. R. Meteorol. Soc. 132, 2006) on the cap within
//! [`MAX_POLAR_DEG`] of the zenith.

use crate::direction::Direction;

/// The polar angle of the lower edge of the dome: real domes end where light would only graze the sample.
pub const MAX_POLAR_DEG: f64 = 75.0;

/// `count` directions from near the zenith to near the lower edge of the dome, each in the middle of an equal
/// share of the area of the cap, consecutive ones a golden angle apart in azimuth.
pub fn lights(count: usize) -> Vec<Direction> {
    let golden_rad = std::f64::consts::PI * (3.0 - 5.0f64.sqrt());
    let lowest_z = MAX_POLAR_DEG.to_radians().cos();
    let light = |i: usize| {
        let z = 1.0 - (1.0 - lowest_z) * (i as f64 + 0.5) / count as f64;
        Direction::from_angles(z.acos(), (i as f64 * golden_rad) % std::f64::consts::TAU)
    };
    (0..count).map(light).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lights_stay_on_the_cap_and_apart() {
        for count in [1, 2, 7, 64, 200] {
            let all = lights(count);
            assert_eq!(all.len(), count);
            let lowest_z = MAX_POLAR_DEG.to_radians().cos();
            assert!(all.iter().all(|l| l.z() >= lowest_z));
            // The side of a square whose area is the share of one light.
            let side = (std::f64::consts::TAU * (1.0 - lowest_z) / count as f64).sqrt();
            for (i, a) in all.iter().enumerate() {
                for b in &all[i + 1..] {
                    assert!(a.dot(*b).acos() > 0.6 * side, "{count} lights");
                }
            }
        }
    }

    #[test]
    fn the_cap_is_covered_evenly() {
        let mean = |f: fn(&Direction) -> f64| lights(500).iter().map(f).sum::<f64>() / 500.0;
        let lowest_z = MAX_POLAR_DEG.to_radians().cos();
        assert!(mean(|l| l.x()).abs() < 2e-3 && mean(|l| l.y()).abs() < 2e-3);
        assert!((mean(|l| l.z()) - 0.5 * (1.0 + lowest_z)).abs() < 1e-6);
        // The mean of x^2 over the cap, from the integral of 1 - z^2.
        let third = (1.0 + lowest_z + lowest_z * lowest_z) / 3.0;
        assert!((mean(|l| l.x() * l.x()) - 0.5 * (1.0 - third)).abs() < 2e-3);
    }
}
