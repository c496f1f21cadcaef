//! From matches to texels: each becomes the exemplar texel, among those that the matches of the
//! patches over it put there, that is nearest to their mean.

use rayon::prelude::*;

use super::super::lattice::Lattice;
use super::super::pyramid::Level;
use super::SPACING;
use super::search::{Matching, Patches};
use crate::synthesis::source_map::Texel;

/// Puts every texel anew.
pub fn cast(lattice: &mut Lattice, level: &Level, patches: &Patches, matching: &Matching) {
    let texels = lattice.size().texels();
    let elect = |texel: usize| elect(lattice, level, patches, matching, texel);
    let sources: Vec<Texel> = (0..texels).into_par_iter().with_min_len(256).map(elect).collect();
    for (texel, source) in sources.into_iter().enumerate() {
        lattice.put(texel, source, &level.exemplars);
    }
}

/// The source of a texel; the first among equals.
fn elect(lattice: &Lattice, level: &Level, patches: &Patches, matching: &Matching, texel: usize) -> Texel {
    let wanted = wanted(lattice, patches, matching, texel);
    let codes = |source: &Texel| {
        level.exemplars.texels()[source.exemplar as usize].run(source.x as usize, source.y as usize, 1)
    };
    let count = wanted.len() as i32;
    let mut sums = vec![0i32; level.exemplars.planes()];
    for source in &wanted {
        sums.iter_mut().zip(codes(source)).for_each(|(sum, &code)| *sum += i32::from(code));
    }
    // Distances to the mean times the count, so that they stay integers.
    let distance = |source: &Texel| -> i64 {
        let differences = codes(source).iter().zip(&sums).map(|(&code, &sum)| i32::from(code) * count - sum);
        differences.map(|difference| i64::from(difference).pow(2)).sum()
    };
    *wanted.iter().min_by_key(|source| distance(source)).expect("every texel lies under a patch")
}

/// What the matches of the patches over a texel put there.
fn wanted(lattice: &Lattice, patches: &Patches, matching: &Matching, texel: usize) -> Vec<Texel> {
    let (place, radius) = (lattice.place(texel), patches.radius());
    let beside = |dx, dy| lattice.place(lattice.beside(place, dx, dy).expect("a torus has no edge"));
    let columns = (-radius..=radius).map(|dx| (dx, beside(dx, 0).0)).filter(|(_, x)| x % SPACING == 0);
    let columns: Vec<(isize, usize)> = columns.collect();
    let rows = (-radius..=radius).map(|dy| (dy, beside(0, dy).1)).filter(|(_, y)| y % SPACING == 0);
    let middles = rows.flat_map(|row| columns.iter().map(move |column| (row, *column)));
    let source = |((dy, y), (dx, x)): ((isize, usize), (isize, usize))| {
        patches.place(matching.at((x, y))).moved(-dx, -dy)
    };
    middles.map(|middle| source(middle).expect("a patch lies inside its exemplar")).collect()
}
