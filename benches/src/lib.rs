//! Measurement and table of ratios, common to the benchmark targets.
//!
//! `cargo bench -p benches --bench fpk` measures one crate. The targets are `kernels`, `neighbour`, `particles`,
//! `sde`, `fpk`, `moments`, `smpm` and `peridynamics`, and `plain`, the hand-written baselines.
//! `cargo bench -p benches -- --test` runs everything once, unmeasured. `neighbour` and `particles` need the feature
//! `rivals`, so that `cargo test --workspace` does not compile crates that only they use.
//!
//! Every time is CPU time of the process, on one thread. Rivals are measured in the same run, and the result is the
//! ratio: [`ratios`] prints it for `kernels`, `neighbour`, `particles`, `smpm` and `plain`. Criterion also measures
//! work that takes microseconds, and stores it for comparison between runs.

pub mod page;
pub mod ratios;
pub mod record;

use std::path::{Path, PathBuf};
use std::time::Duration;

use cpu_time::ProcessTime;
use criterion::Criterion;
use criterion::measurement::{Measurement, ValueFormatter, WallTime};

/// CPU time of the process, over all its threads.
///
/// Unlike wall time it excludes the time in which other processes ran. Their effect on caches and clock rates remains.
/// Reading it is a system call, more expensive than a wall clock: samples should last well over a microsecond.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct CpuTime;

impl Measurement for CpuTime {
    type Intermediate = ProcessTime;
    type Value = Duration;

    fn start(&self) -> ProcessTime {
        ProcessTime::now()
    }

    fn end(&self, start: ProcessTime) -> Duration {
        start.elapsed()
    }

    fn add(&self, v1: &Duration, v2: &Duration) -> Duration {
        *v1 + *v2
    }

    fn zero(&self) -> Duration {
        Duration::ZERO
    }

    fn to_f64(&self, value: &Duration) -> f64 {
        value.as_nanos() as f64
    }

    fn formatter(&self) -> &dyn ValueFormatter {
        WallTime.formatter()
    }
}

/// Criterion with CPU time, configured from the command line.
///
/// By default a measurement takes one second instead of five, with less resampling: the relevant comparisons are those
/// of [`ratios`].
#[must_use]
pub fn criterion() -> Criterion<CpuTime> {
    Criterion::default()
        .with_measurement(CpuTime)
        .warm_up_time(Duration::from_millis(300))
        .measurement_time(Duration::from_secs(1))
        .nresamples(10_000)
        .configure_from_args()
}

/// The root of the workspace; the current folder if cargo did not start the program.
#[must_use]
pub fn workspace() -> PathBuf {
    let package = std::env::var_os("CARGO_MANIFEST_DIR").map(PathBuf::from);
    package.as_deref().and_then(Path::parent).map(Path::to_owned).unwrap_or_default()
}
