//! What the photographs themselves tell: how they moved, how their exposures differ, and what is grey in them.

use relume::capture::develop::{
    Development, Exposures, Shifts, exposures, grey_factors, linear, sample_texels, share_by_direction,
    shifts,
};
use relume::raster::LoadRaster;
use relume::words::listed;
use relume::{Direction, Error, Job, Planes, Rect, Result, Samples, Size, Space};
use serde_json::json;

use super::{BETWEEN, LISTED, PhotographArgs, PhotographSet};

/// The share of exposures that follow the light from which on they may be shading.
const SHADING_SHARE: f64 = 0.7;

impl PhotographSet {
    /// Finds how photographs moved, how their exposures differ, and what is grey in them, as far as the options ask for it;
    /// `foresee` is told the size and the channels of developed photographs before, and may refuse the work.
    ///
    /// # Errors
    /// Those of `foresee`, and photographs that cannot be read or do not tell.
    pub fn measure(
        &mut self,
        args: &PhotographArgs,
        foresee: &dyn Fn(Size, usize) -> Result<()>,
        job: &Job,
    ) -> Result<()> {
        if !args.measure() {
            return Ok(());
        }
        let first = self.photograph(0, job)?;
        foresee(first.size(), first.channels())?;
        drop(first);
        if args.align {
            self.align(job)?;
        }
        if args.equalize {
            self.equalize(job)?;
        }
        if let Some(part) = args.grey {
            self.balance(part, job)?;
        }
        Ok(())
    }

    fn align(&mut self, job: &Job) -> Result<()> {
        let names: Vec<String> = self.lights.iter().map(|(name, _)| name.clone()).collect();
        let Shifts { shifts: found, untold, by_light } = shifts(&self.lights, &|i| self.stored(i, job), job)?;
        if !untold.is_empty() {
            self.warnings.push(format!(
                "{} photographs do not agree with the others well enough to tell whether they moved, and stay where they are: {}",
                untold.len(),
                listed(&untold.iter().map(|&i| names[i].as_str()).collect::<Vec<_>>(), LISTED, BETWEEN)
            ));
        }
        if by_light > 0.5 {
            self.warnings.push(format!(
                "shifts of up to {by_light:.2} pixels follow the direction of the light, as moving shadows do, and were not undone"
            ));
        }
        let far = |s: &[f64; 2]| s[0].hypot(s[1]);
        let moved: Vec<String> = names
            .iter()
            .zip(&found)
            .filter(|(_, s)| far(s) > 0.5)
            .map(|(name, [right, down])| format!("{name} by {right:.2}, {down:.2}"))
            .collect();
        if !moved.is_empty() {
            self.warnings.push(format!(
                "{} of {} photographs moved by more than half a pixel (right, down) and were moved back: {}",
                moved.len(),
                names.len(),
                listed(&moved, LISTED, BETWEEN)
            ));
        }
        self.facts.insert("shifts".to_owned(), json!(found));
        self.development.shifts = found;
        Ok(())
    }

    fn equalize(&mut self, job: &Job) -> Result<()> {
        let load = |i: usize| self.development.apply(i, self.stored(i, job)?);
        let found = exposures_of(&self.lights, &load, self.mask(), job);
        let Exposures { gains: found, untold } = found.map_err(|e| e.at(&self.capture.light_file))?;
        if !untold.is_empty() {
            let names: Vec<&str> = untold.iter().map(|&i| self.lights[i].0.as_str()).collect();
            self.warnings.push(format!(
                "the exposures of {} photographs cannot be told, since they are dark or shadows cover most of what would be lit; those \
                 of the nearest lights are taken: {}",
                names.len(),
                listed(&names, LISTED, BETWEEN)
            ));
            self.facts.insert("exposures_not_told".to_owned(), json!(names));
        }
        let odd: Vec<String> = self
            .lights
            .iter()
            .zip(&found)
            .filter(|(_, gain)| !(0.9..1.1).contains(*gain))
            .map(|((name, _), gain)| format!("{name} by {gain:.2}"))
            .collect();
        if !odd.is_empty() {
            self.warnings.push(format!(
                "the exposures of {} photographs differ by more than a tenth and were multiplied: {}",
                odd.len(),
                listed(&odd, LISTED, BETWEEN)
            ));
        }
        let share = share_by_direction(&self.lights, &found).unwrap_or(0.0);
        if share > SHADING_SHARE && !odd.is_empty() {
            self.warnings.push(format!(
                "{:.0} % of these differences follow the direction of the light, as the shading of a surface that is not matt does: \
                 if the camera kept its exposure and the lamps are alike, leave out --equalize",
                100.0 * share
            ));
            self.facts.insert("gains_by_direction".to_owned(), json!(share));
        }
        self.facts.insert("gains".to_owned(), json!(found));
        self.development.gains = found;
        Ok(())
    }

    fn balance(&mut self, part: Rect<usize>, job: &Job) -> Result<()> {
        let whole = self.stored(0, job)?.size();
        if whole.check_crop(part.x, part.y, part.size).is_err() {
            return Err(Error::invalid(format!(
                "--grey: {} pixels at ({}, {}) do not lie inside the photographs of {whole}: give left, top, width and height of a \
                 grey patch in them",
                part.size, part.x, part.y
            ))
            .at(&self.capture.light_file));
        }
        // The patch may lie beside the surface.
        let frames = Development { crop: None, reduction: 1, mask: None, ..self.development.clone() };
        let mut sums = [0.0; 3];
        for i in 0..self.lights.len() {
            let developed = frames.apply(i, self.stored(i, job)?)?;
            let patch: Planes = linear(&developed.crop(part.x, part.y, part.size)?, None);
            if patch.count() != 3 {
                return Err(Error::usage("--grey is for coloured photographs, and these are grey"));
            }
            for (sum, plane) in sums.iter_mut().zip(patch.iter()) {
                *sum += plane.iter().map(|v| f64::from(*v)).sum::<f64>();
            }
        }
        let factors = grey_factors(sums)?;
        self.facts.insert("white_balance".to_owned(), json!(factors));
        self.development.white = Some(factors);
        Ok(())
    }
}

/// The exposures of photographs, from the texels that a mask leaves.
pub(super) fn exposures_of(
    lights: &[(String, Direction)],
    load: &LoadRaster<'_>,
    mask: Option<&[bool]>,
    job: &Job,
) -> Result<Exposures> {
    let sample = sample_texels(lights, load, mask, job)?;
    let sample = match load(0)?.samples() {
        Samples::F32(_) => sample,
        _ => sample.mapped(|v| f64::from(Space::Srgb.to_linear(v as f32))),
    };
    exposures(&sample)
}
