//! The position of a lamp from the rays of several balls: the point nearest to all of them in the sum of squares.

use super::MirrorBall;
use crate::direction::Direction;
use crate::numeric::small::solve_spd;
use crate::size::Size;

/// The place on a ball where a lamp is mirrored, in pixels from the upper left corner, x right, y *down*, z up from
/// the plane on which the balls lie.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Reflection([f64; 3]);

/// Rays that differ by less than this do not meet at a place that is known.
const LEAST_ANGLE_RAD: f64 = 0.6 * std::f64::consts::PI / 180.0;

impl Reflection {
    pub fn new(ball: &MirrorBall, normal: [f64; 3]) -> Self {
        let [x, y, z] = normal.map(|n| n * ball.radius);
        Self([ball.x + x, ball.y - y, ball.radius + z])
    }

    /// The same from the middle of the picture, y up.
    fn centred(self, size: Size) -> [f64; 3] {
        let [x, y, z] = self.0;
        [x - 0.5 * size.width as f64, 0.5 * size.height as f64 - y, z]
    }
}

/// Where the rays meet, in pixels from the middle of the picture, y up; `None` where they are nearly parallel or meet
/// below the surface.
pub(super) fn meet(rays: &[(Reflection, Direction)], size: Size) -> Option<[f64; 3]> {
    let apart = |a: Direction, b: Direction| a.dot(b).clamp(-1.0, 1.0).acos();
    let widest = rays
        .iter()
        .enumerate()
        .flat_map(|(i, a)| rays[..i].iter().map(move |b| apart(a.1, b.1)))
        .fold(0.0, f64::max);
    if widest < LEAST_ANGLE_RAD {
        return None;
    }
    // Sum of (1 - d d') over the rays, and of its products with their origins.
    let (mut matrix, mut right) = ([[0.0; 3]; 3], [0.0; 3]);
    for (origin, direction) in rays {
        let (origin, d) = (origin.centred(size), direction.to_array());
        for i in 0..3 {
            for j in 0..3 {
                let projection = f64::from(u8::from(i == j)) - d[i] * d[j];
                matrix[i][j] += projection;
                right[i] += projection * origin[j];
            }
        }
    }
    let found = solve_spd(&matrix, &right)?;
    let ahead = rays.iter().all(|(origin, direction)| {
        let origin = origin.centred(size);
        let away = (0..3).map(|k| (found[k] - origin[k]) * direction.to_array()[k]).sum::<f64>();
        away > 0.0
    });
    (ahead && found[2] > 0.0).then_some(found)
}
