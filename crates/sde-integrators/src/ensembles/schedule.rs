//! Ensemble configuration and its time steps.

use crate::error::Error;

/// Ensemble size, step and output times. Paths start at `t = 0`.
#[derive(Debug, Clone, PartialEq)]
pub struct EnsembleConfig {
    /// Seed of all random numbers.
    pub seed: u64,
    /// Number of paths, at least 2; they are the realisations from 0 on.
    pub n_paths: u64,
    /// Largest step length (time).
    ///
    /// Between two output times the steps are equal and as few as possible, and the last ends exactly on the output
    /// time: `ceil(interval/dt)` steps. A quotient within a relative 1e-9 above an integer counts as that integer.
    pub dt: f64,
    /// Output times (time): ascending, none negative. Time zero observes the initial distribution.
    pub times: Vec<f64>,
}

impl EnsembleConfig {
    /// Largest number of steps per path: beyond it step numbers are not exact in `f64`.
    pub const MAX_STEPS: u64 = 1 << 53;
}

/// The steps between two output times.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Leg {
    pub(crate) start: f64,
    pub(crate) end: f64,
    pub(crate) n_steps: u64,
    pub(crate) dt: f64,
}

/// Validates the configuration and divides the time.
pub(crate) fn schedule(config: &EnsembleConfig) -> Result<Vec<Leg>, Error> {
    let EnsembleConfig { n_paths, dt, ref times, .. } = *config;
    if n_paths < 2 {
        return Err(Error::TooFew { quantity: "paths", value: n_paths, limit: 2 });
    }
    if !(dt.is_finite() && dt > 0.0) {
        return Err(Error::NotPositive { quantity: "dt", value: dt });
    }
    if times.is_empty() {
        return Err(Error::TooFew { quantity: "output times", value: 0, limit: 1 });
    }
    let mut legs = Vec::with_capacity(times.len());
    let (mut start, mut relation, mut total) = (0.0, "at least", 0.0);
    for (index, &end) in times.iter().enumerate() {
        if !end.is_finite() || end < start || (index > 0 && end <= start) {
            return Err(Error::OutputTime { index, value: end, relation, limit: start });
        }
        let steps = ((end - start) / dt * (1.0 - 1e-9)).ceil();
        total += steps;
        let limit = EnsembleConfig::MAX_STEPS as f64;
        if total > limit {
            return Err(Error::TooMany { quantity: "steps per path", value: total, limit });
        }
        #[allow(
            clippy::cast_possible_truncation,
            clippy::cast_sign_loss,
            reason = "a whole number from 0 to 2^53"
        )]
        let n_steps = steps as u64;
        let dt = if n_steps > 0 { (end - start) / steps } else { 0.0 };
        legs.push(Leg { start, end, n_steps, dt });
        (start, relation) = (end, "above");
    }
    Ok(legs)
}
