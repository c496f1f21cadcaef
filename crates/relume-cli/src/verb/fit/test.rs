//! The result of a fit under lights that took no part in it.

use relume::direction::Directions;
use relume::workflow::tested::{self, ComparedPhotographs, TestReport};
use relume::{ReflectanceField, Result};
use serde_json::{Value, json};

use super::Args;
use super::input::Inputs;
use crate::context::Context;
use crate::decibels::decibels;
use crate::report::counted;

/// A test, and how its photographs were developed.
pub(super) struct Test {
    report: TestReport,
    facts: Value,
    pub warnings: Vec<String>,
}

/// The test that was asked for, of photographs developed as those of the fit.
pub(super) fn run(
    args: &Args,
    inputs: &Inputs,
    field: &ReflectanceField,
    context: &Context,
) -> Result<Option<Test>> {
    let Some(path) = &args.test else { return Ok(None) };
    let set = inputs.test_set(path, args, &context.job)?;
    let pairs: Vec<(String, Directions)> =
        set.lights().iter().map(|(name, light)| (name.clone(), (*light).into())).collect();
    let load = |i: usize| set.photograph(i, &context.job);
    let lamps = inputs.lamps(field.basis()).and_then(|_| set.lamps());
    let photographs = ComparedPhotographs {
        pairs: &pairs,
        load: &load,
        lamps: lamps.as_ref(),
        mask: set.mask(),
        are_fitted: false,
        set_aside: Vec::new(),
    };
    let report =
        tested::test(field, &photographs, &context.job).map_err(|e| e.at(&set.capture.light_file))?;
    let said = |warning: &String| format!("test: {warning}");
    Ok(Some(Test {
        report,
        facts: set.facts.clone().into(),
        warnings: set.warnings.iter().map(said).collect(),
    }))
}

impl Test {
    /// The test in words, as a line of its own.
    pub(super) fn summary(&self) -> String {
        let report = &self.report;
        let worst = &report.lights[report.worst];
        let exact = match report.exact {
            0 => String::new(),
            exact => format!(", of those that are not exact; {exact} are exact"),
        };
        let fitted = match self.facts["fitted_photographs"].as_u64() {
            None | Some(0) => String::new(),
            Some(fitted) if fitted == report.lights.len() as u64 => ", all of them fitted".to_owned(),
            Some(fitted) => format!(", {fitted} of them fitted"),
        };
        format!(
            "\n{} of the test{fitted}: {} PSNR (mean over pictures{exact}); worst: {}, {}",
            counted(report.lights.len(), "photograph"),
            decibels(report.psnr_db),
            worst.name,
            decibels(worst.psnr_db)
        )
    }

    /// The mean over pictures, and everything, for programs.
    pub(super) fn described(&self) -> (Value, Value) {
        let mut all = json!(self.report);
        all["development"] = self.facts.clone();
        (json!(self.report.psnr_db), all)
    }
}
