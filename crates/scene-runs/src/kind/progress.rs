//! Progress reports: a bar on a terminal, lines elsewhere, always on stderr.

use std::io::{IsTerminal, Write, stderr};
use std::sync::{Mutex, PoisonError};
use std::time::{Duration, Instant};

use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};

/// Minimum interval between two lines of one stage.
const LINES_EVERY: Duration = Duration::from_secs(5);

/// Progress reporter of a run.
#[derive(Debug)]
pub struct Progress {
    show: Show,
    bar: ProgressBar,
    last_line: Mutex<Option<Instant>>,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Show {
    Bar,
    Lines,
    Nothing,
}

impl Progress {
    /// Reports on stderr.
    #[must_use]
    pub fn on_stderr() -> Self {
        Self::new(if stderr().is_terminal() { Show::Bar } else { Show::Lines })
    }

    /// Reports nothing.
    #[must_use]
    pub fn silent() -> Self {
        Self::new(Show::Nothing)
    }

    fn new(show: Show) -> Self {
        let bar = ProgressBar::with_draw_target(Some(0), ProgressDrawTarget::hidden());
        if show == Show::Bar {
            bar.set_draw_target(ProgressDrawTarget::stderr());
            let template = "{elapsed_precise} [{bar:24}] {pos}/{len} {wide_msg}";
            if let Ok(style) = ProgressStyle::with_template(template) {
                bar.set_style(style.progress_chars("=> "));
            }
        }
        Self { show, bar, last_line: Mutex::new(None) }
    }

    /// Announces the next stage.
    pub fn stage(&self, what: &str) {
        *self.last_line.lock().unwrap_or_else(PoisonError::into_inner) = None;
        match self.show {
            Show::Bar => self.bar.println(what),
            Show::Lines => line(what),
            Show::Nothing => {}
        }
    }

    /// Reports the completed fraction of the stage and the current estimate, which is computed only if it is shown.
    pub fn at(&self, (done, all): (u64, u64), estimate: impl FnOnce() -> String) {
        match self.show {
            Show::Bar => {
                self.bar.set_length(all);
                self.bar.set_position(done);
                self.bar.set_message(estimate());
            }
            Show::Lines => {
                let mut last = self.last_line.lock().unwrap_or_else(PoisonError::into_inner);
                if done == all || last.is_none_or(|last| last.elapsed() >= LINES_EVERY) {
                    *last = Some(Instant::now());
                    line(&format!("[{done}/{all}] {}", estimate()));
                }
            }
            Show::Nothing => {}
        }
    }

    /// Removes the bar.
    pub fn finish(&self) {
        self.bar.finish_and_clear();
    }
}

fn line(text: &str) {
    // A failure to show progress does not stop a run.
    let _ = writeln!(stderr(), "{text}");
}
