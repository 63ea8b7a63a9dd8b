//! Many bonds side by side, each for itself, whose stretches are Ornstein-Uhlenbeck paths: when do they break?

use peridyn_sde::{
    Breaking, Cause, Dynamics, Loading, Mobility, Real, Scheme, Simulation, SimulationConfig,
};
use result_figures::Measured;
use sde_integrators::Noise;

use crate::context::CaseError;
use crate::peridyn::network::{Network, lanes_of};

/// Bonds of a chain whose other nodes are held, each for itself.
pub const BONDS: usize = 500;

/// The rate seen over some relaxation times, with its standard error: the ratio of strength to deviation, the step, and the times.
/// One time is that of relaxation.
pub fn seen<T: Real, const L: usize>(
    scheme: Scheme,
    breaking: Breaking,
    (ratio, z, times): (f64, f64, f64),
) -> Result<Measured, CaseError> {
    let mut network = Network::chain(2 * BONDS - 1)?;
    for (node, free) in network.free.iter_mut().enumerate() {
        *free = node % 2 == 1;
    }
    // kT = k = 1: the deviation of a stretch is one.
    let body = lanes_of::<T, 1, L>(&network, ratio)?;
    let loading = Loading::new(network.free.len()).hold(&network.held())?;
    let mobility = Mobility::identity(&network.free, 1.0)?;
    let config = SimulationConfig {
        dynamics: Dynamics::Overdamped { mobility, temperature: 1.0, scheme },
        dt: z,
        breaking,
        confinement: 0.0,
        noise: Noise::new(23),
    };
    let ids = std::array::from_fn(|lane| lane as u64);
    let mut run = Simulation::new(body, loading, config, ids)?;
    // A free node keeps the bond to its left.
    let others: Vec<usize> = (1..2 * BONDS - 1).step_by(2).collect();
    run.cut(&others)?;
    let mut whole = (BONDS * L) as f64;
    let (mut broken, mut time) = (0.0, 0.0);
    let (settled, last) = (count(5.0 / z), count(times / z));
    for step in 0..last {
        let events = run.step()?.broken;
        let grown = events.iter().filter(|event| event.cause != Cause::Cut);
        let lost = grown.map(|event| f64::from(event.lanes.count_ones())).sum::<f64>();
        // From rest a path needs some times to forget its start.
        if step >= settled {
            broken += lost;
            time += (whole - 0.5 * lost) * z;
        }
        whole -= lost;
    }
    Ok(Measured::sampled(broken / time, broken.sqrt() / time))
}

/// A number of steps.
fn count(steps: f64) -> u64 {
    #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "a count of steps")]
    let whole = steps.round() as u64;
    whole
}
