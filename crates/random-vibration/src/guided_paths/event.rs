//! Events of a path whose probability is estimated.

use sde_integrators::GuidedPath;

use crate::tail::Tails;

/// An event of a path.
#[derive(Debug, Clone, Copy)]
pub(crate) enum Event<'e> {
    /// A weighted sum of the states exceeds a threshold at the end.
    AtEnd { weights: &'e [f64], threshold: f64, tails: Tails },
    /// The largest response passes a level within some of the steps.
    Passage { level: usize, n_steps: u64 },
}

/// What is known of a path when its event is decided.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Known<'p> {
    pub(crate) log_ratios: &'p [f64],
    pub(crate) log_weight: f64,
}

impl Event<'_> {
    /// Ratios and weight of a path at the time at which its event is decided, if it happens.
    pub(crate) fn known<'p>(&self, path: &GuidedPath<'p>) -> Option<Known<'p>> {
        match *self {
            Self::AtEnd { weights, threshold, tails } => {
                let demand: f64 = weights.iter().zip(path.end).map(|(w, x)| w * x).sum();
                let is_hit = match tails {
                    Tails::Both => demand.abs() > threshold,
                    Tails::Doubled | Tails::Upper => demand > threshold,
                };
                let GuidedPath { log_ratios, log_weight, .. } = *path;
                is_hit.then_some(Known { log_ratios, log_weight })
            }
            Self::Passage { level, n_steps } => {
                let passage = path.passages.get(level).copied().flatten()?;
                let (log_ratios, log_weight) = (passage.log_ratios, passage.log_weight);
                (passage.steps <= n_steps).then_some(Known { log_ratios, log_weight })
            }
        }
    }

    /// Factor on the probability: 2 if one of two equal tails is sampled.
    pub(crate) fn sides(&self) -> f64 {
        if matches!(self, Self::AtEnd { tails: Tails::Doubled, .. }) { 2.0 } else { 1.0 }
    }
}
