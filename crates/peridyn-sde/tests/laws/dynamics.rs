//! Steps in time, whatever the body.

use peridyn_sde::law::{CriticalStretch, Memory};
use peridyn_sde::{
    Body, BondConfig, BondList, Bonds, Breaking, Cause, Condition, Dynamics, Error, Horizon,
    LatticeBody, Loading, Mobility, Network, Nodes, Program, Scheme, Simulation, SimulationConfig,
    Strain,
};

use crate::fixtures::{PLATE, at, bonded, in_time, overdamped};

/// With a horizon of three shells.
pub(super) fn plate(side: f64) -> (Nodes<2>, Bonds) {
    bonded(side, PLATE, 3)
}

/// The first columns of nodes, which are held.
fn left(nodes: &Nodes<2>) -> Vec<usize> {
    at(nodes, |x| x[0] < 1.0)
}

fn config(dynamics: Dynamics, dt: f64) -> SimulationConfig {
    in_time(dynamics, dt, 9)
}

fn all_free(nodes: &Nodes<2>) -> Vec<bool> {
    vec![true; nodes.positions().len()]
}

fn is_free(nodes: &Nodes<2>) -> Vec<bool> {
    let mut free = all_free(nodes);
    for node in left(nodes) {
        free[node] = false;
    }
    free
}

fn held(nodes: &Nodes<2>) -> Loading<2> {
    Loading::new(nodes.positions().len()).hold(&left(nodes)).unwrap()
}

const SCHEMES: [Scheme; 4] =
    [Scheme::EulerMaruyama, Scheme::LeimkuhlerMatthews, Scheme::Heun, Scheme::Theta(0.5)];

/// Displacements after steps of a hot plate whose bonds break, in some lane.
fn end<const L: usize>(
    body: impl Body<f64, 2, L> + 'static,
    nodes: &Nodes<2>,
    dynamics: Dynamics,
    ids: [u64; L],
) -> (Vec<Vec<[f64; 2]>>, usize) {
    let mut run = Simulation::new(body, held(nodes), config(dynamics, 0.02), ids).unwrap();
    let mut broken = 0;
    for _ in 0..60 {
        broken += run.step().unwrap().broken.len();
    }
    ((0..L).map(|lane| run.displacements(lane)).collect(), broken)
}

/// Lists, lattices and the reference take the same path, within rounding that grows along it; lanes are realisations of their
/// own numbers whatever their neighbours are.
#[test]
fn bodies_and_lanes_take_the_same_paths() {
    let (nodes, bonds) = plate(9.0);
    let n = bonds.len();
    for scheme in SCHEMES {
        let dynamics = || overdamped(&is_free(&nodes), scheme, 2e-3);
        let list = |strength: f64| {
            let (nodes, bonds) = (nodes.clone(), bonds.clone());
            BondList::<f64, 2, 8>::new(nodes, bonds, Strain::Finite, &vec![strength; n]).unwrap()
        };
        let (lanes, broken) = end(list(0.12), &nodes, dynamics(), [5, 9, 2, 3, 4, 6, 7, 8]);
        assert!(broken > 8, "{scheme:?}: {broken}");
        let alone = |id| {
            let (nodes, bonds) = (nodes.clone(), bonds.clone());
            BondList::<f64, 2, 1>::new(nodes, bonds, Strain::Finite, &vec![0.12; n])
                .map(|body| end(body, &plate(9.0).0, dynamics(), [id]).0)
                .unwrap()
        };
        let near = |a: &[[f64; 2]], b: &[[f64; 2]]| {
            let differences =
                a.iter().flatten().zip(b.iter().flatten()).map(|(a, b)| (a - b).abs());
            differences.fold(0.0, f64::max)
        };
        assert!(near(&lanes[1], &alone(9)[0]) < 1e-9, "{scheme:?}");
        let (others, _) = end(list(0.12), &nodes, dynamics(), [1, 9, 11, 12, 13, 14, 15, 16]);
        assert_eq!(lanes[1], others[1], "{scheme:?}");
        let lattice =
            LatticeBody::<f64, 2>::new(nodes.clone(), bonds.clone(), Strain::Finite, 0.12).unwrap();
        let (lattice, _) = end(lattice, &nodes, dynamics(), [9]);
        assert!(near(&lanes[1], &lattice[0]) < 1e-9, "{scheme:?}");
        let law = CriticalStretch;
        let network = Network::new(nodes.clone(), bonds.clone(), law, vec![0.12; n]).unwrap();
        let (network, _) = end(network, &nodes, dynamics(), [9]);
        assert!(near(&lanes[1], &network[0]) < 1e-9, "{scheme:?}");
    }
}

/// The step of a law of any kind is held against the slope of its tension at rest, as that of the fast bodies is.
#[test]
fn bodies_have_the_same_stiffest_mode() {
    let (nodes, bonds) = plate(6.0);
    let strengths = vec![0.12; bonds.len()];
    let z = |body: &mut dyn FnMut(SimulationConfig) -> Result<f64, Error>| {
        let dynamics = overdamped(&is_free(&nodes), Scheme::EulerMaruyama, 0.0);
        body(config(dynamics, 0.02)).unwrap()
    };
    let (columns, loading) = (|| (nodes.clone(), bonds.clone()), || held(&nodes));
    let list = z(&mut |config| {
        let (nodes, bonds) = columns();
        let body = BondList::<f64, 2, 1>::new(nodes, bonds, Strain::Finite, &strengths)?;
        Ok(Simulation::new(body, loading(), config, [0])?.relative_step())
    });
    let network = z(&mut |config| {
        let (nodes, bonds) = columns();
        let body = Network::new(nodes, bonds, CriticalStretch, strengths.clone())?;
        Ok(Simulation::new(body, loading(), config, [0])?.relative_step())
    });
    let worn = z(&mut |config| {
        let (nodes, bonds) = columns();
        let law = Memory::new(1.0, 1.0, (1.0, 1.0), 0.75)?;
        let body = Network::new(nodes, bonds, law, strengths.clone())?;
        Ok(Simulation::new(body, loading(), config, [0])?.relative_step())
    });
    assert!((network / list - 1.0).abs() < 1e-9, "{network} {list}");
    assert!((worn / list - 0.75).abs() < 1e-9, "{worn} {list}");
}

/// A saved and restored run is bitwise identical.
#[test]
fn a_saved_run_goes_on_to_the_same_bits() {
    let (nodes, bonds) = plate(8.0);
    let inertial = Dynamics::Inertial { density: 1.0, friction: 0.1, temperature: 2e-3 };
    let mut cases: Vec<Dynamics> =
        SCHEMES.iter().map(|&scheme| overdamped(&is_free(&nodes), scheme, 2e-3)).collect();
    cases.push(inertial);
    for dynamics in cases {
        let start = || {
            let body = BondList::<f32, 2, 16>::new(
                nodes.clone(),
                bonds.clone(),
                Strain::Finite,
                &vec![0.12; bonds.len()],
            );
            let ids = std::array::from_fn(|lane| lane as u64);
            Simulation::new(body.unwrap(), held(&nodes), config(dynamics.clone(), 0.02), ids)
                .unwrap()
        };
        let mut whole = start();
        for _ in 0..17 {
            let _ = whole.step().unwrap();
        }
        let saved = whole.save().unwrap();
        let mut resumed = start();
        resumed.restore(&saved).unwrap();
        for _ in 0..23 {
            assert_eq!(whole.step().unwrap(), resumed.step().unwrap());
        }
        assert_eq!(whole.save().unwrap(), resumed.save().unwrap(), "{dynamics:?}");
    }
}

/// Velocity Verlet keeps the energy to second order in the step; with friction it falls.
#[test]
fn verlet_keeps_the_energy_and_friction_takes_it() {
    let (nodes, bonds) = plate(8.0);
    let run = |friction: f64, steps: u32| {
        let dt = 20.0 / f64::from(steps);
        let strength = vec![10.0; bonds.len()];
        let body =
            BondList::<f64, 2, 1>::new(nodes.clone(), bonds.clone(), Strain::Finite, &strength);
        let dynamics = Dynamics::Inertial { density: 1.0, friction, temperature: 0.0 };
        let mut run =
            Simulation::new(body.unwrap(), held(&nodes), config(dynamics, dt), [0]).unwrap();
        let bent: Vec<[f64; 2]> =
            nodes.positions().iter().map(|x| [0.0, 0.01 * x[0] * x[0]]).collect();
        run.set_displacements(0, &bent).unwrap();
        let total = |run: &Simulation<f64, 2, 1>| {
            let kinetic: f64 = run.velocities(0).iter().flatten().map(|v| 0.5 * v * v).sum();
            kinetic + run.energy(0)
        };
        let start = total(&run);
        let mut worst = 0.0_f64;
        for _ in 0..steps {
            let _ = run.step().unwrap();
            worst = worst.max((total(&run) / start - 1.0).abs());
        }
        (worst, total(&run) / start)
    };
    let [(coarse, _), (fine, _)] = [100, 200].map(|steps| run(0.0, steps));
    assert!(coarse < 0.02 && coarse / fine > 3.0 && coarse / fine < 5.0, "{coarse} {fine}");
    let (_, left) = run(0.3, 200);
    assert!(left < 0.2, "{left}");
}

/// A ramp with a predictor strains a uniform plate evenly from the first step on; without, the prescribed edges break.
#[test]
fn a_predictor_strains_evenly() {
    let (nodes, bonds) = plate(12.0);
    let grips = at(&nodes, |x| x[1] < 2.0 || x[1] > 10.0);
    let n = nodes.positions().len();
    let ramp = Program::Linear { rate: 0.01 };
    let follow =
        Loading::new(n).stretch(&nodes, &grips, [true; 2], [[0.0; 2], [0.0, 1.0]], ramp).unwrap();
    let (lower, upper) = (at(&nodes, |x| x[1] < 2.0), at(&nodes, |x| x[1] > 10.0));
    let without = Loading::new(n)
        .hold(&lower)
        .unwrap()
        .displace(&upper, [true; 2], [0.0, 12.0], ramp)
        .unwrap();
    let broken = |loading: Loading<2>| {
        let body = LatticeBody::<f64, 2>::new(nodes.clone(), bonds.clone(), Strain::Finite, 0.02);
        let dynamics = overdamped(&all_free(&nodes), Scheme::EulerMaruyama, 0.0);
        let mut run = Simulation::new(body.unwrap(), loading, config(dynamics, 0.05), [0]).unwrap();
        (0..20).map(|_| run.step().unwrap().broken.len()).sum::<usize>()
    };
    assert_eq!(broken(follow), 0);
    assert!(broken(without) > 20);
}

/// In equilibrium the force on the prescribed edges is the load, whatever the mobility.
#[test]
fn a_load_is_borne_by_the_grips() {
    let (nodes, bonds) = plate(8.0);
    let last = at(&nodes, |x| x[0] > 7.0);
    let force = [3e-3, -1e-3];
    let loading = held(&nodes).force(&last, &[force; 8], Program::Constant(1.0)).unwrap();
    let dynamics = Dynamics::Inertial { density: 1.0, friction: 0.3, temperature: 0.0 };
    let body = LatticeBody::<f64, 2>::new(nodes.clone(), bonds, Strain::Finite, 1.0).unwrap();
    let mut run = Simulation::new(body, loading, config(dynamics, 0.5), [0]).unwrap();
    for _ in 0..6000 {
        let _ = run.step().unwrap();
    }
    let pull = run.pull_on(&left(&nodes), 0);
    for k in 0..2 {
        assert!((pull[k] - 8.0 * force[k]).abs() < 1e-12, "{pull:?}");
    }
}

#[test]
fn reports_name_the_bond_the_step_and_the_cause() {
    let bar = Condition::Bar { area: 1.0 };
    let nodes = Nodes::new(vec![[0.0], [1.0], [2.0]], vec![1.0; 3], 1.0, bar).unwrap();
    let bonds =
        Bonds::new(&nodes, &BondConfig::uncorrected(Horizon::of_shells(1, 1.0).unwrap(), 1.0))
            .unwrap();
    let body = BondList::<f64, 1, 1>::new(nodes, bonds, Strain::Linear, &[0.1, 0.5]).unwrap();
    let loading = Loading::new(3)
        .hold(&[0, 2])
        .unwrap()
        .displace(&[1], [true], [1.0], Program::Linear { rate: 1.0 })
        .unwrap();
    let dynamics = overdamped(&[true; 3], Scheme::EulerMaruyama, 0.0);
    let mut run = Simulation::new(body, loading, config(dynamics, 0.03), [7]).unwrap();
    // After four steps the stretch is 0.12; the forces of the fifth find it.
    let reports = (0..6).map(|_| run.step().unwrap());
    let reports: Vec<_> = reports.filter(|report| !report.broken.is_empty()).collect();
    let [report] = &reports[..] else { panic!("{reports:?}") };
    assert_eq!((report.step, report.broken.len()), (5, 1));
    assert_eq!((report.broken[0].bond, report.broken[0].cause), (0, Cause::Stretch));
}

#[test]
fn what_cannot_be_is_refused() {
    let (nodes, bonds) = plate(6.0);
    let body = || {
        BondList::<f64, 2, 1>::new(
            nodes.clone(),
            bonds.clone(),
            Strain::Finite,
            &vec![1.0; bonds.len()],
        )
        .unwrap()
    };
    let new = |config: SimulationConfig| {
        Simulation::new(body(), held(&nodes), config, [0]).map(|run| run.relative_step())
    };
    let cold = |scheme| overdamped(&is_free(&nodes), scheme, 0.0);
    let z = new(config(cold(Scheme::EulerMaruyama), 0.01)).unwrap() / 0.01;
    assert!(new(config(cold(Scheme::EulerMaruyama), 1.98 / z)).is_ok());
    let beyond = new(config(cold(Scheme::EulerMaruyama), 2.02 / z)).unwrap_err();
    assert!(matches!(beyond, Error::Unstable { value, .. } if (value - 2.02).abs() < 1e-9));
    assert!(new(config(cold(Scheme::Theta(0.5)), 20.0 / z)).is_ok());
    assert!(matches!(
        new(config(cold(Scheme::EulerMaruyama), f64::NAN)),
        Err(Error::Parameter { name: "step", .. })
    ));
    let negative = overdamped(&is_free(&nodes), Scheme::Heun, -1.0);
    assert!(matches!(new(config(negative, 0.01)), Err(Error::Parameter { .. })));
    let beyond = new(config(cold(Scheme::Theta(1.5)), 0.01)).unwrap_err();
    assert_eq!(beyond.to_string(), "theta is 1.5; it must lie between 0 and 1");
    let mut bridge = config(overdamped(&is_free(&nodes), Scheme::LeimkuhlerMatthews, 1.0), 0.01);
    bridge.breaking = Breaking::Bridge;
    assert_eq!(new(bridge).unwrap_err(), Error::NoPathBetween);
    // A mobility that couples nodes must know which are held.
    let n = nodes.positions().len();
    let matrix: Vec<f64> =
        (0..n * n).map(|at| if at % (n + 1) == 0 { 2.0 } else { 0.001 }).collect();
    let mobility = Mobility::from_matrix(&all_free(&nodes), &matrix).unwrap();
    let coupled =
        Dynamics::Overdamped { mobility, temperature: 0.0, scheme: Scheme::EulerMaruyama };
    assert_eq!(new(config(coupled, 0.01)).unwrap_err(), Error::MobilityOfPrescribed { node: 0 });
}

/// Beyond what numbers hold a run ends with step, time, node and realisation: here by a force that pulls without end.
#[test]
fn a_lost_path_is_named() {
    let (nodes, bonds) = plate(6.0);
    let loading =
        Loading::new(nodes.positions().len()).force(&[35], &[[1e308, 0.0]], Program::Constant(1.0));
    let body = BondList::<f64, 2, 1>::new(
        nodes.clone(),
        bonds.clone(),
        Strain::Finite,
        &vec![1.0; bonds.len()],
    );
    let dynamics = overdamped(&all_free(&nodes), Scheme::EulerMaruyama, 0.0);
    let mut run =
        Simulation::new(body.unwrap(), loading.unwrap(), config(dynamics, 0.05), [4]).unwrap();
    let error = (0..1000).find_map(|_| run.step().err()).unwrap();
    assert!(matches!(error, Error::Lost { realisation: 4, .. }), "{error}");
}
