//! How far a run has come: a bar on a terminal, plain lines elsewhere, always on stderr.

use std::io::{IsTerminal, Write, stderr};
use std::time::Duration;

use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};

/// Prints which case runs.
#[derive(Debug)]
pub(super) struct Progress {
    bar: ProgressBar,
    is_terminal: bool,
}

impl Progress {
    pub(super) fn new(n_cases: usize) -> Self {
        let is_terminal = stderr().is_terminal();
        let bar = ProgressBar::with_draw_target(Some(n_cases as u64), ProgressDrawTarget::hidden());
        if is_terminal {
            bar.set_draw_target(ProgressDrawTarget::stderr());
            if let Ok(style) =
                ProgressStyle::with_template("{elapsed_precise} [{bar:24}] {pos}/{len} {wide_msg}")
            {
                bar.set_style(style.progress_chars("=> "));
            }
            bar.enable_steady_tick(Duration::from_millis(200));
        }
        Self { bar, is_terminal }
    }

    pub(super) fn start(&self, case_id: &str) {
        if self.is_terminal {
            self.bar.set_message(case_id.to_owned());
        } else {
            let (done, all) = (self.bar.position() + 1, self.bar.length().unwrap_or(0));
            // Progress that cannot be shown is no reason to stop a run.
            let _ = writeln!(stderr(), "[{done}/{all}] {case_id}");
        }
    }

    /// Shown on the bar only: lines would drown the rows of a log.
    pub(super) fn tell(&self, case_id: &str, what: &str) {
        self.bar.set_message(format!("{case_id}: {what}"));
    }

    /// Runs `print` with the bar out of the way.
    pub(super) fn suspend<R>(&self, print: impl FnOnce() -> R) -> R {
        self.bar.suspend(print)
    }

    pub(super) fn finish_case(&self) {
        self.bar.inc(1);
    }

    pub(super) fn finish(&self) {
        self.bar.finish_and_clear();
    }
}
