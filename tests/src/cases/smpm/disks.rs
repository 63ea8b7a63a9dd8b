//! Two elastic disks that collide: time of contact, momentum, energy, rebound. And friction on an incline.

use serde::Deserialize;
use smpm::material::{LinearElasticParameters, LinearElasticSolid};
use smpm::{
    Body, BulkViscosity, Config, Contact, Error, Fill, Ledger, Shape, Simulation, Transfer,
};

use super::incline::Inclines;
use super::methods::{METHODS, Method};
use crate::cases::prelude::*;

pub(crate) const CASE: Case = Case {
    id: "smpm/disks",
    title: "Two elastic disks collide, bonded as in the paper and in frictionless contact; a block on an incline sticks and slides",
    source: "Sulsky, Chen and Schreyer 1994, section 4; the time of contact is (0.6 - 0.4/sqrt(2))/0.2, energy is conserved, and by symmetry the momentum stays zero; the rebound is the limit under refinement; the block follows Coulomb's law",
    cost: Profile::Quick,
    run: Together(run),
};

#[derive(Debug, Deserialize)]
struct ReferenceDisks {
    contact_time_exact: f64,
    rebound: f64,
    rebound_error: f64,
}

const RADIUS: f64 = 0.2;
const DENSITY: f64 = 1000.0;
/// Of each, along both axes.
const SPEED: f64 = 0.1;
/// By then the disks have separated.
const END: f64 = 3.5;
const CELL: f64 = RADIUS / 8.0;
/// By this part of it the kinetic energy has begun to fall.
const DECLINE: f64 = 1e-6;

/// Half the range in which the rebound may be.
const REBOUND: f64 = 0.003;

const FRICTIONLESS: Contact = Contact::Friction { coefficient: 0.0 };

/// Results of a collision.
struct Collision {
    /// When the kinetic energy has begun to fall.
    touched: f64,
    /// The largest momentum of both, over that of one.
    momentum: f64,
    /// At the end over that of the start, less one.
    energy: f64,
    /// The largest until then.
    peak: f64,
    /// The velocity of the first disk at the end, over that of the start, turned about.
    rebound: f64,
}

/// Two disks of these densities.
fn disks(config: Config<2>, densities: [f64; 2]) -> Result<Simulation<f64, 2>, Error> {
    let disk = |centre: f64, speed: f64, density: f64| {
        let material = LinearElasticSolid::linear_elastic(LinearElasticParameters {
            density,
            young_modulus: 1000.0,
            poisson_ratio: 0.3,
        })?;
        let within = |x: &[f64; 2]| (x[0] - centre).hypot(x[1] - centre) < RADIUS;
        let corners = ([centre - RADIUS; 2], [centre + RADIUS; 2]);
        Body::new(material, &Fill::of([0.5 * config.cell; 2], corners, within)?, [speed; 2])
    };
    let bodies = vec![disk(0.2, SPEED, densities[0])?, disk(0.8, -SPEED, densities[1])?];
    let viscosity = BulkViscosity { quadratic: 0.0, linear: 0.0 };
    Simulation::new(Config { viscosity, ..config }, bodies)
}

fn collide(config: Config<2>) -> Result<Collision, Error> {
    let mut run = disks(config, [DENSITY; 2])?;
    let start = run.ledger();
    let of_one = run.ledgers()[0].momentum[0];
    let (mut touched, mut momentum, mut peak) = (f64::NAN, 0.0_f64, 0.0_f64);
    let energy_of = |now: Ledger<2>| (now.kinetic + now.internal) / start.kinetic - 1.0;
    while run.time() < END {
        let _ = run.step()?;
        let now = run.ledger();
        if touched.is_nan() && now.kinetic < start.kinetic * (1.0 - DECLINE) {
            touched = run.time();
        }
        peak = peak.max(energy_of(now));
        momentum = momentum.max(now.momentum[0].hypot(now.momentum[1]) / of_one);
    }
    let end = run.ledger();
    Ok(Collision {
        touched,
        momentum,
        energy: energy_of(end),
        peak,
        rebound: -run.ledgers()[0].momentum[0] / of_one,
    })
}

/// The momentum of disks of unequal masses, over that of the first at the start: its largest change in a collision. No symmetry
/// conserves it.
fn unequal(config: Config<2>) -> CaseResult<f64> {
    let mut run = disks(config, [DENSITY, 3.0 * DENSITY])?;
    let (start, of_first) = (run.ledger().momentum, run.ledgers()[0].momentum[0]);
    let mut change = 0.0_f64;
    while run.time() < END {
        let _ = run.step()?;
        let now = run.ledger().momentum;
        change = change.max((now[0] - start[0]).hypot(now[1] - start[1]) / of_first);
    }
    if run.ledgers()[0].momentum[0] > 0.0 {
        return Err("the lighter disk has not turned about".into());
    }
    Ok(change)
}

/// A collision by one of the methods.
struct Run {
    method: Method,
    contact: Contact,
    collision: Collision,
}

impl ReferenceDisks {
    /// Cells along the line of centres between undeformed disks at a time.
    fn gap_at(&self, time: f64) -> f64 {
        (self.contact_time_exact - time) * 2.0 * SPEED * std::f64::consts::SQRT_2 / CELL
    }
}

fn run(context: &Context<'_>) -> CaseResult {
    let text = include_str!("../../../reference/derived/smpm/disks.json");
    let reference: ReferenceDisks = serde_json::from_str(text)?;
    let (mut runs, mut claims) = (Vec::new(), Vec::new());
    let (mut inclines, mut change) = (Inclines::default(), Worst::of_errors());
    for method in &METHODS {
        // The default method alone where time is short.
        let is_default =
            method.shape == Shape::QuadraticBSpline && method.transfer == Transfer::Flip;
        if context.profile == Profile::Quick && !is_default {
            continue;
        }
        context.progress(&method.name());
        for contact in [Contact::Bonded, FRICTIONLESS] {
            let collision = collide(Config { contact, ..method.config(CELL) })?;
            runs.push(Run { method: *method, contact, collision });
        }
        if method.transfer == Transfer::Flip {
            inclines.take(*method)?;
            let config = Config { contact: FRICTIONLESS, ..method.config(CELL) };
            change.take(unequal(config)?, &method.name());
        }
    }
    let method = change.method("the second disk three times as dense");
    let quantity = "largest change of the momentum of both, over that of the first";
    let reason = "nodes lighter than 1e-12 of a particle do not move: some tens of them in each of a thousand steps";
    let subject = context.lines("unequal", method).of("momentum", quantity);
    claims.push(subject.bounded(change.value(), 5e-10).because(reason));
    claims.extend(inclines.claims(context));
    claims.extend(of_all(context, &runs));
    for contact in [Contact::Bonded, FRICTIONLESS] {
        claims.push(rebound(context, &runs, contact, &reference));
    }
    for run in &runs {
        let id = format!("{}/{}", run.method.name(), name_of(run.contact));
        let lines = context.lines(&id, format!("{id}, {CELLS}"));
        if run.method.transfer == Transfer::Flip {
            claims.extend(of_flip(&lines, run, &reference));
        } else {
            claims.push(of_apic(&lines, run));
        }
    }
    claims.push(touch(context, &runs, &reference));
    Ok(claims)
}

const CELLS: &str = "16 cells to a diameter";

fn name_of(contact: Contact) -> &'static str {
    if contact == Contact::Bonded { "bonded" } else { "contact" }
}

/// When disks in contact touch, at the worst.
fn touch(context: &Context<'_>, runs: &[Run], reference: &ReferenceDisks) -> Claim {
    let touching = runs.iter().filter(|run| run.contact == FRICTIONLESS);
    let (early, method) = worst(touching, |collision| reference.gap_at(collision.touched));
    let quantity =
        "cells along the line of centres that are left when the kinetic energy begins to fall";
    let reason =
        "a fraction of a cell: the rim of a disk is a staircase of particles half a cell wide";
    context.lines("contact", method).of("touch", quantity).bounded(early, 0.5).because(reason)
}

/// The value that is largest in size over some of the runs, and a method text that names the runs and where it is.
fn worst<'a>(
    runs: impl Iterator<Item = &'a Run>,
    value: impl Fn(&Collision) -> f64,
) -> (f64, String) {
    let (mut largest, mut place, mut names) = (0.0_f64, String::new(), Vec::new());
    for run in runs {
        let (here, name) =
            (value(&run.collision), format!("{} {}", run.method.name(), name_of(run.contact)));
        // NaN stays.
        if here.is_nan() || here.abs() >= largest.abs() {
            (largest, place) = (here, name.clone());
        }
        names.push(name);
    }
    (largest, format!("worst of {}, at {place}; {CELLS}", names.join(", ")))
}

fn of_all(context: &Context<'_>, runs: &[Run]) -> [Claim; 2] {
    let (momentum, of_momentum) = worst(runs.iter(), |collision| collision.momentum);
    let (peak, of_peak) = worst(runs.iter(), |collision| collision.peak);
    let lines = |method| context.lines("", method);
    [
        lines(of_momentum)
            .of("momentum", "largest momentum of both over that of one")
            .bounded(momentum, 4e-14)
            .because("roundoff: sums over some thousand particles and steps"),
        lines(of_peak)
            .of("peak-energy", "largest energy of the collision, over that of the start, less one")
            .bounded(peak, 0.02)
            .because("an impulse adds no energy; velocities are half a step from positions, so the sum oscillates while the disks are squeezed"),
    ]
}

/// The rebound of the worst FLIP run. A regression bound: its reference is a limit of finer runs of the same code.
fn rebound(
    context: &Context<'_>,
    runs: &[Run],
    contact: Contact,
    reference: &ReferenceDisks,
) -> Claim {
    let of =
        runs.iter().filter(|run| run.method.transfer == Transfer::Flip && run.contact == contact);
    let (apart, method) = worst(of, |collision| collision.rebound - reference.rebound);
    let seen = if contact == FRICTIONLESS { -0.0456 } else { 0.0165 };
    let lines = context.lines(name_of(contact), method);
    lines
        .of("rebound", "velocity of a disk after over that before, reversed")
        .absolute(
            reference.rebound + apart,
            Reference::uncertain(reference.rebound, reference.rebound_error),
        )
        .as_measured(seen - REBOUND, seen + REBOUND)
        .because("first order in the cell: bonded from above, contact from below; the limit is that of finer runs of the same code")
}

fn of_flip(lines: &Lines<'_>, run: &Run, reference: &ReferenceDisks) -> Vec<Claim> {
    let Run { method, contact, collision } = run;
    let mut claims = vec![
        lines
            .of("energy", "energy at the end, over that of the start, less one")
            .bounded(collision.energy, 0.01)
            .because("one per cent is the target of the source"),
    ];
    if *contact == Contact::Bonded {
        let early = reference.gap_at(collision.touched);
        let seen = match method.shape {
            Shape::QuadraticBSpline => 2.64,
            Shape::CubicBSpline => 3.25,
        };
        let quantity =
            "cells along the line of centres that are left when the kinetic energy begins to fall";
        let reason = "bonded bodies interact at nodes that both share, so before they touch";
        let claim = lines.of("touch", quantity).measured(early, (seen - 0.15, seen + 0.15));
        claims.push(claim.because(reason));
    }
    claims
}

fn of_apic(lines: &Lines<'_>, run: &Run) -> Claim {
    let seen = match (run.method.shape, run.contact == FRICTIONLESS) {
        (Shape::QuadraticBSpline, false) => -0.1258,
        (Shape::QuadraticBSpline, true) => -0.1001,
        (Shape::CubicBSpline, false) => -0.1750,
        (Shape::CubicBSpline, true) => -0.1252,
    };
    lines
        .of("energy", "energy at the end, over that of the start, less one")
        .measured(run.collision.energy, (1.1 * seen, 0.9 * seen))
        .because("APIC filters what is not affine over a cell, at every step")
}
