//! TNT: the state behind its front, and what it does to steel that it touches.

use perturbation_moments::{Jet, Scalar};
use smpm::material::{Detonation, Fluid, Jwl, MieGruneisen, Solid, Units, library};
use smpm::{
    Body, Boundary, BoundaryKind, BulkViscosity, Config, Fill, Number, Shape, Side, Simulation,
    Transfer,
};

use crate::cases::prelude::*;

pub(crate) const CASE: Case = Case {
    id: "smpm/detonation",
    title: "Plane detonation of TNT: Chapman-Jouguet state, energy released, and the shock in steel behind it",
    source: "Chapman-Jouguet state of the JWL equation with E_0 = 7 GPa; impedance match with the isentrope; Dobratz and Crawford 1985",
    cost: Profile::Quick,
    run: Together(run),
};

const UNITS: Units = Units::CM_G_US;
/// Length of the charge whose front is looked at, and of the one on steel (cm).
const CHARGES: [f64; 2] = [10.0, 4.0];
/// Chapman-Jouguet pressure (Mbar) and velocity (cm/us), from the constants.
const CHAPMAN_JOUGUET: [f64; 2] = [0.209_987_5, 0.185_914_5];
/// Pressure at the contact with steel (Mbar), and `dp/dS_1`.
const CONTACT: f64 = 0.350_932_6;
const CONTACT_SLOPE: f64 = 0.010_330_31;
const FROZEN_OVER_TRUE: f64 = 9.85;

/// A charge lit at its left end against a wall, and steel behind it where its `S_1` is given. With steel, all run into the
/// wall with the velocity of the products: behind the front they are then at rest in the state of Chapman and Jouguet, without
/// a Taylor wave.
fn charge<S: Number>(cell: f64, slope: Option<S>) -> CaseResult<Simulation<S, 1>> {
    let length = CHARGES[usize::from(slope.is_some())];
    let velocity = if slope.is_some() { -CHAPMAN_JOUGUET[1] } else { 0.0 };
    let wall = Boundary { axis: 0, position: 0.0, side: Side::Above, kind: BoundaryKind::Symmetry };
    // APIC takes 0.8 % of the energy at the front, whatever the cell: enough to miss the tangent of Chapman and Jouguet by 4 %.
    // Behind a shock in steel it is the one whose derivatives settle.
    let (transfer, linear) =
        if slope.is_some() { (Transfer::Apic, 1.0) } else { (Transfer::Flip, 0.3) };
    let config = Config {
        boundaries: vec![wall],
        shape: Shape::CubicBSpline,
        transfer,
        viscosity: BulkViscosity { quadratic: 1.5, linear },
        ..Config::with_cell(cell)
    };
    let detonation = Detonation { point: [0.0; 3], cells: 3.0 };
    let tnt = library::tnt(UNITS).map(|_, value| <S as Scalar>::constant(value));
    let tnt = Solid { equation: Jwl::new(tnt, detonation)?, strength: Fluid };
    let fill = |from, to| Fill::of([0.5 * cell], ([from], [to]), |_| true);
    let mut bodies = vec![Body::new(tnt, &fill(0.0, length)?, [velocity])?];
    if let Some(slope) = slope {
        let steel = library::steel_equation(UNITS)
            .map(|name, value| if name == "s1" { slope } else { <S as Scalar>::constant(value) });
        let steel = Solid { equation: MieGruneisen::new(steel)?, strength: Fluid };
        bodies.push(Body::new(steel, &fill(length, length + 4.0)?, [velocity])?);
    }
    Ok(Simulation::new(config, bodies)?)
}

/// When the front is close to the end of the charge.
struct Front {
    /// Largest pressure and velocity.
    peak: [f64; 2],
    /// Over that of the start.
    energy: f64,
    /// Mean distance of the pressure from the isentrope, over that of Chapman and Jouguet, behind the front.
    off_isentrope: f64,
}

/// The pressure along the isentrope through the state of Chapman and Jouguet:
/// `p = A exp(-R_1 V) + B exp(-R_2 V) + C V^-(1 + omega)`.
fn isentrope(volume: f64) -> f64 {
    let tnt = library::tnt(UNITS);
    let cold = |v: f64| tnt.a * (-tnt.r1 * v).exp() + tnt.b * (-tnt.r2 * v).exp();
    let at_front = 1.0 - CHAPMAN_JOUGUET[1] / 0.692_935;
    let power = -(1.0 + tnt.omega);
    let constant = (CHAPMAN_JOUGUET[0] - cold(at_front)) / at_front.powf(power);
    cold(volume) + constant * volume.powf(power)
}

fn front(cell: f64) -> CaseResult<Front> {
    let mut run = charge::<f64>(cell, None)?;
    let before = run.ledger();
    run.advance_to(13.5)?;
    let after = run.ledger();
    let body = &run.bodies()[0];
    let largest = |of: &dyn Fn(usize) -> f64| (0..body.n_particles()).map(of).fold(0.0, f64::max);
    // From a centimetre off the wall, where the burn began, to one behind the front.
    let behind: Vec<f64> = (0..body.n_particles())
        .filter(|&p| (1.0..8.0).contains(&body.position(p)[0]))
        .map(|p| (body.pressure(p) - isentrope(body.volume_ratio(p))).abs() / CHAPMAN_JOUGUET[0])
        .collect();
    Ok(Front {
        peak: [largest(&|p| body.pressure(p)), largest(&|p| body.velocity(p)[0])],
        energy: (after.kinetic + after.internal) / (before.kinetic + before.internal),
        off_isentrope: behind.iter().sum::<f64>() / behind.len() as f64,
    })
}

fn run(context: &Context<'_>) -> CaseResult {
    context.progress("front");
    let front = front(0.006_25)?;
    let method = "cubic B-splines, FLIP, MUSL; cells of 0.0625 mm";
    let line = |method: &str| context.lines("", method);
    let mut claims = Vec::new();
    for (k, (name, quantity, unit)) in
        [("pressure", "p behind the front", "Mbar"), ("velocity", "u behind the front", "cm/us")]
            .into_iter()
            .enumerate()
    {
        let reason = "the peak is a cusp, behind which the Taylor wave falls off: a burn of three cells cuts it, 6, 3 and 1.5 % at 0.25, 0.125 and 0.0625 mm. The ringing of FLIP lifts it, to 0.3 % above at 0.03 mm: no order is claimed";
        let subject = line(method).of(format!("front/{name}"), quantity).unit(unit);
        let compared = subject.relative(front.peak[k], CHAPMAN_JOUGUET[k]);
        claims.push(compared.within(0.03).because(reason));
    }
    let reason = "FLIP at the front, the same with every cell";
    let subject = line(method).of("energy", "energy over that of the start, burnt or not");
    claims.push(subject.relative(front.energy, 1.0).within(2e-3).because(reason));
    claims.push(
        line("as above, from one to eight of the nine centimetres burnt")
            .of("taylor-wave", "mean distance of p from the isentrope, over p at the front")
            .bounded(front.off_isentrope, 6e-5)
            .because("the entropy that front and viscosity leave behind, most near the wall where the burn began: 1.7e-5 of it stays with finer cells"),
    );
    context.progress("contact with steel");
    claims.extend(contact(context)?);
    Ok(claims)
}

/// The pressure in the steel right behind the contact, and its derivative, over a window in space and time.
fn contact(context: &Context<'_>) -> CaseResult {
    let cell = 0.025;
    let slope = library::steel_equation(UNITS).s1;
    let mut run = charge::<Jet>(cell, Some(Jet::variable(slope, 0)))?;
    let starts: Vec<f64> = run.bodies()[1].positions().iter().map(|x| x[0].value).collect();
    // The front has run through the charge in 5.8 us, and the shock 11 mm into the steel since.
    run.advance_to(CHARGES[1] / 0.693 + 2.0)?;
    let body = &run.bodies()[1];
    let window: Vec<Jet> = (0..starts.len())
        .filter(|&p| (CHARGES[1] + 0.1..CHARGES[1] + 0.5).contains(&starts[p]))
        .map(|p| body.pressure(p))
        .collect();
    let n = window.len() as f64;
    let mean = window.iter().fold(Jet::constant(0.0), |sum, &p| sum + p) * (1.0 / n);
    let local = body.at_local_state(&local_state(body, &starts));
    let frozen = local.ok_or("steel has local formulas")?.pressure.first[0];
    let method =
        "cubic B-splines, APIC, MUSL, viscosity 1.5 and 1, 0.25 mm, mean over 4 mm of steel";
    let lines = context.lines("contact", method);
    Ok(vec![
        lines
            .of("pressure", "p in the steel at the contact")
            .unit("Mbar")
            .relative(mean.value, CONTACT)
            .within(0.01)
            .because("the reference recompresses along the isentrope, and the front is 3 cells of burn wide"),
        lines
            .of("slope", "dp/dS_1 there")
            .unit("Mbar")
            .relative(mean.first[0], CONTACT_SLOPE)
            .within(0.02)
            .because("as the pressure, and what the ringing leaves in the mean"),
        lines
            .of("frozen-over-true", "frozen dp/dS_1 over the true one")
            .relative(frozen / CONTACT_SLOPE, FROZEN_OVER_TRUE)
            .within(0.1)
            .because("at the run's volume and energy: a frozen code shows this instead of 1"),
    ])
}

/// The state in numbers in the middle of the window.
fn local_state(body: &Body<Jet, 1>, starts: &[f64]) -> smpm::material::LocalState {
    let middle = starts.iter().position(|&x| x > CHARGES[1] + 0.3).unwrap_or(0);
    let seen = body.observe(middle);
    smpm::material::LocalState {
        volume: body.volume_ratio(middle).value,
        pressure: body.pressure(middle).value,
        observed: smpm::material::Observed {
            energy: seen.energy.value,
            plastic_strain: 0.0,
            flow_stress: 0.0,
            temperature: 0.0,
            damage: 0.0,
            overshoot: 0.0,
        },
    }
}
