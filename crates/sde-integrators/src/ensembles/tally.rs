//! Observables and their tallies.

use std::fmt;

use crate::error::Error;
use crate::estimate::{Accumulator, Estimate};

/// An observable of every path at every output time.
///
/// ```
/// use sde_integrators::Observable;
///
/// let threshold = 0.5;
/// let exceeds = |_t: f64, x: &[f64; 2]| x[0].abs() > threshold;
/// let observables =
///     [Observable::Mean(&|_t, x| x[0] * x[0]), Observable::Probability(&exceeds)];
/// assert_eq!(observables.len(), 2);
/// ```
#[derive(Clone, Copy)]
pub enum Observable<'a, const D: usize> {
    /// Mean of a function of time and state, with the error of [`Accumulator::cautious_estimate`].
    Mean(&'a (dyn Fn(f64, &[f64; D]) -> f64 + Sync)),
    /// Probability of an event, with the error of [`Estimate::probability`].
    Probability(&'a (dyn Fn(f64, &[f64; D]) -> bool + Sync)),
}

impl<const D: usize> fmt::Debug for Observable<'_, D> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Mean(_) => "Mean(..)",
            Self::Probability(_) => "Probability(..)",
        })
    }
}

/// Tally of one observable at one output time.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub(crate) enum Tally {
    Values(Accumulator),
    Events { hits: u64, trials: u64 },
}

/// Contribution of one path to a tally.
#[derive(Debug, Clone, Copy)]
pub(crate) enum Observed {
    Value(f64),
    Event(bool),
}

impl Tally {
    pub(crate) fn new<const D: usize>(observable: &Observable<'_, D>) -> Self {
        match observable {
            Observable::Mean(_) => Self::Values(Accumulator::default()),
            Observable::Probability(_) => Self::Events { hits: 0, trials: 0 },
        }
    }

    pub(crate) fn push(&mut self, seen: Observed) {
        match (self, seen) {
            (Self::Values(values), Observed::Value(value)) => values.push(value),
            (Self::Events { hits, trials }, Observed::Event(happened)) => {
                *hits += u64::from(happened);
                *trials += 1;
            }
            _ => unreachable!("a tally is of the kind of its observable"),
        }
    }

    /// Whether the tally is possible for this number of values, and can be merged with another.
    pub(crate) fn is_of(&self, most: u64, other: &Self) -> bool {
        let count = match *self {
            Self::Values(values) => Some(values.count()),
            Self::Events { hits, trials } => (hits <= trials).then_some(trials),
        };
        let is_kind = std::mem::discriminant(self) == std::mem::discriminant(other);
        is_kind && count.is_some_and(|count| count <= most)
    }

    pub(crate) fn estimate(&self) -> Result<Estimate, Error> {
        match *self {
            Self::Values(values) => values.cautious_estimate(),
            Self::Events { hits, trials } => Estimate::probability(hits, trials),
        }
    }

    pub(crate) fn merge(&mut self, later: &Self) {
        match (self, later) {
            (Self::Values(a), Self::Values(b)) => a.merge(b),
            (Self::Events { hits, trials }, Self::Events { hits: h, trials: n }) => {
                *hits += h;
                *trials += n;
            }
            _ => unreachable!("tallies of one observable are of one kind"),
        }
    }
}

impl Observed {
    pub(crate) fn of<const D: usize>(
        observable: &Observable<'_, D>,
        t: f64,
        x: &[f64; D],
    ) -> Result<Self, f64> {
        let finite = |value: f64| if value.is_finite() { Ok(value) } else { Err(value) };
        Ok(match observable {
            Observable::Mean(f) => Self::Value(finite(f(t, x))?),
            Observable::Probability(event) => Self::Event(event(t, x)),
        })
    }
}
