//! Damage with memory on bodies, by the closed form of one bond.

use peridyn_sde::law::{Bilinear, Memory};
use peridyn_sde::{
    BondConfig, Bonds, Breaking, Condition, Dynamics, Horizon, Loading, Mobility, Network, Nodes,
    Program, Scheme, Simulation, SimulationConfig,
};
use reference_problems::peridyn::network::Network as Springs;
use sde_integrators::Noise;

use crate::case::{CaseError, Context};
use crate::cases::lines::Lines;
use crate::cases::worst::Worst;
use crate::report::Claim;

/// `k`, `lambda`, `alpha(0)`; `n = m = 1`.
const LAW: (f64, f64, f64) = (800.0, 0.3, 0.9);
/// The strain of the ramp, held from 1 to 2 units of time.
const STRAIN: f64 = 2e-3;
/// Across it, over it.
const CONTRACTION: f64 = 1.0 / 3.0;

fn law() -> Result<Memory, CaseError> {
    Ok(Memory::new(LAW.0, LAW.1, (1.0, 1.0), LAW.2)?)
}

/// `ln(alpha/(1 - alpha))` falls by the exposure.
fn left(exposure: f64) -> f64 {
    1.0 / (1.0 + (1.0 - LAW.2) / LAW.2 * exposure.exp())
}

/// The exposure of a bond under the ramp and the hold, by its stretch at a strain: Simpson's rule over the ramp.
fn exposure(stretch: impl Fn(f64) -> f64) -> f64 {
    const PANELS: u32 = 1000;
    let rate = |t: f64| LAW.1 * (LAW.0 * stretch(STRAIN * t)).exp();
    let weighed = (0..=2 * PANELS).map(|at| {
        let weight = if at == 0 || at == 2 * PANELS { 1.0 } else { 2.0 + 2.0 * f64::from(at % 2) };
        weight * rate(f64::from(at) / f64::from(2 * PANELS))
    });
    weighed.sum::<f64>() / f64::from(6 * PANELS) + rate(1.0)
}

/// Steps of the ramp, and as many of the hold.
const STEPS: u32 = 32;

/// Damage of each node of a body, and the force across its middle.
struct Worn {
    damage: Vec<f64>,
    resultant: f64,
}

/// A block of 9 x 9 nodes, all of which are moved.
pub(super) fn block(context: &Context<'_>) -> Result<[Claim; 2], CaseError> {
    let condition = Condition::PlaneStress { thickness: 1.0 };
    let nodes = Nodes::lattice(1.0, ([0.0; 2], [9.0; 2]), condition, |_| true)?;
    let config = BondConfig::uncorrected(Horizon::of_shells(3, 1.0)?, 1.0);
    let bonds = Bonds::new(&nodes, &config)?;
    let (x, stiffness) = (nodes.positions().to_vec(), bonds.all()[0].stiffness);
    let found = worn_in_steps(nodes, bonds)?;
    let exact = worn_by_pairs(&x, stiffness);
    let mut worst = Worst::default();
    for (node, (damage, exact)) in found.damage.iter().zip(&exact.damage).enumerate() {
        worst.take(damage - exact, &format!("node {node}"));
    }
    let method = format!(
        "9 x 9 nodes, horizon 3.015 dx, n = m = 1, ramp to 2e-3 and hold, {STEPS} steps each"
    );
    let reason = "second order: between the ends of a step the stretch of a slanting bond bends by 1e-6 of its strain over the square of the steps";
    Ok([
        Lines { context, id: "block", method: worst.method(&method) }.bounded(
            ("damage", "largest error of the damage of a node against the sum of its bonds", ""),
            worst.value(),
            1e-8,
            reason,
        ),
        Lines { context, id: "block", method }.relative(
            ("resultant", "force across the middle of the block", ""),
            found.resultant,
            exact.resultant,
            1e-8,
            reason,
        ),
    ])
}

fn is_upper(x: &[f64; 2]) -> bool {
    x[1] > 5.0
}

fn worn_in_steps(nodes: Nodes<2>, bonds: Bonds) -> Result<Worn, CaseError> {
    let (x, strengths) = (nodes.positions().to_vec(), vec![1.0; bonds.len()]);
    let mut body = Network::new(nodes, bonds, law()?, strengths)?;
    let at = |t: f64| -> Vec<[f64; 2]> {
        let strain = STRAIN * t.min(1.0);
        x.iter().map(|x| [-CONTRACTION * strain * x[0], strain * x[1]]).collect()
    };
    let dt = 1.0 / f64::from(STEPS);
    for step in 0..2 * STEPS {
        let t = dt * f64::from(step);
        body.advance(&at(t), &at(t + dt), dt)?;
    }
    let mut forces = vec![[0.0; 2]; x.len()];
    let _ = body.forces(&at(2.0), &mut forces)?;
    let upper = x.iter().zip(&forces).filter(|(x, _)| is_upper(x));
    Ok(Worn { damage: body.damage(), resultant: -upper.map(|(_, force)| force[1]).sum::<f64>() })
}

/// The same pair by pair, from the places alone.
fn worn_by_pairs(x: &[[f64; 2]], stiffness: f64) -> Worn {
    let (mut lost, mut count, mut resultant) = (vec![0.0; x.len()], vec![0.0; x.len()], 0.0);
    for i in 0..x.len() {
        for j in i + 1..x.len() {
            let (a, b) = (x[j][0] - x[i][0], x[j][1] - x[i][1]);
            let length = a.hypot(b);
            if length > 3.015 {
                continue;
            }
            let stretch = |strain: f64| {
                let (a, b) = (a * (1.0 - CONTRACTION * strain), b * (1.0 + strain));
                a.hypot(b) / length - 1.0
            };
            let alpha = left(exposure(stretch));
            for node in [i, j] {
                lost[node] += 1.0 - alpha;
                count[node] += 1.0;
            }
            if is_upper(&x[i]) != is_upper(&x[j]) {
                let s = stretch(STRAIN);
                let upright = b.abs() * (1.0 + STRAIN) / (length * (1.0 + s));
                resultant += stiffness * alpha * s * upright;
            }
        }
    }
    Worn { damage: lost.iter().zip(&count).map(|(lost, count)| lost / count).collect(), resultant }
}

/// A bar whose inner nodes are free: its bonds stay as stretched as the bar.
pub(super) fn bar(context: &Context<'_>) -> Result<Claim, CaseError> {
    const IN_TIME: u32 = 64;
    let chain = Springs::chain(10)?;
    let last = chain.free.len() - 1;
    let free: Vec<bool> = (0..=last).map(|node| node > 0 && node < last).collect();
    let strengths = vec![1.0; chain.bonds.len()];
    let body = Network::new(chain.nodes.clone(), chain.bonds.clone(), law()?, strengths)?;
    let dynamics = Dynamics::Overdamped {
        mobility: Mobility::identity(&free, 1.0)?,
        temperature: 0.0,
        scheme: Scheme::EulerMaruyama,
    };
    let dt = 1.0 / f64::from(IN_TIME);
    let (breaking, confinement, noise) = (Breaking::AtEnds, 0.0, Noise::new(0));
    let config = SimulationConfig { dynamics, dt, breaking, confinement, noise };
    let program = Program::Ramp { rate: STRAIN, until: 1.0 };
    let loading =
        Loading::new(free.len()).stretch(&chain.nodes, &[0, last], [true], [[1.0]], program)?;
    let mut run = Simulation::new(body, loading, config, [0])?;
    // The forces of a step are those of its start: one step beyond the time 2.
    for _ in 0..=2 * IN_TIME {
        let _ = run.step()?;
    }
    let alpha = left(exposure(|strain| strain));
    let method = format!(
        "11 nodes in a row, nine of them free and at rest, n = m = 1, ramp to 2e-3 and hold, {IN_TIME} Euler steps each, kT = 0"
    );
    Ok(Lines { context, id: "bar", method }.relative(
        ("pull", "force on the prescribed end", ""),
        -run.pull_on(&[last], 0)[0],
        chain.bonds.all()[0].stiffness * alpha * STRAIN,
        1e-11,
        "roundoff: the step is exact on straight lines of strain; the strain is a difference of places of 10, 1e-15 of 2e-3, and its exponential 800 times that",
    ))
}

/// One bond of the bilinear law, of strength 1e-3 and ductility 4, pulled into its softening, unloaded to compression, pulled
/// until it fails and beyond.
pub(super) fn softening(context: &Context<'_>) -> Result<Claim, CaseError> {
    const STRENGTH: f64 = 1e-3;
    const LAST: f64 = 4.0 * STRENGTH;
    const TURN: f64 = 2.5 * STRENGTH;
    let nodes = Nodes::lattice(1.0, ([0.0], [2.0]), Condition::Bar { area: 1.0 }, |_| true)?;
    let config = BondConfig::uncorrected(Horizon::of_shells(1, 1.0)?, 1.0);
    let bonds = Bonds::new(&nodes, &config)?;
    let stiffness = bonds.all()[0].stiffness;
    let mut body = Network::new(nodes, bonds, Bilinear::new(LAST / STRENGTH)?, vec![STRENGTH])?;
    // On first loading the tension falls on a line; unloading goes to the origin, and compression is elastic.
    let envelope = |s: f64| if s <= STRENGTH { s } else { (LAST - s).max(0.0) / 3.0 };
    let up = |s: f64| (s, envelope(s));
    let back = |s: f64| (s, if s < 0.0 { s } else { s / TURN * envelope(TURN) });
    let parts = (0..=100).map(|part| f64::from(part) / 100.0);
    let path = (parts.clone().map(|part| up(TURN * part)))
        .chain(parts.clone().map(|part| back(TURN - (TURN + STRENGTH) * part)))
        .chain(parts.clone().map(|part| back(-STRENGTH + (TURN + STRENGTH) * part)))
        .chain(parts.map(|part| up(TURN + (1.5 * LAST - TURN) * part)));
    let (mut worst, mut before) = (Worst::default(), [[0.0]; 2]);
    for (s, expected) in path {
        let u = [[0.0], [s]];
        body.advance(&before, &u, 1.0)?;
        let mut forces = [[0.0]; 2];
        let _ = body.forces(&u, &mut forces)?;
        worst.take(
            forces[0][0] / (stiffness * STRENGTH) - expected / STRENGTH,
            &format!("s = {s:e}"),
        );
        before = u;
    }
    let method =
        worst.method("one bond, strength 1e-3, ductility 4: to 2.5e-3, to -1e-3, beyond 4e-3");
    Ok(Lines { context, id: "softening", method }.bounded(
        (
            "force",
            "largest error of the force of a bilinear bond against its closed form, over its peak",
            "",
        ),
        worst.value(),
        5e-15,
        "roundoff: some ten operations; the ends of the bond are at 0 and 1, so its elongation is exact",
    ))
}
