//! TNT: the state behind its front, and what it does to steel that it touches.

use perturbation_moments::{Jet, Scalar};
use smpm::material::{Detonation, Fluid, Jwl, MieGruneisen, Solid, Units, library};
use smpm::{
    Body, Boundary, BoundaryKind, BulkViscosity, Config, Fill, Number, Shape, Side, Simulation,
    Transfer,
};

use crate::case::{Case, CaseError, Context, Profile};
use crate::claim::{Criterion, Measured, Reference};
use crate::report::{Claim, ErrorKind};

pub(crate) const CASE: Case = Case {
    id: "smpm/detonation",
    title: "Plane detonation of TNT: Chapman-Jouguet state, energy released, and the shock in steel behind it",
    source: "Chapman-Jouguet state of the JWL equation with E_0 = 7 GPa; impedance match with the isentrope; Dobratz and Crawford 1985",
    cost: Profile::Quick,
    run,
};

const UNITS: Units = Units::CM_G_US;
/// Length of the charge (cm).
const CHARGE: f64 = 10.0;
/// Chapman-Jouguet pressure (Mbar) and velocity (cm/us), from the constants.
const CHAPMAN_JOUGUET: [f64; 2] = [0.209_987_5, 0.185_914_5];
/// Pressure at the contact with steel (Mbar), and `dp/dS_1`.
const CONTACT: f64 = 0.350_932_6;
const CONTACT_SLOPE: f64 = 0.010_330_31;
const FROZEN_OVER_TRUE: f64 = 9.85;

/// A charge from 0 to 10 cm, lit at its left end against a wall, and steel behind it.
fn charge<S: Number>(cell: f64, slope: Option<S>) -> Result<Simulation<S, 1>, CaseError> {
    let wall = Boundary { axis: 0, position: 0.0, side: Side::Above, kind: BoundaryKind::Symmetry };
    let config = Config {
        boundaries: vec![wall],
        shape: Shape::CubicBSpline,
        transfer: Transfer::Apic,
        viscosity: BulkViscosity { quadratic: 1.5, linear: 0.3 },
        // The burn puts its energy in; it is counted from the start.
        ..Config::with_cell(cell)
    };
    let detonation = Detonation { point: [0.0; 3], cells: 3.0 };
    let tnt = library::tnt(UNITS).map(|_, value| <S as Scalar>::constant(value));
    let tnt = Solid { equation: Jwl::new(tnt, detonation)?, strength: Fluid };
    let fill = |from, to| Fill::of([0.5 * cell], ([from], [to]), |_| true);
    let mut bodies = vec![Body::new(tnt, &fill(0.0, CHARGE), [0.0])?];
    if let Some(slope) = slope {
        let steel = library::steel_equation(UNITS)
            .map(|name, value| if name == "s1" { slope } else { <S as Scalar>::constant(value) });
        let steel = Solid { equation: MieGruneisen::new(steel)?, strength: Fluid };
        bodies.push(Body::new(steel, &fill(CHARGE, CHARGE + 6.0), [0.0])?);
    }
    Ok(Simulation::new(config, bodies)?)
}

/// Peak pressure and velocity when the front is close to the end, and the energy over that of the start.
fn peak(cell: f64) -> Result<([f64; 2], f64), CaseError> {
    let mut run = charge::<f64>(cell, None)?;
    let before = run.ledger();
    run.advance_to(13.5)?;
    let after = run.ledger();
    let body = &run.bodies()[0];
    let largest = |of: &dyn Fn(usize) -> f64| (0..body.n_particles()).map(of).fold(0.0, f64::max);
    let energy = (after.kinetic + after.internal) / (before.kinetic + before.internal);
    Ok(([largest(&|p| body.pressure(p)), largest(&|p| body.velocity(p)[0])], energy))
}

fn run(context: &Context<'_>) -> Result<Vec<Claim>, CaseError> {
    context.progress("front");
    let cells = [0.05, 0.025, 0.0125];
    let runs: Vec<([f64; 2], f64)> =
        cells.iter().map(|&cell| peak(cell)).collect::<Result<_, _>>()?;
    let mut claims = Vec::new();
    for (k, (name, quantity, unit)) in
        [("pressure", "p behind the front", "Mbar"), ("velocity", "u behind the front", "cm/us")]
            .into_iter()
            .enumerate()
    {
        // First order: what is missing of the peak is a width of the front.
        let extrapolated = 2.0 * runs[2].0[k] - runs[1].0[k];
        claims.push(Claim::judge(
            context.subject(&format!("front/{name}"), quantity, unit, "cubic B-splines, APIC, MUSL; cells of 0.25 and 0.125 mm, extrapolated at first order"),
            ErrorKind::Relative,
            Measured::exact(extrapolated),
            Reference::exact(CHAPMAN_JOUGUET[k]),
            Criterion::Within { tolerance: 0.03, reason: "the peak is a cusp: the Taylor wave falls off right behind it" },
        ));
    }
    claims.push(Claim::judge(
        context.subject(
            "energy",
            "energy over that of the start, burnt or not",
            "",
            "as above, 0.125 mm",
        ),
        ErrorKind::Relative,
        Measured::exact(runs[2].1),
        Reference::exact(1.0),
        Criterion::Within {
            tolerance: 5e-3,
            reason: "APIC takes some kinetic energy at the front",
        },
    ));
    context.progress("contact with steel");
    claims.extend(contact(context)?);
    Ok(claims)
}

/// The pressure in the steel right behind the contact, and its derivative, over a window in space and time.
fn contact(context: &Context<'_>) -> Result<Vec<Claim>, CaseError> {
    let cell = 0.025;
    let slope = library::steel_equation(UNITS).s1;
    let mut run = charge::<Jet>(cell, Some(Jet::variable(slope, 0)))?;
    let starts: Vec<f64> = run.bodies()[1].positions().iter().map(|x| x[0].value).collect();
    // The shock has left the window, the Taylor wave of ten centimetres of charge has hardly come.
    run.advance_to(14.43 + 1.0)?;
    let body = &run.bodies()[1];
    let window: Vec<Jet> = (0..starts.len())
        .filter(|&p| (CHARGE + 0.1..CHARGE + 0.3).contains(&starts[p]))
        .map(|p| body.pressure(p))
        .collect();
    let n = window.len() as f64;
    let mean = window.iter().fold(Jet::constant(0.0), |sum, &p| sum + p) * (1.0 / n);
    let local = body.at_local_state(&local_state(body, &starts));
    let frozen = local.ok_or("steel has local formulas")?.pressure.first[0];
    let method = "cubic B-splines, APIC, MUSL, 0.25 mm, mean over 2 mm of steel";
    Ok(vec![
        Claim::judge(
            context.subject("contact/pressure", "p in the steel at the contact", "Mbar", method),
            ErrorKind::Relative,
            Measured::exact(mean.value),
            Reference::exact(CONTACT),
            Criterion::Within {
                tolerance: 0.03,
                reason: "what the Taylor wave has taken off by then",
            },
        ),
        Claim::judge(
            context.subject("contact/slope", "dp/dS_1 there", "Mbar", method),
            ErrorKind::Relative,
            Measured::exact(mean.first[0]),
            Reference::exact(CONTACT_SLOPE),
            Criterion::Within {
                tolerance: 0.05,
                reason: "as the pressure, and the ringing's derivative",
            },
        ),
        Claim::judge(
            context.subject(
                "contact/frozen-over-true",
                "frozen dp/dS_1 over the true one",
                "",
                method,
            ),
            ErrorKind::Relative,
            Measured::exact(frozen / CONTACT_SLOPE),
            Reference::exact(FROZEN_OVER_TRUE),
            Criterion::Within {
                tolerance: 0.1,
                reason: "at the run's volume and energy: a frozen code shows this instead of 1",
            },
        ),
    ])
}

/// The state in numbers in the middle of the window.
fn local_state(body: &Body<Jet, 1>, starts: &[f64]) -> smpm::material::LocalState {
    let middle = starts.iter().position(|&x| x > CHARGE + 0.2).unwrap_or(0);
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
