//! Evaluation of the difference equation Y_r = gamma X_r + drive_r + e_r over rectangles of the plane.
//!
//! A recursion is sequential, so it is vectorised across places: sixteen rectangles of one size, anywhere on
//! the plane, are computed side by side, one per vector lane. Their values are interleaved by lane, so that
//! each weight is applied to sixteen values at once without shuffles. Only as many rows are kept as the
//! neighbourhood reaches up. The state before a rectangle is zero: its effect must have decayed within a
//! margin, [`super::level::Level::burn_in`].

use super::level::Level;
use super::neighbourhood::{Offset, Reach};
use super::noise::{BATCH, NUMBERS, normals};
use super::octets::{OCTET, Octets, PortableOctets};
use crate::numeric::random::{Purpose, key};
use crate::planes::Planes;
use crate::size::Size;

/// The number of rectangles computed side by side.
pub const LANES: usize = 2 * OCTET;

/// Predicted planes whose sums are kept in registers together.
const GROUP: usize = 3;

/// A level prepared for evaluation.
#[derive(Debug, Clone)]
pub struct Recursion {
    planes: usize,
    neighbours: Vec<Offset>,
    reach: Reach,
    /// For each group of predicted planes: for each neighbour and each of its planes, the weights of the
    /// group.
    weights: Vec<Vec<f32>>,
    /// Lower triangle, row by row.
    noise: Vec<f32>,
    number: u32,
}

/// The common options of the rectangles, besides the level.
#[derive(Debug, Clone, Copy)]
pub struct RecursionRun<'a> {
    /// Columns and rows of the rectangles.
    pub size: Size,
    /// Added to the noise if there is a coarser level.
    pub drive: Option<Drive<'a>>,
    /// What the noise is multiplied by, one plane.
    pub strength: Option<Drive<'a>>,
    /// Another seed, another noise.
    pub seed: u64,
    /// The period of the noise in texels, along x and y.
    pub period: Option<[i64; 2]>,
}

/// A part of the plane of drives, or of strengths.
#[derive(Debug, Clone, Copy)]
pub struct Drive<'a> {
    /// As many planes as the level has; of strengths one.
    pub planes: &'a Planes,
    /// The position of the top left texel on the plane.
    pub origin: [i64; 2],
}

impl Drive<'_> {
    /// Row `y` of plane `j` over a rectangle of `width` columns.
    fn row(&self, origin: &[i64; 2], y: usize, j: usize, width: usize) -> &[f32] {
        let [x, y] = [origin[0] - self.origin[0], origin[1] - self.origin[1] + y as i64].map(|v| v as usize);
        &self.planes.plane(j)[self.planes.size().index(x, y)..][..width]
    }
}

impl Recursion {
    /// Prepares a level; its number selects the stream of noise.
    pub fn new(level: &Level, number: u32) -> Self {
        let (m, values) = (level.planes(), level.weights.values(false));
        let group = |first: usize| {
            let last = (first + GROUP).min(m);
            values.chunks_exact(m).flat_map(|row| row[first..last].to_vec()).collect()
        };
        Self {
            planes: m,
            neighbours: level.neighbours.clone(),
            reach: level.reach(),
            weights: (0..m).step_by(GROUP).map(group).collect(),
            noise: level.noise.clone(),
            number,
        }
    }

    /// Computes sixteen rectangles whose top left texels are `origins`, and passes on each row: its number,
    /// and for each texel and plane the values of all lanes.
    pub fn run(
        &self,
        origins: &[[i64; 2]; LANES],
        run: &RecursionRun<'_>,
        mut row: impl FnMut(usize, &[f32]),
    ) {
        #[cfg(target_arch = "x86_64")]
        if let Some(simd) = pulp::x86::V3::try_new() {
            return simd.vectorize(
                #[inline(always)]
                || self.rows(simd, origins, run, &mut row),
            );
        }
        self.rows(PortableOctets, origins, run, &mut row);
    }

    #[inline(always)]
    fn rows(
        &self,
        simd: impl Octets,
        origins: &[[i64; 2]; LANES],
        run: &RecursionRun<'_>,
        emit: &mut impl FnMut(usize, &[f32]),
    ) {
        let texel = self.planes * LANES;
        let length = (self.reach.left + run.size.width + self.reach.right) * texel;
        let kept = self.reach.up + 1;
        let mut state = vec![0.0f32; kept * length];
        let mut input = vec![0.0f32; run.size.width * texel];
        let keys = self.keys(run.seed);
        for y in 0..run.size.height {
            self.input(origins, run, &keys, y, &mut input);
            // The offsets of the neighbours of the first texel of the row.
            let start = |o: &Offset| {
                let row = (y + kept).wrapping_add_signed(o.dy as isize) % kept;
                row * length + self.reach.left.wrapping_add_signed(o.dx as isize) * texel
            };
            let starts: Vec<usize> = self.neighbours.iter().map(start).collect();
            let own = (y % kept) * length + self.reach.left * texel;
            for x in 0..run.size.width {
                for (g, weights) in self.weights.iter().enumerate() {
                    let place = Slot {
                        shift: x * texel,
                        texel,
                        input: (g * GROUP * run.size.width + x) * LANES,
                        stride: run.size.width * LANES,
                        out: own + x * texel + g * GROUP * LANES,
                    };
                    match (self.planes - g * GROUP).min(GROUP) {
                        1 => predict::<1, _>(simd, &mut state, &starts, weights, &input, place),
                        2 => predict::<2, _>(simd, &mut state, &starts, weights, &input, place),
                        _ => predict::<GROUP, _>(simd, &mut state, &starts, weights, &input, place),
                    }
                }
            }
            emit(y, &state[own..own + run.size.width * texel]);
        }
    }

    /// The keys of the noise, one for each [`NUMBERS`] components.
    fn keys(&self, seed: u64) -> Vec<u64> {
        let groups = 0..self.planes.div_ceil(NUMBERS) as u64;
        groups.map(|group| key(seed, Purpose::FieldNoise, [u64::from(self.number), group])).collect()
    }

    /// Noise and drive of a row: plane after plane, the lanes of each texel together.
    #[inline(always)]
    fn input(
        &self,
        origins: &[[i64; 2]; LANES],
        run: &RecursionRun<'_>,
        keys: &[u64],
        y: usize,
        input: &mut [f32],
    ) {
        let row = run.size.width * LANES;
        let wrap = |v: i64, axis: usize| run.period.map_or(v, |p| v.rem_euclid(p[axis])) as u32;
        let ys: [u32; BATCH] = std::array::from_fn(|i| wrap(origins[i % LANES][1] + y as i64, 1));
        input.fill(0.0);
        for start in (0..row).step_by(BATCH) {
            let mut xs = [0; BATCH];
            for (x, xs) in xs.chunks_exact_mut(LANES).enumerate() {
                let x = (start / LANES + x) as i64;
                xs.iter_mut().zip(origins).for_each(|(out, origin)| *out = wrap(origin[0] + x, 0));
            }
            for (first, key) in (0..self.planes).step_by(NUMBERS).zip(keys) {
                let numbers = normals(&xs, &ys, *key);
                for (k, numbers) in (first..self.planes).zip(&numbers) {
                    self.colour(k, &numbers[..BATCH.min(row - start)], start, row, input);
                }
            }
        }
        if let Some(strength) = run.strength {
            strengthen(&strength, origins, y, self.planes, input);
        }
        if let Some(drive) = run.drive {
            add_drive(&drive, origins, y, input);
        }
    }

    /// Adds column `k` of the noise factor times independent numbers to the inputs of the planes from `start`
    /// on.
    #[inline(always)]
    fn colour(&self, k: usize, numbers: &[f32], start: usize, row: usize, input: &mut [f32]) {
        for j in k..self.planes {
            let weight = self.noise[j * (j + 1) / 2 + k];
            let out = &mut input[j * row + start..][..numbers.len()];
            for (out, number) in out.iter_mut().zip(numbers) {
                *out = weight.mul_add(*number, *out);
            }
        }
    }

    /// One rectangle, texel by texel: the slow truth. Planes of the size of the rectangle.
    pub fn run_slow(&self, origin: [i64; 2], run: &RecursionRun<'_>) -> Planes {
        let m = self.planes;
        let mut out = Planes::zeros(run.size, m);
        let mut input = vec![0.0f32; run.size.width * m * LANES];
        let keys = self.keys(run.seed);
        for y in 0..run.size.height {
            self.input(&[origin; LANES], run, &keys, y, &mut input);
            for x in 0..run.size.width {
                for j in 0..m {
                    let (weights, width) = (&self.weights[j / GROUP], (m - j / GROUP * GROUP).min(GROUP));
                    let mut sum = input[(j * run.size.width + x) * LANES];
                    for (t, o) in self.neighbours.iter().enumerate() {
                        let (nx, ny) = (x as i64 + i64::from(o.dx), y as i64 + i64::from(o.dy));
                        let inside = (0..run.size.width as i64).contains(&nx) && ny >= 0;
                        for i in (0..m).filter(|_| inside) {
                            let weight = weights[(t * m + i) * width + j % GROUP];
                            sum = weight.mul_add(out.at(i, nx as usize, ny as usize), sum);
                        }
                    }
                    out.plane_mut(j)[y * run.size.width + x] = sum;
                }
            }
        }
        out
    }
}

/// The positions of the inputs and outputs of a group of planes of one texel.
#[derive(Clone, Copy)]
struct Slot {
    /// The shift from the neighbours of the first texel to those of this one.
    shift: usize,
    /// Numbers per texel.
    texel: usize,
    /// The position of the input of the first plane, and the distance between planes.
    input: usize,
    stride: usize,
    /// The position of the output.
    out: usize,
}

/// The values of J planes of one texel: input plus weighted neighbours, which begin at `starts` plus the
/// shift of the texel. Each weight is applied to all lanes, whose sums stay in registers.
#[inline(always)]
fn predict<const J: usize, S: Octets>(
    simd: S,
    state: &mut [f32],
    starts: &[usize],
    weights: &[f32],
    input: &[f32],
    place: Slot,
) {
    let mut sums = [[simd.splat(0.0); 2]; J];
    for (j, sum) in sums.iter_mut().enumerate() {
        let input = &input[place.input + j * place.stride..][..LANES];
        *sum = [simd.load(&input[..OCTET]), simd.load(&input[OCTET..])];
    }
    let mut weights = weights.chunks_exact(J);
    for &start in starts {
        let neighbour = &state[start + place.shift..][..place.texel];
        for (values, weights) in neighbour.chunks_exact(LANES).zip(&mut weights) {
            let (first, second) = (simd.load(&values[..OCTET]), simd.load(&values[OCTET..]));
            for j in 0..J {
                let weight = simd.splat(weights[j]);
                sums[j] = [simd.mul_add(weight, first, sums[j][0]), simd.mul_add(weight, second, sums[j][1])];
            }
        }
    }
    for (out, sum) in state[place.out..].chunks_exact_mut(LANES).zip(sums) {
        simd.store(sum[0], &mut out[..OCTET]);
        simd.store(sum[1], &mut out[OCTET..]);
    }
}

/// Multiplies the noise of m planes by the strengths of the row of each lane.
fn strengthen(strength: &Drive<'_>, origins: &[[i64; 2]; LANES], y: usize, m: usize, input: &mut [f32]) {
    let width = input.len() / (m * LANES);
    for (l, origin) in origins.iter().enumerate() {
        let row = strength.row(origin, y, 0, width);
        for plane in input.chunks_exact_mut(width * LANES) {
            plane[l..].iter_mut().step_by(LANES).zip(row).for_each(|(out, v)| *out *= v);
        }
    }
}

/// Adds the row of the drive of each lane.
fn add_drive(drive: &Drive<'_>, origins: &[[i64; 2]; LANES], y: usize, input: &mut [f32]) {
    let width = input.len() / (drive.planes.count() * LANES);
    for (l, origin) in origins.iter().enumerate() {
        for (j, plane) in input.chunks_exact_mut(width * LANES).enumerate() {
            let row = drive.row(origin, y, j, width);
            plane[l..].iter_mut().step_by(LANES).zip(row).for_each(|(out, v)| *out += v);
        }
    }
}

#[cfg(test)]
pub(super) mod tests {
    use super::super::level::Weights;
    use super::super::neighbourhood::causal;
    use super::*;
    use crate::numeric::random::Stream;
    use proptest::prelude::*;

    /// A stable level: weights whose magnitudes sum to less than one.
    pub fn random_level(m: usize, neighbours: usize, seed: u64) -> Level {
        let mut stream = Stream::new(seed, Purpose::Sample, [1]);
        let most = 0.9 / (neighbours * m).max(1) as f64;
        let weights: Vec<f64> = (0..neighbours * m * m).map(|_| most * (2.0 * stream.unit() - 1.0)).collect();
        let noise = (0..m * (m + 1) / 2).map(|_| stream.unit() as f32 + 0.2).collect();
        Level {
            neighbours: causal(neighbours),
            coarse: Vec::new(),
            weights: Weights::nearest(&weights, neighbours, vec![1e-3; 2 * m], vec![1e-2; m]),
            noise,
            gain: None,
            unevenness: 0,
            burn_in: 16,
            log_evidence: 0.0,
            texels: 1,
        }
    }

    /// A former fault: the upper half of a seed was mixed into the number of the level, so that the finest
    /// level of this seed had the noise of the second level of seed 0.
    #[test]
    fn no_level_has_the_noise_of_another_level_and_seed() {
        let level = random_level(5, 3, 1);
        let [finest, second] = [0, 1].map(|number| Recursion::new(&level, number));
        assert_ne!(finest.keys(0xbc890000 << 32), second.keys(0));
        assert_ne!(finest.keys(1), second.keys(0));
        assert_eq!(finest.keys(7).len(), 2);
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(40))]
        #[test]
        fn lanes_give_the_bits_of_the_raster_order(
            m in 1usize..8, neighbours in 0usize..15, width in 1usize..20, height in 1usize..9,
            driven: bool, uneven: bool, periodic: bool, seed: u64,
        ) {
            let recursion = Recursion::new(&random_level(m, neighbours, seed), 2);
            let size = Size::new(width, height);
            let mut stream = Stream::new(seed, Purpose::Sample, [2]);
            let origins: [[i64; 2]; LANES] = std::array::from_fn(|_| [stream.below(60) as i64 - 30, stream.below(60) as i64 - 30]);
            let area = Size::new(60 + width, 60 + height);
            let data = (0..m * area.texels()).map(|_| stream.unit() as f32).collect();
            let planes = Planes::from_vec(area, m, data).unwrap();
            let drive = driven.then_some(Drive { planes: &planes, origin: [-30, -30] });
            let strengths = Planes::from_vec(area, 1, (0..area.texels()).map(|_| stream.unit() as f32).collect()).unwrap();
            let strength = uneven.then_some(Drive { planes: &strengths, origin: [-30, -30] });
            let run = RecursionRun { size, drive, strength, seed, period: periodic.then_some([24, 17]) };
            let mut rows = Vec::new();
            recursion.run(&origins, &run, |y, row| { assert_eq!(y * width * m * LANES, rows.len()); rows.extend_from_slice(row); });
            for (l, origin) in origins.iter().enumerate() {
                let slow = recursion.run_slow(*origin, &run);
                for (i, texel) in rows.chunks_exact(m * LANES).enumerate() {
                    (0..m).for_each(|j| assert_eq!(texel[j * LANES + l].to_bits(), slow.plane(j)[i].to_bits()));
                }
            }
        }
    }
}
