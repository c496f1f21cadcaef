//! Progress of long work, reported without knowing the listener.

/// Receives the progress of a piece of work; called from any thread.
pub trait Progress: Send + Sync {
    /// Work of `steps` steps begins; `what` is a short phrase such as "fitting photographs".
    fn start(&self, what: &str, steps: u64);
    /// `steps` more are done.
    fn advance(&self, steps: u64);
}
