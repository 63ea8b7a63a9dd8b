//! Statistical linearisation of a system of any number of states whose nonlinear terms depend on two states each.
//!
//! The regression of a term on all states is that on its own two, because the states are jointly normal.

use sde_integrators::{PairTerm, PairwiseSde};

use crate::guides::regression::{Pattern, Regression, Regressions, RunningLaw};
use crate::linearisation::{FAR, LinearisationError, half_line_rule};

/// Nodes on either side of a kink, as for a small system.
const HALF_NODES: usize = 10;
/// Deviations beyond which a kink is ignored: the rule on either side of it is accurate to a per cent no longer.
const FAR_KINK: f64 = 3.0;
/// Smallest standard deviation of a state, over its mean: below it a term is differentiated there.
const NARROW: f64 = 1e-6;
/// The same without a mean: any number whose square does not vanish.
const POINT: f64 = 1e-100;
/// Part of a variance within roundoff: a state of which the other leaves no more unexplained follows it.
const UNEXPLAINED: f64 = 1e-10;
/// Part of the largest variance by which another may be negative.
const HARDLY: f64 = 1e-6;

/// The running normal distribution of a system, from which regressions follow.
pub(crate) struct PairwiseLaws<'a, S> {
    closure: PairClosure<'a, S>,
    spacing: f64,
    laws: Vec<RunningLaw>,
}

impl<'a, S: PairwiseSde> PairwiseLaws<'a, S> {
    /// The distributions from a normal start up to a time, with steps of at most `step`.
    ///
    /// A step at which the covariance fails is halved, five times at most: Runge-Kutta 4 needs `2 omega h < 2.8`.
    pub(crate) fn new(
        system: &'a S,
        start: &RunningLaw,
        (time, mut step): (f64, f64),
    ) -> Result<Self, LinearisationError> {
        if !(step > 0.0 && step.is_finite()) {
            return Err(LinearisationError::Step { value: step });
        }
        let closure = PairClosure::new(system);
        let mut found = closure.laws(start, time, step);
        for _ in 0..5 {
            if !matches!(found, Err(LinearisationError::NotACovariance { .. })) {
                break;
            }
            step *= 0.5;
            found = closure.laws(start, time, step);
        }
        let (laws, spacing) = found?;
        Ok(Self { closure, spacing, laws })
    }

    /// The regressions towards an event of some states.
    ///
    /// Strength `kappa` takes the expectations under `kappa` times the deviations of these states and of those that move with
    /// them; the others follow by their regression on them: a storey may be far out while the others are not.
    pub(crate) fn regressions(&self, states: &[usize], strengths: &[f64]) -> Regressions {
        let moving = self.closure.moving_with(states);
        let mut of_strength = vec![Vec::with_capacity(self.laws.len()); strengths.len()];
        for law in &self.laws {
            let explained = Explained::new(law, &moving);
            for (strength, regressions) in strengths.iter().zip(&mut of_strength) {
                let excess = strength * strength - 1.0;
                let covariance =
                    |i: usize, j: usize| law.covariance(i, j) + excess * explained.covariance(i, j);
                regressions.push(self.closure.regression(law, &covariance));
            }
        }
        let (pattern, laws) = (self.closure.pattern.clone(), self.laws.clone());
        Regressions { pattern, spacing: self.spacing, laws, of_strength }
    }
}

/// The part of a covariance that some states explain: `P_(.r) P_rr^(-1) P_(r.)`.
struct Explained {
    /// `L^(-1) P_(r.)` with the Cholesky factor `L` of `P_rr`, per state.
    whitened: Vec<Vec<f64>>,
}

impl Explained {
    fn new(law: &RunningLaw, states: &[usize]) -> Self {
        let m = states.len();
        let mut factor = vec![vec![0.0; m]; m];
        for i in 0..m {
            for j in 0..=i {
                let rest: f64 = (0..j).map(|k| factor[i][k] * factor[j][k]).sum();
                let variance = law.covariance(states[i], states[j]);
                let value = variance - rest;
                factor[i][j] = if i != j {
                    if factor[j][j] > 0.0 { value / factor[j][j] } else { 0.0 }
                } else if value > UNEXPLAINED * variance {
                    value.sqrt()
                } else {
                    // What the states before it determine adds nothing.
                    0.0
                };
            }
        }
        let whitened = (0..law.mean.len()).map(|state| {
            let mut y = vec![0.0; m];
            for i in 0..m {
                let known: f64 = (0..i).map(|k| factor[i][k] * y[k]).sum();
                let rest = law.covariance(states[i], state) - known;
                y[i] = if factor[i][i] > 0.0 { rest / factor[i][i] } else { 0.0 };
            }
            y
        });
        Self { whitened: whitened.collect() }
    }

    fn covariance(&self, i: usize, j: usize) -> f64 {
        self.whitened[i].iter().zip(&self.whitened[j]).map(|(a, b)| a * b).sum()
    }
}

/// Rates of change of the moments.
struct PairClosure<'a, S> {
    system: &'a S,
    /// Entries of the linear part, then two for each term.
    pattern: Pattern,
    linear: Vec<f64>,
    terms: Vec<PairTerm>,
    legendre: Vec<(f64, f64)>,
}

impl<'a, S: PairwiseSde> PairClosure<'a, S> {
    fn new(system: &'a S) -> Self {
        let (linear, terms) = (system.linear_part(), system.pair_terms());
        let of_terms = terms.iter().flat_map(|term| term.states.map(|state| (term.row, state)));
        let pattern = linear.iter().map(|(i, j, _)| (*i, *j)).chain(of_terms).collect();
        let linear = linear.iter().map(|(_, _, value)| *value).collect();
        Self { system, pattern, linear, terms, legendre: half_line_rule(HALF_NODES) }
    }

    /// States that move with some: their rates, and the variables of terms that depend on these.
    fn moving_with(&self, states: &[usize]) -> Vec<usize> {
        let mut all = states.to_vec();
        let linear = &self.pattern[..self.linear.len()];
        let rates =
            linear.iter().filter(|(row, _)| states.contains(row)).map(|(_, column)| *column);
        all.extend(rates);
        let depends = |term: &&PairTerm| term.states.iter().any(|state| all.contains(state));
        let rows: Vec<usize> = self.terms.iter().filter(depends).map(|term| term.row).collect();
        all.extend(rows);
        all.sort_unstable();
        all.dedup();
        all
    }

    /// The distributions at equally spaced times, and their distance.
    fn laws(
        &self,
        start: &RunningLaw,
        time: f64,
        step: f64,
    ) -> Result<(Vec<RunningLaw>, f64), LinearisationError> {
        let intervals = (time / step).ceil().max(1.0);
        let spacing = time / intervals;
        let (mut now, mut done, mut laws) = (start.clone(), 0.0, Vec::new());
        loop {
            let t = done * spacing;
            laws.push(now.clone());
            if done >= intervals {
                return Ok((laws, spacing));
            }
            now = self.stepped(&now, t, spacing);
            done += 1.0;
            for state in 0..now.mean.len() {
                let value = now.covariance(state, state);
                // Truncation beside the other variances: a storey that the ground motion has hardly reached.
                let is_zero = value.abs() <= HARDLY * now.largest_variance();
                if !((value >= 0.0 || is_zero) && value.is_finite() && now.mean[state].is_finite())
                {
                    let time = done * spacing;
                    return Err(LinearisationError::NotACovariance { time, state, value });
                }
            }
        }
    }

    /// The regression under the mean of a distribution and a covariance.
    fn regression(&self, law: &RunningLaw, covariance: &dyn Fn(usize, usize) -> f64) -> Regression {
        let mut slope = self.linear.clone();
        let mut constant = vec![0.0; law.mean.len()];
        for (k, PairTerm { row, states: [a, b] }) in self.terms.iter().copied().enumerate() {
            let means = [law.mean[a], law.mean[b]];
            let covariances = [covariance(a, a), covariance(a, b), covariance(b, b)];
            let (expected, slopes) = self.of_pair(k, means, covariances);
            constant[row] += expected - slopes[0] * means[0] - slopes[1] * means[1];
            slope.extend(slopes);
        }
        Regression { slope, constant }
    }

    /// `E phi` of a term and its slopes over both states, with their variances and covariance.
    fn of_pair(
        &self,
        k: usize,
        mean: [f64; 2],
        [of_a, of_both, of_b]: [f64; 3],
    ) -> (f64, [f64; 2]) {
        let first = of_a.max(0.0).sqrt().max(NARROW * mean[0].abs()).max(POINT);
        // Truncation may leave variances of states that the noise has hardly reached without a meaning.
        let is_covariance = of_a > 0.0 && of_b > 0.0 && of_both * of_both <= of_a * of_b;
        let shared = if is_covariance { of_both / first } else { 0.0 };
        let alone = of_b - shared * shared;
        let second = if alone > UNEXPLAINED * of_b { alone.sqrt() } else { 0.0 };
        let (mut expected, mut along) = (0.0, [0.0; 2]);
        self.on_either_side(-mean[0] / first, |z_1, weight_1| {
            let (a, centre) = (mean[0] + first * z_1, mean[1] + shared * z_1);
            if second <= 0.0 {
                let weighted = weight_1 * self.system.pair_term(k, a, centre);
                expected += weighted;
                along[0] += weighted * z_1;
                return;
            }
            self.on_either_side(-centre / second, |z_2, weight_2| {
                let value = self.system.pair_term(k, a, centre + second * z_2);
                let weighted = weight_1 * weight_2 * value;
                expected += weighted;
                along[0] += weighted * z_1;
                along[1] += weighted * z_2;
            });
        });
        let slope_b = if second > 0.0 { along[1] / second } else { 0.0 };
        (expected, [(along[0] - shared * slope_b) / first, slope_b])
    }

    /// Nodes and weights of the standard normal distribution on either side of a kink, or of zero if the kink is far out.
    fn on_either_side(&self, kink: f64, mut take: impl FnMut(f64, f64)) {
        let kink = if kink.abs() < FAR_KINK { kink } else { 0.0 };
        for side in [-1.0, 1.0] {
            let length = FAR - side * kink;
            for &(place, part) in &self.legendre {
                let node = kink + side * length * place;
                let density = (-0.5 * node * node).exp() / std::f64::consts::TAU.sqrt();
                take(node, part * length * density);
            }
        }
    }

    /// The moments after a step of Runge-Kutta 4.
    fn stepped(&self, now: &RunningLaw, t: f64, h: f64) -> RunningLaw {
        let k_1 = self.rate(now, t);
        let k_2 = self.rate(&moved(now, 0.5 * h, &k_1), t + 0.5 * h);
        let k_3 = self.rate(&moved(now, 0.5 * h, &k_2), t + 0.5 * h);
        let k_4 = self.rate(&moved(now, h, &k_3), t + h);
        let weighted = [(1.0, k_1), (2.0, k_2), (2.0, k_3), (1.0, k_4)];
        weighted
            .iter()
            .fold(now.clone(), |next, (weight, rate)| moved(&next, weight * h / 6.0, rate))
    }

    /// Rates of change of mean and covariance: `m' = E f`, `P' = S P + P S^T + g g^T`.
    fn rate(&self, law: &RunningLaw, t: f64) -> RunningLaw {
        let n = law.mean.len();
        let own = |i: usize, j: usize| law.covariance(i, j);
        let Regression { slope, constant: mut mean } = self.regression(law, &own);
        let mut half = vec![0.0; n * n];
        for (&(i, k), value) in self.pattern.iter().zip(&slope) {
            mean[i] += value * law.mean[k];
            for j in 0..n {
                half[i * n + j] += value * law.covariance[k * n + j];
            }
        }
        let mut g = vec![0.0; n];
        self.system.noise(t, &mut g);
        let mut covariance = vec![0.0; n * n];
        for i in 0..n {
            for j in 0..n {
                covariance[i * n + j] = half[i * n + j] + half[j * n + i] + g[i] * g[j];
            }
        }
        RunningLaw { mean, covariance }
    }
}

fn moved(law: &RunningLaw, h: f64, rate: &RunningLaw) -> RunningLaw {
    let add = |values: &[f64], rates: &[f64]| -> Vec<f64> {
        values.iter().zip(rates).map(|(value, rate)| value + h * rate).collect()
    };
    RunningLaw {
        mean: add(&law.mean, &rate.mean),
        covariance: add(&law.covariance, &rate.covariance),
    }
}
