//! A stretched body: its transverse bond stiffness exceeds that of the initial step check.

use nalgebra::DMatrix;
use peridyn_sde::{
    BondList, Breaking, Dynamics, Loading, Mobility, Program, Scheme, Simulation, SimulationConfig,
    Strain,
};
use result_figures::{Drawing, Scale};
use sde_integrators::Noise;

use super::super::modes;
use crate::context::CaseError;
use crate::problems::peridyn::network::Network;
use crate::stability::axes::{linear, words};
use crate::stability::{Panel, Work};

/// Steps during the stretching, and steps after it.
const STEPS: [u64; 2] = [200, 8000];
/// Distance from the uniform stretch, in spacings.
const TOLERANCE: f64 = 0.01;
/// `kT` over the stiffness of a bond (spacings squared): the perturbation from which an instability grows.
const TEMPERATURE: f64 = 1e-16;

/// A square whose two outer layers on each side follow a uniform stretch.
fn plate() -> Result<Network<2>, CaseError> {
    let side = 9;
    let mut network = Network::square(side, 2)?;
    let (low, high) = (2.0, side as f64 - 2.0);
    for (free, x) in network.free.iter_mut().zip(network.nodes.positions()) {
        *free = x.iter().all(|&c| c > low && c < high);
    }
    Ok(network)
}

/// Stiffest mode of the free nodes at a uniform stretch.
///
/// A bond adds `k n n^T` along and `k (1 - 1/(1 + e))` across itself.
fn stiffest(network: &Network<2>, stretch: f64) -> Result<f64, CaseError> {
    let unknowns = network.unknowns();
    let mut number = vec![None; network.free.len() * 2];
    for (at, &(node, k)) in unknowns.iter().enumerate() {
        number[node * 2 + k] = Some(at);
    }
    let mut matrix = DMatrix::zeros(unknowns.len(), unknowns.len());
    let across = stretch / (1.0 + stretch);
    for ((i, j), of) in network.bonds.pairs().zip(network.bonds.all()) {
        let (a, b) = (network.nodes.positions()[i], network.nodes.positions()[j]);
        for k in 0..2 {
            for l in 0..2 {
                let along = (b[k] - a[k]) * (b[l] - a[l]) / (of.length * of.length);
                let one = f64::from(k == l);
                let entry = of.stiffness / of.length * (along + across * (one - along));
                for (p, q, sign) in [(i, i, 1.0), (j, j, 1.0), (i, j, -1.0), (j, i, -1.0)] {
                    if let (Some(row), Some(column)) = (number[p * 2 + k], number[q * 2 + l]) {
                        matrix[(row, column)] += sign * entry;
                    }
                }
            }
        }
    }
    Ok(modes(matrix)?.pop().ok_or("a plate without a mode")?.0)
}

/// Largest distance of a node from the uniform stretch, in spacings.
fn follow(
    network: &Network<2>,
    (stretch, dt): (f64, f64),
    work: &mut Work,
) -> Result<f64, CaseError> {
    let strengths = vec![1e6; network.bonds.len()];
    let (nodes, bonds) = (network.nodes.clone(), network.bonds.clone());
    let body = BondList::<f64, 2, 1>::new(nodes, bonds, Strain::Finite, &strengths)?;
    let until = STEPS[0] as f64 * dt;
    let ramp = Program::Ramp { rate: stretch / until, until };
    let (n, one) = (network.free.len(), [[1.0, 0.0], [0.0, 1.0]]);
    let loading = Loading::new(n).stretch(&network.nodes, &network.held(), [true; 2], one, ramp)?;
    let (mobility, scheme) = (Mobility::identity(&network.free, 1.0)?, Scheme::EulerMaruyama);
    let config = SimulationConfig {
        dynamics: Dynamics::Overdamped { mobility, temperature: TEMPERATURE, scheme },
        dt,
        breaking: Breaking::AtEnds,
        confinement: 0.0,
        noise: Noise::new(1),
    };
    let mut run = Simulation::new(body, loading, config, [0])?;
    for steps in STEPS {
        work.spend(steps)?;
        for _ in 0..steps {
            let _ = run.step()?;
        }
    }
    let nodes = run.displacements(0).into_iter().zip(network.nodes.positions());
    let off = nodes.flat_map(|(u, x)| [0, 1].map(|k| (u[k] - stretch * x[k]).abs()));
    Ok(off.fold(0.0, f64::max))
}

pub(super) fn map(is_quick: bool) -> Result<Drawing, CaseError> {
    let network = plate()?;
    let at_rest = stiffest(&network, 0.0)?;
    let limit = |stretch: f64| Some(2.0 * at_rest / stiffest(&network, stretch).ok()?);
    let run =
        |stretch: f64, z: f64, work: &mut Work| follow(&network, (stretch, z / at_rest), work);
    let [across, upwards] = if is_quick { [3, 4] } else { [7, 8] };
    let panel = Panel {
        name: "peridyn-z-stretched".into(),
        words: words(
            "A step that is stable at rest is not stable in a body that is stretched far".into(),
            "plate of 9 x 9 nodes, finite strain, unbreakable bonds, Euler's method, hardly any noise; distance from the uniform stretch, in spacings",
            ["uniform stretch of the plate", "z = h M λ of the stiffest mode at rest"],
            "Boundary: z λ(stretch)/λ(rest) = 2, since tension makes a bond stiff across itself. The initial check uses the body at rest: z of 2 and more is rejected. Later instability, in which nodes swing through each other by about a spacing, ends in an error that names node and step.",
        ),
        scale: Scale::Linear,
        across: linear(across, 0.0, 3.0),
        upwards: linear(upwards, 0.6, 2.3),
        boundary: Some(("stability limit of the stretched plate", &limit)),
        tolerance: TOLERANCE,
        work_limit: STEPS.iter().sum(),
        run: &run,
    };
    Ok(panel.sweep()?)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The boundary is a theorem: no accurate run outside it, and no failed run inside it.
    #[test]
    fn no_run_contradicts_the_boundary_and_what_is_refused_says_why() {
        let drawing = map(true).unwrap();
        assert!(drawing.table.contains("0 against the prediction"), "{}", drawing.table);
        assert!(drawing.data.contains("in units of the stiffest mode"));
        assert!(drawing.data.contains("the body swings"));
    }
}
