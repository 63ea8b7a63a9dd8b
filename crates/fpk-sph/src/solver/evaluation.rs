//! One evaluation of the right-hand side: metric, neighbours, density and score, velocity. The buffers are reused.

use neighbour_search::{CellGrid, Criterion, NeighbourList, NeighbourSearch, Radii};

use crate::cloud::Cloud;
use crate::cloud::metric::{Metric, Whitening, mean_and_covariance};
use crate::error::Error;
use crate::extremes::first_smallest;
use crate::parallel::{BLOCK, for_each_block};
use crate::score::Estimates;
use crate::solver::discretisation::Discretisation;
use crate::solver::report::Work;
use crate::system::coefficients::Coefficients;
use crate::time::state::State;
use vibrating_systems::matrix::Matrix;

/// What one evaluation of the right-hand side holds.
#[derive(Debug)]
pub(crate) struct Evaluation<const D: usize> {
    /// Input of the estimator.
    pub(crate) cloud: WhitenedCloud<D>,
    /// Its output.
    pub(crate) estimates: Estimates<D>,
    /// `D` in the metric at every particle, or once for all.
    diffusion: Vec<[[f64; D]; D]>,
    /// Parts of the particles in the second moments; empty where none is neglected.
    weights: Vec<f64>,
    pub(crate) work: Work,
}

/// The particles in the coordinates of the metric.
#[derive(Debug)]
pub(crate) struct WhitenedCloud<const D: usize> {
    pub(crate) whitening: Whitening<D>,
    /// `y_i`.
    pub(crate) positions: Vec<[f64; D]>,
    /// Smoothing lengths `h_i`, those of the stage.
    smoothing_lengths: Vec<f64>,
    /// Support radii.
    radii: Vec<f64>,
    grid: CellGrid<D>,
    /// Neighbours within the radii, where the estimator searches.
    neighbours: NeighbourList,
}

impl<const D: usize> WhitenedCloud<D> {
    fn new(n: usize) -> Self {
        Self {
            whitening: Whitening::identity(),
            positions: vec![[0.0; D]; n],
            smoothing_lengths: vec![0.0; n],
            radii: vec![0.0; n],
            grid: CellGrid::new(),
            neighbours: NeighbourList::new(),
        }
    }

    /// The metric of the particles at `x`, their places, smoothing lengths and support radii in it.
    fn whiten(
        &mut self,
        discretisation: &Discretisation<D>,
        state: &State<D>,
        Stage { t, x, smoothing_lengths: h }: Stage<'_, D>,
    ) -> Result<(), Error> {
        let at = (state.n_steps, t);
        self.smoothing_lengths.copy_from_slice(h);
        if discretisation.combination.metric == Metric::Whitened {
            let (mean, covariance) = mean_and_covariance(x, &state.masses);
            self.whitening = Whitening::of_covariance(mean, &covariance, at)?;
        }
        let support = discretisation.estimator.support();
        let Self { whitening, positions, radii, .. } = self;
        simd_lanes::dispatch(
            #[inline(always)]
            || {
                for (y, x) in positions.iter_mut().zip(x) {
                    *y = whitening.whiten(x);
                }
                for (radius, h) in radii.iter_mut().zip(h) {
                    *radius = support * h;
                }
            },
        );
        check_finite(&self.positions, &self.radii, at)
    }

    /// Finds the neighbours within the support radii.
    fn find_neighbours(&mut self, criterion: Criterion) -> Result<(), Error> {
        let radii = Radii::PerPoint { radii: &self.radii, criterion };
        Ok(self.grid.full_list(&self.positions, radii, &mut self.neighbours)?)
    }

    /// The estimator's neighbour list: within the support radii, or on the lattice.
    pub(crate) fn neighbours<'a>(
        &'a self,
        discretisation: &'a Discretisation<D>,
    ) -> &'a NeighbourList {
        match discretisation.estimator.criterion() {
            Some(_) => &self.neighbours,
            None => &discretisation.lattice.neighbours,
        }
    }

    /// Mean number of neighbours, the particle itself included.
    pub(crate) fn neighbours_mean(&self, discretisation: &Discretisation<D>) -> f64 {
        1.0 + self.neighbours(discretisation).n_pairs() as f64 / self.positions.len() as f64
    }

    /// The cloud as an estimator sees it.
    pub(crate) fn view<'a>(
        &'a self,
        discretisation: &'a Discretisation<D>,
        state: &'a State<D>,
        time: f64,
    ) -> Cloud<'a, D> {
        Cloud {
            positions: &self.positions,
            masses: &state.masses,
            smoothing_lengths: &self.smoothing_lengths,
            neighbours: self.neighbours(discretisation),
            lattice: &discretisation.lattice.axis_neighbours,
            whitened: discretisation.combination.metric == Metric::Whitened,
            step: state.n_steps,
            time,
        }
    }
}

/// What an evaluation takes of a stage: time, positions, smoothing lengths.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Stage<'a, const D: usize> {
    pub(crate) t: f64,
    pub(crate) x: &'a [[f64; D]],
    /// In the coordinates of the metric.
    pub(crate) smoothing_lengths: &'a [f64],
}

impl<const D: usize> State<D> {
    /// The state as a stage.
    pub(crate) fn stage(&self) -> Stage<'_, D> {
        let Self { time, positions, smoothing_lengths, .. } = self;
        Stage { t: *time, x: positions, smoothing_lengths }
    }
}

impl<const D: usize> Evaluation<D> {
    pub(crate) fn new(n: usize) -> Self {
        Self {
            cloud: WhitenedCloud::new(n),
            estimates: Estimates::new(n),
            diffusion: Vec::new(),
            weights: Vec::with_capacity(n),
            work: Work::default(),
        }
    }

    /// The estimator's input at a stage: whitened positions, support radii, neighbours.
    pub(crate) fn prepare(
        &mut self,
        discretisation: &Discretisation<D>,
        state: &State<D>,
        stage: Stage<'_, D>,
    ) -> Result<(), Error> {
        self.cloud.whiten(discretisation, state, stage)?;
        self.work.evaluations += 1;
        if let Some(criterion) = discretisation.estimator.criterion() {
            self.cloud.find_neighbours(criterion)?;
        }
        self.work.neighbour_visits += self.cloud.neighbours(discretisation).n_pairs() as u64;
        Ok(())
    }

    /// Density and score at a stage, with the masses of the state.
    pub(crate) fn estimate(
        &mut self,
        discretisation: &Discretisation<D>,
        state: &State<D>,
        stage: Stage<'_, D>,
    ) -> Result<(), Error> {
        self.prepare(discretisation, state, stage)?;
        self.estimates.restart();
        let cloud = self.cloud.view(discretisation, state, stage.t);
        discretisation.estimator.estimate(&cloud, &mut self.estimates)
    }

    /// `v = f - div D - D grad log psi` (Canor & Denoël 2013, eq 12), in the units of the state.
    pub(crate) fn velocity(
        &mut self,
        system: &dyn Coefficients<D>,
        discretisation: &Discretisation<D>,
        state: &State<D>,
        stage: Stage<'_, D>,
        v: &mut [[f64; D]],
    ) -> Result<(), Error> {
        self.estimate(discretisation, state, stage)?;
        let Stage { t, x, .. } = stage;
        let (whitening, score_y) = (&self.cloud.whitening, &self.estimates.score);
        for_each_block(v, &|first, v| {
            let mut score = [[0.0; D]; BLOCK];
            let (block, score) = (first..first + v.len(), &mut score[..v.len()]);
            let score_y = &score_y[block.clone()];
            simd_lanes::dispatch(
                #[inline(always)]
                || {
                    for (score, score_y) in score.iter_mut().zip(score_y) {
                        *score = whitening.unwhiten_gradient(score_y);
                    }
                },
            );
            system.velocity(t, &x[block], score, v);
        });
        Ok(())
    }

    /// The particle that spreads fastest against what the estimator resolves, and its rate there, at the worse of two times:
    /// `D_y / R^2`, with `D_y` the trace of the diffusion matrix in the metric and `R` the support radius, unless the
    /// estimator knows better. The fastest particles that together hold at most the
    /// [negligible](crate::Combination::negligible) part of the second moments are left out.
    pub(crate) fn fastest_spread(
        &mut self,
        system: &dyn Coefficients<D>,
        discretisation: &Discretisation<D>,
        [now, then]: [f64; 2],
        state: &State<D>,
    ) -> (usize, f64) {
        let x = &state.positions;
        if discretisation.combination.negligible > 0.0 {
            self.weigh(&state.masses);
        }
        system.diffusion(now, x, &mut self.diffusion);
        let shared = if let [matrix] = self.diffusion[..] { Some(matrix) } else { None };
        if let Some(first) = shared {
            system.diffusion(then, x, &mut self.diffusion);
            let last = self.diffusion[0];
            if are_proportional(&first, &last) {
                // Noise under a window: the greater intensity spreads all particles faster.
                self.diffusion[0] = if trace(&last) > trace(&first) { last } else { first };
                return self.fastest_spread_of(discretisation);
            }
            self.diffusion[0] = first;
        }
        let first = self.fastest_spread_of(discretisation);
        if now.to_bits() == then.to_bits() {
            return first;
        }
        system.diffusion(then, x, &mut self.diffusion);
        let last = self.fastest_spread_of(discretisation);
        if last.1 > first.1 { last } else { first }
    }

    /// The same with the diffusion matrices that are held.
    fn fastest_spread_of(&mut self, discretisation: &Discretisation<D>) -> (usize, f64) {
        let Self { cloud, estimates, diffusion, weights, .. } = self;
        for matrix in diffusion.iter_mut() {
            *matrix = cloud.whitening.whitened(matrix);
        }
        let (radii, deformation) = (&cloud.radii, &estimates.deformation);
        let (estimator, negligible) =
            (&discretisation.estimator, discretisation.combination.negligible);
        if negligible > 0.0 {
            return estimator.fastest_spread_but(
                diffusion,
                radii,
                deformation,
                weights,
                negligible,
            );
        }
        estimator.fastest_spread(diffusion, radii, deformation)
    }

    /// The parts that particles have in the trace of the second moments in the metric, `mu_i |y_i|^2` over their sum.
    fn weigh(&mut self, masses: &[f64]) {
        let Self { cloud, weights, .. } = self;
        weights.clear();
        let squares = cloud.positions.iter().map(|y| y.iter().map(|c| c * c).sum::<f64>());
        weights.extend(squares.zip(masses).map(|(square, mass)| mass * square));
        let total: f64 = weights.iter().sum();
        for weight in weights {
            *weight /= total;
        }
    }

    /// The particle that moves furthest against its smoothing length, and `min_i h_i / |v_i|` in the metric.
    pub(crate) fn courant_limit(&self, smoothing_lengths: &[f64], v: &[[f64; D]]) -> (usize, f64) {
        first_smallest(
            v.len(),
            #[inline(always)]
            |first, limits| {
                let here = first..first + limits.len();
                let (v, h) = (&v[here.clone()], &smoothing_lengths[here]);
                for (p, limit) in limits.iter_mut().enumerate() {
                    let u = self.cloud.whitening.whiten_vector(&v[p]);
                    *limit = h[p] / u.iter().map(|c| c * c).sum::<f64>().sqrt();
                }
            },
        )
    }
}

fn trace<const D: usize>(matrix: &Matrix<D>) -> f64 {
    (0..D).map(|k| matrix[k][k]).sum()
}

/// Whether two diffusion matrices are the same within roundoff but for a factor.
fn are_proportional<const D: usize>(a: &Matrix<D>, b: &Matrix<D>) -> bool {
    let (of_a, of_b) = (trace(a), trace(b));
    let within = 1e-14 * of_a * of_b;
    let mut entries = a.as_flattened().iter().zip(b.as_flattened());
    entries.all(|(a, b)| (a * of_b - b * of_a).abs() <= within)
}

/// Whether a condition holds for all values; it looks at all, so that registers take several.
fn all(values: &[f64], holds: impl Fn(f64) -> bool) -> bool {
    simd_lanes::dispatch(
        #[inline(always)]
        || values.iter().fold(true, |all, value| all & holds(*value)),
    )
}

/// Refuses a particle that has left every scale, before the neighbour search meets it.
pub(crate) fn check_finite<const D: usize>(
    points: &[[f64; D]],
    radii: &[f64],
    at: (u64, f64),
) -> Result<(), Error> {
    let (step, time) = at;
    let is_length = |value: f64| value > 0.0 && value.is_finite();
    if all(points.as_flattened(), f64::is_finite) && all(radii, is_length) {
        return Ok(());
    }
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
