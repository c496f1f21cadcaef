//! The part of shifts that follows the light: shadows and shading move edges with the lamp, and cameras do not.
//!
//! What of the shifts is linear in the direction of the light is found by least squares with Cauchy's weights, squared, so that frames
//! that did move have little say. It is taken out where it explains much of the usual shift.

use super::reading::median;
use crate::direction::Direction;
use crate::numeric::small::solve_spd;

/// The fewest frames that are compared with their lights, and the part of the usual shift that must be explained.
const FEWEST: usize = 12;
const LEAST_EXPLAINED: f64 = 0.3;
/// Rounds of weights, and the least deviation of shifts, in pixels.
const ROUNDS: usize = 12;
const LEAST_DEVIATION: f64 = 0.02;

/// Takes out of known shifts (right, down) what follows the light; the most that is taken out of one, in pixels.
pub(super) fn taken_out(shifts: &mut [Option<[f64; 2]>], lights: &[Direction]) -> f64 {
    let (rows, values): (Vec<[f64; 3]>, Vec<[f64; 2]>) = lights
        .iter()
        .zip(shifts.iter())
        .filter_map(|(light, shift)| Some(([1.0, light.x(), light.y()], (*shift)?)))
        .unzip();
    if rows.len() < FEWEST {
        return 0.0;
    }
    let axes = [0, 1].map(|axis| values.iter().map(|shift| shift[axis]).collect::<Vec<f64>>());
    let [Some(right), Some(down)] = axes.each_ref().map(|axis| fitted(&rows, axis)) else { return 0.0 };
    let still = axes.map(|axis| [median(axis), 0.0, 0.0]);
    if usual(&rows, &values, [right, down]) > (1.0 - LEAST_EXPLAINED) * usual(&rows, &values, still) {
        return 0.0;
    }
    let mut most = 0.0f64;
    for (light, shift) in lights.iter().zip(shifts) {
        let part = [right, down].map(|line| line[1] * light.x() + line[2] * light.y());
        if let Some([x, y]) = shift {
            most = most.max(part[0].hypot(part[1]));
            (*x, *y) = (*x - part[0], *y - part[1]);
        }
    }
    most
}

/// The median length of what shifts are off from lines.
fn usual(rows: &[[f64; 3]], values: &[[f64; 2]], lines: [[f64; 3]; 2]) -> f64 {
    let off = |(row, shift): (&[f64; 3], &[f64; 2])| {
        let [right, down] = [0, 1].map(|axis| shift[axis] - product(lines[axis], *row));
        right.hypot(down)
    };
    median(rows.iter().zip(values).map(off).collect())
}

/// The line through values over rows.
fn fitted(rows: &[[f64; 3]], values: &[f64]) -> Option<[f64; 3]> {
    let mut line = [median(values.to_vec()), 0.0, 0.0];
    for _ in 0..ROUNDS {
        let residuals: Vec<f64> = rows.iter().zip(values).map(|(row, v)| v - product(line, *row)).collect();
        let deviation = (1.4826 * median(residuals.iter().map(|r| r.abs()).collect())).max(LEAST_DEVIATION);
        let (mut matrix, mut right) = ([[0.0; 3]; 3], [0.0; 3]);
        for ((row, value), residual) in rows.iter().zip(values).zip(residuals) {
            let weight = (1.0 + (residual / deviation).powi(2)).powi(-2);
            for i in 0..3 {
                right[i] += weight * row[i] * value;
                (0..3).for_each(|j| matrix[i][j] += weight * row[i] * row[j]);
            }
        }
        line = solve_spd(&matrix, &right)?;
    }
    Some(line)
}

fn product(line: [f64; 3], row: [f64; 3]) -> f64 {
    line.iter().zip(row).map(|(a, b)| a * b).sum()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A fault: edges that moved with the shadows passed for a camera that moved, and normals got twice as wrong.
    #[test]
    fn what_follows_the_light_is_taken_out_and_what_moved_stays() {
        let lights: Vec<Direction> = (0..30).map(|i| Direction::fibonacci(30)(i)).collect();
        let wobble = |i: usize| 0.02 * ((7 * i) % 5) as f64 - 0.04;
        let moved = |i: usize| if i % 10 == 4 { [6.0, -3.0] } else { [0.0; 2] };
        let shift = |i: usize| {
            let [right, down] = moved(i);
            Some([right + 0.5 * lights[i].x() + wobble(i), down - 0.45 * lights[i].y() - wobble(i)])
        };
        let mut shifts: Vec<Option<[f64; 2]>> = (0..30).map(shift).collect();
        shifts[7] = None;
        let most = taken_out(&mut shifts, &lights);
        assert!((0.3..0.6).contains(&most), "{most}");
        for (i, shift) in shifts.iter().enumerate() {
            let Some([right, down]) = *shift else { continue };
            assert!((right - moved(i)[0]).abs() < 0.1 && (down - moved(i)[1]).abs() < 0.1, "{i}: {shift:?}");
        }
        assert_eq!(shifts[7], None);
    }

    /// A hand-held camera: nothing of its motion follows the lights, and few frames tell nothing.
    #[test]
    fn motion_that_does_not_follow_the_light_stays() {
        let lights: Vec<Direction> = (0..24).map(|i| Direction::fibonacci(24)(i)).collect();
        let by_hand = |i: usize| Some([((5 * i) % 7) as f64 - 3.0, ((3 * i) % 11) as f64 - 5.0]);
        let before: Vec<Option<[f64; 2]>> = (0..24).map(by_hand).collect();
        let mut after = before.clone();
        assert_eq!(taken_out(&mut after, &lights), 0.0);
        assert_eq!(after, before);
        let mut few: Vec<Option<[f64; 2]>> =
            lights[..11].iter().map(|light| Some([light.x(), light.y()])).collect();
        assert_eq!(taken_out(&mut few, &lights[..11]), 0.0);
    }
}
