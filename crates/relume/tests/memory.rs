//! The memory that stages foresee against the memory they take, measured at the allocator.

#[path = "integration/stages.rs"]
mod stages;

use peak_alloc::PeakAlloc;
use relume::{Job, Limits};

#[global_allocator]
static ALLOCATED: PeakAlloc = PeakAlloc;

/// Bytes besides what grows with the input: options, small tables, scratch memory of the threads.
const FIXED: usize = 2 << 20;

#[test]
fn stages_take_no_more_memory_than_they_foresee() {
    // The threads of the pool exist before anything is measured.
    rayon::join(|| (), || ());
    let mut over = Vec::new();
    for stage in stages::all(128) {
        let job = Job::new(Limits { max_bytes: 1 << 40, ..Limits::default() });
        ALLOCATED.reset_peak_usage();
        let before = ALLOCATED.current_usage();
        (stage.run)(&job).unwrap_or_else(|e| panic!("{}: {e}", stage.name));
        let taken = ALLOCATED.peak_usage().saturating_sub(before);
        let foreseen = job.peak_bytes() as usize;
        let mib = |bytes: usize| bytes as f64 / f64::from(1 << 20);
        let line = format!("{:<40} foresees {:8.2} takes {:8.2} MiB", stage.name, mib(foreseen), mib(taken));
        eprintln!("{line}: {:.2}", foreseen as f64 / taken as f64);
        if taken * 19 / 20 > foreseen + FIXED {
            over.push(line);
        }
        assert_eq!(job.free_bytes(), 1 << 40, "{}: everything held is given back", stage.name);
    }
    assert!(over.is_empty(), "{over:#?}");
}
