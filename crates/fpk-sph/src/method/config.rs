//! Parameters of a simulation.

use crate::cloud::start::InitialLattice;
use crate::method::{Combination, Estimator, Method};
use crate::score::settling::Settling;

/// Parameters of a simulation besides the system and its initial distribution.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Config<const D: usize> {
    /// The combination of choices that carries the density.
    pub method: Method,
    /// The lattice on which the particles start.
    pub lattice: InitialLattice<D>,
    /// A time that is characteristic of the system: the natural period of an oscillator; for a process without one, the
    /// time in which the noise doubles the variance of the start. The step has collapsed below 1e-6 of it, and what the
    /// flow-map fit does not see is taken out within 0.3 of it.
    pub reference_period: f64,
    /// Most steps that a run may take.
    pub most_steps: u64,
}

impl<const D: usize> Config<D> {
    /// The same with both time constants of [`Settling`] doubled: for the part of the error that lattices do not show. `None`
    /// where the estimator does not settle: all but the flow-map fit.
    ///
    /// The rate of settling is no part of the problem. To first order in it, settling makes of a value `Q` on a lattice of
    /// the spacing `h` the error
    ///
    /// $$ e_s(h) = 2 |Q(h, \tau) - Q(h, 2 \tau)|, \qquad e_s(h / r) = e_s(h) / r^p $$
    ///
    /// where the spacing has the order `p`: the coarser of two lattices shows it at the lesser cost. In three and four
    /// states, on spacings of one standard deviation, it can be ten times what the two lattices differ by.
    #[must_use]
    pub fn with_slower_settling(&self) -> Option<Self> {
        let combination = self.method.combination_in(D);
        let Estimator::FlowMapFit { degree, thinnest, settling } = combination.estimator else {
            return None;
        };
        let settling = Settling { inside: 2.0 * settling.inside, outside: 2.0 * settling.outside };
        let estimator = Estimator::FlowMapFit { degree, thinnest, settling };
        Some(Self { method: Method::Custom(Combination { estimator, ..combination }), ..*self })
    }
}

/// Steps that a run may take where the caller sees no reason for another number: honest runs of the paper's method to
/// `t = 10` take about 5,000, the paper reports 11,000.
pub const DEFAULT_MOST_STEPS: u64 = 200_000;

/// The step has collapsed below this part of the reference period. Honest runs have been seen at 2e-5, collapsed ones
/// below 1e-7.
pub const COLLAPSED_STEP: f64 = 1e-6;

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn settling_is_half_as_fast_in_the_flow_map_fit_and_absent_elsewhere() {
        let config = |method| Config::<5> {
            method,
            lattice: InitialLattice::Ball { reach: 5.0, spacing: 1.0 },
            reference_period: 2.0,
            most_steps: DEFAULT_MOST_STEPS,
        };
        let slower = config(Method::FlowMapFit).with_slower_settling();
        let Some(Config { method: Method::Custom(slower), .. }) = slower else {
            unreachable!("{slower:?}")
        };
        let Estimator::FlowMapFit { settling, .. } = slower.estimator else {
            unreachable!("{slower:?}")
        };
        assert_eq!(settling, Settling { inside: 0.6, outside: 0.6 });
        // All else is as the method has it in five dimensions.
        let estimator = Method::FlowMapFit.combination_in(5).estimator;
        assert_eq!(
            Combination { estimator, ..slower },
            Method::FlowMapFit.combination_in(5),
            "settling alone"
        );
        assert_eq!(config(Method::CanorDenoel2013).with_slower_settling(), None);
    }
}
