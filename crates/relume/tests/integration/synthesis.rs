//! Block-based synthesis: the promises of the source map, and that gathering keeps them.

use std::collections::BTreeMap;

use proptest::prelude::*;
use relume::field::{Basis, PlaneLayout};
use relume::numeric::random::{Purpose, Stream};
use relume::procedural::{Material, MaterialOptions};
use relume::synthesis::{
    Blend, BlockOptions, Boundary, Exemplar, SourceMap, Synthesis, Tolerance, gather, synthesize,
};
use relume::{Direction, Job, Limits, Planes, ReflectanceField, Size, Space};

fn noise(size: Size, planes: usize, seed: u64) -> Planes {
    let mut stream = Stream::new(seed, Purpose::Sample, [0]);
    let data = (0..size.texels() * planes).map(|_| stream.unit() as f32).collect();
    Planes::from_vec(size, planes, data).unwrap()
}

fn field(basis: Basis, color: PlaneLayout, size: Size, seed: u64) -> ReflectanceField {
    let planes = noise(size, color.planes(basis.len()), seed);
    ReflectanceField::new(basis, color, Space::Linear, planes).unwrap()
}

fn make(exemplars: &[&Planes], options: &BlockOptions) -> Synthesis {
    let exemplars: Vec<Exemplar<'_>> =
        exemplars.iter().map(|index| Exemplar { index, excluded: None }).collect();
    synthesize(&exemplars, options, &Job::default()).unwrap()
}

fn small(size: Size, boundary: Boundary, blend: Blend) -> BlockOptions {
    BlockOptions { size, block: 9, overlap: 3, boundary, blend, ..BlockOptions::default() }
}

/// Whether a block of the output puts `source` at `texel`.
fn explained(made: &Synthesis, block: usize, texel: usize, source: relume::synthesis::Texel) -> bool {
    let size = made.map.size();
    made.report.placements.iter().any(|p| {
        let dx = (texel % size.width + size.width - p.x) % size.width;
        let dy = (texel / size.width + size.height - p.y) % size.height;
        dx < block && dy < block && p.source.offset(dx, dy) == source
    })
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(40))]

    #[test]
    fn blocks_explain_every_texel(
        (width, height, planes) in (9usize..40, 9usize..40, 1usize..5),
        (torus, join, feather, seed) in (any::<bool>(), 0usize..3, 0usize..4, any::<u64>()),
    ) {
        let boundary = if torus { Boundary::Torus } else { Boundary::Open };
        let blend = [Blend::Cut, Blend::GraphCut, Blend::Alpha][join];
        let feather = if blend == Blend::Alpha { 0 } else { feather };
        let options = BlockOptions { seed, feather, ..small(Size::new(width, height), boundary, blend) };
        let (a, b) = (noise(Size::new(17, 13), planes, seed), noise(Size::new(11, 23), planes, seed ^ 1));
        let made = make(&[&a, &b], &options);
        prop_assert_eq!(made.map.copies().len(), width * height);
        for (texel, source) in made.map.copies().iter().enumerate() {
            prop_assert!(explained(&made, 9, texel, *source), "texel {} from {:?}", texel, source);
        }
        prop_assert!(blend == Blend::Alpha || feather > 0 || made.map.mix_count() == 0);
        for (texel, parts) in made.map.mixes() {
            prop_assert!(parts.len() >= 2 && parts.len() <= 4);
            prop_assert!((parts.iter().map(|p| p.weight).sum::<f32>() - 1.0).abs() < 1e-6);
            for part in parts {
                prop_assert!(part.weight > 0.0 && explained(&made, 9, texel, part.source));
            }
        }
    }

    #[test]
    fn cut_copies_are_exact(
        (width, height, seed) in (9usize..40, 9usize..40, any::<u64>()),
        (torus, graph) in (any::<bool>(), any::<bool>()),
    ) {
        let boundary = if torus { Boundary::Torus } else { Boundary::Open };
        let blend = if graph { Blend::GraphCut } else { Blend::Cut };
        let options = BlockOptions { seed, ..small(Size::new(width, height), boundary, blend) };
        for color in [PlaneLayout::LUMINANCE, PlaneLayout::RGB, PlaneLayout::LRGB] {
            let exemplar = field(Basis::Ptm, color.clone(), Size::new(20, 15), seed);
            let map = make(&[exemplar.coefficients()], &options).map;
            let output = gather(&map, &[&exemplar], &Job::default()).unwrap();
            for (texel, from) in map.copies().iter().enumerate() {
                for k in 0..output.coefficients().count() {
                    let stored = exemplar.coefficients().at(k, from.x as usize, from.y as usize);
                    prop_assert_eq!(output.coefficients().plane(k)[texel].to_bits(), stored.to_bits());
                }
            }
        }
    }
}

#[test]
fn a_periodic_exemplar_is_continued_exactly_across_the_torus() {
    let period = Size::new(8, 5);
    let pattern = noise(period, 3, 4);
    let exemplar = pattern.repeated(4, 6);
    for (blend, feather) in [(Blend::Cut, 0), (Blend::GraphCut, 0), (Blend::Cut, 2), (Blend::Alpha, 0)] {
        let options = BlockOptions {
            tolerance: Tolerance::Relative(0.0),
            feather,
            ..small(Size::new(40, 35), Boundary::Torus, blend)
        };
        let made = make(&[&exemplar], &options);
        assert!(made.report.placements.iter().all(|p| p.best == 0.0));
        let phase = made.report.placements[0].source;
        for (texel, from) in made.map.copies().iter().enumerate() {
            let (x, y) = (texel % 40, texel / 40);
            assert_eq!((x + phase.x as usize) % period.width, from.x as usize % period.width);
            assert_eq!((y + phase.y as usize) % period.height, from.y as usize % period.height);
        }
    }
}

/// A former fault: a third of a texture of wood recurred within a fifth of the exemplar's side.
#[test]
fn little_recurs_nearby() {
    let options = MaterialOptions { size: Size::new(128, 128), feature: 16.0, ..MaterialOptions::default() };
    let wood = Material::Wood.make(&options, &Job::default()).unwrap().albedo;
    let recurring = |seed: u64| {
        let options = BlockOptions {
            size: Size::new(256, 256),
            block: 32,
            overlap: 5,
            seed,
            ..BlockOptions::default()
        };
        let made = make(&[&wood], &options);
        let mut places: BTreeMap<relume::synthesis::Texel, Vec<(usize, usize)>> = BTreeMap::new();
        for (i, from) in made.map.copies().iter().enumerate() {
            places.entry(*from).or_default().push((i % 256, i / 256));
        }
        let near = |a: &(usize, usize), b: &(usize, usize)| {
            (1..=128 / 5).contains(&a.0.abs_diff(b.0).max(a.1.abs_diff(b.1)))
        };
        let recur = |all: &Vec<(usize, usize)>| all.iter().filter(|a| all.iter().any(|b| near(a, b))).count();
        places.values().map(recur).sum::<usize>() as f64 / 65_536.0
    };
    let mean = (0..4).map(recurring).sum::<f64>() / 4.0;
    assert!(mean < 0.2, "{mean}");
}

/// Mean absolute step between neighbours across the line before column `x`.
fn step_across(map: &SourceMap, picture: &Planes, x: usize) -> f64 {
    let size = map.size();
    let value = |x: usize, y: usize| {
        let from = map.copies()[size.index(x % size.width, y)];
        f64::from(picture.at(0, from.x as usize, from.y as usize))
    };
    let steps = (0..size.height).map(|y| (value(x + size.width - 1, y) - value(x, y)).abs());
    steps.sum::<f64>() / size.height as f64
}

#[test]
fn the_wrap_is_no_seam() {
    // A smooth random picture: waves of several directions and lengths.
    let size = Size::new(96, 96);
    let waves = [(0.31, 0.07), (0.11, -0.23), (-0.05, 0.37), (0.19, 0.17)];
    let value = |i: usize| {
        let (x, y) = ((i % 96) as f32, (i / 96) as f32);
        waves.iter().map(|(u, v)| (u * x + v * y).sin()).sum::<f32>()
    };
    let picture = Planes::from_vec(size, 1, (0..size.texels()).map(value).collect()).unwrap();
    let step = |boundary| {
        let options =
            BlockOptions { block: 24, overlap: 6, ..small(Size::new(80, 80), boundary, Blend::Cut) };
        let map = make(&[&picture], &options).map;
        let inner = (1..80).map(|x| step_across(&map, &picture, x)).fold(0.0, f64::max);
        (step_across(&map, &picture, 0), inner)
    };
    let (wrap, inner) = step(Boundary::Torus);
    assert!(wrap <= inner, "step {wrap} across the wrap, at most {inner} inside");
    let (wrap, inner) = step(Boundary::Open);
    assert!(wrap > inner, "open edges do not close: {wrap} against {inner}");
}

#[test]
fn excluded_texels_are_never_used() {
    let size = Size::new(40, 30);
    let index = noise(size, 2, 8);
    let mask: Vec<bool> = (0..size.texels()).map(|t| t % 40 > 25 || (t % 40 == 3 && t / 40 == 4)).collect();
    let exemplars = [Exemplar { index: &index, excluded: Some(&mask) }];
    let options = small(Size::new(60, 50), Boundary::Torus, Blend::Alpha);
    let made = synthesize(&exemplars, &options, &Job::default()).unwrap();
    let used = made.map.mixes().flat_map(|(_, parts)| parts.iter().map(|p| p.source));
    assert!(
        used.chain(made.map.copies().iter().copied()).all(|t| !mask[size.index(t.x as usize, t.y as usize)])
    );
}

#[test]
fn blended_texels_are_the_weighted_sum_of_the_functions() {
    let options = small(Size::new(30, 24), Boundary::Open, Blend::Alpha);
    for color in [PlaneLayout::LUMINANCE, PlaneLayout::RGB, PlaneLayout::LRGB] {
        let mut exemplar = field(Basis::Ptm, color.clone(), Size::new(20, 15), 5);
        if color == PlaneLayout::LRGB {
            // One colour everywhere, so that a sum of functions is again a product.
            let mut planes = exemplar.coefficients().clone();
            (6..9).for_each(|k| planes.plane_mut(k).fill(0.2 * (k - 4) as f32));
            exemplar = exemplar.with_coefficients(planes).unwrap();
        }
        let map = make(&[exemplar.coefficients()], &options).map;
        let output = gather(&map, &[&exemplar], &Job::default()).unwrap();
        assert!(map.mix_count() > 100);
        let light = Direction::from_angles(0.6, 1.1);
        for (texel, parts) in map.mixes() {
            let made = output.value(texel % 30, texel / 30, light);
            for (c, made) in made.into_iter().enumerate() {
                let sum: f32 = parts
                    .iter()
                    .map(|p| p.weight * exemplar.value(p.source.x as usize, p.source.y as usize, light)[c])
                    .sum();
                assert!((sum - made).abs() < 1e-4, "{color:?}: {sum} vs {made}");
            }
        }
    }
}

#[test]
fn maps_apply_to_registered_fields_only() {
    let exemplar = noise(Size::new(20, 15), 3, 5);
    let map = make(&[&exemplar], &small(Size::new(12, 12), Boundary::Open, Blend::Cut)).map;
    let mask = field(Basis::Constant, PlaneLayout::LUMINANCE, Size::new(20, 15), 6);
    assert_eq!(gather(&map, &[&mask], &Job::default()).unwrap().size(), Size::new(12, 12));
    let other = field(Basis::Constant, PlaneLayout::LUMINANCE, Size::new(21, 15), 6);
    let error = gather(&map, &[&other], &Job::default()).unwrap_err();
    assert!(error.message().contains("21 x 15") && error.message().contains("20 x 15"));
    assert!(gather(&map, &[], &Job::default()).is_err());
    assert!(gather(&map, &[&mask, &mask], &Job::default()).is_err());
    let tight = Job::new(Limits { max_bytes: 100, ..Limits::default() });
    assert!(gather(&map, &[&mask], &tight).is_err());
}

#[test]
fn outputs_beyond_the_limits_are_refused() {
    let exemplar = noise(Size::new(20, 15), 3, 5);
    let exemplars = [Exemplar { index: &exemplar, excluded: None }];
    for size in [Size::new(1 << 40, 9), Size::new(1 << 17, 1 << 17)] {
        let options = small(size, Boundary::Open, Blend::Cut);
        assert!(synthesize(&exemplars, &options, &Job::default()).is_err());
    }
}
