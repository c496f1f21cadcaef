//! One job: its limits, the memory it holds, the listener to its progress, its cancellation, and the remarks
//! of its readers.

use std::fmt;
use std::path::Path;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};

use crate::clipping::{Clipper, Clipping};
use crate::error::{Error, ErrorKind, Result};
use crate::limits::Limits;
use crate::memory;
use crate::progress::Progress;
use crate::remarks::Remarks;
use crate::size::Size;

/// The limits, progress listener, cancellation flag and remarks of one piece of work.
///
/// Clones share them all, so one memory budget covers all stages of a job: before a stage allocates, it asks
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
    ledger: Arc<Ledger>,
    progress: Option<Arc<dyn Progress>>,
    cancel: Cancel,
    remarks: Arc<Remarks>,
    /// The file that is being read.
    file: Option<Arc<Path>>,
    asks_system: bool,
}

/// A flag that cancels a job from outside; clones are the same flag.
#[derive(Debug, Clone, Default)]
pub struct Cancel(Arc<AtomicBool>);

/// What all clones of a job have taken of its budget, in bytes.
#[derive(Debug, Default)]
struct Ledger {
    held: AtomicU64,
    peak: AtomicU64,
}

/// Bytes that count against the budget of a job until this guard is dropped.
///
/// A clone stands for a copy of the data, so it counts again. It never fails: the copy exists already,
/// and the next request is refused instead.
#[derive(Debug, Default)]
#[must_use = "the bytes are given back as soon as this is dropped"]
pub struct Held {
    bytes: u64,
    ledger: Arc<Ledger>,
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

    /// A job without limits, of callers that have none.
    pub(crate) fn unlimited() -> Self {
        Self::new(Limits { max_bytes: u64::MAX, max_side: usize::MAX })
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

    /// The same job, which also asks the system for every request: limits on the address space of a process
    /// (`ulimit -v`) and sizes that no machine has are then refused in words, where an allocation without
    /// memory would end the process. What is asked for is given back at once, untouched.
    #[must_use]
    pub fn asking_system(self) -> Self {
        Self { asks_system: true, ..self }
    }

    /// The limits of the whole job.
    pub fn limits(&self) -> &Limits {
        &self.limits
    }

    /// The bytes of the budget not yet held.
    pub fn free_bytes(&self) -> u64 {
        self.limits.max_bytes.saturating_sub(self.ledger.held.load(Ordering::Relaxed))
    }

    /// The most bytes that were held and asked for at one time so far: the peak of the job's memory
    /// as its stages foresaw it.
    pub fn peak_bytes(&self) -> u64 {
        self.ledger.peak.load(Ordering::Relaxed)
    }

    /// Refuses `what` when a side of `size` is zero or too long, or when it does not fit beside the memory
    /// held.
    ///
    /// # Errors
    /// [`ErrorKind::Limit`], and [`ErrorKind::Invalid`] for a side of zero.
    pub fn check(&self, what: &str, size: Size, bytes_per_texel: u64) -> Result<()> {
        self.limits.check(what, size, 0)?;
        let texels = (size.width as u64).saturating_mul(size.height as u64);
        self.check_bytes(what, texels.saturating_mul(bytes_per_texel))
    }

    /// Refuses `what` when it does not fit beside the memory held.
    ///
    /// # Errors
    /// [`ErrorKind::Limit`].
    pub fn check_bytes(&self, what: &str, bytes: u64) -> Result<()> {
        if bytes > self.free_bytes() {
            return Err(self.refusal(what, bytes));
        }
        self.ask(what, bytes)?;
        self.ledger.note(bytes);
        Ok(())
    }

    /// Counts `bytes` against the budget for as long as the result lives.
    ///
    /// # Errors
    /// [`ErrorKind::Limit`] when they do not fit beside the memory held.
    pub fn hold(&self, what: &str, bytes: u64) -> Result<Held> {
        self.ask(what, bytes.min(self.free_bytes()))?;
        let most = self.limits.max_bytes;
        let added = |held: u64| held.checked_add(bytes).filter(|sum| *sum <= most);
        match self.ledger.held.fetch_update(Ordering::Relaxed, Ordering::Relaxed, added) {
            Ok(_) => {
                self.ledger.note(0);
                Ok(Held { bytes, ledger: Arc::clone(&self.ledger) })
            }
            Err(_) => Err(self.refusal(what, bytes)),
        }
    }

    /// The same job, whose remarks concern a file.
    #[must_use]
    pub fn about(&self, file: &Path) -> Self {
        Self { file: Some(file.into()), ..self.clone() }
    }

    /// Keeps a remark on the file that is read: a sentence about a value that was left out, converted or
    /// taken by convention. It has no full stop.
    pub fn remark(&self, sentence: impl Into<String>) {
        self.remarks.add(sentence.into(), self.file.as_deref());
    }

    /// Counts values that a file or a measure cannot hold: one remark says it of all of them together.
    pub(crate) fn count_clipped(&self, clipper: Clipper, clipping: Clipping) {
        self.remarks.count(clipper, clipping, self.file.as_deref());
    }

    /// The same job, whose remarks are not heard: of work of which the caller says the same in its own words.
    #[must_use]
    pub(crate) fn unheard(&self) -> Self {
        Self { remarks: Arc::default(), ..self.clone() }
    }

    /// The remarks so far, each once and with the files it concerns, in alphabetical order.
    pub fn remarks(&self) -> Vec<String> {
        self.remarks.sentences()
    }

    fn ask(&self, what: &str, bytes: u64) -> Result<()> {
        if !self.asks_system {
            return Ok(());
        }
        memory::with_capacity::<u8>(what, usize::try_from(bytes).unwrap_or(usize::MAX)).map(|given| {
            std::hint::black_box(given);
        })
    }

    fn refusal(&self, what: &str, bytes: u64) -> Error {
        self.limits.refusal(what, bytes, self.ledger.held.load(Ordering::Relaxed))
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

impl Ledger {
    /// Keeps the peak: `more` bytes are about to be taken beside those that are held.
    fn note(&self, more: u64) {
        self.peak.fetch_max(self.held.load(Ordering::Relaxed).saturating_add(more), Ordering::Relaxed);
    }
}

impl Held {
    /// Gives back what is more than `bytes`.
    pub fn shrink(&mut self, bytes: u64) {
        let less = self.bytes.saturating_sub(bytes);
        self.bytes -= less;
        self.ledger.held.fetch_sub(less, Ordering::Relaxed);
    }
}

impl Clone for Held {
    fn clone(&self) -> Self {
        self.ledger.held.fetch_add(self.bytes, Ordering::Relaxed);
        self.ledger.note(0);
        Self { bytes: self.bytes, ledger: Arc::clone(&self.ledger) }
    }
}

impl PartialEq for Held {
    /// Always: which job counts them makes no difference between data.
    fn eq(&self, _: &Self) -> bool {
        true
    }
}

impl Eq for Held {}

impl Drop for Held {
    fn drop(&mut self) {
        self.ledger.held.fetch_sub(self.bytes, Ordering::Relaxed);
    }
}

impl fmt::Debug for Job {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Job")
            .field("limits", &self.limits)
            .field("ledger", &self.ledger)
            .field("is_heard", &self.progress.is_some())
            .field("cancel", &self.cancel)
            .field("asks_system", &self.asks_system)
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
        assert_eq!((stage.free_bytes(), job.peak_bytes()), (100, 100));
    }

    #[test]
    fn copies_count_again_and_the_next_request_is_refused() {
        let job = Job::new(Limits { max_bytes: 100, ..Limits::default() });
        let mut held = job.hold("the exemplar", 60).unwrap();
        let copy = held.clone();
        assert_eq!((job.free_bytes(), job.peak_bytes()), (0, 120));
        assert_eq!(job.check_bytes("a table", 1).unwrap_err().kind(), ErrorKind::Limit);
        drop(copy);
        held.shrink(10);
        assert_eq!(job.free_bytes(), 90);
        drop(held);
        assert_eq!(job.free_bytes(), 100);
    }

    #[test]
    fn a_job_that_asks_the_system_refuses_what_no_machine_has() {
        let limits = Limits { max_bytes: u64::MAX, max_side: usize::MAX };
        let (trusting, asking) = (Job::new(limits), Job::new(limits).asking_system());
        let most = u64::MAX / 2;
        assert!(trusting.check_bytes("a table", most).is_ok());
        for refused in [
            asking.clone().check_bytes("a table", most).unwrap_err(),
            asking.check("a table", Size::new(1 << 40, 1 << 20), 1).unwrap_err(),
            asking.hold("a table", most).unwrap_err(),
        ] {
            assert_eq!(refused.kind(), ErrorKind::Limit);
            assert!(refused.message().contains("which the system does not give"), "{refused}");
        }
        assert!(asking.hold("a table", 100).is_ok());
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
