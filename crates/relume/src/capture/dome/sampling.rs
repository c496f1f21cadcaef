//! Pairs of light and view directions at which a bidirectional texture function is measured.
//!
//! Angles are whole multiples of a hundredth of a degree, so that the names of files can say them exactly.

use super::lights::MAX_POLAR_DEG;
use crate::direction::{Direction, Directions};
use crate::names::named;
use crate::numeric::random::{Purpose, Stream};

/// Directions of a measuring device, used for lights and views alike.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum DirectionSampling {
    /// The 81 directions of the textures measured in Bonn (M. Sattler, R. Sarlette, R. Klein, Efficient and realistic
    /// visualization of cloth, EGSR 2003): rings at 0, 15, 30, 45, 60 and 75 degrees of 1, 6, 12, 18, 20 and 24.
    Bonn,
    /// 151 directions, as many as the camera dome of Bonn has (G. Müller, G. H. Bendels, R. Klein, Rapid synchronous
    /// acquisition of geometry and appearance of cultural heritage artefacts, VAST 2005), of our own arrangement:
    /// rings at 0, 12.5, 25, 37.5, 50, 62.5 and 75 degrees of 1, 8, 16, 24, 30, 36 and 36.
    Dome,
}

named!(DirectionSampling { Bonn => "bonn", Dome => "dome" });

impl DirectionSampling {
    /// The rings: polar angle in degrees, and the number of azimuths, the first of which is 0.
    fn rings(self) -> &'static [(f64, u32)] {
        match self {
            Self::Bonn => &[(0.0, 1), (15.0, 6), (30.0, 12), (45.0, 18), (60.0, 20), (75.0, 24)],
            Self::Dome => &[(0.0, 1), (12.5, 8), (25.0, 16), (37.5, 24), (50.0, 30), (62.5, 36), (75.0, 36)],
        }
    }

    /// The directions, ring by ring from the zenith, azimuths ascending.
    pub fn directions(self) -> Vec<Direction> {
        let ring = |&(polar, count): &(f64, u32)| {
            (0..count).map(move |k| from_degrees(polar, 360.0 * f64::from(k) / f64::from(count)))
        };
        self.rings().iter().flat_map(ring).collect()
    }
}

/// `count` random directions that keep apart, from near the zenith to [`MAX_POLAR_DEG`]: each lies at a random height
/// within an equal share of the area of the cap, a golden angle after the one before, from a random azimuth on.
pub fn spread_directions(count: usize, seed: u64) -> Vec<Direction> {
    let golden_deg = 180.0 * (3.0 - 5.0f64.sqrt());
    let mut stream = Stream::new(seed, Purpose::SpreadDirections, [count as u64]);
    let first = 360.0 * stream.unit();
    let direction = |k: usize| {
        let share = (k as f64 + stream.unit()) / count as f64;
        from_degrees(polar_deg(share), (first + k as f64 * golden_deg) % 360.0)
    };
    (0..count).map(direction).collect()
}

/// `count` pairs of a light and a view, all independent and evenly distributed over the cap of [`MAX_POLAR_DEG`].
pub fn random_pairs(count: usize, seed: u64) -> Vec<Directions> {
    let pair = |k: usize| {
        let mut stream = Stream::new(seed, Purpose::RandomDirections, [k as u64]);
        let mut direction = || from_degrees(polar_deg(stream.unit()), 360.0 * stream.unit());
        Directions { light: direction(), view: direction() }
    };
    (0..count).map(pair).collect()
}

/// All pairs of lights and views, all lights of the first view first.
pub fn all_pairs(lights: &[Direction], views: &[Direction]) -> Vec<Directions> {
    views.iter().flat_map(|&view| lights.iter().map(move |&light| Directions { light, view })).collect()
}

/// The polar angle that encloses a share of the area of the cap.
fn polar_deg(share: f64) -> f64 {
    (1.0 - (1.0 - MAX_POLAR_DEG.to_radians().cos()) * share).acos().to_degrees()
}

/// The direction at whole hundredths of these degrees.
fn from_degrees(polar: f64, azimuth: f64) -> Direction {
    let [polar, azimuth] = [polar, azimuth].map(|deg| ((deg * 100.0).round() / 100.0).to_radians());
    Direction::from_angles(polar, azimuth)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_samplings_are_the_rings_they_name() {
        let bonn = DirectionSampling::Bonn.directions();
        assert_eq!((bonn.len(), DirectionSampling::Dome.directions().len()), (81, 151));
        assert_eq!(bonn[0], Direction::ZENITH);
        assert_eq!(bonn[1], Direction::from_angles(15f64.to_radians(), 0.0));
        assert_eq!(bonn[80], Direction::from_angles(75f64.to_radians(), 345f64.to_radians()));
        assert_eq!(all_pairs(&bonn, &bonn).len(), 6561);
        assert_eq!(all_pairs(&bonn, &bonn)[82], Directions { light: bonn[1], view: bonn[1] });
    }

    #[test]
    fn spread_directions_keep_apart_on_the_cap() {
        let lowest_z = MAX_POLAR_DEG.to_radians().cos() - 1e-4;
        for (count, seed) in [(1, 0), (5, 1), (40, 2), (200, 3)] {
            let all = spread_directions(count, seed);
            assert!(all.len() == count && all.iter().all(|d| d.z() >= lowest_z));
            assert_ne!(all, spread_directions(count, seed + 1));
            let side = (std::f64::consts::TAU * (1.0 - lowest_z) / count as f64).sqrt();
            for (i, a) in all.iter().enumerate() {
                assert!(
                    all[i + 1..].iter().all(|b| a.dot(*b).min(1.0).acos() > 0.3 * side),
                    "{count} directions"
                );
            }
        }
    }

    #[test]
    fn random_pairs_cover_the_cap_evenly_and_independently() {
        let pairs = random_pairs(4000, 7);
        let mean = |f: &dyn Fn(&Directions) -> f64| pairs.iter().map(f).sum::<f64>() / pairs.len() as f64;
        let middle = 0.5 * (1.0 + MAX_POLAR_DEG.to_radians().cos());
        assert!((mean(&|p| p.light.z()) - middle).abs() < 0.02);
        assert!((mean(&|p| p.view.z()) - middle).abs() < 0.02);
        assert!(mean(&|p| p.view.x() * p.light.x()).abs() < 0.02);
        assert_eq!(random_pairs(10, 7), pairs[..10], "a pair belongs to its number");
    }
}
