//! Parameters of guided paths, and their checks.

use sde_integrators::Error;

/// Parameters of guided paths.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct GuidedConfig {
    /// Number of paths, at least 2 and at most 2^62; for exceedances at several times, of each time.
    pub n_paths: u64,
    /// Number of pilot paths that choose the strengths; none of them enters the estimate.
    pub n_pilots: u64,
    /// Share of the paths without a guide, in `[0, 1)`: bounds every weight by its inverse.
    pub unguided: f64,
    /// Seed of all random numbers; pilot paths are realisations of their own.
    pub seed: u64,
}

/// How a system of many states is linearised and guided.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PairwiseRule {
    /// Longest step of the linearisation (time): a tenth of the shortest period suffices for a guide.
    pub step: f64,
    /// Number of steps of a path for which its guide is held, at least 1.
    pub hold: usize,
    /// Standard deviation of a response that its linearised system leaves out, over that of the response (no unit).
    ///
    /// 0 for a linear system; 0.25 for a building whose storeys yield. It keeps guides from insisting on a response that the
    /// linearised system predicts badly: weights are then more even, and fewer paths reach the event.
    pub unmodelled: f64,
}

impl PairwiseRule {
    pub(crate) fn check(&self) -> Result<(), Error> {
        let Self { hold, unmodelled, .. } = *self;
        if !(unmodelled.is_finite() && unmodelled >= 0.0) {
            let (quantity, value) = ("unmodelled deviation of a response", unmodelled);
            return Err(Error::OutOfRange { quantity, value, from: 0.0, to: f64::INFINITY });
        }
        if hold == 0 {
            let quantity = "steps for which a guide is held";
            return Err(Error::TooFew { quantity, value: 0, limit: 1 });
        }
        Ok(())
    }
}

impl GuidedConfig {
    pub(crate) fn check(&self, thresholds: &[f64]) -> Result<(), Error> {
        const MOST: u64 = 1 << 62;
        if let Some(index) = thresholds.iter().position(|threshold| !threshold.is_finite()) {
            return Err(Error::NotFinite {
                quantity: "threshold",
                index,
                value: thresholds[index],
            });
        }
        if !(self.unguided >= 0.0 && self.unguided < 1.0) {
            let (quantity, value) =
                ("share of unguided paths, which must be below 1,", self.unguided);
            return Err(Error::OutOfRange { quantity, value, from: 0.0, to: 1.0 });
        }
        if self.n_paths < 2 {
            return Err(Error::TooFew { quantity: "paths", value: self.n_paths, limit: 2 });
        }
        for (quantity, value) in [("paths", self.n_paths), ("pilot paths", self.n_pilots)] {
            if value > MOST {
                let (value, limit) = (value as f64, MOST as f64);
                return Err(Error::TooMany { quantity, value, limit });
            }
        }
        Ok(())
    }
}

/// Rejects numbers of steps to times that are none, do not increase, or pass the end of the paths.
pub(crate) fn check_times(n_steps: &[usize], most: usize) -> Result<(), Error> {
    if n_steps.is_empty() {
        return Err(Error::TooFew { quantity: "times", value: 0, limit: 1 });
    }
    let mut from = 0;
    for &steps in n_steps {
        if !(from < steps && steps <= most) {
            let quantity = "number of steps to a time";
            let (value, from, to) = (steps as f64, from as f64 + 1.0, most as f64);
            return Err(Error::OutOfRange { quantity, value, from, to });
        }
        from = steps;
    }
    Ok(())
}
