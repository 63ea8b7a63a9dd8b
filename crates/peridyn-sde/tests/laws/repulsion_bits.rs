//! Nodes that repel each other: bitwise identical results, and refused input.

use peridyn_sde::{
    Body, BondConfig, BondList, Bonds, Breaking, Condition, Dynamics, Error, Horizon, Influence,
    Loading, Mobility, Nodes, Program, Real, Repulsion, SavedState, Scheme, Simulation,
    SimulationConfig, Strain, SurfaceCorrection, VolumeCorrection, micromodulus,
};
use sde_integrators::Noise;

type Run<T, const L: usize> = Simulation<T, BondList<T, 2, L>, 2, L>;

const SIDE: f64 = 8.0;

fn plate() -> (Nodes<2>, Bonds, Repulsion) {
    let condition = Condition::PlaneStress { thickness: 1.0 };
    let nodes = Nodes::lattice(1.0, ([0.0; 2], [SIDE; 2]), condition, |_| true).unwrap();
    let (horizon, influence) = (Horizon::of_shells(3, 1.0).unwrap(), Influence::Constant);
    let config = BondConfig {
        horizon,
        young_modulus: 1.0,
        influence,
        volume_correction: VolumeCorrection::None,
        surface_correction: SurfaceCorrection::None,
    };
    let bonds = Bonds::new(&nodes, &config).unwrap();
    let c = micromodulus(1.0, horizon.radius(), influence, condition).unwrap();
    (nodes, bonds, Repulsion::new(c, horizon.radius()).unwrap())
}

fn dynamics(scheme: Option<Scheme>) -> Dynamics {
    let Some(scheme) = scheme else {
        return Dynamics::Inertial { density: 1.0, friction: 0.1, temperature: 2e-2 };
    };
    let mobility = Mobility::identity(&[true; 64], 1.0).unwrap();
    Dynamics::Overdamped { mobility, temperature: 2e-2, scheme }
}

const WAYS: [Option<Scheme>; 5] = [
    None,
    Some(Scheme::EulerMaruyama),
    Some(Scheme::LeimkuhlerMatthews),
    Some(Scheme::Heun),
    Some(Scheme::Theta(0.5)),
];

/// A plate cut across, hot enough for its bonds to break, pressed together by a load.
fn hot<T: Real, const L: usize>(way: Option<Scheme>, ids: [u64; L], repels: bool) -> Run<T, L>
where
    BondList<T, 2, L>: Body<T, 2, L>,
{
    let (nodes, bonds, repulsion) = plate();
    let crack = bonds.across_segment(&nodes, ([-1.0, 4.0], [9.0, 4.0])).unwrap();
    let strengths = vec![0.4; bonds.len()];
    let top: Vec<usize> = (56..64).collect();
    let loading = Loading::new(64).hold(&[0, 1, 2, 3, 4, 5, 6, 7]).unwrap();
    let loading = match way {
        None => loading,
        Some(_) => Loading::new(64),
    };
    let press = Program::Constant(1.0);
    let loading = loading.force(&top, &[[0.0, -0.05]; 8], press).unwrap();
    let body = BondList::new(nodes, bonds, Strain::Finite, &strengths).unwrap();
    let config = SimulationConfig {
        dynamics: dynamics(way),
        dt: 0.02,
        breaking: Breaking::AtEnds,
        confinement: 0.0,
        noise: Noise::new(5),
    };
    let mut run = Simulation::new(body, loading, config, ids).unwrap();
    run.cut(&crack).unwrap();
    // The faces overlap at once.
    let down: Vec<[f64; 2]> =
        (0..64).map(|node| [0.0, if node < 32 { 0.0 } else { -0.15 }]).collect();
    for lane in 0..L {
        run.set_displacements(lane, &down).unwrap();
    }
    if repels { run.with_repulsion(repulsion).unwrap() } else { run }
}

fn after<T: Real, const L: usize>(run: &mut Run<T, L>, steps: usize) -> SavedState
where
    BondList<T, 2, L>: Body<T, 2, L>,
{
    for _ in 0..steps {
        let _ = run.step().unwrap();
    }
    run.save().unwrap()
}

/// A run restored with lists of another age is bitwise identical.
fn goes_on<T: Real, const L: usize>()
where
    BondList<T, 2, L>: Body<T, 2, L>,
{
    let ids: [u64; L] = std::array::from_fn(|lane| lane as u64);
    for way in WAYS {
        let mut whole = hot::<T, L>(way, ids, true);
        let saved = after(&mut whole, 37);
        let touching = (0..L).filter(|&lane| whole.repulsion_energy(lane).unwrap() > 0.0).count();
        assert!(touching > L / 2, "{way:?}: {touching}");
        let mut resumed = hot::<T, L>(way, ids, true);
        resumed.restore(&saved).unwrap();
        let end = after(&mut whole, 33);
        assert!(end == after(&mut resumed, 33), "{way:?}");
        assert!(end != after(&mut hot::<T, L>(way, ids, false), 70), "{way:?}");
    }
}

#[test]
fn a_saved_run_goes_on_to_the_same_bits() {
    goes_on::<f64, 8>();
    goes_on::<f32, 16>();
}

/// Which lanes are beside does not change a lane, and alone it has the same repulsion to the last bit.
#[test]
fn lanes_do_not_know_of_each_other() {
    for way in WAYS {
        let mut one = hot::<f64, 8>(way, [5, 9, 2, 3, 4, 6, 7, 8], true);
        let mut other = hot::<f64, 8>(way, [1, 9, 11, 12, 13, 14, 15, 16], true);
        let (_, _) = (after(&mut one, 50), after(&mut other, 50));
        let u = one.displacements(1);
        assert_eq!(u, other.displacements(1), "{way:?}");
        let mut alone = hot::<f64, 1>(way, [9], true);
        alone.set_displacements(0, &u).unwrap();
        let forces = one.repulsion_forces(1).unwrap();
        assert!(forces.iter().flatten().any(|force| force.abs() > 1e-3), "{way:?}");
        let alone = alone.repulsion_forces(0).unwrap();
        for (node, (force, alone)) in forces.iter().zip(alone).enumerate() {
            assert_eq!(force.map(f64::to_bits), alone.map(f64::to_bits), "{way:?} {node}");
        }
    }
}

/// Between single and double precision the repulsion differs by the rounding of displacements of order 1, a few 1e-8 of them,
/// times the stiffness of a pair.
#[test]
fn single_precision_is_double_precision_rounded() {
    let mut double = hot::<f64, 8>(None, [0; 8], true);
    let mut single = hot::<f32, 16>(None, [0; 16], true);
    let _ = after(&mut double, 30);
    let u = double.displacements(0);
    single.set_displacements(0, &u).unwrap();
    let forces = double.repulsion_forces(0).unwrap();
    let stiffness = plate().2.stiffness;
    for (a, b) in forces.iter().flatten().zip(single.repulsion_forces(0).unwrap().iter().flatten())
    {
        assert!((a - b).abs() < 1e-6 * stiffness, "{a} {b}");
    }
}

#[test]
fn what_cannot_be_is_refused() {
    let repulsion = plate().2;
    let with = |repulsion| hot::<f64, 8>(None, [0; 8], false).with_repulsion(repulsion).map(|_| ());
    let error = with(Repulsion { rest_factor: 1.5, ..repulsion }).unwrap_err();
    assert!(matches!(error, Error::OutOfRange { value, .. } if value > 1.4), "{error}");
    let error = with(Repulsion { horizon: 0.0, ..repulsion }).unwrap_err();
    assert!(matches!(error, Error::NotPositive { .. }), "{error}");
    let error = with(Repulsion { spacing_factor: 1e200, ..repulsion }).unwrap_err();
    assert!(matches!(error, Error::OutOfRange { .. }), "{error}");
    let error = with(Repulsion { stiffness: 1e300, ..repulsion }).unwrap_err();
    assert!(matches!(error, Error::Unstable { .. }), "{error}");
    let error = with(Repulsion { stiffness: f64::MAX, horizon: 1e-300, ..repulsion }).unwrap_err();
    assert!(matches!(error, Error::Unstable { .. }), "{error}");
}

/// The first and the last node, of the two halves, at one place: bonds do not see it, the repulsion does.
#[test]
fn nodes_at_one_place_have_no_direction() {
    let mut run = hot::<f64, 1>(Some(Scheme::EulerMaruyama), [0], true);
    let mut u = vec![[0.0; 2]; 64];
    u[63] = [-(SIDE - 1.0); 2];
    let error = run.set_displacements(0, &u).unwrap_err();
    assert_eq!(error, Error::Coincident { first: 0, second: 63 });
}

/// A force that throws a node out of what numbers hold, within a step and at its end; and a node so far out that squares overflow.
#[test]
fn a_lost_path_is_named() {
    let (nodes, bonds, repulsion) = plate();
    for scheme in [Scheme::EulerMaruyama, Scheme::Heun, Scheme::Theta(0.5)] {
        for push in [1e170, 1e308] {
            let press = Program::Table(vec![(0.0, 1.0), (0.1, 1e3)]);
            let loading = Loading::new(64).force(&[35], &[[push, 0.0]], press).unwrap();
            let strengths = vec![1.0; bonds.len()];
            let body = BondList::<f64, 2, 1>::new(
                nodes.clone(),
                bonds.clone(),
                Strain::Finite,
                &strengths,
            );
            let config = SimulationConfig {
                dynamics: dynamics(Some(scheme)),
                dt: 0.05,
                breaking: Breaking::AtEnds,
                confinement: 0.0,
                noise: Noise::new(5),
            };
            let run = Simulation::new(body.unwrap(), loading, config, [4]).unwrap();
            let mut run = run.with_repulsion(repulsion).unwrap();
            let error = (0..200).find_map(|_| run.step().err());
            match (error, scheme) {
                (Some(Error::Lost { realisation: 4, node, value, .. }), _) => {
                    assert!(!value.is_finite() && node < 64, "{scheme:?} {node} {value}");
                }
                // Squares of forces are no numbers: conjugate gradients end before the search does.
                (Some(Error::NotSolved { iterations: 0, .. }), Scheme::Theta(_)) => {}
                // Far out, but somewhere.
                (None, Scheme::EulerMaruyama | Scheme::Heun) => assert!(push < 1e200),
                (other, _) => panic!("{scheme:?} {push}: {other:?}"),
            }
        }
    }
}
