use proptest::prelude::*;

use super::*;
use crate::numeric::random::Stream;
use crate::synthesis::pixel::plain;

const METHODS: [FillMethod; 2] = [FillMethod::Texels, FillMethod::Patches];

fn noise(size: Size, planes: usize, seed: u64) -> Planes {
    let mut stream = Stream::new(seed, 1);
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
    FillOptions { method, window, epsilon: 0.1, boundary, seed }
}

fn place(texel: usize, size: Size) -> Texel {
    Texel { exemplar: 0, y: (texel / size.width) as u32, x: (texel % size.width) as u32 }
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
            let make = |index| fill(index, &holes, Some(&excluded), &options, &Limits::default(), &());
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
    fn patches_are_those_of_the_plain_search(
        (width, height, planes) in (14usize..25, 14usize..23, 1usize..4),
        (torus, seed) in (any::<bool>(), any::<u64>()),
    ) {
        let size = Size::new(width, height);
        let index = noise(size, planes, seed);
        let boundary = if torus { Boundary::Torus } else { Boundary::Open };
        let options = options(FillMethod::Patches, 5, boundary, seed);
        let exemplar = [Exemplar { index: &index, excluded: None }];
        let band = 3;
        let fast = tileable(exemplar[0], band, &options, &Limits::default(), &()).unwrap().0;
        let quantised = Quantised::new(&exemplar, &Limits::default()).unwrap();
        let positions = Positions::new(&exemplar, 5).unwrap();
        let mut lattice = Lattice::new(size, planes, Boundary::Torus, &Limits::default()).unwrap();
        for texel in 0..size.texels() {
            let (x, y) = (texel % width, texel / width);
            if (band..width - band).contains(&x) && (band..height - band).contains(&y) {
                lattice.put(texel, place(texel, size), &quantised);
            }
        }
        let window = Window::uniform(5);
        let grower =
            Grower { exemplars: &quantised, positions: &positions, window: &window, epsilon: 0.1, seed };
        let search = |query: &_, _: &[_]| plain::matches(&quantised, &positions, query, 0.1);
        patches::fill(&grower, &mut lattice, &search, &());
        prop_assert_eq!(lattice.into_map(&exemplar), fast);
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
            let map = fill(&index, &holes, None, &options, &Limits::default(), &()).unwrap().0;
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
        let map = tileable(exemplar, 4, &options, &Limits::default(), &()).unwrap().0;
        let exact = |(texel, from): (usize, &Texel)| {
            (from.x as usize % 6, from.y as usize % 5) == (texel % 36 % 6, texel / 36 % 5)
        };
        assert!(map.copies().iter().enumerate().all(exact));
    }
}

#[test]
fn masks_and_bands_without_meaning_are_refused() {
    let index = noise(Size::new(12, 9), 1, 0);
    let refused = |holes: &[bool], excluded: Option<&[bool]>, window| {
        let options = options(FillMethod::Patches, window, Boundary::Open, 0);
        fill(&index, holes, excluded, &options, &Limits::default(), &()).unwrap_err().message().to_owned()
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
        let error = tileable(exemplar, band, &FillOptions::default(), &Limits::default(), &()).unwrap_err();
        assert!(error.message().contains("1 to 4"), "{error}");
    }
}
