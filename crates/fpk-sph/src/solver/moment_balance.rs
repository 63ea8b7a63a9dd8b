//! Errors of mean and covariance, from what the particles violate of the moment equations.

use crate::cloud::metric::mean_and_covariance;
use crate::score::inverse;
use crate::system::coefficients::Coefficients;
use crate::time::state::State;
use vibrating_systems::matrix::{Matrix, add, exponential, product, scaled, transposed};

/// Mean and covariance, or their errors.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MeanAndCovariance<const D: usize> {
    /// One entry a state (unit of each state).
    pub mean: [f64; D],
    /// Row by row (product of the units of both states).
    pub covariance: Matrix<D>,
}

/// Accumulates the errors of mean and covariance.
///
/// The density that solves the equation keeps
///
/// $$ \dot m = E f, \qquad \dot P = E[(x - m) f^T + f (x - m)^T] + 2 E D . $$
///
/// Particles that move with `v` violate both by `r` and `R`, which are zero where the score is exact. With the linear regression
/// `A = E[f (x - m)^T] P^{-1}` of the drift their errors follow
///
/// $$ \dot e = A e + r, \qquad \dot E = A E + E A^T + R, $$
///
/// starting from those of the lattice. For a linear drift this is exact. What settling moves is a part of both.
/// Source: this project; regression as in statistical linearisation (Roberts and Spanos 1990).
#[derive(Debug, Clone)]
pub(crate) struct MomentBalance<const D: usize> {
    /// Moments of the particles less those of the density.
    pub(crate) errors: MeanAndCovariance<D>,
    drift: Vec<[f64; D]>,
    diffusion: Vec<Matrix<D>>,
}

/// `sum mu x` and `sum mu (x - m) (x - m)^T`, not divided by the mass, about the mean `m` of the particles.
pub(crate) fn carried<const D: usize>(x: &[[f64; D]], masses: &[f64]) -> MeanAndCovariance<D> {
    let (mean, covariance) = mean_and_covariance(x, masses);
    let total: f64 = masses.iter().sum();
    MeanAndCovariance { mean, covariance: scaled(&covariance, total) }
}

impl<const D: usize> MomentBalance<D> {
    /// For particles that start on a lattice over a distribution of this mean and covariance.
    pub(crate) fn new(
        (mean, covariance): ([f64; D], Matrix<D>),
        x: &[[f64; D]],
        masses: &[f64],
    ) -> Self {
        let start = carried(x, masses);
        let errors = MeanAndCovariance {
            mean: simd_lanes::from_fn(|k| start.mean[k] - mean[k]),
            covariance: add(&start.covariance, &scaled(&covariance, -1.0)),
        };
        Self { errors, drift: Vec::new(), diffusion: Vec::new() }
    }

    /// Follows the errors over a step of length `dt`, in which the particles of `state` set out with velocities `v`.
    pub(crate) fn step(
        &mut self,
        system: &dyn Coefficients<D>,
        state: &State<D>,
        v: &[[f64; D]],
        dt: f64,
    ) {
        let State { time, positions, masses, .. } = state;
        system.drift(*time, positions, &mut self.drift);
        system.diffusion(*time, positions, &mut self.diffusion);
        let total: f64 = masses.iter().sum();
        let (mean, covariance) = mean_and_covariance(positions, masses);
        let (mut violated_mean, mut violated, mut of_drift) =
            ([0.0; D], [[0.0; D]; D], [[0.0; D]; D]);
        for (i, (x, mu)) in positions.iter().zip(masses).enumerate() {
            let (f, v) = (&self.drift[i], &v[i]);
            let spread = &self.diffusion[i.min(self.diffusion.len() - 1)];
            for k in 0..D {
                let (away, excess) = (mu * (x[k] - mean[k]), mu * (v[k] - f[k]));
                violated_mean[k] += excess;
                for l in 0..D {
                    // Divided by the mass, so that mass that is missing is a part of the violation.
                    violated[k][l] += away * (v[l] - f[l]) + excess * (x[l] - mean[l])
                        - 2.0 * mu * spread[k][l] / total;
                    of_drift[k][l] += mu * f[k] * (x[l] - mean[l]) / total;
                }
            }
        }
        // Without an inverse the cloud has no extent along an axis: nothing is propagated.
        let regression = inverse(&covariance).map_or([[0.0; D]; D], |p| product(&of_drift, &p));
        let propagated = exponential(&regression, dt);
        let MeanAndCovariance { mean: e, covariance: matrix } = &mut self.errors;
        let grown: [f64; D] = simd_lanes::from_fn(|k| e[k] + dt * violated_mean[k]);
        *e = simd_lanes::from_fn(|k| (0..D).map(|l| propagated[k][l] * grown[l]).sum());
        let grown = add(matrix, &scaled(&violated, dt));
        *matrix = product(&propagated, &product(&grown, &transposed(&propagated)));
    }

    /// Adds what has moved the particles from one place to another without time.
    pub(crate) fn moved(&mut self, from: &MeanAndCovariance<D>, x: &[[f64; D]], masses: &[f64]) {
        let to = carried(x, masses);
        for k in 0..D {
            self.errors.mean[k] += to.mean[k] - from.mean[k];
        }
        let change = add(&to.covariance, &scaled(&from.covariance, -1.0));
        self.errors.covariance = add(&self.errors.covariance, &change);
    }
}

impl<const D: usize> MeanAndCovariance<D> {
    /// All numbers with the names that they have in a snapshot.
    pub(crate) fn named(&self) -> impl Iterator<Item = (String, &f64)> {
        let all = self.mean.iter().chain(self.covariance.as_flattened());
        all.enumerate().map(|(k, value)| (name(k), value))
    }

    /// As [`Self::named`], to be changed.
    pub(crate) fn named_mut(&mut self) -> impl Iterator<Item = (String, &mut f64)> {
        let all = self.mean.iter_mut().chain(self.covariance.as_flattened_mut());
        all.enumerate().map(|(k, value)| (name(k), value))
    }

    /// The affine map `x -> x - e - E P^{-1} (x - m) / 2` that takes these errors out of particles with mean `m` and covariance
    /// `P`, to first order; none where the covariance has no inverse.
    pub(crate) fn correction(&self, x: &[[f64; D]], masses: &[f64]) -> Option<Correction<D>> {
        let (mean, covariance) = mean_and_covariance(x, masses);
        let slope = scaled(&product(&self.covariance, &inverse(&covariance)?), -0.5);
        Some(Correction { mean, shift: self.mean.map(|e| -e), slope })
    }
}

/// A small affine map of the states.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Correction<const D: usize> {
    mean: [f64; D],
    shift: [f64; D],
    slope: Matrix<D>,
}

impl<const D: usize> Correction<D> {
    /// The corrected place of a particle.
    #[must_use]
    pub fn of(&self, x: &[f64; D]) -> [f64; D] {
        let Self { mean, shift, slope } = self;
        simd_lanes::from_fn(|k| {
            let turned: f64 = (0..D).map(|l| slope[k][l] * (x[l] - mean[l])).sum();
            x[k] + shift[k] + turned
        })
    }

    /// The root of the sum of squares of the relative changes along the axes in which the map stretches, `sqrt(tr(S S))` for its
    /// slope `S` (no unit).
    #[must_use]
    pub fn relative_change(&self) -> f64 {
        let square = product(&self.slope, &self.slope);
        (0..D).map(|k| square[k][k]).sum::<f64>().max(0.0).sqrt()
    }
}

fn name(k: usize) -> String {
    format!("moment_error_{k}")
}
