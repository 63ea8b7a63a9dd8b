//! Forces of a strained block, against LAMMPS and between all paths.

use peridyn_sde::law::CriticalStretch;
use peridyn_sde::{
    AtStrength, Body, BondConfig, BondList, Bonds, Condition, Horizon, Influence, LatticeBody,
    Network, Nodes, Real, Strain, SurfaceCorrection, VolumeCorrection,
};
use serde::Deserialize;

use crate::case::{Case, CaseError, Context, Profile, Schedule};
use crate::cases::lines::Lines;
use crate::cases::worst::Worst;
use crate::report::Claim;

pub(crate) const CASE: Case = Case {
    id: "peridyn-sde/forces",
    title: "Forces on 6 x 6 x 6 nodes against LAMMPS peri/pmb; a bar of unequal nodes; strains at the border of the series of the fast paths",
    source: "LAMMPS 22Jul2025 peri/pmb, lammps_pmb_forces_6x6x6.json, with the same sums in 40 digits",
    cost: Profile::Quick,
    schedule: Schedule::Together,
    run,
};

#[derive(Debug, Deserialize)]
struct Lammps {
    x: Vec<[f64; 3]>,
    /// Force densities.
    f: Vec<[f64; 3]>,
    /// The same by arithmetic of 40 digits.
    exact: Vec<[f64; 3]>,
}

/// A body and displacements of it.
struct Strained<const D: usize> {
    nodes: Nodes<D>,
    bonds: Bonds,
    u: Vec<[f64; D]>,
}

/// Nothing breaks.
const STRENGTH: f64 = 1.0;

impl<const D: usize> Strained<D> {
    fn reference(&self) -> Result<Vec<f64>, CaseError> {
        let strengths = vec![STRENGTH; self.bonds.len()];
        let (nodes, bonds) = (self.nodes.clone(), self.bonds.clone());
        let network = Network::new(nodes, bonds, CriticalStretch, strengths)?;
        let mut forces = vec![[0.0; D]; self.u.len()];
        let _ = network.forces(&self.u, &mut forces)?;
        Ok(forces.into_flattened())
    }

    /// The forces of a fast path, all lanes of a component side by side.
    fn by<T: Real, const L: usize>(
        &self,
        mut body: impl Body<T, D, L>,
    ) -> Result<Vec<f64>, CaseError> {
        let u: Vec<T> = self.u.as_flattened().iter().flat_map(|&u| [T::of(u); L]).collect();
        let mut forces = vec![T::ZERO; u.len()];
        body.forces(&u, &mut forces, AtStrength::Break(&mut Vec::new()))?;
        Ok(forces.into_iter().map(Real::to_f64).collect())
    }

    fn list<T: Real, const L: usize>(&self) -> Result<Vec<f64>, CaseError> {
        let strengths = vec![STRENGTH; self.bonds.len()];
        let (nodes, bonds) = (self.nodes.clone(), self.bonds.clone());
        self.by(BondList::<T, D, L>::new(nodes, bonds, Strain::Finite, &strengths)?)
    }

    fn lattice<T: Real>(&self) -> Result<Vec<f64>, CaseError> {
        let (nodes, bonds) = (self.nodes.clone(), self.bonds.clone());
        self.by(LatticeBody::<T, D>::new(nodes, bonds, Strain::Finite, STRENGTH)?)
    }

    /// The forces of every fast path.
    fn fast(&self) -> Result<[Path; 6], CaseError> {
        let path = |name, lanes, forces| Path { name, lanes, forces };
        Ok([
            path("lattice-f64", 1, self.lattice::<f64>()?),
            path("list-f64", 1, self.list::<f64, 1>()?),
            path("list-f64-x8", 8, self.list::<f64, 8>()?),
            path("lattice-f32", 1, self.lattice::<f32>()?),
            path("list-f32", 1, self.list::<f32, 1>()?),
            path("list-f32-x16", 16, self.list::<f32, 16>()?),
        ])
    }
}

/// What the series of the fast paths leaves: in f64 its first term that is left out, in f32 the roundoff of a sum of 122 bonds.
const F64: f64 = 2e-12;
const F32: f64 = 1e-6;

/// Numbers of fast paths, and the bound of their error.
const PRECISIONS: [(&str, f64); 2] = [("f64", F64), ("f32", F32)];

struct Path {
    name: &'static str,
    lanes: usize,
    forces: Vec<f64>,
}

impl Path {
    /// Its place among [`PRECISIONS`].
    fn precision(&self) -> usize {
        usize::from(self.name.contains("f32"))
    }
}

/// The largest difference in any lane, over the largest force.
fn off(forces: &[f64], lanes: usize, expected: &[f64]) -> f64 {
    let largest = expected.iter().fold(0.0, |most: f64, f| most.max(f.abs()));
    let apart = forces
        .chunks(lanes)
        .zip(expected)
        .flat_map(|(lanes, f)| lanes.iter().map(move |lane| (lane - f).abs()));
    let worst =
        apart.fold(0.0, |most: f64, e| if e.is_nan() { f64::INFINITY } else { most.max(e) });
    worst / largest
}

fn lammps() -> Result<(Strained<3>, Lammps), CaseError> {
    let text = include_str!("../../../reference/derived/peridyn/lammps_pmb_forces_6x6x6.json");
    let data: Lammps = serde_json::from_str(text)?;
    let dx = 5e-4;
    // The first index fastest, from the origin. As products of the spacing, so that displacements are exact differences.
    let at = |node: usize| [node % 6, node / 6 % 6, node / 36].map(|index| index as f64 * dx);
    let u = data.x.iter().enumerate();
    let u = u.map(|(node, x)| std::array::from_fn(|k| x[k] - at(node)[k])).collect();
    let positions = (0..216).map(at).collect();
    let nodes = Nodes::new(positions, vec![dx.powi(3); 216], dx, Condition::Solid)?;
    let config = BondConfig {
        horizon: Horizon::of_shells(3, dx)?,
        // E = 3 K (1 - 2 nu), nu = 1/4.
        young_modulus: 1.5 * 14.9e9,
        influence: Influence::Constant,
        volume_correction: VolumeCorrection::Partial,
        surface_correction: SurfaceCorrection::None,
    };
    let bonds = Bonds::new(&nodes, &config)?;
    Ok((Strained { nodes, bonds, u }, data))
}

fn run(context: &Context<'_>) -> Result<Vec<Claim>, CaseError> {
    let (block, data) = lammps()?;
    let volume = block.nodes.volumes()[0];
    let forces_of = |densities: &[[f64; 3]]| {
        densities.as_flattened().iter().map(|f| f * volume).collect::<Vec<f64>>()
    };
    let (theirs, exact) = (forces_of(&data.f), forces_of(&data.exact));
    let reference = block.reference()?;
    let method = "216 nodes, horizon 3.015 dx, partial volumes, strains up to 2e-3";
    let lines = Lines { context, id: "lammps", method: method.into() };
    let what = "largest difference of a force, over the largest force";
    let mut claims = vec![
        lines.bounded(
            ("reference-path", what, ""),
            off(&reference, 1, &theirs),
            1.5e-13,
            "LAMMPS takes the stretch as a difference of lengths: its own roundoff is 1.2e-13, which is why 1e-13, the aim, is not reached against it and is against 40 digits",
        ),
        lines.bounded(
            ("reference-path/exact", &format!("{what}, of sums in 40 digits"), ""),
            off(&reference, 1, &exact),
            5e-15,
            "roundoff: sums over 122 bonds, of 1e-16 each",
        ),
    ];
    let mut worst = [Worst::default(), Worst::default()];
    for path in block.fast()? {
        worst[path.precision()].take(off(&path.forces, path.lanes, &exact), path.name);
    }
    for (worst, (name, bound)) in worst.iter().zip(PRECISIONS) {
        let method = worst.method(&lines.method);
        claims.push(Lines { method, ..lines }.bounded(
            (name, &format!("{what}, of sums in 40 digits, by the worst of three fast paths"), ""),
            worst.value(),
            bound,
            "the series of the fast paths, and the roundoff of their precision",
        ));
    }
    claims.push(of_unequal_nodes(context)?);
    claims.extend(at_border(context)?);
    Ok(claims)
}

/// A bar whose nodes have unequal volumes `V_i`, each bonded to the next, under stretches that make every bond pull with the
/// same force: `c V_i V_(i+1) s_i = F` with `c = 2 E/(A delta^2)`. The ends carry `F`, the nodes between them nothing.
fn of_unequal_nodes(context: &Context<'_>) -> Result<Claim, CaseError> {
    const AREA: f64 = 0.5;
    const YOUNG_MODULUS: f64 = 3.0;
    const FORCE: f64 = 1e-3;
    let volumes = vec![0.3, 0.8, 0.5, 1.1, 0.2, 0.7];
    let positions = (0..volumes.len()).map(|node| [node as f64]).collect();
    let horizon = Horizon::of_shells(1, 1.0)?;
    let c = 2.0 * YOUNG_MODULUS / (AREA * horizon.radius().powi(2));
    let mut u = vec![[0.0]];
    for pair in volumes.windows(2) {
        u.push([u[u.len() - 1][0] + FORCE / (c * pair[0] * pair[1])]);
    }
    let mut expected = vec![0.0; volumes.len()];
    expected[0] = FORCE;
    expected[volumes.len() - 1] = -FORCE;
    let nodes = Nodes::new(positions, volumes, 1.0, Condition::Bar { area: AREA })?;
    let config = BondConfig::uncorrected(horizon, YOUNG_MODULUS);
    let bonds = Bonds::new(&nodes, &config)?;
    let bar = Strained { nodes, bonds, u };
    let mut worst = Worst::default();
    worst.take(off(&bar.reference()?, 1, &expected), "reference path");
    worst.take(off(&bar.list::<f64, 1>()?, 1, &expected), "list-f64");
    worst.take(off(&bar.list::<f64, 8>()?, 8, &expected), "list-f64-x8");
    let method = worst.method("6 nodes, volumes from 0.2 to 1.1, strains up to 5e-3");
    Ok(Lines { context, id: "unequal-nodes", method }.bounded(
        ("force", "largest difference of a force to the closed form, over the largest", ""),
        worst.value(),
        3e-12,
        "roundoff: a stretch of 2e-4 is a difference of positions of size 5, 1e-15 of 5 each",
    ))
}

/// A bar under a uniform strain of the growth `w = (1 + s)^2 - 1`.
fn bar(growth: f64) -> Result<Strained<1>, CaseError> {
    let condition = Condition::Bar { area: 1.0 };
    let nodes = Nodes::lattice(1.0, ([-4.0], [4.0]), condition, |_| true)?;
    let config = BondConfig::uncorrected(Horizon::of_shells(2, 1.0)?, 1.0);
    let bonds = Bonds::new(&nodes, &config)?;
    let stretch = growth / (1.0 + (1.0 + growth).sqrt());
    let u = nodes.positions().iter().map(|x| [stretch * x[0]]).collect();
    Ok(Strained { nodes, bonds, u })
}

/// Series serve up to `|w| = 0.03` in f64 and 0.02 in f32; beyond, the closed form.
fn at_border(context: &Context<'_>) -> Result<Vec<Claim>, CaseError> {
    let mut claims = Vec::new();
    for (side, factors, tolerances) in [
        ("inside", [0.5, 0.99, 1.0 - 1e-6], [(F64, "the series"), (F32, "roundoff of f32")]),
        (
            "outside",
            [1.0 + 1e-6, 1.01, 10.0],
            [(5e-15, "roundoff: the closed form in f64"), (F32, "roundoff of f32")],
        ),
    ] {
        let mut worst = [Worst::default(), Worst::default()];
        for factor in factors {
            for sign in [1.0, -1.0] {
                for (precision, border) in [0.03, 0.02].into_iter().enumerate() {
                    let bar = bar(sign * border * factor)?;
                    let expected = bar.reference()?;
                    for path in bar.fast()?.iter().filter(|path| path.precision() == precision) {
                        let place = format!("{}, w = {}", path.name, sign * border * factor);
                        worst[precision].take(off(&path.forces, path.lanes, &expected), &place);
                    }
                }
            }
        }
        let id = format!("border/{side}");
        for ((worst, (name, _)), (tolerance, of)) in worst.iter().zip(PRECISIONS).zip(tolerances) {
            let method = worst.method("bar of 8 nodes under a uniform strain, three fast paths");
            claims.push(Lines { context, id: &id, method }.bounded(
                (name, "largest difference of a force to the reference path, over the largest", ""),
                worst.value(),
                tolerance,
                &format!("{of}, on this side of the strain where the series ends, in tension and compression"),
            ));
        }
    }
    Ok(claims)
}
