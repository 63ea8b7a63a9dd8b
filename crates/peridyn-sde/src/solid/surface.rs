//! What bonds near a surface lack in a linear peridynamic solid.

use super::moduli::Moduli;
use crate::bodies::bonds::Bonds;
use crate::bodies::nodes::Nodes;
use crate::bodies::surface::{direction, factors_of};
use crate::error::Error;

/// The factors of bonds by which each node has the dilatation 1 under a unit strain along each axis.
pub(super) fn factors<const D: usize>(
    nodes: &Nodes<D>,
    bonds: &Bonds,
    (weights, m): (&[f64], &[f64]),
) -> Vec<f64> {
    let (v, dimension) = (nodes.volumes(), D as f64);
    let mut dilatations = vec![[0.0; D]; bonds.n_nodes()];
    for (((i, j), of), weight) in bonds.pairs().zip(bonds.all()).zip(weights) {
        let along = direction(nodes, (i, j), of.length);
        for k in 0..D {
            let part = dimension * weight * (of.length * along[k]).powi(2);
            for node in [i, j] {
                dilatations[node][k] += part / (m[node] * v[node]);
            }
        }
    }
    factors_of(nodes, bonds, &dilatations)
}

/// Whether no deformation has a negative energy. By the inequality of Cauchy and Schwarz that of a node is at least
/// `(B + D^2 A c)/(2 m)` times a sum of squares, with `c = sum omega beta g |xi|^2 V/m`, 1 without factors `g` of bonds.
pub(super) fn check<const D: usize>(
    nodes: &Nodes<D>,
    bonds: &Bonds,
    (weights, m): (&[f64], &[f64]),
    moduli: Moduli,
) -> Result<(), Error> {
    let (v, mut c) = (nodes.volumes(), vec![0.0; bonds.n_nodes()]);
    for (((i, j), of), weight) in bonds.pairs().zip(bonds.all()).zip(weights) {
        let part = weight * of.length * of.length;
        c[i] += part / (m[i] * v[i]);
        c[j] += part / (m[j] * v[j]);
    }
    let least = |c: f64| moduli.b + (D * D) as f64 * moduli.a * c;
    match c.iter().position(|&c| least(c).is_nan() || least(c) <= 0.0) {
        Some(node) => Err(Error::Node {
            name: "the bound B + D^2 A c of the energy",
            node,
            value: least(c[node]),
            must: "greater than 0: use no surface correction",
        }),
        None => Ok(()),
    }
}
