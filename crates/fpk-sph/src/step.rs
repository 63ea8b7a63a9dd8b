//! One step of the method.

use crate::error::Error;
use crate::extremes::{first_smallest, last_greatest};
use crate::method::remapping::Remapped;
use crate::scheme::Scheme;
use crate::score::Unresolved;
use crate::score::settling::Settling;
use crate::solver::Solver;
use crate::solver::evaluation::{Stage, check_finite};
use crate::solver::moment_balance::carried;
use crate::solver::report::StepReport;
use crate::solver::step_length::StepLength;
use crate::system::coefficients::Coefficients;
use crate::time::Begin;

/// The most probability that unresolved cells may hold. Runs whose claims hold were seen with up to 0.014: the damper at
/// t = 10, one cell at the centre of a cloud that has collapsed onto its slow manifold; Bouc-Wen with up to 4e-4.
pub const MOST_UNRESOLVED: f64 = 0.05;

/// Whether to go on, asked before a step with the present time.
pub(crate) type GoesOn<'a> = &'a mut (dyn FnMut(f64) -> bool + Send);

impl<const D: usize> Solver<D> {
    /// One step, not beyond `end`, of `dX/dt = v` (Canor & Denoël 2013, eq 14), then `h` (eq 20):
    ///
    /// $$ v = f - \nabla\cdot D - D \nabla\log\psi, \qquad
    /// h_i = h_{0i} \left( \frac{V_i}{V_{0i}} \right)^{1/D}, \qquad \frac{d\mu_i}{dt} = 0 . $$
    ///
    /// The limits of `dt` are those of the first stage; `h` is that of [`Smoothing`](crate::time::smoothing::Smoothing).
    pub(crate) fn step_towards(
        &mut self,
        system: &dyn Coefficients<D>,
        end: f64,
    ) -> Result<StepReport, Error> {
        self.observed_step(system, end, |solver, length, remapped| StepReport {
            remapped,
            ..solver.report(length)
        })
    }

    /// Steps to the given time, while `goes_on` returns true at the present one.
    pub(crate) fn advance_while(
        &mut self,
        system: &dyn Coefficients<D>,
        time: f64,
        goes_on: GoesOn<'_>,
    ) -> Result<(), Error> {
        self.check_not_past(time)?;
        while self.state.time < time && goes_on(self.state.time) {
            self.observed_step(system, time, |_, _, _| ())?;
        }
        Ok(())
    }

    /// One step, not beyond `end`, and what `observe` makes of its first stage, its length and the remeshing before it.
    pub(crate) fn observed_step<R>(
        &mut self,
        system: &dyn Coefficients<D>,
        end: f64,
        observe: impl FnOnce(&Self, &StepLength, Option<Remapped>) -> R,
    ) -> Result<R, Error> {
        self.check_end(end)?;
        let remapped = self.first_stage(system)?;
        let length = self.step_length(system, end)?;
        let observed = observe(self, &length, remapped);
        let (dt, t_1) = (length.dt, length.reached);

        let Self { discretisation, state, balance, evaluation, stages, smoothing, .. } = self;
        balance.step(system, state, &stages.k[0], dt);
        let scheme = discretisation.combination.scheme;
        let t_0 = state.time;
        let begin = Begin {
            t: t_0,
            x: &state.positions,
            previous: state.previous.as_ref(),
            linear: system.linear_part().unwrap_or([[0.0; D]; D]),
            dt,
        };
        stages.advance(scheme, &begin, |t, x, v| {
            let stage = Stage { t, x, smoothing_lengths: &smoothing.lengths };
            evaluation.velocity(system, discretisation, state, stage, v)
        })?;
        check_finite(&stages.x, &[], (state.n_steps, t_0 + dt))?;
        // What the estimator does not see would stay for ever: it is taken out at its own rate.
        let part = Settling::part_of_a_step(dt, self.reference_period);
        let [first, .., scratch] = &mut stages.k;
        let before = carried(&stages.x, &state.masses);
        discretisation.estimator.settle(&mut stages.x, scratch, part);
        balance.moved(&before, &stages.x, &state.masses);
        check_finite(&stages.x, &[], (state.n_steps, t_1))?;

        if scheme == Scheme::LawsonAdamsBashforth2 {
            state.remember_rates(first, dt);
        }
        state.positions.copy_from_slice(&stages.x);
        smoothing.finish(state);
        state.n_steps += 1;
        state.time = t_1;
        Ok(observed)
    }

    /// Refuses an end that does not lie ahead, and a step beyond the limit of the work.
    pub(crate) fn check_end(&self, end: f64) -> Result<(), Error> {
        let t = self.state.time;
        if end.is_nan() || end <= t {
            return Err(Error::TimeInThePast { value: end, now: t });
        }
        if self.state.n_steps >= self.most_steps {
            return Err(Error::WorkLimit { time: t, target: end, limit: self.most_steps });
        }
        Ok(())
    }

    /// `k_1 = v(t, x)` and the smoothing lengths that follow from it, after remapping a cloud that has become too uneven.
    fn first_stage(&mut self, system: &dyn Coefficients<D>) -> Result<Option<Remapped>, Error> {
        self.first_velocity(system)?;
        let mut remapped = None;
        if let Some(remapping) = self.discretisation.combination.remapping
            && self.unevenness() > remapping.most_uneven
        {
            remapped = Some(self.remap_evaluated(&remapping)?);
            self.first_velocity(system)?;
        }
        self.check_resolved()?;
        let Self { discretisation, state, evaluation, smoothing, .. } = self;
        if discretisation.estimator.criterion().is_none() {
            smoothing.start_on_lattice(state, &evaluation.estimates.volume);
        } else {
            smoothing.start(state, &evaluation.estimates.volume);
        }
        Ok(remapped)
    }

    /// `k_1 = v(t, x)`.
    fn first_velocity(&mut self, system: &dyn Coefficients<D>) -> Result<(), Error> {
        let Self { discretisation, state, evaluation, stages, .. } = self;
        evaluation.velocity(system, discretisation, state, state.stage(), &mut stages.k[0])
    }

    /// Refuses a step where unresolved particles hold too much probability.
    pub(crate) fn check_resolved(&self) -> Result<(), Error> {
        let Unresolved { particles, mass, heaviest } = self.evaluation.estimates.unresolved;
        if mass <= MOST_UNRESOLVED {
            return Ok(());
        }
        let (step, time) = (self.state.n_steps, self.state.time);
        let (particle, limit) = (heaviest.unwrap_or(0), MOST_UNRESOLVED);
        Err(Error::TooMuchUnresolved { step, time, particle, particles, mass, limit })
    }

    /// The report of a step of the given length, from its first stage.
    pub(crate) fn report(&self, length: &StepLength) -> StepReport {
        let Self { discretisation, state, evaluation, stages, .. } = self;
        let h = &state.smoothing_lengths;
        let lengths =
            |first: usize, out: &mut [f64]| out.copy_from_slice(&h[first..first + out.len()]);
        StepReport {
            step: state.n_steps + 1,
            time: length.reached,
            dt: length.dt,
            diffusion_limit: length.diffusion_limit,
            courant_limit: evaluation.courant_limit(h, &stages.k[0]).1,
            neighbours_min: 1 + evaluation.cloud.neighbours(discretisation).min_count(),
            neighbours_mean: evaluation.cloud.neighbours_mean(discretisation),
            h_min: first_smallest(h.len(), lengths).1,
            h_max: last_greatest(h.len(), lengths).1,
            unresolved: evaluation.estimates.unresolved,
            fits: evaluation.estimates.fits,
            remapped: None,
        }
    }
}
