//! What a probability rests on.

use std::fmt;

/// What a probability rests on, the worst first: the particles, an extrapolation, or nothing but a bound.
///
/// A lattice leaves some probability outside from the start ([`mass_outside`](crate::Simulation::mass_outside)). No particle
/// carries it, so a probability that is not larger is not known, whatever the number.
#[derive(Debug, Clone, Copy, PartialEq)]
#[must_use]
pub enum Support {
    /// No more is known than this upper bound: the estimate and what the lattice left outside, which is as large.
    Below {
        /// The upper bound.
        bound: f64,
    },
    /// This share of it rests on cells that the estimator does not resolve.
    Unresolved {
        /// Between 0 and 1.
        share: f64,
    },
    /// This share of it lies beyond the outermost particles' own cells, by extrapolation of their fits.
    Extrapolated {
        /// Between 0 and 1.
        share: f64,
    },
    /// What the lattice left outside is this share of it, and may be missing.
    Truncated {
        /// Between 0 and 1.
        share: f64,
    },
    /// On the particles.
    Resolved,
}

/// Most of a probability on unresolved cells. Seen with Bouc and Wen's hysteresis: below it the error of log10 P is within
/// 0.02; at 0.02 it is 0.13, and from 0.1 on it is 0.6 and more.
const NOTED_UNRESOLVED: f64 = 0.01;

/// Most of a probability beyond the outermost cells, or left outside. Seen with the damper: log10 P errs by less than 0.01
/// at 0.12, and by 0.16 at 0.18 and 0.76.
const NOTED_BEYOND: f64 = 0.1;

impl Support {
    /// What a probability rests on, given its parts and what the lattice left outside.
    pub(super) fn of(probability: f64, unresolved: f64, beyond: f64, outside: f64) -> Self {
        if probability <= outside {
            return Self::Below { bound: probability + outside };
        }
        let share = |part: f64| part / probability;
        if share(unresolved) > NOTED_UNRESOLVED {
            Self::Unresolved { share: share(unresolved) }
        } else if share(beyond) > NOTED_BEYOND {
            Self::Extrapolated { share: share(beyond) }
        } else if share(outside) > NOTED_BEYOND {
            Self::Truncated { share: share(outside) }
        } else {
            Self::Resolved
        }
    }
}

impl fmt::Display for Support {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Below { bound } => {
                write!(f, "known only to be below {bound:.1e}, since no particle carries as little")
            }
            Self::Unresolved { share } => {
                write!(f, "{:.0} % rest on cells that are not resolved", 100.0 * share)
            }
            Self::Extrapolated { share } => {
                write!(f, "{:.0} % lie beyond the outermost particles", 100.0 * share)
            }
            Self::Truncated { share } => {
                write!(f, "up to {:.0} % more may lie outside the lattice", 100.0 * share)
            }
            Self::Resolved => write!(f, "carried by particles"),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::Support;

    #[test]
    fn the_worst_is_named() {
        let of = |unresolved, beyond, outside| Support::of(1e-3, unresolved, beyond, outside);
        assert_eq!(of(0.0, 0.0, 0.0), Support::Resolved);
        assert_eq!(of(0.9e-5, 0.9e-4, 0.9e-4), Support::Resolved);
        assert_eq!(of(0.0, 0.0, 2e-4), Support::Truncated { share: 0.2 });
        assert_eq!(of(0.0, 5e-4, 2e-4), Support::Extrapolated { share: 0.5 });
        assert_eq!(of(5e-4, 5e-4, 2e-4), Support::Unresolved { share: 0.5 });
        assert_eq!(of(5e-4, 5e-4, 1e-3), Support::Below { bound: 2e-3 });
        assert_eq!(Support::of(0.0, 0.0, 0.0, 3e-7), Support::Below { bound: 3e-7 });
    }
}
