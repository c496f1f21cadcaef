//! Signals that end the program: unfinished outputs are removed, and the exit status shows the signal.
//!
//! A thread waits for them. The work is cancelled and has a moment to stop; then, stopped or not, the
//! temporaries of this process are removed and it ends with 128 plus the number of the signal.

use std::sync::atomic::{AtomicI32, Ordering};
use std::time::Duration;

use crate::output::remove_all;

/// The time in which the work may stop by itself.
const PATIENCE: Duration = Duration::from_millis(300);

/// The signal that ends the program, or 0.
static RECEIVED: AtomicI32 = AtomicI32::new(0);

/// Ends the program if a signal was received: the error of the cancelled work is not reported.
pub fn end_if_received() {
    match RECEIVED.load(Ordering::SeqCst) {
        0 => {}
        signal => end(signal),
    }
}

/// Removes unfinished outputs and ends the program.
fn end(signal: i32) -> ! {
    let _held = remove_all();
    std::process::exit(128 + signal)
}

/// Watches for signals from now on; `cancel` cancels the work. Exceeding the limit on file sizes becomes a
/// write error.
///
/// # Errors
/// When the system refuses handlers or the thread.
#[cfg(unix)]
pub fn watch(cancel: impl Fn() + Send + 'static) -> std::io::Result<()> {
    use signal_hook::consts::{SIGHUP, SIGINT, SIGTERM, SIGXFSZ};
    use signal_hook::iterator::Signals;

    // It ends a process that does not handle it; setting a flag that is never read is enough handling.
    signal_hook::flag::register(SIGXFSZ, std::sync::Arc::default())?;
    let watched = if hangup_is_ignored() { &[SIGINT, SIGTERM][..] } else { &[SIGINT, SIGTERM, SIGHUP][..] };
    let mut signals = Signals::new(watched)?;
    std::thread::Builder::new().name("signals".to_owned()).spawn(move || {
        if let Some(signal) = signals.forever().next() {
            RECEIVED.store(signal, Ordering::SeqCst);
            cancel();
            std::thread::sleep(PATIENCE);
            end(signal);
        }
    })?;
    Ok(())
}

/// Other systems end programs themselves.
///
/// # Errors
/// Never.
#[cfg(not(unix))]
pub fn watch(_cancel: impl Fn() + Send + 'static) -> std::io::Result<()> {
    Ok(())
}

/// Whether the program was started to outlive its terminal (`nohup`).
#[cfg(unix)]
fn hangup_is_ignored() -> bool {
    let status = std::fs::read_to_string("/proc/self/status").unwrap_or_default();
    let ignored = status.lines().find_map(|line| line.strip_prefix("SigIgn:"));
    ignored.and_then(|mask| u64::from_str_radix(mask.trim(), 16).ok()).is_some_and(|mask| mask & 1 == 1)
}
