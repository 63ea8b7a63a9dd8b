//! The length of a step, by the rule and the limits of the method.

use crate::error::Error;
use crate::method::StepRule;
use crate::solver::Solver;
use crate::system::coefficients::Coefficients;

/// The length of a step with the limits that it keeps.
#[derive(Debug, Clone, Copy)]
pub(crate) struct StepLength {
    pub(crate) dt: f64,
    /// Time after the step.
    pub(crate) reached: f64,
    pub(crate) diffusion_limit: f64,
}

impl<const D: usize> Solver<D> {
    /// `dt` by the rule and the limits, not beyond `end`, from the first stage of the step.
    pub(crate) fn step_length(
        &mut self,
        system: &dyn Coefficients<D>,
        end: f64,
    ) -> Result<StepLength, Error> {
        let limit = self.diffusion_limit(system);
        self.length_within(limit, end)
    }

    /// `dt` by the rule, not beyond `end`, within a limit of stability, which comes with the particle that sets it.
    pub(crate) fn length_within(
        &self,
        (spreading, diffusion_limit): (usize, f64),
        end: f64,
    ) -> Result<StepLength, Error> {
        let (step, time, rule) =
            (self.state.n_steps, self.state.time, self.discretisation.combination.step);
        let (asked, particle) = match rule {
            StepRule::Courant { number } => {
                let h = &self.state.smoothing_lengths;
                let (fastest, limit) = self.evaluation.courant_limit(h, &self.stages.k[0]);
                (number * limit, fastest)
            }
            StepRule::Fixed { dt } if dt > diffusion_limit => {
                let (particle, limit) = (spreading, diffusion_limit);
                return Err(Error::StepExceedsDiffusionLimit { step, time, dt, particle, limit });
            }
            StepRule::Fixed { dt } => (dt, spreading),
            StepRule::DiffusionLimited { .. } | StepRule::PeriodFraction { .. } => {
                (diffusion_limit.min(self.longest_step), spreading)
            }
        };
        let limit = self.shortest_step;
        if asked.is_nan() || asked < limit {
            return Err(Error::StepCollapsed { step, time, dt: asked, particle, limit });
        }
        let (dt, reached) = match rule {
            // The paper's rule, unchanged: its own length until the end cuts it.
            StepRule::Courant { .. } if asked < end - time => (asked, time + asked),
            _ => land(time, asked, end),
        };
        Ok(StepLength { dt, reached, diffusion_limit })
    }

    /// The particle that spreads fastest and the largest step by the diffusion limit, which holds at the begin of the step
    /// and at the end of the longest one: the window may rise within it.
    fn diffusion_limit(&mut self, system: &dyn Coefficients<D>) -> (usize, f64) {
        let Self { discretisation, evaluation, state, longest_step, .. } = self;
        let now = state.time;
        let then = match discretisation.combination.step {
            StepRule::Courant { .. } => now,
            _ => now + *longest_step,
        };
        let (particle, spread) =
            evaluation.fastest_spread(system, discretisation, [now, then], state);
        (particle, discretisation.combination.scheme.diffusion_limit() / spread)
    }
}

/// The step that starts at `time` with at most `rule` and lands on `end`, and the time that it reaches. The remainder
/// is taken in equal steps, so that no sliver is left.
fn land(time: f64, rule: f64, end: f64) -> (f64, f64) {
    let remainder = end - time;
    if remainder.is_infinite() {
        return (rule, time + rule);
    }
    // Steps as equal as the rule allows; the slack absorbs roundoff of times that add up.
    let n_steps = (remainder / rule - 1e-9).ceil().max(1.0);
    if n_steps <= 1.0 {
        (remainder, end)
    } else {
        (remainder / n_steps, time + remainder / n_steps)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn steps_land_on_the_end_without_a_sliver() {
        let (mut time, mut n) = (0.0, 0);
        while time < 1.0 {
            let (dt, reached) = land(time, 0.3, 1.0);
            assert!((dt - 0.25).abs() < 1e-15);
            (time, n) = (reached, n + 1);
        }
        assert!(n == 4 && (time - 1.0_f64).abs() < f64::MIN_POSITIVE);
    }

    #[test]
    fn times_that_add_up_with_roundoff_do_not_cost_a_step() {
        let time = (0..9).fold(0.0, |t, _| t + 0.1);
        let (dt, reached) = land(time, 0.1, 1.0);
        assert!((dt - 0.1).abs() < 1e-15 && (reached - 1.0).abs() < f64::MIN_POSITIVE);
    }
}
