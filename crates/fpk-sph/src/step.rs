//! One step of the method.

use sde_integrators::Sde;

use crate::error::Error;
use crate::method::{Scheme, StepRule};
use crate::metric::{condition_number, mean_and_covariance};
use crate::report::StepReport;
use crate::score::Unresolved;
use crate::simulation::Simulation;
use crate::stage::check_finite;

/// Reference periods in which an estimator's [`settle`](crate::ScoreEstimator::settle) takes out all but `1/e` of what it
/// does not see. Measured on the damper: E[v^2] at t = 6 is 0.8 % high without, 0.02 % at 0.6, and the same within 0.1 %
/// from 0.3 to 1.3.
const SETTLING_PERIODS: f64 = 0.3;

/// The most probability that unresolved cells may hold. Runs whose claims hold were seen with up to 0.014: the damper at
/// t = 10, one cell at the centre of a cloud that has collapsed onto its slow manifold; Bouc-Wen with up to 4e-4.
pub const MOST_UNRESOLVED: f64 = 0.05;

/// Buffers of a Runge-Kutta step: positions of a stage, velocities of up to four stages, volumes of the first.
#[derive(Debug)]
pub(crate) struct Stages<const D: usize> {
    x: Vec<[f64; D]>,
    k: [Vec<[f64; D]>; 4],
    volume: Vec<f64>,
}

impl<S: Sde<D, M>, const D: usize, const M: usize> Simulation<S, D, M> {
    /// One step of the rule's own length.
    ///
    /// # Errors
    /// [`Error::StepCollapsed`], [`Error::StepExceedsDiffusionLimit`], [`Error::WorkLimit`], those of the metric and of
    /// the estimator, and of [`remap`](Self::remap); [`Error::TooMuchUnresolved`] above [`MOST_UNRESOLVED`];
    /// [`Error::LeftStableRange`] where a particle is no longer finite. The state is then that before the step, or that on
    /// the fresh lattice laid before it.
    pub fn step(&mut self) -> Result<StepReport, Error> {
        self.step_towards(f64::INFINITY)
    }

    /// One step, not beyond `end`: `dX/dt = v` (eq 14) by the method's scheme, then `h` by eq 20. Before it a
    /// fresh lattice, where the method has a [`Remapping`](crate::Remapping) and the cloud has become too uneven.
    ///
    /// # Errors
    /// As [`Self::step`]; [`Error::TimeInThePast`] unless `end` lies ahead.
    pub fn step_towards(&mut self, end: f64) -> Result<StepReport, Error> {
        let t = self.state.time;
        if end.is_nan() || end <= t {
            return Err(Error::TimeInThePast { value: end, now: t });
        }
        if self.state.n_steps >= self.most_steps {
            return Err(Error::WorkLimit { time: t, target: end, limit: self.most_steps });
        }
        let report = self.first_stage(end)?;
        self.later_stages(report.dt)?;

        if self.field.combination.scheme == Scheme::LeapFrog {
            self.state.remember(report.dt);
        }
        // What the estimator does not see would stay for ever: it is taken out at its own rate.
        let part = 1.0 - (-report.dt / (SETTLING_PERIODS * self.reference_period)).exp();
        let Stages { x, k: [before, ..], .. } = &mut self.stages;
        self.field.estimator.settle(x, before, part);
        check_finite(x, &[], (self.state.n_steps, report.time))?;
        self.state.positions.copy_from_slice(x);
        self.state.update_smoothing_lengths(&self.stages.volume);
        self.state.n_steps += 1;
        self.state.time = report.time;
        Ok(report)
    }

    /// `k_1 = v(t, x)`, on a fresh lattice where the cloud asks for one, and from it the step.
    fn first_stage(&mut self, end: f64) -> Result<StepReport, Error> {
        self.first_velocity()?;
        let mut remapped = None;
        if let Some(remapping) = self.field.combination.remapping
            && self.unevenness() > remapping.most_uneven
        {
            remapped = Some(self.lay_fresh_lattice(&remapping)?);
            self.first_velocity()?;
        }
        self.check_resolved()?;
        self.stages.volume.copy_from_slice(&self.stage.volume);
        Ok(StepReport { remapped, ..self.plan(end)? })
    }

    /// Refuses to go on where what is not resolved holds too much.
    fn check_resolved(&self) -> Result<(), Error> {
        let Unresolved { particles, mass, heaviest } = self.stage.unresolved;
        if mass <= MOST_UNRESOLVED {
            return Ok(());
        }
        let (step, time) = (self.state.n_steps, self.state.time);
        let (particle, limit) = (heaviest.unwrap_or(0), MOST_UNRESOLVED);
        Err(Error::TooMuchUnresolved { step, time, particle, particles, mass, limit })
    }

    /// `k_1 = v(t, x)`.
    fn first_velocity(&mut self) -> Result<(), Error> {
        let Self { field, state, stage, stages, .. } = self;
        stage.velocity(field, state, state.time, &state.positions, &mut stages.k[0])
    }

    /// `x(t + dt)` from `k_1`, in `stages.x`.
    fn later_stages(&mut self, dt: f64) -> Result<(), Error> {
        let Self { field, state, stage, stages: Stages { x, k: [k_1, k_2, k_3, k_4], .. }, .. } =
            self;
        let (t, x_0) = (state.time, &state.positions);
        match (field.combination.scheme, &state.previous) {
            (Scheme::ForwardEuler, _) => combine(x, x_0, &[(dt, k_1)]),
            (Scheme::LeapFrog, Some(previous)) => {
                let ratio = dt / previous.dt;
                combine(x, x_0, &[((1.0 + ratio) * dt, k_1)]);
                for ((x, x_0), before) in x.iter_mut().zip(x_0).zip(&previous.positions) {
                    for k in 0..D {
                        x[k] += ratio * ratio * (before[k] - x_0[k]);
                    }
                }
            }
            (Scheme::Heun | Scheme::LeapFrog, _) => {
                combine(x, x_0, &[(dt, k_1)]);
                stage.velocity(field, state, t + dt, x, k_2)?;
                combine(x, x_0, &[(dt / 2.0, k_1), (dt / 2.0, k_2)]);
            }
            (Scheme::RungeKutta4, _) => {
                combine(x, x_0, &[(dt / 2.0, k_1)]);
                stage.velocity(field, state, t + dt / 2.0, x, k_2)?;
                combine(x, x_0, &[(dt / 2.0, k_2)]);
                stage.velocity(field, state, t + dt / 2.0, x, k_3)?;
                combine(x, x_0, &[(dt, k_3)]);
                stage.velocity(field, state, t + dt, x, k_4)?;
                combine(
                    x,
                    x_0,
                    &[(dt / 6.0, k_1), (dt / 3.0, k_2), (dt / 3.0, k_3), (dt / 6.0, k_4)],
                );
            }
        }
        check_finite(x, &[], (state.n_steps, t + dt))
    }

    /// The length of the step by the rule and the limits, not beyond `end`, and the report of the step.
    fn plan(&self, end: f64) -> Result<StepReport, Error> {
        let Self { field, state, stage, stages, .. } = self;
        let (step, time, x) = (state.n_steps, state.time, &state.positions);
        let (fastest, courant_limit) = stage.courant_limit(&state.smoothing_lengths, &stages.k[0]);
        // The window may rise within the step: the limit holds at its begin and at its end.
        let limit_at = |t: f64| {
            let (particle, spread) = stage.fastest_spread(field, t, x);
            (particle, field.combination.scheme.diffusion_limit() / spread)
        };
        let ahead = |longest: f64| {
            let (now, then) = (limit_at(time), limit_at(time + longest));
            if then.1 < now.1 { then } else { now }
        };
        let (rule, particle, diffusion_limit) = match field.combination.step {
            StepRule::Courant { number } => (number * courant_limit, fastest, limit_at(time).1),
            StepRule::Fixed { dt } => {
                let (particle, limit) = ahead(dt);
                if dt > limit {
                    return Err(Error::StepExceedsDiffusionLimit {
                        step,
                        time,
                        dt,
                        particle,
                        limit,
                    });
                }
                (dt, particle, limit)
            }
            StepRule::DiffusionLimited { .. } | StepRule::PeriodFraction { .. } => {
                let (particle, limit) = ahead(self.longest_step);
                (limit.min(self.longest_step), particle, limit)
            }
        };
        if rule.is_nan() || rule < self.shortest_step {
            return Err(Error::StepCollapsed {
                step,
                time,
                dt: rule,
                particle,
                limit: self.shortest_step,
            });
        }
        let (dt, reached) = match field.combination.step {
            // The paper's rule as it stands: its own length until the end cuts it.
            StepRule::Courant { .. } if rule < end - time => (rule, time + rule),
            _ => land(time, rule, end),
        };
        let (_, covariance) = mean_and_covariance(x, &state.masses);
        Ok(StepReport {
            step: step + 1,
            time: reached,
            dt,
            diffusion_limit,
            courant_limit,
            neighbours_min: 1 + stage.neighbours_of(field).min_count(),
            neighbours_mean: stage.neighbours_mean(field),
            h_min: state.smoothing_lengths.iter().copied().fold(f64::INFINITY, f64::min),
            h_max: state.smoothing_lengths.iter().copied().fold(0.0, f64::max),
            covariance_condition: condition_number(&covariance),
            unresolved: stage.unresolved,
            fits: stage.fits,
            remapped: None,
        })
    }
}

impl<const D: usize> Stages<D> {
    pub(crate) fn new(n: usize) -> Self {
        Self {
            x: vec![[0.0; D]; n],
            k: std::array::from_fn(|_| vec![[0.0; D]; n]),
            volume: vec![0.0; n],
        }
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

/// `x = x_0 + sum_s c_s k_s`.
fn combine<const D: usize>(x: &mut [[f64; D]], x_0: &[[f64; D]], terms: &[(f64, &Vec<[f64; D]>)]) {
    for (i, point) in x.iter_mut().enumerate() {
        *point = x_0[i];
        for (c, k) in terms {
            for (value, rate) in point.iter_mut().zip(&k[i]) {
                *value += c * rate;
            }
        }
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
