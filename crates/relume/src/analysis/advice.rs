//! From measurements to suggestions: methods of synthesis to try, the most promising first.
//!
//! The table behind it was measured (`docs/methods.md`). On photographs and fabrics of 256 x 256 texels,
//! blocks joined along cuts are nearest to their exemplar by the patch distance when their side is a quarter
//! to an eleventh of that of the exemplar. The best of these differs from texture to texture and, by a tenth
//! to a third, from seed to seed. So several sizes are suggested, within bounds from the analysis: a block
//! holds three features, and one period if the texture is plainly regular. Where there is a period, tiles of
//! whole periods are worth a try as well, and where they are few and large, their elements laid one by one,
//! even if the lattice is uncertain. Optimisation by patches is worth one everywhere: it is the nearest
//! on some pictures of stones. Of the methods that place single texels, only scanlines of continued pieces
//! (Wei-Levoy with a coherence of 1) were ever within a tenth of the best, on textures without a period.
//! Noise was not, and has no source map.
//!
//! Of several exemplars all are analysed: blocks fit the smallest, and hold three features, and a period, of
//! each. Tiles are made from a single exemplar only.

use serde::Serialize;

use super::{Analysis, Extents};
use crate::numeric::periods::Pattern;
use crate::size::Size;

/// Sides of blocks as fractions of the smaller side of the exemplar, and overlaps as fractions of the block:
/// a sixth is customary (Efros, Freeman 2001), a third makes cuts smoother.
const BLOCKS: [(f64, usize); 5] = [(4.0, 6), (6.0, 6), (8.0, 6), (11.0, 6), (4.0, 3)];
/// The least number of features across a block.
const LEAST_FEATURES: f64 = 3.0;
/// Tiles of a set: each takes about a quarter of the exemplar.
const TILES: usize = 4;
/// Up to so many periods along the smaller side, the elements of a lattice are few and large enough to be laid
/// one by one.
const FEW_PERIODS: f64 = 5.0;
/// The coherence from which a texture counts as oriented.
const ORIENTED: f64 = 0.4;
/// The kurtosis up to which the steps are nearly those of random phases.
const RANDOM: f64 = 4.0;

/// The kind of texture, the most demanding first.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum TextureKind {
    /// It repeats in two directions.
    Regular,
    /// It repeats in one direction.
    Striped,
    /// It has a direction and no period.
    Oriented,
    /// It has edges, and neither period nor direction.
    Irregular,
    /// It has neither of these, nor edges.
    Random,
}

/// A method of synthesis with its main parameters.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(tag = "method", rename_all = "lowercase")]
pub enum Way {
    /// Square blocks joined along cuts.
    Quilting {
        /// Side of the blocks in texels.
        block: usize,
        /// Texels by which they overlap.
        overlap: usize,
    },
    /// The whole output improved by matching its patches.
    PatchMatch,
    /// Texels row by row, coarse to fine, each continuing a neighbouring piece.
    Scanlines,
    /// Tiles of whole periods.
    Roller {
        /// The number of tiles.
        tiles: usize,
    },
    /// Whole elements of a lattice in random order.
    Elements,
}

/// Suggestions for an exemplar.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Advice {
    /// The kind of texture; of several, the most demanding one.
    pub kind: TextureKind,
    /// The measurements and what follows from them, in one sentence.
    pub reason: String,
    /// Methods to try, the most promising first; at least one.
    pub ways: Vec<Way>,
}

/// The advice for exemplars, given by their analyses and sizes; a function of its arguments alone.
///
/// # Panics
/// When there are none.
pub fn advise(exemplars: &[(&Analysis, Size)]) -> Advice {
    let kinds: Vec<TextureKind> = exemplars.iter().map(|(found, _)| kind(found)).collect();
    let kind = *kinds.iter().min().expect("there is an exemplar");
    let each = exemplars.iter().zip(&kinds).enumerate().map(|(number, ((found, _), kind))| {
        let of = if exemplars.len() > 1 { format!("exemplar {}: ", number + 1) } else { String::new() };
        of + &measured(found, *kind)
    });
    let each: Vec<String> = each.collect();
    Advice { kind, reason: format!("{}: {}", each.join("; "), consequence(kind)), ways: ways(exemplars) }
}

fn kind(found: &Analysis) -> TextureKind {
    match found.periods.pattern {
        Pattern::Lattice(_) => TextureKind::Regular,
        Pattern::Stripes(_) => TextureKind::Striped,
        Pattern::None if found.orientation.coherence > ORIENTED => TextureKind::Oriented,
        Pattern::None if found.kurtosis < RANDOM => TextureKind::Random,
        Pattern::None => TextureKind::Irregular,
    }
}

fn measured(found: &Analysis, kind: TextureKind) -> String {
    let repeats = 100.0 * found.periods.share;
    let features = match found.feature {
        Some(size) => format!("features of {size:.1} texels"),
        None => "features as large as half the picture".to_owned(),
    };
    match kind {
        TextureKind::Regular => {
            format!("regular ({repeats:.0} % repeats in two directions), with {features}")
        }
        TextureKind::Striped => format!("striped ({repeats:.0} % repeats in one direction), with {features}"),
        TextureKind::Oriented => {
            format!(
                "oriented (coherence {:.2}) without a period, with {features}",
                found.orientation.coherence
            )
        }
        TextureKind::Random => {
            format!("random without edges (kurtosis {:.1}), with {features}", found.kurtosis)
        }
        TextureKind::Irregular => {
            format!("irregular with edges (kurtosis {:.1}), with {features}", found.kurtosis)
        }
    }
}

fn consequence(kind: TextureKind) -> &'static str {
    match kind {
        TextureKind::Regular => "blocks of at least one period, or tiles of whole periods, keep the pattern",
        TextureKind::Striped => {
            "blocks of at least one period, or tiles of whole periods, keep the stripes, along which any length \
             can be copied"
        }
        TextureKind::Oriented => "blocks joined along cuts keep the lines, which noise would break",
        TextureKind::Random => {
            "blocks joined along cuts copy it, and noise or a random-field model suits it too"
        }
        TextureKind::Irregular => {
            "blocks of at least three features, joined along cuts, keep whole things whole"
        }
    }
}

fn ways(exemplars: &[(&Analysis, Size)]) -> Vec<Way> {
    let sides = exemplars.iter().map(|(_, size)| size.width.min(size.height));
    let side = sides.min().unwrap_or(0) as f64;
    let extents: Vec<Extents> = exemplars.iter().map(|&(found, size)| Extents::of(found, size)).collect();
    let least = needed(&extents);
    let mut ways: Vec<Way> = Vec::new();
    for part in BLOCKS {
        let (block, overlap) = sized(side, least, part);
        let way = Way::Quilting { block, overlap };
        if !ways.contains(&way) {
            ways.push(way);
        }
    }
    ways.insert(1, Way::PatchMatch);
    let repeats = |(found, _): &(&Analysis, Size)| found.periods.pattern != Pattern::None;
    if !exemplars.iter().any(repeats) {
        ways.insert(2, Way::Scanlines);
    } else if exemplars.len() == 1 {
        ways.push(Way::Roller { tiles: TILES });
    }
    if let [(found, _)] = exemplars
        && found
            .periods
            .likely_lattice()
            .is_some_and(|lattice| side <= FEW_PERIODS * lattice.cell_area().sqrt())
    {
        ways.insert(1, Way::Elements);
    }
    ways
}

/// The least side of a block in texels: three features, and a period.
fn least_block(extents: &Extents) -> f64 {
    let features = LEAST_FEATURES * extents.feature.unwrap_or(f64::INFINITY);
    features.max(extents.period.unwrap_or(0.0))
}

/// The side of a block and its overlap: a `part` of the given side of an exemplar, but at least what the
/// extents demand, at most half of the side, and at least four texels.
fn sized(side: f64, least: f64, (part, overlap): (f64, usize)) -> (usize, usize) {
    let block = ((side / part).max(least.min(side / 2.0)).round() as usize).max(4);
    (block, (block / overlap).max(1))
}

/// The first side of blocks that is suggested for exemplars with these extents and the given shortest side.
pub fn first_block(extents: &[Extents], side: usize) -> usize {
    sized(side as f64, needed(extents), BLOCKS[0]).0
}

/// The least side of a block for all exemplars.
fn needed(extents: &[Extents]) -> f64 {
    extents.iter().map(least_block).fold(0.0, f64::max)
}

#[cfg(test)]
mod tests {
    use super::super::blocks::Drift;
    use super::super::orientation::Orientation;
    use super::*;
    use crate::numeric::lattice::Lattice;
    use crate::numeric::periods::Periods;
    use proptest::prelude::*;

    fn found(pattern: Pattern, share: f64, feature: Option<f64>) -> Analysis {
        let none = [Drift { factor: 1.0, errors: 0.0 }; 2];
        Analysis {
            periods: Periods { pattern, share, uncertain: None },
            orientation: Orientation { angle_deg: 0.0, coherence: 0.1 },
            feature,
            kurtosis: 6.0,
            trend: 0.0,
            scale: none,
            contrast: none,
            warnings: Vec::new(),
        }
    }

    const SIDE: Size = Size::new(256, 300);

    fn one(found: &Analysis) -> Advice {
        advise(&[(found, SIDE)])
    }

    fn blocks(advice: &Advice) -> Vec<(usize, usize)> {
        let of = |way: &Way| match *way {
            Way::Quilting { block, overlap } => Some((block, overlap)),
            Way::PatchMatch | Way::Scanlines | Way::Roller { .. } | Way::Elements => None,
        };
        advice.ways.iter().filter_map(of).collect()
    }

    #[test]
    fn small_features_leave_all_sizes_and_large_ones_bound_them() {
        let small = one(&found(Pattern::None, 0.1, Some(5.0)));
        assert_eq!(blocks(&small), [(64, 10), (43, 7), (32, 5), (23, 3), (64, 21)]);
        assert_eq!(small.kind, TextureKind::Irregular);
        let large = one(&found(Pattern::None, 0.1, Some(16.0)));
        assert_eq!(blocks(&large), [(64, 10), (48, 8), (64, 21)]);
        let huge = one(&found(Pattern::None, 0.1, None));
        assert_eq!(blocks(&huge), [(128, 21), (128, 42)]);
    }

    #[test]
    fn periods_add_tiles_and_plain_ones_bound_the_blocks() {
        let lattice = Pattern::Lattice(Lattice::new([40.0, 0.0], [0.0, 50.0]).unwrap());
        let plain = one(&found(lattice, 0.8, Some(5.0)));
        assert_eq!(blocks(&plain), [(64, 10), (50, 8), (64, 21)]);
        assert!(plain.ways.contains(&Way::Roller { tiles: 4 }) && plain.kind == TextureKind::Regular);
        let loose = one(&found(lattice, 0.3, Some(5.0)));
        assert_eq!(blocks(&loose).len(), 5);
        let stripes = one(&found(Pattern::Stripes([0.0, 60.0]), 0.8, Some(5.0)));
        assert_eq!((stripes.kind, blocks(&stripes)[1].0), (TextureKind::Striped, 60));
    }

    #[test]
    fn all_of_several_exemplars_count() {
        let plain = found(Pattern::None, 0.1, Some(5.0));
        assert!(one(&plain).ways.contains(&Way::Scanlines));
        let striped = found(Pattern::Stripes([0.0, 50.0]), 0.8, Some(4.0));
        let both = |first, second| advise(&[(first, SIDE), (second, Size::new(200, 400))]);
        let mixed = both(&plain, &striped);
        // Sides of a quarter to an eleventh of 200, at least the period of 50, and no sets of two tiles.
        assert_eq!(blocks(&mixed), [(50, 8), (50, 16)]);
        assert_eq!((mixed.kind, &mixed.ways), (TextureKind::Striped, &both(&striped, &plain).ways));
        assert!(!mixed.ways.iter().any(|way| matches!(way, Way::Roller { .. } | Way::Scanlines)));
        assert!(
            mixed.reason.contains("exemplar 1: irregular") && mixed.reason.contains("exemplar 2: striped")
        );
    }

    #[test]
    fn kinds_follow_direction_and_edges() {
        let mut analysis = found(Pattern::None, 0.0, Some(4.0));
        analysis.kurtosis = 3.2;
        assert_eq!(one(&analysis).kind, TextureKind::Random);
        analysis.orientation.coherence = 0.5;
        let advice = one(&analysis);
        assert_eq!(advice.kind, TextureKind::Oriented);
        assert!(advice.reason.contains("0.50") && advice.reason.contains("4.0 texels"), "{}", advice.reason);
    }

    proptest! {
        /// Whatever the measurements, every block fits the exemplar and overlaps by at most half.
        #[test]
        fn all_ways_are_possible(
            (width, height) in (16usize..400, 16usize..400),
            (feature, share) in (prop::option::of(0.5..500.0f64), 0.0..1.0f64),
            period in prop::option::of(1.0..300.0f64),
        ) {
            let pattern = period.map_or(Pattern::None, |p| Pattern::Stripes([p, 0.0]));
            let advice = advise(&[(&found(pattern, share, feature), Size::new(width, height))]);
            prop_assert!(!blocks(&advice).is_empty());
            for (block, overlap) in blocks(&advice) {
                prop_assert!(block <= width.min(height) && (1..=block / 2).contains(&overlap));
            }
        }
    }
}
