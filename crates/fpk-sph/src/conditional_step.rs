//! A step of the density of a structure whose filter states are conditioned out.

use particle_store::{Attribute, ParticleStore};

use crate::error::Error;
use crate::method::remapping::Remapped;
use crate::parallel::for_each_block;
use crate::remap::rim_extrapolation::RimExtrapolation;
use crate::remap::{Carried, CarriedOn};
use crate::scheme::Scheme;
use crate::score::WAVE_DAMPING;
use crate::score::settling::Settling;
use crate::solver::Solver;
use crate::solver::discretisation::Discretisation;
use crate::solver::evaluation::{Evaluation, Stage, check_finite};
use crate::solver::report::StepReport;
use crate::system::coefficients::Coefficients;
use crate::system::linear_filter::{FilterMoments, LinearFilter};
use crate::time::Begin;
use crate::time::state::State;
use vibrating_systems::matrix::{Matrix, scaled};

/// What is carried besides the density of the structure, and the buffers of a step.
#[derive(Debug)]
pub(crate) struct Conditional<const D: usize> {
    pub(crate) filter: LinearFilter,
    pub(crate) moments: FilterMoments,
    rim: RimExtrapolation,
    /// Moments at a stage, and their rates at all.
    stage: FilterMoments,
    rates: [FilterMoments; 4],
    /// `g . grad log rho` at every particle.
    along: Vec<f64>,
    /// Scores of zero, with which the velocity is the drift.
    no_score: Vec<[f64; D]>,
    noise: Vec<[f64; D]>,
    /// `c C c` at the last stage.
    variance: f64,
}

impl<const D: usize> Conditional<D> {
    pub(crate) fn new(filter: LinearFilter, moments: FilterMoments, rim: RimExtrapolation) -> Self {
        let (n_states, n) = (filter.n_states, moments.means.len() / filter.n_states);
        let zeros = || FilterMoments::zeros(n, n_states);
        Self {
            filter,
            moments,
            rim,
            stage: zeros(),
            rates: std::array::from_fn(|_| zeros()),
            along: vec![0.0; n],
            no_score: vec![[0.0; D]; n],
            noise: Vec::with_capacity(1),
            variance: 0.0,
        }
    }

    /// Takes the moments of particles on another lattice.
    pub(crate) fn start_on(&mut self, moments: FilterMoments, rim: RimExtrapolation) {
        *self = Self::new(self.filter.clone(), moments, rim);
    }

    /// Velocities `a + g u` with `u = c . m`, and the rates of the moments, at stage `k` of a step, `elapsed` after its start.
    fn stage(
        &mut self,
        (k, elapsed): (usize, f64),
        system: &dyn Coefficients<D>,
        (evaluation, discretisation, state): (&mut Evaluation<D>, &Discretisation<D>, &State<D>),
        at: Stage<'_, D>,
        v: &mut [[f64; D]],
    ) -> Result<(), Error> {
        let Stage { t, x, .. } = at;
        match k.checked_sub(1) {
            Some(before) => self.stage.combine(&self.moments, [(elapsed, &self.rates[before])]),
            None => self.stage.clone_from(&self.moments),
        }
        evaluation.estimate(discretisation, state, at)?;
        let (with_output, variance) = self.filter.conditional(&self.stage, &state.masses, t)?;
        self.variance = variance;
        let no_score = &self.no_score;
        for_each_block(v, &|first, v| {
            let here = first..first + v.len();
            system.velocity(t, &x[here.clone()], &no_score[here], v);
        });
        // Additive noise: one column for all.
        system.noise(t, &x[..1], &mut self.noise);
        let Some(&g) = self.noise.first() else { return Ok(()) };
        let (whitening, n) = (&evaluation.cloud.whitening, self.filter.n_states);
        let means = self.stage.means.chunks_exact(n);
        for (i, (v, m)) in v.iter_mut().zip(means).enumerate() {
            let score = whitening.unwhiten_gradient(&evaluation.estimates.score[i]);
            let u = self.filter.output(m);
            self.along[i] = g.iter().zip(&score).map(|(g, s)| g * s).sum();
            for (v, g) in v.iter_mut().zip(&g) {
                *v += g * u;
            }
        }
        let input = (&with_output, &self.along[..]);
        self.filter.rates(t, &self.stage, input, &mut self.rates[k]);
        Ok(())
    }

    /// Adds the means of all particles and the covariance to a store.
    pub(crate) fn save(&self, store: &mut ParticleStore<D>) -> Result<(), Error> {
        let n = self.filter.n_states;
        for k in 0..n {
            let column: Vec<f64> = self.moments.means.chunks_exact(n).map(|m| m[k]).collect();
            store.add(&mean_name(k), column)?;
            for l in 0..n {
                let value = Attribute::Real(self.moments.covariance[k][l]);
                store.set_attribute(&covariance_name(k, l), value);
            }
        }
        Ok(())
    }

    /// The moments in a store.
    pub(crate) fn read(&self, store: &ParticleStore<D>) -> Result<FilterMoments, Error> {
        let (n, n_particles) = (self.filter.n_states, store.len());
        let mut moments = FilterMoments::zeros(n_particles, n);
        let check = |quantity, particle, value: f64| {
            let error = Error::SnapshotNumber { quantity, particle, value, must: "finite" };
            if value.is_finite() { Ok(value) } else { Err(error) }
        };
        for k in 0..n {
            let column = store.get(store.handle::<f64>(&mean_name(k))?)?;
            for (i, &value) in column.iter().enumerate() {
                moments.means[i * n + k] = check("mean of the filter", i, value)?;
            }
            for l in 0..n {
                let Some(Attribute::Real(value)) = store.attribute(&covariance_name(k, l)) else {
                    return Err(Error::SnapshotWithoutTime);
                };
                moments.covariance[k][l] = check("covariance of the filter", 0, value)?;
            }
        }
        Ok(moments)
    }
}

fn mean_name(state: usize) -> String {
    format!("filter_mean_{state}")
}

fn covariance_name(row: usize, column: usize) -> String {
    format!("filter_covariance_{row}_{column}")
}

impl<const D: usize> Solver<D> {
    /// One step, not beyond `end`, of the positions of the structure's particles, of the filter's means that they carry and of
    /// the filter's covariance, by Runge-Kutta 4:
    ///
    /// $$ \frac{dX}{dt} = a + g\, c \cdot m, \qquad \frac{dm}{dt} = A m - C c\, (g \cdot \nabla\log\rho), \qquad
    ///    \frac{dP}{dt} = A P + P A^T + w^2 b b^T, \qquad C = P - \mathrm{Cov}(m) . $$
    ///
    /// Before it the cloud is remeshed, where the method has a [`Remapping`](crate::Remapping) and the cloud is too uneven. After
    /// the step the means at the rim are extrapolated from the inside: one-sided gradients let waves grow there.
    pub(crate) fn conditional_step(
        &mut self,
        conditional: &mut Conditional<D>,
        system: &dyn Coefficients<D>,
        end: f64,
    ) -> Result<StepReport, Error> {
        self.check_end(end)?;
        let Self { discretisation, state, evaluation, stages, .. } = self;
        let of_state = (&mut *evaluation, &*discretisation, &*state);
        conditional.stage((0, 0.0), system, of_state, state.stage(), &mut stages.k[0])?;
        let remapped = self.remap_conditional(conditional)?;
        let Self { discretisation, state, evaluation, stages, smoothing, .. } = self;
        if remapped.is_some() {
            let of_state = (&mut *evaluation, &*discretisation, &*state);
            conditional.stage((0, 0.0), system, of_state, state.stage(), &mut stages.k[0])?;
        }
        smoothing.start_on_lattice(state, &evaluation.estimates.volume);
        self.check_resolved()?;
        let limit = self.wave_limit(conditional, system);
        let length = self.length_within(limit, end)?;
        let report = StepReport { remapped, ..self.report(&length) };
        let (dt, t_1) = (length.dt, length.reached);
        let Self { discretisation, state, evaluation, stages, smoothing, .. } = self;
        let t_0 = state.time;
        let begin =
            Begin { t: t_0, x: &state.positions, previous: None, linear: [[0.0; D]; D], dt };
        let mut k = 0;
        stages.runge_kutta_4(&begin, |t, x, v| {
            k += 1;
            let stage = Stage { t, x, smoothing_lengths: &smoothing.lengths };
            let of_state = (&mut *evaluation, &*discretisation, &*state);
            // Each stage of this scheme starts from the rates of the one before alone.
            conditional.stage((k, t - t_0), system, of_state, stage, v)
        })?;
        let [k_1, k_2, k_3, k_4] = &conditional.rates;
        let (sixth, third) = (dt / 6.0, dt / 3.0);
        let terms = [(sixth, k_1), (third, k_2), (third, k_3), (sixth, k_4)];
        conditional.stage.combine(&conditional.moments, terms);
        conditional.rim.apply(&mut conditional.stage.means, conditional.filter.n_states);
        check_finite(&stages.x, &[], (state.n_steps, t_1))?;
        let part = Settling::part_of_a_step(dt, self.reference_period);
        let [scratch, ..] = &mut stages.k;
        discretisation.estimator.settle(&mut stages.x, scratch, part);
        check_finite(&stages.x, &[], (state.n_steps, t_1))?;
        check_means(&conditional.stage, conditional.filter.n_states, (state.n_steps, t_1))?;
        std::mem::swap(&mut conditional.moments, &mut conditional.stage);
        state.positions.copy_from_slice(&stages.x);
        smoothing.finish(state);
        state.n_steps += 1;
        state.time = t_1;
        Ok(report)
    }

    /// Remaps a cloud that has become too uneven, with the means that its particles carry, from the evaluation of the present state.
    fn remap_conditional(
        &mut self,
        conditional: &mut Conditional<D>,
    ) -> Result<Option<Remapped>, Error> {
        let Some(remapping) = self.discretisation.combination.remapping else { return Ok(None) };
        if self.unevenness() <= remapping.most_uneven {
            return Ok(None);
        }
        let (time, limit) = (self.state.time, remapping.most_change);
        let Conditional { filter, moments, .. } = &*conditional;
        let before = filter.explained_variance(&moments.means, &self.state.masses);
        let whole = filter.variance(moments);
        let check = |means: &[f64], masses: &[f64]| {
            let value = (filter.explained_variance(means, masses) - before) / whole;
            let quantity = "explained variance of the filter's output";
            let is_small = value.abs() <= limit;
            let error = Error::RemappingChangesMass { time, quantity, value, limit };
            if is_small { Ok(()) } else { Err(error) }
        };
        let carried = Carried { values: &moments.means, n: filter.n_states };
        let (remapped, CarriedOn { values, rim }) = self.remap_with(&remapping, &carried, check)?;
        let covariance = moments.covariance;
        conditional.start_on(FilterMoments { means: values, covariance }, rim);
        Ok(Some(remapped))
    }

    /// The particle with the fastest waves and the largest step in which they and the filter are stable, from the first stage:
    ///
    /// $$ \Delta t \left( k \sqrt{c^T C c\, g_y^T g_y} + \lVert A \rVert \right) \le 2.6, $$
    ///
    /// where `k` is the steepest that the gradient makes of a wave on the lattice. Waves of the density and of the filter's
    /// output make up an oscillator that the filter damps; the half disc of radius 2.6 lies within the region of stability of
    /// Runge-Kutta 4.
    fn wave_limit(
        &mut self,
        conditional: &Conditional<D>,
        system: &dyn Coefficients<D>,
    ) -> (usize, f64) {
        let Self { discretisation, evaluation, state, longest_step, .. } = self;
        let waves = Waves { system, variance: conditional.variance.abs() };
        let times = [state.time, state.time + *longest_step];
        let (particle, square) = evaluation.fastest_spread(&waves, discretisation, times, state);
        let radius = Scheme::RungeKutta4.diffusion_limit() * WAVE_DAMPING;
        (particle, radius / ((WAVE_DAMPING * square).sqrt() + conditional.filter.fastest))
    }
}

/// Refuses a mean that is not finite.
fn check_means(moments: &FilterMoments, n: usize, (step, time): (u64, f64)) -> Result<(), Error> {
    let Some(i) = moments.means.iter().position(|value| !value.is_finite()) else { return Ok(()) };
    let (particle, quantity, value) = (i / n, "mean of the filter", moments.means[i]);
    Err(Error::LeftStableRange { step, time, particle, quantity, value })
}

/// `c C c g g^T` in place of the diffusion matrix: the square of the speed of waves.
struct Waves<'a, const D: usize> {
    system: &'a dyn Coefficients<D>,
    variance: f64,
}

impl<const D: usize> Coefficients<D> for Waves<'_, D> {
    fn velocity(&self, t: f64, x: &[[f64; D]], score: &[[f64; D]], v: &mut [[f64; D]]) {
        self.system.velocity(t, x, score, v);
    }

    fn drift(&self, t: f64, x: &[[f64; D]], drift: &mut Vec<[f64; D]>) {
        self.system.drift(t, x, drift);
    }

    fn diffusion(&self, t: f64, x: &[[f64; D]], diffusion: &mut Vec<[[f64; D]; D]>) {
        self.system.diffusion(t, x, diffusion);
        for matrix in diffusion {
            // The structure's own is half of g g^T.
            *matrix = scaled(matrix, 2.0 * self.variance);
        }
    }

    fn noise(&self, t: f64, x: &[[f64; D]], columns: &mut Vec<[f64; D]>) {
        self.system.noise(t, x, columns);
    }

    fn linear_part(&self) -> Option<Matrix<D>> {
        self.system.linear_part()
    }
}
