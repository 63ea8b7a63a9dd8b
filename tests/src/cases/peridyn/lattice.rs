//! What bonds on a lattice amount to: stiffness, strain energy, energy of a crack.

use peridyn_sde::{Condition, Horizon, Influence, VolumeCorrection};
use reference_problems::peridyn::lattice::{config, energy_of_crack, energy_of_middle};
use serde_json::Value;

use super::rest::number;
use crate::case::{Case, CaseError, Context, Profile, Schedule};
use crate::cases::lines::Lines;
use crate::cases::worst::Worst;
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
    let mut claims = vec![
        stiffness::<2>(context, table, "2D", plate, (9.0 / 8.0, 2e-14))?,
        stiffness::<3>(context, table, "3D", Condition::Solid, (1.2, 2e-13))?,
    ];
    let strain = Condition::PlaneStrain { thickness: 0.7 };
    claims.extend(constants::<1>(context, Condition::Bar { area: 0.3 }, (8, 12), (0.03, 0.015))?);
    claims.extend(constants::<2>(context, plate, (5, 8), (0.03, 0.03))?);
    claims.extend(constants::<2>(context, strain, (5, 8), (0.03, 0.03))?);
    claims.extend(constants::<3>(context, Condition::Solid, (4, 5), (0.05, 0.05))?);
    Ok(claims)
}

/// Every row of the table whose horizon does not end on nodes.
fn stiffness<const D: usize>(
    context: &Context<'_>,
    table: &Value,
    name: &str,
    condition: Condition,
    (c11, tolerance): (f64, f64),
) -> Result<Claim, CaseError> {
    let mut worst = Worst::default();
    for (key, label, volume) in [
        ("none<=", "none", VolumeCorrection::None),
        ("lammps", "partial", VolumeCorrection::Partial),
        ("PA", "ramp", VolumeCorrection::Ramp),
    ] {
        let mut is_empty = true;
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
                let place = format!("{of}, m = {shells}.015, volume correction: {label}");
                worst.take(value / number(&row[of])? - 1.0, &place);
            }
            is_empty = false;
        }
        if is_empty {
            return Err(format!("no row of {name} has the volume correction {label}").into());
        }
    }
    let method = worst.method("square or cubic lattice, three corrections of volume");
    Ok(Lines { context, id: "stiffness", method }.bounded(
        (&name.to_lowercase(), "largest relative error of C11 and C12", ""),
        worst.value(),
        tolerance,
        "roundoff: sums over up to 900 bonds, and C12 a difference of two of them",
    ))
}

/// Influence functions, and their names.
const INFLUENCES: [(&str, Influence); 3] = [
    ("constant", Influence::Constant),
    ("conical", Influence::Conical),
    ("quartic", Influence::Quartic),
];

/// The worst of all influence functions, with horizons of so many shells for the extension and for the crack.
fn constants<const D: usize>(
    context: &Context<'_>,
    condition: Condition,
    (shells, shells_of_crack): (u32, u32),
    tolerances: (f64, f64),
) -> Result<[Claim; 2], CaseError> {
    let horizon = Horizon::of_shells(shells, 1.0)?;
    let (mut extension, mut crack) = (Worst::default(), Worst::default());
    for (name, influence) in INFLUENCES {
        let config = config(horizon, influence, VolumeCorrection::Ramp);
        let twice = energy_of_middle::<D>(condition, &config, |x| *x)?;
        extension.take(0.5 * twice / condition.energy_of_extension() - 1.0, name);
        crack.take(energy_of_crack::<D>(condition, shells_of_crack, influence)? - 1.0, name);
    }
    let place = match condition {
        Condition::Bar { .. } => "bar",
        Condition::PlaneStress { .. } => "plane-stress",
        Condition::PlaneStrain { .. } => "plane-strain",
        Condition::Solid => "solid",
    };
    let reason = "what is left is the lattice, and falls with the spacing";
    let claim = |worst: &Worst, shells: u32, of: (&str, &str, &str), tolerance| {
        let method = worst
            .method(&format!("constant, conical and quartic influence, m = {shells}.015, ramp"));
        Lines { context, id: place, method }.bounded(of, worst.value(), tolerance, reason)
    };
    Ok([
        claim(
            &extension,
            shells,
            (
                "extension",
                "strain energy of a uniform extension over that of the elastic body, less 1",
                "",
            ),
            tolerances.0,
        ),
        claim(
            &crack,
            shells_of_crack,
            (
                "crack",
                "energy of the bonds across a plane at the critical stretch over G0, less 1",
                "",
            ),
            tolerances.1,
        ),
    ])
}
