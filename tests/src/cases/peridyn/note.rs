//! The note as printed: where it is off, and by how much.

use peridyn_sde::{
    BondConfig, Bonds, Condition, Horizon, Influence, Nodes, NoteAsPrinted, SurfaceCorrection,
    VolumeCorrection,
};

use crate::case::{Case, CaseError, Context, Profile, Schedule};
use crate::cases::lines::Lines;
use crate::report::Claim;

pub(crate) const CASE: Case = Case {
    id: "peridyn-sde/note-as-printed",
    title: "The note's bonds to the letter against those that are meant: stiffness by dimension and volume, the horizon of whole spacings",
    source: "docs/errata.md; 18 K/(pi delta^4) is the constant of three dimensions; eq 3 weighs a bond by the volume of one end",
    cost: Profile::Quick,
    schedule: Schedule::Together,
    run,
};

const SHELLS: u32 = 3;

/// The stiffness of the note's bonds over those that are meant, which is one number for all, at a spacing.
fn ratio<const D: usize>(condition: Condition, spacing: f64) -> Result<[f64; 2], CaseError> {
    let horizon = Horizon::of_shells(SHELLS, spacing)?;
    let nodes = Nodes::lattice(spacing, ([0.0; D], [8.0 * spacing; D]), condition, |_| true)?;
    let meant = Bonds::new(
        &nodes,
        &BondConfig {
            horizon,
            young_modulus: 3.0 * (1.0 - 2.0 * condition.poisson_ratio()),
            influence: Influence::Constant,
            volume_correction: VolumeCorrection::None,
            surface_correction: SurfaceCorrection::None,
        },
    )?;
    let note = NoteAsPrinted { bulk_modulus: 1.0, horizon: horizon.radius(), eta: 1.0 };
    let printed = note.bonds(&nodes)?;
    if printed.len() != meant.len() {
        return Err("the note bonds other nodes".into());
    }
    let ratios = printed.all().iter().zip(meant.all()).map(|(a, b)| a.stiffness / b.stiffness);
    let ends = |(low, high): (f64, f64), ratio: f64| (low.min(ratio), high.max(ratio));
    let (low, high) = ratios.fold((f64::INFINITY, 0.0), ends);
    Ok([low, high])
}

fn run(context: &Context<'_>) -> Result<Vec<Claim>, CaseError> {
    let thickness = 0.7;
    let plate = Condition::PlaneStress { thickness };
    let mut claims = Vec::new();
    for spacing in [1.0_f64, 0.5] {
        let lines = Lines {
            context,
            id: &format!("dx{spacing}"),
            method: format!("lattice of 8 nodes to a side, horizon 3.015 dx, dx = {spacing}"),
        };
        let horizon = 3.015 * spacing;
        let volume = [thickness * spacing.powi(2), spacing.powi(3)];
        let of_plate = ratio::<2>(plate, spacing)?;
        let of_solid = ratio::<3>(Condition::Solid, spacing)?;
        let reason = "roundoff; every bond is off by the same factor";
        for (name, found, expected) in [
            // 12 E/(pi delta^4) over 9 E/(pi delta^3 t), with K = E/(3 (1 - 2 nu)) = E.
            ("plate", of_plate, 2.0 * thickness / horizon / volume[0]),
            ("solid", of_solid, 1.0 / volume[1]),
        ] {
            for (end, value) in [("least", found[0]), ("most", found[1])] {
                let quantity = "stiffness of a bond as printed over that of the bond that is meant";
                let name = format!("{name}/{end}");
                claims.push(lines.relative((&name, quantity, ""), value, expected, 1e-12, reason));
            }
        }
    }
    claims.extend(horizon(context)?);
    Ok(claims)
}

/// With a horizon of three whole spacings and `<`, roundoff decides which bonds of that length there are.
fn horizon(context: &Context<'_>) -> Result<Vec<Claim>, CaseError> {
    let mut claims = Vec::new();
    for spacing in [1.0, 0.1, 1.0 / 30.0, 1e-3] {
        let side = 40_u32;
        let corner = f64::from(side) * spacing;
        let plate = Condition::PlaneStress { thickness: 1.0 };
        let nodes = Nodes::lattice(spacing, ([0.0; 2], [corner; 2]), plate, |_| true)?;
        let note = NoteAsPrinted { bulk_modulus: 1.0, horizon: 3.0 * spacing, eta: 1.0 };
        let longest = |length: f64| length > 2.9 * spacing;
        let kept = note.bonds(&nodes)?.all().iter().filter(|bond| longest(bond.length)).count();
        let all = 2 * side * (side - 3);
        let lines = Lines {
            context,
            id: &format!("horizon/dx{spacing:.3e}"),
            method: format!("{side} x {side} nodes, delta = 3 dx, dx = {spacing}"),
        };
        claims.push(lines.measured(
            ("kept", "share of the bonds of three spacings that are there", ""),
            kept as f64 / f64::from(all),
            (0.0, 0.8),
            "none is meant by the sign <; roundoff keeps some, others at each spacing. This crate refuses such a horizon",
        ));
    }
    Ok(claims)
}
