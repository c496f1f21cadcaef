//! The common options of all verbs, converted to limits, threads and progress.

use std::sync::Arc;

use clap::Args;
use relume::{Cancel, Error, Job, Limits, Result};

use crate::memory;
use crate::progress::Bar;

/// Options of every verb.
#[derive(Debug, Args)]
pub struct Common {
    /// Print a machine-readable result on standard output
    #[arg(long, global = true, help_heading = "Common options")]
    pub json: bool,
    /// Overwrite existing outputs
    #[arg(long, global = true, help_heading = "Common options")]
    pub force: bool,
    /// Worker threads, 1 to 1024, of which at most four for each processor are started [default: one for each
    /// processor]; results do not depend on it
    #[arg(long, global = true, value_name = "N", help_heading = "Common options")]
    pub threads: Option<usize>,
    /// Memory limit of a job, in GiB [default: three quarters of what is free]
    #[arg(long, global = true, value_name = "GIB", help_heading = "Common options")]
    pub memory: Option<f64>,
}

/// The common options, checked.
#[derive(Debug)]
pub struct Context {
    /// Whether the report is printed as JSON.
    pub json: bool,
    /// Whether existing outputs may be replaced.
    pub force: bool,
    /// The job of readers and stages.
    pub job: Job,
    /// A bar on standard error, silent unless that is a terminal.
    pub bar: Arc<Bar>,
}

impl Context {
    /// Checks the options and sets the number of threads; `cancel` stops the work.
    pub fn new(common: Common, cancel: Cancel) -> Result<Self> {
        if let Some(threads) = common.threads.filter(|threads| !(1..=1024).contains(threads)) {
            return Err(Error::usage(format!("--threads {threads}: expected a number from 1 to 1024")));
        }
        let chosen = common.threads.map(|threads| threads.min(most_threads()));
        let threads = chosen.unwrap_or_else(default_threads);
        let limits = limits(common.memory, at_a_time(threads))?;
        // Started here, since a system that refuses a thread later would stop the program. 0 is the default
        // of the pool.
        let started = chosen.unwrap_or(if threads == processors() { 0 } else { threads });
        rayon::ThreadPoolBuilder::new().num_threads(started).build_global().map_err(|_| {
            Error::new(
                relume::ErrorKind::Io,
                "cannot start the worker threads: allow more memory or processes, or ask for fewer --threads",
            )
        })?;
        let bar = Arc::new(Bar::default());
        let job = Job::new(limits).asking_system().with_progress(bar.clone()).with_cancel(cancel);
        Ok(Self { json: common.json, force: common.force, job, bar })
    }
}

/// The threads that exist at a time where `threads` of our own do: decoders of EXR files start one for each
/// processor, if any.
fn at_a_time(threads: usize) -> usize {
    if threads > 1 { threads + processors() } else { threads }
}

/// More threads than this only take each other's time.
fn most_threads() -> usize {
    4 * processors()
}

fn processors() -> usize {
    std::thread::available_parallelism().map_or(1, std::num::NonZero::get)
}

/// The address space that is left for data where threads have to be given up for it.
const LEAST_DATA_BYTES: u64 = 192 << 20;

/// One for each processor, or as many as leave room for data within the limits of the process.
fn default_threads() -> usize {
    let leave_room =
        |threads: &usize| memory::process(at_a_time(*threads)).is_none_or(|left| left >= LEAST_DATA_BYTES);
    (1..=processors()).rev().find(leave_room).unwrap_or(1)
}

/// The limits for a budget in GiB, or for the memory that is free now. More than the limits of the
/// process would end it, so they hold in any case.
fn limits(memory_gib: Option<f64>, threads: usize) -> Result<Limits> {
    let default = Limits::default();
    let max_bytes = match memory_gib {
        Some(gib) if gib.is_finite() && gib > 0.0 => {
            ((gib * (1u64 << 30) as f64) as u64).min(memory::process(threads).unwrap_or(u64::MAX))
        }
        Some(gib) => return Err(Error::usage(format!("--memory {gib}: expected a number of GiB above 0"))),
        None => memory::available_bytes(threads).map_or(default.max_bytes, |free| free / 4 * 3),
    };
    Ok(Limits { max_bytes, ..default })
}
