//! Photographs that take no part in a fit, developed as those of the fit were.
//!
//! What was found or declared for all photographs of the fit alike is taken as it is: the space of their samples, the light
//! of the room, the white card, the grey patch, the mask and the part. What belongs to one photograph is known for those that were
//! fitted, too. For others, exposures and shifts are found together with the photographs of the fit; intensities, and white cards
//! of single lamps, are not known.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use relume::capture::develop::{Development, shifts};
use relume::{Direction, Error, ErrorKind, Job, Planes, Raster, Result};
use serde_json::json;

use super::measure::exposures_of;
use super::{PhotographArgs, PhotographSet};

/// The photographs of a test beside those of the fit.
struct Beside<'a> {
    fitted: &'a PhotographSet,
    test: &'a PhotographSet,
    /// The number in the fit of each photograph of the test that took part.
    known: Vec<Option<usize>>,
    /// The numbers of the others.
    strangers: Vec<usize>,
}

impl PhotographSet {
    /// Photographs for a test of what was fitted to these, which `args` developed.
    ///
    /// # Errors
    /// Everything wrong with the capture, and photographs of another size than those of the fit.
    pub fn test_set(&self, path: &Path, args: &PhotographArgs, job: &Job) -> Result<Self> {
        let located =
            PhotographArgs { pair: args.pair, orientation: args.orientation, ..PhotographArgs::default() };
        let mut set = Self::open(path, &located, None, job)?;
        let (first, fitted) = (set.stored(0, job)?, self.stored(0, job)?);
        if first.channels() != fitted.channels() {
            let kind = |channels: usize| if channels == 1 { "grey" } else { "in colour" };
            return Err(Error::invalid(format!(
                "the photographs of the test are {} and those of the fit {}: both must be of one kind",
                kind(first.channels()),
                kind(fitted.channels())
            ))
            .at(&set.capture.light_file));
        }
        let (own, whole) = (first.size(), fitted.size());
        if own != whole {
            return Err(Error::invalid(format!(
                "the photographs of the test are {own} pixels and those of the fit {whole}: both must have the same size"
            ))
            .at(&set.capture.light_file));
        }
        set.place_lamps(args, job)?;
        let lamps = set.development.lamps.take();
        let beside = Beside::new(self, &set);
        let mut missing = Vec::new();
        let mut development = Development { lamps, ..self.development.clone() };
        development.intensities = beside.intensities(&mut missing);
        development.flat = beside.cards(&mut missing);
        development.shifts = beside.shifts(&mut missing, job)?;
        development.gains = beside.gains(&development, &mut missing, job)?;
        let strangers = beside.strangers.len();
        let facts = [
            ("fitted_photographs", json!(set.lights.len() - strangers)),
            ("not_applied", json!(missing)),
            ("intensities", json!(development.intensities)),
            ("shifts", json!(development.shifts)),
            ("gains", json!(development.gains)),
        ];
        set.facts = facts.into_iter().map(|(name, value)| (name.to_owned(), value)).collect();
        set.development = development;
        if !missing.is_empty() {
            set.warnings.push(format!(
                "{strangers} of {} photographs of the test took no part in the fit, and what {} undoes is not known for them: they \
                 are compared without it",
                set.lights.len(),
                missing.join(" and ")
            ));
        }
        Ok(set)
    }

    /// The files of the photographs, each under one name.
    fn files_by_name(&self) -> Vec<PathBuf> {
        let one = |path: &Path| std::fs::canonicalize(path).unwrap_or_else(|_| path.to_path_buf());
        self.paths().into_iter().map(one).collect()
    }
}

impl<'a> Beside<'a> {
    fn new(fitted: &'a PhotographSet, test: &'a PhotographSet) -> Self {
        let files = fitted.files_by_name();
        let number = |file: PathBuf| files.iter().position(|other| *other == file);
        let known: Vec<Option<usize>> = test.files_by_name().into_iter().map(number).collect();
        let strangers = (0..known.len()).filter(|i| known[*i].is_none()).collect();
        Self { fitted, test, known, strangers }
    }

    fn intensities(&self, missing: &mut Vec<&'static str>) -> Vec<[f64; 3]> {
        let of_fit = &self.fitted.development.intensities;
        if of_fit.is_empty() {
            return Vec::new();
        }
        missing.extend((!self.strangers.is_empty()).then_some("--intensities"));
        self.known.iter().map(|known| known.map_or([1.0; 3], |i| of_fit[i])).collect()
    }

    fn cards(&self, missing: &mut Vec<&'static str>) -> Vec<Arc<Planes>> {
        let of_fit = &self.fitted.development.flat;
        let [first, _, ..] = of_fit.as_slice() else { return of_fit.clone() };
        missing.extend((!self.strangers.is_empty()).then_some("--white-card"));
        let mut even = Planes::zeros(first.size(), first.count());
        even.as_mut_slice().fill(1.0);
        let even = Arc::new(even);
        self.known.iter().map(|known| known.map_or(&even, |i| &of_fit[i]).clone()).collect()
    }

    fn shifts(&self, missing: &mut Vec<&'static str>, job: &Job) -> Result<Vec<[f64; 2]>> {
        let of_fit = &self.fitted.development.shifts;
        if of_fit.is_empty() {
            return Ok(Vec::new());
        }
        let lights = self.lights();
        let found = || Ok(shifts(&lights, &|i| self.stored(i, job), job)?.shifts);
        let found = self.of_strangers("--align", found, missing)?;
        Ok(self.each(of_fit, found.as_deref(), [0.0; 2]))
    }

    fn gains(
        &self,
        development: &Development,
        missing: &mut Vec<&'static str>,
        job: &Job,
    ) -> Result<Vec<f64>> {
        let of_fit = &self.fitted.development.gains;
        if of_fit.is_empty() {
            return Ok(Vec::new());
        }
        // As they were when the exposures of the fit were found.
        let before = |of: &Development| Development { gains: Vec::new(), white: None, ..of.clone() };
        let (fitted, test) = (before(&self.fitted.development), before(development));
        let count = of_fit.len();
        let load = |i: usize| match i.checked_sub(count) {
            None => fitted.apply(i, self.stored(i, job)?),
            Some(k) => test.apply(self.strangers[k], self.stored(i, job)?),
        };
        let found = || {
            let found = exposures_of(&self.lights(), &load, self.fitted.mask(), job)?.gains;
            // The product of the factors of the fit is 1.
            let scale = (found[..count].iter().map(|gain| gain.ln()).sum::<f64>() / count as f64).exp();
            Ok(found.into_iter().map(|gain| gain / scale).collect())
        };
        let found = self.of_strangers("--equalize", found, missing)?;
        Ok(self.each(of_fit, found.as_deref(), 1.0))
    }

    /// What is found of the photographs that were not fitted, together with those that were.
    fn of_strangers<T>(
        &self,
        option: &'static str,
        find: impl FnOnce() -> Result<Vec<T>>,
        missing: &mut Vec<&'static str>,
    ) -> Result<Option<Vec<T>>> {
        if self.strangers.is_empty() {
            return Ok(None);
        }
        match find() {
            Ok(mut found) => Ok(Some(found.split_off(self.fitted.lights.len()))),
            Err(error) if matches!(error.kind(), ErrorKind::Invalid | ErrorKind::Usage) => {
                missing.push(option);
                Ok(None)
            }
            Err(error) => Err(error),
        }
    }

    /// The value of each photograph of the test: that of the fit, that which was found, or the usual one.
    fn each<T: Copy>(&self, of_fit: &[T], found: Option<&[T]>, usual: T) -> Vec<T> {
        let mut found = found.into_iter().flatten().copied();
        self.known
            .iter()
            .map(|known| known.map_or_else(|| found.next().unwrap_or(usual), |i| of_fit[i]))
            .collect()
    }

    /// The photographs of the fit and then the strangers.
    fn lights(&self) -> Vec<(String, Direction)> {
        let strangers = self.strangers.iter().map(|&i| &self.test.lights[i]);
        self.fitted.lights.iter().chain(strangers).cloned().collect()
    }

    fn stored(&self, i: usize, job: &Job) -> Result<Raster> {
        match i.checked_sub(self.fitted.lights.len()) {
            None => self.fitted.stored(i, job),
            Some(k) => self.test.stored(self.strangers[k], job),
        }
    }
}
