//! The time taken by a piece of work, by the wall clock and by that of the processor.

use std::time::Instant;

use serde::Serialize;

/// Ticks of the processor clock per second, as reported by Linux on all common machines.
const TICKS: f64 = 100.0;

/// Times of a piece of work in seconds.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Times {
    /// By the wall clock.
    pub seconds: f64,
    /// Of all threads of this program together; `None` if the system does not report it.
    pub processor_seconds: Option<f64>,
}

/// Does some work and measures it. Anything else this program does meanwhile counts as well.
pub fn timed<T>(work: impl FnOnce() -> T) -> (T, Times) {
    let (started, before) = (Instant::now(), processor_ticks());
    let result = work();
    let ticks = processor_ticks().zip(before).map(|(after, before)| after - before);
    let processor_seconds = ticks.map(|ticks| ticks as f64 / TICKS);
    (result, Times { seconds: started.elapsed().as_secs_f64(), processor_seconds })
}

/// Ticks of the processor used so far, by user and system.
fn processor_ticks() -> Option<u64> {
    let text = std::fs::read_to_string("/proc/self/stat").ok()?;
    // The second field is the name of the program in brackets, which may contain anything.
    let fields: Vec<&str> = text.rsplit_once(')')?.1.split_whitespace().collect();
    let ticks = |number: usize| fields.get(number)?.parse::<u64>().ok();
    Some(ticks(11)? + ticks(12)?)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn work_takes_time_on_both_clocks() {
        let (sum, times) = timed(|| {
            let mut state = 1u64;
            let started = Instant::now();
            while started.elapsed().as_secs_f64() < 0.1 {
                state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1);
            }
            state
        });
        assert!(sum != 0 && times.seconds >= 0.1);
        if let Some(used) = times.processor_seconds {
            assert!((0.0..100.0).contains(&used), "{times:?}");
        }
    }
}
