//! Contextual neighbourhoods: the texels from which a texel is predicted.

use std::fmt;

/// The position of a neighbour relative to the texel, in texels: x to the right, y down.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct Offset {
    /// Texels to the right.
    pub dx: i32,
    /// Texels down.
    pub dy: i32,
}

impl Offset {
    /// A neighbour `dx` to the right and `dy` down.
    pub const fn new(dx: i32, dy: i32) -> Self {
        Self { dx, dy }
    }

    /// Squared distance.
    pub const fn square(self) -> i32 {
        self.dx * self.dx + self.dy * self.dy
    }

    /// Whether it comes before the texel in raster order: a row above, or in the row to the left.
    pub const fn is_causal(self) -> bool {
        self.dy < 0 || (self.dy == 0 && self.dx < 0)
    }
}

impl fmt::Display for Offset {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "({}, {})", self.dx, self.dy)
    }
}

/// The first `count` causal neighbours by distance; ties by row from that of the texel upwards, then from
/// left to right. Rings of equal distance may be cut.
pub fn causal(count: usize) -> Vec<Offset> {
    grown(count, Offset::is_causal)
}

/// The first `count` neighbours by distance in all directions, the texel itself first.
pub fn all_around(count: usize) -> Vec<Offset> {
    grown(count, |_| true)
}

/// The sizes of the causal neighbourhoods that are half disks, up to `most`: 2, 4, 6, 10, 12, 14 ...
pub fn half_disks(most: usize) -> Vec<usize> {
    let offsets = causal(most + 1);
    (1..=most).filter(|&n| offsets[n - 1].square() < offsets[n].square()).collect()
}

fn grown(count: usize, wanted: impl Fn(Offset) -> bool) -> Vec<Offset> {
    // A half disk of radius r holds more than r^2 texels, so this radius suffices.
    let reach = 1 + (count as f64).sqrt().ceil() as i32;
    let square = (-reach..=reach).flat_map(|dy| (-reach..=reach).map(move |dx| Offset::new(dx, dy)));
    let mut offsets: Vec<Offset> = square.filter(|&o| wanted(o) && o.square() <= reach * reach).collect();
    offsets.sort_by_key(|o| (o.square(), -o.dy, o.dx));
    offsets.truncate(count);
    offsets
}

/// The extent of a neighbourhood around its texel.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Reach {
    /// Texels to the left.
    pub left: usize,
    /// Texels to the right.
    pub right: usize,
    /// Rows above.
    pub up: usize,
    /// Rows below.
    pub down: usize,
}

impl Reach {
    /// The reach of given neighbours.
    pub fn of(offsets: &[Offset]) -> Self {
        let most = |f: fn(&Offset) -> i32| offsets.iter().map(f).max().unwrap_or(0).max(0) as usize;
        Self { left: most(|o| -o.dx), right: most(|o| o.dx), up: most(|o| -o.dy), down: most(|o| o.dy) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn neighbourhoods_grow_by_distance_and_are_prefixes_of_each_other() {
        let longest = causal(112);
        assert_eq!(longest[..2], [Offset::new(-1, 0), Offset::new(0, -1)]);
        assert!(longest.iter().all(|o| o.is_causal()));
        for count in 0..112 {
            assert_eq!(causal(count), longest[..count]);
        }
        // No nearer causal texel was left out.
        for (count, last) in [(6, 4), (40, 25), (112, 72)] {
            let inside = (-20..=20)
                .flat_map(|dy| (-20..=20).map(move |dx| Offset::new(dx, dy)))
                .filter(|o| o.is_causal() && o.square() <= last);
            assert_eq!(inside.count(), count);
            assert_eq!(longest[count - 1].square(), last);
        }
    }

    #[test]
    fn half_disks_are_whole_rings() {
        assert_eq!(half_disks(40), [2, 4, 6, 10, 12, 14, 18, 22, 24, 28, 30, 34, 40]);
        assert_eq!(all_around(5)[0], Offset::new(0, 0));
        assert_eq!(Reach::of(&causal(6)), Reach { left: 2, right: 1, up: 2, down: 0 });
        assert_eq!(Reach::of(&[]), Reach::default());
    }
}
