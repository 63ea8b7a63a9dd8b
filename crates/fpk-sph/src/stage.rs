//! One evaluation of the velocity: metric, neighbours, score. The buffers live here and are reused.

use neighbour_search::{CellGrid, NeighbourList, NeighbourSearch, Radii};
use sde_integrators::{NoiseClass, Sde};

use crate::cloud::Cloud;
use crate::error::Error;
use crate::lattice::ParticleLattice;
use crate::method::Combination;
use crate::metric::{Metric, Whitening};
use crate::parallel::fill;
use crate::report::Work;
use crate::score::{Estimates, Fits, LatticePlaces, ScoreEstimator, Unresolved};
use crate::simulation::State;

/// What makes the velocity field: the system, the choices of the method, and the lattice, which changes when a fresh one
/// is laid.
#[derive(Debug)]
pub(crate) struct Field<S, const D: usize> {
    pub(crate) system: S,
    pub(crate) estimator: Box<dyn ScoreEstimator<D> + Sync>,
    pub(crate) combination: Combination,
    pub(crate) lattice: ParticleLattice<D>,
}

impl<S, const D: usize> Field<S, D> {
    /// Takes a lattice and tells the estimator of it; gives back the one before. After an error all is as it was.
    pub(crate) fn lay(
        &mut self,
        mut lattice: ParticleLattice<D>,
    ) -> Result<ParticleLattice<D>, Error> {
        let reach = self.combination.support_over_spacing;
        if self.estimator.criterion().is_none() {
            lattice.find_neighbours(reach)?;
        }
        self.estimator.start(&LatticePlaces {
            places: &lattice.places,
            neighbours: &lattice.neighbours,
            reach,
            spacing: lattice.spacing,
        })?;
        Ok(std::mem::replace(&mut self.lattice, lattice))
    }
}

/// What one evaluation leaves behind, in the coordinates of the metric.
#[derive(Debug)]
pub(crate) struct Stage<const D: usize> {
    pub(crate) whitening: Whitening<D>,
    pub(crate) whitened: Vec<[f64; D]>,
    pub(crate) radii: Vec<f64>,
    grid: CellGrid<D>,
    pub(crate) neighbours: NeighbourList,
    pub(crate) score: Vec<[f64; D]>,
    pub(crate) density: Vec<f64>,
    pub(crate) volume: Vec<f64>,
    pub(crate) deformation: Vec<[[f64; D]; D]>,
    pub(crate) unresolved: Unresolved,
    pub(crate) fits: Fits,
    pub(crate) work: Work,
}

impl<const D: usize> Stage<D> {
    pub(crate) fn new(n: usize) -> Self {
        Self {
            whitening: Whitening::identity(),
            whitened: vec![[0.0; D]; n],
            radii: vec![0.0; n],
            grid: CellGrid::new(),
            neighbours: NeighbourList::new(),
            score: vec![[0.0; D]; n],
            density: vec![0.0; n],
            volume: vec![0.0; n],
            deformation: vec![[[0.0; D]; D]; n],
            unresolved: Unresolved::default(),
            fits: Fits::default(),
            work: Work::default(),
        }
    }

    /// Whitens the positions and finds who is near whom.
    pub(crate) fn find_neighbours<S>(
        &mut self,
        field: &Field<S, D>,
        state: &State<D>,
        t: f64,
        x: &[[f64; D]],
    ) -> Result<(), Error> {
        let at = (state.n_steps, t);
        self.whitening = Whitening::of(field.combination.metric, x, &state.masses, at)?;
        let support = field.estimator.support();
        for (i, (y, radius)) in self.whitened.iter_mut().zip(&mut self.radii).enumerate() {
            *y = self.whitening.whiten(&x[i]);
            *radius = support * state.smoothing_lengths[i];
        }
        check_finite(&self.whitened, &self.radii, at)?;
        self.work.evaluations += 1;
        let Some(criterion) = field.estimator.criterion() else {
            self.work.neighbour_visits += field.lattice.neighbours.n_pairs() as u64;
            return Ok(());
        };
        let radii = Radii::PerPoint { radii: &self.radii, criterion };
        self.grid.full_list(&self.whitened, radii, &mut self.neighbours)?;
        self.work.neighbour_visits += self.neighbours.n_pairs() as u64;
        let (step, time) = at;
        let (mean, limit) = (self.neighbours_mean(field), field.estimator.fewest_mean_neighbours());
        if mean < limit {
            return Err(Error::CloudTooSparse { step, time, mean, limit });
        }
        Ok(())
    }

    /// Mean number of neighbours, the particle itself included.
    pub(crate) fn neighbours_mean<S>(&self, field: &Field<S, D>) -> f64 {
        1.0 + self.neighbours_of(field).n_pairs() as f64 / self.whitened.len() as f64
    }

    /// Who the estimator takes as neighbours.
    pub(crate) fn neighbours_of<'a, S>(&'a self, field: &'a Field<S, D>) -> &'a NeighbourList {
        match field.estimator.criterion() {
            Some(_) => &self.neighbours,
            None => &field.lattice.neighbours,
        }
    }

    /// The cloud of the last evaluation.
    pub(crate) fn cloud<'a, S>(
        &'a self,
        field: &'a Field<S, D>,
        state: &'a State<D>,
        time: f64,
    ) -> Cloud<'a, D> {
        Cloud {
            positions: &self.whitened,
            masses: &state.masses,
            smoothing_lengths: &state.smoothing_lengths,
            neighbours: self.neighbours_of(field),
            lattice: &field.lattice.axis_neighbours,
            whitened: field.combination.metric == Metric::Whitened,
            step: state.n_steps,
            time,
        }
    }

    /// Density and score of particles at the positions `x`, with the masses and smoothing lengths of the state.
    pub(crate) fn estimate<S>(
        &mut self,
        field: &Field<S, D>,
        state: &State<D>,
        t: f64,
        x: &[[f64; D]],
    ) -> Result<(), Error> {
        self.find_neighbours(field, state, t, x)?;
        let (mut score, mut density, mut volume, mut deformation) = (
            std::mem::take(&mut self.score),
            std::mem::take(&mut self.density),
            std::mem::take(&mut self.volume),
            std::mem::take(&mut self.deformation),
        );
        let (mut unresolved, mut fits) = (Unresolved::default(), Fits::default());
        let mut out = Estimates {
            score: &mut score,
            density: &mut density,
            volume: &mut volume,
            deformation: &mut deformation,
            unresolved: &mut unresolved,
            fits: &mut fits,
        };
        let outcome = field.estimator.estimate(&self.cloud(field, state, t), &mut out);
        (self.score, self.density, self.volume) = (score, density, volume);
        (self.deformation, self.unresolved, self.fits) = (deformation, unresolved, fits);
        outcome
    }

    /// `v = f - div D - D grad log psi` (Canor & Denoël 2013, eq 12), in the units of the state.
    pub(crate) fn velocity<S: Sde<D, M>, const M: usize>(
        &mut self,
        field: &Field<S, D>,
        state: &State<D>,
        t: f64,
        x: &[[f64; D]],
        v: &mut [[f64; D]],
    ) -> Result<(), Error> {
        self.estimate(field, state, t, x)?;
        let system = &field.system;
        // Additive noise spreads every particle alike: one diffusion matrix serves the stage.
        let shared = (!S::Noise::STATE_DEPENDENT).then(|| system.diffusion(t, &x[0]));
        fill(v, |i| {
            let gradient = self.whitening.unwhiten_gradient(&self.score[i]);
            let diffusion = shared.unwrap_or_else(|| system.diffusion(t, &x[i]));
            let mut v_i = system.drift(t, &x[i]);
            if S::Noise::STATE_DEPENDENT {
                for (value, divergence) in
                    v_i.iter_mut().zip(&system.diffusion_divergence(t, &x[i]))
                {
                    *value -= divergence;
                }
            }
            for (value, row) in v_i.iter_mut().zip(&diffusion) {
                *value -= row.iter().zip(&gradient).map(|(d, s)| d * s).sum::<f64>();
            }
            v_i
        });
        Ok(())
    }

    /// The particle that spreads fastest against what the estimator resolves, and its rate there: `D_y / R^2`, with `D_y`
    /// the trace of the diffusion matrix in the metric and `R` the support radius, unless the estimator knows better.
    pub(crate) fn fastest_spread<S: Sde<D, M>, const M: usize>(
        &self,
        field: &Field<S, D>,
        t: f64,
        x: &[[f64; D]],
    ) -> (usize, f64) {
        let in_metric = |i: usize| self.whitening.whitened(&field.system.diffusion(t, &x[i]));
        let shared = (!S::Noise::STATE_DEPENDENT).then(|| in_metric(0));
        let spread = |i: usize| {
            let diffusion = shared.unwrap_or_else(|| in_metric(i));
            field.estimator.spread(&diffusion, self.radii[i], &self.deformation[i])
        };
        (0..x.len()).map(|i| (i, spread(i))).max_by(|a, b| a.1.total_cmp(&b.1)).unwrap_or((0, 0.0))
    }

    /// The particle that moves furthest against its smoothing length, and `min_i h_i / |v_i|` in the metric.
    pub(crate) fn courant_limit(&self, smoothing_lengths: &[f64], v: &[[f64; D]]) -> (usize, f64) {
        let limit = |i: usize| {
            let speed =
                self.whitening.whiten_vector(&v[i]).iter().map(|c| c * c).sum::<f64>().sqrt();
            smoothing_lengths[i] / speed
        };
        (0..v.len())
            .map(|i| (i, limit(i)))
            .min_by(|a, b| a.1.total_cmp(&b.1))
            .unwrap_or((0, f64::INFINITY))
    }
}

/// Refuses a particle that has left every scale, before the neighbour search meets it.
pub(crate) fn check_finite<const D: usize>(
    points: &[[f64; D]],
    radii: &[f64],
    at: (u64, f64),
) -> Result<(), Error> {
    let (step, time) = at;
    for (particle, y) in points.iter().enumerate() {
        if let Some(&value) = y.iter().find(|value| !value.is_finite()) {
            return Err(Error::LeftStableRange {
                step,
                time,
                particle,
                quantity: "position",
                value,
            });
        }
    }
    for (particle, &value) in radii.iter().enumerate() {
        if !(value.is_finite() && value > 0.0) {
            return Err(Error::LeftStableRange {
                step,
                time,
                particle,
                quantity: "smoothing length",
                value,
            });
        }
    }
    Ok(())
}
