//! Moments by statistical linearisation (Gaussian closure).

use sde_integrators::{
    Additive, GaussianMixture, Sde, SmallPivot, normal_probability, small_cholesky,
};

/// Mean and covariance of a normal distribution at a time.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct GaussianLaw<const D: usize> {
    /// The time.
    pub t: f64,
    /// The mean.
    pub mean: [f64; D],
    /// The covariance.
    pub covariance: [[f64; D]; D],
}

/// Quadrature over one state, conditional on the states before it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Quadrature {
    /// Gauss-Hermite rule with three nodes: exact for polynomials of degree 5.
    Hermite,
    /// Gauss-Legendre rule with 16 nodes on either side of zero, for a drift with a kink or a root at zero.
    SplitAtZero,
    /// The same rule on either side of the value of an earlier state, for a kink where both are equal.
    SplitAt(usize),
}

/// Error of the linearisation.
#[derive(Debug, thiserror::Error, PartialEq)]
#[non_exhaustive]
pub enum LinearisationError {
    /// The step is not positive.
    #[error("the step is {value}; it must be greater than 0")]
    Step {
        /// The step given.
        value: f64,
    },
    /// The output times do not increase from zero.
    #[error("the output time {value} does not exceed the one before it, {limit}")]
    Times {
        /// The time.
        value: f64,
        /// The previous time, or zero.
        limit: f64,
    },
    /// The order of the states is no permutation.
    #[error(
        "the state {value} occurs twice in the order of the quadrature, or is none of {limit} states"
    )]
    Order {
        /// The state.
        value: usize,
        /// Number of states.
        limit: usize,
    },
    /// A rule splits at a state that comes later in the order.
    #[error("the rule of state {state} splits at state {at}, which does not come before it")]
    Split {
        /// The state of the rule.
        state: usize,
        /// The state at which it splits.
        at: usize,
    },
    /// The nested rules have too many nodes: the cost of every step.
    #[error(
        "an expectation of these rules takes {value} nodes; at most {limit}: take sampled paths, or a system whose kinks depend on two \
         states each (`PairwiseSde`)"
    )]
    TooManyNodes {
        /// Number of nodes.
        value: f64,
        /// Limit.
        limit: f64,
    },
    /// The computed covariance is not positive definite.
    #[error(
        "at t = {time} the pivot of the covariance at state {state} is {value}; it must be positive"
    )]
    NotACovariance {
        /// Time of the evaluation.
        time: f64,
        /// Index of the state.
        state: usize,
        /// The pivot.
        value: f64,
    },
}

/// Statistical linearisation (Gaussian closure).
///
/// The drift is replaced by its linear regression on the state under the current normal distribution,
///
/// $$ \dot m = E f(X), \qquad \dot P = E[f (X - m)^T] + E[(X - m) f^T] + 2 D, \qquad X \sim \mathcal N(m, P) . $$
///
/// Letters: $m$ = [`GaussianLaw::mean`] and $P$ = [`GaussianLaw::covariance`] (units of the states), $f$ the drift and
/// $D$ the diffusion matrix of the system. The method is exact for a linear system. Otherwise its error is that of the
/// normal approximation, and no parameter reduces it. Time integration is Runge-Kutta 4: for a linear system the error
/// decreases with the fourth power of the step.
///
/// Sources: Roberts and Spanos 1990, Random vibration and statistical linearization; equivalence of both formulations:
/// Atalik and Utku 1976, Stochastic linearization of multi-degree-of-freedom non-linear systems.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Linearisation<const D: usize> {
    /// States in the order in which expectations are nested, with their rules.
    ///
    /// States with kinks come first, so that a kink is where a variable is zero.
    pub order: [(usize, Quadrature); D],
    /// Longest step (time).
    pub step: f64,
}

impl<const D: usize> Linearisation<D> {
    /// Distributions at the given times, which increase from zero.
    ///
    /// # Errors
    /// [`LinearisationError`].
    pub fn laws<const M: usize>(
        &self,
        system: &dyn Sde<D, M, Noise = Additive>,
        law: &GaussianMixture<D>,
        times: &[f64],
    ) -> Result<Vec<GaussianLaw<D>>, LinearisationError> {
        self.laws_while(system, law, times, &mut |_| true)
    }

    /// The same as long as `goes_on`, which is asked at the time after each step: distributions at the times up to then.
    ///
    /// # Errors
    /// [`LinearisationError`].
    pub fn laws_while<const M: usize>(
        &self,
        system: &dyn Sde<D, M, Noise = Additive>,
        law: &GaussianMixture<D>,
        times: &[f64],
        goes_on: &mut dyn FnMut(f64) -> bool,
    ) -> Result<Vec<GaussianLaw<D>>, LinearisationError> {
        let closure = self.closure(system, HALF_NODES)?;
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
                now = closure.stepped_within(&now, dt, MOST_HALVINGS)?;
                done += 1.0;
                if !goes_on(from + done * dt) {
                    return Ok(laws);
                }
            }
            now.t = end;
            laws.push(now);
        }
        Ok(laws)
    }

    /// The rates of change of the moments, after a check of the rule, with this many nodes on either side of a kink.
    pub(crate) fn closure<'a, const M: usize>(
        &self,
        system: &'a dyn Sde<D, M, Noise = Additive>,
        half_nodes: usize,
    ) -> Result<Closure<'a, D, M>, LinearisationError> {
        self.check(half_nodes)?;
        Ok(Closure { system, order: self.order, legendre: half_line_rule(half_nodes) })
    }

    fn check(&self, half_nodes: usize) -> Result<(), LinearisationError> {
        if !(self.step > 0.0 && self.step.is_finite()) {
            return Err(LinearisationError::Step { value: self.step });
        }
        let mut seen = [false; D];
        for (state, rule) in self.order {
            if let Quadrature::SplitAt(at) = rule
                && !seen.get(at).is_some_and(|seen| *seen)
            {
                return Err(LinearisationError::Split { state, at });
            }
            if state >= D || std::mem::replace(&mut seen[state], true) {
                return Err(LinearisationError::Order { value: state, limit: D });
            }
        }
        let of = |(_, rule)| match rule {
            Quadrature::Hermite => 3.0,
            Quadrature::SplitAtZero | Quadrature::SplitAt(_) => 2.0 * half_nodes as f64,
        };
        let value: f64 = self.order.map(of).iter().product();
        if value > MOST_NODES {
            return Err(LinearisationError::TooManyNodes { value, limit: MOST_NODES });
        }
        Ok(())
    }
}

/// Rates of change of the moments.
pub(crate) struct Closure<'a, const D: usize, const M: usize> {
    system: &'a dyn Sde<D, M, Noise = Additive>,
    order: [(usize, Quadrature); D],
    legendre: Vec<(f64, f64)>,
}

/// `E f` and `E[f (x - m)^T]`.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Expectations<const D: usize> {
    pub(crate) drift: [f64; D],
    pub(crate) products: [[f64; D]; D],
}

impl<const D: usize, const M: usize> Closure<'_, D, M> {
    /// The moments after a step of Runge-Kutta 4.
    pub(crate) fn stepped(
        &self,
        now: &GaussianLaw<D>,
        dt: f64,
    ) -> Result<GaussianLaw<D>, LinearisationError> {
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

    /// As [`Self::stepped`], in two halves where a stage has no covariance: next to a state that is known, a step that the drift allows
    /// can be longer than the covariance.
    fn stepped_within(
        &self,
        now: &GaussianLaw<D>,
        dt: f64,
        halvings: u32,
    ) -> Result<GaussianLaw<D>, LinearisationError> {
        match self.stepped(now, dt) {
            Err(LinearisationError::NotACovariance { .. }) if halvings > 0 => {
                let half = self.stepped_within(now, 0.5 * dt, halvings - 1)?;
                self.stepped_within(&half, 0.5 * dt, halvings - 1)
            }
            stepped => stepped,
        }
    }

    /// Rates of change of mean and covariance.
    fn rate(&self, law: &GaussianLaw<D>) -> Result<GaussianLaw<D>, LinearisationError> {
        let sums = self.expectations(law)?;
        let diffusion = self.system.diffusion(law.t, &law.mean);
        let covariance = std::array::from_fn(|i| {
            std::array::from_fn(|j| {
                sums.products[i][j] + sums.products[j][i] + 2.0 * diffusion[i][j]
            })
        });
        Ok(GaussianLaw { t: law.t, mean: sums.drift, covariance })
    }

    /// `E f` and `E[f (x - m)^T]` under a normal distribution.
    pub(crate) fn expectations(
        &self,
        law: &GaussianLaw<D>,
    ) -> Result<Expectations<D>, LinearisationError> {
        let factor = self.factor(law)?;
        let mut sums = Expectations { drift: [0.0; D], products: [[0.0; D]; D] };
        self.visit(0, law, &factor, ([0.0; D], law.mean), 1.0, &mut sums);
        Ok(sums)
    }

    /// The Cholesky factor of the covariance with its states in the order of the quadrature.
    fn factor(&self, law: &GaussianLaw<D>) -> Result<[[f64; D]; D], LinearisationError> {
        let state = |k: usize| self.order[k].0;
        let ordered: [[f64; D]; D] =
            std::array::from_fn(|i| std::array::from_fn(|j| law.covariance[state(i)][state(j)]));
        small_cholesky(&ordered, 0.0).map_err(|SmallPivot { row, value, .. }| {
            LinearisationError::NotACovariance { time: law.t, state: state(row), value }
        })
    }

    /// Sums over the nodes of the states from `depth` on; `normals` and `x` hold the earlier choices.
    fn visit(
        &self,
        depth: usize,
        law: &GaussianLaw<D>,
        factor: &[[f64; D]; D],
        (mut normals, mut x): ([f64; D], [f64; D]),
        weight: f64,
        sums: &mut Expectations<D>,
    ) {
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
        let kink = if let Quadrature::SplitAt(other) = quadrature { x[other] } else { 0.0 };
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
            Quadrature::SplitAtZero | Quadrature::SplitAt(_) => {
                let zero = ((kink - mean) / deviation).clamp(-FAR, FAR);
                for side in [-1.0, 1.0] {
                    let length = FAR - side * zero;
                    for &(place, part) in &self.legendre {
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
    /// The raw moment `E[X_1^a_1 .. X_D^a_D]` of the normal distribution, for powers `a` of low order.
    ///
    /// The cost grows with the number of pairings of the factors (764 for eight).
    ///
    /// Source: Isserlis 1918, On a formula for the product-moment coefficient of any order of a normal frequency distribution.
    #[must_use]
    pub fn raw_moment(&self, powers: [u32; D]) -> f64 {
        let Some(i) = powers.iter().position(|&power| power > 0) else { return 1.0 };
        let mut rest = powers;
        rest[i] -= 1;
        let mut moment = self.mean[i] * self.raw_moment(rest);
        for j in (0..D).filter(|&j| rest[j] > 0) {
            let mut paired = rest;
            paired[j] -= 1;
            moment += f64::from(rest[j]) * self.covariance[i][j] * self.raw_moment(paired);
        }
        moment
    }

    /// `P(|w . X| > T)` for weights `w`.
    #[must_use]
    pub fn exceedance(&self, weights: &[f64; D], threshold: f64) -> f64 {
        let mean: f64 = (0..D).map(|i| weights[i] * self.mean[i]).sum();
        let mut variance = 0.0;
        for i in 0..D {
            for j in 0..D {
                variance += weights[i] * self.covariance[i][j] * weights[j];
            }
        }
        let tail = |side: f64| normal_probability((side * mean - threshold) / variance.sqrt());
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

/// Halvings of a step until a covariance that stays outside its cone is an error.
const MOST_HALVINGS: u32 = 12;

/// Limit of the integration of a normal density: 5e-14 of its mass lies beyond.
pub(crate) const FAR: f64 = 7.5;
/// Nodes on either side of zero.
const HALF_NODES: usize = 16;
/// Nodes of an expectation, of which each step has four. 885,000 nodes for 1,600 expectations had not ended after 150 s (2026-11-27).
const MOST_NODES: f64 = 3e5;

/// Nodes and weights over `[0, 1]`: the Gauss-Legendre rule with `y = u^2`, which is accurate for a root at zero.
pub(crate) fn half_line_rule(n_nodes: usize) -> Vec<(f64, f64)> {
    let mut rule = vec![(0.0, 0.0); n_nodes];
    let n = n_nodes as f64;
    for (i, entry) in rule.iter_mut().enumerate() {
        // Newton's method on Legendre's polynomial, from Abramowitz and Stegun 1964, eq 22.16.6.
        let mut x = (std::f64::consts::PI * (i as f64 + 0.75) / (n + 0.5)).cos();
        let mut slope = 1.0;
        for _ in 0..8 {
            let (mut now, mut before) = (1.0, 0.0);
            for k in 0..n_nodes {
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
