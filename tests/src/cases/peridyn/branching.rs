//! A plate of glass with a notch, pulled at once: the crack branches.

use figures::{Field, Words, field};
use peridyn_sde::{Loading, Notch, Program};

use crate::case::{Case, CaseError, Context, Profile, Schedule};
use crate::cases::lines::Lines;
use crate::peridyn::plate::{Cracked, Plate};
use crate::report::Claim;

pub(crate) const CASE: Case = Case {
    id: "peridyn-sde/branching",
    title: "A notched plate of glass under a sudden traction: where and how the crack branches",
    source: "after Ha and Bobaru 2010, constants of prototype_dynamic.json, which are mixed ones; its results are compared with and are no truth",
    cost: Profile::Quick,
    schedule: Schedule::Together,
    run,
};

/// s.
const END: f64 = 50e-6;

/// Traction (Pa) and energy release rate (J/m^2), with the name of the claims.
const LOADS: [(&str, f64, f64); 2] = [("12mpa", 12e6, 204.0), ("2mpa", 2e6, 3.8)];

struct Seen {
    n_tips: usize,
    /// mm from the left edge.
    start: f64,
    /// Over the Rayleigh speed.
    speed: f64,
    asymmetry: f64,
    n_steps: u64,
}

fn notch(spacing: f64) -> Notch {
    Notch { mouth: [-spacing, 0.0], tip: [0.05, 0.0] }
}

/// A plate of 0.1 by 0.04 m, notched half way, its outermost rows pulled by body forces that make up the traction.
fn pulled(
    spacing: f64,
    traction: f64,
    energy_release_rate: f64,
) -> Result<(Plate, Cracked), CaseError> {
    let plate = Plate {
        young_modulus: 72e9,
        density: 2440.0,
        energy_release_rate,
        thickness: 1e-3,
        shells: 4,
        spacing,
    };
    let nodes = plate.rectangle([0.0, -0.02], [0.1, 0.02])?;
    let x = nodes.positions();
    let edges: Vec<usize> =
        (0..x.len()).filter(|&node| x[node][1].abs() > 0.02 - spacing).collect();
    let pull = traction * spacing * plate.thickness;
    let forces: Vec<[f64; 2]> =
        edges.iter().map(|&node| [0.0, pull.copysign(x[node][1])]).collect();
    let loading = Loading::new(x.len()).force(&edges, &forces, Program::Constant(1.0))?;
    let cracked = plate.crack(nodes, &[notch(spacing)], loading, END)?;
    Ok((plate, cracked))
}

fn seen(plate: &Plate, cracked: &Cracked) -> Result<Seen, CaseError> {
    let notch = notch(plate.spacing);
    let path = cracked.path(&notch, END)?.ok_or("no crack grew from the notch")?;
    Ok(Seen {
        n_tips: path.tips().len(),
        start: path.branches().first().map_or(f64::NAN, |branch| 1e3 * branch.start()[0]),
        speed: cracked.tip_speed(&notch, 1e-6, 50)? / plate.rayleigh_speed(),
        asymmetry: cracked.asymmetry(),
        n_steps: cracked.n_steps,
    })
}

fn run(context: &Context<'_>) -> Result<Vec<Claim>, CaseError> {
    let millimetres: &[f64] = if context.profile == Profile::Quick { &[0.5] } else { &[0.5, 0.25] };
    let mut claims = Vec::new();
    for (name, traction, energy_release_rate) in LOADS {
        let mut starts = Vec::new();
        for &dx in millimetres {
            context.progress(&format!("{name}, {dx} mm"));
            let (plate, cracked) = pulled(1e-3 * dx, traction, energy_release_rate)?;
            let seen = seen(&plate, &cracked)?;
            starts.push(seen.start);
            claims.extend(of_run(context, name, dx, &seen));
            if name == LOADS[0].0 && starts.len() == millimetres.len() {
                let title = format!("Damage at 50 us, {dx} mm");
                context.show_chart(&title, field(&picture(&cracked, dx))?);
            }
        }
        if let &[coarse, fine] = starts.as_slice() {
            let lines =
                Lines { context, id: name, method: "velocity Verlet, 0.5 and 0.25 mm".into() };
            claims.push(lines.bounded(
                ("change-of-point", "branching point at 0.25 mm over that at 0.5 mm, less one", ""),
                fine / coarse - 1.0,
                0.05,
                "the claim: the place is that of the plate, not of its mesh",
            ));
        }
    }
    Ok(claims)
}

fn of_run(context: &Context<'_>, name: &str, dx: f64, seen: &Seen) -> [Claim; 4] {
    let id = format!("{name}/dx-{dx}mm");
    let method = format!(
        "{dx} mm, horizon 4.015 dx, plane stress, velocity Verlet, {} steps of 0.8 of the critical one",
        seen.n_steps
    );
    let lines = Lines { context, id: &id, method };
    [
        lines.bounded(
            ("tips", "tips of the crack at the end, less two", ""),
            seen.n_tips as f64 - 2.0,
            0.0,
            "it branches, once",
        ),
        lines.measured(
            ("branching-point", "where the lines through both arms meet, from the left edge", "mm"),
            seen.start,
            (63.0, 67.0),
            "prototype: 65.8 and 65.1 mm at 12 MPa, 66.1 mm at 2 MPa, by another measure of the place",
        ),
        lines.bounded(
            ("tip-speed", "fastest growth of the crack over 4 us, over the Rayleigh speed 3058 m/s", ""),
            seen.speed,
            0.6,
            "cracks in glass branch near 0.6 of the Rayleigh speed and do not outrun it; c_R of plane stress, nu = 1/3",
        ),
        lines.bounded(
            ("asymmetry", "share of broken bonds whose image did not break in the same step", ""),
            seen.asymmetry,
            5e-3,
            "the plate is symmetric; roundoff, 1e-13 of a stretch, may move a break by a step",
        ),
    ]
}

fn picture(cracked: &Cracked, dx: f64) -> Field {
    let columns = cracked.columns();
    let rows = cracked.damage.len() / columns;
    let edges =
        |count: usize, low: f64| (0..=count).map(|k| low + dx * k as f64).collect::<Vec<f64>>();
    Field {
        words: Words {
            title: "Crack in glass that branches".into(),
            subtitle: "12 MPa at the upper and lower edge from the start, 50 us after".into(),
            x_label: "x (mm)".into(),
            y_label: "y (mm)".into(),
            caption: vec![format!("{dx} mm, horizon 4.015 dx, no noise; damage from 0.05 on")],
        },
        unit: "damage".into(),
        x: edges(columns, 0.0),
        y: edges(rows, -20.0),
        values: (0..rows)
            .map(|row| (0..columns).map(|column| cracked.shown(row * columns + column)).collect())
            .collect(),
        regions: Vec::new(),
    }
}
