//! A density scene by statistical linearisation.

use random_vibration::{GaussianLaw, Linearisation, Quadrature};
use scene_runs::answers::Unknown;
use scene_runs::clock::CpuClock;
use scene_runs::kind::RunError;
use sde_integrators::{Additive, Sde};

use super::observed::Observed;
use super::record::{Content, WorkRecord, asked_series};
use crate::paths::Paths;
use crate::scene::FpkScene;
use crate::system::{System, Visitor};

/// Solves a scene by statistical linearisation.
pub(super) struct Linearised<'a> {
    pub(super) scene: &'a FpkScene,
    pub(super) system: &'a System,
    /// Longest step.
    pub(super) step: f64,
}

/// `2^4 - 1`: the coarser run has twice the step, at order 4.
const RICHARDSON: f64 = 15.0;

/// A system that the check of the scene rejects.
#[derive(Debug, thiserror::Error)]
#[error("linearisation needs additive noise")]
struct NotAdditive;

impl Visitor for Linearised<'_> {
    type Output = Result<Content, RunError>;

    fn visit<S: Paths<D, M>, const D: usize, const M: usize>(self, system: &S) -> Self::Output {
        let system = system.additive().ok_or(NotAdditive).map_err(RunError::solver)?;
        self.linearised(system)
    }
}

impl Linearised<'_> {
    /// Compiled once for each dimension.
    fn linearised<const D: usize, const M: usize>(
        self,
        system: &dyn Sde<D, M, Noise = Additive>,
    ) -> Result<Content, RunError> {
        let Self { scene, system: named, step } = self;
        let (law, asked) = (scene.initial_law::<D>(named)?, scene.requested::<D>(named, false)?);
        let order = order(named.kinks());
        let laws = |step| {
            let rule = Linearisation { order, step };
            rule.laws(system, &law, &asked.times).map_err(RunError::solver)
        };
        let clock = CpuClock::start();
        let fine = laws(step)?;
        let work = WorkRecord { cpu_seconds: clock.seconds(), ..WorkRecord::default() };
        // A linear system keeps a normal distribution, so the only error is that of Runge-Kutta 4.
        let is_exact = named.is_linear() && law.components().len() == 1;
        let coarse = if is_exact { laws(2.0 * step)? } else { Vec::new() };
        let coarser = [(coarse, RICHARDSON)];
        let values = |pick: &dyn Fn(&GaussianLaw<D>) -> f64| {
            Observed::of_runs(&fine, &coarser, &|law| (law.t, pick(law)))
        };
        let weights = std::array::from_fn(|k| asked.demand.weights[k]);
        let moment = |k: usize| values(&|law| law.raw_moment(asked.powers[k]));
        let exceedance = |k: usize| {
            let values = values(&|law| law.exceedance(&weights, asked.thresholds[k])).into_iter();
            values
                .map(|observed| observed.without_zero_error("below the smallest number"))
                .collect()
        };
        let quantities = asked_series(scene, named, &moment, &exceedance);
        let unknown = (!is_exact).then(|| Unknown {
            what: "errors of all quantities".to_owned(),
            reason: "the distribution is approximated as normal, and no second run estimates that error: \
                     compare with `monte_carlo`"
                .to_owned(),
        });
        let unknown = unknown.into_iter().collect();
        Ok(Content { work, unknown, quantities, ..Content::default() })
    }
}

/// All states: first those with kinks, then those in which the drift is a polynomial.
pub(super) fn order<const D: usize>(kinks: &[(usize, Quadrature)]) -> [(usize, Quadrature); D] {
    let is_smooth = |k: &usize| kinks.iter().all(|(state, _)| state != k);
    let smooth = (0..D).filter(is_smooth).map(|k| (k, Quadrature::Hermite));
    let mut all = kinks.iter().copied().chain(smooth);
    std::array::from_fn(|k| all.next().unwrap_or((k, Quadrature::Hermite)))
}
