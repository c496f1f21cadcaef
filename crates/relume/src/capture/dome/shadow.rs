//! Cast shadows: the share of the disk of the lamp that is visible to each texel over the relief.

use super::march::{Heading, crossings, steepest_slopes};
use super::relief::Relief;
use crate::direction::Direction;
use crate::error::Result;
use crate::job::Job;
use crate::parallel;
/// The least elevation of the lower edge of a lamp, which limits the length of rays.
const LEAST_ELEVATION_RAD: f64 = 0.01;

/// The visible share of a lamp of angular radius `lamp_radius_rad` for every texel, row by row.
///
/// Only the horizon in the azimuth of the lamp is used, as if it ran level across the disk.
///
/// # Errors
/// A cancelled job.
pub fn lamp_share(relief: &Relief, light: Direction, lamp_radius_rad: f64, job: &Job) -> Result<Vec<f32>> {
    let level = light.x().hypot(light.y());
    let mut share = vec![1.0f32; relief.size().texels()];
    if level < 1e-9 {
        return Ok(share);
    }
    let heading = Heading { column: light.x() / level, row: -light.y() / level };
    let elevation = light.z().atan2(level);
    let lower_edge = (elevation - lamp_radius_rad).max(LEAST_ELEVATION_RAD).tan();
    let path = crossings(heading, relief.reach().min(f64::from(relief.range()) / lower_edge));
    parallel::try_for_each(share.chunks_mut(relief.size().width).enumerate(), |(y, row)| {
        job.proceed()?;
        row.fill(f32::MIN);
        steepest_slopes(relief, &path, y, lower_edge as f32, row);
        for value in row {
            *value = disk_share(elevation - f64::from(*value).atan(), lamp_radius_rad) as f32;
        }
        Ok(())
    })?;
    Ok(share)
}

/// The share of a disk above a level line that runs `above_rad` below its middle.
fn disk_share(above_rad: f64, radius_rad: f64) -> f64 {
    if above_rad >= radius_rad {
        1.0
    } else if above_rad <= -radius_rad {
        0.0
    } else {
        let s = above_rad / radius_rad;
        0.5 + (s * (1.0 - s * s).sqrt() + s.asin()) / std::f64::consts::PI
    }
}

#[cfg(test)]
mod tests {
    use super::super::march::slope_by_brute_force;
    use super::super::relief::{ReliefBorder, relief_of as relief};
    use super::*;
    use crate::numeric::quadrature::gauss_legendre;
    use crate::size::Size;

    #[test]
    fn a_wall_casts_a_shadow_of_its_height_over_the_tangent() {
        for (degrees, height) in [(30.0f64, 10.0), (45.0, 7.5), (60.0, 12.5), (20.0, 6.0)] {
            let wall =
                relief(Size::new(64, 5), ReliefBorder::Clamp, |x, _| if x >= 40.0 { height } else { 0.0 });
            let light = Direction::from_angles((90.0 - degrees).to_radians(), 0.0);
            let share = lamp_share(&wall, light, 0.0, &Job::default()).unwrap();
            let length = height / degrees.to_radians().tan();
            for x in 0..64 {
                let shadowed = x < 40 && (40 - x) as f64 <= length;
                let lit = f32::from(u8::from(!shadowed));
                assert_eq!(share[2 * 64 + x], lit, "{degrees} degrees, texel {x}, shadow of {length}");
            }
        }
    }

    #[test]
    fn shadows_fall_away_from_the_light_on_all_four_sides() {
        let size = Size::new(41, 41);
        let post = relief(size, ReliefBorder::Clamp, |x, y| if (x, y) == (20.0, 20.0) { 8.0 } else { 0.0 });
        // A light above the top of the picture (y up) throws the shadow down the rows.
        for (azimuth, [dx, dy]) in [(0.0f64, [-1, 0]), (90.0, [0, 1]), (180.0, [1, 0]), (270.0, [0, -1])] {
            let share =
                lamp_share(&post, Direction::from_angles(0.8, azimuth.to_radians()), 0.0, &Job::default())
                    .unwrap();
            let at = |k: i32| share[size.index((20 + k * dx) as usize, (20 + k * dy) as usize)];
            assert_eq!([at(-3), at(0), at(3), at(5)], [1.0, 1.0, 0.0, 0.0], "azimuth {azimuth}");
        }
    }

    #[test]
    fn shadows_of_a_cone_and_a_hemisphere_agree_with_brute_force() {
        let size = Size::new(64, 48);
        let radius = |x: f64, y: f64| (x - 30.0).hypot(y - 22.0);
        let cone = relief(size, ReliefBorder::Clamp, |x, y| 1.3 * (12.0 - radius(x, y)).max(0.0));
        let ball = relief(size, ReliefBorder::Wrap, |x, y| (169.0 - radius(x, y).powi(2)).max(0.0).sqrt());
        for (relief, lights) in [(&cone, [(0.9, 0.3), (1.2, 2.5)]), (&ball, [(1.1, 4.0), (1.3, 5.9)])] {
            for (polar, azimuth) in lights {
                let light = Direction::from_angles(polar, azimuth);
                let share = lamp_share(relief, light, 0.0, &Job::default()).unwrap();
                let (heading, slope) = (Heading::from_azimuth(azimuth), 1.0 / polar.tan());
                let slow = |i: usize| {
                    let texel = [i % 64, i / 64];
                    let seen = slope_by_brute_force(relief, texel, heading, relief.reach(), 1.0 / 16.0);
                    f32::from(u8::from(seen <= slope))
                };
                let wrong = (0..size.texels()).filter(|&i| share[i] != slow(i)).count();
                let shadowed = share.iter().filter(|s| **s == 0.0).count();
                assert!(shadowed > 100, "{shadowed} texels in shadow");
                // Only texels on the outline of the shadow may differ.
                assert!(wrong * 200 <= size.texels(), "{wrong} texels differ, {shadowed} in shadow");
            }
        }
    }

    #[test]
    fn the_share_of_a_disk_is_its_integral() {
        for above in [-0.9, -0.3, 0.0, 0.55, 0.97] {
            // Area of the unit disk above -above, by chords.
            let (low, high) = (-above, 1.0);
            let chord = |t: f64| 2.0 * (1.0 - t * t).max(0.0).sqrt();
            let place = |x: f64| 0.5 * (low + high) + 0.5 * (high - low) * x;
            let sum: f64 = gauss_legendre(200).iter().map(|(x, w)| w * chord(place(*x))).sum();
            let area = 0.5 * (high - low) * sum / std::f64::consts::PI;
            assert!((disk_share(0.2 * above, 0.2) - area).abs() < 1e-6, "{above}");
        }
        assert_eq!((disk_share(0.0, 0.0), disk_share(-1e-9, 0.0)), (1.0, 0.0));
    }
}
