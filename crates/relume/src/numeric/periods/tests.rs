use std::f64::consts::TAU;

use super::*;
use crate::job::Job;
use crate::numeric::lattice::length;
use crate::numeric::random::{Purpose, Stream};
use crate::planes::Planes;
use crate::size::Size;

fn planes(size: Size, value: impl Fn(f64, f64) -> f64) -> Planes {
    let data = (0..size.texels()).map(|i| value((i % size.width) as f64, (i / size.width) as f64) as f32);
    Planes::from_vec(size, 1, data.collect()).unwrap()
}

fn periods(planes: &Planes) -> Periods {
    of(planes, &Job::default()).unwrap()
}

/// A motif without symmetry on every cell of a lattice: random waves that all have its period.
fn motif(lattice: Lattice, seed: u64) -> impl Fn(f64, f64) -> f64 {
    let mut random = Stream::new(seed, Purpose::Sample, [0]);
    let mut wave = |i: i32, j: i32| (f64::from(i), f64::from(j), TAU * random.unit(), 0.4 + random.unit());
    let waves: Vec<_> =
        (-2..=2).flat_map(|i| (0..=2).map(move |j| (i, j))).map(|(i, j)| wave(i, j)).collect();
    move |x, y| {
        let [s, t] = lattice.coordinates([x, y]);
        waves.iter().map(|(i, j, phase, height)| height * (TAU * (i * s + j * t) + phase).cos()).sum()
    }
}

/// A random field that is smooth over about `scale` texels: waves of all directions and of this length and
/// more.
fn noise(size: Size, scale: f64, seed: u64) -> Planes {
    let mut random = Stream::new(seed, Purpose::Sample, [1]);
    let waves: Vec<[f64; 3]> = (0..150)
        .map(|_| {
            let (length, angle) = (0.5 * random.unit().sqrt() / scale, TAU * random.unit());
            [length * angle.cos(), length * angle.sin(), random.unit()]
        })
        .collect();
    planes(size, |x, y| {
        waves.iter().map(|[u, v, phase]| (TAU * (u * x + v * y + phase)).cos()).sum::<f64>() / 15.0
    })
}

fn assert_lattice(found: Periods, truth: Lattice, within: f64) {
    let Pattern::Lattice(lattice) = found.pattern else { panic!("{found:?} is not {truth:?}") };
    let nearest = lattice.basis().map(|v| {
        let near = truth.nearest(v);
        length([near[0] - v[0], near[1] - v[1]])
    });
    assert!(nearest.iter().all(|&d| d < within), "{lattice:?} is not {truth:?}");
    let cells = lattice.cell_area() / truth.cell_area();
    assert!((cells - 1.0).abs() < 0.05, "{lattice:?} holds {cells} cells of {truth:?}");
}

/// Was reported as a lattice of two shifts along the stripes: wood, whose rings lie at one distance and
/// become less and less self-similar along the grain.
#[test]
fn stripes_that_change_along_themselves_are_no_lattice() {
    let size = Size::new(160, 150);
    let is_stripes = |period: f64, seed: u64| {
        let bend = noise(Size::new(1, 150), 25.0, seed);
        let streaks = noise(size, 2.0, seed + 100);
        let stripes = planes(size, |x, y| {
            let phase = x / period + 0.15 * f64::from(bend.as_slice()[y as usize]);
            (TAU * phase).cos() + 0.3 * f64::from(streaks.at(0, x as usize, y as usize))
        });
        let Pattern::Stripes(across) = periods(&stripes).pattern else { return false };
        assert!((length(across) - period).abs() < 0.1 && across[1].abs() < 0.3, "{period}: {across:?}");
        true
    };
    let cases = [4.0, 5.3, 7.0].into_iter().flat_map(|period| (0..12).map(move |seed| (period, seed)));
    let wrong: Vec<(f64, u64)> = cases.filter(|&(period, seed)| !is_stripes(period, seed)).collect();
    assert!(wrong.is_empty(), "{wrong:?} of 36");
}

#[test]
fn planted_lattices_are_found_to_a_fraction_of_a_texel() {
    let lattices = [
        ([16.0, 0.0], [0.0, 24.0]),
        ([21.37, 0.0], [0.0, 17.61]),
        ([19.3, 4.7], [-6.2, 23.9]),
        ([12.0, 12.0], [-12.0, 12.0]),
        ([30.5, 0.0], [15.25, 11.0]),
        ([7.3, 1.1], [2.2, 9.6]),
    ];
    for (k, (a, b)) in lattices.into_iter().enumerate() {
        let truth = Lattice::new(a, b).unwrap();
        let size = Size::new(151, 128);
        let found = periods(&planes(size, motif(truth, k as u64)));
        assert_lattice(found, truth, 0.05);
        assert!(found.share > 0.8, "{found:?}");
    }
}

#[test]
fn the_share_is_that_of_the_periodic_part() {
    let truth = Lattice::new([17.0, 3.0], [-4.0, 15.5]).unwrap();
    let size = Size::new(192, 192);
    let pattern = planes(size, motif(truth, 1));
    let rest = noise(size, 5.0, 2);
    let variance = |p: &Planes| {
        let mean = p.as_slice().iter().sum::<f32>() / size.texels() as f32;
        p.as_slice().iter().map(|v| (v - mean).powi(2)).sum::<f32>() / size.texels() as f32
    };
    for wanted in [0.9f32, 0.6, 0.45] {
        let gain = (variance(&pattern) / variance(&rest) * (1.0 - wanted) / wanted).sqrt();
        let mixed = pattern.as_slice().iter().zip(rest.as_slice()).map(|(p, n)| p + gain * n).collect();
        let found = periods(&Planes::from_vec(size, 1, mixed).unwrap());
        assert_lattice(found, truth, 0.2);
        assert!((found.share - f64::from(wanted)).abs() < 0.1, "{found:?}, planted {wanted}");
    }
}

#[test]
fn stripes_have_one_period_whatever_their_direction() {
    for (period, angle_deg) in [(12.0, 0.0f64), (9.4, 90.0), (14.3, 30.0), (17.7, 117.0)] {
        let (c, s) = (angle_deg.to_radians().cos(), angle_deg.to_radians().sin());
        let rest = noise(Size::new(160, 140), 6.0, 4);
        let stripes = planes(rest.size(), |x, y| {
            let t = TAU * (c * x + s * y) / period;
            t.sin() + 0.5 * (2.0 * t).cos()
        });
        let mixed = stripes.as_slice().iter().zip(rest.as_slice()).map(|(p, n)| p + n).collect();
        let found = periods(&Planes::from_vec(rest.size(), 1, mixed).unwrap());
        let Pattern::Stripes([x, y]) = found.pattern else { panic!("{angle_deg}: {found:?}") };
        assert!((length([x, y]) - period).abs() < 0.1, "{angle_deg}: {found:?}");
        assert!(((c * x + s * y).abs() - period).abs() < 0.1, "{angle_deg}: {found:?}");
    }
}

#[test]
fn what_does_not_repeat_has_no_period() {
    let cases = [3.0, 8.0, 20.0, 45.0].into_iter().flat_map(|scale| (0..24).map(move |seed| (scale, seed)));
    let found = |&(scale, seed): &(f64, u64)| {
        periods(&noise(Size::new(128, 120), scale, seed)).pattern != Pattern::None
    };
    let wrong: Vec<(f64, u64)> = cases.filter(found).collect();
    assert!(wrong.is_empty(), "{wrong:?} of 96");
}

#[test]
fn tiny_and_flat_textures_are_no_trouble() {
    for (width, height) in [(1, 1), (1, 40), (2, 2), (3, 7), (5, 4), (33, 2)] {
        for seed in 0..4 {
            let mut random = Stream::new(seed, Purpose::Sample, [0]);
            let data = (0..width * height).map(|_| random.unit() as f32).collect();
            let found = periods(&Planes::from_vec(Size::new(width, height), 1, data).unwrap());
            assert!((0.0..=1.0 + 1e-9).contains(&found.share), "{found:?}");
        }
        assert_eq!(periods(&Planes::zeros(Size::new(width, height), 2)).pattern, Pattern::None);
    }
}
