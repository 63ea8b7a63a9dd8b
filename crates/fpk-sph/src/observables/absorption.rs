//! Survival of the particles below thresholds, with what noise and motion absorb beyond them.

use super::exchange::{LatticeExchange, Move};
use crate::error::{Error, finite};
use crate::solver::Solver;
use crate::time::state::State;

/// What [`FirstPassage`](super::FirstPassage) records, whatever the demand.
pub(super) struct Absorption<const D: usize> {
    pub(super) thresholds: Vec<f64>,
    /// Time and steps at the last record.
    pub(super) time: f64,
    n_steps: u64,
    /// Number of remeshings at construction.
    n_remaps: u64,
    /// Probability that no particle carries.
    pub(super) mass_outside: f64,
    /// The step before the last record; 0 at the first.
    dt: f64,
    /// Demands at the last record and at the one before.
    pub(super) value: Vec<f64>,
    before: Vec<f64>,
    pub(super) exchange: LatticeExchange<D>,
    /// `w_i`, per threshold.
    pub(super) survival: Vec<Vec<f64>>,
    pub(super) absorbed: Vec<f64>,
    /// The part of what is absorbed that came from particles whose cells were turned over.
    pub(super) unresolved: Vec<f64>,
    pub(super) scratch: Scratch<D>,
}

/// Parts of an exchange per rate at which noise takes a particle beyond a threshold: with too few the particles next to it
/// run empty. `P` of a Brownian motion is 2 % low with 1, and within 0.3 % with 8 (121 particles).
const PARTS_PER_RATE: f64 = 8.0;
/// Most parts of an exchange.
const MOST_PARTS: f64 = 16.0;

/// Buffers of a record.
#[derive(Debug, Clone)]
pub(super) struct Scratch<const D: usize> {
    pub(super) exchange: LatticeExchange<D>,
    pub(super) value: Vec<f64>,
    /// Columns of the noise, particle by particle.
    pub(super) noise: Vec<[f64; D]>,
    /// Parts of the reduced mass that pairs exchange, parts of a particle's mass that moves take.
    pair_parts: Vec<f64>,
    move_rates: Vec<f64>,
}

impl<const D: usize> Absorption<D> {
    /// Survival of all particles; nothing is absorbed yet.
    pub(super) fn new(solver: &Solver<D>, thresholds: &[f64]) -> Result<Self, Error> {
        if thresholds.is_empty() {
            return Err(Error::TooFewRows { name: "thresholds", count: 0, limit: 1 });
        }
        for &threshold in thresholds {
            finite("threshold", threshold)?;
        }
        let n = solver.n_particles();
        let exchange = LatticeExchange::new(&solver.discretisation.lattice.places);
        let scratch = Scratch {
            exchange: exchange.clone(),
            value: vec![0.0; n],
            noise: Vec::new(),
            pair_parts: Vec::new(),
            move_rates: Vec::new(),
        };
        Ok(Self {
            thresholds: thresholds.to_vec(),
            time: solver.state.time,
            n_steps: solver.state.n_steps,
            n_remaps: solver.state.n_remaps,
            mass_outside: solver.mass_outside(),
            dt: 0.0,
            value: vec![0.0; n],
            before: vec![0.0; n],
            survival: vec![vec![1.0; n]; thresholds.len()],
            absorbed: vec![0.0; thresholds.len()],
            unresolved: vec![0.0; thresholds.len()],
            scratch,
            exchange,
        })
    }

    /// Makes the buffers the first record: what is beyond a threshold is absorbed.
    pub(super) fn begin(&mut self, masses: &[f64]) {
        self.take_over();
        self.before.copy_from_slice(&self.value);
        self.absorb(masses, |record, i| (record.value[i], record.exchange.turned_over[i]));
    }

    /// Whether the solver's step is recorded already.
    ///
    /// # Errors
    /// [`Error::UnwatchedSteps`]; [`Error::OtherSimulation`]; [`Error::RemappedUnderWatch`].
    pub(super) fn has_recorded(&self, solver: &Solver<D>) -> Result<bool, Error> {
        let State { time, n_steps, n_remaps, .. } = solver.state;
        if n_remaps != self.n_remaps {
            return Err(Error::RemappedUnderWatch { time });
        }
        let (found, expected) = (solver.n_particles(), self.value.len());
        if found != expected {
            return Err(Error::OtherSimulation { found, expected });
        }
        if n_steps != self.n_steps && n_steps != self.n_steps + 1 {
            return Err(Error::UnwatchedSteps { recorded: self.n_steps, found: n_steps });
        }
        Ok(n_steps == self.n_steps)
    }

    /// Records the step that led to the state, with demands and exchange there in the buffers: half an exchange before the
    /// motion, absorption by it, half an exchange after it.
    pub(super) fn record(&mut self, state: &State<D>) {
        let (dt, masses) = (state.time - self.time, &state.masses);
        self.exchange(masses, 0.5 * dt);
        let (h_0, h_1) = (self.dt, dt);
        self.absorb(masses, |record, i| {
            let [y_0, y_1, y_2] = [record.before[i], record.value[i], record.scratch.value[i]];
            let demand = y_2.max(peak([y_0, y_1, y_2], h_0, h_1));
            (demand, record.scratch.exchange.turned_over[i])
        });
        self.take_over();
        self.exchange(masses, 0.5 * dt);
        (self.time, self.n_steps, self.dt) = (state.time, state.n_steps, dt);
    }

    /// Makes the buffers the last record.
    fn take_over(&mut self) {
        std::mem::swap(&mut self.before, &mut self.value);
        std::mem::swap(&mut self.value, &mut self.scratch.value);
        std::mem::swap(&mut self.exchange, &mut self.scratch.exchange);
    }

    /// Absorbs the particles whose demand is beyond a threshold, given with whether the cell is turned over.
    fn absorb(&mut self, masses: &[f64], seen: impl Fn(&Self, usize) -> (f64, bool)) {
        for i in 0..masses.len() {
            let (demand, is_turned_over) = seen(self, i);
            for (k, &threshold) in self.thresholds.iter().enumerate() {
                if demand > threshold {
                    let mass = masses[i] * self.survival[k][i];
                    self.absorbed[k] += mass;
                    self.unresolved[k] += if is_turned_over { mass } else { 0.0 };
                    self.survival[k][i] = 0.0;
                }
            }
        }
    }

    /// The exchange over a time, in as many parts as the moves beyond a threshold ask for.
    fn exchange(&mut self, masses: &[f64], dt: f64) {
        let crosses = |to: &&Move| {
            let value = self.value[to.i as usize];
            self.thresholds.iter().any(|&threshold| value <= threshold && threshold < to.demand)
        };
        let rate = |to: &Move| to.conductance / masses[to.i as usize];
        let fastest = self.exchange.moves.iter().filter(crosses).map(rate).fold(0.0, f64::max);
        let parts = (PARTS_PER_RATE * fastest * dt).ceil().clamp(1.0, MOST_PARTS);
        let part = dt / parts;
        let LatticeExchange { pairs, moves, .. } = &self.exchange;
        let Scratch { pair_parts, move_rates, .. } = &mut self.scratch;
        pair_parts.clear();
        pair_parts.extend(pairs.iter().map(|pair| {
            let (a, b) = (masses[pair.i as usize], masses[pair.j as usize]);
            let reduced = a * b / (a + b);
            -reduced * (-pair.conductance / reduced * 0.5 * part).exp_m1()
        }));
        move_rates.clear();
        move_rates.extend(moves.iter().map(|to| rate(to) * part));
        let mut left = parts;
        while left > 0.0 {
            self.exchange_part(masses);
            left -= 1.0;
        }
    }

    /// One part of the exchange: forth over all pairs and back, each exactly (Strang 1968). It is bounded for any time.
    fn exchange_part(&mut self, masses: &[f64]) {
        let LatticeExchange { pairs, moves, turned_over, .. } = &self.exchange;
        let Scratch { pair_parts, move_rates, .. } = &self.scratch;
        for (k, &threshold) in self.thresholds.iter().enumerate() {
            let (w, value) = (&mut self.survival[k], &self.value);
            let trade = |w: &mut [f64], at: usize| {
                let (pair, part) = (&pairs[at], pair_parts[at]);
                let (i, j) = (pair.i as usize, pair.j as usize);
                if value[i].max(value[j]).max(pair.demand) <= threshold {
                    let moved = part * (w[j] - w[i]);
                    w[i] += moved / masses[i];
                    w[j] -= moved / masses[j];
                }
            };
            (0..pairs.len()).for_each(|at| trade(w, at));
            // In the middle what noise takes beyond the threshold: w falls to zero at the part of the move that is inside.
            for (to, rate) in moves.iter().zip(move_rates) {
                let i = to.i as usize;
                if value[i] <= threshold && to.demand > threshold && w[i] > 0.0 {
                    let inside = (threshold - value[i]) / (to.demand - value[i]);
                    let taken = -w[i] * (-rate / inside).exp_m1();
                    self.absorbed[k] += masses[i] * taken;
                    self.unresolved[k] += if turned_over[i] { masses[i] * taken } else { 0.0 };
                    w[i] -= taken;
                }
            }
            (0..pairs.len()).rev().for_each(|at| trade(w, at));
        }
    }
}

/// The largest value of the parabola through three values `h_0` and `h_1` apart where the middle one is the largest, else
/// minus infinity.
fn peak([y_0, y_1, y_2]: [f64; 3], h_0: f64, h_1: f64) -> f64 {
    if h_0 == 0.0 || y_1 < y_0 || y_1 < y_2 {
        return f64::NEG_INFINITY;
    }
    let (left, right) = ((y_1 - y_0) / h_0, (y_2 - y_1) / h_1);
    let curvature = 2.0 * (right - left) / (h_0 + h_1);
    if curvature == 0.0 {
        return y_1;
    }
    let slope = (left * h_1 + right * h_0) / (h_0 + h_1);
    y_1 - 0.5 * slope * slope / curvature
}

#[cfg(test)]
mod tests {
    use super::peak;

    #[test]
    fn the_peak_is_that_of_the_parabola() {
        // y = 3 - 2 (t - 0.1)^2 at t = -0.5, 0, 0.4.
        let y = |t: f64| 3.0 - 2.0 * (t - 0.1) * (t - 0.1);
        assert!((peak([y(-0.5), y(0.0), y(0.4)], 0.5, 0.4) - 3.0).abs() < 1e-14);
        assert!(peak([0.0, 1.0, 2.0], 1.0, 1.0) == f64::NEG_INFINITY);
        assert!((peak([1.0, 1.0, 1.0], 1.0, 1.0) - 1.0).abs() < 1e-15);
    }
}
