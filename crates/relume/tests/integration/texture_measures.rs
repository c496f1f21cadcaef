//! Each measure distinguishes a real second half of an exemplar from degraded copies of the first.

use relume::format::read_raster;
use relume::metric::texture::copying::copying;
use relume::metric::texture::seams::seams;
use relume::metric::texture::wrap::wrap;
use relume::metric::texture::{
    SlicedOptions, Source, Sources, correlation, histogram, sliced, spectrum, steerable,
};
use relume::numeric::random::{Purpose, Stream};
use relume::procedural::{Material, MaterialOptions, Tiling};
use relume::synthesis::{BlockOptions, Exemplar, synthesize};
use relume::{Job, Planes, Size, Space};

use crate::support::data;

/// The degradations of the first half of an exemplar.
const SPOILT: [&str; 3] = ["blurred", "tiled", "scrambled"];

/// The binomial kernel along rows and columns, twice: the deviation is 1.4 texels.
pub fn blurred(planes: &Planes) -> Planes {
    let size = planes.size();
    let once = |from: &Planes| {
        let mut out = from.clone();
        for (k, plane) in out.iter_mut().enumerate() {
            for (i, value) in plane.iter_mut().enumerate() {
                let (x, y) = (i % size.width, i / size.width);
                let at = |x: usize, y: usize| from.at(k, x.min(size.width - 1), y.min(size.height - 1));
                let row = |y: usize| 0.25 * at(x.saturating_sub(1), y) + 0.5 * at(x, y) + 0.25 * at(x + 1, y);
                *value = 0.25 * row(y.saturating_sub(1)) + 0.5 * row(y) + 0.25 * row(y + 1);
            }
        }
        out
    };
    (0..4).fold(planes.clone(), |planes, _| once(&planes))
}

/// The middle sixteenth sixteen times.
pub fn tiled(planes: &Planes) -> Planes {
    let size = planes.size();
    let tile = Size::new(size.width / 4, size.height / 4);
    planes.crop(3 * size.width / 8, 3 * size.height / 8, tile).unwrap().repeated(4, 4)
}

/// The same texels in random places.
pub fn scrambled(planes: &Planes) -> Planes {
    let mut order: Vec<usize> = (0..planes.size().texels()).collect();
    let mut random = Stream::new(7, Purpose::Sample, [0]);
    (1..order.len()).rev().for_each(|i| order.swap(i, random.below(i + 1)));
    let moved = planes.iter().flat_map(|plane| order.iter().map(|&i| plane[i])).collect();
    Planes::from_vec(planes.size(), planes.count(), moved).unwrap()
}

/// Left and right half.
pub fn halves(planes: &Planes) -> [Planes; 2] {
    let half = Size::new(planes.size().width / 2, planes.size().height);
    [0, half.width].map(|x| planes.crop(x, 0, half).unwrap())
}

/// In the order of [`MEASURES`].
fn measured(a: &Planes, b: &Planes) -> [f64; 5] {
    let job = Job::default();
    let levels = sliced::levels(a, b, &SlicedOptions::default(), &job).unwrap();
    [
        levels.iter().sum::<f64>() / levels.len() as f64,
        histogram::distance(a, b),
        correlation::distance(a, b, &job).unwrap(),
        spectrum::distance_db(a, b, &job).unwrap(),
        steerable::distance(a, b, &job).unwrap(),
    ]
}

/// The distances from the first half: of the second half, then of the degraded first half.
fn table(name: &str, exemplar: &Planes) -> [[f64; 5]; 4] {
    let [first, second] = halves(exemplar);
    let all = [second, blurred(&first), tiled(&first), scrambled(&first)].map(|b| measured(&first, &b));
    for (what, d) in ["second half", SPOILT[0], SPOILT[1], SPOILT[2]].iter().zip(&all) {
        let [sliced, histogram, autocorrelation, spectrum_db, steerable] = d;
        println!(
            "{name} | {what} | {sliced:.4} | {histogram:.4} | {autocorrelation:.4} | {spectrum_db:.2} | {steerable:.4}"
        );
    }
    all
}

/// A measure, and the degraded copies that it must detect: a histogram ignores positions.
type Measure = (&'static str, &'static [&'static str]);
const MEASURES: [Measure; 5] = [
    ("sliced", &SPOILT),
    ("histogram", &["blurred"]),
    ("autocorrelation", &SPOILT),
    ("spectrum", &SPOILT),
    ("steerable", &SPOILT),
];

/// The degraded copies that a measure finds nearer than the second half, although it should detect them.
fn failures(table: &[[f64; 5]; 4]) -> Vec<String> {
    let mut failures = Vec::new();
    for (measure, (name, meant)) in MEASURES.into_iter().enumerate() {
        let [second, spoilt @ ..] = table.map(|distances| distances[measure]);
        for (what, distance) in SPOILT.iter().zip(spoilt) {
            if meant.contains(what) && distance <= second {
                failures.push(format!("{name} {what}"));
            }
        }
    }
    failures
}

#[test]
fn the_second_half_of_built_in_materials_is_nearest() {
    // The two halves of a fire are different flames.
    for material in Material::ALL.into_iter().filter(|material| *material != Material::Fire) {
        let options = MaterialOptions {
            size: Size::new(512, 256),
            feature: 16.0,
            tiling: Tiling::Free,
            ..MaterialOptions::default()
        };
        let albedo = material.make(&options, &Job::default()).unwrap().albedo;
        let failures = failures(&table(material.name(), &albedo));
        assert!(failures.is_empty(), "{}: {failures:?}", material.name());
    }
}

/// Real textures, and the known misses of the measures on them, because their halves differ.
const REAL: [(&str, &[&str]); 9] = [
    // Photographed in perspective: the halves hold bricks of different sizes.
    (
        "textures/brick.png",
        &["sliced blurred", "histogram blurred", "autocorrelation blurred", "steerable tiled"],
    ),
    ("textures/grass.png", &[]),
    ("textures/gravel.png", &[]),
    ("materials/bark/albedo.jpg", &[]),
    ("materials/facade/albedo.jpg", &[]),
    ("materials/mossyrock/albedo.jpg", &[]),
    // The left half holds more rust.
    ("materials/rustymetal/albedo.jpg", &["histogram blurred", "autocorrelation blurred"]),
    // The halves correlate differently; a blur hardly changes the correlation of a regular texture.
    ("captures/wool/wool_t45_p000.png", &["autocorrelation blurred"]),
    ("captures/corduroy/corduroy_t45_p000.png", &[]),
];

#[test]
fn the_second_half_of_real_textures_is_nearest_but_for_known_cases() {
    for (file, known) in REAL {
        let Some(path) = data(file) else { continue };
        let whole = read_raster(&path, &Job::default()).unwrap().to_picture(Space::Srgb).planes;
        let size = Size::new(whole.size().width.min(512), whole.size().height.min(512));
        let failures = failures(&table(file, &whole.crop(0, 0, size).unwrap()));
        assert_eq!(failures, known, "{file}");
    }
}

fn albedo(material: Material, side: usize, tiling: Tiling, seed: u64) -> Planes {
    let options = MaterialOptions {
        size: Size::new(side, side),
        feature: 16.0,
        tiling,
        seed,
        ..MaterialOptions::default()
    };
    material.make(&options, &Job::default()).unwrap().albedo
}

#[test]
fn borders_of_tiles_are_smoother_than_those_of_crops() {
    for material in Material::ALL {
        // One border may follow an edge of the texture by chance: the mean of eight.
        let mean_ratio = |tiling: Tiling| {
            let wraps = (0..4).flat_map(|seed| wrap(&albedo(material, 120, tiling, seed)));
            wraps.map(|wrap| wrap.ratio).sum::<f64>() / 8.0
        };
        let (tile, crop) = (mean_ratio(Tiling::Torus), mean_ratio(Tiling::Free));
        println!("{}: mean wrap ratio of tiles {tile:.2}, of crops {crop:.2}", material.name());
        // Borders of a weave run between yarns, where steps are legitimately large.
        let least = if material == Material::Weave { 1.0 } else { 1.25 };
        assert!(crop > least * tile, "{}: {tile} and {crop}", material.name());
    }
}

/// The planes gathered from sources.
fn gathered(exemplar: &Planes, size: Size, sources: &[Source]) -> Planes {
    let texel = |plane: usize, s: &Source| exemplar.at(plane, s.x as usize, s.y as usize);
    let data = (0..exemplar.count()).flat_map(|k| sources.iter().map(move |s| texel(k, s))).collect();
    Planes::from_vec(size, exemplar.count(), data).unwrap()
}

/// Blocks of a given side, placed at random by a seed.
fn laid_blindly(size: Size, block: usize, exemplar: Size, seed: u64) -> Vec<Source> {
    let mut random = Stream::new(seed, Purpose::Sample, [0]);
    let columns = size.width / block;
    let corners: Vec<[usize; 2]> = (0..columns * size.height / block)
        .map(|_| [exemplar.width, exemplar.height].map(|side| random.below(side - block + 1)))
        .collect();
    let source = |i: usize| {
        let (x, y) = (i % size.width, i / size.width);
        let [left, top] = corners[y / block * columns + x / block];
        Source { exemplar: 0, x: (left + x % block) as u32, y: (top + y % block) as u32 }
    };
    (0..size.texels()).map(source).collect()
}

/// The ratios are means over three seeds: with one seed a ratio varies by a tenth.
#[test]
fn cuts_are_less_visible_than_blocks_laid_blindly() {
    let (size, block) = (Size::new(144, 144), 24);
    for material in Material::ALL {
        let exemplar = albedo(material, 128, Tiling::Free, 0);
        let exemplars = [Exemplar { index: &exemplar, excluded: None }];
        let sizes = [exemplar.size()];
        let ratio = |texels: &[Source]| {
            let sources = Sources::new(size, texels, &sizes).unwrap();
            seams(&gathered(&exemplar, size, texels), &sources).unwrap().ratio
        };
        let (mut cut, mut blind) = (0.0, 0.0);
        for seed in 0..3 {
            let options = BlockOptions { size, block, overlap: 6, seed, ..BlockOptions::default() };
            let made = synthesize(&exemplars, &options, &Job::default()).unwrap();
            let texels: Vec<Source> =
                made.map.copies().iter().map(|t| Source { exemplar: t.exemplar, x: t.x, y: t.y }).collect();
            cut += ratio(&texels) / 3.0;
            let texels = laid_blindly(size, block, exemplar.size(), seed);
            blind += ratio(&texels) / 3.0;
            let copied = copying(&Sources::new(size, &texels, &sizes).unwrap());
            assert_eq!((copied.largest_piece, copied.longest_run), (block * block, block));
        }
        println!("{}: cut {cut:.3}, blind {blind:.3}", material.name());
        // At 1 the steps across cuts are those of the texture itself: what is above is seen.
        assert!(cut - 1.0 < 0.4 * (blind - 1.0), "{}: {cut} and {blind}", material.name());
    }
}
