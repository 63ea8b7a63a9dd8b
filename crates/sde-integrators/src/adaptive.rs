//! Adaptive time steps on a Brownian tree: the path does not depend on which steps are accepted.

use crate::bridge::BrownianTree;
use crate::diagonal::DiagonalSde;
use crate::error::Error;
use crate::euler_maruyama::EulerMaruyama;
use crate::heun::Heun;
use crate::integrator::Integrator;
use crate::milstein::Milstein;
use crate::noise::{Increment, Noise};
use crate::shark::Shark;
use crate::sra1::Sra1;
use crate::sra3::Sra3;
use crate::sriw1::Sriw1;
use crate::stratonovich::StratonovichSde;
use crate::system::{Additive, Sde};

/// A method that converges on every path when steps are chosen from the path: strong order at least 1.
///
/// A rejected step has used information about the path. With such steps a method of strong order 1/2 can fail:
/// Euler-Maruyama with state-dependent noise then converges to another equation. Here it does not compile:
///
/// ```compile_fail
/// use sde_integrators::{AdaptivePath, DiagonalNoise, DiagonalSde, EulerMaruyama, Noise, StepControl};
///
/// struct Growth;
/// impl DiagonalSde<1> for Growth {
///     fn drift(&self, _t: f64, x: &[f64; 1]) -> [f64; 1] { [0.5 * x[0]] }
///     fn intensity(&self, _t: f64, x: &[f64; 1]) -> [f64; 1] { [0.8 * x[0]] }
///     fn intensity_derivative(&self, _t: f64, _x: &[f64; 1]) -> [f64; 1] { [0.8] }
/// }
///
/// let control = StepControl { longest: 0.25, absolute: 1e-3, relative: 1e-3, halvings: 12 };
/// AdaptivePath::new(&DiagonalNoise(Growth), &EulerMaruyama, &Noise::new(1), 0, [1.0], &control);
/// ```
///
/// Source: Gaines and Lyons 1997, Variable step size control in the numerical solution of stochastic differential
/// equations, theorem 4.3 and the counterexample before it.
pub trait Pathwise<S: ?Sized, const D: usize, const M: usize>: Integrator<S, D, M> {
    /// The strong order `gamma`. The error of one step is of order `gamma + 1/2`, which sets the gain of the controller.
    const STRONG_ORDER: f64;
}

impl<S: DiagonalSde<D> + ?Sized, const D: usize> Pathwise<S, D, D> for Milstein {
    const STRONG_ORDER: f64 = 1.0;
}
impl<S: DiagonalSde<D> + ?Sized, const D: usize> Pathwise<S, D, D> for Sriw1 {
    const STRONG_ORDER: f64 = 1.5;
}
/// A single motion commutes with itself.
impl<S: StratonovichSde<D, 1> + ?Sized, const D: usize> Pathwise<S, D, 1> for Heun {
    const STRONG_ORDER: f64 = 1.0;
}
macro_rules! pathwise_for_additive {
    ($($method:ty => $order:literal;)+) => { $(
        impl<S, const D: usize, const M: usize> Pathwise<S, D, M> for $method
        where
            S: Sde<D, M, Noise = Additive> + ?Sized,
        {
            const STRONG_ORDER: f64 = $order;
        }
    )+ };
}
pathwise_for_additive! {
    EulerMaruyama => 1.0;
    Sra1 => 1.5;
    Sra3 => 1.5;
    Shark => 1.5;
}

/// Step control of an [`AdaptivePath`].
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct StepControl {
    /// Longest step (time): the root of the tree.
    pub longest: f64,
    /// Absolute tolerance of a step (unit of the state).
    pub absolute: f64,
    /// Relative tolerance of a step.
    pub relative: f64,
    /// Largest number of halvings of the longest step: 0 to [`BrownianTree::MAX_DEPTH`] - 1.
    pub halvings: u32,
}

impl StepControl {
    fn check(&self) -> Result<(), Error> {
        for (quantity, value) in [("longest step", self.longest), ("absolute", self.absolute)] {
            if !(value.is_finite() && value > 0.0) {
                return Err(Error::NotPositive { quantity, value });
            }
        }
        if !(self.relative.is_finite() && self.relative >= 0.0) {
            let (value, to) = (self.relative, f64::MAX);
            return Err(Error::OutOfRange { quantity: "relative", value, from: 0.0, to });
        }
        let limit = DEEPEST - 1;
        if self.halvings > limit {
            let (value, limit) = (f64::from(self.halvings), f64::from(limit));
            return Err(Error::TooMany { quantity: "halvings", value, limit });
        }
        Ok(())
    }

    fn length(&self, depth: u32) -> f64 {
        self.longest * 0.5_f64.powi(depth.cast_signed())
    }
}

/// An accepted step.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct AcceptedStep {
    /// Time at its start.
    pub t: f64,
    /// Its length.
    pub dt: f64,
    /// Error estimate over the tolerance: at most 1.
    pub error: f64,
    /// Number of longer steps rejected from the same state.
    pub rejected: u32,
}

const DEEPEST: u32 = 20;
/// Safety factor of the step length.
const SAFETY: f64 = 0.9;
/// Smallest and largest factor of a change of the step length.
const CHANGE: (f64, f64) = (0.2, 5.0);

/// One path with adaptive steps.
///
/// A step of length `h` is computed once as a whole and once as two halves along the same path; the result of the
/// halves is kept. The error is
///
/// $$ e = \max_i \frac{|x_i^{(h/2, h/2)} - x_i^{(h)}|}{\varepsilon_a + \varepsilon_r \max(|x_i|, |x_i^{(h/2, h/2)}|)} $$
///
/// and the step is accepted for `e <= 1`. The next length is `0.9 h e^(-0.7/k) e_b^(0.4/k)`, where `e_b` is the error
/// of the previous step and `k = gamma + 1/2` (a proportional-integral controller). It is rounded down to the tree: a
/// power of 1/2 of the longest step, at a time where such a step begins.
///
/// A rejected step is halved, and the noise of its halves comes from the [`BrownianTree`] as a function of position.
/// No increment is redrawn, so acceptance does not bias the distribution, and the path does not depend on the
/// tolerances.
///
/// Cost: three steps of the method per trial, and about 100 ns per halving to look up the noise.
///
/// Sources: Gaines and Lyons 1997; the controller: Gustafsson 1991, Control theoretic techniques for stepsize selection.
///
/// ```
/// use sde_integrators::{AdaptivePath, DiagonalSde, Milstein, Noise, StepControl};
///
/// struct Growth;
/// impl DiagonalSde<1> for Growth {
///     fn drift(&self, _t: f64, x: &[f64; 1]) -> [f64; 1] { [0.5 * x[0]] }
///     fn intensity(&self, _t: f64, x: &[f64; 1]) -> [f64; 1] { [0.8 * x[0]] }
///     fn intensity_derivative(&self, _t: f64, _x: &[f64; 1]) -> [f64; 1] { [0.8] }
/// }
///
/// let control = StepControl { longest: 0.25, absolute: 1e-4, relative: 1e-4, halvings: 16 };
/// let noise = Noise::new(1);
/// let mut path = AdaptivePath::new(&Growth, &Milstein, &noise, 0, [1.0], &control)?;
/// path.run(4)?;
/// // The same path in closed form, from the four steps at the root of the tree.
/// let mut steps = noise.path::<1>(0);
/// let w: f64 = (0..4).map(|_| steps.next_increment(0.25).brownian[0]).sum();
/// let exact = ((0.5 - 0.32) + 0.8 * w).exp();
/// assert_eq!(path.time(), 1.0);
/// assert!((path.state()[0] / exact - 1.0).abs() < 3e-3);
/// # Ok::<(), sde_integrators::Error>(())
/// ```
#[derive(Debug, Clone)]
pub struct AdaptivePath<'a, S: ?Sized, I: Integrator<S, D, M>, const D: usize, const M: usize> {
    system: &'a S,
    integrator: &'a I,
    tree: BrownianTree<M>,
    control: StepControl,
    realisation: u64,
    /// Completed longest steps, and the position in the next one in units of its last halving.
    root: u64,
    place: u64,
    depth: u32,
    error_before: f64,
    accepted: u64,
    rejected: u64,
    state: [f64; D],
    memory: I::Memory,
}

/// A trial step: state after its two halves, and error.
struct Trial<Memory, const D: usize> {
    state: [f64; D],
    memory: Memory,
    error: f64,
}

impl<'a, S, I, const D: usize, const M: usize> AdaptivePath<'a, S, I, D, M>
where
    S: ?Sized,
    I: Pathwise<S, D, M>,
{
    /// A path from `start` at time 0; its first trial is the longest step.
    ///
    /// # Errors
    /// [`Error::NotPositive`] (`longest`, `absolute`), [`Error::OutOfRange`] (`relative`), [`Error::TooMany`]
    /// (`halvings`), [`Error::NotFinite`] (`start`).
    pub fn new(
        system: &'a S,
        integrator: &'a I,
        noise: &Noise,
        realisation: u64,
        start: [f64; D],
        control: &StepControl,
    ) -> Result<Self, Error> {
        control.check()?;
        if let Some(index) = start.iter().position(|value| !value.is_finite()) {
            return Err(Error::NotFinite { quantity: "state", index, value: start[index] });
        }
        Ok(Self {
            system,
            integrator,
            tree: BrownianTree::new(*noise, realisation, control.longest),
            control: *control,
            realisation,
            root: 0,
            place: 0,
            depth: 0,
            error_before: 1.0,
            accepted: 0,
            rejected: 0,
            state: start,
            memory: I::Memory::default(),
        })
    }

    /// The state.
    #[must_use]
    pub const fn state(&self) -> &[f64; D] {
        &self.state
    }

    /// The time.
    #[must_use]
    pub fn time(&self) -> f64 {
        (self.root as f64 + self.place as f64 / self.places() as f64) * self.control.longest
    }

    /// Number of accepted steps.
    #[must_use]
    pub const fn accepted(&self) -> u64 {
        self.accepted
    }

    /// Number of rejected steps.
    #[must_use]
    pub const fn rejected(&self) -> u64 {
        self.rejected
    }

    /// Advances to the end of the longest step number `n_longest`, counted from time 0.
    ///
    /// # Errors
    /// Those of [`step`](Self::step).
    pub fn run(&mut self, n_longest: u64) -> Result<(), Error> {
        while self.root < n_longest {
            let _step = self.step()?;
        }
        Ok(())
    }

    /// Advances by one accepted step. After an error the path is in its state after the last accepted step.
    ///
    /// # Errors
    /// Errors of the shortest step: [`Error::StepUnderflow`] if its error is too large, [`Error::NonFiniteState`] if
    /// the state is not finite, [`Error::Step`] if the method fails.
    pub fn step(&mut self) -> Result<AcceptedStep, Error> {
        let (t, mut rejected) = (self.time(), 0);
        loop {
            let dt = self.control.length(self.depth);
            let failure = match self.try_step(t, dt) {
                Ok(trial) if trial.error <= 1.0 => {
                    self.accept(&trial, dt);
                    return Ok(AcceptedStep { t, dt, error: trial.error, rejected });
                }
                Ok(trial) => {
                    let (realisation, error) = (self.realisation, trial.error);
                    (error, Error::StepUnderflow { realisation, t, dt, error })
                }
                Err(failure) => (f64::INFINITY, failure),
            };
            if self.depth == self.control.halvings {
                return Err(failure.1);
            }
            rejected += 1;
            self.rejected += 1;
            let shorter =
                self.depth_of(dt * (SAFETY * failure.0.powf(-1.0 / Self::K)).max(CHANGE.0));
            self.depth = shorter.clamp(self.depth + 1, self.control.halvings);
        }
    }

    /// Order of the local error.
    const K: f64 = I::STRONG_ORDER + 0.5;

    /// Computes the whole step and its halves.
    fn try_step(&self, t: f64, dt: f64) -> Result<Trial<I::Memory, D>, Error> {
        let (whole, halves) = self.increments();
        let mut coarse = (self.state, self.memory.clone());
        let mut fine = coarse.clone();
        let half = 0.5 * dt;
        let step = |from: f64, length: f64, dw, path: &mut ([f64; D], I::Memory)| {
            let (realisation, step) = (self.realisation, self.accepted);
            self.integrator
                .step(self.system, from, length, dw, &mut path.0, &mut path.1)
                .map_err(|source| Error::Step { realisation, step, t: from, source })
        };
        step(t, dt, &whole, &mut coarse)?;
        step(t, half, &halves[0], &mut fine)?;
        step(t + half, half, &halves[1], &mut fine)?;
        for x in [&coarse.0, &fine.0] {
            if let Some(component) = x.iter().position(|value| !value.is_finite()) {
                return Err(Error::NonFiniteState {
                    realisation: self.realisation,
                    steps: self.accepted + 1,
                    t: t + dt,
                    component,
                    value: x[component],
                });
            }
        }
        let (state, memory) = fine;
        let error = (0..D).fold(0.0_f64, |largest, i| {
            let size = self.state[i].abs().max(state[i].abs());
            let scale = self.control.absolute + self.control.relative * size;
            largest.max((state[i] - coarse.0[i]).abs() / scale)
        });
        Ok(Trial { state, memory, error })
    }

    /// Noise of the current step and of its halves, from the tree.
    fn increments(&self) -> (Increment<M>, [Increment<M>; 2]) {
        let mut halves = [0_u8; DEEPEST as usize];
        let depth = self.depth as usize;
        for (level, half) in halves[..depth].iter_mut().enumerate() {
            let bit = self.control.halvings as usize - 1 - level;
            *half = u8::from(self.place >> bit & 1 == 1);
        }
        self.tree.parts(self.root, &halves[..depth])
    }

    fn accept(&mut self, trial: &Trial<I::Memory, D>, dt: f64) {
        self.state = trial.state;
        self.memory = trial.memory.clone();
        self.accepted += 1;
        self.place += self.places() >> self.depth;
        if self.place == self.places() {
            (self.root, self.place) = (self.root + 1, 0);
        }
        // An error of zero requests the largest change, and must not be divided by.
        let error = trial.error.max(1e-10);
        let factor = SAFETY * error.powf(-0.7 / Self::K) * self.error_before.powf(0.4 / Self::K);
        self.error_before = error;
        let wanted = self.depth_of(dt * factor.clamp(CHANGE.0, CHANGE.1));
        // The longest step that begins at this position.
        let begins = self.control.halvings - self.place.trailing_zeros().min(self.control.halvings);
        let begins = if self.place == 0 { 0 } else { begins };
        self.depth = wanted.max(begins);
    }

    /// Number of shortest steps in a longest one.
    const fn places(&self) -> u64 {
        1 << self.control.halvings
    }

    /// Depth of the longest step of the tree that does not exceed `dt`.
    fn depth_of(&self, dt: f64) -> u32 {
        (0..self.control.halvings)
            .find(|&depth| self.control.length(depth) <= dt)
            .unwrap_or(self.control.halvings)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_tree_is_as_deep_as_it_says() {
        assert_eq!(DEEPEST as usize, BrownianTree::<1>::MAX_DEPTH);
    }
}
