//! How strong the detail is at a place, given what is coarser there.
//!
//! A Gaussian field has the same grain everywhere. Materials have more of it in joints and at edges than on stones: the
//! strength of a band of the pyramid varies from place to place, and goes with the value and with the steps of what is coarser
//! (M. Wainwright, E. Simoncelli, "Scale Mixtures of Gaussians and the Statistics of Natural Images", NIPS 12, 1999;
//! R. Buccigrossi, E. Simoncelli, "Image Compression via Joint Statistical Characterization in the Wavelet Domain", IEEE
//! Transactions on Image Processing 8, 1999). A band is therefore a stationary field times a gain, a function of two numbers of
//! the coarser image at the place: its value, and the magnitude of its gradient. The function is linear between nodes.
//!
//! Only the first component of the coarser image is seen, the lightness of pictures; the gain is that of all components.

use super::noise::exp2;
use crate::parallel;
use crate::planes::Planes;
use crate::size::Size;

/// Nodes along each of the two numbers.
const SIDE: usize = 5;

/// The number of nodes.
pub const NODES: usize = SIDE * SIDE;

/// The codes of a factor of two.
const OCTAVE: f32 = 16.0;

/// Values beyond this many deviations are taken for these.
const SPAN: f32 = 2.0;

/// The mean gain has the weight of so many texels at every node.
const PRIOR_TEXELS: f64 = 16.0;

/// What a gain takes in a file, in nats: it must make the detail more probable by more than that.
const COST: f64 = 8.0 * (4 + NODES) as f64 * std::f64::consts::LN_2;

/// The gain of a band as a function of the coarser image.
#[derive(Debug, Clone, PartialEq)]
pub struct LocalGain {
    /// The deviation of the values of the coarser image; nodes are at -2, -1, 0, 1 and 2 of them.
    pub deviation: f32,
    /// The usual magnitude g of its gradient; nodes are at the magnitudes for which a / (a + g) is 0, 1/4, 1/2, 3/4 and 1.
    pub gradient: f32,
    /// The gains at the nodes, those of one value after another: 2 to the power (code - 128) / 16.
    pub codes: [u8; NODES],
}

/// What is known of a place: the node before it, and the parts beyond.
type NodePlace = (usize, [f32; 2]);

impl LocalGain {
    /// The code of gain 1.
    pub const ONE: u8 = 128;

    /// The gain of the `band` of planes given the coarser image of the same size, its mean 0; `None` where the detail is no
    /// more probable with one, or the coarser image is the same everywhere.
    ///
    /// # Panics
    /// When the sizes differ, or there are no planes.
    pub fn of(band: &Planes, coarser: &Planes) -> Option<Self> {
        assert_eq!(band.size(), coarser.size(), "a band and what it is added to");
        let (size, texels) = (band.size(), band.size().texels() as f64);
        let deviation = mean_square(coarser.plane(0)).sqrt() as f32;
        let mut magnitudes = vec![0.0; size.texels()];
        for (y, row) in magnitudes.chunks_exact_mut(size.width).enumerate() {
            NeighbourRows::of(coarser.plane(0), size, y).gradients(0, row);
        }
        let gradient = (magnitudes.iter().map(|&g| f64::from(g)).sum::<f64>() / texels) as f32;
        let [deviation, gradient] = [deviation, gradient].map(|v| half::f16::from_f32(v).to_f32());
        let energies = energies(band);
        if !(deviation > 0.0 && gradient > 0.0) || energies.is_empty() {
            return None;
        }
        let mut gain = Self { deviation, gradient, codes: [Self::ONE; NODES] };
        gain.codes = gain.codes_of(coarser, &energies);
        (gain.nats(coarser, &energies, band.count()) > COST).then_some(gain)
    }

    /// Divides a band by its gains, given the coarser image of the same size.
    pub fn divide(&self, band: &mut Planes, coarser: &Planes) {
        self.for_each(band, coarser, [0, 0], |value, gain| *value /= gain);
    }

    /// Multiplies a band by its gains; its top left texel is that of the coarser image at `origin`.
    ///
    /// # Panics
    /// When the coarser image does not cover the band.
    pub fn multiply(&self, band: &mut Planes, coarser: &Planes, origin: [usize; 2]) {
        self.for_each(band, coarser, origin, |value, gain| *value *= gain);
    }

    fn for_each(
        &self,
        band: &mut Planes,
        coarser: &Planes,
        [x, y]: [usize; 2],
        change: impl Fn(&mut f32, &f32) + Sync,
    ) {
        let (width, size, table) = (band.size().width, coarser.size(), self.table());
        parallel::for_each(band.bands_mut(width).into_iter().enumerate(), |(row, mut planes)| {
            let rows = NeighbourRows::of(coarser.plane(0), size, y + row);
            let mut gains = vec![0.0; width];
            rows.gradients(x, &mut gains);
            for (gain, &value) in gains.iter_mut().zip(&rows.here[x..]) {
                *gain = interpolated(&table, self.place(value, *gain));
            }
            planes.iter_mut().for_each(|plane| plane.iter_mut().zip(&gains).for_each(|(v, g)| change(v, g)));
        });
    }

    fn place(&self, value: f32, magnitude: f32) -> NodePlace {
        let last = (SIDE - 1) as f32;
        let across = ((value / self.deviation + SPAN) * (last / (2.0 * SPAN))).clamp(0.0, last);
        let down = last * magnitude / (magnitude + self.gradient);
        let [i, j] = [across, down].map(|at| (at as usize).min(SIDE - 2));
        (i * SIDE + j, [across - i as f32, down - j as f32])
    }

    fn table(&self) -> [f32; NODES] {
        self.codes.map(|code| exp2((f32::from(code) - f32::from(Self::ONE)) / OCTAVE))
    }

    /// The gains that make the energy around every node 1.
    fn codes_of(&self, coarser: &Planes, energies: &[f32]) -> [u8; NODES] {
        let (mut sums, mut weights) = ([PRIOR_TEXELS; NODES], [PRIOR_TEXELS; NODES]);
        self.each_place(coarser, |t, (node, [s, u])| {
            let corners =
                [(0, (1.0 - s) * (1.0 - u)), (1, (1.0 - s) * u), (SIDE, s * (1.0 - u)), (SIDE + 1, s * u)];
            for (step, weight) in corners {
                sums[node + step] += f64::from(weight * energies[t]);
                weights[node + step] += f64::from(weight);
            }
        });
        std::array::from_fn(|k| {
            let octaves = 0.5 * (sums[k] / weights[k]).max(f64::MIN_POSITIVE).log2();
            (f64::from(Self::ONE) + f64::from(OCTAVE) * octaves).round().clamp(0.0, 255.0) as u8
        })
    }

    /// How much more probable the energies of m components are with these gains than with none, in nats.
    fn nats(&self, coarser: &Planes, energies: &[f32], components: usize) -> f64 {
        let (table, mut logs, mut energy) = (self.table(), 0.0, 0.0);
        self.each_place(coarser, |t, place| {
            let gain = f64::from(interpolated(&table, place));
            logs += gain.ln();
            energy += f64::from(energies[t]) / (gain * gain);
        });
        let n = energies.len() as f64;
        let m = components as f64;
        -m * logs - 0.5 * m * n * (energy / n).ln()
    }

    fn each_place(&self, coarser: &Planes, mut each: impl FnMut(usize, NodePlace)) {
        let size = coarser.size();
        let mut magnitudes = vec![0.0; size.width];
        for y in 0..size.height {
            let rows = NeighbourRows::of(coarser.plane(0), size, y);
            rows.gradients(0, &mut magnitudes);
            for (x, (&value, &magnitude)) in rows.here.iter().zip(&magnitudes).enumerate() {
                each(size.index(x, y), self.place(value, magnitude));
            }
        }
    }
}

fn interpolated(table: &[f32; NODES], (node, [s, u]): NodePlace) -> f32 {
    let line = |at: usize| table[at] + u * (table[at + 1] - table[at]);
    let (here, next) = (line(node), line(node + SIDE));
    here + s * (next - here)
}

/// For each texel the square of the band in units of its mean square, the mean over planes that are not zero everywhere;
/// empty where all are.
fn energies(band: &Planes) -> Vec<f32> {
    let squares: Vec<(&[f32], f64)> =
        band.iter().map(|plane| (plane, mean_square(plane))).filter(|(_, square)| *square > 0.0).collect();
    if squares.is_empty() {
        return Vec::new();
    }
    let mut energies = vec![0.0f32; band.size().texels()];
    for (plane, square) in &squares {
        let scale = (1.0 / (square * squares.len() as f64)) as f32;
        energies.iter_mut().zip(*plane).for_each(|(sum, v)| *sum += scale * v * v);
    }
    energies
}

fn mean_square(values: &[f32]) -> f64 {
    values.iter().map(|&v| f64::from(v) * f64::from(v)).sum::<f64>() / values.len() as f64
}

/// A row of a plane and its neighbours; beyond the borders the outer texels are repeated.
struct NeighbourRows<'a> {
    above: &'a [f32],
    here: &'a [f32],
    below: &'a [f32],
}

impl<'a> NeighbourRows<'a> {
    fn of(plane: &'a [f32], size: Size, y: usize) -> Self {
        let row = |y: usize| &plane[y * size.width..][..size.width];
        Self { above: row(y.saturating_sub(1)), here: row(y), below: row((y + 1).min(size.height - 1)) }
    }

    /// The magnitudes of the gradient from column `x` on, from differences over two texels.
    fn gradients(&self, x: usize, out: &mut [f32]) {
        let last = self.here.len() - 1;
        for (i, out) in out.iter_mut().enumerate() {
            let at = x + i;
            let across = self.here[(at + 1).min(last)] - self.here[at.saturating_sub(1)];
            let down = self.below[at] - self.above[at];
            *out = 0.5 * (across * across + down * down).sqrt();
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::numeric::random::{Purpose, Stream};

    /// A smooth coarser image, and noise whose deviation is a function of its value.
    fn planted(deviation: impl Fn(f32) -> f32) -> (Planes, Planes) {
        let (size, mut random) = (Size::new(96, 80), Stream::new(4, Purpose::Sample, [0]));
        let value = |t: usize| 1.4 * ((t % 96) as f32 * 0.21).sin() * ((t / 96) as f32 * 0.17).cos();
        let coarser: Vec<f32> = (0..size.texels()).map(value).collect();
        let band = coarser.iter().map(|&v| deviation(v) * random.normal() as f32).collect();
        let planes = |data| Planes::from_vec(size, 1, data).unwrap();
        (planes(band), planes(coarser))
    }

    #[test]
    fn a_planted_gain_is_found_and_divides_and_multiplies() {
        let truth = |v: f32| if v < 0.0 { 2.0 } else { 0.5 };
        let (band, coarser) = planted(truth);
        let gain = LocalGain::of(&band, &coarser).unwrap();
        let mut flat = band.clone();
        gain.divide(&mut flat, &coarser);
        let spread = |planes: &Planes, dark: bool| {
            let of: Vec<f32> = planes
                .plane(0)
                .iter()
                .zip(coarser.plane(0))
                .filter(|(_, v)| if dark { **v < -0.4 } else { **v > 0.4 })
                .map(|(b, _)| *b)
                .collect();
            mean_square(&of).sqrt()
        };
        assert!(spread(&band, true) / spread(&band, false) > 3.5);
        let left = spread(&flat, true) / spread(&flat, false);
        assert!((0.8..1.25).contains(&left), "{left}");
        gain.multiply(&mut flat, &coarser, [0, 0]);
        let off = flat.plane(0).iter().zip(band.plane(0)).map(|(a, b)| (a - b).abs()).fold(0.0, f32::max);
        assert!(off < 1e-5, "{off}");
    }

    #[test]
    fn a_part_has_the_gains_of_the_whole() {
        let (band, coarser) = planted(|v| v.exp());
        let gain = LocalGain::of(&band, &coarser).unwrap();
        let mut whole = band.clone();
        gain.multiply(&mut whole, &coarser, [0, 0]);
        let part = Size::new(30, 20);
        let mut cut = band.crop(11, 7, part).unwrap();
        // The coarser image reaches one texel farther on all sides.
        let around = coarser.crop(10, 6, Size::new(32, 22)).unwrap();
        gain.multiply(&mut cut, &around, [1, 1]);
        assert_eq!(cut, whole.crop(11, 7, part).unwrap());
    }

    #[test]
    fn stationary_noise_and_flat_images_have_no_gain() {
        let (band, coarser) = planted(|_| 1.0);
        assert_eq!(LocalGain::of(&band, &coarser), None);
        let (size, flat) = (band.size(), Planes::zeros(band.size(), 1));
        assert_eq!(LocalGain::of(&band, &flat), None);
        assert_eq!(LocalGain::of(&Planes::zeros(size, 2), &coarser), None);
    }
}
