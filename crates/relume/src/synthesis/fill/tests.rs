use proptest::prelude::*;

use super::*;
use crate::numeric::random::{Purpose, Stream};
use crate::synthesis::guidance::Guided;
use crate::synthesis::pixel::canvas::PixelCanvas;
use crate::synthesis::pixel::grow::Grower;
use crate::synthesis::pixel::plain;
use crate::synthesis::positions::Positions;

const METHODS: [FillMethod; 2] = [FillMethod::Texels, FillMethod::Patches];

fn noise(size: Size, planes: usize, seed: u64) -> Planes {
    let mut stream = Stream::new(seed, Purpose::Sample, [1]);
    let data = (0..size.texels() * planes).map(|_| stream.below(50) as f32).collect();
    Planes::from_vec(size, planes, data).unwrap()
}

fn disc(size: Size, x: f64, y: f64, radius: f64) -> Vec<bool> {
    let inside = |texel: usize| {
        let (dx, dy) = ((texel % size.width) as f64 - x, (texel / size.width) as f64 - y);
        dx * dx + dy * dy <= radius * radius
    };
    (0..size.texels()).map(inside).collect()
}

fn options(method: FillMethod, window: usize, boundary: Boundary, seed: u64) -> FillOptions {
    FillOptions { method, window, epsilon: 0.1, boundary, guidance: None, seed }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(40))]

    #[test]
    fn only_holes_change_and_their_content_does_not_matter(
        (width, height, planes) in (14usize..31, 14usize..27, 1usize..4),
        (x, y, radius) in (0.0..30.0, 0.0..27.0, 1.0..4.0),
        (half, torus, seed) in (1usize..3, any::<bool>(), any::<u64>()),
    ) {
        let size = Size::new(width, height);
        let index = noise(size, planes, seed);
        let mut holes = disc(size, x, y, radius);
        holes[seed as usize % size.texels()] = true;
        let excluded: Vec<bool> = (0..size.texels()).map(|texel| texel % size.width == 0).collect();
        let mut other = index.clone();
        for plane in other.iter_mut() {
            plane.iter_mut().zip(&holes).filter(|(_, hole)| **hole).for_each(|(v, _)| *v = f32::NAN);
        }
        let boundary = if torus { Boundary::Torus } else { Boundary::Open };
        for method in METHODS {
            let options = options(method, 2 * half + 1, boundary, seed);
            let make = |index| fill(index, &holes, Some(&excluded), &options, &Job::default());
            let Ok((map, growth)) = make(&index) else { continue };
            prop_assert_eq!(growth.texels as usize, holes.iter().filter(|hole| **hole).count());
            for (texel, &from) in map.copies().iter().enumerate() {
                let source = size.index(from.x as usize, from.y as usize);
                prop_assert!(holes[texel] || source == texel);
                prop_assert!(!holes[texel] || !(holes[source] || excluded[source]));
            }
            prop_assert_eq!(make(&other).unwrap().0, map);
        }
    }

    #[test]
    fn fillings_are_those_of_the_plain_search(
        (width, height, planes, guides) in (14usize..25, 14usize..23, 1usize..4, 0usize..3),
        (texels, torus, seed) in (any::<bool>(), any::<bool>(), any::<u64>()),
    ) {
        let (size, job) = (Size::new(width, height), Job::default());
        let index = noise(size, planes, seed);
        let mut holes = disc(size, 9.0, 7.0, 2.5);
        holes[0] = true;
        let guidance = (guides > 0).then(|| Guidance {
            sources: vec![noise(size, guides, seed ^ 3)],
            target: noise(size, guides, seed ^ 4),
            weight: 2.0,
        });
        let method = if texels { FillMethod::Texels } else { FillMethod::Patches };
        let boundary = if torus { Boundary::Torus } else { Boundary::Open };
        let options = FillOptions { guidance, ..options(method, 5, boundary, seed) };
        let fast = fill(&index, &holes, None, &options, &job);
        let blank = blanked(&index, &holes);
        let exemplars = [Exemplar { index: &blank, excluded: Some(&holes) }];
        let guided = Guided::new(&exemplars, options.guidance.as_ref(), size, &job).unwrap();
        let (quantised, target) = guided.interleaved(&job).unwrap();
        let Ok(positions) = Positions::new(&exemplars, 5) else {
            prop_assert!(fast.is_err());
            return Ok(());
        };
        let mut canvas = PixelCanvas::new(size, planes + guides, boundary, &job).unwrap();
        target.iter().for_each(|target| canvas.guide(target));
        for texel in (0..size.texels()).filter(|&texel| !holes[texel]) {
            canvas.put(texel, place(texel, size), &quantised);
        }
        let window = if texels { ComparedWindow::gaussian(5) } else { ComparedWindow::uniform(5) };
        let grower = Grower { exemplars: &quantised, positions: &positions, window: &window, seed };
        let search = |query: &_, _: &[_]| plain::matches(&quantised, &positions, query, 0.1);
        match method {
            FillMethod::Texels => grower.grow(&mut canvas, &search, &Job::default()).unwrap(),
            _ => patches::fill(&grower, &mut canvas, &search, &Job::default()).unwrap(),
        };
        prop_assert_eq!(canvas.into_map(&exemplars), fast.unwrap().0);
    }
}

/// Two halves of one noise that only the guide distinguishes, and a hole across their border.
#[test]
fn holes_follow_their_guide() {
    let size = Size::new(48, 32);
    let index = noise(size, 1, 2);
    let holes: Vec<bool> =
        (0..size.texels()).map(|t| (14..34).contains(&(t % 48)) && (8..24).contains(&(t / 48))).collect();
    let half = |border: usize| {
        Planes::from_vec(size, 1, (0..size.texels()).map(|t| f32::from(u8::from(t % 48 >= border))).collect())
            .unwrap()
    };
    for (method, border) in METHODS.into_iter().flat_map(|method| [19, 29].map(|border| (method, border))) {
        let agreement = |weight: Option<f64>| {
            let guidance =
                weight.map(|weight| Guidance { sources: vec![half(24)], target: half(border), weight });
            let options = FillOptions { guidance, ..options(method, 5, Boundary::Open, 1) };
            let map = fill(&index, &holes, None, &options, &Job::default()).unwrap().0;
            let filled = map.copies().iter().enumerate().filter(|(texel, _)| holes[*texel]);
            let agree = filled.filter(|(texel, from)| (texel % 48 >= border) == (from.x >= 24)).count();
            agree as f64 / holes.iter().filter(|hole| **hole).count() as f64
        };
        let (guided, free) = (agreement(Some(4.0)), agreement(None));
        assert!(guided > 0.85 && free < 0.75, "{method:?}, {border}: {guided} guided, {free} free");
    }
}

#[test]
fn holes_in_a_periodic_texture_are_restored_exactly() {
    let period = Size::new(7, 6);
    let index = noise(period, 3, 3).repeated(6, 6);
    let size = index.size();
    let holes = disc(size, 20.0, 17.0, 8.0);
    for method in METHODS {
        for boundary in [Boundary::Open, Boundary::Torus] {
            let options = FillOptions { epsilon: 0.0, ..options(method, 9, boundary, 1) };
            let map = fill(&index, &holes, None, &options, &Job::default()).unwrap().0;
            for (texel, from) in map.copies().iter().enumerate() {
                let phase = (from.x as usize % period.width, from.y as usize % period.height);
                assert_eq!(phase, (texel % size.width % period.width, texel / size.width % period.height));
            }
        }
    }
}

#[test]
fn a_periodic_texture_is_made_to_tile_by_its_own_period() {
    let index = noise(Size::new(6, 5), 2, 8).repeated(6, 6);
    let exemplar = Exemplar { index: &index, excluded: None };
    for method in METHODS {
        let options = FillOptions { epsilon: 0.0, ..options(method, 7, Boundary::Open, 1) };
        let map = tileable(exemplar, 4, &options, &Job::default()).unwrap().0;
        let exact = |(texel, from): (usize, &Texel)| {
            (from.x as usize % 6, from.y as usize % 5) == (texel % 36 % 6, texel / 36 % 5)
        };
        assert!(map.copies().iter().enumerate().all(exact));
    }
}

/// An output mismatched at its border is corrected; its middle stays.
#[test]
fn an_output_of_copies_is_closed_from_its_exemplars() {
    let index = noise(Size::new(6, 5), 2, 8).repeated(6, 6);
    let exemplars = [Exemplar { index: &index, excluded: None }; 2];
    let size = Size::new(42, 40);
    let inside = |texel: usize| (4..38).contains(&(texel % 42)) && (4..36).contains(&(texel / 42));
    let source = |texel: usize| {
        let out_of_step = u32::from(!inside(texel));
        let Texel { x, y, .. } = place(texel, size);
        Texel { exemplar: 1, x: x % 6 + out_of_step, y: y % 5 }
    };
    let map = SourceMap::new(size, &exemplars, (0..size.texels()).map(source).collect());
    for method in METHODS {
        let options = FillOptions { epsilon: 0.0, ..options(method, 7, Boundary::Open, 1) };
        let (closed, growth) = close(&map, &exemplars, 4, &options, &Job::default()).unwrap();
        assert_eq!(growth.texels, 42 * 40 - 34 * 32);
        for (texel, from) in closed.copies().iter().enumerate() {
            assert_eq!((from.x as usize % 6, from.y as usize % 5), (texel % 42 % 6, texel / 42 % 5));
            assert!(!inside(texel) || *from == source(texel));
        }
    }
}

#[test]
fn masks_and_bands_without_meaning_are_refused() {
    let index = noise(Size::new(12, 9), 1, 0);
    let refused = |holes: &[bool], excluded: Option<&[bool]>, window| {
        let options = options(FillMethod::Patches, window, Boundary::Open, 0);
        fill(&index, holes, excluded, &options, &Job::default()).unwrap_err().message().to_owned()
    };
    let mut one = vec![false; 108];
    one[54] = true;
    assert!(refused(&[false; 108], None, 3).contains("no hole"));
    assert!(refused(&[true; 108], None, 3).contains("every texel"));
    assert!(refused(&[true; 107], None, 3).contains("107 texels"));
    assert!(refused(&one, Some(&[false; 5]), 3).contains("5 texels"));
    assert!(refused(&one, None, 4).contains("odd"));
    assert!(refused(&one, None, 11).contains("at most 9"));
    assert!(refused(&one, None, 9).contains("no place"));
    let exemplar = Exemplar { index: &index, excluded: None };
    for band in [0, 5] {
        let error = tileable(exemplar, band, &FillOptions::default(), &Job::default()).unwrap_err();
        assert!(error.message().contains("1 to 4"), "{error}");
    }
}
