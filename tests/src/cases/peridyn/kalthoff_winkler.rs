//! A plate of steel with two notches that is struck between them: two cracks at a steep angle to the notches.

use peridyn_sde::{Loading, Notch};

use crate::cases::prelude::*;
use crate::peridyn::plate::{Cracked, Plate};

pub(crate) const CASE: Case = Case {
    id: "peridyn-sde/kalthoff-winkler",
    title: "A plate with two notches, struck between them: angle and speed of the cracks",
    source: "experiment of Kalthoff and Winkler 1988, about 70 degrees, and Silling 2001, about 68, both from memory; set-up of prototype_dynamic.json, whose own angles are compared with and are no truth",
    cost: Profile::Default,
    run: Together(run),
};

/// 0.1 m along the notches, 0.2 m across.
const SIZE: [f64; 2] = [0.1, 0.2];
/// Half of the distance of the notches, and their length (m).
const HALF: f64 = 0.025;
const LENGTH: f64 = 0.05;
/// Of the rows between the notches (m/s).
const SPEED: f64 = 16.5;
/// s.
const END: f64 = 90e-6;
/// The angle is that of the crack up to this length (m).
const FITTED: f64 = 0.03;

/// What is seen of a run.
struct Seen {
    /// From the axis of the notches to the line through the upper crack (degrees).
    angle: f64,
    /// Fastest of the tip, over the Rayleigh speed.
    speed: f64,
    asymmetry: f64,
    n_steps: u64,
}

fn struck(spacing: f64) -> CaseResult<(Plate, Cracked)> {
    let plate = Plate {
        young_modulus: 190e9,
        density: 8000.0,
        energy_release_rate: 22130.0,
        thickness: 0.009,
        shells: 3,
        spacing,
    };
    let nodes = plate.rectangle([0.0, -0.5 * SIZE[1]], [SIZE[0], 0.5 * SIZE[1]])?;
    let hit = |x: &[f64; 2]| x[0] < 3.0 * spacing && x[1].abs() < HALF;
    let x = nodes.positions();
    let hit: Vec<usize> = (0..x.len()).filter(|&node| hit(&x[node])).collect();
    let loading = Loading::new(x.len()).velocity(&hit, [true, false], [SPEED, 0.0])?;
    let notches = [upper_notch(spacing), lower_notch(spacing)];
    let cracked = plate.crack(nodes, &notches, loading, END)?;
    Ok((plate, cracked))
}

/// From beyond the edge, so that it is open.
fn upper_notch(spacing: f64) -> Notch {
    Notch { mouth: [-spacing, HALF], tip: [LENGTH, HALF] }
}

fn lower_notch(spacing: f64) -> Notch {
    Notch { mouth: [-spacing, -HALF], tip: [LENGTH, -HALF] }
}

fn seen(plate: &Plate, cracked: &Cracked) -> CaseResult<Seen> {
    let notch = upper_notch(plate.spacing);
    let path = cracked.path(&notch, END)?.ok_or("no crack grew from the upper notch")?;
    let start = path.until(FITTED)?;
    Ok(Seen {
        angle: start.angle_of_fit(notch.direction()?)?.to_degrees(),
        speed: cracked.tip_speed(&notch, 1.5e-6, 60)? / plate.rayleigh_speed(),
        asymmetry: cracked.asymmetry(),
        n_steps: cracked.n_steps,
    })
}

fn run(context: &Context<'_>) -> CaseResult {
    const MILLIMETRES: [f64; 3] = [1.0, 0.5, 0.25];
    let (mut claims, mut angles) = (Vec::new(), Vec::new());
    let (mut speed, mut asymmetry) = (Worst::default(), Worst::default());
    for dx in MILLIMETRES {
        context.progress(&format!("{dx} mm"));
        let (plate, cracked) = struck(1e-3 * dx)?;
        let seen = seen(&plate, &cracked)?;
        claims.push(angle(context, dx, &seen));
        speed.take(seen.speed, &format!("{dx} mm"));
        asymmetry.take(seen.asymmetry, &format!("{dx} mm"));
        angles.push(seen.angle);
    }
    let method = "1, 0.5 and 0.25 mm, velocity Verlet, steps of 0.8 of the critical one";
    let lines = |method| context.lines("", method);
    for pair in angles.windows(2) {
        if let &[coarse, fine] = pair {
            let name = if claims.len() == MILLIMETRES.len() { "coarse" } else { "fine" };
            let quantity = "fitted angle less that of the mesh of twice the spacing";
            let reason = "the angle is not that of the plate alone: it rises by about as much with each finer mesh, and no limit is in sight";
            let subject = lines(method.into()).of(format!("change-of-angle/{name}"), quantity);
            let claim = subject.unit("degree").measured(fine - coarse, (1.5, 3.0));
            claims.push(claim.because(reason));
        }
    }
    claims.push(
        lines(speed.method(method))
            .of("tip-speed", "fastest growth of the crack over 6 us, over the Rayleigh speed 2744 m/s")
            .bounded(speed.value(), 1.0)
            .because("no crack that opens outruns the waves along its faces; c_R of plane stress, nu = 1/3"),
    );
    let quantity = "share of broken bonds whose image did not break in the same step";
    let reason = "roundoff: the plate is symmetric; 1e-13 of a stretch may move a break by a step, and with it some of thousands";
    let subject = lines(asymmetry.method(method)).of("asymmetry", quantity);
    claims.push(subject.bounded(asymmetry.value(), 5e-3).because(reason));
    Ok(claims)
}

fn angle(context: &Context<'_>, dx: f64, seen: &Seen) -> Claim {
    let method = format!(
        "{dx} mm, horizon 3.015 dx, plane stress, velocity Verlet, {} steps of 0.8 of the critical one",
        seen.n_steps
    );
    let lines = context.lines(format!("dx-{dx}mm"), method);
    let quantity = "angle from the notch to the line through 30 mm of crack";
    let angle = lines.of("fitted-angle", quantity).unit("degree");
    if dx > 0.6 {
        let reason = "a mesh of 50 nodes along the notch, coarser than the experiment is claimed for: 70 degrees";
        return angle.measured(seen.angle, (62.5, 64.5)).because(reason);
    }
    let reason = "65 to 75 degrees is all that the experiment, about 70, can support; another code gets 64.9 and 65.5 on these meshes";
    angle.absolute(seen.angle, 70.0).within(4.5).because(reason)
}
