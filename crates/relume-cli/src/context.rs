//! What every verb shares: the common options, turned into limits, threads and progress.

use std::sync::Arc;

use clap::Args;
use relume::{Cancel, Error, Job, Limits, Result};

use crate::progress::Bar;

/// Options every verb takes.
#[derive(Debug, Args)]
pub struct Common {
    /// Print a machine-readable result on standard output
    #[arg(long, global = true, help_heading = "Common options")]
    pub json: bool,
    /// Overwrite existing outputs
    #[arg(long, global = true, help_heading = "Common options")]
    pub force: bool,
    /// Worker threads [default: one for each processor]; results do not depend on it
    #[arg(long, global = true, value_name = "N", help_heading = "Common options")]
    pub threads: Option<usize>,
    /// Memory one job may use, in GiB [default: three quarters of what is free]
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
    /// What readers and stages work within.
    pub job: Job,
    /// A bar on standard error, silent unless that is a terminal.
    pub bar: Arc<Bar>,
}

impl Context {
    /// Checks the options and sets the number of threads; `cancel` stops the work.
    pub fn new(common: Common, cancel: Cancel) -> Result<Self> {
        if let Some(threads) = common.threads {
            if !(1..=1024).contains(&threads) {
                return Err(Error::usage(format!("--threads {threads}: expected a number from 1 to 1024")));
            }
            rayon::ThreadPoolBuilder::new().num_threads(threads).build_global().map_err(|e| {
                Error::new(relume::ErrorKind::Io, format!("cannot start {threads} threads: {e}"))
            })?;
        }
        let bar = Arc::new(Bar::default());
        let job = Job::new(limits(common.memory)?).with_progress(bar.clone()).with_cancel(cancel);
        Ok(Self { json: common.json, force: common.force, job, bar })
    }
}

/// The limits for a budget in GiB, or for the memory that is free now.
fn limits(memory_gib: Option<f64>) -> Result<Limits> {
    let default = Limits::default();
    let max_bytes = match memory_gib {
        Some(gib) if gib.is_finite() && gib > 0.0 => (gib * (1u64 << 30) as f64) as u64,
        Some(gib) => return Err(Error::usage(format!("--memory {gib}: expected a number of GiB above 0"))),
        None => available_bytes().map_or(default.max_bytes, |free| free / 4 * 3),
    };
    Ok(Limits { max_bytes, ..default })
}

/// Memory the system says it can hand out; `None` where it does not say.
fn available_bytes() -> Option<u64> {
    let text = std::fs::read_to_string("/proc/meminfo").ok()?;
    let line = text.lines().find_map(|line| line.strip_prefix("MemAvailable:"))?;
    let kib: u64 = line.trim().strip_suffix("kB")?.trim().parse().ok()?;
    Some(kib * 1024)
}
