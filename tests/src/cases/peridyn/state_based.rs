//! The linear peridynamic solid: forces against LAMMPS, Poisson's ratio, the work of a crack, the stationary law.

use peridyn_sde::{
    AtStrength, Body, BondConfig, BondList, Condition, Horizon, Influence, LatticeBody, Nodes,
    SolidBonds, Strain, SurfaceCorrection, VolumeCorrection, critical_stretch_of_solid,
};
use serde::Deserialize;

use super::state_based_law;
use crate::case::{Case, CaseError, Context, Profile, Schedule};
use crate::cases::lines::Lines;
use crate::cases::worst::Worst;
use crate::report::Claim;

pub(crate) const CASE: Case = Case {
    id: "peridyn-sde/state-based",
    title: "Linear peridynamic solid: forces on 60 random nodes against LAMMPS peri/lps, Poisson's ratio of a bar, the work of a crack, covariance against kT K^-1",
    source: "LAMMPS 22Jul2025 peri/lps, lammps_lps_forces_60.json, with the same sums in 40 digits; Silling et al. 2007",
    cost: Profile::Quick,
    schedule: Schedule::Together,
    run,
};

#[derive(Debug, Deserialize)]
struct Lammps {
    bulk_modulus: f64,
    shear_modulus: f64,
    volumes: Vec<f64>,
    x0: Vec<[f64; 3]>,
    x: Vec<[f64; 3]>,
    /// Force densities.
    f: Vec<[f64; 3]>,
    /// The same by arithmetic of 40 digits.
    exact: Vec<[f64; 3]>,
}

const PLATE: Condition = Condition::PlaneStress { thickness: 1.0 };

fn config(shells: u32) -> Result<BondConfig, CaseError> {
    Ok(BondConfig {
        horizon: Horizon::of_shells(shells, 1.0)?,
        young_modulus: 1.0,
        influence: Influence::Constant,
        volume_correction: VolumeCorrection::Partial,
        surface_correction: SurfaceCorrection::None,
    })
}

/// One realisation in double precision, whose bonds break at a stretch.
type One<const D: usize> = BondList<f64, D, 1>;

fn one<const D: usize>(
    nodes: Nodes<D>,
    solid: SolidBonds,
    strain: Strain,
    strength: f64,
) -> Result<One<D>, CaseError> {
    let strengths = vec![strength; solid.bonds().len()];
    Ok(BondList::of_solid(nodes, solid, strain, &strengths)?)
}

/// The largest difference over the largest entry of the second.
fn off(found: &[f64], exact: &[f64]) -> f64 {
    let largest = exact.iter().fold(0.0, |most: f64, f| most.max(f.abs()));
    let apart = found.iter().zip(exact).map(|(f, e)| (f - e).abs() / largest);
    apart.fold(0.0, |most: f64, e| if e.is_nan() { f64::INFINITY } else { most.max(e) })
}

fn run(context: &Context<'_>) -> Result<Vec<Claim>, CaseError> {
    let mut claims = lammps(context)?;
    claims.push(lattice(context)?);
    claims.push(bar(context)?);
    claims.push(crack(context)?);
    claims.extend(state_based_law::claims(context)?);
    Ok(claims)
}

fn lammps(context: &Context<'_>) -> Result<Vec<Claim>, CaseError> {
    let text = include_str!("../../../reference/derived/peridyn/lammps_lps_forces_60.json");
    let data: Lammps = serde_json::from_str(text)?;
    let (k, g) = (data.bulk_modulus, data.shear_modulus);
    let config = BondConfig { young_modulus: 9.0 * k * g / (3.0 * k + g), ..config(3)? };
    let u: Vec<f64> =
        data.x.iter().flatten().zip(data.x0.iter().flatten()).map(|(x, x0)| x - x0).collect();
    let nodes = Nodes::new(data.x0, data.volumes.clone(), 1.0, Condition::Solid)?;
    let solid = SolidBonds::new(&nodes, &config, (3.0 * k - 2.0 * g) / (2.0 * (3.0 * k + g)))?;
    let mut body = one(nodes, solid, Strain::Finite, 10.0)?;
    let mut forces = vec![0.0; u.len()];
    body.forces(&u, &mut forces, AtStrength::Hold)?;
    let of_density = |densities: &[[f64; 3]]| -> Vec<f64> {
        let volumes = data.volumes.iter().flat_map(|&volume| [volume; 3]);
        densities.as_flattened().iter().zip(volumes).map(|(f, volume)| f * volume).collect()
    };
    let method = "60 nodes at random places, volumes 0.5 to 1.5, horizon 3.015, partial volumes, nu = 0.32, strains up to 2e-2";
    let lines = Lines { context, id: "lammps", method: method.into() };
    let what = "largest difference of a force, over the largest force";
    Ok(vec![
        lines.bounded(
            ("forces", what, ""),
            off(&forces, &of_density(&data.f)),
            2e-12,
            "the series of the list, 8.4e-13 of the pull of a bond within its range; LAMMPS takes the elongation as a difference of lengths: its own roundoff is 1.2e-14 here; displacements are differences of its rounded places",
        ),
        lines.bounded(
            ("forces/exact", &format!("{what}, of sums in 40 digits"), ""),
            off(&forces, &of_density(&data.exact)),
            2e-12,
            "the series of the list, 8.4e-13 of the pull of a bond within its range",
        ),
    ])
}

/// The lattice path of a plate and a block against the list.
fn lattice(context: &Context<'_>) -> Result<Claim, CaseError> {
    fn of<const D: usize>(condition: Condition, side: f64) -> Result<f64, CaseError> {
        let nodes = Nodes::lattice(1.0, ([0.0; D], [side; D]), condition, |_| true)?;
        let solid = SolidBonds::new(&nodes, &config(3)?, 0.4)?;
        let n = nodes.positions().len() * D;
        let u: Vec<f64> = (0..n).map(|at| 0.01 * (1.7 * at as f64).sin()).collect();
        let (mut exact, mut found) = (vec![0.0; n], vec![0.0; n]);
        one(nodes.clone(), solid.clone(), Strain::Finite, 10.0)?.forces(
            &u,
            &mut exact,
            AtStrength::Hold,
        )?;
        LatticeBody::<f64, D>::of_solid(nodes, solid, Strain::Finite, 10.0)?.forces(
            &u,
            &mut found,
            AtStrength::Hold,
        )?;
        Ok(off(&found, &exact))
    }
    let mut worst = Worst::default();
    worst.take(of::<2>(PLATE, 21.0)?, "plate");
    worst.take(of::<3>(Condition::Solid, 9.0)?, "block");
    let method =
        worst.method("lattice path in f64, 21 x 21 and 9 x 9 x 9 nodes, strains up to 2e-2");
    Ok(Lines { context, id: "lattice", method }.bounded(
        ("forces", "largest difference of a force to the list, over the largest", ""),
        worst.value(),
        2e-12,
        "both add the same forces in another order; of elongations that differ by roundoff the series may differ by its error, 8.4e-13 of a pull",
    ))
}

/// Equilibrium under forces, by conjugate gradients.
fn at_rest(body: &mut One<2>, load: &[f64]) -> Result<Vec<f64>, CaseError> {
    let dot = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
    let (mut u, mut r) = (vec![0.0; load.len()], load.to_vec());
    let (mut p, mut image, mut square) = (r.clone(), r.clone(), dot(&r, &r));
    let end = 1e-18 * square;
    for _ in 0..10_000 {
        if square <= end {
            return Ok(u);
        }
        body.linear_forces(&p, &mut image)?;
        let along = -square / dot(&p, &image);
        let next: f64 = (0..r.len())
            .map(|at| {
                u[at] += along * p[at];
                r[at] += along * image[at];
                r[at] * r[at]
            })
            .sum();
        for (p, r) in p.iter_mut().zip(&r) {
            *p = r + next / square * *p;
        }
        square = next;
    }
    Err("conjugate gradients did not end".into())
}

/// Poisson's ratio in the middle of a bar that is pulled at its ends, over that of the material.
fn bar(context: &Context<'_>) -> Result<Claim, CaseError> {
    let (length, width) = (101.0, 41.0);
    let mut worst = Worst::default();
    for nu in [0.1, 0.2, 0.3, 0.45] {
        let nodes = Nodes::lattice(1.0, ([0.0; 2], [length, width]), PLATE, |_| true)?;
        let config = BondConfig {
            influence: Influence::Conical,
            volume_correction: VolumeCorrection::None,
            surface_correction: SurfaceCorrection::Energy,
            ..config(6)?
        };
        let solid = SolidBonds::new(&nodes, &config, nu)?;
        let x = nodes.positions().to_vec();
        let pull = |x: &[f64; 2]| f64::from(x[0] > length - 3.0) - f64::from(x[0] < 3.0);
        let load: Vec<f64> = x.iter().flat_map(|x| [pull(x), 0.0]).collect();
        let mut body = one(nodes, solid, Strain::Finite, 10.0)?;
        let u = at_rest(&mut body, &load)?;
        let middle = x.len() / 2;
        let row = x.iter().position(|x| x[1] > 1.0).ok_or("one row")?;
        let along = u[2 * (middle + 1)] - u[2 * (middle - 1)];
        let across = u[2 * (middle + row) + 1] - u[2 * (middle - row) + 1];
        worst.take((-across / (along * nu) - 1.0).abs(), &format!("nu = {nu}"));
    }
    let method = worst.method("plane stress, bar of 101 x 41 nodes, 6 shells, conical influence, surface correction, between the nodes beside its middle");
    Ok(Lines { context, id: "bar", method }.bounded(
        ("poisson-ratio", "contraction over extension, relative to Poisson's ratio from 0.1 to 0.45", ""),
        worst.value(),
        0.01,
        "aim of 1 %; the fourth moments of 6 shells of a square lattice alone are off by 0.9 % at nu = 0.1",
    ))
}

/// The work of moving two rigid halves of a plate from each other for each unit of area, over the energy release rate.
fn work(config: &BondConfig, nu: f64, stretch: f64) -> Result<f64, CaseError> {
    let far = 4.0 * stretch * config.horizon.radius();
    let shells = config.horizon.radius().floor();
    let (height, width) = (4.0 * shells + 2.0, 4.0 * shells + 3.0);
    let nodes = Nodes::lattice(1.0, ([0.0; 2], [height, width]), PLATE, |_| true)?;
    let solid = SolidBonds::new(&nodes, config, nu)?;
    let mut body = one(nodes, solid, Strain::Linear, stretch)?;
    let x = body.nodes().positions().to_vec();
    let is_upper = |x: &[f64; 2]| x[0] > 0.5 * height;
    let apart = |opening: f64| -> Vec<f64> {
        x.iter().flat_map(|x| [if is_upper(x) { opening } else { 0.0 }, 0.0]).collect()
    };
    // Nodes on the line through the middle: each has the area of one spacing.
    let line = |x: &[f64; 2]| is_upper(x) && (x[1] - 0.5 * width).abs() < 0.1;
    let (steps, mut work, mut before) = (400, 0.0, 0.0);
    let mut forces = vec![0.0; 2 * x.len()];
    for step in 1..=steps {
        let to = apart(far * f64::from(step) / f64::from(steps));
        let mut broken = Vec::new();
        body.forces(&to, &mut forces, AtStrength::Break(&mut broken))?;
        for found in broken {
            body.set_intact(found.bond, 0);
        }
        body.forces(&to, &mut forces, AtStrength::Hold)?;
        let pulls = x.iter().enumerate().filter(|(_, x)| line(x));
        let now: f64 = pulls.map(|(node, _)| -forces[2 * node]).sum();
        work += 0.5 * (before + now) * far / f64::from(steps);
        before = now;
    }
    Ok(work)
}

fn crack(context: &Context<'_>) -> Result<Claim, CaseError> {
    const G0: f64 = 1e-6;
    let mut worst = Worst::default();
    for (shells, nu) in [(3, 0.1), (3, 0.45), (4, 0.2), (5, 0.3)] {
        let config = BondConfig { volume_correction: VolumeCorrection::Ramp, ..config(shells)? };
        let BondConfig { horizon, influence, .. } = config;
        let stretch = critical_stretch_of_solid(G0, (1.0, nu), horizon, influence, PLATE)?;
        let place = format!("{shells} shells, nu = {nu}");
        worst.take((work(&config, nu, stretch)? / G0 - 1.0).abs(), &place);
    }
    let method = worst.method("plane stress, two rigid halves moved from each other in 400 steps, volumes with a ramp, 3 to 5 shells, nu from 0.1 to 0.45");
    Ok(Lines { context, id: "crack", method }.bounded(
        ("stretch", "work for each unit of area, relative to the energy release rate", ""),
        worst.value(),
        0.03,
        "aim of 3 %; sums over a square lattice in place of integrals, and an opening of 400 steps",
    ))
}
