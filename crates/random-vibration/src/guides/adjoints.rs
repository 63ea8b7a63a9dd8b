//! Backward functions of a response at several ends, from one pass over the steps.

use crate::guides::backward::{Backward, Stepping};
use crate::guides::regression::{Pattern, Regression, Regressions};

/// Noise of a system with `M` motions, the same at every state.
pub(crate) struct Loads<'a> {
    pub(crate) n_motions: usize,
    /// Writes `g(t)`, row by row.
    pub(crate) noise: Box<NoiseAt<'a>>,
}

/// Writes `g(t)`, row by row.
type NoiseAt<'a> = dyn Fn(f64, &mut [f64]) + Sync + 'a;

impl Loads<'_> {
    /// Writes `g^T a` of several adjoints, motion by motion: `a[i][column]`, of which the first `active` columns count.
    fn of(&self, t: f64, (a, width): (&[f64], usize), active: usize, work: &mut LoadWork) {
        let LoadWork { g, loads } = work;
        (self.noise)(t, g);
        let n = self.n_motions;
        loads.fill(0.0);
        for (a, g) in a.chunks_exact(width).zip(g.chunks_exact(n)) {
            for (loads, g) in loads.chunks_exact_mut(width).zip(g) {
                for (load, a) in loads[..active].iter_mut().zip(a) {
                    *load += g * a;
                }
            }
        }
    }
}

/// Buffers of [`Loads::of`].
struct LoadWork {
    /// `g`, row by row.
    g: Vec<f64>,
    /// Per motion and column.
    loads: Vec<f64>,
}

/// The backward functions of a weighted sum of the states after each of some numbers of steps.
///
/// The regression of a step is the same for all ends. Their adjoint states are columns of one matrix, so that one pass over
/// the entries of the regression serves them all; each column is bitwise that of its end alone.
pub(crate) fn backward_at_ends(
    loads: &Loads<'_>,
    (regressions, strength): (&Regressions, usize),
    weights: &[f64],
    (ends, stepping): (&[usize], Stepping),
) -> Vec<Backward> {
    // The latest end first, so that the columns which a step has are the first ones.
    let mut order: Vec<usize> = (0..ends.len()).collect();
    order.sort_by_key(|&column| std::cmp::Reverse(ends[column]));
    let (n, m, width) = (weights.len(), loads.n_motions, ends.len());
    let mut all: Vec<Backward> =
        ends.iter().map(|&end| Backward::empty((n, m), end, stepping)).collect();
    let mut columns = Columns {
        width,
        active: 0,
        states: vec![0.0; n * width],
        before: vec![0.0; n * width],
        terms: [vec![0.0; n * width], vec![0.0; n * width]],
        constants: vec![0.0; width],
        variances: vec![0.0; width],
        later: vec![0.0; m * width],
    };
    let mut work = LoadWork { g: vec![0.0; n * m], loads: vec![0.0; m * width] };
    let mut regression = Regression::default();
    let Stepping { dt, hold, .. } = stepping;
    let n_steps = order.first().map_or(0, |&column| ends[column]);
    for k in (0..n_steps).rev() {
        let (t, end) = (k as f64 * dt, (k + 1) as f64 * dt);
        while order.get(columns.active).is_some_and(|&column| ends[column] == k + 1) {
            columns.begin(weights, (loads, end), &mut work);
        }
        regressions.interpolate(strength, t + 0.5 * dt, &mut regression);
        columns.adjoint(&regressions.pattern, &regression, dt);
        loads.of(t, (&columns.states, width), columns.active, &mut work);
        for (place, &column) in order[..columns.active].iter().enumerate() {
            let backward = &mut all[column];
            let direction = &mut backward.directions[2 * m * k..2 * m * (k + 1)];
            for motion in 0..m {
                let earlier = work.loads[motion * width + place];
                let later = columns.later[motion * width + place];
                let w = 0.5 * (earlier + later) * dt.sqrt();
                let h = (earlier - later) * (dt / 12.0).sqrt();
                direction[motion] = w;
                direction[m + motion] = h;
                columns.variances[place] += w * w + h * h;
            }
            if k.is_multiple_of(hold) {
                let block = k / hold;
                let states = &mut backward.states[block * n..(block + 1) * n];
                for (state, row) in states.iter_mut().zip(columns.states.chunks_exact(width)) {
                    *state = row[place];
                }
                backward.constants[block] = columns.constants[place];
                backward.deviations[block] = columns.variances[place].sqrt();
            }
        }
        std::mem::swap(&mut columns.later, &mut work.loads);
    }
    all
}

/// Adjoint states of several ends, state by state: the entry of a column is at `state * width + column`.
struct Columns {
    width: usize,
    /// Number of columns whose end lies after the step.
    active: usize,
    states: Vec<f64>,
    before: Vec<f64>,
    terms: [Vec<f64>; 2],
    constants: Vec<f64>,
    variances: Vec<f64>,
    /// `g^T a` at the end of the step, motion by motion.
    later: Vec<f64>,
}

impl Columns {
    /// Adds the column of an end: its adjoint there is the weights of the response.
    fn begin(&mut self, weights: &[f64], (loads, end): (&Loads<'_>, f64), work: &mut LoadWork) {
        let (place, width) = (self.active, self.width);
        for (row, weight) in self.states.chunks_exact_mut(width).zip(weights) {
            row[place] = *weight;
        }
        self.active += 1;
        loads.of(end, (&self.states, width), self.active, work);
        for (later, load) in self.later.chunks_exact_mut(width).zip(work.loads.chunks_exact(width))
        {
            later[place] = load[place];
        }
    }

    /// Replaces `a` by `exp(A^T h) a`, by its series to fourth order, and adds to the constants.
    fn adjoint(&mut self, pattern: &Pattern, regression: &Regression, h: f64) {
        let Self { width, active, states, before, terms: [term, next], constants, .. } = self;
        let (width, active) = (*width, *active);
        let row = |i: usize| i * width..i * width + active;
        before.copy_from_slice(states);
        term.copy_from_slice(states);
        for order in 1..=4 {
            next.fill(0.0);
            for (&(i, j), slope) in pattern.iter().zip(&regression.slope) {
                for (next, term) in next[row(j)].iter_mut().zip(&term[row(i)]) {
                    *next += slope * term;
                }
            }
            for (state, (term, next)) in states.iter_mut().zip(term.iter_mut().zip(next.iter())) {
                *term = next * h / f64::from(order);
                *state += *term;
            }
        }
        for (i, mean) in regression.constant.iter().enumerate() {
            let rows = states[row(i)].iter().zip(&before[row(i)]);
            for (constant, (before, after)) in constants.iter_mut().zip(rows) {
                *constant += h * 0.5 * (before + after) * mean;
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::guides::regression::RunningLaw;

    /// A pair of states whose slope changes over time.
    fn regressions() -> Regressions {
        let regression = |k: usize| Regression {
            slope: vec![1.0, -4.0 - 0.5 * k as f64, -0.3],
            constant: vec![0.0, 0.1 * k as f64],
        };
        let laws = vec![RunningLaw::at_rest(2); 4];
        let of_strength = vec![(0..4).map(regression).collect()];
        Regressions { pattern: vec![(0, 1), (1, 0), (1, 1)], spacing: 0.5, laws, of_strength }
    }

    #[test]
    fn each_column_is_bitwise_that_of_its_end_alone() {
        let noise = |t: f64, g: &mut [f64]| g.copy_from_slice(&[0.0, 1.0 + t, 0.2, 0.1 * t]);
        let loads = Loads { n_motions: 2, noise: Box::new(noise) };
        let stepping = Stepping { dt: 0.05, hold: 3, unmodelled: 0.0 };
        let (regressions, weights) = (regressions(), [1.0, 0.2]);
        let of = |ends: &[usize]| {
            backward_at_ends(&loads, (&regressions, 0), &weights, (ends, stepping))
        };
        let ends = [7, 30, 1, 30, 12];
        for (together, end) in of(&ends).iter().zip(ends) {
            let alone = &of(&[end])[0];
            assert_eq!(together.states, alone.states, "{end}");
            assert_eq!(together.directions, alone.directions, "{end}");
            let rest = |b: &Backward| (b.constants.clone(), b.deviations.clone());
            assert_eq!(rest(together), rest(alone), "{end}");
            assert!(alone.deviations[0] > 0.0 && alone.directions.len() == 4 * end, "{end}");
        }
    }
}
