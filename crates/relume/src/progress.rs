//! How long work tells how far it has come, without knowing who listens.

/// Told how far a piece of work has come; called from any thread.
pub trait Progress: Send + Sync {
    /// Work of `steps` steps begins; `what` is a short phrase such as "fitting photographs".
    fn start(&self, what: &str, steps: u64);
    /// `steps` more are done.
    fn advance(&self, steps: u64);
}
