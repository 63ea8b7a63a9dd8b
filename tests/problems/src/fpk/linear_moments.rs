//! Exact first and second moments of a linear system, and the tails of its normal law.

use result_figures::Reference;
use sde_integrators::{GaussianMixture, Sde, normal_probability};

/// The normal law of a linear system at a time, with the error of its integration.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct NormalLaw<const D: usize> {
    /// The time.
    pub t: f64,
    /// `E[X]`.
    pub mean: [f64; D],
    /// The covariance of `X`.
    pub covariance: [[f64; D]; D],
    /// The largest error of an entry `C_ij` over `sqrt(C_ii C_jj)`, by halving the step.
    pub relative_error: f64,
}

/// Why there are no exact moments.
#[derive(Debug, thiserror::Error, PartialEq)]
#[non_exhaustive]
pub enum LinearMomentsError {
    /// The drift is no affine function of the state.
    #[error(
        "the drift is not linear: at t = {time} it misses linearity in state {state} by {error:e}"
    )]
    NotLinear {
        /// When.
        time: f64,
        /// The state in which it was doubled.
        state: usize,
        /// By how much it is off, over its size.
        error: f64,
    },
    /// Output times must increase from zero.
    #[error("the output time {value} does not exceed the one before it, {limit}")]
    Times {
        /// The time.
        value: f64,
        /// The one before it, or zero.
        limit: f64,
    },
    /// The step is no positive number.
    #[error("the step is {value}; it must be greater than 0")]
    Step {
        /// What was given.
        value: f64,
    },
}

/// Mean and covariance of `X` at the times, by
///
/// $$ \dot m = A m + b, \qquad \dot P = A P + P A^T + 2 D $$
///
/// for `dX = (A(t) X + b(t)) dt + g(t) dB`, with `A` and `b` read off the drift. Runge-Kutta 4 at steps of at most `step`
/// that land on the times, and again at half the step, which gives one more order and the error. Times at which a window
/// has a kink should be among the times.
///
/// Source: Risken 1996, The Fokker-Planck equation, section 6.5.
///
/// # Errors
/// [`LinearMomentsError`].
pub fn linear_moments<S: Sde<D, M>, const D: usize, const M: usize>(
    system: &S,
    law: &GaussianMixture<D>,
    times: &[f64],
    step: f64,
) -> Result<Vec<NormalLaw<D>>, LinearMomentsError> {
    if !(step > 0.0 && step.is_finite()) {
        return Err(LinearMomentsError::Step { value: step });
    }
    let start = Moments { mean: law.mean(), covariance: law.covariance() };
    let (mut t, mut coarse, mut fine) = (0.0, start, start);
    let mut laws = Vec::with_capacity(times.len());
    for &end in times {
        if end.is_nan() || end <= t {
            return Err(LinearMomentsError::Times { value: end, limit: t });
        }
        let legs = ((end - t) / step).ceil();
        coarse = coarse.advanced(system, (t, end), legs)?;
        fine = fine.advanced(system, (t, end), 2.0 * legs)?;
        laws.push(fine.extrapolated(&coarse, end));
        t = end;
    }
    Ok(laws)
}

#[derive(Debug, Clone, Copy)]
struct Moments<const D: usize> {
    mean: [f64; D],
    covariance: [[f64; D]; D],
}

impl<const D: usize> Moments<D> {
    fn advanced<S: Sde<D, M>, const M: usize>(
        mut self,
        system: &S,
        (from, to): (f64, f64),
        steps: f64,
    ) -> Result<Self, LinearMomentsError> {
        let dt = (to - from) / steps;
        let mut done = 0.0;
        while done < steps {
            let t = from + done * dt;
            let k_1 = self.rate(system, t)?;
            let k_2 = self.moved(0.5 * dt, &k_1).rate(system, t + 0.5 * dt)?;
            let k_3 = self.moved(0.5 * dt, &k_2).rate(system, t + 0.5 * dt)?;
            let k_4 = self.moved(dt, &k_3).rate(system, t + dt)?;
            for (weight, rate) in [(1.0, k_1), (2.0, k_2), (2.0, k_3), (1.0, k_4)] {
                self = self.moved(weight * dt / 6.0, &rate);
            }
            done += 1.0;
        }
        Ok(self)
    }

    fn rate<S: Sde<D, M>, const M: usize>(
        &self,
        system: &S,
        t: f64,
    ) -> Result<Self, LinearMomentsError> {
        let (a, b) = coefficients(system, t)?;
        let p = &self.covariance;
        let mut covariance = system.diffusion(t, &self.mean);
        for i in 0..D {
            for j in 0..D {
                let pulled: f64 = (0..D).map(|k| a[i][k] * p[k][j] + p[i][k] * a[j][k]).sum();
                covariance[i][j] = 2.0 * covariance[i][j] + pulled;
            }
        }
        let mean =
            std::array::from_fn(|i| b[i] + (0..D).map(|k| a[i][k] * self.mean[k]).sum::<f64>());
        Ok(Self { mean, covariance })
    }

    fn moved(&self, dt: f64, rate: &Self) -> Self {
        let mut moved = *self;
        for i in 0..D {
            moved.mean[i] += dt * rate.mean[i];
            for j in 0..D {
                moved.covariance[i][j] += dt * rate.covariance[i][j];
            }
        }
        moved
    }

    /// Order 5 from the fine run and the coarse one.
    fn extrapolated(&self, coarse: &Self, t: f64) -> NormalLaw<D> {
        let better = |fine: f64, coarse: f64| fine + (fine - coarse) / 15.0;
        let mean = std::array::from_fn(|i| better(self.mean[i], coarse.mean[i]));
        let mut covariance = self.covariance;
        let mut relative_error = 0.0_f64;
        for i in 0..D {
            for j in 0..D {
                let scale = (self.covariance[i][i] * self.covariance[j][j]).sqrt();
                let change = (self.covariance[i][j] - coarse.covariance[i][j]).abs() / 15.0;
                covariance[i][j] = better(self.covariance[i][j], coarse.covariance[i][j]);
                relative_error = relative_error.max(change / scale);
            }
        }
        NormalLaw { t, mean, covariance, relative_error }
    }
}

/// A matrix and a vector of `D` states.
type Affine<const D: usize> = ([[f64; D]; D], [f64; D]);

/// `A` and `b` of a drift `A x + b`.
fn coefficients<S: Sde<D, M>, const D: usize, const M: usize>(
    system: &S,
    t: f64,
) -> Result<Affine<D>, LinearMomentsError> {
    let at = |j: usize, size: f64| {
        let mut x = [0.0; D];
        x[j] = size;
        system.drift(t, &x)
    };
    let b = system.drift(t, &[0.0; D]);
    let mut a = [[0.0; D]; D];
    for j in 0..D {
        let (one, two) = (at(j, 1.0), at(j, -2.0));
        for i in 0..D {
            a[i][j] = one[i] - b[i];
            let error = (two[i] - b[i] + 2.0 * a[i][j]).abs() / (1.0 + one[i].abs() + b[i].abs());
            if error.is_nan() || error > ROUNDOFF {
                return Err(LinearMomentsError::NotLinear { time: t, state: j, error });
            }
        }
    }
    Ok((a, b))
}

/// What the sum of a few products loses, with room.
const ROUNDOFF: f64 = 1e-12;

impl<const D: usize> NormalLaw<D> {
    /// `E[X_i X_j]`.
    #[must_use]
    pub fn second_moment(&self, i: usize, j: usize) -> Reference {
        let value = self.covariance[i][j] + self.mean[i] * self.mean[j];
        let scale = (self.covariance[i][i] * self.covariance[j][j]).sqrt();
        Reference::uncertain(value, self.relative_error * scale)
    }

    /// `P(|w . X| > T)` for weights `w`.
    #[must_use]
    pub fn exceedance(&self, weights: &[f64; D], threshold: f64) -> Reference {
        let mean: f64 = (0..D).map(|i| weights[i] * self.mean[i]).sum();
        let mut variance = 0.0;
        for i in 0..D {
            for j in 0..D {
                variance += weights[i] * self.covariance[i][j] * weights[j];
            }
        }
        let deviation = variance.sqrt();
        let (above, below) = ((threshold - mean) / deviation, (threshold + mean) / deviation);
        let p = normal_probability(-above) + normal_probability(-below);
        // d ln P/d ln variance is at most (1 + z^2)/2.
        let z = above.abs().max(below.abs());
        Reference::uncertain(p, p * 0.5 * (1.0 + z * z) * self.relative_error)
    }
}

#[cfg(test)]
mod tests {
    use vibrating_systems::{
        Filter, Filtered, KanaiTajimiParameters, LinearOscillator, LinearOscillatorParameters,
        OrnsteinUhlenbeck, OrnsteinUhlenbeckParameters, Window,
    };

    use super::*;
    use crate::fpk::oscillator::Oscillator;
    use crate::fpk::problem::Problem;

    #[test]
    fn the_linear_oscillator_has_the_moments_and_tails_of_its_reference() {
        let problem = Problem::linear_oscillator().unwrap();
        let Oscillator::Linear(system) = &problem.system else { panic!("another system") };
        let times: Vec<f64> =
            problem.reference.times().iter().copied().filter(|t| *t > 0.0).collect();
        let laws = linear_moments(system, &problem.law, &times, 2e-3).unwrap();
        assert_eq!(laws.len(), 12);
        for law in &laws {
            for (powers, (i, j)) in [([2, 0], (0, 0)), ([1, 1], (0, 1)), ([0, 2], (1, 1))] {
                let expected = problem.reference.moment(powers, law.t).unwrap().value;
                let scale = (law.covariance[i][i] * law.covariance[j][j]).sqrt();
                let error = (law.second_moment(i, j).value - expected).abs() / scale;
                // The reference is good to 1e-11.
                assert!(error < 2e-11, "{powers:?} at {}: {error:e}", law.t);
            }
            let expected = problem.reference.exceedance(1.0, law.t).unwrap().value;
            let error = (law.exceedance(&[1.0, 0.0], 1.0).value / expected - 1.0).abs();
            // z^2/2 times 1e-11.
            assert!(error < 1e-8, "tail at {}: {error:e}", law.t);
            assert!(law.relative_error < 1e-9, "{:e}", law.relative_error);
        }
    }

    #[test]
    fn an_ornstein_uhlenbeck_process_has_its_closed_law() {
        let parameters = OrnsteinUhlenbeckParameters {
            rates: [[1.0, 0.5, 0.0], [-0.5, 1.5, 0.2], [0.0, 0.3, 0.4]],
            mean: [0.2, 0.0, -0.1],
            noise: [[0.5, 0.0, 0.0], [0.1, 0.4, 0.0], [0.0, 0.2, 0.3]],
        };
        let process = OrnsteinUhlenbeck::new(parameters).unwrap();
        let start = GaussianMixture::independent([1.0, 0.0, 0.0], [0.1, 0.2, 0.3]).unwrap();
        for law in linear_moments(&process, &start, &[0.5, 3.0], 1e-2).unwrap() {
            let covariance = process.covariance_at(law.t, &start.covariance()).unwrap();
            let mean = process.mean_at(law.t, &start.mean()).unwrap();
            for i in 0..3 {
                assert!((law.mean[i] - mean[i]).abs() < 1e-12);
                for j in 0..3 {
                    assert!((law.covariance[i][j] - covariance[i][j]).abs() < 1e-12);
                }
            }
        }
    }

    #[test]
    fn the_filter_of_a_shaken_structure_stays_in_its_stationary_law() {
        let structure = LinearOscillator::new(LinearOscillatorParameters {
            natural_frequency: std::f64::consts::PI,
            damping_ratio: 0.05,
            noise_intensity: 0.2,
            window: Window::CANOR_DENOEL_2013,
        })
        .unwrap();
        let soil = KanaiTajimiParameters { ground_frequency: 15.6, ground_damping: 0.6 };
        let filter = Filter::kanai_tajimi(soil).unwrap();
        let system = Filtered::new(structure, filter, Window::Stationary).unwrap();
        let start: GaussianMixture<4> = system.initial_distribution(&[0.0; 2], &[0.01; 2]).unwrap();
        let laws = linear_moments(&system, &start, &[2.0, 6.0], 2e-3).unwrap();
        for i in 0..2 {
            let stays = filter.stationary_covariance()[i][i];
            assert!((laws[1].covariance[2 + i][2 + i] / stays - 1.0).abs() < 1e-9);
        }
        assert!(laws[1].covariance[0][0] > laws[0].covariance[0][0]);
    }

    #[test]
    fn a_system_that_is_not_linear_and_times_out_of_order_are_refused() {
        let problem = Problem::viscous_damper().unwrap();
        let Oscillator::Damper(damper) = &problem.system else { panic!("another system") };
        let refused = linear_moments(damper, &problem.law, &[1.0], 0.1).unwrap_err();
        assert!(matches!(refused, LinearMomentsError::NotLinear { state: 1, .. }), "{refused}");
        let problem = Problem::linear_oscillator().unwrap();
        let Oscillator::Linear(linear) = &problem.system else { panic!("another system") };
        let refused = linear_moments(linear, &problem.law, &[1.0, 1.0], 0.1).unwrap_err();
        assert_eq!(refused, LinearMomentsError::Times { value: 1.0, limit: 1.0 });
    }
}
