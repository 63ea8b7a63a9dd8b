//! The linear peridynamic solid: forces, energy and moduli.

use peridyn_sde::{
    AtStrength, Body, BondConfig, BondList, Bonds, Condition, Influence, Loading, Nodes, Scheme,
    Simulation, SimulationConfig, SolidBonds, Strain, SurfaceCorrection, VolumeCorrection,
};

use crate::fixtures::{self, cube, in_time, overdamped, rows, shaken};

pub(super) const PLANE_STRESS: Condition = Condition::PlaneStress { thickness: 0.5 };
const PLANE_STRAIN: Condition = Condition::PlaneStrain { thickness: 0.5 };
const BAR: Condition = Condition::Bar { area: 2.0 };

pub(super) fn config(shells: u32) -> BondConfig {
    BondConfig { volume_correction: VolumeCorrection::Partial, ..fixtures::config(shells) }
}

/// One realisation in double precision.
pub(super) type One<const D: usize> = BondList<f64, D, 1>;

/// With bonds that break at a stretch.
pub(super) fn one<const D: usize>(
    nodes: &Nodes<D>,
    solid: &SolidBonds,
    strain: Strain,
    strength: f64,
) -> One<D> {
    let strengths = vec![strength; solid.bonds().len()];
    BondList::of_solid(nodes.clone(), solid.clone(), strain, &strengths).unwrap()
}

pub(super) fn body<const D: usize>(nodes: &Nodes<D>, config: &BondConfig, nu: f64) -> One<D> {
    one(nodes, &SolidBonds::new(nodes, config, nu).unwrap(), Strain::Finite, 10.0)
}

fn forces<const D: usize>(body: &mut One<D>, u: &[[f64; D]]) -> Vec<[f64; D]> {
    let mut forces = vec![[0.0; D]; u.len()];
    body.forces(u.as_flattened(), forces.as_flattened_mut(), AtStrength::Hold).unwrap();
    forces
}

fn largest<const D: usize>(forces: &[[f64; D]]) -> f64 {
    forces.iter().flatten().fold(0.0, |most, f| most.max(f.abs()))
}

fn are_slopes_of_the_energy<const D: usize>(condition: Condition, nu: f64, strain: Strain) {
    for surface_correction in [SurfaceCorrection::None, SurfaceCorrection::Energy] {
        let nodes = cube::<D>(if D == 3 { 4.0 } else { 6.0 }, condition);
        let config = BondConfig { surface_correction, ..config(2) };
        let solid = SolidBonds::new(&nodes, &config, nu).unwrap();
        let mut body = one(&nodes, &solid, strain, 10.0);
        for bond in [0, 3] {
            body.set_intact(bond, 0);
        }
        let n = body.nodes().positions().len();
        let mut u = shaken::<D>(n, 0.03);
        let forces = forces(&mut body, &u);
        for node in [0, n / 2, n - 1] {
            for k in 0..D {
                let (delta, here) = (1e-6, u[node][k]);
                let mut energy_at = |place: f64| {
                    u[node][k] = place;
                    body.energy(u.as_flattened(), 0)
                };
                let slope = (energy_at(here + delta) - energy_at(here - delta)) / (2.0 * delta);
                u[node][k] = here;
                // The energy of some 1e-2 has an error of 1e-17, its difference of 1e-11.
                assert!((slope + forces[node][k]).abs() < 1e-9, "{slope} {}", forces[node][k]);
            }
        }
        for k in 0..D {
            let sum: f64 = forces.iter().map(|f| f[k]).sum();
            assert!(sum.abs() < 1e-13 * n as f64 * largest(&forces), "{sum}");
        }
    }
}

#[test]
fn forces_are_minus_the_slope_of_the_energy_and_sum_to_nothing() {
    for nu in [-0.3, 0.1, 0.45] {
        are_slopes_of_the_energy::<1>(BAR, nu, Strain::Finite);
        are_slopes_of_the_energy::<2>(PLANE_STRESS, nu, Strain::Finite);
        are_slopes_of_the_energy::<2>(PLANE_STRAIN, nu, Strain::Finite);
        are_slopes_of_the_energy::<3>(Condition::Solid, nu, Strain::Finite);
        are_slopes_of_the_energy::<2>(PLANE_STRESS, nu, Strain::Linear);
    }
}

#[test]
fn a_rigid_motion_has_no_force() {
    let nodes = cube::<3>(5.0, Condition::Solid);
    let mut body = body(&nodes, &config(3), 0.4);
    let (sin, cos) = 0.7_f64.sin_cos();
    let turned = |x: &[f64; 3]| [cos * x[0] - sin * x[1], sin * x[0] + cos * x[1], x[2] + 3.0];
    let rigid = |x: &[f64; 3]| {
        let to = turned(x);
        [0, 1, 2].map(|k| to[k] - x[k])
    };
    let u: Vec<[f64; 3]> = nodes.positions().iter().map(rigid).collect();
    // Strains of 1e-16 on moduli of 1 and areas of 25.
    assert!(largest(&forces(&mut body, &u)) < 1e-13);
    // And the angular momentum of forces about the deformed places is nothing.
    let u = shaken::<3>(125, 0.05);
    let forces = forces(&mut body, &u);
    let moment = |a: usize, b: usize| -> f64 {
        let of = |((x, u), f): ((&[f64; 3], &[f64; 3]), &[f64; 3])| {
            (x[a] + u[a]) * f[b] - (x[b] + u[b]) * f[a]
        };
        nodes.positions().iter().zip(&u).zip(&forces).map(of).sum()
    };
    for (a, b) in [(0, 1), (1, 2), (2, 0)] {
        assert!(moment(a, b).abs() < 1e-12 * largest(&forces) * 125.0, "{}", moment(a, b));
    }
}

#[test]
fn the_order_of_nodes_changes_rounding_alone() {
    let nodes = cube::<2>(7.0, PLANE_STRAIN);
    let (n, u) = (49, shaken::<2>(49, 0.04));
    let order: Vec<usize> = (0..n).map(|node| node * 19 % n).collect();
    let positions = order.iter().map(|&node| nodes.positions()[node]).collect();
    let volumes = order.iter().map(|&node| nodes.volumes()[node]).collect();
    let permuted = Nodes::new(positions, volumes, 1.0, PLANE_STRAIN).unwrap();
    let moved: Vec<[f64; 2]> = order.iter().map(|&node| u[node]).collect();
    let [one, other] = [(&nodes, &u), (&permuted, &moved)]
        .map(|(nodes, u)| forces(&mut body(nodes, &config(3), 0.1), u));
    for (at, &node) in order.iter().enumerate() {
        for k in 0..2 {
            assert!((one[node][k] - other[at][k]).abs() < 1e-14 * largest(&one) * 30.0);
        }
    }
}

/// The node in the middle of a body larger than its horizon, whose energy is that of the interior.
fn middle<const D: usize>(nodes: &Nodes<D>) -> usize {
    nodes.positions().len() / 2
}

fn linear<const D: usize>(nodes: &Nodes<D>, gradient: [[f64; D]; D]) -> Vec<[f64; D]> {
    let field = |x: &[f64; D]| gradient.map(|row| (0..D).map(|k| row[k] * x[k]).sum::<f64>());
    nodes.positions().iter().map(field).collect()
}

/// Strains as random as their indices.
fn strain<const D: usize>(of: usize) -> [[f64; D]; D] {
    let entry = |a: usize, b: usize| {
        1e-3 * (0.7 + 3.1 * of as f64 + 1.9 * (a + b) as f64 + (a * b) as f64).sin()
    };
    std::array::from_fn(|a| std::array::from_fn(|b| entry(a, b)))
}

/// Where Poisson's ratio is that of bonds, every homogeneous strain has the energy of bonds of the same influence, times the ratio
/// of weighted volumes.
fn is_bond_based<const D: usize>(condition: Condition, nu: f64) {
    for influence in Influence::ALL {
        let config = BondConfig { influence, ..config(2) };
        let nodes = cube::<D>(7.0, condition);
        let bonds = Bonds::new(&nodes, &config).unwrap();
        let solid = SolidBonds::new(&nodes, &config, nu).unwrap();
        let i = middle(&nodes);
        // S delta^(D + 2) int omega q^D dq, times what is across.
        let power = u32::try_from(D).unwrap();
        let surface = [2.0, 2.0 * std::f64::consts::PI, 4.0 * std::f64::consts::PI][D - 1];
        let continuum = surface * condition.across() * influence.moment(power);
        let continuum = continuum * config.horizon.radius().powi(i32::try_from(D).unwrap() + 2);
        let ratio = continuum / solid.weighted_volumes()[i];
        let body = one(&nodes, &solid, Strain::Linear, 10.0);
        for of in 0..4 {
            let gradient = strain::<D>(of);
            let u = linear(&nodes, gradient);
            let mut of_bonds = 0.0;
            for ((a, b), bond) in
                bonds.pairs().zip(bonds.all()).filter(|&((a, b), _)| a == i || b == i)
            {
                let x = nodes.positions();
                let e: f64 = (0..D).map(|k| (u[b][k] - u[a][k]) * (x[b][k] - x[a][k])).sum();
                of_bonds += 0.25 * bond.stiffness * e * e / bond.length.powi(3);
            }
            let energy = solid.energies(&body, u.as_flattened(), 0)[i];
            assert!(
                (energy / (ratio * of_bonds) - 1.0).abs() < 1e-12,
                "{energy} {ratio} {of_bonds}"
            );
        }
    }
}

#[test]
fn at_poissons_ratio_of_bonds_it_is_the_law_of_bonds() {
    is_bond_based::<1>(BAR, 0.5 - 1e-15);
    is_bond_based::<2>(PLANE_STRESS, 1.0 / 3.0);
    is_bond_based::<2>(PLANE_STRAIN, 0.25);
    is_bond_based::<3>(Condition::Solid, 0.25);
}

/// The energy density of an elastic body.
fn elastic<const D: usize>(condition: Condition, nu: f64, e: [[f64; D]; D]) -> f64 {
    let g = 1.0 / (2.0 * (1.0 + nu));
    let lame = match condition {
        Condition::Bar { .. } => 2.0 * g * nu,
        Condition::PlaneStress { .. } => nu / (1.0 - nu * nu),
        _ => nu / ((1.0 + nu) * (1.0 - 2.0 * nu)),
    };
    let trace: f64 = (0..D).map(|k| e[k][k]).sum();
    0.5 * lame * trace * trace + g * e.iter().flatten().map(|e| e * e).sum::<f64>()
}

fn has_the_elastic_energy<const D: usize>(condition: Condition) {
    for nu in [0.1, 0.25, 0.45] {
        let nodes = cube::<D>(9.0, condition);
        let solid = SolidBonds::new(&nodes, &config(3), nu).unwrap();
        let (i, body) = (middle(&nodes), one(&nodes, &solid, Strain::Finite, 10.0));
        let energy = |gradient| {
            let u = linear(&nodes, gradient);
            solid.energies(&body, u.as_flattened(), 0)[i] / nodes.volumes()[i]
        };
        let mut extension = [[0.0; D]; D];
        for k in 0..D {
            extension[k][k] = 1e-7;
        }
        let ratio = energy(extension) / elastic(condition, nu, extension);
        assert!((ratio - 1.0).abs() < 2e-7, "{condition:?} {nu} {ratio}");
        // The fourth moments of a square lattice of three shells are within 0.3 % of isotropic, of a cubic one within 4 %.
        let bound = if D == 3 { 0.04 } else { 3e-3 };
        for of in 0..4 {
            let gradient = strain::<D>(of).map(|row| row.map(|e| 1e-4 * e));
            let ratio = energy(gradient) / elastic(condition, nu, gradient);
            assert!((ratio - 1.0).abs() < bound, "{condition:?} {nu} {of} {ratio}");
        }
    }
}

#[test]
fn a_homogeneous_strain_has_the_energy_of_the_elastic_body() {
    has_the_elastic_energy::<1>(BAR);
    has_the_elastic_energy::<2>(PLANE_STRESS);
    has_the_elastic_energy::<2>(PLANE_STRAIN);
    has_the_elastic_energy::<3>(Condition::Solid);
}

/// Equilibrium under forces.
fn at_rest<const D: usize>(
    body: &mut One<D>,
    load: &[[f64; D]],
    is_held: &dyn Fn(usize) -> bool,
) -> Vec<[f64; D]> {
    let forces = |u: &[f64], forces: &mut [f64]| {
        body.linear_forces(u, forces).unwrap();
        for (node, force) in forces.as_chunks_mut::<D>().0.iter_mut().enumerate() {
            if is_held(node) {
                *force = [0.0; D];
            }
        }
    };
    let u = fixtures::at_rest(load.as_flattened(), 1e-18, forces);
    u.as_chunks().0.to_vec()
}

/// Poisson's ratio between the nodes beside the middle of a bar in two dimensions that is pulled at its ends.
fn poisson_ratio(
    condition: Condition,
    nu: f64,
    config: &BondConfig,
    (length, width): (f64, f64),
) -> f64 {
    let nodes = Nodes::lattice(1.0, ([0.0; 2], [length, width]), condition, |_| true).unwrap();
    let mut body = body(&nodes, config, nu);
    let load = |x: &[f64; 2]| {
        let pull = f64::from(x[0] > length - 3.0) - f64::from(x[0] < 3.0);
        [pull, 0.0]
    };
    let load: Vec<[f64; 2]> = nodes.positions().iter().map(load).collect();
    let u = at_rest(&mut body, &load, &|_| false);
    let elongation = |k: usize| {
        let at = |side: f64| {
            let mut place = [0.5 * length, 0.5 * width];
            place[k] += side;
            let near = |x: &[f64; 2]| (0..2).all(|k| (x[k] - place[k]).abs() < 0.1);
            u[nodes.positions().iter().position(near).unwrap()][k]
        };
        at(1.0) - at(-1.0)
    };
    -elongation(1) / elongation(0)
}

/// Under a pull the middle of a bar contracts by Poisson's ratio of the material. The fourth moments of a square lattice decide how
/// well: at 6 shells they are within 0.1 % of isotropic.
#[test]
fn a_bar_contracts_by_poissons_ratio() {
    let (surface_correction, volume_correction) =
        (SurfaceCorrection::Energy, VolumeCorrection::None);
    let influence = Influence::Conical;
    let config = BondConfig { surface_correction, volume_correction, influence, ..config(6) };
    for nu in [0.1, 0.2, 0.3, 0.45] {
        let ratio = poisson_ratio(PLANE_STRESS, nu, &config, (101.0, 41.0)) / nu;
        assert!((ratio - 1.0).abs() < 0.01, "{nu}: {ratio}");
    }
}

#[test]
fn forces_are_those_of_lammps() {
    let text = include_str!("../data/lammps_lps_forces_60.json");
    let data: serde_json::Value = serde_json::from_str(text).unwrap();
    let [x0, x, theirs, exact] = ["x0", "x", "f", "exact"].map(|name| rows(&data[name]));
    let volumes: Vec<f64> =
        data["volumes"].as_array().unwrap().iter().map(|v| v.as_f64().unwrap()).collect();
    let u: Vec<[f64; 3]> =
        x.iter().zip(&x0).map(|(x, x0)| std::array::from_fn(|k| x[k] - x0[k])).collect();
    let nodes = Nodes::new(x0, volumes.clone(), 1.0, Condition::Solid).unwrap();
    // K = 1, G = 0.4: E = 9 K G/(3 K + G), nu = (3 K - 2 G)/(2 (3 K + G)).
    let config = BondConfig { young_modulus: 3.6 / 3.4, ..config(3) };
    let forces = forces(&mut body(&nodes, &config, 2.2 / 6.8), &u);
    let off = |expected: &[[f64; 3]]| {
        let mut worst = 0.0_f64;
        for ((force, volume), expected) in forces.iter().zip(&volumes).zip(expected) {
            for k in 0..3 {
                worst = worst.max((force[k] / volume - expected[k]).abs());
            }
        }
        worst / largest(expected)
    };
    // The series errs by 8.4e-13 of a pull. Theirs err by 1.2e-14 of the largest against the same sums in 40 digits.
    assert!(off(&theirs) < 1e-12 && off(&exact) < 1e-12, "{:e} {:e}", off(&theirs), off(&exact));
}

/// Long runs of a small plate with linear strains: `cov(a u, b u) = kT a K^-1 b`, by an exact scheme far from small steps.
#[test]
fn the_stationary_covariance_is_kt_over_the_stiffness() {
    const TEMPERATURE: f64 = 0.7;
    const BATCHES: usize = 64;
    let nodes = cube::<2>(4.0, PLANE_STRESS);
    let solid = SolidBonds::new(&nodes, &config(2), 0.05).unwrap();
    let mut body = one(&nodes, &solid, Strain::Linear, 10.0);
    let is_held = |node: usize| node.is_multiple_of(4);
    let held: Vec<usize> = (0..16).filter(|&node| is_held(node)).collect();
    let free: Vec<bool> = (0..16).map(|node| !is_held(node)).collect();
    let weights = |of: f64| -> Vec<[f64; 2]> {
        let entry = |node: usize, k: usize| (of + 1.3 * node as f64 + 2.1 * k as f64).sin();
        (0..16).map(|i| [0, 1].map(|k| if is_held(i) { 0.0 } else { entry(i, k) })).collect()
    };
    let pairs = [(0.0, 0.0), (0.0, 0.9), (0.9, 0.9), (2.0, 0.9)];
    let dot = |a: &[[f64; 2]], b: &[[f64; 2]]| -> f64 {
        a.iter().flatten().zip(b.iter().flatten()).map(|(a, b)| a * b).sum()
    };
    let exact = pairs
        .map(|(a, b)| TEMPERATURE * dot(&weights(a), &at_rest(&mut body, &weights(b), &is_held)));
    let config = in_time(overdamped(&free, Scheme::LeimkuhlerMatthews, TEMPERATURE), 1.0, 8);
    let loading = || Loading::new(16).hold(&held).unwrap();
    let small = SimulationConfig { dt: 1e-6, ..config.clone() };
    let z = Simulation::new(body.clone(), loading(), small, [0]).unwrap().relative_step();
    let config = SimulationConfig { dt: 1.2e-6 / z, ..config };
    let mut run = Simulation::new(body, loading(), config, [0]).unwrap();
    for _ in 0..2000 {
        let _ = run.step().unwrap();
    }
    let mut means = vec![[0.0; 4]; BATCHES];
    for mean in &mut means {
        for _ in 0..2000 {
            let _ = run.step().unwrap();
            let u = run.displacements(0);
            for (mean, (a, b)) in mean.iter_mut().zip(pairs) {
                *mean += dot(&weights(a), &u) * dot(&weights(b), &u) / 2000.0;
            }
        }
    }
    for (of, exact) in exact.iter().enumerate() {
        let mean = means.iter().map(|batch| batch[of]).sum::<f64>() / BATCHES as f64;
        let square: f64 = means.iter().map(|batch| (batch[of] - mean).powi(2)).sum();
        let error = (square / (BATCHES * (BATCHES - 1)) as f64).sqrt();
        assert!((mean - exact).abs() < 4.0 * error, "{of}: {mean} +- {error}, {exact}");
        // The test sees an error of 10 % of a variance.
        assert!(of % 2 == 1 || error < 0.025 * exact, "{of}: {error} of {exact}");
    }
}
