//! CPU time of a computation, also next to other work of the process.

use std::time::Duration;

use cpu_time::{ProcessTime, ThreadTime};

/// CPU time since a start (s): of this thread where parallel loops have no other thread, else of the process.
///
/// In a pool of one thread all parallel loops run on the thread that reads the clock, so computation of other pools of
/// the process is not counted.
#[derive(Debug, Clone, Copy)]
pub struct CpuClock(Duration);

impl CpuClock {
    /// Starts the clock.
    #[must_use]
    pub fn start() -> Self {
        Self(now())
    }

    /// CPU time since the start (s). Call it in the thread pool in which the clock was started.
    #[must_use]
    pub fn seconds(&self) -> f64 {
        now().saturating_sub(self.0).as_secs_f64()
    }
}

fn now() -> Duration {
    if rayon::current_thread_index().is_some() && rayon::current_num_threads() == 1 {
        ThreadTime::now().as_duration()
    } else {
        ProcessTime::now().as_duration()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn work_of_other_threads_is_not_counted_in_a_pool_of_one() {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(1).build().unwrap();
        let busy = |seconds: f64| {
            let clock = ThreadTime::now();
            while clock.elapsed().as_secs_f64() < seconds {
                std::hint::spin_loop();
            }
        };
        std::thread::scope(|scope| {
            let clock = CpuClock::start();
            scope.spawn(|| busy(0.2)).join().unwrap();
            assert!(clock.seconds() >= 0.2);
            let here = pool.install(|| {
                let clock = CpuClock::start();
                scope.spawn(|| busy(0.2)).join().unwrap();
                busy(0.01);
                clock.seconds()
            });
            assert!((0.01..0.15).contains(&here), "{here}");
        });
    }
}
