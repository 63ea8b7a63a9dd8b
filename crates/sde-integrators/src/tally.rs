//! Observables and their tallies.

use std::fmt;

use crate::error::Error;
use crate::estimate::{Accumulator, ControlledAccumulator, Estimate};

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
    /// Mean of a function of time and state, with the standard error of the sample mean.
    Mean(&'a (dyn Fn(f64, &[f64; D]) -> f64 + Sync)),
    /// Probability of an event, with the error of [`Estimate::probability`].
    Probability(&'a (dyn Fn(f64, &[f64; D]) -> bool + Sync)),
    /// Mean of a function with a control variate, `E[y] = E[y - b (c - E[c])]`, with the `b` of least variance.
    ///
    /// The standard error decreases by the factor `sqrt(1 - corr(y, c)^2)`. `b` is fitted to the same sample, which
    /// biases the result by a fraction of order `1/n` of its standard deviation. For a control from another system
    /// with the same noise, join the two systems to one with more states.
    Controlled {
        /// `y`, the function whose mean is estimated.
        value: &'a (dyn Fn(f64, &[f64; D]) -> f64 + Sync),
        /// `c`, a function with a known mean.
        control: &'a (dyn Fn(f64, &[f64; D]) -> f64 + Sync),
        /// `E[c]` at a time.
        expected: &'a (dyn Fn(f64) -> f64 + Sync),
    },
}

impl<const D: usize> fmt::Debug for Observable<'_, D> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Mean(_) => "Mean(..)",
            Self::Probability(_) => "Probability(..)",
            Self::Controlled { .. } => "Controlled(..)",
        })
    }
}

/// Dependence between the paths of an ensemble.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub enum Sampling {
    /// Every path has independent noise.
    #[default]
    Independent,
    /// Paths `2k` and `2k + 1` start from the same state; the second has the noise of the first with opposite sign.
    ///
    /// Odd functions of the noise cancel. The sample consists of the means of pairs, and its standard error counts
    /// pairs. The variance of means of nearly linear functions decreases, that of even functions increases: for the
    /// second moment of a linear system it doubles. The number of paths must be even.
    Antithetic,
}

/// Tally of one observable at one output time.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub(crate) enum Tally {
    Values(Accumulator),
    Events { hits: u64, trials: u64 },
    Controlled { values: ControlledAccumulator, expected: f64 },
}

/// Contribution of one path to a tally.
#[derive(Debug, Clone, Copy)]
pub(crate) enum Seen {
    Value(f64),
    Event(bool),
    Controlled([f64; 2]),
}

impl Tally {
    pub(crate) fn new<const D: usize>(
        observable: &Observable<'_, D>,
        t: f64,
        sampling: Sampling,
    ) -> Self {
        match (observable, sampling) {
            (Observable::Controlled { expected, .. }, _) => {
                Self::Controlled { values: ControlledAccumulator::default(), expected: expected(t) }
            }
            (Observable::Probability(_), Sampling::Independent) => {
                Self::Events { hits: 0, trials: 0 }
            }
            _ => Self::Values(Accumulator::default()),
        }
    }

    pub(crate) fn push(&mut self, seen: Seen) {
        match (self, seen) {
            (Self::Values(values), Seen::Value(value)) => values.push(value),
            (Self::Events { hits, trials }, Seen::Event(happened)) => {
                *hits += u64::from(happened);
                *trials += 1;
            }
            (Self::Controlled { values, .. }, Seen::Controlled([value, control])) => {
                values.push(value, control);
            }
            _ => unreachable!("a tally is of the kind of its observable"),
        }
    }

    /// Whether the tally is possible for this number of values, and can be merged with another.
    pub(crate) fn is_of(&self, most: u64, other: &Self) -> bool {
        let count = match *self {
            Self::Values(values) => Some(values.count()),
            Self::Events { hits, trials } => (hits <= trials).then_some(trials),
            Self::Controlled { values, .. } => values.count(),
        };
        let is_kind = std::mem::discriminant(self) == std::mem::discriminant(other);
        is_kind && count.is_some_and(|count| count <= most)
    }

    pub(crate) fn estimate(&self) -> Result<Estimate, Error> {
        match *self {
            Self::Values(values) => values.estimate(),
            Self::Events { hits, trials } => Estimate::probability(hits, trials),
            Self::Controlled { values, expected } => values.estimate(expected),
        }
    }

    pub(crate) fn merge(&mut self, later: &Self) {
        match (self, later) {
            (Self::Values(a), Self::Values(b)) => a.merge(b),
            (Self::Events { hits, trials }, Self::Events { hits: h, trials: n }) => {
                *hits += h;
                *trials += n;
            }
            (Self::Controlled { values: a, .. }, Self::Controlled { values: b, .. }) => a.merge(b),
            _ => unreachable!("tallies of one observable are of one kind"),
        }
    }
}

impl Seen {
    pub(crate) fn of<const D: usize>(
        observable: &Observable<'_, D>,
        t: f64,
        x: &[f64; D],
    ) -> Result<Self, f64> {
        let finite = |value: f64| if value.is_finite() { Ok(value) } else { Err(value) };
        Ok(match observable {
            Observable::Mean(f) => Self::Value(finite(f(t, x))?),
            Observable::Probability(event) => Self::Event(event(t, x)),
            Observable::Controlled { value, control, .. } => {
                Self::Controlled([finite(value(t, x))?, finite(control(t, x))?])
            }
        })
    }

    /// Mean of an antithetic pair.
    pub(crate) fn pair(self, other: Self) -> Self {
        match (self, other) {
            (Self::Value(a), Self::Value(b)) => Self::Value(0.5 * (a + b)),
            (Self::Event(a), Self::Event(b)) => {
                Self::Value(0.5 * (f64::from(u8::from(a)) + f64::from(u8::from(b))))
            }
            (Self::Controlled(a), Self::Controlled(b)) => {
                Self::Controlled([0.5 * (a[0] + b[0]), 0.5 * (a[1] + b[1])])
            }
            _ => unreachable!("both are of the kind of their observable"),
        }
    }
}
