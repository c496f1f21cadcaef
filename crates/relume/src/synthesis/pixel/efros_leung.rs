//! Non-parametric sampling: Efros, Leung, "Texture Synthesis by Non-parametric Sampling", ICCV 1999,
//! on index planes.
//!
//! The output grows from a 3 x 3 piece of an exemplar in its middle. Each texel is a copy of the middle of a
//! window drawn from all whose weighted squared distance to the known texels is within (1 + epsilon) of the
//! smallest. The side of the window is the main parameter: it must contain the largest feature of the
//! texture. Windows lie inside the exemplars; there is no threshold on the error, because every texel has to
//! be filled.
//!
//! The known failures are those of the paper: growing garbage, when the growth slips into a part of the
//! exemplar with no way out, and verbatim copying, when windows are so large that only one fits.

use super::canvas::PixelCanvas;
use super::grow::{Grower, Growth, Matcher, Task, check_epsilon, check_output};
use super::window::ComparedWindow;
use crate::error::Result;
use crate::job::Job;
use crate::numeric::random::{Purpose, Stream};
use crate::size::Size;
use crate::synthesis::guidance::Guidance;
use crate::synthesis::options::Boundary;
use crate::synthesis::quantise::Exemplar;
use crate::synthesis::source_map::SourceMap;

/// The side of the piece from which the output grows.
const SEED_SIDE: usize = 3;

/// Options of [`efros_leung`].
#[derive(Debug, Clone, PartialEq)]
pub struct EfrosLeungOptions {
    /// Size of the output in texels.
    pub size: Size,
    /// Side of the window in texels: odd, 3 to 1023.
    pub window: usize,
    /// How much farther than the best a window may be to be a candidate, as a fraction of the best squared
    /// distance: 0 to a million.
    pub epsilon: f64,
    /// Whether the output tiles.
    pub boundary: Boundary,
    /// The guide that the output follows.
    pub guidance: Option<Guidance>,
    /// Seed of the random choices.
    pub seed: u64,
}

impl Default for EfrosLeungOptions {
    /// 256 x 256 texels, windows of 11, epsilon 0.1, open edges.
    fn default() -> Self {
        Self {
            size: Size::new(256, 256),
            window: 11,
            epsilon: 0.1,
            boundary: Boundary::Open,
            guidance: None,
            seed: 0,
        }
    }
}

impl EfrosLeungOptions {
    /// Checks the options in isolation; they are checked against the exemplars later.
    pub fn validate(&self) -> Result<()> {
        check_output(self.size, self.window, self.boundary)?;
        check_epsilon(self.epsilon)
    }
}

/// Grows an output from a seed.
///
/// The result depends on the exemplars and the options only, not on the number of threads.
///
/// # Errors
/// When the options are invalid, no window fits the exemplars, or the limits are exceeded.
pub fn efros_leung(
    exemplars: &[Exemplar<'_>],
    options: &EfrosLeungOptions,
    job: &Job,
) -> Result<(SourceMap, Growth)> {
    options.validate()?;
    let task = Task {
        exemplars,
        guidance: options.guidance.as_ref(),
        size: options.size,
        boundary: options.boundary,
        window: ComparedWindow::gaussian(options.window),
        epsilon: options.epsilon,
        seed: options.seed,
    };
    task.run(job, |grower, canvas, matches| {
        plant(grower, canvas, matches);
        grower.grow(canvas, matches, job)
    })
}

/// Puts the middle of a window drawn at random into the middle of the output; with a guide, of one that fits
/// it.
fn plant(grower: &Grower<'_>, canvas: &mut PixelCanvas, matches: &Matcher<'_>) {
    let mut stream = Stream::new(grower.seed, Purpose::FirstTexels, []);
    let size = canvas.size();
    let corner = if canvas.guides() > 0 {
        let middle = size.index(size.width / 2, size.height / 2);
        let fitting = matches(&grower.window.query(canvas, middle), &[]).positions;
        fitting[stream.below(fitting.len())]
    } else {
        grower.positions.nth(stream.below(grower.positions.count()))
    };
    let inset = (grower.window.side() - SEED_SIDE) / 2;
    let (left, top) = (size.width.saturating_sub(SEED_SIDE) / 2, size.height.saturating_sub(SEED_SIDE) / 2);
    for dy in 0..SEED_SIDE.min(size.height) {
        for dx in 0..SEED_SIDE.min(size.width) {
            let source = corner.offset(inset + dx, inset + dy);
            canvas.put(size.index(left + dx, top + dy), source, grower.exemplars);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::planes::Planes;
    use crate::synthesis::pixel::plain;
    use crate::synthesis::positions::Positions;
    use crate::synthesis::quantise::Quantised;
    use proptest::prelude::*;

    fn noise(size: Size, planes: usize, seed: u64) -> Planes {
        let mut stream = Stream::new(seed, Purpose::Sample, [1]);
        let data = (0..size.texels() * planes).map(|_| stream.below(40) as f32).collect();
        Planes::from_vec(size, planes, data).unwrap()
    }

    /// One texel after another in the order of growth, by the plain search.
    fn sequential(exemplars: &[Exemplar<'_>], options: &EfrosLeungOptions) -> SourceMap {
        let job = Job::default();
        let quantised = Quantised::new(exemplars, &job).unwrap();
        let positions = Positions::new(exemplars, options.window).unwrap();
        let mut canvas = PixelCanvas::new(options.size, quantised.planes(), options.boundary, &job).unwrap();
        let window = ComparedWindow::gaussian(options.window);
        let radius = window.radius();
        let grower =
            Grower { exemplars: &quantised, positions: &positions, window: &window, seed: options.seed };
        let search = |query: &_, _: &[_]| plain::matches(&quantised, &positions, query, options.epsilon);
        plant(&grower, &mut canvas, &search);
        while canvas.unknown().next().is_some() {
            let round = super::super::front::first(&canvas);
            for texel in super::super::front::ordered(&canvas, round, radius, options.seed) {
                let query = window.query(&canvas, texel);
                let fitting = search(&query, &[]).positions;
                let mut stream = Stream::new(options.seed, Purpose::GrownTexel, [texel as u64]);
                let drawn = fitting[stream.below(fitting.len())];
                canvas.put(texel, drawn.offset(radius, radius), &quantised);
            }
        }
        canvas.into_map(exemplars)
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(30))]

        #[test]
        fn equals_the_sequential_growth_at_any_number_of_threads(
            (half, planes, seed) in (1usize..4, 1usize..5, any::<u64>()),
            (width, height, extra) in (1usize..29, 1usize..23, 0usize..9),
            (torus, masked, several) in (any::<bool>(), any::<bool>(), 1usize..3),
        ) {
            let window = 2 * half + 1;
            let least = if torus { window } else { 1 };
            let options = EfrosLeungOptions {
                size: Size::new(width.max(least), height.max(least)),
                window,
                boundary: if torus { Boundary::Torus } else { Boundary::Open },
                seed,
                ..EfrosLeungOptions::default()
            };
            let side = window + extra;
            let fields: Vec<Planes> =
                (0..several).map(|e| noise(Size::new(side + e, side + 2), planes, seed ^ e as u64)).collect();
            let mask = |p: &Planes| (0..p.size().texels()).map(|i| masked && i == 0).collect::<Vec<bool>>();
            let masks: Vec<Vec<bool>> = fields.iter().map(mask).collect();
            let exemplars: Vec<Exemplar<'_>> =
                fields.iter().zip(&masks).map(|(index, mask)| Exemplar { index, excluded: Some(mask) }).collect();
            let truth = sequential(&exemplars, &options);
            for threads in [1, 2, 5] {
                let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
                let made = pool.install(|| efros_leung(&exemplars, &options, &Job::default()).unwrap());
                prop_assert_eq!(&made.0, &truth, "{} threads", threads);
            }
        }
    }

    #[test]
    fn a_periodic_exemplar_is_continued_exactly_around_the_torus() {
        let pattern = noise(Size::new(6, 5), 3, 9);
        let index = pattern.repeated(4, 4);
        let options = EfrosLeungOptions {
            size: Size::new(36, 25),
            window: 9,
            epsilon: 0.0,
            boundary: Boundary::Torus,
            seed: 5,
            ..EfrosLeungOptions::default()
        };
        let made = efros_leung(&[Exemplar { index: &index, excluded: None }], &options, &Job::default());
        let map = made.unwrap().0;
        let phase = |texel: usize| {
            let from = map.copies()[texel];
            ((from.x as usize + 36 - texel % 36) % 6, (from.y as usize + 25 - texel / 36) % 5)
        };
        assert!((0..36 * 25).all(|texel| phase(texel) == phase(0)));
    }

    #[test]
    fn meaningless_options_are_refused() {
        let good = EfrosLeungOptions::default();
        assert!(good.validate().is_ok());
        let bad = [
            EfrosLeungOptions { window: 10, ..good.clone() },
            EfrosLeungOptions { window: 1, ..good.clone() },
            EfrosLeungOptions { epsilon: f64::NAN, ..good.clone() },
            EfrosLeungOptions { epsilon: -0.5, ..good.clone() },
            EfrosLeungOptions { size: Size::new(3, 0), ..good.clone() },
            EfrosLeungOptions { size: Size::new(40, 10), boundary: Boundary::Torus, ..good },
        ];
        assert!(bad.iter().all(|options| options.validate().is_err()));
        let index = noise(Size::new(9, 30), 1, 0);
        let exemplar = [Exemplar { index: &index, excluded: None }];
        let error = efros_leung(&exemplar, &EfrosLeungOptions::default(), &Job::default());
        assert!(error.unwrap_err().message().contains("window of 11 x 11"));
    }
}
