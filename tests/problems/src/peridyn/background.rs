//! Plates in noise and without load: how many bonds break, and how many should.

use nalgebra::{DMatrix, DVector};
use peridyn_sde::{
    Bond, Breaking, Dynamics, Error, Mobility, Real, Scheme, Simulation, SimulationConfig,
};
use result_figures::Measured;
use sde_integrators::{Noise, Purpose};

use super::network::{Network, lanes, lanes_of, rate as stiffest};
use super::sample::mean;
use crate::context::CaseError;

/// Realisations side by side.
pub const LANES: usize = 8;

/// Beyond so many deviations a bond does not break.
pub const MOST_DEVIATIONS: f64 = 9.0;

/// `kT` at which the strength is so many deviations of a bond: `kT dof = sigma^2 kappa` over all bonds, as of equal shares
/// of the energy.
#[must_use]
pub fn temperature(network: &Network<2>, strength: f64, ratio: f64) -> f64 {
    let stiffness = network.bonds.all()[0].stiffness;
    let sigma = strength / ratio;
    sigma * sigma * stiffness * network.bonds.len() as f64 / network.n_unknowns() as f64
}

/// Bonds broken in each lane until some ascending times, in units of one over `lambda` of the stiffest mode; and `lambda`. With the
/// bridge, by steps of `z`.
pub fn broken(
    network: &Network<2>,
    (strength, ratio): (f64, f64),
    (z, times): (f64, &[f64]),
    scheme: Scheme,
) -> Result<(Vec<[f64; LANES]>, f64), Error> {
    let dynamics = Dynamics::Overdamped {
        mobility: Mobility::identity(&network.free, 1.0)?,
        temperature: temperature(network, strength, ratio),
        scheme,
    };
    let rate = stiffest(network, &dynamics)?;
    let config = SimulationConfig {
        dynamics,
        dt: z / rate,
        breaking: Breaking::Bridge,
        confinement: 0.0,
        noise: Noise::new(3),
    };
    let body = lanes::<2, LANES>(network, strength)?;
    let ids = std::array::from_fn(|lane| lane as u64);
    let mut run = Simulation::new(body, network.loading()?, config, ids)?;
    let (mut lost, mut seen) = ([0.0; LANES], Vec::new());
    for time in times {
        #[allow(
            clippy::cast_possible_truncation,
            clippy::cast_sign_loss,
            reason = "a count of steps"
        )]
        let steps = (time / z).round() as u64;
        while run.steps() < steps {
            for event in run.step()?.broken {
                for lane in (0..LANES).filter(|lane| event.lanes & 1 << lane != 0) {
                    lost[lane] += 1.0;
                }
            }
        }
        seen.push(lost);
    }
    Ok((seen, rate))
}

/// Bonds broken per time (1/time), mean over realisations that each start in equilibrium and are followed for a time in units of one
/// over `lambda`, and that time; few bonds are lost if it is short. With the bridge, by steps of `z`, `L` realisations side by side in each of
/// some batches.
///
/// # Errors
/// Those of the run; where the network is singular.
pub fn rate_in_equilibrium<T: Real, const L: usize>(
    network: &Network<2>,
    (strength, ratio): (f64, f64),
    (z, time): (f64, f64),
    batches: u64,
) -> Result<(Measured, f64), CaseError> {
    let kt = temperature(network, strength, ratio);
    let dynamics = Dynamics::Overdamped {
        mobility: Mobility::identity(&network.free, 1.0)?,
        temperature: kt,
        scheme: Scheme::Heun,
    };
    let rate = stiffest(network, &dynamics)?;
    let noise = Noise::new(5);
    let (dt, breaking, confinement) = (z / rate, Breaking::Bridge, 0.0);
    let config = SimulationConfig { dynamics, dt, breaking, confinement, noise };
    let root = network.stiffness().cholesky().ok_or("a singular network")?.l().transpose();
    let mut lost = Vec::new();
    for batch in 0..batches {
        let ids: [u64; L] = std::array::from_fn(|lane| batch * L as u64 + lane as u64);
        let body = lanes_of::<T, 2, L>(network, strength)?;
        let mut run = Simulation::new(body, network.loading()?, config.clone(), ids)?;
        for (lane, id) in ids.into_iter().enumerate() {
            run.set_displacements(lane, &in_equilibrium(network, &root, kt, (&noise, id))?)?;
        }
        let mut broken = [0.0; L];
        while run.time() * rate < time - 0.5 * z {
            for event in run.step()?.broken {
                for (lane, broken) in broken.iter_mut().enumerate() {
                    *broken += f64::from(event.lanes >> lane & 1);
                }
            }
        }
        lost.extend(broken.map(|broken| broken / run.time()));
    }
    Ok((mean(&lost), time / rate))
}

/// Displacements of the law `N(0, kT K^-1)`, with the transposed Cholesky factor of `K`.
fn in_equilibrium(
    network: &Network<2>,
    root: &DMatrix<f64>,
    temperature: f64,
    (noise, realisation): (&Noise, u64),
) -> Result<Vec<[f64; 2]>, CaseError> {
    let mut normals = vec![0.0; network.n_unknowns()];
    noise.stream(Purpose::InitialDistribution, realisation).fill_normal(&mut normals);
    let white = DVector::from_vec(normals);
    let found = root.solve_upper_triangular(&white).ok_or("a singular network")?;
    let mut u = vec![[0.0; 2]; network.free.len()];
    for (value, (node, k)) in found.iter().zip(network.unknowns()) {
        u[node][k] = temperature.sqrt() * value;
    }
    Ok(u)
}

/// A bond in the noise of a network whose `kT` is one.
#[derive(Debug, Clone, Copy)]
pub struct BondNoise {
    /// Of its stretch.
    pub variance: f64,
    /// Of its stretch, over time.
    pub diffusion: f64,
}

/// Of each bond, by `K^-1`.
///
/// # Errors
/// Where the network is singular.
pub fn noise_of_bonds(network: &Network<2>) -> Result<Vec<BondNoise>, CaseError> {
    let covariance = network.stiffness().try_inverse().ok_or("a singular network")?;
    let mut number = vec![None; network.free.len() * 2];
    for (at, (node, k)) in network.unknowns().into_iter().enumerate() {
        number[node * 2 + k] = Some(at);
    }
    let entry = |a: Option<usize>, b: Option<usize>| match (a, b) {
        (Some(a), Some(b)) => covariance[(a, b)],
        _ => 0.0,
    };
    let of_bond = |((i, j), of): ((usize, usize), &Bond)| {
        let (a, b) = (network.nodes.positions()[i], network.nodes.positions()[j]);
        let n = [0, 1].map(|k| (b[k] - a[k]) / of.length);
        let mut variance = 0.0;
        for k in 0..2 {
            for l in 0..2 {
                let at = |node: usize, k: usize| number[node * 2 + k];
                variance += n[k]
                    * n[l]
                    * (entry(at(i, k), at(i, l)) + entry(at(j, k), at(j, l))
                        - entry(at(i, k), at(j, l))
                        - entry(at(j, k), at(i, l)));
            }
        }
        let ends = f64::from(u8::from(network.free[i]) + u8::from(network.free[j]));
        let square = of.length * of.length;
        BondNoise { variance: variance / square, diffusion: ends / square }
    };
    Ok(network.bonds.pairs().zip(network.bonds.all()).map(of_bond).collect())
}

impl BondNoise {
    /// The rate at which it breaks, as of a killed Ornstein-Uhlenbeck path of its own: with the variance `s^2` and the diffusion `d`
    /// of its stretch, one-sided at the strength, `d/s^2` times the eigenvalue at `s_0/s`, which `eigenvalue` gives up to
    /// [`MOST_DEVIATIONS`]; beyond them a bond does not break.
    pub fn rate(&self, temperature: f64, strength: f64, eigenvalue: impl Fn(f64) -> f64) -> f64 {
        let deviations = strength / (temperature * self.variance).sqrt();
        let is_near = self.variance > 0.0 && deviations < MOST_DEVIATIONS;
        if is_near { self.diffusion / self.variance * eigenvalue(deviations) } else { 0.0 }
    }
}
