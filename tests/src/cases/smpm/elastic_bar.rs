//! An elastic bar, in its first mode and against a wall: closed forms, order, energy and momentum, by shape function and
//! transfer.

use serde::Deserialize;
use smpm::material::{LinearElasticParameters, LinearElasticSolid};
use smpm::{Body, Boundary, BoundaryKind, BulkViscosity, Config, Fill, Side, Simulation, Transfer};

use super::methods::{METHODS, Method};
use crate::cases::prelude::*;

pub(crate) const CASE: Case = Case {
    id: "smpm/elastic-bar",
    title: "An elastic bar, fixed and free, in its first mode; one that runs into a wall; two that meet",
    source: "linear vibration: v = v_0 cos(w t) sin(b x), b = pi/(2 L), w = b sqrt(E/rho), the bar of Bardenhagen 2002; impact: sigma = -rho c V until 2 L/c",
    cost: Profile::Quick,
    run: Together(run),
};

const NO_VISCOSITY: BulkViscosity = BulkViscosity { quadratic: 0.0, linear: 0.0 };

#[derive(Debug, Deserialize)]
struct ReferenceBars {
    vibration: Vibration,
    wall_impact: WallImpact,
}

#[derive(Debug, Deserialize)]
struct Vibration {
    #[serde(rename = "E")]
    young_modulus: f64,
    rho: f64,
    #[serde(rename = "L")]
    length: f64,
    omega: f64,
    period: f64,
}

#[derive(Debug, Deserialize)]
struct WallImpact {
    steel: Steel,
    /// Speed of longitudinal waves.
    #[serde(rename = "cL")]
    speed: f64,
    /// Bulk modulus.
    #[serde(rename = "K")]
    bulk_modulus: f64,
    /// Over the length.
    #[serde(rename = "contact_time_per_L")]
    contact_time: f64,
}

#[derive(Debug, Deserialize)]
struct Steel {
    rho0: f64,
    /// Shear modulus.
    #[serde(rename = "G")]
    shear_modulus: f64,
}

/// A strain of 6e-6: what is not linear is far below the errors.
const SPEED: f64 = 1e-4;

/// Methods whose errors have one reason: shape functions are taken together.
const FAMILIES: [Family; 2] = [
    Family {
        name: "musl",
        transfer: Transfer::Flip,
        order: (1.0, 1.45),
        wall_order: (0.38, 0.48),
        tolerances: [0.008, 2e-4, 4e-4, 0.015, 0.08, 0.005, 0.03],
    },
    Family {
        name: "musl-apic",
        transfer: Transfer::Apic,
        order: (1.0, 1.25),
        wall_order: (0.53, 0.63),
        tolerances: [0.008, 5e-4, 5e-4, 4e-3, 0.045, 0.04, 0.03],
    },
];

/// Methods taken together, and how far they may be off.
struct Family {
    name: &'static str,
    transfer: Transfer,
    /// Where the order farthest from one is.
    order: (f64, f64),
    /// Where the least order at the wall is.
    wall_order: (f64, f64),
    /// Of velocity, displacement and energy of the vibration; of stress, velocity, energy and rebound at the wall.
    tolerances: [f64; 7],
}

fn run(context: &Context<'_>) -> CaseResult {
    let text = include_str!("../../../reference/derived/smpm/elastic_bar.json");
    let reference: ReferenceBars = serde_json::from_str(text)?;
    let mut claims = Vec::new();
    let mut change = Worst::of_errors();
    for family in &FAMILIES {
        let of_family = METHODS.iter().filter(|method| method.transfer == family.transfer);
        let methods: Vec<&Method> = of_family.collect();
        context.progress(family.name);
        claims.extend(vibration(context, family, &methods, &reference.vibration)?);
        claims.extend(wall_impact(context, family, &methods, &reference.wall_impact)?);
        for method in methods {
            change.take(momentum(*method)?, &method.name());
        }
    }
    let lines = context.lines("", change.method(RODS));
    let quantity = "change of the momentum of two rods that meet, over that of one";
    let reason = "roundoff: of some hundred steps, since shape functions sum to one; and nodes lighter than 1e-12 of a particle, which do not move: a particle whose edge has just passed one loses a part of its force, at these steps 1e-12";
    claims.push(lines.of("momentum", quantity).bounded(change.value(), 1.2e-11).because(reason));
    Ok(claims)
}

const RODS: &str = "plane strain, 0.5 a cell";

/// What is seen of a vibrating bar.
struct Vibrated {
    /// Root mean square errors of velocity and displacement, over their amplitudes.
    velocity: f64,
    displacement: f64,
    /// Over that of the start.
    energy: f64,
}

/// After a period and a quarter: there the velocity passes through zero and shows an error of the phase, the displacement is at
/// its largest and shows one of the amplitude.
fn vibrate(config: &Config<1>, reference: &Vibration) -> CaseResult<Vibrated> {
    let Vibration { young_modulus, rho, length, omega, period } = *reference;
    let material = LinearElasticSolid::linear_elastic(LinearElasticParameters {
        density: rho,
        young_modulus,
        poisson_ratio: 0.0,
    })?;
    let mode = |x: f64| (std::f64::consts::PI * x / (2.0 * length)).sin();
    let fill = Fill::of([0.5 * config.cell], ([0.0], [length]), |_| true)?;
    let mut body = Body::new(material, &fill, [0.0])?;
    body.set_velocities(|x| [SPEED * mode(x[0])])?;
    let fixed = Boundary { axis: 0, position: 0.0, side: Side::Above, kind: BoundaryKind::Clamped };
    let config = Config { boundaries: vec![fixed], viscosity: NO_VISCOSITY, ..config.clone() };
    let mut run = Simulation::new(config, vec![body])?;
    let before = run.ledger();
    run.advance_to(1.25 * period)?;
    let after = run.ledger();
    let bar = &run.bodies()[0];
    let root_mean_square = |error: &dyn Fn(usize) -> f64| {
        let n = bar.n_particles();
        ((0..n).map(|p| error(p).powi(2)).sum::<f64>() / n as f64).sqrt()
    };
    Ok(Vibrated {
        velocity: root_mean_square(&|p| bar.velocity(p)[0] / SPEED),
        displacement: root_mean_square(&|p| {
            let start = fill.positions[p][0];
            (bar.position(p)[0] - start) * omega / SPEED - mode(start)
        }),
        energy: (after.kinetic + after.internal) / (before.kinetic + before.internal),
    })
}

/// The worst of each quantity over the methods of a family.
fn worst<const N: usize>(
    methods: &[&Method],
    targets: [f64; N],
    of: impl Fn(&Method) -> CaseResult<[f64; N]>,
) -> CaseResult<[Worst; N]> {
    let mut all = targets.map(Worst::about);
    for method in methods {
        for (worst, value) in all.iter_mut().zip(of(method)?) {
            worst.take(value, &method.name());
        }
    }
    Ok(all)
}

fn vibration(
    context: &Context<'_>,
    family: &Family,
    methods: &[&Method],
    reference: &Vibration,
) -> CaseResult<[Claim; 4]> {
    let [velocity, order, displacement, energy] = worst(methods, [0.0, 1.0, 0.0, 1.0], |method| {
        let at = |cells: f64| vibrate(&method.config(reference.length / cells), reference);
        let (coarse, fine) = (at(50.0)?, at(100.0)?);
        let order = (coarse.velocity / fine.velocity).log2();
        Ok([coarse.velocity, order, coarse.displacement, coarse.energy])
    })?;
    let lines = |worst: &Worst| {
        context.lines(
            family.name,
            worst.method("50 cells, 2 particles a cell, one and a quarter periods"),
        )
    };
    let [of_velocity, of_displacement, of_energy, ..] = family.tolerances;
    Ok([
        lines(&velocity)
            .of("velocity", "root mean square error of v where it passes through zero, over v_0")
            .bounded(velocity.value(), of_velocity)
            .because("velocities are half a step off the positions, w dt/2 = 0.006, and the step is 0.4 of a cell"),
        lines(&order)
            .of("order", "order of that error between 50 and 100 cells, farthest from one")
            .measured(order.value(), family.order)
            .because("one, by that half step; what else there is, of second order, has either sign"),
        lines(&displacement)
            .of("displacement", "root mean square error of u at its largest, over v_0/w")
            .bounded(displacement.value(), of_displacement)
            .because("second order in the step; APIC damps"),
        lines(&energy)
            .of("energy", "energy over that of the start")
            .relative(energy.value(), 1.0)
            .within(of_energy)
            .because("second order in the step, 1e-4 of it; what APIC takes on top is as much"),
    ])
}

/// What is seen of a bar that runs into a wall.
struct Struck {
    /// Mean stress behind the front, over `-rho c V`.
    stress: f64,
    /// Mean absolute error of the velocity while the front runs away from the wall, over V.
    velocity: f64,
    /// Over that of the start, as the bar is about to leave.
    energy: f64,
    /// The momentum with which it has left, over that with which it came.
    rebound: f64,
}

fn strike(config: &Config<1>, reference: &WallImpact) -> CaseResult<Struck> {
    let WallImpact { steel, speed, bulk_modulus, contact_time } = reference;
    let (k, g) = (*bulk_modulus, steel.shear_modulus);
    let material = LinearElasticSolid::linear_elastic(LinearElasticParameters {
        density: steel.rho0,
        young_modulus: 9.0 * k * g / (3.0 * k + g),
        poisson_ratio: (3.0 * k - 2.0 * g) / (2.0 * (3.0 * k + g)),
    })?;
    let fill = Fill::of([0.5 * config.cell], ([0.0], [1.0]), |_| true)?;
    let bar = Body::new(material, &fill, [-SPEED])?;
    let wall = Boundary {
        axis: 0,
        position: 0.0,
        side: Side::Above,
        kind: BoundaryKind::Rigid { friction: 0.0 },
    };
    let config = Config { boundaries: vec![wall], viscosity: NO_VISCOSITY, ..config.clone() };
    let mut run = Simulation::new(config, vec![bar])?;
    let before = run.ledger();
    // The front is at 0.6 of the length.
    run.advance_to(0.3 * contact_time)?;
    let bar = &run.bodies()[0];
    let starts = fill.positions.iter().map(|x| x[0]).enumerate();
    let exact = |x: f64| if x < 0.6 { 0.0 } else { -1.0 };
    let errors = starts.clone().map(|(p, x)| (bar.velocity(p)[0] / SPEED - exact(x)).abs());
    let velocity = errors.sum::<f64>() / bar.n_particles() as f64;
    let behind: Vec<f64> = starts
        .filter(|(_, x)| (0.1..0.4).contains(x))
        .map(|(p, _)| bar.stress(p).matrix()[0][0])
        .collect();
    let stress = behind.iter().sum::<f64>() / behind.len() as f64;
    run.advance_to(0.95 * contact_time)?;
    let touching = run.ledger();
    run.advance_to(1.3 * contact_time)?;
    Ok(Struck {
        stress: stress / (-steel.rho0 * speed * SPEED),
        velocity,
        energy: (touching.kinetic + touching.internal) / before.kinetic,
        rebound: -run.ledger().momentum[0] / before.momentum[0],
    })
}

fn wall_impact(
    context: &Context<'_>,
    family: &Family,
    methods: &[&Method],
    reference: &WallImpact,
) -> CaseResult<[Claim; 5]> {
    let [stress, velocity, order, energy, rebound] =
        worst(methods, [1.0, 0.0, 1.0, 1.0, 1.0], |method| {
            let (coarse, fine) = (
                strike(&method.config(0.02), reference)?,
                strike(&method.config(0.01), reference)?,
            );
            let order = (coarse.velocity / fine.velocity).log2();
            Ok([fine.stress, fine.velocity, order, fine.energy, fine.rebound])
        })?;
    let lines = |worst: &Worst| {
        context.lines(family.name, worst.method("100 cells, 2 particles a cell, no viscosity"))
    };
    let [_, _, _, of_stress, of_velocity, of_energy, of_rebound] = family.tolerances;
    Ok([
        lines(&stress)
            .of("wall/stress", "mean stress behind the front over -rho c V")
            .relative(stress.value(), 1.0)
            .within(of_stress)
            .because("mean over 30 cells of what rings behind a jump without viscosity"),
        lines(&velocity)
            .of("wall/velocity", "mean absolute error of v as the front runs, over V")
            .bounded(velocity.value(), of_velocity)
            .because("a jump that rings over some cells; APIC and USL ring less"),
        lines(&order)
            .of("wall/order", "order of that error between 50 and 100 cells, the least")
            .measured(order.value(), family.wall_order)
            .because("at a jump a scheme of order p has the order p/(p + 1) in the mean norm: 1/2 to 2/3, and the ringing takes some of it"),
        lines(&energy)
            .of("wall/energy", "energy as the bar is about to leave, over that of the start")
            .relative(energy.value(), 1.0)
            .within(of_energy)
            .because("APIC takes from what rings at the jump, FLIP keeps it"),
        lines(&rebound)
            .of("wall/rebound", "momentum after the contact over that before, turned about")
            .relative(rebound.value(), 1.0)
            .within(of_rebound)
            .because("the closed form is one; a part of the energy stays as ringing"),
    ])
}

/// Two free rods that meet: the change of the sum of their momenta over that of one.
fn momentum(method: Method) -> CaseResult<f64> {
    let material = LinearElasticSolid::linear_elastic(LinearElasticParameters {
        density: 1.0,
        young_modulus: 100.0,
        poisson_ratio: 0.3,
    })?;
    let rod = |from: f64, to: f64, velocity: [f64; 2]| {
        Body::new(material, &Fill::of([0.25; 2], ([from, 0.0], [to, 2.0]), |_| true)?, velocity)
    };
    let bodies = vec![rod(0.0, 5.0, [0.3, 0.1])?, rod(5.5, 9.0, [-0.2, 0.0])?];
    let mut run = Simulation::new(method.config::<2>(0.5), bodies)?;
    let before = run.ledger().momentum;
    run.advance_to(4.0)?;
    let after = run.ledger().momentum;
    let scale: f64 = 5.0 * 2.0 * 0.3;
    Ok((after[0] - before[0]).hypot(after[1] - before[1]) / scale)
}
