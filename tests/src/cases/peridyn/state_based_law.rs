//! The stationary law of a linear peridynamic solid.

use nalgebra::DMatrix;
use peridyn_sde::{
    Body, BondConfig, BondList, Breaking, Condition, Dynamics, Horizon, Influence, Loading,
    Mobility, Nodes, Scheme, Simulation, SimulationConfig, SolidBonds, Strain, SurfaceCorrection,
    VolumeCorrection,
};
use reference_problems::peridyn::network::{distance, stationary};
use reference_problems::peridyn::stationary::{TEMPERATURE, averaged};
use sde_integrators::{LaneNormals, Noise, Purpose};

use crate::case::{CaseError, Context};
use crate::cases::lines::Lines;
use crate::cases::worst::Worst;
use crate::report::Claim;

/// A plate of 16 nodes, its first column held.
struct Small {
    free: Vec<usize>,
    k: DMatrix<f64>,
}

fn small() -> Result<BondList<f64, 2, 1>, CaseError> {
    let condition = Condition::PlaneStress { thickness: 1.0 };
    let nodes = Nodes::lattice(1.0, ([0.0; 2], [4.0; 2]), condition, |_| true)?;
    let config = BondConfig {
        horizon: Horizon::of_shells(2, 1.0)?,
        young_modulus: 1.0,
        influence: Influence::Constant,
        volume_correction: VolumeCorrection::Partial,
        surface_correction: SurfaceCorrection::None,
    };
    let solid = SolidBonds::new(&nodes, &config, 0.1)?;
    let strengths = vec![10.0; solid.bonds().len()];
    Ok(BondList::of_solid(nodes, solid, Strain::Linear, &strengths)?)
}

/// The plate in time.
fn simulation(
    (scheme, temperature): (Scheme, f64),
    dt: f64,
) -> Result<Simulation<f64, 2, 1>, CaseError> {
    let is_free: Vec<bool> = (0..16).map(|node| node % 4 != 0).collect();
    let held: Vec<usize> = (0..16).filter(|node| node % 4 == 0).collect();
    let mobility = Mobility::identity(&is_free, 1.0)?;
    let config = SimulationConfig {
        dynamics: Dynamics::Overdamped { mobility, temperature, scheme },
        dt,
        breaking: Breaking::AtEnds,
        confinement: 0.0,
        noise: Noise::new(77),
    };
    Ok(Simulation::new(small()?, Loading::new(16).hold(&held)?, config, [0])?)
}

impl Small {
    /// `K` by second differences of the energy, which is quadratic.
    fn new() -> Result<Self, CaseError> {
        let body = small()?;
        let free: Vec<usize> = (0..32).filter(|at| at / 2 % 4 != 0).collect();
        let energy = |of: &[usize]| {
            let mut u = vec![0.0; 32];
            for &at in of {
                u[at] += 1.0;
            }
            body.energy(&u, 0)
        };
        let entry = |a: usize, b: usize| {
            let (a, b) = (free[a], free[b]);
            energy(&[a, b]) - energy(&[a]) - energy(&[b])
        };
        let k = DMatrix::from_fn(free.len(), free.len(), entry);
        Ok(Self { free, k })
    }

    /// Displacements of free components after a step.
    fn after(&self, mut run: Simulation<f64, 2, 1>) -> Result<Vec<f64>, CaseError> {
        let _ = run.step()?;
        let u = run.displacements(0);
        Ok(self.free.iter().map(|&at| u.as_flattened()[at]).collect())
    }

    /// How far the covariance of a scheme is from `kT K^-1`, and its first step from what its noise should make of the normals.
    fn errors(&self, scheme: Scheme, z: f64) -> Result<[f64; 2], CaseError> {
        let dt = 1e-6;
        let dt = z * dt / simulation((scheme, 0.0), dt)?.relative_step();
        let n = self.free.len();
        let mut map = DMatrix::zeros(n, n);
        for (column, &at) in self.free.iter().enumerate() {
            let mut run = simulation((scheme, 0.0), dt)?;
            let mut unit = vec![[0.0; 2]; 16];
            unit.as_flattened_mut()[at] = 1.0;
            run.set_displacements(0, &unit)?;
            map.set_column(column, &self.after(run)?.into());
        }
        let amplitude = (2.0 * TEMPERATURE * dt).sqrt();
        let one = DMatrix::<f64>::identity(n, n);
        let noise = match scheme {
            Scheme::Theta(theta) => {
                let implicit = &one + theta * dt * &self.k;
                amplitude * implicit.try_inverse().ok_or("a singular step")?
            }
            _ => amplitude * one,
        };
        let normals = |purpose| {
            let mut z = vec![0.0; 32];
            LaneNormals::new(&Noise::new(77), purpose, [0]).fill(0, 32, 0..32, &mut z);
            z
        };
        let (w, before) = (normals(Purpose::Path), normals(Purpose::PathArea));
        let is_averaged = scheme == Scheme::LeimkuhlerMatthews;
        let drawn = self
            .free
            .iter()
            .map(|&at| if is_averaged { 0.5 * (w[at] + before[at]) } else { w[at] });
        let expected = &noise * DMatrix::from_iterator(n, 1, drawn);
        let first = self.after(simulation((scheme, TEMPERATURE), dt)?)?;
        let kick = distance(&DMatrix::from_vec(n, 1, first), &expected);
        let covariance = if is_averaged {
            averaged(&map, &noise)
        } else {
            stationary(&map, &(&noise * noise.transpose()))
        };
        let exact = TEMPERATURE * self.k.clone().try_inverse().ok_or("a singular network")?;
        Ok([distance(&covariance, &exact), kick])
    }
}

/// The stationary law of the schemes that are exact for linear forces.
pub(super) fn claims(context: &Context<'_>) -> Result<Vec<Claim>, CaseError> {
    let plate = Small::new()?;
    let mut claims = Vec::new();
    for (scheme, key, [covariance, kick]) in [
        (Scheme::LeimkuhlerMatthews, "leimkuhler-matthews", [3e-13, 2e-15]),
        (Scheme::Theta(0.5), "theta-0.5", [3e-10, 5e-11]),
    ] {
        let (mut of_covariance, mut of_kick) = (Worst::default(), Worst::default());
        for z in [0.1, 1.0, 1.9] {
            let [covariance, kick] = plate.errors(scheme, z)?;
            of_covariance.take(covariance, &format!("z = {z}"));
            of_kick.take(kick, &format!("z = {z}"));
        }
        let name = scheme.name();
        for (id, worst, tolerance, what) in [
            (
                "covariance",
                of_covariance,
                covariance,
                "largest entry of cov - kT K^-1 over its largest, K by differences of the energy",
            ),
            (
                "kick",
                of_kick,
                kick,
                "the first step from rest against N z, with the noise map N of the scheme",
            ),
        ] {
            let method = worst.method(&format!(
                "{name}, z = 0.1, 1 and 1.9, plate of 16 nodes, 2 shells, nu = 0.1"
            ));
            claims.push(Lines { context, id: key, method }.bounded(
                (id, what, ""),
                worst.value(),
                tolerance,
                "roundoff: of matrices, times their condition; of the implicit scheme, some times the residual of 1e-11 of its linear system",
            ));
        }
    }
    Ok(claims)
}
