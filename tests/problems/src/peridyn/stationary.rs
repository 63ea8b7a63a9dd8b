//! The stationary law of each scheme on a small network, by the map of its step.

use nalgebra::DMatrix;
use peridyn_sde::{Dynamics, Mobility, Scheme};

use super::network::{Network, distance, rate, stationary};
use crate::context::CaseError;

/// `kT`.
pub const TEMPERATURE: f64 = 0.7;

/// Of a temperature, by a scheme.
#[must_use]
pub fn overdamped(mobility: &Mobility, temperature: f64, scheme: Scheme) -> Dynamics {
    Dynamics::Overdamped { mobility: mobility.clone(), temperature, scheme }
}

/// The stationary covariance of a scheme over that of the law, and how far its first step is from `N z` with the noise map `N` it
/// should have.
#[derive(Debug, Clone)]
pub struct Law {
    /// `cov u` of the free components (length squared).
    pub covariance: DMatrix<f64>,
    /// How far the first step is off, over its size.
    pub kick: f64,
}

/// The law of a scheme, by steps of `z`.
///
/// # Errors
/// Those of the run: of a step that is not stable.
pub fn law_of<const D: usize>(
    network: &Network<D>,
    mobility: &Mobility,
    scheme: Scheme,
    z: f64,
) -> Result<Law, CaseError> {
    let cold = overdamped(mobility, 0.0, scheme);
    let dt = z / rate(network, &cold)?;
    let map = network.map_of_step(&cold, dt)?;
    let (l, k) = (network.factor(mobility)?, network.stiffness());
    let n = network.n_unknowns();
    let one = DMatrix::<f64>::identity(n, n);
    let noise = (2.0 * TEMPERATURE * dt).sqrt() * &l;
    let drift = dt * &l * l.transpose() * &k;
    let noise = match scheme {
        Scheme::EulerMaruyama | Scheme::LeimkuhlerMatthews => noise,
        Scheme::Heun => (one - 0.5 * drift) * noise,
        Scheme::Theta(theta) => {
            (one + theta * drift).try_inverse().ok_or("a singular step")? * noise
        }
    };
    let hot = overdamped(mobility, TEMPERATURE, scheme);
    let [u, w, area] = network.first_kick(hot, dt, l.ncols())?;
    let z = if scheme == Scheme::LeimkuhlerMatthews {
        w.iter().zip(&area).map(|(w, area)| 0.5 * (w + area)).collect()
    } else {
        w
    };
    let expected = &noise * DMatrix::from_vec(z.len(), 1, z);
    let kick = distance(&DMatrix::from_vec(u.len(), 1, u), &expected);
    let covariance = if scheme == Scheme::LeimkuhlerMatthews {
        averaged(&map, &noise)
    } else {
        stationary(&map, &(&noise * noise.transpose()))
    };
    Ok(Law { covariance, kick })
}

/// The covariance of `x' = A x + B (z_0 + z_1)/2`, whose memory `z_0` is part of the state.
#[must_use]
pub fn averaged(map: &DMatrix<f64>, noise: &DMatrix<f64>) -> DMatrix<f64> {
    let (n, m) = noise.shape();
    let (mut large, mut kicks) = (DMatrix::zeros(n + m, n + m), DMatrix::zeros(n + m, m));
    large.view_mut((0, 0), (n, n)).copy_from(map);
    large.view_mut((0, n), (n, m)).copy_from(&(0.5 * noise));
    kicks.view_mut((0, 0), (n, m)).copy_from(&(0.5 * noise));
    kicks.view_mut((n, 0), (m, m)).fill_with_identity();
    stationary(&large, &(&kicks * kicks.transpose())).view((0, 0), (n, n)).into_owned()
}

/// The covariance of the displacements under BAOAB with unit masses, at `omega h` of the stiffest mode.
///
/// # Errors
/// Those of the run: of a step that is not stable.
pub fn covariance_of_baoab(
    network: &Network<1>,
    friction: f64,
    angle: f64,
) -> Result<DMatrix<f64>, CaseError> {
    let n = network.n_unknowns();
    let dynamics = |temperature| Dynamics::Inertial { density: 1.0, friction, temperature };
    let dt = angle / rate(network, &dynamics(0.0))?;
    let map = network.map_of_step(&dynamics(0.0), dt)?;
    let amplitude = ((1.0 - (-2.0_f64 * friction * dt).exp()) * TEMPERATURE).sqrt();
    let one = DMatrix::<f64>::identity(n, n);
    let moved = 0.5 * dt * amplitude * &one;
    let mut noise = DMatrix::zeros(2 * n, n);
    noise.view_mut((0, 0), (n, n)).copy_from(&moved);
    let kicked = amplitude * &one - 0.5 * dt * network.stiffness() * &moved;
    noise.view_mut((n, 0), (n, n)).copy_from(&kicked);
    let covariance = stationary(&map, &(&noise * noise.transpose()));
    Ok(covariance.view((0, 0), (n, n)).into_owned())
}
