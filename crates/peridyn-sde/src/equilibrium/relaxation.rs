//! Adaptive dynamic relaxation.

use super::solver::Stop;
use super::two_level::for_each_bond;
use crate::bonds::Bonds;
use crate::error::Error;
use crate::nodes::Nodes;

/// Adaptive dynamic relaxation of a body: explicit steps of length one with the fictitious masses of Gershgorin's bound,
/// `lambda_i = sum_j |K_ij|/4`, and the damping
///
/// $$ c^n = 2 \sqrt{\frac{u^T K^n u}{u^T u}}, \qquad K_{ii}^n = -\frac{F_i^n/\lambda_i - F_i^{n-1}/\lambda_i}{v_i^{n-1/2}} , $$
///
/// with the displacements `u` from where it begins (Kilic & Madenci 2010, eq 13 to 19).
pub(super) struct Relaxation {
    /// Components that may move.
    free: Vec<usize>,
    masses: Vec<f64>,
}

impl Relaxation {
    pub(super) fn new<const D: usize>(
        nodes: &Nodes<D>,
        bonds: &Bonds,
        weights: &[f64],
        is_free: &[bool],
    ) -> Self {
        let free = (0..is_free.len()).filter(|&component| is_free[component]).collect();
        Self { free, masses: masses(nodes, bonds, weights) }
    }

    /// Moves displacements until the residual is at most `0.7 limit` of the reaction; `evaluate` computes the residual forces at
    /// displacements, and returns the norms of residual and reaction.
    pub(super) fn relax(
        &self,
        u: &mut Vec<f64>,
        (limit, most): (f64, usize),
        mut evaluate: impl FnMut(&mut Vec<f64>, &mut Vec<f64>) -> Result<[f64; 2], Error>,
    ) -> Result<Stop, Error> {
        let Self { free, masses } = self;
        let n = masses.len();
        let (start, mut v, mut last) = (u.clone(), vec![0.0_f64; n], vec![0.0_f64; n]);
        let (mut residual, mut step) = (Vec::new(), 0);
        loop {
            let [left, reaction] = evaluate(u, &mut residual)?;
            if left <= 0.7 * limit * reaction {
                return Ok(Stop::Solved(step));
            }
            if step == most || !left.is_finite() {
                return Ok(Stop::Stalled(left));
            }
            let (mut over, mut under) = (0.0, 0.0_f64);
            for &i in free {
                let (moved, now) = (u[i] - start[i], residual[i] / masses[i]);
                if v[i].abs() > 0.0 {
                    over -= moved * moved * (now - last[i]) / v[i];
                }
                under += moved * moved;
            }
            let damping = if over > 0.0 { f64::min(2.0 * (over / under).sqrt(), 1.9) } else { 0.0 };
            for &i in free {
                let now = residual[i] / masses[i];
                v[i] = if step == 0 {
                    0.5 * now
                } else {
                    ((2.0 - damping) * v[i] + 2.0 * now) / (2.0 + damping)
                };
                last[i] = now;
                u[i] += v[i];
            }
            step += 1;
        }
    }
}

/// A quarter of the sum of each row of the stiffness.
fn masses<const D: usize>(nodes: &Nodes<D>, bonds: &Bonds, weights: &[f64]) -> Vec<f64> {
    let mut masses = vec![0.0; nodes.positions().len() * D];
    for_each_bond(nodes, bonds, weights, |(i, j), e, weight| {
        let sum: f64 = e.iter().map(|e| e.abs()).sum();
        for k in 0..D {
            let row = 0.25 * 2.0 * weight * e[k].abs() * sum;
            masses[i * D + k] += row;
            masses[j * D + k] += row;
        }
    });
    // A component that no bond resists moves by its force over the largest mass.
    let largest = masses.iter().copied().fold(0.0, f64::max);
    masses.into_iter().map(|mass| if mass > 0.0 { mass } else { largest }).collect()
}
