//! Learned functions as small integers: what a file of a few tens of kilobytes holds of them.
//!
//! Values for all pairs of some lights and some views are rounded to multiples of a step, one for each function. What
//! comes back is made orthonormal again (by the Cholesky factor of its Gram matrix), always with the same operations, so
//! the functions are those of the integers to the bit. Directions are rounded too: x and y to 32-bit floats.

use super::learned::Learned;
use crate::direction::{Direction, Directions};
use crate::error::{Error, Result};
use crate::numeric::Matrix;

/// The largest magnitude of an integer.
pub const MOST_PACKED: i32 = 1 << 17;

/// A smaller share of the square of a function outside the space of others is that of rounding errors.
const LEAST_OWN: f64 = 1e-8;

/// A direction, and the share of the hemisphere that it stands for.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct WeightedDirection {
    /// x and y of the unit vector.
    pub disk: [f32; 2],
    /// The share.
    pub weight: f32,
}

/// Learned functions as integers.
#[derive(Debug, Clone, PartialEq)]
pub struct PackedFunctions {
    /// The lights.
    pub lights: Vec<WeightedDirection>,
    /// The views.
    pub views: Vec<WeightedDirection>,
    /// Values of a function for a pair.
    pub channels: usize,
    /// What an integer of each function stands for.
    pub steps: Vec<f32>,
    /// For each function, of each view, of each light, of each channel.
    pub codes: Vec<i32>,
}

impl PackedFunctions {
    /// Refuses pairs whose functions cannot be packed.
    ///
    /// # Errors
    /// Pairs that are not all of some lights with all of some views.
    pub fn check(pairs: &[Directions]) -> Result<()> {
        let [lights, views] = sides(pairs);
        table(pairs, &lights, &views).map(|_| ())
    }

    /// The first functions of a basis, rounded to multiples of the steps, one for each.
    ///
    /// # Errors
    /// Pairs that are not all of some lights with all of some views, more steps than functions or none, and steps that
    /// are not positive or too fine for integers of at most [`MOST_PACKED`].
    pub fn new(learned: &Learned, steps: &[f32]) -> Result<Self> {
        if steps.is_empty() || steps.len() > learned.functions() {
            return Err(Error::usage(format!(
                "1 to {} of the functions can be packed, not {}",
                learned.functions(),
                steps.len()
            )));
        }
        let [lights, views] = sides(learned.pairs());
        let table = table(learned.pairs(), &lights, &views)?;
        let total: f64 = learned.weights().iter().sum();
        let weighted = |all: &[Direction], of: fn(&Directions) -> Direction| -> Vec<WeightedDirection> {
            let mut sums = vec![0.0; all.len()];
            for (pair, weight) in learned.pairs().iter().zip(learned.weights()) {
                sums[place(all, of(pair))] += weight / total.sqrt();
            }
            let entry = |(d, sum): (&Direction, f64)| WeightedDirection {
                disk: [d.x() as f32, d.y() as f32],
                weight: sum as f32,
            };
            all.iter().zip(sums).map(entry).collect()
        };
        let (channels, n) = (learned.channels(), learned.functions());
        let mut codes = Vec::with_capacity(steps.len() * learned.pairs().len() * channels);
        for (k, step) in steps.iter().enumerate() {
            for (pair, c) in table.iter().flat_map(|pair| (0..channels).map(move |c| (*pair, c))) {
                codes.push((learned.values()[(pair * channels + c) * n + k] / step).round());
            }
        }
        let is_held = |code: f32| code.is_finite() && code.abs() <= MOST_PACKED as f32;
        if let Some(wrong) = codes.iter().find(|code| !is_held(**code)) {
            return Err(Error::usage(format!(
                "a step of a function is too fine: it makes the integer {wrong}, and {MOST_PACKED} is the most: round more coarsely"
            )));
        }
        Ok(Self {
            lights: weighted(&lights, |pair| pair.light),
            views: weighted(&views, |pair| pair.view),
            channels,
            steps: steps.to_vec(),
            codes: codes.into_iter().map(|code| code as i32).collect(),
        })
    }

    /// The functions.
    ///
    /// # Errors
    /// Directions outside the hemisphere, weights that are not positive, and integers that are not those of so many
    /// independent functions.
    pub fn unpacked(&self) -> Result<Learned> {
        let (n, channels) = (self.steps.len(), self.channels);
        let rows = self.lights.len() * self.views.len() * channels;
        if n == 0 || rows == 0 || self.codes.len() != n * rows {
            return Err(Error::invalid(format!(
                "{n} packed functions for {} lights, {} views and {channels} channels have {} integers: expected {}",
                self.lights.len(),
                self.views.len(),
                self.codes.len(),
                n * rows
            )));
        }
        let (pairs, weights) = self.weighted_pairs()?;
        let inverse = self.factor(&weights)?.lower_inverse();
        let mut values = Vec::with_capacity(rows * n);
        for row in 0..rows {
            let packed = self.row(row);
            let product = |j: usize| inverse.row(j).iter().zip(&packed).map(|(a, v)| a * v).sum::<f64>();
            values.extend((0..n).map(|j| product(j) as f32));
        }
        Ok(Learned::of_channels(channels, pairs, weights, values)?.packed_as(self.clone()))
    }

    /// The pairs, each view with all lights, and their weights.
    fn weighted_pairs(&self) -> Result<(Vec<Directions>, Vec<f64>)> {
        let all = |of: &[WeightedDirection]| of.iter().map(direction).collect::<Result<Vec<Direction>>>();
        let (lights, views) = (all(&self.lights)?, all(&self.views)?);
        let of_lights = |view: Direction| lights.iter().map(move |light| Directions { light: *light, view });
        let weight = |a: &WeightedDirection, b: &WeightedDirection| f64::from(a.weight) * f64::from(b.weight);
        let weights = self.views.iter().flat_map(|a| self.lights.iter().map(move |b| weight(a, b)));
        Ok((views.iter().flat_map(|view| of_lights(*view)).collect(), weights.collect()))
    }

    /// The values of all functions for a channel of a pair.
    fn row(&self, row: usize) -> Vec<f64> {
        let rows = self.codes.len() / self.steps.len();
        let value = |(k, step): (usize, &f32)| f64::from(self.codes[k * rows + row]) * f64::from(*step);
        self.steps.iter().enumerate().map(value).collect()
    }

    /// The Cholesky factor of the inner products of the functions.
    fn factor(&self, weights: &[f64]) -> Result<Matrix> {
        let n = self.steps.len();
        let mut gram = Matrix::zeros(n, n);
        for row in 0..self.codes.len() / n {
            let values = self.row(row);
            for (j, value) in values.iter().enumerate() {
                let factor = weights[row / self.channels] * value;
                gram.row_mut(j).iter_mut().zip(&values).for_each(|(sum, v)| *sum += factor * v);
            }
        }
        let factor = gram.cholesky().ok().filter(|factor| {
            // What a function has outside the space of those before it.
            (0..n).all(|k| factor[(k, k)].powi(2) > LEAST_OWN * gram[(k, k)])
        });
        factor.ok_or_else(|| Error::invalid("the packed functions are not independent of each other"))
    }
}

fn direction(of: &WeightedDirection) -> Result<Direction> {
    let [x, y] = of.disk.map(f64::from);
    let square = x * x + y * y;
    let is_sound = of.weight > 0.0 && of.weight.is_finite() && square <= 1.0 + 1e-6;
    if !is_sound {
        return Err(Error::invalid(format!(
            "the direction ({x}, {y}) of the weight {} is not one of the hemisphere",
            of.weight
        )));
    }
    Direction::new(x, y, (1.0 - square).max(0.0).sqrt())
}

/// The distinct lights, and the distinct views.
fn sides(pairs: &[Directions]) -> [Vec<Direction>; 2] {
    [|pair: &Directions| pair.light, |pair: &Directions| pair.view].map(|of| distinct(pairs.iter().map(of)))
}

/// The distinct directions, ring by ring.
fn distinct(directions: impl Iterator<Item = Direction>) -> Vec<Direction> {
    let key = |d: &Direction| {
        let rounded = |angle: f64| (angle * 1e6).round() as i64;
        (rounded(d.polar_rad()), rounded(d.azimuth_rad()), d.to_array().map(f64::to_bits))
    };
    let mut all: Vec<Direction> = directions.collect();
    all.sort_by_cached_key(key);
    all.dedup();
    all
}

fn place(all: &[Direction], direction: Direction) -> usize {
    all.iter().position(|other| *other == direction).expect("one of all directions")
}

/// The pair of each view and light.
fn table(pairs: &[Directions], lights: &[Direction], views: &[Direction]) -> Result<Vec<usize>> {
    let mut table = vec![usize::MAX; lights.len() * views.len()];
    for (i, pair) in pairs.iter().enumerate() {
        table[place(views, pair.view) * lights.len() + place(lights, pair.light)] = i;
    }
    if pairs.len() != table.len() || table.contains(&usize::MAX) {
        return Err(Error::unsupported(format!(
            "functions of {} pairs of {} lights and {} views cannot be rounded to integers: each light is needed with each view, \
             once",
            pairs.len(),
            lights.len(),
            views.len()
        )));
    }
    Ok(table)
}

#[cfg(test)]
mod tests {
    use super::super::examples;
    use super::*;

    #[test]
    fn fine_steps_give_the_functions_back_and_coarse_ones_something_near() {
        let learned = examples::learned_of_channels(3, 9, 6, 4);
        for (step, tolerance) in [(1e-5, 1e-4), (3e-3, 0.02)] {
            let packed = PackedFunctions::new(&learned, &[step; 4]).unwrap();
            let found = packed.unpacked().unwrap();
            let mut row = [[0.0; 12]; 2];
            for pair in learned.pairs() {
                learned.weights_into(*pair, &mut row[0]);
                found.weights_into(*pair, &mut row[1]);
                let far = row[0].iter().zip(&row[1]).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
                assert!(far < tolerance, "{far} at a step of {step}");
            }
            assert_eq!(found.packed(), Some(&packed));
        }
    }

    #[test]
    fn the_first_functions_alone_can_be_packed() {
        let learned = examples::learned(8, 5, 6);
        let packed = PackedFunctions::new(&learned, &[1e-4; 2]).unwrap();
        assert_eq!((packed.unpacked().unwrap().functions(), packed.codes.len()), (2, 80));
    }

    #[test]
    fn what_cannot_be_packed_is_refused_in_a_sentence() {
        let learned = examples::learned(8, 5, 3);
        let refused = |of: &Learned, steps: &[f32]| PackedFunctions::new(of, steps).unwrap_err().to_string();
        assert!(refused(&learned, &[]).contains("1 to 3"));
        assert!(refused(&learned, &[0.1; 4]).contains("not 4"));
        assert!(refused(&learned, &[1e-9; 3]).contains("too fine"));
        assert!(refused(&learned, &[0.0; 3]).contains("too fine"));
        assert!(refused(&examples::scattered(8, 4, 3), &[0.1; 3]).contains("each light is needed"));
        let packed = PackedFunctions::new(&learned, &[1e-3; 3]).unwrap();
        let unpacked = |change: &dyn Fn(&mut PackedFunctions)| {
            let mut other = packed.clone();
            change(&mut other);
            other.unpacked().unwrap_err().to_string()
        };
        assert!(unpacked(&|p| p.codes.truncate(5)).contains("5 integers"));
        assert!(unpacked(&|p| p.codes.fill(1)).contains("not independent"));
        assert!(unpacked(&|p| p.views[1].disk = [1.0, 1.0]).contains("not one of the hemisphere"));
        assert!(unpacked(&|p| p.lights[1].weight = -1.0).contains("not one of the hemisphere"));
    }
}
