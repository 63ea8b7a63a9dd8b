//! A plate of glass with a notch, pulled at once: the crack branches.

use peridyn_sde::{Loading, Notch, Program};

use crate::cases::prelude::*;
use crate::peridyn::plate::{Cracked, Plate};

pub(crate) const CASE: Case = Case {
    id: "peridyn-sde/branching",
    title: "A notched plate of glass under a sudden traction: where and how the crack branches",
    source: "after Ha and Bobaru 2010, constants of prototype_dynamic.json, which are mixed ones; its results are compared with and are no truth",
    cost: Profile::Quick,
    run: Together(run),
};

/// s.
const END: f64 = 50e-6;

/// Traction (Pa) and energy release rate (J/m^2), with the name of the claims.
const LOADS: [(&str, f64, f64); 2] = [("12mpa", 12e6, 204.0), ("2mpa", 2e6, 3.8)];

struct Seen {
    n_tips: usize,
    /// mm from the left edge.
    start: f64,
    /// m/s.
    speed: f64,
    asymmetry: f64,
    n_steps: u64,
}

fn notch(spacing: f64) -> Notch {
    Notch { mouth: [-spacing, 0.0], tip: [0.05, 0.0] }
}

/// A plate of 0.1 by 0.04 m, notched half way, its outermost rows pulled by body forces that make up the traction.
fn pulled(spacing: f64, traction: f64, energy_release_rate: f64) -> CaseResult<(Plate, Cracked)> {
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

fn seen(plate: &Plate, cracked: &Cracked) -> CaseResult<Seen> {
    let notch = notch(plate.spacing);
    let path = cracked.path(&notch, END)?.ok_or("no crack grew from the notch")?;
    Ok(Seen {
        n_tips: path.tips().len(),
        start: path.branches().first().map_or(f64::NAN, |branch| 1e3 * branch.start()[0]),
        speed: cracked.tip_speed(&notch, 1e-6, 50)?,
        asymmetry: cracked.asymmetry(),
        n_steps: cracked.n_steps,
    })
}

/// The fastest crack that a duran glass was seen to bear before it branched (m/s): Doell 1975, as cited by Ha and Bobaru 2010, from
/// memory.
const FASTEST: f64 = 1580.0;

/// Where the crack branches by another code (mm), by traction and mesh: prototype_dynamic.json.
fn by_another_code(name: &str, dx: f64) -> f64 {
    match (name, dx > 0.4) {
        ("12mpa", true) => 65.8,
        ("12mpa", false) => 65.1,
        _ => 66.1,
    }
}

fn run(context: &Context<'_>) -> CaseResult {
    let millimetres: &[f64] = if context.profile == Profile::Quick { &[0.5] } else { &[0.5, 0.25] };
    let mut worst = Branching::default();
    for (name, traction, energy_release_rate) in LOADS {
        let mut starts = Vec::new();
        for &dx in millimetres {
            context.progress(&format!("{name}, {dx} mm"));
            let (plate, cracked) = pulled(1e-3 * dx, traction, energy_release_rate)?;
            let seen = seen(&plate, &cracked)?;
            starts.push(seen.start);
            worst.see(&seen, by_another_code(name, dx), &format!("{name}, {dx} mm"));
        }
        if let &[coarse, fine] = starts.as_slice() {
            worst.change.take(fine / coarse - 1.0, name);
        }
    }
    Ok(worst.claims(context, millimetres))
}

/// The worst of all runs.
#[derive(Default)]
struct Branching {
    tips: Worst,
    start: Worst,
    change: Worst,
    speed: Worst,
    asymmetry: Worst,
}

impl Branching {
    fn see(&mut self, seen: &Seen, start: f64, at: &str) {
        let at = format!("{at}, {} steps", seen.n_steps);
        self.tips.take(seen.n_tips as f64 - 2.0, &at);
        self.start.take(seen.start / start - 1.0, &at);
        self.speed.take(seen.speed / FASTEST - 1.0, &at);
        self.asymmetry.take(seen.asymmetry, &at);
    }

    fn claims(&self, context: &Context<'_>, millimetres: &[f64]) -> Vec<Claim> {
        let method = format!(
            "12 and 2 MPa, {millimetres:?} mm, horizon 4.015 dx, plane stress, velocity Verlet, steps of 0.8 of the critical one"
        );
        let of = |worst: &Worst, name: &str, quantity: &str| {
            context.lines("", worst.method(&method)).of(name, quantity)
        };
        let Self { tips, start, change, speed, asymmetry } = self;
        let mut claims = vec![
            of(tips, "tips", "tips of the crack at the end, less two")
                .bounded(tips.value(), 0.0)
                .because("it branches, once"),
            of(start, "branching-point", "where the lines through both arms meet, from the left edge, over that of another code, less one")
                .bounded(start.value(), 0.03)
                .because("the other code takes the place where damage splits, up to 1.1 mm to the right, half of a horizon of 2 mm"),
            of(speed, "tip-speed", "fastest growth of the crack over 4 us, over 1580 m/s, less one")
                .bounded(speed.value(), 0.25)
                .because("the fastest crack that was seen in a glass before it branched, of somewhat other constants; growth over 4 us, four to eight horizons, scatters by 10 %"),
            of(asymmetry, "asymmetry", "share of broken bonds whose image did not break in the same step")
                .bounded(asymmetry.value(), 5e-3)
                .because("roundoff: the plate is symmetric; 1e-13 of a stretch may move a break by a step, and with it some of thousands"),
        ];
        if millimetres.len() > 1 {
            let quantity = "branching point at 0.25 mm over that at 0.5 mm, less one";
            let reason = "the place is that of the plate, not of its mesh: within 0.6 mm, the horizon of the finer one is 1 mm";
            let subject = of(change, "change-of-point", quantity);
            claims.push(subject.bounded(change.value(), 0.01).because(reason));
        }
        claims
    }
}
