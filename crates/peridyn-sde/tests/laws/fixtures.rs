//! What several laws start from.

use peridyn_sde::{
    BondConfig, Bonds, Breaking, Condition, Dynamics, Horizon, Mobility, Nodes, Scheme,
    SimulationConfig,
};
use sde_integrators::Noise;

/// A plate of the thickness 1.
pub(crate) const PLATE: Condition = Condition::PlaneStress { thickness: 1.0 };

/// Bonds of Young's modulus 1 within so many shells of a lattice of spacing 1, without corrections.
pub(crate) fn config(shells: u32) -> BondConfig {
    BondConfig::uncorrected(Horizon::of_shells(shells, 1.0).unwrap(), 1.0)
}

/// A lattice of spacing 1 from the origin to `side` along each axis.
pub(crate) fn cube<const D: usize>(side: f64, condition: Condition) -> Nodes<D> {
    Nodes::lattice(1.0, ([0.0; D], [side; D]), condition, |_| true).unwrap()
}

/// A lattice with the bonds of [`config`].
pub(crate) fn bonded<const D: usize>(
    side: f64,
    condition: Condition,
    shells: u32,
) -> (Nodes<D>, Bonds) {
    let nodes = cube(side, condition);
    let bonds = Bonds::new(&nodes, &config(shells)).unwrap();
    (nodes, bonds)
}

/// The nodes at such places.
pub(crate) fn at<const D: usize>(
    nodes: &Nodes<D>,
    wanted: impl Fn(&[f64; D]) -> bool,
) -> Vec<usize> {
    let positions = nodes.positions();
    (0..positions.len()).filter(|&node| wanted(&positions[node])).collect()
}

/// Small displacements without a pattern.
pub(crate) fn shaken<const D: usize>(n: usize, size: f64) -> Vec<[f64; D]> {
    let wave = |node: usize, k: usize| (1.7 * node as f64 + 2.3 * k as f64 + 0.4).sin();
    (0..n).map(|node| std::array::from_fn(|k| size * wave(node, k))).collect()
}

pub(crate) fn overdamped(free: &[bool], scheme: Scheme, temperature: f64) -> Dynamics {
    Dynamics::Overdamped { mobility: Mobility::identity(free, 1.0).unwrap(), temperature, scheme }
}

/// A run in time whose bonds are looked at where a step ends.
pub(crate) fn in_time(dynamics: Dynamics, dt: f64, seed: u64) -> SimulationConfig {
    let (breaking, confinement, noise) = (Breaking::AtEnds, 0.0, Noise::new(seed));
    SimulationConfig { dynamics, dt, breaking, confinement, noise }
}

/// The displacements in which forces that are linear in them balance a load: conjugate gradients from rest to a residual of
/// which the square is this part of that of the load.
pub(crate) fn at_rest(
    load: &[f64],
    part: f64,
    mut forces: impl FnMut(&[f64], &mut [f64]),
) -> Vec<f64> {
    let dot = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
    let (mut u, mut residual) = (vec![0.0; load.len()], load.to_vec());
    let (mut search, mut image) = (load.to_vec(), load.to_vec());
    let mut square = dot(&residual, &residual);
    let end = part * square;
    for _ in 0..20_000 {
        if square < end {
            return u;
        }
        forces(&search, &mut image);
        let step = -square / dot(&search, &image);
        for at in 0..load.len() {
            u[at] += step * search[at];
            residual[at] += step * image[at];
        }
        let next = dot(&residual, &residual);
        for at in 0..load.len() {
            search[at] = residual[at] + next / square * search[at];
        }
        square = next;
    }
    panic!("no convergence: {square:e} of {end:e}");
}

/// The rows of a table of references.
pub(crate) fn rows(value: &serde_json::Value) -> Vec<[f64; 3]> {
    let row = |row: &serde_json::Value| std::array::from_fn(|k| row[k].as_f64().unwrap());
    value.as_array().unwrap().iter().map(row).collect()
}
