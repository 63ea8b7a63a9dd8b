//! Failure of the linear peridynamic solid: the work of a crack, both criteria over time, and what is refused.

use peridyn_sde::{
    AtStrength, Body, BondConfig, BondFailure, Breaking, Cause, Condition, Dynamics, Error,
    Horizon, Influence, Loading, Mobility, Nodes, Scheme, Simulation, SimulationConfig, SolidBonds,
    SolidNetwork, Strain, VolumeCorrection, critical_bond_energy, critical_stretch,
    critical_stretch_of_solid,
};
use sde_integrators::Noise;

use super::solid::{PLANE_STRESS, body, config, cube};

const PLANE_STRAIN: Condition = Condition::PlaneStrain { thickness: 0.5 };

/// The work of pulling two rigid halves of a block apart, over the area of the plane in the middle.
fn work_of_separation<const D: usize>(
    condition: Condition,
    config: &BondConfig,
    nu: f64,
    failure: impl Fn(&SolidBonds) -> BondFailure,
    (stretch, steps): (f64, u32),
) -> f64 {
    let shells = config.horizon.radius().floor();
    let mut high = [if D == 3 { 2.0 * shells + 3.0 } else { 4.0 * shells + 3.0 }; D];
    high[0] = 4.0 * shells + 2.0;
    let nodes = Nodes::lattice(1.0, ([0.0; D], high), condition, |_| true).unwrap();
    let solid = SolidBonds::new(&nodes, config, nu).unwrap();
    let failure = failure(&solid);
    let n = nodes.positions().len();
    let mut body = SolidNetwork::new(nodes, solid, Strain::Linear, failure).unwrap();
    let x = body.nodes().positions().to_vec();
    let apart = |opening: f64| -> Vec<[f64; D]> {
        let of = |x: &[f64; D]| {
            let mut u = [0.0; D];
            u[0] = if x[0] > 0.5 * high[0] { opening } else { 0.0 };
            u
        };
        x.iter().map(of).collect()
    };
    // Nodes of the upper half on the line through the middle: each is for an area of the plane.
    let upper: Vec<usize> = (0..n)
        .filter(|&i| {
            x[i][0] > 0.5 * high[0] && (1..D).all(|k| (x[i][k] - 0.5 * high[k]).abs() < 0.1)
        })
        .collect();
    let area = condition.across();
    let (mut from, mut work, mut before) = (apart(0.0), 0.0, 0.0);
    // Up to an opening at which only bonds nearly in the plane are left.
    let (far, mut opening) = (4.0 * stretch * config.horizon.radius(), 0.0);
    for _ in 0..steps {
        opening += far / f64::from(steps);
        let to = apart(opening);
        let mut broken = Vec::new();
        let mut forces = vec![[0.0; D]; n];
        if body.has_memory() {
            body.advance(from.as_flattened(), to.as_flattened(), 1.0, None, &mut broken).unwrap();
        }
        body.forces(to.as_flattened(), forces.as_flattened_mut(), AtStrength::Break(&mut broken))
            .unwrap();
        for found in broken {
            body.set_intact(found.bond, 0);
        }
        body.forces(to.as_flattened(), forces.as_flattened_mut(), AtStrength::Hold).unwrap();
        let now: f64 = upper.iter().map(|&i| -forces[i][0]).sum();
        work += 0.5 * (before + now) * far / f64::from(steps);
        (before, from) = (now, to);
    }
    work / area
}

/// At the strengths for an energy release rate, by both criteria.
fn takes_its_energy(shells: u32, nu: f64) {
    let (g0, config) =
        (1e-6, BondConfig { volume_correction: VolumeCorrection::Ramp, ..config(shells) });
    let (horizon, influence) = (config.horizon, config.influence);
    let stretch =
        critical_stretch_of_solid(g0, (1.0, nu), horizon, influence, PLANE_STRESS).unwrap();
    let energy = critical_bond_energy(g0, horizon.radius(), PLANE_STRESS).unwrap();
    let work = |failure: &dyn Fn(usize) -> BondFailure, far: f64| {
        let failure = |solid: &SolidBonds| failure(solid.bonds().len());
        work_of_separation::<2>(PLANE_STRESS, &config, nu, failure, (far * stretch, 300)) / g0
    };
    let by_stretch = work(&|n| BondFailure::Stretch(vec![stretch; n]), 1.0);
    let by_energy = work(&|n| BondFailure::Energy(vec![energy; n]), 2.0);
    assert!((by_stretch - 1.0).abs() < 0.03, "{shells} {nu} {by_stretch}");
    assert!((by_energy - 1.0).abs() < 0.03, "{shells} {nu} {by_energy}");
}

#[test]
fn a_crack_takes_the_energy_of_its_criterion() {
    takes_its_energy(3, 0.1);
    takes_its_energy(3, 0.45);
    takes_its_energy(4, 0.2);
}

/// Where the law is that of bonds, so is the critical stretch.
#[test]
fn the_critical_stretch_is_that_of_bonds_at_their_poissons_ratio() {
    let horizon = Horizon::of_shells(3, 1.0).unwrap();
    for (condition, nu) in
        [(PLANE_STRESS, 1.0 / 3.0), (PLANE_STRAIN, 0.25), (Condition::Solid, 0.25)]
    {
        for influence in Influence::ALL {
            let ours =
                critical_stretch_of_solid(2.0, (3.0, nu), horizon, influence, condition).unwrap();
            let of_bonds =
                critical_stretch(2.0, 3.0, horizon.radius(), influence, condition).unwrap();
            assert!((ours / of_bonds - 1.0).abs() < 1e-14, "{condition:?} {influence:?}");
        }
    }
    // 4 G0/(pi delta^4) and 3 G0/(2 t delta^3).
    let energy = critical_bond_energy(2.0, 1.5, Condition::Solid).unwrap();
    assert!((energy / (8.0 / (std::f64::consts::PI * 1.5_f64.powi(4))) - 1.0).abs() < 1e-14);
    let energy = critical_bond_energy(2.0, 1.5, PLANE_STRESS).unwrap();
    assert!((energy / (6.0 / (2.0 * 0.5 * 1.5_f64.powi(3))) - 1.0).abs() < 1e-14);
}

/// The failure of the bonds of a body.
type Failure<'a> = &'a dyn Fn(&SolidBonds) -> BondFailure;

/// A plate in noise, held at its left edge, by a scheme.
fn in_noise(
    failure: Failure<'_>,
    scheme: Scheme,
    breaking: Breaking,
) -> Result<Simulation<f64, SolidNetwork<2>, 2, 1>, Error> {
    let nodes = cube::<2>(7.0, PLANE_STRESS);
    let solid = SolidBonds::new(&nodes, &config(3), 0.2)?;
    let held: Vec<usize> = (0..49).filter(|node| node % 7 == 0).collect();
    let free: Vec<bool> = (0..49).map(|node| node % 7 != 0).collect();
    let failure = failure(&solid);
    let body = SolidNetwork::new(nodes, solid, Strain::Finite, failure)?;
    let mobility = Mobility::identity(&free, 1.0)?;
    let config = SimulationConfig {
        dynamics: Dynamics::Overdamped { mobility, temperature: 1e-3, scheme },
        dt: 0.1,
        breaking,
        confinement: 0.0,
        noise: Noise::new(4),
    };
    Simulation::new(body, Loading::new(49).hold(&held)?, config, [0])
}

#[test]
fn bonds_break_by_either_criterion_and_stay_broken() {
    let stretch = |solid: &SolidBonds| BondFailure::Stretch(vec![0.12; solid.bonds().len()]);
    let energy = |solid: &SolidBonds| BondFailure::Energy(vec![2e-3; solid.bonds().len()]);
    let runs: [(Failure<'_>, Breaking, Cause); 3] = [
        (&stretch, Breaking::AtEnds, Cause::Stretch),
        (&stretch, Breaking::Bridge, Cause::Crossing),
        (&energy, Breaking::AtEnds, Cause::Energy),
    ];
    for (failure, breaking, cause) in runs {
        let mut run = in_noise(failure, Scheme::Heun, breaking).unwrap();
        let mut broken = Vec::new();
        for _ in 0..40 {
            broken.extend(run.step().unwrap().broken);
        }
        let of_cause = broken.iter().filter(|of| of.cause == cause).count();
        assert!(of_cause > 3, "{cause:?}: {} of {}", of_cause, broken.len());
        let mut bonds: Vec<usize> = broken.iter().map(|of| of.bond).collect();
        bonds.sort_unstable();
        bonds.dedup();
        assert_eq!(bonds.len(), broken.len());
        assert!(bonds.iter().all(|&bond| run.body().intact(bond) == 0));
        assert_eq!(run.save().is_ok(), cause != Cause::Energy);
    }
}

#[test]
fn what_cannot_be_is_refused_with_its_value() {
    let energy = |solid: &SolidBonds| BondFailure::Energy(vec![1.0; solid.bonds().len()]);
    let bridge = in_noise(&energy, Scheme::Heun, Breaking::Bridge);
    assert_eq!(bridge.err(), Some(Error::NoBridgeOfEnergy));
    let nodes = cube::<2>(4.0, PLANE_STRESS);
    for nu in [-1.0, 0.5, f64::NAN] {
        let refused = SolidBonds::new(&nodes, &config(2), nu).unwrap_err();
        assert!(matches!(refused, Error::OutOfRange { name: "Poisson's ratio", .. }), "{refused}");
    }
    let solid = SolidBonds::new(&nodes, &config(2), 0.2).unwrap();
    let new = |failure| SolidNetwork::new(nodes.clone(), solid.clone(), Strain::Finite, failure);
    let n = solid.bonds().len();
    assert!(matches!(new(BondFailure::Stretch(vec![0.1; n + 1])), Err(Error::Length { .. })));
    let negative = new(BondFailure::Energy(vec![-0.1; n])).unwrap_err();
    assert!(matches!(negative, Error::NotPositive { name: "critical energy of a bond", .. }));
    let body = body(&nodes, &config(2), 0.2);
    let lost = body.dilatations(&[[f64::NAN; 2]; 16]).unwrap_err();
    assert!(matches!(lost, Error::Node { node: 0, .. }));
    let mut met = vec![[0.0; 2]; 16];
    met[1] = [-1.0, 0.0];
    assert_eq!(body.energies(&met).unwrap_err(), Error::Coincident { first: 0, second: 1 });
}
