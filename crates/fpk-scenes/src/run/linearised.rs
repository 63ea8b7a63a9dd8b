//! A density scene by statistical linearisation.

use random_vibration::{GaussianLaw, Linearisation, Quadrature};
use scene_runs::answers::Unknown;
use scene_runs::clock::CpuClock;
use scene_runs::kind::{Run, RunError};
use sde_integrators::{Additive, Sde};

use super::observed::{Observed, Refinement};
use super::record::{Content, WorkRecord, asked_series};
use super::resolution_error::{Orders, StepsOfInterval};
use crate::paths::Paths;
use crate::scene::FpkScene;
use crate::system::{System, Visitor};

/// Solves a scene by statistical linearisation.
pub(super) struct Linearised<'a> {
    pub(super) scene: &'a FpkScene,
    pub(super) system: &'a System,
    pub(super) run: &'a Run<'a>,
    /// Longest step.
    pub(super) step: f64,
}

/// Orders of Runge-Kutta 4, and the ratio of the steps of the coarser runs: steps that are halved next to a state that is known are never
/// those of another run.
const ORDERS: Orders = Orders { of_method: 4.0, largest: 4.0 };
const RATIO: f64 = 1.5;
/// Steps of an interval between observations with which there are two coarser runs.
const FEWEST_STEPS: f64 = 4.0;

/// Steps of the shortest period of a linear system, at the least: the coarser runs then converge, with twice that step too.
const STEPS_OF_PERIOD: f64 = 24.0;

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
        let Self { scene, system: named, run, step } = self;
        let (law, asked) = (scene.initial_law::<D>(named)?, scene.requested::<D>(named, false)?);
        let order = order(named.kinks());
        // Steps end at kinks of a modulating function, across which they would lose their order.
        let until = asked.times.last().copied().unwrap_or_default();
        let kinks = scene.system.kinks().into_iter().filter(|&t| t > 0.0 && t < until);
        let mut stops: Vec<f64> = kinks.chain(asked.times.iter().copied()).collect();
        stops.sort_by(f64::total_cmp);
        stops.dedup();
        let laws = |step| -> Result<Vec<GaussianLaw<D>>, RunError> {
            let pace = run.pace("statistical linearisation");
            let rule = Linearisation { order, step };
            let mut goes_on = |t: f64| pace.goes_on(t / until);
            let laws = rule.laws_while(system, &law, &stops, &mut goes_on);
            let laws = laws.map_err(RunError::solver)?;
            RunError::if_ended_early(&pace)?;
            let is_asked = |law: &GaussianLaw<D>| asked.times.contains(&law.t);
            Ok(laws.into_iter().filter(is_asked).collect::<Vec<_>>())
        };
        let clock = CpuClock::start();
        // A linear system keeps a normal distribution, so the only error is that of Runge-Kutta 4.
        let is_exact = named.is_linear() && law.components().len() == 1;
        let every = scene.times.every;
        let shortest = named.reference_period() / STEPS_OF_PERIOD;
        let steps = StepsOfInterval::new((every / step.min(shortest)).max(FEWEST_STEPS), RATIO);
        // Of an interval, and not below it by roundoff.
        let length = |n: u32| every / f64::from(n) * (1.0 + 1e-9);
        let fine = laws(if is_exact { length(steps.fine) } else { step })?;
        let work = WorkRecord { cpu_seconds: clock.seconds(), ..WorkRecord::default() };
        let refinements = if is_exact {
            let (ratio, next) = steps.ratios();
            // A coarse run that fails leaves the error unknown, and not the answer.
            let of = |n: u32| laws(length(n)).unwrap_or_default();
            let coarsest = steps.coarsest.zip(next).map(|(n, next)| (of(n), next));
            vec![Refinement { coarse: (of(steps.coarse), ratio), coarsest, orders: ORDERS }]
        } else {
            Vec::new()
        };
        let values = |pick: &dyn Fn(&GaussianLaw<D>) -> f64| {
            Observed::of_runs(&fine, &refinements, &|law| (law.t, pick(law)))
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
