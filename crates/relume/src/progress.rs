//! How long work tells how far it has come, without knowing who listens.

/// Told how far a piece of work has come; called from any thread. `()` does not listen.
pub trait Progress: Sync {
    /// Work of `steps` steps begins; `what` is a short phrase such as "fitting photographs".
    fn start(&self, what: &str, steps: u64);
    /// `steps` more are done.
    fn advance(&self, steps: u64);
}

impl Progress for () {
    fn start(&self, _what: &str, _steps: u64) {}
    fn advance(&self, _steps: u64) {}
}
