//! Failure of the linear peridynamic solid: the work of a crack, bonds that break over time, and what is refused.

use peridyn_sde::{
    AtStrength, Body, BondConfig, BondList, Breaking, Cause, Condition, Error, Horizon, Influence,
    Loading, Nodes, Scheme, Simulation, SimulationConfig, SolidBonds, Strain, VolumeCorrection,
    critical_stretch, critical_stretch_of_solid,
};

use crate::fixtures::{cube, in_time, overdamped};
use crate::solid::{PLANE_STRESS, config, one};

const PLANE_STRAIN: Condition = Condition::PlaneStrain { thickness: 0.5 };

/// The work of pulling two rigid halves of a block apart, over the area of the plane in the middle.
fn work_of_separation<const D: usize>(
    condition: Condition,
    config: &BondConfig,
    nu: f64,
    (stretch, steps): (f64, u32),
) -> f64 {
    let shells = config.horizon.radius().floor();
    let mut high = [if D == 3 { 2.0 * shells + 3.0 } else { 4.0 * shells + 3.0 }; D];
    high[0] = 4.0 * shells + 2.0;
    let nodes = Nodes::lattice(1.0, ([0.0; D], high), condition, |_| true).unwrap();
    let solid = SolidBonds::new(&nodes, config, nu).unwrap();
    let n = nodes.positions().len();
    let mut body = one(&nodes, &solid, Strain::Linear, stretch);
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
    let (mut work, mut before) = (0.0, 0.0);
    // Up to an opening at which only bonds nearly in the plane are left.
    let (far, mut opening) = (4.0 * stretch * config.horizon.radius(), 0.0);
    for _ in 0..steps {
        opening += far / f64::from(steps);
        let to = apart(opening);
        let mut broken = Vec::new();
        let mut forces = vec![[0.0; D]; n];
        body.forces(to.as_flattened(), forces.as_flattened_mut(), AtStrength::Break(&mut broken))
            .unwrap();
        for found in broken {
            body.set_intact(found.bond, 0);
        }
        body.forces(to.as_flattened(), forces.as_flattened_mut(), AtStrength::Hold).unwrap();
        let now: f64 = upper.iter().map(|&i| -forces[i][0]).sum();
        work += 0.5 * (before + now) * far / f64::from(steps);
        before = now;
    }
    work / area
}

/// At the critical stretch of an energy release rate.
fn takes_its_energy(shells: u32, nu: f64) {
    let (g0, config) =
        (1e-6, BondConfig { volume_correction: VolumeCorrection::Ramp, ..config(shells) });
    let (horizon, influence) = (config.horizon, config.influence);
    let stretch =
        critical_stretch_of_solid(g0, (1.0, nu), horizon, influence, PLANE_STRESS).unwrap();
    let work = work_of_separation::<2>(PLANE_STRESS, &config, nu, (stretch, 300)) / g0;
    assert!((work - 1.0).abs() < 0.03, "{shells} {nu} {work}");
}

#[test]
fn a_crack_takes_the_energy_of_its_critical_stretch() {
    takes_its_energy(3, 0.1);
    takes_its_energy(3, 0.45);
    takes_its_energy(4, 0.2);
    takes_its_energy(5, 0.3);
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
}

/// A plate in noise, held at its left edge, by a scheme.
fn in_noise(scheme: Scheme, breaking: Breaking) -> Result<Simulation<f64, 2, 1>, Error> {
    let nodes = cube::<2>(7.0, PLANE_STRESS);
    let solid = SolidBonds::new(&nodes, &config(3), 0.2)?;
    let held: Vec<usize> = (0..49).filter(|node| node % 7 == 0).collect();
    let free: Vec<bool> = (0..49).map(|node| node % 7 != 0).collect();
    let body = one(&nodes, &solid, Strain::Finite, 0.12);
    let dynamics = overdamped(&free, scheme, 1e-3);
    let config = SimulationConfig { breaking, ..in_time(dynamics, 0.1, 4) };
    Simulation::new(body, Loading::new(49).hold(&held)?, config, [0])
}

#[test]
fn bonds_break_at_the_ends_of_steps_and_between_them_and_stay_broken() {
    for (breaking, cause) in
        [(Breaking::AtEnds, Cause::Stretch), (Breaking::Bridge, Cause::Crossing)]
    {
        let mut run = in_noise(Scheme::Heun, breaking).unwrap();
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
        assert!(run.save().is_ok());
    }
}

#[test]
fn what_cannot_be_is_refused_with_its_value() {
    let nodes = cube::<2>(4.0, PLANE_STRESS);
    for nu in [-1.0, 0.5, f64::NAN] {
        let refused = SolidBonds::new(&nodes, &config(2), nu).unwrap_err();
        assert!(matches!(refused, Error::Parameter { name: "Poisson's ratio", .. }), "{refused}");
    }
    let solid = SolidBonds::new(&nodes, &config(2), 0.2).unwrap();
    let new = |strengths: Vec<f64>| {
        BondList::<f64, 2, 1>::of_solid(nodes.clone(), solid.clone(), Strain::Finite, &strengths)
    };
    let n = solid.bonds().len();
    assert!(matches!(new(vec![0.1; n + 1]), Err(Error::Length { .. })));
    assert!(matches!(new(vec![-0.1; n]), Err(Error::Parameter { .. })));
}
