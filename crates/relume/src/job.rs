//! One job: its limits, the memory it holds, the listener to its progress, and its cancellation.

use std::fmt;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};

use crate::error::{Error, ErrorKind, Result};
use crate::limits::Limits;
use crate::progress::Progress;
use crate::size::Size;

/// The limits, progress listener and cancellation flag of one piece of work.
///
/// Clones share all three, so one memory budget covers all stages of a job: before a stage allocates, it asks
/// [`Job::check`] whether the allocation fits beside the memory already held; whatever outlives a stage is
/// held with [`Job::hold`].
///
/// ```
/// use relume::{Job, Limits, Size};
///
/// let job = Job::new(Limits { max_bytes: 1000, ..Limits::default() });
/// let exemplar = job.hold("the exemplar", 600)?;
/// assert!(job.check("the result", Size::new(10, 10), 8).is_err());
/// drop(exemplar);
/// assert!(job.check("the result", Size::new(10, 10), 8).is_ok());
/// # Ok::<(), relume::Error>(())
/// ```
#[derive(Clone, Default)]
pub struct Job {
    limits: Limits,
    held_bytes: Arc<AtomicU64>,
    progress: Option<Arc<dyn Progress>>,
    cancel: Cancel,
}

/// A flag that cancels a job from outside; clones are the same flag.
#[derive(Debug, Clone, Default)]
pub struct Cancel(Arc<AtomicBool>);

/// Bytes that count against the budget of a job until this guard is dropped.
#[derive(Debug)]
#[must_use = "the bytes are given back as soon as this is dropped"]
pub struct Held {
    bytes: u64,
    held_bytes: Arc<AtomicU64>,
}

impl Cancel {
    /// Asks the job to stop.
    pub fn cancel(&self) {
        self.0.store(true, Ordering::Relaxed);
    }

    /// Whether the job has been asked to stop.
    pub fn is_cancelled(&self) -> bool {
        self.0.load(Ordering::Relaxed)
    }
}

impl Job {
    /// A job within these limits, without a progress listener.
    pub fn new(limits: Limits) -> Self {
        Self { limits, ..Self::default() }
    }

    /// The same job, with a progress listener.
    #[must_use]
    pub fn with_progress(self, progress: Arc<dyn Progress>) -> Self {
        Self { progress: Some(progress), ..self }
    }

    /// The same job, cancelled by this flag.
    #[must_use]
    pub fn with_cancel(self, cancel: Cancel) -> Self {
        Self { cancel, ..self }
    }

    /// The limits of the whole job.
    pub fn limits(&self) -> &Limits {
        &self.limits
    }

    /// The bytes of the budget not yet held.
    pub fn free_bytes(&self) -> u64 {
        self.limits.max_bytes.saturating_sub(self.held_bytes.load(Ordering::Relaxed))
    }

    /// Refuses `what` when a side of `size` is zero or too long, or when it does not fit beside the memory
    /// held.
    ///
    /// # Errors
    /// [`ErrorKind::Limit`], and [`ErrorKind::Invalid`] for a side of zero.
    pub fn check(&self, what: &str, size: Size, bytes_per_texel: u64) -> Result<()> {
        self.free().check(what, size, bytes_per_texel)
    }

    /// Refuses `what` when it does not fit beside the memory held.
    ///
    /// # Errors
    /// [`ErrorKind::Limit`].
    pub fn check_bytes(&self, what: &str, bytes: u64) -> Result<()> {
        self.free().check_bytes(what, bytes)
    }

    /// Counts `bytes` against the budget for as long as the result lives.
    ///
    /// # Errors
    /// [`ErrorKind::Limit`] when they do not fit beside the memory held.
    pub fn hold(&self, what: &str, bytes: u64) -> Result<Held> {
        let limits = self.limits;
        let added = |held: u64| held.checked_add(bytes).filter(|sum| *sum <= limits.max_bytes);
        match self.held_bytes.fetch_update(Ordering::Relaxed, Ordering::Relaxed, added) {
            Ok(_) => Ok(Held { bytes, held_bytes: Arc::clone(&self.held_bytes) }),
            Err(_) => Err(self.free().refusal(what, bytes)),
        }
    }

    fn free(&self) -> Limits {
        Limits { max_bytes: self.free_bytes(), ..self.limits }
    }

    /// Work of `steps` steps begins; `what` is a short phrase such as "fitting photographs".
    pub fn start(&self, what: &str, steps: u64) {
        if let Some(progress) = &self.progress {
            progress.start(what, steps);
        }
    }

    /// Counts `steps` more steps as done; the work continues unless the job has been cancelled.
    ///
    /// # Errors
    /// [`ErrorKind::Cancelled`].
    pub fn advance(&self, steps: u64) -> Result<()> {
        if let Some(progress) = &self.progress {
            progress.advance(steps);
        }
        self.proceed()
    }

    /// Ends the work at this point when the job has been cancelled.
    ///
    /// # Errors
    /// [`ErrorKind::Cancelled`].
    pub fn proceed(&self) -> Result<()> {
        match self.cancel.is_cancelled() {
            true => Err(Error::new(ErrorKind::Cancelled, "stopped before it was done")),
            false => Ok(()),
        }
    }
}

impl Drop for Held {
    fn drop(&mut self) {
        self.held_bytes.fetch_sub(self.bytes, Ordering::Relaxed);
    }
}

impl fmt::Debug for Job {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Job")
            .field("limits", &self.limits)
            .field("held_bytes", &self.held_bytes)
            .field("is_heard", &self.progress.is_some())
            .field("cancel", &self.cancel)
            .finish()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn stages_share_one_budget() {
        let job = Job::new(Limits { max_bytes: 100, ..Limits::default() });
        let stage = job.clone();
        let held = job.hold("the exemplar", 60).unwrap();
        assert_eq!(stage.free_bytes(), 40);
        assert!(stage.check_bytes("a table", 40).is_ok());
        assert_eq!(stage.hold("a table", 41).unwrap_err().kind(), ErrorKind::Limit);
        assert_eq!(stage.hold("a table", u64::MAX).unwrap_err().kind(), ErrorKind::Limit);
        drop(held);
        assert_eq!(stage.free_bytes(), 100);
    }

    #[test]
    fn a_cancelled_job_does_not_proceed() {
        let cancel = Cancel::default();
        let job = Job::default().with_cancel(cancel.clone());
        assert!(job.proceed().is_ok());
        cancel.cancel();
        assert_eq!(job.clone().proceed().unwrap_err().kind(), ErrorKind::Cancelled);
    }
}
