//! The note as printed: where it is off, and by how much.

use peridyn_sde::{
    BondConfig, Bonds, Condition, Horizon, Influence, Nodes, NoteAsPrinted, SurfaceCorrection,
    VolumeCorrection,
};

use crate::case::{Case, CaseError, Context, Profile, Schedule};
use crate::cases::lines::Lines;
use crate::cases::worst::Worst;
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
    let mut worst = [Worst::default(), Worst::default()];
    for spacing in [1.0_f64, 0.5] {
        let horizon = 3.015 * spacing;
        let volume = [thickness * spacing.powi(2), spacing.powi(3)];
        let place = format!("dx = {spacing}");
        // 12 E/(pi delta^4) over 9 E/(pi delta^3 t), with K = E/(3 (1 - 2 nu)) = E.
        for ratio in ratio::<2>(plate, spacing)? {
            worst[0].take(ratio / (2.0 * thickness / horizon / volume[0]) - 1.0, &place);
        }
        for ratio in ratio::<3>(Condition::Solid, spacing)? {
            worst[1].take(ratio * volume[1] - 1.0, &place);
        }
    }
    let method =
        "lattice of 8 nodes to a side, horizon 3.015 dx, dx = 1 and 0.5, softest and stiffest bond";
    let mut claims: Vec<Claim> = ["plate", "solid"].into_iter().zip(&worst).map(|(name, worst)| {
        let quantity = "stiffness of a bond as printed over that of the bond that is meant: relative error of the factor by which all are off";
        let lines = Lines { context, id: "stiffness", method: worst.method(method) };
        lines.bounded((name, quantity, ""), worst.value(), 1e-14, "roundoff: a product of ten numbers; every bond is off by the same factor")
    }).collect();
    claims.extend(horizon(context)?);
    Ok(claims)
}

/// With a horizon of three whole spacings and `<`, roundoff decides which bonds of that length there are.
fn horizon(context: &Context<'_>) -> Result<[Claim; 3], CaseError> {
    let (mut apart, mut shares) = (Worst::default(), Vec::new());
    for spacing in [1.0, 0.1, 1.0 / 30.0, 1e-3] {
        let side = 40_u32;
        let corner = f64::from(side) * spacing;
        let plate = Condition::PlaneStress { thickness: 1.0 };
        let nodes = Nodes::lattice(spacing, ([0.0; 2], [corner; 2]), plate, |_| true)?;
        let reach = 3.0 * spacing;
        let note = NoteAsPrinted { bulk_modulus: 1.0, horizon: reach, eta: 1.0 };
        let longest = |length: f64| length > 2.9 * spacing;
        let kept = note.bonds(&nodes)?.all().iter().filter(|bond| longest(bond.length)).count();
        // The print, pair by pair.
        let x = nodes.positions();
        let pairs = (0..x.len()).flat_map(|i| (i + 1..x.len()).map(move |j| (i, j)));
        let lengths =
            pairs.map(|(i, j)| ((x[j][0] - x[i][0]).powi(2) + (x[j][1] - x[i][1]).powi(2)).sqrt());
        let printed = lengths.filter(|&length| longest(length) && length < reach).count();
        apart.take(kept as f64 - printed as f64, &format!("dx = {spacing}"));
        shares.push(kept as f64 / f64::from(2 * side * (side - 3)));
    }
    let method = "40 x 40 nodes, delta = 3 dx, dx = 1, 0.1, 1/30 and 0.001";
    let lines = Lines { context, id: "horizon", method: method.into() };
    let (least, most) = shares
        .iter()
        .fold((1.0_f64, 0.0_f64), |(low, high), &share| (low.min(share), high.max(share)));
    let quantity = |which| format!("{which} share of the bonds of three spacings that are there");
    Ok([
        Lines { method: apart.method(method), ..lines }.bounded(
            ("kept", "bonds of three spacings that are there, less those of the print", ""),
            apart.value(),
            0.0,
            "the sign <, pair by pair over all nodes, in the same arithmetic",
        ),
        lines.bounded(
            ("least", &quantity("least"), ""),
            least,
            0.0,
            "none is meant by the sign <, and with dx = 1 no product is rounded",
        ),
        lines.measured(
            ("most", &quantity("largest"), ""),
            most,
            (0.55, 0.65),
            "roundoff of the products of dx keeps some, others at each spacing. This crate refuses such a horizon",
        ),
    ])
}
