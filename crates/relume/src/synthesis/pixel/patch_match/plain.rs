//! The slow truths: distances of patches texel by texel, and votes texel by texel.

use super::super::canvas::PixelCanvas;
use super::patches::ExemplarPatches;
use super::search::Matching;
use crate::synthesis::source_map::Texel;

/// The squared distance of the patch of the output around a position and one of the exemplars.
pub fn distance(
    canvas: &PixelCanvas,
    patches: &ExemplarPatches<'_>,
    middle: (usize, usize),
    corner: Texel,
) -> u64 {
    let exemplar = &patches.level().exemplars.texels()[corner.exemplar as usize];
    let radius = patches.radius().cast_signed();
    let mut sum = 0;
    for (dx, dy) in (0..patches.window()).flat_map(|dy| (0..patches.window()).map(move |dx| (dx, dy))) {
        let beside = canvas.beside(middle, dx.cast_signed() - radius, dy.cast_signed() - radius);
        let ours = canvas.codes(beside.expect("a torus has no edge"));
        let theirs = exemplar.run(corner.x as usize + dx, corner.y as usize + dy, 1);
        sum += ours.iter().zip(theirs).map(|(a, b)| u64::from(a.abs_diff(*b)).pow(2)).sum::<u64>();
    }
    sum
}

/// The texels that the matches of the patches over a texel propose, each with the weight of its match.
fn wanted(
    canvas: &PixelCanvas,
    patches: &ExemplarPatches<'_>,
    matching: &Matching,
    weights: &[u32],
    texel: usize,
) -> Vec<(Texel, u32)> {
    let mut wanted = Vec::new();
    let window = 0..patches.window();
    let radius = patches.radius().cast_signed();
    for (number, middle) in Matching::middles(canvas.size()).enumerate() {
        for (dx, dy) in window.clone().flat_map(|dy| window.clone().map(move |dx| (dx, dy))) {
            let there = canvas.beside(middle, dx.cast_signed() - radius, dy.cast_signed() - radius);
            if there == Some(texel) {
                wanted.push((matching.at(middle).corner.offset(dx, dy), weights[number]));
            }
        }
    }
    wanted
}

/// The source of a texel: of all proposals the nearest to their weighted mean, the first of the texels of the
/// exemplars among equals.
pub fn elect(
    canvas: &PixelCanvas,
    patches: &ExemplarPatches<'_>,
    matching: &Matching,
    weights: &[u32],
    texel: usize,
) -> Texel {
    let wanted = wanted(canvas, patches, matching, weights, texel);
    let code = |source: &Texel, k: usize| {
        let exemplar = &patches.level().exemplars.texels()[source.exemplar as usize];
        i128::from(exemplar.run(source.x as usize, source.y as usize, 1)[k])
    };
    let total: i128 = wanted.iter().map(|(_, weight)| i128::from(*weight)).sum();
    let distance = |source: &Texel| -> i128 {
        let planes = 0..patches.level().exemplars.planes() - canvas.guides();
        let sum = |k: usize| wanted.iter().map(|(s, w)| i128::from(*w) * code(s, k)).sum::<i128>();
        planes.map(|k| (code(source, k) * total - sum(k)).pow(2)).sum()
    };
    let nearest = wanted.iter().map(|(source, _)| (distance(source), *source)).min();
    nearest.expect("every texel lies under a patch").1
}
