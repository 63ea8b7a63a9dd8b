//! Paths of a stochastic differential equation with doubling numbers of steps.

use sde_integrators::{Increment, InitialDistribution, Integrator, Noise};

use crate::ladder::{Failure, Ladder, Pair};

/// Paths of a system by one method, with twice as many steps on each level.
///
/// The step of level `l` is `end / (coarsest_steps 2^l)`. The paths of a pair share their Brownian motion: over a coarse
/// step of length $H$, made of fine steps of length $h$ with increments $w_k$ and integrals
/// $I_k = \int (W_s - W_{t_k})\, ds$ over each,
///
/// $$ w = \sum_k w_k, \qquad I = \sum_k \left( I_k + h\, (W_{t_k} - W_{t_0}) \right), $$
///
/// so a method that uses the integral has its order on both levels, and no difference of the levels has a bias. The cost
/// of a level is its number of steps. The initial state is that of the realisation.
///
/// Source: Giles 2008, Multilevel Monte Carlo path simulation, section 4; the integral by additivity.
///
/// ```
/// use uq_estimators::{Bias, Multilevel, PathLadder, Statistic, Target, Tolerance};
/// use sde_integrators::{EulerMaruyama, General, Sde};
///
/// /// dX = 0.05 X dt + 0.2 X dW.
/// struct Growth;
/// impl Sde<1, 1> for Growth {
///     type Noise = General;
///     fn drift(&self, _: f64, x: &[f64; 1]) -> [f64; 1] {
///         [0.05 * x[0]]
///     }
///     fn noise(&self, _: f64, x: &[f64; 1]) -> [[f64; 1]; 1] {
///         [[0.2 * x[0]]]
///     }
/// }
///
/// let ladder = PathLadder::<_, _, _, _, 1, 1> {
///     system: &Growth, integrator: &EulerMaruyama, law: &[1.0], seed: 1, end: 1.0, coarsest_steps: 1, n_levels: 8,
///     n_responses: 1, responses: |x: &[f64; 1], y: &mut [f64]| y[0] = x[0],
/// };
/// let tolerance = Tolerance::Absolute(5e-3);
/// let targets = [Target { response: 0, statistic: Statistic::Mean, tolerance }];
/// let study = Multilevel {
///     name: "growth", targets: &targets, bias: Bias::Order(1.0), block_length: 64, pilot_blocks: 2, budget: 1e6,
/// };
/// let mean = study.run(&ladder)?.targets[0];
/// assert!(mean.is_reached && (mean.estimate.value - 0.05_f64.exp()).abs() < 4.0 * 5e-3);
/// # Ok::<(), uq_estimators::Error>(())
/// ```
#[derive(Debug)]
pub struct PathLadder<'a, S: ?Sized, I, L: ?Sized, F, const D: usize, const M: usize> {
    /// The system.
    pub system: &'a S,
    /// The method.
    pub integrator: &'a I,
    /// Distribution of the initial state.
    pub law: &'a L,
    /// Seed of all random numbers.
    pub seed: u64,
    /// Final time.
    pub end: f64,
    /// Number of steps of level 0.
    pub coarsest_steps: u64,
    /// Number of levels.
    pub n_levels: usize,
    /// Number of responses.
    pub n_responses: usize,
    /// Writes the responses of a final state.
    pub responses: F,
}

impl<S, I, L, F, const D: usize, const M: usize> PathLadder<'_, S, I, L, F, D, M>
where
    S: ?Sized,
    L: ?Sized,
{
    fn n_steps(&self, level: usize) -> Result<u64, PathError> {
        let limit = MOST_STEPS;
        let n_steps = (self.coarsest_steps as f64) * (level as f64).exp2();
        if !(self.end.is_finite() && self.end > 0.0) {
            return Err(PathError::EndTime { value: self.end });
        }
        if n_steps >= 1.0 && n_steps <= limit as f64 {
            Ok(self.coarsest_steps << level)
        } else {
            Err(PathError::Steps { value: n_steps, limit })
        }
    }
}

/// Largest number of steps of a path.
const MOST_STEPS: u64 = 1 << 40;

/// Why a path could not be simulated; its text is that of the failed sample.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
enum PathError {
    #[error("the final time is {value}, must be finite and positive")]
    EndTime { value: f64 },
    #[error("{value} steps, must be at least 1 and at most {limit}")]
    Steps { value: f64, limit: u64 },
    #[error("non-finite after {n_steps} steps: state {component} is {value}")]
    State { n_steps: u64, component: usize, value: f64 },
}

impl<S, I, L, F, const D: usize, const M: usize> Ladder for PathLadder<'_, S, I, L, F, D, M>
where
    S: Sync + ?Sized,
    I: Integrator<S, D, M>,
    L: InitialDistribution<D> + ?Sized,
    F: Fn(&[f64; D], &mut [f64]) + Sync,
{
    fn n_levels(&self) -> usize {
        self.n_levels
    }

    fn n_responses(&self) -> usize {
        self.n_responses
    }

    fn cost(&self, level: usize) -> f64 {
        self.coarsest_steps as f64 * (level as f64).exp2()
    }

    fn sample(
        &self,
        pair: Pair,
        realisation: u64,
        fine: &mut [f64],
        coarse: &mut [f64],
    ) -> Result<(), Failure> {
        let noise = Noise::new(self.seed);
        let mut motion = noise.path::<M>(realisation);
        let n_steps = self.n_steps(pair.fine)?;
        let dt = self.end / n_steps as f64;
        let start = self.law.sample(&noise, realisation);
        let mut path = Walk::<I::Memory, D> { x: start, memory: I::Memory::default() };
        let Some(below) = pair.coarse else {
            for step in 0..n_steps {
                let dw = motion.next_increment(dt);
                self.step(&mut path, (step, dt), &dw)?;
            }
            return self.respond(&path.x, n_steps, fine);
        };
        let n_coarse = self.n_steps(below)?;
        let (ratio, long) = (n_steps / n_coarse, self.end / n_coarse as f64);
        let mut other = Walk::<I::Memory, D> { x: start, memory: I::Memory::default() };
        for step in 0..n_coarse {
            let (mut w, mut integral) = ([0.0; M], [0.0; M]);
            for part in 0..ratio {
                let dw = motion.next_increment(dt);
                self.step(&mut path, (step * ratio + part, dt), &dw)?;
                for m in 0..M {
                    let own = dt * (0.5 * dw.brownian[m] + dw.space_time_area[m]);
                    integral[m] += own + dt * w[m];
                    w[m] += dw.brownian[m];
                }
            }
            let mut dw = Increment { brownian: w, space_time_area: [0.0; M] };
            for m in 0..M {
                dw.space_time_area[m] = integral[m] / long - 0.5 * w[m];
            }
            self.step(&mut other, (step, long), &dw)?;
        }
        self.respond(&path.x, n_steps, fine)?;
        self.respond(&other.x, n_coarse, coarse)
    }
}

/// State and memory of a path.
struct Walk<Y, const D: usize> {
    x: [f64; D],
    memory: Y,
}

impl<S, I, L, F, const D: usize, const M: usize> PathLadder<'_, S, I, L, F, D, M>
where
    S: ?Sized,
    L: ?Sized,
    F: Fn(&[f64; D], &mut [f64]),
{
    #[inline]
    fn step(
        &self,
        path: &mut Walk<I::Memory, D>,
        (step, dt): (u64, f64),
        dw: &Increment<M>,
    ) -> Result<(), Failure>
    where
        I: Integrator<S, D, M>,
    {
        let t = step as f64 * dt;
        self.integrator.step(self.system, t, dt, dw, &mut path.x, &mut path.memory)?;
        Ok(())
    }

    fn respond(&self, x: &[f64; D], n_steps: u64, responses: &mut [f64]) -> Result<(), Failure> {
        if let Some(component) = x.iter().position(|value| !value.is_finite()) {
            return Err(PathError::State { n_steps, component, value: x[component] }.into());
        }
        (self.responses)(x, responses);
        Ok(())
    }
}
