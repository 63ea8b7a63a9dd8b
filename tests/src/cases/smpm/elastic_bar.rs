//! A bar in its first mode: closed form, order, energy, by shape function and update order; and a free one for momentum.

use smpm::material::{LinearElasticParameters, LinearElasticSolid};
use smpm::{
    Body, Boundary, BoundaryKind, BulkViscosity, Config, Fill, Shape, Side, Simulation, Transfer,
    UpdateOrder,
};

use crate::case::{Case, CaseError, Context, Profile};
use crate::claim::{Criterion, Measured, Reference};
use crate::report::{Claim, ErrorKind};

pub(crate) const CASE: Case = Case {
    id: "smpm/elastic-bar",
    title: "An elastic bar, fixed and free, in its first mode over one period",
    source: "linear vibration: v = v_0 cos(w t) sin(b x), b = pi/(2 L), w = b sqrt(E/rho); the bar of Bardenhagen 2002",
    cost: Profile::Quick,
    run,
};

const LENGTH: f64 = 25.0;
const PERIOD: f64 = 10.0;
/// A strain of 6e-6: what is not linear is far below the errors.
const SPEED: f64 = 1e-4;

const SHAPES: [(Shape, &str); 4] = [
    (Shape::Linear, "linear"),
    (Shape::Gimp, "gimp"),
    (Shape::QuadraticBSpline, "quadratic"),
    (Shape::CubicBSpline, "cubic"),
];
const ORDERS: [(UpdateOrder, &str); 3] = [
    (UpdateOrder::StressFirst, "usf"),
    (UpdateOrder::StressLast, "usl"),
    (UpdateOrder::ModifiedStressLast, "musl"),
];
const FLIP: Transfer = Transfer::Flip { damping_time: f64::INFINITY };

/// After a period: root mean square of the error of the velocity over its amplitude, and the energy over that of the start.
fn vibrate(config: &Config<1>) -> Result<(f64, f64), CaseError> {
    let material = LinearElasticSolid::linear_elastic(LinearElasticParameters {
        density: 1.0,
        young_modulus: 100.0,
        poisson_ratio: 0.0,
    })?;
    let mode = |x: f64| (std::f64::consts::PI * x / (2.0 * LENGTH)).sin();
    let fill = Fill::of([0.5 * config.cell], ([0.0], [LENGTH]), |_| true);
    let mut body = Body::new(material, &fill, [0.0])?;
    body.set_velocities(|x| [SPEED * mode(x[0])])?;
    let fixed = Boundary { axis: 0, position: 0.0, side: Side::Above, kind: BoundaryKind::Clamped };
    let viscosity = BulkViscosity { quadratic: 0.0, linear: 0.0 };
    let mut run = Simulation::new(
        Config { boundaries: vec![fixed], viscosity, ..config.clone() },
        vec![body],
    )?;
    let before = run.ledger();
    run.advance_to(PERIOD)?;
    let after = run.ledger();
    let bar = &run.bodies()[0];
    let square = |(x, v): (&[f64; 1], &[f64; 1])| (v[0] / SPEED - mode(x[0])).powi(2);
    let sum: f64 = bar.positions().iter().zip(bar.velocities()).map(square).sum();
    let energy = (after.kinetic + after.internal) / (before.kinetic + before.internal);
    Ok(((sum / bar.n_particles() as f64).sqrt(), energy))
}

fn run(context: &Context<'_>) -> Result<Vec<Claim>, CaseError> {
    let mut claims = Vec::new();
    for (shape, shape_name) in SHAPES {
        for (update_order, order_name) in ORDERS {
            let name = format!("{shape_name}-{order_name}");
            let config =
                |cell| Config { shape, update_order, transfer: FLIP, ..Config::with_cell(cell) };
            claims.extend(rows(context, &name, config, shape)?);
        }
    }
    let apic = |cell| Config { transfer: Transfer::Apic, ..Config::with_cell(cell) };
    claims.extend(rows(context, "quadratic-musl-apic", apic, Shape::QuadraticBSpline)?);
    claims.push(momentum(context)?);
    Ok(claims)
}

fn rows(
    context: &Context<'_>,
    name: &str,
    config: impl Fn(f64) -> Config<1>,
    shape: Shape,
) -> Result<[Claim; 3], CaseError> {
    context.progress(name);
    let (coarse, _) = vibrate(&config(LENGTH / 25.0))?;
    let (fine, energy) = vibrate(&config(LENGTH / 50.0))?;
    let order = (coarse / fine).log2();
    let method = format!("{name}, 50 cells, 2 particles a cell, one period");
    let (tolerance, least) = match shape {
        Shape::Linear => (0.1, 0.3),
        _ => (0.03, 1.0),
    };
    Ok([
        Claim::judge(
            context.subject(
                &format!("{name}/velocity"),
                "root mean square error of v, over v_0",
                "",
                &method,
            ),
            ErrorKind::Absolute,
            Measured::exact(fine),
            Reference::exact(0.0),
            Criterion::Within {
                tolerance,
                reason: "second order in the cell; what hats do not see inside a cell is of first",
            },
        ),
        Claim::as_measured(
            context.subject(
                &format!("{name}/order"),
                "order of that error between 25 and 50 cells",
                "",
                &method,
            ),
            Measured::exact(order),
            least,
            4.0,
            "two of the transfer where the mode is resolved",
        ),
        Claim::judge(
            context.subject(
                &format!("{name}/energy"),
                "energy after a period, over that of the start",
                "",
                &method,
            ),
            ErrorKind::Relative,
            Measured::exact(energy),
            Reference::exact(1.0),
            Criterion::Within {
                tolerance: 0.05,
                reason: "no method here keeps it exactly: USF gains, USL and APIC lose",
            },
        ),
    ])
}

/// Two free rods that meet: the sum of their momenta.
fn momentum(context: &Context<'_>) -> Result<Claim, CaseError> {
    let material = LinearElasticSolid::linear_elastic(LinearElasticParameters {
        density: 1.0,
        young_modulus: 100.0,
        poisson_ratio: 0.3,
    })?;
    let rod = |from: f64, to: f64, velocity: [f64; 2]| {
        Body::new(material, &Fill::of([0.25; 2], ([from, 0.0], [to, 2.0]), |_| true), velocity)
    };
    let bodies = vec![rod(0.0, 5.0, [0.3, 0.1])?, rod(5.5, 9.0, [-0.2, 0.0])?];
    let mut run = Simulation::new(Config::<2>::with_cell(0.5), bodies)?;
    let before = run.ledger().momentum;
    run.advance_to(4.0)?;
    let after = run.ledger().momentum;
    let scale: f64 = 5.0 * 2.0 * 0.3;
    let change = ((after[0] - before[0]).powi(2) + (after[1] - before[1]).powi(2)).sqrt() / scale;
    Ok(Claim::judge(
        context.subject(
            "momentum",
            "change of the momentum of two rods that meet, over that of one",
            "",
            "plane strain, quadratic B-splines, MUSL",
        ),
        ErrorKind::Absolute,
        Measured::exact(change),
        Reference::exact(0.0),
        Criterion::Within {
            tolerance: 1e-12,
            reason: "roundoff of some hundred steps: shape functions sum to one",
        },
    ))
}
