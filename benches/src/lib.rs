//! What the benchmark targets share: the measurement, and the table of ratios.
//!
//! `cargo bench -p benches --bench fpk` measures one crate; the targets are `kernels`, `neighbour`, `particles`, `sde`,
//! `fpk`, `moments`, `smpm` and `peridynamics`, and `plain`, steps written by hand beside ours. `cargo bench -p benches -- --test` runs everything once, unmeasured.
//!
//! Every time is CPU time of the process, on one thread. Rivals are measured in the same run, and what counts is the ratio:
//! [`ratios`] prints it for `kernels`, `neighbour`, `particles`, `smpm` and `plain`. Criterion measures what takes microseconds as well, and
//! keeps it for comparison between runs.

pub mod output;
pub mod page;
pub mod ratios;
pub mod record;

use std::time::Duration;

use cpu_time::ProcessTime;
use criterion::Criterion;
use criterion::measurement::{Measurement, ValueFormatter, WallTime};

/// CPU time of the process, all its threads together.
///
/// Unlike wall time it does not count the time in which others had the processor. What others do to caches and clock
/// rates remains in it. Reading it is a system call, dearer than a wall clock: samples should last well beyond a microsecond.
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
/// Without options it takes a second for a measurement, not five, and resamples less: the comparisons that count are those
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
