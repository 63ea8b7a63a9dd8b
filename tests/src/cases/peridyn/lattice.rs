//! What bonds on a lattice amount to: stiffness, strain energy, energy of a crack.

use peridyn_sde::{Condition, Horizon, Influence, VolumeCorrection};
use serde_json::Value;
use work_precision::problems::peridyn::lattice::{config, energy_of_crack, energy_of_middle};

use super::rest::number;
use crate::case::{Case, CaseError, Context, Profile, Schedule};
use crate::cases::lines::Lines;
use crate::report::Claim;

pub(crate) const CASE: Case = Case {
    id: "peridyn-sde/lattice",
    title: "Stiffness of lattices; energy of a uniform extension and of a crack for every influence function and condition",
    source: "sums over the bonds of one node, lattice_stiffness.json; the elastic body and its G0",
    cost: Profile::Quick,
    schedule: Schedule::Together,
    run,
};

fn run(context: &Context<'_>) -> Result<Vec<Claim>, CaseError> {
    let text = include_str!("../../../reference/derived/peridyn/lattice_stiffness.json");
    let table: Value = serde_json::from_str(text)?;
    let table = &table["table"];
    // Plane stress, nu = 1/3: C11 = E/(1 - nu^2) = 9/8 E and C12 a third of it; a solid, nu = 1/4: 6/5 E and a third of it.
    let plate = Condition::PlaneStress { thickness: 0.7 };
    let mut claims = stiffness::<2>(context, table, "2D", plate, 9.0 / 8.0)?;
    claims.extend(stiffness::<3>(context, table, "3D", Condition::Solid, 1.2)?);
    for (name, influence) in [
        ("constant", Influence::Constant),
        ("conical", Influence::Conical),
        ("quartic", Influence::Quartic),
    ] {
        claims.extend(constants::<1>(
            context,
            name,
            influence,
            (Condition::Bar { area: 0.3 }, 8, 12),
        )?);
        claims.extend(constants::<2>(context, name, influence, (plate, 5, 8))?);
        let strain = Condition::PlaneStrain { thickness: 0.7 };
        claims.extend(constants::<2>(context, name, influence, (strain, 5, 8))?);
        claims.extend(constants::<3>(context, name, influence, (Condition::Solid, 4, 5))?);
    }
    Ok(claims)
}

/// Every row of the table whose horizon does not end on nodes.
fn stiffness<const D: usize>(
    context: &Context<'_>,
    table: &Value,
    name: &str,
    condition: Condition,
    c11: f64,
) -> Result<Vec<Claim>, CaseError> {
    let mut claims = Vec::new();
    for (key, label, volume) in [
        ("none<=", "none", VolumeCorrection::None),
        ("lammps", "partial", VolumeCorrection::Partial),
        ("PA", "ramp", VolumeCorrection::Ramp),
    ] {
        let (mut worst, mut rows): (f64, Vec<String>) = (0.0, Vec::new());
        for shells in 2..=6 {
            let row = &table[format!("{name} m={shells}.015")][key];
            if row.is_null() {
                continue;
            }
            let horizon = Horizon::of_shells(shells, 1.0)?;
            let config = config(horizon, Influence::Constant, volume);
            let along = |count: usize| {
                move |x: &[f64; D]| std::array::from_fn(|k| if k < count { x[k] } else { 0.0 })
            };
            let one = energy_of_middle(condition, &config, along(1))?;
            // 2 C11 + 2 C12.
            let both = energy_of_middle(condition, &config, along(2))?;
            let c12 = c11 / 3.0;
            for (value, of) in [(one / c11, "C11"), ((0.5 * both - one) / c12, "C12")] {
                worst = worst.max((value / number(&row[of])? - 1.0).abs());
            }
            rows.push(format!("{shells}.015"));
        }
        let method = format!("square or cubic lattice, m = {}", rows.join(", "));
        let lines = Lines { context, id: "stiffness", method };
        claims.push(lines.bounded(
            (
                &format!("{}/{label}", name.to_lowercase()),
                &format!("largest relative error of C11 and C12, volume correction: {label}"),
                "",
            ),
            if rows.is_empty() { f64::NAN } else { worst },
            1e-12,
            "roundoff of sums over up to 900 bonds",
        ));
    }
    Ok(claims)
}

fn constants<const D: usize>(
    context: &Context<'_>,
    name: &str,
    influence: Influence,
    (condition, shells, shells_of_crack): (Condition, u32, u32),
) -> Result<[Claim; 2], CaseError> {
    let horizon = Horizon::of_shells(shells, 1.0)?;
    let config = config(horizon, influence, VolumeCorrection::Ramp);
    let twice = energy_of_middle::<D>(condition, &config, |x| *x)?;
    let crack = energy_of_crack::<D>(condition, shells_of_crack, influence)?;
    let place = match condition {
        Condition::Bar { .. } => "bar",
        Condition::PlaneStress { .. } => "plane-stress",
        Condition::PlaneStrain { .. } => "plane-strain",
        Condition::Solid => "solid",
    };
    let id = format!("{place}/{name}");
    let method = format!("{name} influence, m = {shells}.015 and {shells_of_crack}.015, ramp");
    let lines = Lines { context, id: &id, method };
    Ok([
        lines.relative(
            ("extension", "strain energy of a uniform extension over that of the elastic body", ""),
            0.5 * twice / condition.energy_of_extension(),
            1.0,
            0.05,
            "the claim; what is left is the lattice, and falls with the spacing",
        ),
        lines.relative(
            ("crack", "energy of the bonds across a plane at the critical stretch, over G0", ""),
            crack,
            1.0,
            0.05,
            "the claim; what is left is the lattice, and falls with the spacing",
        ),
    ])
}
