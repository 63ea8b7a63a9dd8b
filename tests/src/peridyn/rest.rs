//! Bodies at rest under loads that balance.

use peridyn_sde::{Bonds, Nodes};

use crate::case::CaseError;

/// Displacements (length) of a free body whose bonds are linear, under loads (force) that balance: conjugate gradients to a
/// residual of 1e-13 of the loads, from rest. Its rigid motions are not determined.
///
/// # Errors
/// Where that is not reached in 20,000 steps.
pub fn displacements<const D: usize>(
    nodes: &Nodes<D>,
    bonds: &Bonds,
    loads: &[[f64; D]],
) -> Result<Vec<[f64; D]>, CaseError> {
    let springs = springs(nodes, bonds);
    let mut u = vec![[0.0; D]; loads.len()];
    let (mut residual, mut search) = (loads.to_vec(), loads.to_vec());
    let mut square = dot(&residual, &residual);
    let target = 1e-26 * square;
    for _ in 0..20_000 {
        if square < target {
            return Ok(u);
        }
        let image = pulls(&springs, &search);
        let step = square / dot(&search, &image);
        add(&mut u, step, &search);
        add(&mut residual, -step, &image);
        let next = dot(&residual, &residual);
        for (search, residual) in search.iter_mut().zip(&residual) {
            *search = std::array::from_fn(|k| residual[k] + next / square * search[k]);
        }
        square = next;
    }
    Err(format!("conjugate gradients: residual {square:e} of {target:e}").into())
}

/// A bond: its ends, its direction, its stiffness over its length.
type Spring<const D: usize> = ((usize, usize), [f64; D], f64);

fn springs<const D: usize>(nodes: &Nodes<D>, bonds: &Bonds) -> Vec<Spring<D>> {
    let x = nodes.positions();
    let spring = |((i, j), bond): ((usize, usize), &peridyn_sde::Bond)| {
        let direction = std::array::from_fn(|k| (x[j][k] - x[i][k]) / bond.length);
        ((i, j), direction, bond.stiffness / bond.length)
    };
    bonds.pairs().zip(bonds.all()).map(spring).collect()
}

/// `K u`.
fn pulls<const D: usize>(springs: &[Spring<D>], u: &[[f64; D]]) -> Vec<[f64; D]> {
    let mut forces = vec![[0.0; D]; u.len()];
    for &((i, j), n, stiffness) in springs {
        let along: f64 = (0..D).map(|k| n[k] * (u[j][k] - u[i][k])).sum();
        for k in 0..D {
            let tension = stiffness * along * n[k];
            forces[i][k] -= tension;
            forces[j][k] += tension;
        }
    }
    forces
}

fn dot<const D: usize>(a: &[[f64; D]], b: &[[f64; D]]) -> f64 {
    a.as_flattened().iter().zip(b.as_flattened()).map(|(a, b)| a * b).sum()
}

fn add<const D: usize>(to: &mut [[f64; D]], factor: f64, what: &[[f64; D]]) {
    for (to, what) in to.as_flattened_mut().iter_mut().zip(what.as_flattened()) {
        *to += factor * what;
    }
}
