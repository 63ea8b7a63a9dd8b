//! Groups of bonds whose tension is not linear, in noise: moments of the invariant measure `exp(-V/kT)` by quadrature and by paths.
//!
//! A chain whose every third node is held falls into groups of two free nodes with displacements `u` and `v` and two bonds, of
//! stiffness and length one: `V = W(u) + W(v - u)`.

use peridyn_sde::law::BondLaw;
use peridyn_sde::{
    Breaking, Cause, Dynamics, Error, Loading, Network as Body, Simulation, SimulationConfig,
};
use result_figures::Measured;
use sde_integrators::Noise;

use super::network::Network;
use super::sample::mean;
use crate::context::CaseError;

/// Groups side by side.
pub const GROUPS: usize = 400;

/// A bond that is stable at two stretches,
///
/// $$ \int_0^s \sigma ds = W(s) - W(0), \qquad W = h \left( (s/a)^2 - 1 \right)^2 + g s/a . $$
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct DoubleWell {
    /// `a` (a stretch).
    pub width: f64,
    /// `h`, over the stiffness of the bond and its length.
    pub barrier: f64,
    /// `g`, likewise.
    pub tilt: f64,
}

impl BondLaw for DoubleWell {
    type State = ();

    fn advance(&self, _strength: f64, _from: f64, _to: f64, _dt: f64, _state: &mut ()) {}

    fn tension(&self, _strength: f64, s: f64, _state: &()) -> f64 {
        let x = s / self.width;
        (4.0 * self.barrier * x * (x * x - 1.0) + self.tilt) / self.width
    }

    fn energy(&self, _strength: f64, s: f64, _state: &()) -> f64 {
        let x = s / self.width;
        self.barrier * ((x * x - 1.0).powi(2) - 1.0) + self.tilt * x
    }

    fn damage(&self, _strength: f64, _state: &()) -> f64 {
        0.0
    }

    /// In a well, where it is stiffer than at rest.
    fn slope(&self, _strength: f64, _state: &()) -> f64 {
        8.0 * self.barrier / (self.width * self.width)
    }
}

/// What is looked at of a group, by the displacements of its nodes.
pub type Observable = fn(f64, f64) -> f64;

/// Means under `exp(-V/kT)` of displacements up to `reach`, by the trapezoidal rule, which converges faster than any power where
/// the density ends before the reach.
#[must_use]
pub fn expected<const K: usize>(
    (law, strength): (&impl BondLaw, f64),
    (temperature, reach): (f64, f64),
    observables: [Observable; K],
) -> [f64; K] {
    const COUNT: i32 = 300;
    let place = |index: i32| reach * f64::from(index) / f64::from(COUNT);
    let intact = Default::default();
    let energy = |s: f64| law.energy(strength, s, &intact);
    let (mut weight, mut sums) = (0.0, [0.0; K]);
    for u in (-COUNT..=COUNT).map(place) {
        for v in (-COUNT..=COUNT).map(place) {
            let density = (-(energy(u) + energy(v - u)) / temperature).exp();
            weight += density;
            for (sum, of) in sums.iter_mut().zip(observables) {
                *sum += density * of(u, v);
            }
        }
    }
    sums.map(|sum| sum / weight)
}

/// A chain of so many groups, every third node of it held.
pub fn groups() -> Result<Network<1>, Error> {
    let mut chain = Network::chain(3 * GROUPS)?;
    for (node, free) in chain.free.iter_mut().enumerate() {
        *free = node % 3 != 0;
    }
    Ok(chain)
}

/// How long groups are followed.
#[derive(Debug, Clone, Copy)]
pub struct Followed {
    /// `z`, or `omega h`, of the stiffest mode.
    pub relative: f64,
    /// Until they are looked at first (steps).
    pub settled: u32,
    /// After that (steps).
    pub steps: u32,
}

/// Means over time and groups, with standard errors from the scatter of the groups.
///
/// # Errors
/// Those of the run; where a bond breaks.
pub fn sampled<L: BondLaw + Clone + Send + 'static, const K: usize>(
    (law, strength): (&L, f64),
    dynamics: &Dynamics,
    followed: Followed,
    observables: [Observable; K],
) -> Result<[Measured; K], CaseError> {
    let chain = groups()?;
    let start = |dt: f64| {
        let strengths = vec![strength; chain.bonds.len()];
        let body = Body::new(chain.nodes.clone(), chain.bonds.clone(), law.clone(), strengths)?;
        let (breaking, confinement) = (Breaking::AtEnds, 0.0);
        let (dynamics, noise) = (dynamics.clone(), Noise::new(17));
        let config = SimulationConfig { dynamics, dt, breaking, confinement, noise };
        let loading = Loading::new(chain.free.len()).hold(&chain.held())?;
        Simulation::new(body, loading, config, [0])
    };
    let small = 1e-6;
    let per_step = start(small)?.relative_step();
    let is_inertial = matches!(dynamics, Dynamics::Inertial { .. });
    let per_step = if is_inertial { per_step.sqrt() } else { per_step };
    let mut run = start(small * followed.relative / per_step)?;
    // The bond from the second node of each group to the next held one.
    let last: Vec<usize> = (0..GROUPS).map(|group| 3 * group + 2).collect();
    run.cut(&last)?;
    let mut sums = [[0.0; K]; GROUPS];
    for step in 0..followed.settled + followed.steps {
        let report = run.step()?;
        if let Some(broken) = report.broken.iter().find(|broken| broken.cause != Cause::Cut) {
            return Err(format!("bond {} broke in step {step}", broken.bond).into());
        }
        if step < followed.settled {
            continue;
        }
        let u = run.displacements(0);
        for (group, sums) in sums.iter_mut().enumerate() {
            let (first, second) = (u[3 * group + 1][0], u[3 * group + 2][0]);
            for (sum, of) in sums.iter_mut().zip(observables) {
                *sum += of(first, second) / f64::from(followed.steps);
            }
        }
    }
    Ok(std::array::from_fn(|k| mean(&sums.iter().map(|sums| sums[k]).collect::<Vec<_>>())))
}
