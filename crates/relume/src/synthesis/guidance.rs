//! Guidance: maps that an output follows. Hertzmann, Jacobs, Oliver, Curless, Salesin, "Image Analogies",
//! SIGGRAPH 2001 (texture by numbers); Efros, Freeman, "Image Quilting for Texture Synthesis and Transfer",
//! SIGGRAPH 2001 (texture transfer).
//!
//! One guide covers each exemplar and one the output: any planes, such as label maps, or a blurred copy. They
//! are compared as additional index planes: a difference over the whole range of the guides counts the given
//! weight times the whole range of the widest index plane. For output texels that are not known yet, only the
//! guides are compared.

use super::quantise::{Channels, Exemplar, IndexTexels, Quantised, Scale, check};
use crate::error::{Error, Result};
use crate::job::Job;
use crate::planes::Planes;
use crate::size::Size;

/// The guides of an output.
#[derive(Debug, Clone, PartialEq)]
pub struct Guidance {
    /// A guide for each exemplar, registered with it.
    pub sources: Vec<Planes>,
    /// The guide of the output, of the same size.
    pub target: Planes,
    /// The weight of a difference of the guides relative to one of the texture: 1e-6 to 1e6.
    pub weight: f64,
}

impl Guidance {
    /// Checks the guides against exemplars and the size of an output.
    fn validate(&self, exemplars: &[Exemplar<'_>], size: Size) -> Result<()> {
        if !(1e-6..=1e6).contains(&self.weight) {
            return Err(Error::usage(format!(
                "a guide's weight of {} has no meaning: expected a number from 0.000001 to 1,000,000",
                self.weight
            )));
        }
        if self.sources.len() != exemplars.len() {
            return Err(Error::usage(format!(
                "there are {} guides for {} exemplars: give one for each in turn",
                self.sources.len(),
                exemplars.len()
            )));
        }
        let places = exemplars.iter().map(|exemplar| exemplar.index.size()).chain([size]);
        for (number, (guide, size)) in self.guides().zip(places).enumerate() {
            let of = if number < exemplars.len() {
                format!("exemplar {}", number + 1)
            } else {
                "the output".into()
            };
            if guide.size() != size {
                return Err(Error::usage(format!(
                    "the guide of {of} has {} texels, {of} {size}: they must have the same size",
                    guide.size()
                )));
            }
            if guide.count() != self.target.count() {
                return Err(Error::usage(format!(
                    "the guide of {of} has {} planes, that of the output {}: they must be of one kind",
                    guide.count(),
                    self.target.count()
                )));
            }
            if guide.as_slice().iter().any(|value| !value.is_finite()) {
                return Err(Error::invalid(format!("the guide of {of} holds a value that is not finite")));
            }
        }
        Ok(())
    }

    fn guides(&self) -> impl Iterator<Item = &Planes> {
        self.sources.iter().chain([&self.target])
    }

    /// The factor that turns the values of guides into index planes.
    fn scale(&self, exemplars: &[Exemplar<'_>]) -> f32 {
        let widest = |planes: &mut dyn Iterator<Item = &Planes>| {
            let all: Vec<&Planes> = planes.collect();
            let range = |k: usize| {
                let ranges = all.iter().map(|planes| planes.range(k));
                let (low, high) =
                    ranges.fold((f32::INFINITY, f32::NEG_INFINITY), |a, b| (a.0.min(b.0), a.1.max(b.1)));
                high - low
            };
            (0..all[0].count()).map(range).fold(0.0, f32::max)
        };
        let index = widest(&mut exemplars.iter().map(|exemplar| exemplar.index));
        let guides = widest(&mut self.guides());
        if index > 0.0 && guides > 0.0 { self.weight as f32 * index / guides } else { self.weight as f32 }
    }
}

/// Exemplars with their guides and that of the output, if any.
#[derive(Debug)]
pub(in crate::synthesis) struct Guided<'a> {
    exemplars: &'a [Exemplar<'a>],
    guides: Option<ScaledGuides>,
}

/// Guides scaled so that their values count like those of index planes.
#[derive(Debug)]
struct ScaledGuides {
    /// One for each exemplar.
    sources: Vec<Planes>,
    target: Planes,
}

/// Guides as codes with the step of the exemplars.
#[derive(Debug)]
pub(in crate::synthesis) struct GuideCodes {
    /// One for each exemplar.
    pub sources: Vec<IndexTexels>,
    /// That of the output.
    pub target: IndexTexels,
}

impl<'a> Guided<'a> {
    /// Combines guides with exemplars.
    ///
    /// # Errors
    /// When they do not match, or the limits are exceeded.
    pub fn new(
        exemplars: &'a [Exemplar<'a>],
        guidance: Option<&Guidance>,
        size: Size,
        job: &Job,
    ) -> Result<Self> {
        check(exemplars)?;
        let Some(guidance) = guidance else { return Ok(Self { exemplars, guides: None }) };
        guidance.validate(exemplars, size)?;
        let samples = guidance.guides().map(|guide| (guide.size().texels() * guide.count()) as u64);
        job.check_bytes("the guides", 4 * samples.sum::<u64>())?;
        let scale = guidance.scale(exemplars);
        let scaled = |guide: &Planes| {
            let mut guide = guide.clone();
            guide.as_mut_slice().iter_mut().for_each(|value| *value *= scale);
            let finite = guide.as_slice().iter().all(|value| value.is_finite());
            finite.then_some(guide).ok_or_else(|| {
                Error::usage(format!("a guide's weight of {} is too large for its values", guidance.weight))
            })
        };
        let sources = guidance.sources.iter().map(scaled).collect::<Result<_>>()?;
        Ok(Self { exemplars, guides: Some(ScaledGuides { sources, target: scaled(&guidance.target)? }) })
    }

    /// The exemplars themselves.
    pub fn exemplars(&self) -> &'a [Exemplar<'a>] {
        self.exemplars
    }

    /// The number of planes of a guide; 0 without guides.
    pub fn guides(&self) -> usize {
        self.guides.as_ref().map_or(0, |guides| guides.target.count())
    }

    /// The codes of exemplars with their guides appended to the index planes, and of the guide of the output.
    ///
    /// # Errors
    /// When the limits are exceeded.
    pub fn interleaved(&self, job: &Job) -> Result<(Quantised, Option<IndexTexels>)> {
        let Some(guides) = &self.guides else { return Ok((Quantised::new(self.exemplars, job)?, None)) };
        let mut joined: Vec<Channels<'_>> = self.exemplars.iter().map(Channels::of).collect();
        let first = joined[0].planes.len();
        joined.iter_mut().zip(&guides.sources).for_each(|(own, guide)| own.planes.extend(guide.iter()));
        joined.push(of_guide(&guides.target, first));
        let (mut codes, step) = codes(&joined, job)?;
        let target = codes.pop();
        Ok((Quantised::of(codes, first + self.guides(), step), target))
    }

    /// The codes of the exemplars, and separately those of the guides, in one step.
    ///
    /// # Errors
    /// When the limits are exceeded.
    pub fn apart(&self, job: &Job) -> Result<(Quantised, Option<GuideCodes>)> {
        let Some(guides) = &self.guides else { return Ok((Quantised::new(self.exemplars, job)?, None)) };
        let mut all: Vec<Channels<'_>> = self.exemplars.iter().map(Channels::of).collect();
        let (count, first) = (all.len(), all[0].planes.len());
        all.extend(guides.sources.iter().chain([&guides.target]).map(|guide| of_guide(guide, first)));
        let (mut exemplars, step) = codes(&all, job)?;
        let mut sources = exemplars.split_off(count);
        let target = sources.pop().expect("the output has a guide");
        Ok((Quantised::of(exemplars, first, step), Some(GuideCodes { sources, target })))
    }
}

/// The planes of a guide alone, numbered after `first` index planes.
fn of_guide(guide: &Planes, first: usize) -> Channels<'_> {
    Channels { size: guide.size(), first, planes: guide.iter().collect() }
}

/// All codes in one step, and that step.
fn codes(all: &[Channels<'_>], job: &Job) -> Result<(Vec<IndexTexels>, f64)> {
    job.check_bytes("the index of the exemplars and guides", all.iter().map(Channels::code_bytes).sum())?;
    let scale = Scale::common(all);
    Ok((all.iter().map(|channels| scale.codes(channels)).collect(), scale.step))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::numeric::random::{Purpose, Stream};
    use crate::synthesis::options::Boundary;
    use crate::synthesis::pixel::canvas::PixelCanvas;
    use crate::synthesis::pixel::scan::Scan;
    use crate::synthesis::pixel::window::ComparedWindow;
    use crate::synthesis::pixel::{plain, wei_levoy::neighbourhood::ScanNeighbourhood};
    use crate::synthesis::positions::Positions;
    use proptest::prelude::*;

    fn noise(size: Size, planes: usize, seed: u64) -> Planes {
        let mut stream = Stream::new(seed, Purpose::Sample, [3]);
        let data = (0..size.texels() * planes).map(|_| stream.below(90) as f32).collect();
        Planes::from_vec(size, planes, data).unwrap()
    }

    /// Two exemplars with guides, joined with the guide of an output.
    fn joined(planes: usize, guides: usize, side: usize, size: Size, seed: u64) -> (Quantised, IndexTexels) {
        let fields = sides(side).map(|size| noise(size, planes, seed ^ size.width as u64));
        let exemplars = fields.each_ref().map(|index| Exemplar { index, excluded: None });
        let guidance = Guidance {
            sources: fields.iter().map(|f| noise(f.size(), guides, seed ^ 5)).collect(),
            target: noise(size, guides, seed ^ 7),
            weight: 1.5,
        };
        let job = Job::default();
        let guided = Guided::new(&exemplars, Some(&guidance), size, &job).unwrap();
        let (quantised, target) = guided.interleaved(&job).unwrap();
        (quantised, target.unwrap())
    }

    fn sides(side: usize) -> [Size; 2] {
        [Size::new(side, side + 1), Size::new(side + 2, side)]
    }

    /// The positions of windows of a given side in those exemplars.
    fn positions(side: usize, window: usize) -> Positions {
        Positions::of_areas(&sides(side).map(|size| (size, None)), window, "window").unwrap()
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(25))]

        #[test]
        fn guided_scans_are_those_of_the_plain_loops(
            (planes, guides, seed) in (1usize..5, 1usize..4, any::<u64>()),
            (width, height, half, torus, extra) in (9usize..20, 9usize..17, 1usize..5, any::<bool>(), 0usize..9),
        ) {
            let (size, job, window) = (Size::new(width, height), Job::default(), 2 * half + 1);
            let (quantised, target) = joined(planes, guides, window + extra, size, seed);
            let positions = positions(window + extra, window);
            let scan = Scan::guided(&quantised, &positions, guides, &job).unwrap();
            let boundary = if torus { Boundary::Torus } else { Boundary::Open };
            let mut canvas = PixelCanvas::new(size, planes + guides, boundary, &job).unwrap();
            canvas.guide(&target);
            for texel in (0..size.texels()).step_by(3) {
                canvas.put(texel, positions.nth(texel % positions.count()), &quantised);
                let given = target.run(texel % width, texel / width, 1);
                prop_assert_eq!(canvas.guide_codes(texel), given);
            }
            for texel in (0..size.texels()).step_by(7) {
                let query = ComparedWindow::gaussian(window).query(&canvas, texel);
                let truth = plain::matches(&quantised, &positions, &query, 0.1);
                prop_assert_eq!(scan.matches(&query, 0.1, &[]), truth);
            }
        }
    }

    #[test]
    fn neighbourhoods_hold_the_guides_of_texels_to_come() {
        let (size, job) = (Size::new(9, 8), Job::default());
        let index = noise(size, 2, 1);
        let exemplars = [Exemplar { index: &index, excluded: None }];
        let guide = noise(size, 1, 2);
        let guidance = Guidance { sources: vec![guide.clone()], target: guide, weight: 1.0 };
        let guided = Guided::new(&exemplars, Some(&guidance), size, &job).unwrap();
        let (quantised, target) = guided.interleaved(&job).unwrap();
        let mut canvas = PixelCanvas::new(size, 3, Boundary::Torus, &job).unwrap();
        canvas.guide(&target.unwrap());
        let mut vector = Vec::new();
        ScanNeighbourhood::new(3, false, 1).of_output(&canvas, None, size.index(4, 5), &mut vector);
        let own = |x, y| quantised.texels()[0].run(x, y, 1)[2];
        // Four known texels of three planes, then five guides.
        assert_eq!(vector[12..17], [own(4, 5), own(5, 5), own(3, 6), own(4, 6), own(5, 6)]);
    }

    #[test]
    fn guides_follow_the_index_planes_in_their_weight() {
        let index = Planes::from_vec(Size::new(2, 1), 1, vec![1.0, 5.0]).unwrap();
        let exemplars = [Exemplar { index: &index, excluded: None }];
        let guidance = Guidance {
            sources: vec![Planes::from_vec(Size::new(2, 1), 1, vec![0.0, 0.5]).unwrap()],
            target: Planes::from_vec(Size::new(1, 3), 1, vec![0.5, 0.0, 0.25]).unwrap(),
            weight: 0.5,
        };
        let job = Job::default();
        let guided = Guided::new(&exemplars, Some(&guidance), Size::new(1, 3), &job).unwrap();
        assert_eq!((guided.guides(), guided.exemplars().len()), (1, 1));
        let (quantised, target) = guided.interleaved(&job).unwrap();
        let texels = &quantised.texels()[0];
        // The whole range of the guide counts half of that of the index plane.
        assert_eq!(2 * texels.run(1, 0, 1)[1], texels.run(1, 0, 1)[0]);
        assert_eq!(target.as_ref().unwrap().run(0, 0, 1), &texels.run(1, 0, 1)[1..]);
        // Separately, the codes are the same.
        let (own, guides) = guided.apart(&job).unwrap();
        let guides = guides.unwrap();
        assert_eq!((own.planes(), own.step(), quantised.planes()), (1, quantised.step(), 2));
        assert_eq!(Some(guides.target), target);
        for x in 0..2 {
            assert_eq!(own.texels()[0].run(x, 0, 1), &texels.run(x, 0, 1)[..1]);
            assert_eq!(guides.sources[0].run(x, 0, 1), &texels.run(x, 0, 1)[1..]);
        }
        assert!(Guided::new(&exemplars, Some(&guidance), Size::new(2, 3), &job).is_err());
        let bad = [
            Guidance { weight: 0.0, ..guidance.clone() },
            Guidance { weight: f64::NAN, ..guidance.clone() },
            Guidance { weight: 1e300, ..guidance.clone() },
            Guidance { sources: Vec::new(), ..guidance.clone() },
            Guidance { sources: vec![Planes::zeros(Size::new(3, 1), 1)], ..guidance.clone() },
            Guidance { sources: vec![Planes::zeros(Size::new(2, 1), 2)], ..guidance.clone() },
            Guidance { target: Planes::from_vec(Size::new(1, 3), 1, vec![f32::NAN; 3]).unwrap(), ..guidance },
        ];
        for guidance in bad {
            assert!(Guided::new(&exemplars, Some(&guidance), Size::new(1, 3), &job).is_err());
        }
        assert_eq!(Guided::new(&exemplars, None, Size::new(9, 9), &job).unwrap().exemplars().len(), 1);
    }
}
