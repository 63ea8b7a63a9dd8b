//! Nodes that push each other away.

use peridyn_sde::{
    Body, BondConfig, BondList, Bonds, Breaking, Condition, Dynamics, Error, Horizon, Influence,
    Loading, Mobility, Nodes, Program, Real, Repulsion, Scheme, Simulation, SimulationConfig,
    Strain, SurfaceCorrection, VolumeCorrection, micromodulus,
};
use sde_integrators::Noise;

/// A lattice of spacing 1 and Young's modulus 1, its bonds, and the repulsion of the sources.
fn block<const D: usize>(sides: [f64; D], condition: Condition) -> (Nodes<D>, Bonds, Repulsion) {
    let nodes = Nodes::lattice(1.0, ([0.0; D], sides), condition, |_| true).unwrap();
    let horizon = Horizon::of_shells(3, 1.0).unwrap();
    let influence = Influence::Constant;
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

const PLATE: Condition = Condition::PlaneStress { thickness: 1.0 };

fn config(dynamics: Dynamics, dt: f64) -> SimulationConfig {
    let (breaking, noise) = (Breaking::AtEnds, Noise::new(31));
    SimulationConfig { dynamics, dt, breaking, confinement: 0.0, noise }
}

fn inertial(friction: f64, temperature: f64) -> Dynamics {
    Dynamics::Inertial { density: 1.0, friction, temperature }
}

fn overdamped(n_nodes: usize, scheme: Scheme, temperature: f64) -> Dynamics {
    let mobility = Mobility::identity(&vec![true; n_nodes], 1.0).unwrap();
    Dynamics::Overdamped { mobility, temperature, scheme }
}

type Run<T, const D: usize, const L: usize> = Simulation<T, BondList<T, D, L>, D, L>;

/// A body that never breaks.
fn simulation<T: Real, const D: usize, const L: usize>(
    (nodes, bonds): (&Nodes<D>, &Bonds),
    loading: Loading<D>,
    config: SimulationConfig,
    realisations: [u64; L],
) -> Result<Run<T, D, L>, Error>
where
    BondList<T, D, L>: Body<T, D, L>,
{
    let strengths = vec![1e3; bonds.len()];
    let body = BondList::new(nodes.clone(), bonds.clone(), Strain::Finite, &strengths)?;
    Simulation::new(body, loading, config, realisations)
}

fn free<const D: usize>(nodes: &Nodes<D>) -> Loading<D> {
    Loading::new(nodes.positions().len())
}

fn size<const D: usize>(values: &[[f64; D]]) -> f64 {
    values.iter().flatten().map(|value| value.abs()).sum()
}

/// Squeezed by a third and shaken: neighbours, diagonals and more touch.
fn squeezed<const D: usize>(nodes: &Nodes<D>) -> Vec<[f64; D]> {
    let wave = |node: usize, k: usize| (1.7 * node as f64 + 2.3 * k as f64 + 0.4).sin();
    let place = |(node, x): (usize, &[f64; D])| {
        std::array::from_fn(|k| -0.35 * x[k] + 0.05 * wave(node, k))
    };
    nodes.positions().iter().enumerate().map(place).collect()
}

fn are_slopes_of_the_energy<const D: usize>(sides: [f64; D], condition: Condition)
where
    BondList<f64, D, 1>: Body<f64, D, 1>,
{
    let (nodes, bonds, repulsion) = block(sides, condition);
    let run = simulation((&nodes, &bonds), free(&nodes), config(inertial(0.0, 0.0), 0.05), [0]);
    let mut run: Run<f64, D, 1> = run.unwrap().with_repulsion(repulsion).unwrap();
    let mut u = squeezed(&nodes);
    run.set_displacements(0, &u).unwrap();
    let forces = run.repulsion_forces(0).unwrap();
    assert!(run.repulsion_energy(0).unwrap() > 0.0);
    let (n, delta) = (u.len(), 1e-6);
    for node in [0, n / 2, n - 1] {
        for k in 0..D {
            let here = u[node][k];
            let [above, below] = [delta, -delta].map(|change| {
                u[node][k] = here + change;
                run.set_displacements(0, &u).unwrap();
                run.repulsion_energy(0).unwrap()
            });
            u[node][k] = here;
            let (slope, force) = ((above - below) / (2.0 * delta), forces[node][k]);
            // Energies of at most 100 have an error of 1e-14, their differences of 1e-8.
            assert!((slope + force).abs() < 2e-8, "{D} {node} {k}: {slope} {force}");
        }
    }
    for k in 0..D {
        let sum: f64 = forces.iter().map(|force| force[k]).sum();
        assert!(sum.abs() < 1e-14 * size(&forces), "{sum}");
    }
    assert!(forces[0][0].abs() > 1e-2, "{forces:?}");
}

#[test]
fn forces_are_minus_the_slope_of_the_energy_and_sum_to_nothing() {
    are_slopes_of_the_energy([9.0], Condition::Bar { area: 1.0 });
    are_slopes_of_the_energy([6.0; 2], PLATE);
    are_slopes_of_the_energy([4.0; 3], Condition::Solid);
}

/// Two nodes alone: one step takes the overlap by the factor `1 - z` of Euler's method, `1 - z/2` of Verlet's from rest. Beyond
/// the range of a pair the step is refused.
#[test]
fn the_step_of_a_pair_is_the_one_that_is_held_against_the_limit() {
    let bar = Condition::Bar { area: 1.0 };
    let (nodes, bonds, repulsion) = block([2.0], bar);
    let repulsion = Repulsion { stiffness: 40.0 * repulsion.stiffness, ..repulsion };
    let cases = [
        (overdamped(2, Scheme::EulerMaruyama, 0.0), 1.0),
        (overdamped(2, Scheme::Theta(0.5), 0.0), 1.0),
        (inertial(0.0, 0.0), 0.5),
    ];
    for (dynamics, part) in cases {
        let run = |dt: f64| {
            let config = config(dynamics.clone(), dt);
            let mut run: Run<f64, 1, 1> =
                simulation((&nodes, &bonds), free(&nodes), config, [0]).unwrap();
            run.cut(&[0]).unwrap();
            run.with_repulsion(repulsion)
        };
        let unit = run(1e-3).unwrap().relative_step_of_repulsion();
        let step = |value: f64| match dynamics {
            Dynamics::Overdamped { .. } => 1e-3 * value / unit,
            Dynamics::Inertial { .. } => 1e-3 * (value / unit).sqrt(),
        };
        let limit = 2.0 / part;
        let mut inside = run(step(0.6 * limit)).unwrap();
        inside.set_displacements(0, &[[0.2], [-0.2]]).unwrap();
        let _ = inside.step().unwrap();
        let u = inside.displacements(0);
        // A pair that comes to 1 - 0.4 and touches within 0.9.
        let overlap = 0.9 - (1.0 + u[1][0] - u[0][0]);
        let expected = 0.3 * (1.0 - 0.6 * 2.0);
        assert!((overlap - expected).abs() < 1e-12, "{dynamics:?} {overlap}");
        assert!(run(step(0.999 * limit)).is_ok());
        let beyond = run(step(1.001 * limit)).unwrap_err();
        let Error::Unstable { value, limit: stated, .. } = beyond else { panic!("{beyond}") };
        assert!((value - 1.001 * limit).abs() < 1e-9 && (stated - limit).abs() < 1e-12);
    }
}

/// Halves of a plate, cut along its middle and separated by two spacings, thrown at each other.
fn halves(dt: f64, repels: bool) -> (Run<f64, 2, 1>, Vec<bool>) {
    let (nodes, bonds, repulsion) = block([12.0, 6.0], PLATE);
    let is_right: Vec<bool> = nodes.positions().iter().map(|x| x[0] > 6.0).collect();
    let across = bonds.across_segment(&nodes, ([6.0, -1.0], [6.0, 7.0])).unwrap();
    let config = config(inertial(0.0, 0.0), dt);
    let mut run = simulation((&nodes, &bonds), free(&nodes), config, [0]).unwrap();
    run.cut(&across).unwrap();
    let away = |right: &bool| [if *right { 1.0 } else { -1.0 }, 0.0];
    let apart: Vec<_> = is_right.iter().map(away).collect();
    run.set_displacements(0, &apart).unwrap();
    let thrown: Vec<_> = apart.iter().map(|u| [-0.03 * u[0], 0.0]).collect();
    run.set_velocities(0, &thrown).unwrap();
    (if repels { run.with_repulsion(repulsion).unwrap() } else { run }, is_right)
}

/// The mean velocity of the right half along the axis.
fn velocity_of_right(run: &Run<f64, 2, 1>, is_right: &[bool]) -> f64 {
    let right = run.velocities(0).into_iter().zip(is_right).filter(|(_, right)| **right);
    let sum: f64 = right.map(|(v, _)| v[0]).sum();
    sum / (0.5 * is_right.len() as f64)
}

#[test]
fn bodies_that_are_thrown_at_each_other_bounce() {
    let throw = |dt: f64, repels: bool| {
        let (mut run, is_right) = halves(dt, repels);
        let kinetic = |run: &Run<f64, 2, 1>| -> f64 {
            run.velocities(0).iter().flatten().map(|v| 0.5 * v * v).sum()
        };
        let start = kinetic(&run);
        let (mut worst, mut touched) = (0.0_f64, 0.0_f64);
        while run.time() < 90.0 {
            let _ = run.step().unwrap();
            let repulsion = run.repulsion_energy(0).unwrap();
            touched = touched.max(repulsion / start);
            let total = kinetic(&run) + run.energy(0) + repulsion;
            worst = worst.max((total / start - 1.0).abs());
            let v = run.velocities(0);
            let momentum: f64 = v.iter().map(|v| v[0]).sum();
            assert!(momentum.abs() < 1e-13 * 0.03 * 72.0, "{momentum}");
        }
        (velocity_of_right(&run, &is_right), worst, touched)
    };
    let (through, _, never) = throw(0.1, false);
    assert!((through + 0.03).abs() < 1e-15 && never <= 0.0, "{through}");
    let [(_, coarse, touched), (back, fine, _)] = [0.2, 0.1].map(|dt| throw(dt, true));
    assert!(touched > 0.1 && back > 0.6 * 0.03, "{touched} {back}");
    // Of second order: four times; the moment of touching falls differently into the steps.
    assert!(fine < 2e-3 && coarse / fine > 3.0 && coarse / fine < 5.0, "{coarse:e} {fine:e}");
}

/// Compressed by 5 %, with noise: bitwise identical to a run without. By 15 %: not.
#[test]
fn nothing_acts_at_rest_nor_under_little_compression() {
    let (nodes, bonds, repulsion) = block([8.0; 2], PLATE);
    let n = nodes.positions().len();
    let end = |compression: f64, repels: bool| {
        let dynamics = overdamped(n, Scheme::Heun, 1e-6);
        let config = config(dynamics, 0.02);
        let run = simulation::<f64, 2, 8>((&nodes, &bonds), free(&nodes), config, LANES).unwrap();
        let mut run = if repels { run.with_repulsion(repulsion).unwrap() } else { run };
        let u: Vec<_> = nodes.positions().iter().map(|x| x.map(|x| -compression * x)).collect();
        run.set_displacements(3, &u).unwrap();
        for _ in 0..20 {
            let _ = run.step().unwrap();
        }
        run.save().unwrap()
    };
    for compression in [0.0, 0.05] {
        assert!(end(compression, true) == end(compression, false), "{compression}");
    }
    assert!(end(0.15, true) != end(0.15, false));
}

const LANES: [u64; 8] = [0, 1, 2, 3, 4, 5, 6, 7];

/// A plate cut through from side to side and pressed by its upper rows: the load that comes to the lower ones.
fn load_through_a_crack(repulsion: Option<Repulsion>, is_cut: bool) -> ([f64; 2], f64) {
    let (nodes, bonds, _) = block([8.0, 12.0], PLATE);
    let rows = |from: f64, to: f64| -> Vec<usize> {
        let x = nodes.positions();
        (0..x.len()).filter(|&i| x[i][1] > from && x[i][1] < to).collect()
    };
    let (lower, upper) = (rows(0.0, 2.0), rows(10.0, 12.0));
    let press = Program::Ramp { rate: -0.01, until: 60.0 };
    let loading = free(&nodes).hold(&lower).unwrap();
    let loading = loading.displace(&upper, [true; 2], [0.0, 1.0], press).unwrap();
    let config = config(inertial(0.2, 0.0), 0.25);
    let mut run: Run<f64, 2, 1> = simulation((&nodes, &bonds), loading, config, [0]).unwrap();
    if is_cut {
        let crack = bonds.across_segment(&nodes, ([-1.0, 6.0], [9.0, 6.0])).unwrap();
        run.cut(&crack).unwrap();
    }
    if let Some(repulsion) = repulsion {
        run = run.with_repulsion(repulsion).unwrap();
    }
    while run.time() < 600.0 {
        let _ = run.step().unwrap();
    }
    let forces = run.repulsion_forces(0).unwrap();
    let pushed: f64 = rows(6.0, 12.0).iter().map(|&i| forces[i][1]).sum();
    ([run.pull_on(&lower, 0)[1], run.pull_on(&upper, 0)[1]], pushed)
}

#[test]
fn a_crack_that_closes_transmits_load() {
    let (_, _, repulsion) = block([8.0, 12.0], PLATE);
    let ([lower, upper], pushed) = load_through_a_crack(Some(repulsion), true);
    // Friction has taken what moved: it is an equilibrium.
    assert!(
        (lower + upper).abs() < 1e-9 && (pushed - upper).abs() < 1e-9,
        "{lower} {upper} {pushed}"
    );
    let ([_, whole], _) = load_through_a_crack(None, false);
    assert!(upper > 0.5 * whole && upper < whole, "{upper} {whole}");
    let ([none, still], _) = load_through_a_crack(None, true);
    assert!(none.abs() < 1e-12 && still.abs() < 1e-12, "{none} {still}");
}
