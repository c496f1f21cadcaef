//! The two passes over the photographs.

use super::dots::Interleaved;
use crate::error::{Error, Result};
use crate::field::{Basis, ReflectanceField};
use crate::fit::exposed::Exposed;
use crate::fit::held_out::HeldOut;
use crate::fit::levels::SampleLevels;
use crate::fit::products::{BAND, FUNCTIONS, add_products};
use crate::fit::sample::Grid;
use crate::fit::stream::{BATCH, PhotographStream};
use crate::job::{Held, Job};
use crate::numeric::Matrix;
use crate::numeric::eigen;
use crate::numeric::random::{Purpose, Stream};
use crate::parallel::{self, Spares};
use crate::planes::Planes;
use crate::raster::Raster;
use pulp::Arch;

/// Squares of singular values below this share of the largest are those of rounding errors.
pub(super) const ROUNDING: f64 = 1e-11;

/// What both passes need.
pub(super) struct Setting<'a> {
    pub stream: &'a PhotographStream<'a>,
    pub levels: &'a SampleLevels,
    pub held_out: &'a HeldOut,
    pub seed: u64,
}

/// The result of the passes over a matrix B of texels by columns, one for each channel of each pair that takes
/// part.
pub(super) struct Sketch {
    /// Q' B: for each column its products with an orthonormal basis of few vectors.
    pub rows: Vec<f32>,
    /// The number of these vectors.
    pub width: usize,
    /// B Z, Z the transpose of the rows.
    pub products: Planes,
    /// The sum of the squares of B.
    pub energy: f64,
    /// The number of values of B inside the mask.
    pub values: f64,
    /// The texels of the report's grid in every photograph.
    pub kept: Vec<Raster>,
    /// The photographs that are black or white.
    pub exposed: Exposed,
    _held: Held,
}

impl Sketch {
    /// Passes over the photographs with a random matrix of `width` columns.
    pub fn new(setting: &Setting<'_>, width: usize, grid: &Grid, job: &Job) -> Result<Self> {
        let stream = setting.stream;
        let columns = setting.held_out.kept() * stream.channels();
        let held = job.hold("the functions", 12 * (columns * width) as u64)?;
        let size = stream.size();
        let sums_bytes = 4 * (width * size.texels()) as u64 + Interleaved::bytes(width, size.texels());
        let _sums = job.hold("the sums of the factorisation", sums_bytes)?;
        job.start("learning functions", 2 * stream.len() as u64);

        let mut sums = Planes::zeros(size, width);
        let (mut energy, mut kept, mut exposed) = (0.0, Vec::new(), Exposed::default());
        setting.for_each_batch(job, |first, batch| {
            let random = setting.random_rows(first, batch.len(), width);
            energy += setting.add_batch(&mut sums, first, batch, &random);
            for (i, photograph) in (first..).zip(batch) {
                let picked = grid.raster(photograph);
                exposed.look(i, photograph, &picked);
                kept.push(picked);
            }
        })?;
        if energy == 0.0 {
            return Err(Error::invalid("all photographs are black: there is no function to learn"));
        }
        let basis = Interleaved::new(&orthonormal(sums, job)?);
        let width = basis.count();
        let mut sums = Planes::zeros(size, width);
        let mut rows = Vec::with_capacity(columns * width);
        setting.for_each_batch(job, |first, batch| {
            let products = setting.inner_products(&basis, first, batch);
            setting.add_batch(&mut sums, first, batch, &products);
            rows.extend(setting.of_kept(first, batch.len(), &products, width));
        })?;
        let values = columns as f64 * grid.inside_texels() as f64;
        Ok(Self { rows, width, products: sums, energy, values, kept, exposed, _held: held })
    }
}

impl Sketch {
    /// The mean square of what two fields of learned functions differ by, over all values of the photographs: those of
    /// the pairs of the first field, which count alike here, whatever their solid angles.
    pub fn mean_square(&self, a: &ReflectanceField, b: &ReflectanceField, job: &Job) -> Result<f64> {
        let functions = function_products(a, b)?;
        let (a, b) = (a.coefficients(), b.coefficients());
        let planes = [gram(a, job)?, products_of(a, b, job)?, gram(b, job)?];
        let sum = |planes: &Matrix, functions: &Matrix| -> f64 {
            let rows = (0..planes.rows()).flat_map(|j| planes.row(j).iter().zip(functions.row(j)));
            rows.map(|(a, b)| a * b).sum()
        };
        let [own, between, other] = [0, 1, 2].map(|i| sum(&planes[i], &functions[i]));
        Ok((own - 2.0 * between + other).max(0.0) / self.values)
    }
}

/// The inner products of the functions of the first field with each other, of both, and of those of the second with each
/// other.
fn function_products(a: &ReflectanceField, b: &ReflectanceField) -> Result<[Matrix; 3]> {
    let Basis::Learned(learned) = a.basis() else {
        return Err(Error::invalid("the difference of textures of other than learned functions"));
    };
    let (m, n) = (learned.functions(), b.basis().len());
    let mut products = [(m, m), (m, n), (n, n)].map(|(rows, columns)| Matrix::zeros(rows, columns));
    for pair in learned.pairs() {
        let (a, b) = (a.basis().weights(*pair), b.basis().weights(*pair));
        for (a, b) in a.chunks_exact(m).zip(b.chunks_exact(n)) {
            for (matrix, (left, right)) in products.iter_mut().zip([(a, a), (a, b), (b, b)]) {
                for (j, factor) in left.iter().enumerate() {
                    matrix.row_mut(j).iter_mut().zip(right).for_each(|(sum, value)| *sum += factor * value);
                }
            }
        }
    }
    Ok(products)
}

impl Setting<'_> {
    fn for_each_batch(&self, job: &Job, mut take: impl FnMut(usize, &[Raster])) -> Result<()> {
        self.stream.for_each_batch(job, |first, batch| {
            take(first, batch);
            job.advance(batch.len() as u64)
        })
    }

    /// Rows of a random matrix for the channels of a batch; they belong to the photograph.
    fn random_rows(&self, first: usize, photographs: usize, width: usize) -> Vec<f32> {
        let row = |i: usize| {
            let mut stream = Stream::new(self.seed, Purpose::FactorSketch, [(first + i) as u64]);
            (0..self.stream.channels() * width).map(move |_| (2.0 * stream.unit() - 1.0) as f32)
        };
        (0..photographs).flat_map(row).collect()
    }

    /// The rows of photographs that take part.
    fn of_kept<'a>(
        &'a self,
        first: usize,
        photographs: usize,
        rows: &'a [f32],
        width: usize,
    ) -> impl Iterator<Item = f32> + 'a {
        let length = width * self.stream.channels();
        let kept = (0..photographs).filter(move |i| !self.held_out.is_out(first + i));
        kept.flat_map(move |i| rows[i * length..][..length].iter().copied())
    }

    /// sums_k += sum_i rows_ik image_i over the channels of those of a batch that take part, and the sum of the
    /// squares of their values.
    fn add_batch(&self, sums: &mut Planes, first: usize, batch: &[Raster], rows: &[f32]) -> f64 {
        let (width, arch) = (sums.count(), Arch::new());
        let taking = self.taking_part(first, batch);
        let scratch = Spares::new(|| vec![0.0f32; BATCH * BAND]);
        let energies = parallel::map(sums.bands_mut(BAND).into_iter().enumerate(), |(b, mut band)| {
            let mut scratch = scratch.take();
            let texels = band[0].len();
            let mut energy = 0.0;
            for columns in taking.chunks(BATCH) {
                let scratch = &mut scratch[..columns.len() * BAND];
                self.values(columns, batch, b, texels, scratch);
                energy += scratch.chunks_exact(BAND).map(|row| squares(&row[..texels])).sum::<f64>();
                for (group, planes) in band.chunks_mut(FUNCTIONS).enumerate() {
                    let share = |k: usize, i: usize| rows[columns[i].row * width + group * FUNCTIONS + k];
                    add_products(arch, planes, scratch, share);
                }
            }
            energy
        });
        energies.into_iter().sum()
    }

    /// The inner products of the channels of a batch with planes, row after row; zero where a photograph takes no
    /// part.
    fn inner_products(&self, planes: &Interleaved, first: usize, batch: &[Raster]) -> Vec<f32> {
        let (width, arch) = (planes.count(), Arch::new());
        let taking = self.taking_part(first, batch);
        let scratch = Spares::new(|| vec![0.0f32; taking.len() * BAND]);
        let of_band = |&band: &usize| {
            let mut scratch = scratch.take();
            let mut products = vec![0.0f32; taking.len() * width];
            self.values(&taking, batch, band, planes.band_texels(band), &mut scratch);
            planes.dots(arch, band, &scratch, &mut products);
            products
        };
        // Bands are added in order, in doubles.
        let mut sums = vec![0.0f64; taking.len() * width];
        let bands: Vec<usize> = (0..planes.bands()).collect();
        for bands in bands.chunks(4 * rayon::current_num_threads().max(1)) {
            for products in parallel::map(bands.iter(), of_band) {
                sums.iter_mut().zip(products).for_each(|(sum, product)| *sum += f64::from(product));
            }
        }
        let mut rows = vec![0.0f32; batch.len() * self.stream.channels() * width];
        for (column, sums) in taking.iter().zip(sums.chunks_exact(width)) {
            rows[column.row * width..][..width]
                .iter_mut()
                .zip(sums)
                .for_each(|(row, &sum)| *row = sum as f32);
        }
        rows
    }

    /// The channels of a batch that take part.
    fn taking_part(&self, first: usize, batch: &[Raster]) -> Vec<Column> {
        let channels = self.stream.channels();
        let taking = (0..batch.len()).filter(|i| !self.held_out.is_out(first + i));
        let of_photograph = |photograph| {
            (0..channels).map(move |channel| Column {
                photograph,
                channel,
                row: photograph * channels + channel,
            })
        };
        taking.flat_map(of_photograph).collect()
    }

    /// The values of columns over a band, a row of [`BAND`] values each.
    fn values(&self, columns: &[Column], batch: &[Raster], band: usize, texels: usize, out: &mut [f32]) {
        for (column, row) in columns.iter().zip(out.chunks_exact_mut(BAND)) {
            self.levels.channel(&batch[column.photograph], column.channel, band * BAND, &mut row[..texels]);
        }
    }
}

/// A channel of a photograph of a batch.
struct Column {
    photograph: usize,
    channel: usize,
    /// The row of its numbers among those of the batch.
    row: usize,
}

fn squares(values: &[f32]) -> f64 {
    values.iter().map(|v| f64::from(*v).powi(2)).sum()
}

/// An orthonormal basis of the space of planes, as planes.
fn orthonormal(planes: Planes, job: &Job) -> Result<Planes> {
    let (values, vectors) = eigen::symmetric(&gram(&planes, job)?);
    let rank = values.iter().take_while(|value| **value > ROUNDING * values[0]).count().max(1);
    let norm = |k: usize| if values[k] > 0.0 { 1.0 / values[k].sqrt() } else { 0.0 };
    Ok(combined(&planes, &Matrix::from_fn(rank, planes.count(), |k, j| norm(k) * vectors[(k, j)])))
}

/// The inner products of planes.
pub(super) fn gram(planes: &Planes, job: &Job) -> Result<Matrix> {
    let n = planes.count();
    let row = |j: usize| {
        job.proceed()?;
        Ok((0..=j).map(|k| dot(planes.plane(j), planes.plane(k))).collect::<Vec<f64>>())
    };
    let rows = parallel::try_map(0..n, row)?;
    Ok(Matrix::from_fn(n, n, |j, k| rows[j.max(k)][j.min(k)]))
}

/// The inner products of planes with other planes.
fn products_of(planes: &Planes, others: &Planes, job: &Job) -> Result<Matrix> {
    let row = |j: usize| {
        job.proceed()?;
        Ok(others.iter().map(|other| dot(planes.plane(j), other)).collect::<Vec<f64>>())
    };
    let rows = parallel::try_map(0..planes.count(), row)?;
    Ok(Matrix::from_fn(planes.count(), others.count(), |j, k| rows[j][k]))
}

fn dot(a: &[f32], b: &[f32]) -> f64 {
    a.iter().zip(b).map(|(a, b)| f64::from(*a) * f64::from(*b)).sum()
}

/// out_k = sum_j matrix_kj plane_j.
pub(super) fn combined(planes: &Planes, matrix: &Matrix) -> Planes {
    let arch = Arch::new();
    let mut out = Planes::zeros(planes.size(), matrix.rows());
    let scratch = Spares::new(|| vec![0.0f32; BATCH * BAND]);
    parallel::for_each(out.bands_mut(BAND).into_iter().enumerate(), |(b, mut band)| {
        let mut scratch = scratch.take();
        let texels = band[0].len();
        for first in (0..planes.count()).step_by(BATCH) {
            let count = BATCH.min(planes.count() - first);
            let scratch = &mut scratch[..count * BAND];
            for (j, row) in scratch.chunks_exact_mut(BAND).enumerate() {
                row[..texels].copy_from_slice(&planes.plane(first + j)[b * BAND..][..texels]);
            }
            for (group, sums) in band.chunks_mut(FUNCTIONS).enumerate() {
                let share = |k: usize, j: usize| matrix[(group * FUNCTIONS + k, first + j)] as f32;
                add_products(arch, sums, scratch, share);
            }
        }
    });
    out
}
