//! What the neighbours of a texel do not predict: the noise of a level as it is in the material.

use super::level::Level;
use super::neighbourhood::{Offset, Reach};
use crate::parallel;
use crate::planes::Planes;
use crate::size::Size;

/// A stack of the m planes of a band, and of the m planes of the expanded coarser level if the level has neighbours there,
/// minus what the neighbours predict, at the texels all of whose neighbours are inside.
///
/// # Panics
/// When the stack has no such texel.
pub(super) fn innovations(level: &Level, stack: &Planes) -> Planes {
    let (m, size) = (level.planes(), stack.size());
    let [own, coarse] = [false, true].map(|coarse| level.weights.values(coarse));
    let all: Vec<Offset> = level.neighbours.iter().chain(&level.coarse).copied().collect();
    let reach = Reach::of(&all);
    let inner = Size::new(size.width - reach.left - reach.right, size.height - reach.up - reach.down);
    let mut out = Planes::zeros(inner, m);
    for (j, plane) in out.iter_mut().enumerate() {
        parallel::for_each(plane.chunks_exact_mut(inner.width).enumerate(), |(y, row)| {
            let part = |plane: usize, o: Offset| {
                let x = reach.left.wrapping_add_signed(o.dx as isize);
                let y = (y + reach.up).wrapping_add_signed(o.dy as isize);
                &stack.plane(plane)[size.index(x, y)..][..inner.width]
            };
            row.copy_from_slice(part(j, Offset::new(0, 0)));
            let sets = [(&level.neighbours, &own, 0), (&level.coarse, &coarse, m)];
            for (offsets, weights, first) in sets {
                for (offset, weights) in offsets.iter().zip(weights.chunks_exact(m * m)) {
                    for i in 0..m {
                        let weight = weights[i * m + j];
                        row.iter_mut().zip(part(first + i, *offset)).for_each(|(out, v)| *out -= weight * v);
                    }
                }
            }
        });
    }
    out
}

#[cfg(test)]
mod tests {
    use super::super::neighbourhood::causal;
    use super::super::recursion::tests::random_level;
    use super::super::recursion::{Recursion, RecursionRun};
    use super::*;

    #[test]
    fn a_recursion_is_undone() {
        let level = random_level(3, 6, 2);
        let plain = Level { neighbours: Vec::new(), weights: random_level(3, 0, 2).weights, ..level.clone() };
        let run =
            RecursionRun { size: Size::new(40, 30), drive: None, strength: None, seed: 5, period: None };
        let made = |level: &Level| Recursion::new(level, 1).run_slow([0, 0], &run);
        let (field, noise) = (made(&level), made(&plain));
        let left = innovations(&level, &field);
        let reach = Reach::of(&causal(6));
        let noise = noise.crop(reach.left, reach.up, left.size()).unwrap();
        let error = left.as_slice().iter().zip(noise.as_slice()).map(|(a, b)| (a - b).abs());
        assert!(error.fold(0.0, f32::max) < 1e-4);
    }
}
