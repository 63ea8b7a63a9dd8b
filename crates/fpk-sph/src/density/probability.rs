//! A probability together with what it rests on.

use std::fmt;

/// A probability together with what it rests on, the worst last: the particles, an extrapolation, or nothing but a bound.
///
/// A lattice leaves some probability outside from the start ([`mass_outside`](crate::Simulation::mass_outside)). No particle
/// carries it, so a probability that is not larger is not known, whatever the estimate: [`Below`](Self::Below).
///
/// There is no way to the number but through its name:
///
/// ```
/// use fpk_sph::observables::Probability;
///
/// let read = |probability| match probability {
///     Probability::Resolved(p) => format!("{p:.1e}"),
///     Probability::Below { bound, .. } => format!("less than {bound:.1e}"),
///     other => format!("not enough particles: {other}"),
/// };
/// assert_eq!(read(Probability::Resolved(2e-3)), "2.0e-3");
/// assert_eq!(read(Probability::Below { estimate: 1e-7, bound: 4e-7 }), "less than 4.0e-7");
/// let far = Probability::Extrapolated { estimate: 2e-5, share: 0.76 };
/// assert_eq!(read(far), "not enough particles: 2.000e-5, 76 % lie beyond the outermost particles");
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
#[must_use]
pub enum Probability {
    /// Particles carry it.
    Resolved(f64),
    /// What the lattice left outside is a part of it, and may be missing.
    Truncated {
        /// The probability that particles carry.
        estimate: f64,
        /// What was left outside over the estimate, between 0 and 1.
        share: f64,
    },
    /// A part of it lies beyond the outermost particles' own cells, by extrapolation of their fits.
    Extrapolated {
        /// The probability with that part.
        estimate: f64,
        /// The part over the estimate, between 0 and 1.
        share: f64,
    },
    /// A part of it rests on cells that the estimator does not resolve.
    Unresolved {
        /// The probability with that part.
        estimate: f64,
        /// The part over the estimate, between 0 and 1.
        share: f64,
    },
    /// No more is known than an upper bound.
    Below {
        /// What the particles give; no larger than what the lattice left outside, and no estimate of the probability.
        estimate: f64,
        /// The sum of both.
        bound: f64,
    },
}

/// Most of a probability on unresolved cells. Seen with Bouc and Wen's hysteresis: below it the error of log10 P is within
/// 0.02; at 0.02 it is 0.13, and from 0.1 on it is 0.6 and more.
const NOTED_UNRESOLVED: f64 = 0.01;

/// Most of a probability beyond the outermost cells, or left outside. Seen with the damper: log10 P errs by less than 0.01
/// at 0.12, and by 0.16 at 0.18 and 0.76.
const NOTED_BEYOND: f64 = 0.1;

impl Probability {
    /// An estimate with what it rests on, given its parts and what the lattice left outside.
    pub(crate) fn of(estimate: f64, unresolved: f64, beyond: f64, outside: f64) -> Self {
        if estimate <= outside {
            return Self::Below { estimate, bound: estimate + outside };
        }
        let share = |part: f64| part / estimate;
        if share(unresolved) > NOTED_UNRESOLVED {
            Self::Unresolved { estimate, share: share(unresolved) }
        } else if share(beyond) > NOTED_BEYOND {
            Self::Extrapolated { estimate, share: share(beyond) }
        } else if share(outside) > NOTED_BEYOND {
            Self::Truncated { estimate, share: share(outside) }
        } else {
            Self::Resolved(estimate)
        }
    }

    /// The number where particles carry it.
    #[must_use]
    pub const fn resolved(self) -> Option<f64> {
        match self {
            Self::Resolved(p) => Some(p),
            _ => None,
        }
    }

    /// What it rests on, in words, as scenes note it.
    #[must_use]
    pub fn basis(&self) -> String {
        match self {
            Self::Resolved(_) => "carried by particles".to_owned(),
            Self::Truncated { share, .. } => {
                format!("up to {:.0} % more may lie outside the lattice", 100.0 * share)
            }
            Self::Extrapolated { share, .. } => {
                format!("{:.0} % lie beyond the outermost particles", 100.0 * share)
            }
            Self::Unresolved { share, .. } => {
                format!("{:.0} % rest on cells that are not resolved", 100.0 * share)
            }
            Self::Below { bound, .. } => {
                format!("known only to be below {bound:.1e}, since no particle carries as little")
            }
        }
    }
}

/// The number with what it rests on; a bound as `< 3.0e-7`.
impl fmt::Display for Probability {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Below { bound, .. } => write!(f, "< {bound:.1e}"),
            Self::Resolved(estimate) => write!(f, "{estimate:.3e}"),
            Self::Truncated { estimate, .. }
            | Self::Extrapolated { estimate, .. }
            | Self::Unresolved { estimate, .. } => write!(f, "{estimate:.3e}, {}", self.basis()),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::Probability::{self, Below, Extrapolated, Resolved, Truncated, Unresolved};

    #[test]
    fn the_worst_is_named() {
        let estimate = 1e-3;
        let of =
            |unresolved, beyond, outside| Probability::of(estimate, unresolved, beyond, outside);
        assert_eq!(of(0.0, 0.0, 0.0), Resolved(estimate));
        assert_eq!(of(0.9e-5, 0.9e-4, 0.9e-4), Resolved(estimate));
        assert_eq!(of(0.0, 0.0, 2e-4), Truncated { estimate, share: 0.2 });
        assert_eq!(of(0.0, 5e-4, 2e-4), Extrapolated { estimate, share: 0.5 });
        assert_eq!(of(5e-4, 5e-4, 2e-4), Unresolved { estimate, share: 0.5 });
        assert_eq!(of(5e-4, 5e-4, 1e-3), Below { estimate, bound: 2e-3 });
        assert_eq!(Probability::of(0.0, 0.0, 0.0, 3e-7), Below { estimate: 0.0, bound: 3e-7 });
    }

    #[test]
    fn a_bound_is_printed_as_a_bound_and_gives_no_number() {
        let bound = Probability::of(1.7e-7, 0.0, 0.0, 2.5e-7);
        assert_eq!(bound.to_string(), "< 4.2e-7");
        assert_eq!((bound.resolved(), Resolved(0.02).resolved()), (None, Some(0.02)));
        assert_eq!(
            Unresolved { estimate: 2e-3, share: 0.5 }.to_string(),
            "2.000e-3, 50 % rest on cells that are not resolved"
        );
    }
}
