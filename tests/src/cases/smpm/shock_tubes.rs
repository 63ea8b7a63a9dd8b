//! Riemann problems between gases, liquids and metal as stiffened gases: profiles against the exact solution.

use smpm::material::{Fluid, Solid, StiffenedGas, StiffenedGasParameters};
use smpm::{
    Body, Boundary, BoundaryKind, BulkViscosity, Config, Fill, Shape, Side, Simulation, Transfer,
};

use crate::cases::prelude::*;
use crate::smpm::riemann::{Gas, Riemann};

pub(crate) const CASE: Case = Case {
    id: "smpm/shock-tubes",
    title: "Riemann problems: Sod's, water, steel",
    source: "exact solution of the Riemann problem; Sod 1978, Toro 2009",
    cost: Profile::Quick,
    run: Together(run),
};

/// A tube from -1 to 1 with the contact at zero.
struct Tube {
    name: &'static str,
    left: Gas,
    right: Gas,
    time: f64,
    /// Of pressure and velocity with 200 cells, twice what is seen.
    tolerances: [f64; 2],
    /// The order of the mean error.
    order: f64,
    /// Where the error with 800 cells over that with 200 was seen with quadratic B-splines, the larger of both.
    quadratic: (f64, f64),
    /// Why the order is that.
    reason: &'static str,
}

const fn gas(density: f64, velocity: f64, pressure: f64, exponent: f64, stiffness: f64) -> Gas {
    Gas { density, velocity, pressure, exponent, stiffness }
}

const GAS: &str = "first order: fronts and kinks are a few cells wide";

/// Centimetre, gram, microsecond but for Sod's pure numbers.
const TUBES: [Tube; 3] = [
    Tube {
        name: "sod",
        left: gas(1.0, 0.0, 1.0, 1.4, 0.0),
        right: gas(0.125, 0.0, 0.1, 1.4, 0.0),
        time: 0.4,
        tolerances: [0.015, 0.025],
        order: 1.0,
        quadratic: (1.3, 1.75),
        reason: GAS,
    },
    Tube {
        name: "water",
        left: gas(1.0, 0.0, 0.01, 4.4, 0.006),
        right: gas(1.0, 0.0, 1e-6, 4.4, 0.006),
        time: 3.0,
        tolerances: [0.025, 0.04],
        order: 1.0,
        quadratic: (0.9, 1.25),
        reason: GAS,
    },
    Tube {
        name: "steel",
        left: gas(7.83, 0.01, 1e-9, 3.0, 0.544_857_362_1),
        right: gas(7.83, 0.0, 1e-9, 3.0, 0.544_857_362_1),
        time: 1.5,
        tolerances: [0.04, 0.035],
        order: 0.5,
        quadratic: (0.45, 0.6),
        reason: "a half: the shock is weak, and the linear viscosity widens it as the root of cell and time, far beyond its steady width",
    },
];

/// Error of pressure and velocity, each the mean over the particles between the walls' waves, over the largest.
fn errors(tube: &Tube, shape: Shape, n_cells: u32) -> CaseResult<[f64; 2]> {
    let exact = Riemann::new(tube.left, tube.right)?;
    let cell = 2.0 / f64::from(n_cells);
    let body = |gas: &Gas, from: f64, to: f64| -> CaseResult<Body<f64, 1>> {
        let equation = StiffenedGas::new(StiffenedGasParameters {
            density: gas.density,
            exponent: gas.exponent,
            stiffness: gas.stiffness,
            pressure: gas.pressure,
        })?;
        let fill = Fill::of([0.5 * cell], ([from], [to]), |_| true)?;
        Ok(Body::new(Solid { equation, strength: Fluid }, &fill, [gas.velocity])?)
    };
    // Room for what moves, and walls that no wave reaches.
    let wall = |position, side| Boundary { axis: 0, position, side, kind: BoundaryKind::Symmetry };
    let config = Config {
        origin: [-2.0],
        boundaries: vec![wall(-2.0, Side::Above), wall(2.0, Side::Below)],
        shape,
        transfer: Transfer::Apic,
        viscosity: BulkViscosity { quadratic: 1.5, linear: 0.3 },
        ..Config::with_cell(cell)
    };
    let bodies = vec![body(&tube.left, -2.0, 0.0)?, body(&tube.right, 0.0, 2.0)?];
    let mut run = Simulation::new(config, bodies)?;
    run.advance_to(tube.time)?;
    let (mut sums, mut largest, mut n) = ([0.0; 2], [0.0_f64; 2], 0.0);
    for body in run.bodies() {
        for particle in 0..body.n_particles() {
            let x = body.position(particle)[0];
            if x.abs() > 1.0 {
                continue;
            }
            let state = exact.at(x / tube.time);
            sums[0] += (body.pressure(particle) - state.pressure).abs();
            sums[1] += (body.velocity(particle)[0] - state.velocity).abs();
            largest[0] = largest[0].max(state.pressure.abs());
            largest[1] = largest[1].max(state.velocity.abs());
            n += 1.0;
        }
    }
    Ok(std::array::from_fn(|k| sums[k] / (n * largest[k])))
}

fn run(context: &Context<'_>) -> CaseResult {
    let mut claims = Vec::new();
    for tube in &TUBES {
        context.progress(tube.name);
        let [coarse, fine] = [100, 200].map(|n_cells| errors(tube, Shape::CubicBSpline, n_cells));
        let (coarse, fine) = (coarse?, fine?);
        let method = |shape: &str, cells: &str| {
            format!(
                "{shape} B-splines, APIC, MUSL, viscosity 1.5 and 0.3, 2 particles a cell, {cells}"
            )
        };
        let lines = |method: String| context.lines(tube.name, method);
        let mut order = Worst::about(tube.order);
        for (k, quantity) in ["pressure", "velocity"].into_iter().enumerate() {
            claims.push(
                lines(method("cubic", "200 cells"))
                    .of(quantity, "mean absolute error, over the largest value")
                    .bounded(fine[k], tube.tolerances[k])
                    .because(tube.reason),
            );
            order.take((coarse[k] / fine[k]).log2(), quantity);
        }
        claims.push(
            lines(order.method(&method("cubic", "100 and 200 cells")))
                .of("order", "order of the mean error of pressure or velocity")
                .absolute(order.value(), tube.order)
                .within(0.15)
                .because(tube.reason),
        );
        let [fine, finest] =
            [200, 800].map(|n_cells| errors(tube, Shape::QuadraticBSpline, n_cells));
        let (fine, finest) = (fine?, finest?);
        claims.push(
            lines(method("quadratic", "800 over 200 cells"))
                .of("quadratic", "ratio of the mean errors of pressure or velocity, the larger")
                .measured((finest[0] / fine[0]).max(finest[1] / fine[1]), tube.quadratic)
                .because("with quadratic B-splines, APIC and two particles a cell the errors of gases grow beyond 400 cells; cubic ones, FLIP or four particles do not"),
        );
    }
    Ok(claims)
}
