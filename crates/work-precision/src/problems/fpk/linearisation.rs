//! A rival for moments: statistical linearisation.

use sde_integrators::{Additive, GaussianMixture, Sde};

use super::cholesky::cholesky;
use super::linear_moments::upper_tail;

/// Mean and covariance of a normal law at a time.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct GaussianLaw<const D: usize> {
    /// The time.
    pub t: f64,
    /// The mean.
    pub mean: [f64; D],
    /// The covariance.
    pub covariance: [[f64; D]; D],
}

/// How expectations over one state are taken, given the states before it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Quadrature {
    /// The rule of Gauss and Hermite with three nodes: exact for polynomials of degree 5.
    Hermite,
    /// The rule of Gauss and Legendre with 16 nodes on either side of zero, for a drift that has a kink or a root there.
    SplitAtZero,
}

/// Why there are no moments.
#[derive(Debug, thiserror::Error, PartialEq)]
#[non_exhaustive]
pub enum LinearisationError {
    /// The step is no positive number.
    #[error("the step is {value}; it must be greater than 0")]
    Step {
        /// What was given.
        value: f64,
    },
    /// Output times must increase from zero.
    #[error("the output time {value} does not exceed the one before it, {limit}")]
    Times {
        /// The time.
        value: f64,
        /// The one before it, or zero.
        limit: f64,
    },
    /// The order of the states is no permutation.
    #[error(
        "the state {value} stands twice in the order of the quadrature, or is none of {limit} states"
    )]
    Order {
        /// The state.
        value: usize,
        /// How many there are.
        limit: usize,
    },
    /// The closure made a covariance that is none.
    #[error(
        "at t = {time} the pivot of the covariance at state {state} is {value}; it must be positive"
    )]
    NotACovariance {
        /// When.
        time: f64,
        /// At which state.
        state: usize,
        /// The pivot.
        value: f64,
    },
}

/// Statistical linearisation, which is Gaussian closure: the drift is replaced by its linear regression on the state under
/// the present normal law,
///
/// $$ \dot m = E f(X), \qquad \dot P = E[f (X - m)^T] + E[(X - m) f^T] + 2 D, \qquad X \sim \mathcal N(m, P) . $$
///
/// Exact for a linear system; otherwise its error is that of taking the law for normal, and no parameter makes it smaller.
/// Runge-Kutta 4 in time.
///
/// Sources: Roberts and Spanos 1990, Random vibration and statistical linearization; that both are the same Atalik and
/// Utku 1976, Stochastic linearization of multi-degree-of-freedom non-linear systems.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Linearisation<const D: usize> {
    /// The states in the order in which expectations are nested, with their rules; those with kinks first, so that a kink
    /// is where a variable vanishes.
    pub order: [(usize, Quadrature); D],
    /// Longest step (time).
    pub step: f64,
}

impl<const D: usize> Linearisation<D> {
    /// The laws at the times.
    ///
    /// # Errors
    /// [`LinearisationError`].
    pub fn laws<S: Sde<D, M, Noise = Additive>, const M: usize>(
        &self,
        system: &S,
        law: &GaussianMixture<D>,
        times: &[f64],
    ) -> Result<Vec<GaussianLaw<D>>, LinearisationError> {
        self.check()?;
        let closure = Closure { system, order: self.order, legendre: half_line_rule() };
        let mut now = GaussianLaw { t: 0.0, mean: law.mean(), covariance: law.covariance() };
        let mut laws = Vec::with_capacity(times.len());
        for &end in times {
            if end.is_nan() || end <= now.t {
                return Err(LinearisationError::Times { value: end, limit: now.t });
            }
            let (from, steps) = (now.t, ((end - now.t) / self.step).ceil());
            let dt = (end - from) / steps;
            let mut done = 0.0;
            while done < steps {
                now.t = from + done * dt;
                now = closure.stepped(&now, dt)?;
                done += 1.0;
            }
            now.t = end;
            laws.push(now);
        }
        Ok(laws)
    }

    fn check(&self) -> Result<(), LinearisationError> {
        if !(self.step > 0.0 && self.step.is_finite()) {
            return Err(LinearisationError::Step { value: self.step });
        }
        let mut seen = [false; D];
        for (state, _) in self.order {
            if state >= D || std::mem::replace(&mut seen[state], true) {
                return Err(LinearisationError::Order { value: state, limit: D });
            }
        }
        Ok(())
    }
}

/// The rates of the moments.
struct Closure<'a, S, const D: usize> {
    system: &'a S,
    order: [(usize, Quadrature); D],
    legendre: [(f64, f64); HALF_NODES],
}

/// `E f` and `E[f (x - m)^T]`.
#[derive(Debug, Clone, Copy)]
struct Expectations<const D: usize> {
    drift: [f64; D],
    products: [[f64; D]; D],
}

impl<S, const D: usize> Closure<'_, S, D> {
    fn stepped<const M: usize>(
        &self,
        now: &GaussianLaw<D>,
        dt: f64,
    ) -> Result<GaussianLaw<D>, LinearisationError>
    where
        S: Sde<D, M, Noise = Additive>,
    {
        let k_1 = self.rate(now)?;
        let k_2 = self.rate(&now.moved(0.5 * dt, &k_1))?;
        let k_3 = self.rate(&now.moved(0.5 * dt, &k_2))?;
        let k_4 = self.rate(&now.moved(dt, &k_3))?;
        let mut next = *now;
        for (weight, rate) in [(1.0, k_1), (2.0, k_2), (2.0, k_3), (1.0, k_4)] {
            next = next.moved(weight * dt / 6.0, &rate);
        }
        next.t = now.t + dt;
        Ok(next)
    }

    /// The rates of mean and covariance.
    fn rate<const M: usize>(
        &self,
        law: &GaussianLaw<D>,
    ) -> Result<GaussianLaw<D>, LinearisationError>
    where
        S: Sde<D, M, Noise = Additive>,
    {
        let factor = self.factor(law)?;
        let mut sums = Expectations { drift: [0.0; D], products: [[0.0; D]; D] };
        self.visit(0, law, &factor, ([0.0; D], law.mean), 1.0, &mut sums);
        let diffusion = self.system.diffusion(law.t, &law.mean);
        let covariance = std::array::from_fn(|i| {
            std::array::from_fn(|j| {
                sums.products[i][j] + sums.products[j][i] + 2.0 * diffusion[i][j]
            })
        });
        Ok(GaussianLaw { t: law.t, mean: sums.drift, covariance })
    }

    /// The Cholesky factor of the covariance with its states in the order of the quadrature.
    fn factor(&self, law: &GaussianLaw<D>) -> Result<[[f64; D]; D], LinearisationError> {
        let state = |k: usize| self.order[k].0;
        let ordered: [[f64; D]; D] =
            std::array::from_fn(|i| std::array::from_fn(|j| law.covariance[state(i)][state(j)]));
        cholesky(&ordered).map_err(|(k, value)| LinearisationError::NotACovariance {
            time: law.t,
            state: state(k),
            value,
        })
    }

    /// Sums over the nodes of the states from `depth` on; `normals` and `x` hold what was chosen before.
    fn visit<const M: usize>(
        &self,
        depth: usize,
        law: &GaussianLaw<D>,
        factor: &[[f64; D]; D],
        (mut normals, mut x): ([f64; D], [f64; D]),
        weight: f64,
        sums: &mut Expectations<D>,
    ) where
        S: Sde<D, M, Noise = Additive>,
    {
        if depth == D {
            let f = self.system.drift(law.t, &x);
            for i in 0..D {
                sums.drift[i] += weight * f[i];
                for j in 0..D {
                    sums.products[i][j] += weight * f[i] * (x[j] - law.mean[j]);
                }
            }
            return;
        }
        let (state, quadrature) = self.order[depth];
        let given: f64 = (0..depth).map(|k| factor[depth][k] * normals[k]).sum();
        let (mean, deviation) = (law.mean[state] + given, factor[depth][depth]);
        let mut take = |node: f64, part: f64| {
            normals[depth] = node;
            x[state] = mean + deviation * node;
            self.visit(depth + 1, law, factor, (normals, x), weight * part, sums);
        };
        match quadrature {
            Quadrature::Hermite => {
                let far = 3.0_f64.sqrt();
                for (node, part) in [(-far, 1.0 / 6.0), (0.0, 2.0 / 3.0), (far, 1.0 / 6.0)] {
                    take(node, part);
                }
            }
            Quadrature::SplitAtZero => {
                let zero = (-mean / deviation).clamp(-FAR, FAR);
                for side in [-1.0, 1.0] {
                    let length = FAR - side * zero;
                    for (place, part) in self.legendre {
                        let node = zero + side * length * place;
                        let density = (-0.5 * node * node).exp() / std::f64::consts::TAU.sqrt();
                        take(node, part * length * density);
                    }
                }
            }
        }
    }
}

impl<const D: usize> GaussianLaw<D> {
    /// `E[X_i^2]`.
    #[must_use]
    pub fn second_moment(&self, state: usize) -> f64 {
        self.covariance[state][state] + self.mean[state] * self.mean[state]
    }

    /// `P(|X_i| > T)`.
    #[must_use]
    pub fn exceedance(&self, state: usize, threshold: f64) -> f64 {
        let deviation = self.covariance[state][state].sqrt();
        let tail = |side: f64| upper_tail((threshold - side * self.mean[state]) / deviation);
        tail(1.0) + tail(-1.0)
    }

    fn moved(&self, dt: f64, rate: &Self) -> Self {
        let mut moved = *self;
        moved.t += dt;
        for i in 0..D {
            moved.mean[i] += dt * rate.mean[i];
            for j in 0..D {
                moved.covariance[i][j] += dt * rate.covariance[i][j];
            }
        }
        moved
    }
}

/// Where the integration of a normal density ends: 5e-14 of its mass lies beyond.
const FAR: f64 = 7.5;
/// Nodes on either side of zero.
const HALF_NODES: usize = 16;

/// Nodes and weights over `[0, 1]` by `y = u^2` from the rule of Gauss and Legendre, which takes a root at zero well.
fn half_line_rule() -> [(f64, f64); HALF_NODES] {
    let mut rule = [(0.0, 0.0); HALF_NODES];
    let n = HALF_NODES as f64;
    for (i, entry) in rule.iter_mut().enumerate() {
        // Newton's method on Legendre's polynomial, from Abramowitz and Stegun 1964, eq 22.16.6.
        let mut x = (std::f64::consts::PI * (i as f64 + 0.75) / (n + 0.5)).cos();
        let mut slope = 1.0;
        for _ in 0..8 {
            let (mut now, mut before) = (1.0, 0.0);
            for k in 0..HALF_NODES {
                let k = k as f64;
                (now, before) = (((2.0 * k + 1.0) * x * now - k * before) / (k + 1.0), now);
            }
            slope = n * (x * now - before) / (x * x - 1.0);
            x -= now / slope;
        }
        let (u, weight) = (0.5 * (1.0 + x), 1.0 / ((1.0 - x * x) * slope * slope));
        *entry = (u * u, 2.0 * u * weight);
    }
    rule
}

#[cfg(test)]
mod tests {
    use fpk_sph::systems::{
        Duffing, DuffingParameters, LinearOscillator, LinearOscillatorParameters, ViscousDamper,
        ViscousDamperParameters, Window,
    };

    use super::*;
    use crate::problems::fpk::linear_moments::linear_moments;

    const STRUCTURE: LinearOscillatorParameters = LinearOscillatorParameters {
        natural_frequency: 1.0,
        damping_ratio: 0.05,
        noise_intensity: 0.1,
        window: Window::Stationary,
    };

    fn start() -> GaussianMixture<2> {
        GaussianMixture::independent([0.0, 0.0], [0.7, 0.9]).unwrap()
    }

    fn plane(on_v: Quadrature) -> Linearisation<2> {
        Linearisation { order: [(1, on_v), (0, Quadrature::Hermite)], step: 0.02 }
    }

    #[test]
    fn a_linear_system_keeps_its_exact_law() {
        let system = LinearOscillator::new(STRUCTURE).unwrap();
        let exact = linear_moments(&system, &start(), &[3.0], 1e-2).unwrap();
        for rule in [Quadrature::Hermite, Quadrature::SplitAtZero] {
            let law = plane(rule).laws(&system, &start(), &[3.0]).unwrap()[0];
            for i in 0..2 {
                for j in 0..2 {
                    // Runge-Kutta 4 for a covariance that turns at 2 omega: 2 omega t (2 omega dt)^4/120.
                    let error = (law.covariance[i][j] - exact[0].covariance[i][j]).abs();
                    assert!(error < 1.3e-7, "{rule:?}: {error:e}");
                }
            }
        }
    }

    #[test]
    fn the_stationary_duffing_oscillator_has_the_closed_linearised_variance() {
        // w^2 (1 + 3 eps s) s = S_0/(2 xi w): with w = 1, eps = 0.5, s = (sqrt(1 + 6) - 1)/3.
        let duffing = DuffingParameters { structure: STRUCTURE, cubic_stiffness: 0.5 };
        let system = Duffing::new(duffing).unwrap();
        let law = plane(Quadrature::Hermite).laws(&system, &start(), &[150.0]).unwrap()[0];
        let expected = (7.0_f64.sqrt() - 1.0) / 3.0;
        // What is left of the start: exp(-2 xi w t) = 3e-7.
        assert!((law.covariance[0][0] / expected - 1.0).abs() < 1e-5, "{}", law.covariance[0][0]);
        assert!((law.covariance[1][1] - 1.0).abs() < 1e-5);
    }

    #[test]
    fn a_root_of_the_drift_is_integrated_as_in_closed_form() {
        // E[|v|^1.35] = s^1.35 2^0.675 Gamma(1.175)/sqrt(pi), of which the damper takes 2 eta.
        let structure = LinearOscillatorParameters { noise_intensity: 0.0, ..STRUCTURE };
        let damper = |damper_coefficient| {
            ViscousDamper::new(ViscousDamperParameters {
                structure: structure.clone(),
                damper_coefficient,
                damper_exponent: 0.35,
            })
            .unwrap()
        };
        let rate = |eta: f64| {
            let system = damper(eta);
            let closure = Closure {
                system: &system,
                order: plane(Quadrature::SplitAtZero).order,
                legendre: half_line_rule(),
            };
            let covariance = [[0.49, 0.1], [0.1, 0.81]];
            let law = GaussianLaw { t: 0.0, mean: [0.0; 2], covariance };
            closure.rate(&law).unwrap().covariance[1][1]
        };
        let gamma = 0.9251974225134013;
        let moment = 0.9_f64.powf(1.35) * 2.0_f64.powf(0.675) * gamma / std::f64::consts::PI.sqrt();
        let taken = rate(0.0) - rate(0.25);
        assert!((taken / (0.5 * moment) - 1.0).abs() < 1e-5, "{taken} {}", 0.5 * moment);
    }

    #[test]
    fn bad_input_is_refused() {
        let system = LinearOscillator::new(STRUCTURE).unwrap();
        let with = |linearisation: Linearisation<2>, times: &[f64]| {
            linearisation.laws(&system, &start(), times).unwrap_err()
        };
        let good = plane(Quadrature::Hermite);
        assert!(matches!(
            with(Linearisation { step: 0.0, ..good }, &[1.0]),
            LinearisationError::Step { .. }
        ));
        assert!(matches!(with(good, &[1.0, 1.0]), LinearisationError::Times { .. }));
        let twice = Linearisation { order: [good.order[0]; 2], ..good };
        assert_eq!(with(twice, &[1.0]), LinearisationError::Order { value: 1, limit: 2 });
    }
}
