//! The place of an exemplar that fits given texels best: a template of any shape.
//!
//! All places are evaluated at once by correlation, |t - s|^2 = |t|^2 + |s|^2 - 2 t.s, in 64-bit floating point
//! with a stated error; those that could be the best within it are decided by their exact sums.

use realfft::num_complex::Complex64;

use super::further::RELATIVE_ERROR;
use super::profile::squared_distance;
use crate::numeric::fourier::Fourier;
use crate::size::Size;
use crate::synthesis::quantise::{IndexTexels, squared_length, squared_lengths};

/// Texels to be found in an exemplar.
pub struct Template<'a> {
    /// The rectangle that has to fit inside the exemplar.
    pub size: Size,
    /// Column and row in that rectangle, and the codes there.
    pub texels: Vec<((usize, usize), &'a [i16])>,
}

impl<'a> Template<'a> {
    /// Compares it with all places of an exemplar.
    pub fn compared<'t>(&'t self, exemplar: &'t ExemplarSpectra<'a>) -> ComparedTemplate<'t> {
        let size = exemplar.texels.size();
        let fits = self.size.width <= size.width && self.size.height <= size.height;
        let (errors, margin) = if fits { self.errors(exemplar) } else { (Vec::new(), 0.0) };
        ComparedTemplate { template: self, exemplar: exemplar.texels, errors, margin }
    }

    /// The approximate sums for all places, and their largest error.
    fn errors(&self, exemplar: &ExemplarSpectra<'_>) -> (Vec<f64>, f64) {
        let (size, transform) = (exemplar.texels.size(), &exemplar.transform);
        let spectrum = |value: &dyn Fn(&[i16]) -> f64| {
            let mut image = vec![0.0; size.texels()];
            self.texels.iter().for_each(|((x, y), codes)| image[size.index(*x, *y)] = value(codes));
            transform.forward(image)
        };
        let mask = spectrum(&|_| 1.0);
        let mut product: Vec<Complex64> =
            mask.iter().zip(&exemplar.squares).map(|(t, s)| t.conj() * s).collect();
        for (k, whole) in exemplar.planes.iter().enumerate() {
            let ours = spectrum(&|codes| f64::from(codes[k]));
            let parts = ours.iter().zip(whole).map(|(t, s)| t.conj() * s);
            product.iter_mut().zip(parts).for_each(|(sum, part)| *sum -= 2.0 * part);
        }
        let own: u64 = self.texels.iter().map(|(_, codes)| squared_length(codes)).sum();
        let mut errors = transform.inverse(product);
        errors.iter_mut().for_each(|error| *error += own as f64);
        let planes = exemplar.planes.len() as f64;
        let of_squares = exemplar.fourth_powers.sqrt() * (self.texels.len() as f64).sqrt();
        let of_codes = exemplar.norm.sqrt() * (own as f64).sqrt() * planes.sqrt();
        (errors, RELATIVE_ERROR * (of_squares + 2.0 * of_codes) + 0.5)
    }

    /// The slow truth of a sum.
    pub fn direct(&self, exemplar: &IndexTexels, x: usize, y: usize) -> u64 {
        let error = |((i, j), codes): &((usize, usize), &[i16])| {
            squared_distance(codes, exemplar.run(x + i, y + j, 1))
        };
        self.texels.iter().map(error).sum()
    }
}

/// A template and its differences from all places of an exemplar.
pub struct ComparedTemplate<'t> {
    template: &'t Template<'t>,
    exemplar: &'t IndexTexels,
    /// The approximate sums for all places, row by row; none where the template does not fit inside.
    errors: Vec<f64>,
    /// The largest error of those values.
    margin: f64,
}

impl ComparedTemplate<'_> {
    /// The allowed place of the top left corner with the least sum of squared differences, and that sum; the
    /// topmost, then leftmost of equals.
    pub fn best(&self, allowed: impl Fn(usize, usize) -> bool) -> Option<((usize, usize), u64)> {
        let (size, template) = (self.exemplar.size(), self.template.size);
        let rows = 0..(size.height + 1).saturating_sub(template.height);
        let columns = (size.width + 1).saturating_sub(template.width);
        let places = rows.flat_map(|y| (0..columns).map(move |x| (x, y))).filter(|&(x, y)| allowed(x, y));
        let places: Vec<(usize, usize)> = places.collect();
        let approximate = |&(x, y): &(usize, usize)| self.errors[size.index(x, y)];
        let least = places.iter().map(approximate).min_by(f64::total_cmp)?;
        let near = places.into_iter().filter(|place| approximate(place) <= least + 2.0 * self.margin);
        let exact = near.map(|(x, y)| (self.template.direct(self.exemplar, x, y), y, x));
        exact.min().map(|(sum, y, x)| ((x, y), sum))
    }
}

/// The spectra of an exemplar: of its planes, and of the squared lengths of its texels.
pub struct ExemplarSpectra<'a> {
    texels: &'a IndexTexels,
    transform: Fourier,
    planes: Vec<Vec<Complex64>>,
    squares: Vec<Complex64>,
    norm: f64,
    fourth_powers: f64,
}

impl<'a> ExemplarSpectra<'a> {
    /// Transforms an exemplar.
    pub fn new(texels: &'a IndexTexels) -> Self {
        let (size, count) = (texels.size(), texels.planes());
        let transform = Fourier::new(size);
        let codes = &texels.codes()[..size.texels() * count];
        let plane = |k: usize| {
            transform.forward(codes[k..].iter().step_by(count).map(|&code| f64::from(code)).collect())
        };
        let planes = (0..count).map(plane).collect();
        let squares: Vec<f64> =
            squared_lengths(codes, count).into_iter().map(|square| square as f64).collect();
        let norm = squares.iter().sum();
        let fourth_powers = squares.iter().map(|square| square * square).sum();
        Self { texels, planes, squares: transform.forward(squares), transform, norm, fourth_powers }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::numeric::random::{Purpose, Stream};
    use crate::synthesis::roller::tests::noise;
    use proptest::prelude::*;

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(60))]

        #[test]
        fn the_best_place_is_that_of_all_direct_sums(
            (extra_w, extra_h, planes) in (0usize..9, 0usize..9, 1usize..4), seed in any::<u64>(),
        ) {
            let tile = Size::new(7, 5);
            let size = Size::new(tile.width + extra_w, tile.height + extra_h);
            let exemplar = noise(size, planes, seed);
            let mut stream = Stream::new(seed, Purpose::Sample, [1]);
            let codes: Vec<i16> = (0..tile.texels() * planes).map(|_| stream.below(4096) as i16).collect();
            let texels = codes.chunks_exact(planes).enumerate().filter(|_| stream.below(3) > 0);
            let texels = texels.map(|(t, codes)| ((t % 7, t / 7), codes)).collect();
            let template = Template { size: tile, texels };
            let spectra = ExemplarSpectra::new(&exemplar.texels()[0]);
            let allowed = |x: usize, y: usize| (x + 2 * y) % 3 != 1;
            let places = (0..=extra_h).flat_map(|y| (0..=extra_w).map(move |x| (x, y)));
            let sums = places.filter(|&(x, y)| allowed(x, y));
            let truth = sums.map(|(x, y)| (template.direct(&exemplar.texels()[0], x, y), y, x)).min().unwrap();
            let compared = template.compared(&spectra);
            prop_assert_eq!(compared.best(allowed), Some(((truth.2, truth.1), truth.0)));
            prop_assert_eq!(compared.best(|_, _| false), None);
            let larger = Template { size: Size::new(size.width + 1, 5), texels: template.texels.clone() };
            prop_assert_eq!(larger.compared(&spectra).best(|_, _| true), None);
        }
    }
}
