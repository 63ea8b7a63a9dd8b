//! Adaptive dynamic relaxation.

use super::statics::{Forces, Statics};
use crate::body::Body;
use crate::error::Error;

/// Moves a body to equilibrium by explicit steps of length one with the fictitious masses of Gershgorin's bound,
/// `lambda_i = sum_j |K_ij|/4`, and the damping
///
/// $$ c^n = 2 \sqrt{\frac{u^T K^n u}{u^T u}}, \qquad K_{ii}^n = -\frac{F_i^n/\lambda_i - F_i^{n-1}/\lambda_i}{v_i^{n-1/2}} , $$
///
/// with the displacements `u` from where it begins (Kilic & Madenci 2010, eq 13 to 19). Returns the steps.
pub(super) fn relax<const D: usize>(
    statics: &mut Statics<D>,
    body: &mut dyn Body<f64, D, 1>,
    (load, limit): (f64, f64),
    forces: Forces,
) -> Result<usize, Error> {
    let masses = masses(statics, body);
    let n = masses.len();
    let free: Vec<usize> = (0..n).filter(|&i| statics.is_free(i)).collect();
    let (start, mut v, mut last) = (statics.u.clone(), vec![0.0_f64; n], vec![0.0_f64; n]);
    for step in 0..statics.config.most_iterations {
        let [left, reaction] = statics.residual(body, forces)?;
        if left <= 0.7 * limit * reaction {
            return Ok(step);
        }
        if !left.is_finite() {
            return Err(Error::NotInEquilibrium { load, residual: left, iterations: step, limit });
        }
        let (mut over, mut under) = (0.0, 0.0_f64);
        for &i in &free {
            let moved = statics.u[i] - start[i];
            let now = statics.residual_at(i) / masses[i];
            if v[i].abs() > 0.0 {
                over -= moved * moved * (now - last[i]) / v[i];
            }
            under += moved * moved;
        }
        let damping = if over > 0.0 { f64::min(2.0 * (over / under).sqrt(), 1.9) } else { 0.0 };
        for &i in &free {
            let now = statics.residual_at(i) / masses[i];
            v[i] = if step == 0 {
                0.5 * now
            } else {
                ((2.0 - damping) * v[i] + 2.0 * now) / (2.0 + damping)
            };
            last[i] = now;
            statics.u[i] += v[i];
        }
    }
    let [left, reaction] = statics.residual(body, forces)?;
    let (residual, iterations) = (left / reaction, statics.config.most_iterations);
    Err(Error::NotInEquilibrium { load, residual, iterations, limit })
}

/// A quarter of the sum of each row of the stiffness.
fn masses<const D: usize>(statics: &Statics<D>, body: &dyn Body<f64, D, 1>) -> Vec<f64> {
    let n = body.nodes().positions().len();
    let mut masses = vec![0.0; n * D];
    super::two_level::for_each_bond(
        body.nodes(),
        body.bonds(),
        &statics.weights,
        |(i, j), e, weight| {
            let sum: f64 = e.iter().map(|e| e.abs()).sum();
            for k in 0..D {
                let row = 0.25 * 2.0 * weight * e[k].abs() * sum;
                masses[i * D + k] += row;
                masses[j * D + k] += row;
            }
        },
    );
    // A component that no bond resists moves by its force over the largest mass.
    let largest = masses.iter().copied().fold(0.0, f64::max);
    masses.into_iter().map(|mass| if mass > 0.0 { mass } else { largest }).collect()
}
