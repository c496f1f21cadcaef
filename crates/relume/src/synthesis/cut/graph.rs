//! The seam of least energy through all filled margins of a block at once, by minimum cut.
//!
//! Kwatra, Schödl, Essa, Turk, Bobick, "Graphcut Textures: Image and Video Synthesis Using Graph Cuts",
//! SIGGRAPH 2003, section 3: a seam between neighbouring texels s and t costs the difference of old and new
//! at both, e(s) + e(t). A cut of one strip is a path with one texel in each row; this one may go back and
//! forth, and corners need no special treatment.
//!
//! As in the paper, the old texels along the edges of filled margins stay, and the texels next to unfilled
//! ones are new, so that each seam runs where both differences are known; only in a margin of one texel do
//! the two coincide, and it is new. The ends of margins are free. Where we differ: e is the squared distance,
//! an exact integer that also decides the search and the cuts of single strips, so that the joins are
//! comparable; the paper uses the distance itself, whose roots would have to be rounded. Earlier seams are
//! not remembered.

use super::max_flow::GridNetwork;
use super::{connected, depths, middle};
use crate::size::Size;
use crate::synthesis::neighbourhood::Neighbourhood;

/// The most memory of [`inside_seam`] per texel of a block.
pub const BYTES_PER_TEXEL: u64 = 160;

/// The cost of a seam at one filled texel.
#[derive(Debug, Clone, Copy)]
struct Links {
    x: usize,
    y: usize,
    /// Between it and its right neighbour; 0 if that is not filled.
    right: u64,
    /// Between it and its lower neighbour; 0 if that is not filled.
    down: u64,
}

/// Whether each texel of a block is taken from the new block, for the least [`seam_energy`]. `error(x, y)` is
/// the squared distance between the existing texel and the new block; it is called for filled texels only.
///
/// Of all such choices the new region is the largest, minus the pieces not connected to the middle of the
/// block, whose seams cost nothing. So both regions are connected: the new one with the middle, the old one
/// with the texels beyond the edges.
pub fn inside_seam(shape: &Neighbourhood, error: impl Fn(usize, usize) -> u64) -> Vec<bool> {
    let size = shape.extent;
    let links: Vec<Links> = links(shape, error).collect();
    let more_than_all = 1 + links.iter().map(|link| link.right + link.down).sum::<u64>();
    let mut network = GridNetwork::new(size);
    for Links { x, y, right, down } in links {
        let is = |new: bool| if given(shape, x, y) == Some(new) { more_than_all } else { 0 };
        network.join_terminals(x, y, is(false), is(true));
        if right > 0 {
            network.join_right(x, y, right);
        }
        if down > 0 {
            network.join_down(x, y, down);
        }
    }
    let old = network.minimum_cut().source_side;
    connected(size, middle(shape), |x, y| !old[size.index(x, y)])
}

/// The cost of the seam around the texels that are `new`.
pub fn seam_energy(shape: &Neighbourhood, error: impl Fn(usize, usize) -> u64, new: &[bool]) -> u64 {
    let is_new = |x: usize, y: usize| new[shape.extent.index(x, y)];
    let cost = |Links { x, y, right, down }: Links| {
        let across = |to: (usize, usize), cost: u64| {
            if cost > 0 && is_new(to.0, to.1) != is_new(x, y) { cost } else { 0 }
        };
        across((x + 1, y), right) + across((x, y + 1), down)
    };
    links(shape, error).map(cost).sum()
}

/// Whether a filled texel has to be new, or old; `None` if the seam decides.
fn given(shape: &Neighbourhood, x: usize, y: usize) -> Option<bool> {
    let Size { width, height } = shape.extent;
    let beside = [(x + 1, y), (x, y + 1), (x.wrapping_sub(1), y), (x, y.wrapping_sub(1))];
    if beside.iter().any(|&(x, y)| x < width && y < height && !shape.contains(x, y)) {
        return Some(true);
    }
    depths(shape, x, y).any(|depth| depth == 1).then_some(false)
}

/// The costs at all filled texels, row by row.
fn links(shape: &Neighbourhood, error: impl Fn(usize, usize) -> u64) -> impl Iterator<Item = Links> {
    let (shape, size) = (*shape, shape.extent);
    let texels = || (0..size.height).flat_map(move |y| (0..size.width).map(move |x| (x, y)));
    let errors: Vec<Option<u64>> = texels().map(|(x, y)| shape.contains(x, y).then(|| error(x, y))).collect();
    let at = move |x: usize, y: usize| {
        if x < size.width && y < size.height { errors[size.index(x, y)] } else { None }
    };
    texels().filter_map(move |(x, y)| {
        let own = at(x, y)?;
        let to = |x: usize, y: usize| at(x, y).map_or(0, |other| own + other);
        Some(Links { x, y, right: to(x + 1, y), down: to(x, y + 1) })
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::synthesis::cut::inside_cuts;
    use crate::synthesis::neighbourhood::Margins;
    use proptest::prelude::*;

    /// Shapes of blocks up to `side`, with errors for all texels.
    fn blocks(side: usize) -> impl Strategy<Value = (Neighbourhood, Vec<u64>)> {
        let sizes = (2..=side, 2..=side, any::<[bool; 4]>(), any::<[u8; 4]>(), 1u64..40);
        sizes.prop_flat_map(|(width, height, filled, widths, most)| {
            let margin = |i: usize, side: usize| {
                if filled[i] { 1 + usize::from(widths[i]) % (side / 2) } else { 0 }
            };
            let margins = Margins {
                left: margin(0, width),
                top: margin(1, height),
                right: margin(2, width),
                bottom: margin(3, height),
            };
            let shape = Neighbourhood { extent: Size::new(width, height), margins };
            (Just(shape), proptest::collection::vec(0..most, width * height))
        })
    }

    /// A choice, corrected where texels have to be new or old.
    fn allowed(shape: &Neighbourhood, choice: impl Fn(usize) -> bool) -> Vec<bool> {
        let width = shape.extent.width;
        let new = |texel: usize| {
            let (x, y) = (texel % width, texel / width);
            if shape.contains(x, y) { given(shape, x, y).unwrap_or_else(|| choice(texel)) } else { true }
        };
        (0..shape.extent.texels()).map(new).collect()
    }

    /// The least energy of all choices of the filled texels.
    fn least_energy(shape: &Neighbourhood, error: &impl Fn(usize, usize) -> u64) -> u64 {
        let choose =
            |choice: u32| seam_energy(shape, error, &allowed(shape, |texel| choice >> texel & 1 == 1));
        (0..1 << shape.extent.texels()).map(choose).min().unwrap_or(0)
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(150))]

        #[test]
        fn no_choice_has_less_energy((shape, errors) in blocks(5)) {
            prop_assume!(shape.extent.texels() <= 16);
            let error = |x: usize, y: usize| errors[shape.extent.index(x, y)];
            let new = inside_seam(&shape, error);
            prop_assert_eq!(seam_energy(&shape, error, &new), least_energy(&shape, &error));
        }

        #[test]
        fn cuts_of_single_strips_never_cost_less((shape, errors) in blocks(24)) {
            let error = |x: usize, y: usize| errors[shape.extent.index(x, y)];
            let (seam, cuts) = (inside_seam(&shape, error), inside_cuts(&shape, error));
            let cuts = allowed(&shape, |texel| cuts[texel]);
            prop_assert!(seam_energy(&shape, error, &seam) <= seam_energy(&shape, error, &cuts));
        }

        #[test]
        fn regions_are_in_one_piece_and_what_is_not_filled_is_new((shape, errors) in blocks(24)) {
            let size = shape.extent;
            let new = inside_seam(&shape, |x, y| errors[size.index(x, y)]);
            for (x, y) in (0..size.height).flat_map(|y| (0..size.width).map(move |x| (x, y))) {
                prop_assert!(new[size.index(x, y)] || shape.contains(x, y));
                if shape.contains(x, y) {
                    prop_assert!(given(&shape, x, y).is_none_or(|given| new[size.index(x, y)] == given));
                }
            }
            let piece = connected(size, middle(&shape), |x, y| new[size.index(x, y)]);
            prop_assert_eq!(&piece, &new);
            for texel in (0..size.texels()).filter(|texel| !new[*texel]) {
                let seed = (texel % size.width, texel / size.width);
                let piece = connected(size, seed, |x, y| !new[size.index(x, y)]);
                let reaches = |t: usize| depths(&shape, t % size.width, t / size.width).any(|d| d == 1);
                prop_assert!((0..size.texels()).any(|t| piece[t] && reaches(t)), "{:?} is cut off", seed);
            }
        }
    }

    #[test]
    fn a_seam_may_go_back_where_a_path_may_not() {
        let shape = Neighbourhood {
            extent: Size::new(9, 9),
            margins: Margins { left: 0, top: 8, right: 0, bottom: 0 },
        };
        // An obstacle from the top and one from the bottom, too close for a path to pass between.
        let error = |x: usize, y: usize| match (x, y) {
            (3, 0..=5) | (6, 2..=7) => 1000,
            _ => 1,
        };
        let new = inside_seam(&shape, error);
        let cuts = inside_cuts(&shape, error);
        let cuts = allowed(&shape, |texel| cuts[texel]);
        let (seam, path) = (seam_energy(&shape, error, &new), seam_energy(&shape, error, &cuts));
        assert!(seam <= 2 * 9 * 3 && path > 1000, "{seam} against {path}");
    }

    #[test]
    fn ties_give_the_largest_new_region() {
        let margins = Margins { left: 3, top: 2, right: 0, bottom: 0 };
        let shape = Neighbourhood { extent: Size::new(9, 8), margins };
        let new_from = |shape: &Neighbourhood, error: u64, left: usize, top: usize| {
            let new = inside_seam(shape, |_, _| error);
            assert!((0..72).all(|t| new[t] == (t % 9 >= left && t / 9 >= top)), "{shape:?}: {new:?}");
        };
        new_from(&shape, 0, 1, 1);
        new_from(&Neighbourhood { margins: Margins { top: 0, ..margins }, ..shape }, 7, 1, 0);
        // Around a corner the inner line is the shortest.
        new_from(&shape, 7, 2, 1);
        // Margins of one texel are new except for their corner, which touches no new texel.
        let thin = Neighbourhood { margins: Margins { left: 1, top: 1, ..Margins::default() }, ..shape };
        let new = inside_seam(&thin, |_, _| 7);
        assert!(!new[0] && new[1..].iter().all(|new| *new));
        let first = Neighbourhood { margins: Margins::default(), ..shape };
        assert!(inside_seam(&first, |_, _| unreachable!("nothing is filled")).into_iter().all(|new| new));
    }

    #[test]
    fn seams_on_four_sides_close_where_they_cost_nothing() {
        let margins = Margins { left: 3, top: 3, right: 3, bottom: 3 };
        let shape = Neighbourhood { extent: Size::new(10, 10), margins };
        // There is no difference at depths 1 and 2, so a seam between them costs nothing.
        let depth = |x: usize, y: usize| x.min(y).min(9 - x).min(9 - y);
        let new = inside_seam(&shape, |x, y| if (1..=2).contains(&depth(x, y)) { 0 } else { 9 });
        let expected: Vec<bool> = (0..100).map(|t| depth(t % 10, t / 10) >= 2).collect();
        assert_eq!(new, expected);
    }
}
