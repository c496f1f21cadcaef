//! Relighting: the picture of a field under one light, R(x) = sum_k c_k(x) b_k(light).
//!
//! The weights b_k are the same for the whole picture, so relighting is a weighted sum of planes, limited by
//! memory bandwidth. Texels are processed in blocks that stay in the first-level cache; blocks are
//! distributed over threads, and the inner loops use the widest vectors of the machine. Sums are in `f32` in
//! plane order, so the result depends on neither. The slow truth is [`ReflectanceField::value`].

use super::srgb8;
use crate::direction::Directions;
use crate::field::ReflectanceField;
use crate::parallel;
use crate::picture::Picture;
use crate::planes::Planes;
use pulp::{Simd, WithSimd};

/// Texels per block: three channels of `f32` are 12 KiB.
const BLOCK: usize = 1024;
/// Blocks per task: enough work to hide the cost of dispatching it to a thread.
const TASK: usize = 16 * BLOCK;

/// The field under a light seen from straight above, or for a light and a view, in the space of the field and
/// not clamped: one plane per channel. One plane of luminance, or red, green and blue, form a picture; for
/// other channels, [`ReflectanceField::of_channels`] selects those that do.
pub fn relight(field: &ReflectanceField, directions: impl Into<Directions>) -> Picture {
    relight_by(field, &field.basis().weights(directions.into()))
}

/// The sum of the functions of a field with one weight for each; otherwise as [`relight`].
pub(super) fn relight_by(field: &ReflectanceField, weights: &[f64]) -> Picture {
    let job = Relighting::new(field, weights);
    let texels = field.size().texels();
    let mut planes = Planes::zeros(field.size(), field.layout().channels());
    if field.layout().is_product() {
        let (red, rest) = planes.as_mut_slice().split_at_mut(texels);
        let (green, blue) = rest.split_at_mut(texels);
        let tasks = red.chunks_mut(TASK).zip(green.chunks_mut(TASK)).zip(blue.chunks_mut(TASK)).enumerate();
        parallel::for_each(tasks, |(i, ((r, g), b))| job.run_product(i * TASK, [r, g, b]));
    } else {
        let tasks = planes.iter_mut().enumerate().flat_map(|(c, channel)| {
            channel.chunks_mut(TASK).enumerate().map(move |(i, out)| (c, i * TASK, out))
        });
        parallel::for_each(tasks, |(c, first, out)| job.run(c, first, out));
    }
    Picture { planes, space: field.space() }
}

/// The field under a light as interleaved 8-bit sRGB, rows from the top; values outside 0..1 are
/// clamped, and linear fields are encoded within 0.501 of a code (see [`srgb8_from_linear`]).
///
/// # Panics
/// When `out` does not hold three bytes for each texel, or the channels have names that do not form a colour.
///
/// [`srgb8_from_linear`]: super::srgb8_from_linear
pub fn relight_srgb8(field: &ReflectanceField, directions: impl Into<Directions>, out: &mut [u8]) {
    relight_srgb8_by(field, &field.basis().weights(directions.into()), out);
}

/// As [`relight_by`], otherwise as [`relight_srgb8`].
pub(super) fn relight_srgb8_by(field: &ReflectanceField, weights: &[f64], out: &mut [u8]) {
    assert_eq!(out.len(), 3 * field.size().texels(), "three bytes a texel");
    assert!(!field.layout().is_named(), "named channels make no colour");
    let job = Relighting::new(field, weights);
    let tasks = out.chunks_mut(3 * TASK).enumerate();
    parallel::for_each(tasks, |(i, codes)| job.run_srgb8(i * TASK, codes));
}

/// The common data of all blocks.
struct Relighting<'a> {
    field: &'a ReflectanceField,
    weights: Vec<f32>,
    arch: pulp::Arch,
}

impl<'a> Relighting<'a> {
    fn new(field: &'a ReflectanceField, weights: &[f64]) -> Self {
        assert_eq!(
            weights.len(),
            field.basis().len() * field.basis().channels(),
            "a weight for each function"
        );
        let weights = weights.iter().map(|&w| w as f32).collect();
        Self { field, weights, arch: pulp::Arch::new() }
    }

    /// Fills a channel with its own function, from texel `first` on.
    fn run(&self, channel: usize, first: usize, out: &mut [f32]) {
        self.arch.dispatch(ChannelTask { job: self, channel, first, out });
    }

    /// Fills the three channels of a function times a colour, from texel `first` on.
    fn run_product(&self, first: usize, channels: [&mut [f32]; 3]) {
        self.arch.dispatch(ProductTask { job: self, first, channels });
    }

    fn run_srgb8(&self, first: usize, codes: &mut [u8]) {
        self.arch.dispatch(EncodeTask { job: self, first, codes });
    }

    /// One block of at most [`BLOCK`] texels; for grey fields the first channel only.
    #[inline(always)]
    fn block(&self, first: usize, channels: [&mut [f32]; 3]) {
        if self.field.layout().is_product() {
            return self.product_block(first, channels);
        }
        for (c, out) in channels.into_iter().take(self.field.layout().channels()).enumerate() {
            self.combine(c, first, out);
        }
    }

    /// One block of a function times a colour.
    #[inline(always)]
    fn product_block(&self, first: usize, channels: [&mut [f32]; 3]) {
        let n = self.field.basis().len();
        let mut luminance = [0.0f32; BLOCK];
        let luminance = &mut luminance[..channels[0].len()];
        self.combine(0, first, luminance);
        for (c, out) in channels.into_iter().enumerate() {
            let color = &self.field.coefficients().plane(n + c)[first..][..out.len()];
            let product = luminance.iter().zip(color);
            out.iter_mut().zip(product).for_each(|(o, (l, c))| *o = l * c);
        }
    }

    /// out = sum_k weight_k plane_k over the planes of the function of a channel and the texels from `first` on,
    /// three planes per pass.
    #[inline(always)]
    fn combine(&self, channel: usize, first: usize, out: &mut [f32]) {
        let (n, functions, layout) = (out.len(), self.field.basis().len(), self.field.layout());
        let plane = layout.function_plane(channel, functions);
        let source = |k: usize| &self.field.coefficients().plane(plane + k)[first..][..n];
        let triples = layout.weights(channel, functions, &self.weights).chunks_exact(3);
        let (first_single, singles) = (3 * triples.len(), triples.remainder());
        for (t, w) in triples.enumerate() {
            let terms = source(3 * t).iter().zip(source(3 * t + 1)).zip(source(3 * t + 2));
            for (o, ((a, b), c)) in out.iter_mut().zip(terms) {
                let before = if t == 0 { 0.0 } else { *o };
                *o = before + (w[0] * a + w[1] * b + w[2] * c);
            }
        }
        for (k, w) in (first_single..).zip(singles) {
            for (o, a) in out.iter_mut().zip(source(k)) {
                let before = if k == 0 { 0.0 } else { *o };
                *o = before + w * a;
            }
        }
    }
}

/// The texels of one channel in one thread's task, as values.
struct ChannelTask<'a> {
    job: &'a Relighting<'a>,
    channel: usize,
    first: usize,
    out: &'a mut [f32],
}

impl WithSimd for ChannelTask<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, _simd: S) {
        for (i, out) in self.out.chunks_mut(BLOCK).enumerate() {
            self.job.combine(self.channel, self.first + i * BLOCK, out);
        }
    }
}

/// The texels of one thread's task, a function times a colour, as values.
struct ProductTask<'a> {
    job: &'a Relighting<'a>,
    first: usize,
    channels: [&'a mut [f32]; 3],
}

impl WithSimd for ProductTask<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, _simd: S) {
        let [red, green, blue] = self.channels;
        let (mut greens, mut blues) = (green.chunks_mut(BLOCK), blue.chunks_mut(BLOCK));
        for (i, r) in red.chunks_mut(BLOCK).enumerate() {
            let (g, b) = (greens.next().unwrap_or_default(), blues.next().unwrap_or_default());
            self.job.product_block(self.first + i * BLOCK, [r, g, b]);
        }
    }
}

/// The texels of one thread's task, as interleaved codes.
struct EncodeTask<'a> {
    job: &'a Relighting<'a>,
    first: usize,
    codes: &'a mut [u8],
}

impl WithSimd for EncodeTask<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, _simd: S) {
        let grey = self.job.field.layout().channels() == 1;
        let mut values = [[0.0f32; BLOCK]; 3];
        let mut codes = [[0u8; BLOCK]; 3];
        for (i, out) in self.codes.chunks_mut(3 * BLOCK).enumerate() {
            let n = out.len() / 3;
            self.job.block(self.first + i * BLOCK, values.each_mut().map(|v| &mut v[..n]));
            let used = if grey { 1 } else { 3 };
            for (values, codes) in values.iter().zip(&mut codes).take(used) {
                srgb8::encode(self.job.field.space(), &values[..n], &mut codes[..n]);
            }
            let [r, g, b] = if grey { [&codes[0]; 3] } else { codes.each_ref() };
            interleave([&r[..n], &g[..n], &b[..n]], out);
        }
    }
}

/// Three planes of codes as one row of texels.
#[inline(always)]
fn interleave([red, green, blue]: [&[u8]; 3], out: &mut [u8]) {
    let colors = red.iter().zip(green).zip(blue);
    out.chunks_exact_mut(3).zip(colors).for_each(|(texel, ((&r, &g), &b))| {
        texel[0] = r;
        texel[1] = g;
        texel[2] = b;
    });
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::direction::Direction;
    use crate::field::{Basis, PlaneLayout};
    use crate::numeric::random::{Purpose, Stream};
    use crate::size::Size;
    use crate::space::Space;

    fn random_field(basis: Basis, color: PlaneLayout, space: Space, size: Size) -> ReflectanceField {
        let mut stream = Stream::new(5, Purpose::Sample, [size.texels() as u64]);
        let count = color.planes(basis.len());
        let data = (0..size.texels() * count).map(|_| stream.unit() as f32 * 1.6 - 0.4).collect();
        let planes = Planes::from_vec(size, count, data).unwrap();
        ReflectanceField::new(basis, color, space, planes).unwrap()
    }

    /// All bases, colour models and spaces at sizes around the block and task boundaries.
    fn fields() -> impl Iterator<Item = ReflectanceField> {
        let sizes = [(1, 1), (7, 3), (1023, 1), (1, 1025), (129, 130)].map(|(w, h)| Size::new(w, h));
        let kinds = Basis::examples()
            .into_iter()
            .flat_map(|basis| {
                PlaneLayout::examples(&basis).into_iter().map(move |layout| (basis.clone(), layout))
            })
            .filter(|(_, layout)| !layout.is_named());
        kinds.flat_map(move |(basis, layout)| {
            [Space::Linear, Space::Srgb].into_iter().flat_map(move |space| {
                let kind = (basis.clone(), layout.clone());
                sizes.into_iter().map(move |size| random_field(kind.0.clone(), kind.1.clone(), space, size))
            })
        })
    }

    fn lights() -> [Direction; 3] {
        [Direction::ZENITH, Direction::from_disk(0.5, -0.3), Direction::from_disk(-0.9, 0.4)]
    }

    #[test]
    fn relit_values_are_those_of_the_field() {
        for (field, light) in fields().flat_map(|f| lights().map(|l| (f.clone(), l))) {
            let picture = relight(&field, light);
            assert_eq!((picture.size(), picture.space), (field.size(), field.space()));
            for y in 0..field.size().height {
                for x in 0..field.size().width {
                    let truth = field.value(x, y, light);
                    for c in 0..picture.planes.count() {
                        assert!((picture.planes.at(c, x, y) - truth[c]).abs() < 3e-6, "({x}, {y}) {truth:?}");
                    }
                }
            }
        }
    }

    #[test]
    fn codes_are_within_half_a_code_of_the_encoded_values() {
        for (field, light) in fields().flat_map(|f| lights().map(|l| (f.clone(), l))) {
            let size = field.size();
            let mut out = vec![99; 3 * size.texels()];
            relight_srgb8(&field, light, &mut out);
            for (texel, codes) in out.chunks_exact(3).enumerate() {
                let truth = field.value(texel % size.width, texel / size.width, light);
                for (value, &code) in truth.iter().zip(codes) {
                    let exact = field.space().to_srgb(value.clamp(0.0, 1.0)) * 255.0;
                    // The linear toe multiplies rounding errors of the sum by 12.92.
                    assert!((exact - f32::from(code)).abs() < 0.502, "{value} became {code}");
                }
            }
        }
    }

    #[test]
    fn values_that_are_not_numbers_stay_in_their_texel() {
        let mut field = random_field(Basis::Ptm, PlaneLayout::LRGB, Space::Linear, Size::new(5, 1));
        let mut planes = field.coefficients().clone();
        planes.plane_mut(2)[3] = f32::NAN;
        planes.plane_mut(7)[1] = f32::INFINITY;
        field = field.with_coefficients(planes).unwrap();
        let picture = relight(&field, lights()[1]);
        assert!(picture.planes.plane(0).iter().enumerate().all(|(i, v)| v.is_nan() == (i == 3)));
        let mut out = [0; 15];
        relight_srgb8(&field, lights()[1], &mut out);
        assert_eq!(&out[9..12], [0; 3]);
    }

    #[test]
    fn thread_counts_do_not_change_a_bit() {
        let field = random_field(Basis::Ptm, PlaneLayout::RGB, Space::Linear, Size::new(301, 203));
        let run = |threads| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            pool.install(|| relight(&field, lights()[2]))
        };
        assert_eq!(run(1), run(3));
    }
}
