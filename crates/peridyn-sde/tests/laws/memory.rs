//! Bodies of bonds that wear out, against the closed form of one bond.

use peridyn_sde::law::Memory;
use peridyn_sde::{Bonds, Condition, Loading, Network, Nodes, Program, Scheme, Simulation};

use crate::fixtures::{PLATE, bonded, config, in_time, overdamped};

/// `k`, `lambda`, `alpha(0)`.
const SENSITIVITY: f64 = 800.0;
const RATE: f64 = 0.3;
const START: f64 = 0.9;

fn law() -> Memory {
    Memory::new(SENSITIVITY, RATE, (1.0, 1.0), START).unwrap()
}

/// The strain of the ramp, held from 1 to 2 units of time.
const STRAIN: f64 = 2e-3;

/// With `n = m = 1`, `ln(alpha/(1 - alpha))` falls by the exposure.
fn left(exposure: f64) -> f64 {
    1.0 / (1.0 + (1.0 - START) / START * exposure.exp())
}

/// The exposure of a bond under the ramp and the hold, by its stretch at a strain: Simpson's rule over the ramp.
fn exposure(stretch: impl Fn(f64) -> f64) -> f64 {
    const PANELS: u32 = 1000;
    let rate = |t: f64| RATE * (SENSITIVITY * stretch(STRAIN * t)).exp();
    let weighed = (0..=2 * PANELS).map(|at| {
        let weight = if at == 0 || at == 2 * PANELS { 1.0 } else { 2.0 + 2.0 * f64::from(at % 2) };
        weight * rate(f64::from(at) / f64::from(2 * PANELS))
    });
    weighed.sum::<f64>() / f64::from(6 * PANELS) + rate(1.0)
}

/// 9 x 9 nodes, all of which are moved, against sums pair by pair from the places alone. Between the ends of a step the stretch of
/// a slanting bond bends by 1e-6 of its strain over the square of the steps.
#[test]
fn a_worn_block_has_the_damage_and_the_force_of_its_pairs() {
    const STEPS: u32 = 32;
    const CONTRACTION: f64 = 1.0 / 3.0;
    let (nodes, bonds) = bonded(9.0, PLATE, 3);
    let (x, stiffness) = (nodes.positions().to_vec(), bonds.all()[0].stiffness);
    let is_upper = |x: &[f64; 2]| x[1] > 5.0;

    let (mut lost, mut count, mut resultant) = (vec![0.0; x.len()], vec![0.0; x.len()], 0.0);
    for (i, j) in (0..x.len()).flat_map(|i| (i + 1..x.len()).map(move |j| (i, j))) {
        let (a, b) = (x[j][0] - x[i][0], x[j][1] - x[i][1]);
        let length = a.hypot(b);
        if length > 3.015 {
            continue;
        }
        let stretch = |strain: f64| {
            (a * (1.0 - CONTRACTION * strain)).hypot(b * (1.0 + strain)) / length - 1.0
        };
        let alpha = left(exposure(stretch));
        for node in [i, j] {
            lost[node] += 1.0 - alpha;
            count[node] += 1.0;
        }
        if is_upper(&x[i]) != is_upper(&x[j]) {
            let s = stretch(STRAIN);
            resultant += stiffness * alpha * s * b.abs() * (1.0 + STRAIN) / (length * (1.0 + s));
        }
    }

    let strengths = vec![1.0; bonds.len()];
    let mut body = Network::new(nodes, bonds, law(), strengths).unwrap();
    let at = |t: f64| -> Vec<[f64; 2]> {
        let strain = STRAIN * t.min(1.0);
        x.iter().map(|x| [-CONTRACTION * strain * x[0], strain * x[1]]).collect()
    };
    let dt = 1.0 / f64::from(STEPS);
    for step in 0..2 * STEPS {
        let t = dt * f64::from(step);
        body.advance(&at(t), &at(t + dt), dt).unwrap();
    }
    for (node, damage) in body.damage().into_iter().enumerate() {
        let off = damage - lost[node] / count[node];
        assert!(off.abs() < 1e-8, "node {node}: {off:e}");
    }
    let mut forces = vec![[0.0; 2]; x.len()];
    let _ = body.forces(&at(2.0), &mut forces).unwrap();
    let upper = x.iter().zip(&forces).filter(|(x, _)| is_upper(x));
    let off = -upper.map(|(_, force)| force[1]).sum::<f64>() / resultant - 1.0;
    assert!(off.abs() < 1e-8, "{off:e}");
}

/// Eleven nodes in a row, nine of them free: the bonds stay as stretched as the bar. The strain is a difference of places of 10,
/// 1e-15 of 2e-3, and its exponential 800 times that.
#[test]
fn a_worn_bar_pulls_with_what_its_bonds_have_left() {
    const STEPS: u32 = 64;
    let condition = Condition::Bar { area: 1.0 };
    let nodes = Nodes::lattice(1.0, ([-0.5], [10.5]), condition, |_| true).unwrap();
    let bonds = Bonds::new(&nodes, &config(1)).unwrap();
    let (last, stiffness) = (nodes.positions().len() - 1, bonds.all()[5].stiffness);
    let free: Vec<bool> = (0..=last).map(|node| node > 0 && node < last).collect();
    let strengths = vec![1.0; bonds.len()];
    let body = Network::new(nodes.clone(), bonds, law(), strengths).unwrap();
    let dynamics = overdamped(&free, Scheme::EulerMaruyama, 0.0);
    let config = in_time(dynamics, 1.0 / f64::from(STEPS), 0);
    let program = Program::Ramp { rate: STRAIN, until: 1.0 };
    let loading =
        Loading::new(free.len()).stretch(&nodes, &[0, last], [true], [[1.0]], program).unwrap();
    let mut run = Simulation::new(body, loading, config, [0]).unwrap();
    // The forces of a step are those of its start: one step beyond the time 2.
    for _ in 0..=2 * STEPS {
        let _ = run.step().unwrap();
    }
    let expected = stiffness * left(exposure(|strain| strain)) * STRAIN;
    let off = -run.pull_on(&[last], 0)[0] / expected - 1.0;
    assert!(off.abs() < 1e-11, "{off:e}");
}
