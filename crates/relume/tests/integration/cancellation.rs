//! A cancelled job stops soon, whatever stage it is in.

use std::time::{Duration, Instant};

use relume::{Cancel, ErrorKind, Job};

use crate::stages;

/// When the flag is set.
const AFTER: Duration = Duration::from_millis(50);
/// How long a stage may go on after that: half a second of an idle machine, and tests share theirs.
const AT_MOST: Duration = Duration::from_secs(2);

#[test]
fn every_stage_stops_soon_after_it_is_cancelled() {
    let mut late = Vec::new();
    for stage in stages::all(192) {
        let cancel = Cancel::default();
        let job = Job::default().with_cancel(cancel.clone());
        let flag = std::thread::spawn(move || {
            std::thread::sleep(AFTER);
            cancel.cancel();
            Instant::now()
        });
        let result = (stage.run)(&job);
        let ended = Instant::now();
        let waited = ended.saturating_duration_since(flag.join().unwrap());
        if let Err(error) = &result {
            assert_eq!(error.kind(), ErrorKind::Cancelled, "{}: {error}", stage.name);
        }
        if waited > AT_MOST {
            late.push(format!("{} went on for {:.2} s", stage.name, waited.as_secs_f64()));
        }
    }
    assert!(late.is_empty(), "{late:#?}");
}

/// Files are decoded by other crates, which ask nobody.
const NOT_ASKING: &str = "reading ";

#[test]
fn a_stage_of_a_cancelled_job_has_no_result() {
    let cancel = Cancel::default();
    cancel.cancel();
    let job = Job::default().with_cancel(cancel);
    let mut unasked = Vec::new();
    for stage in stages::all(128).iter().filter(|stage| !stage.name.starts_with(NOT_ASKING)) {
        match (stage.run)(&job) {
            Err(error) => assert_eq!(error.kind(), ErrorKind::Cancelled, "{}: {error}", stage.name),
            Ok(()) => unasked.push(stage.name),
        }
    }
    assert!(unasked.is_empty(), "these did not ask whether to go on: {unasked:#?}");
}
