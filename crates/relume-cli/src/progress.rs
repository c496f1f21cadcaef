//! A progress bar with the time left, on standard error if that is a terminal.

use std::sync::{Mutex, MutexGuard};

use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};

/// The library's progress drawn as a bar.
#[derive(Debug, Default)]
pub struct Bar {
    current: Mutex<Option<ProgressBar>>,
    part: Mutex<String>,
}

impl relume::Progress for Bar {
    fn start(&self, what: &str, steps: u64) {
        let style = ProgressStyle::with_template("{prefix}{msg:<28} {wide_bar} {pos}/{len}  {eta} left")
            .expect("the template is valid");
        // indicatif draws nothing where standard error is not a terminal.
        let bar = ProgressBar::with_draw_target(Some(steps), ProgressDrawTarget::stderr()).with_style(style);
        bar.set_prefix(self.part().clone());
        bar.set_message(what.to_owned());
        if let Some(finished) = self.current().replace(bar) {
            finished.finish_and_clear();
        }
    }

    fn advance(&self, steps: u64) {
        if let Some(bar) = self.current().as_ref() {
            bar.inc(steps);
        }
    }
}

impl Bar {
    /// Removes the bar from the terminal.
    pub fn clear(&self) {
        if let Some(bar) = self.current().take() {
            bar.finish_and_clear();
        }
    }

    /// Sets the part of a longer job shown before the following bars.
    pub fn set_part(&self, part: String) {
        *self.part() = part;
    }

    fn part(&self) -> MutexGuard<'_, String> {
        self.part.lock().unwrap_or_else(std::sync::PoisonError::into_inner)
    }

    fn current(&self) -> MutexGuard<'_, Option<ProgressBar>> {
        self.current.lock().unwrap_or_else(std::sync::PoisonError::into_inner)
    }
}
