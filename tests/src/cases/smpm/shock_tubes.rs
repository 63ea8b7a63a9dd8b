//! Riemann problems between gases, liquids and metal as stiffened gases: profiles against the exact solution.

use smpm::material::{Fluid, Solid, StiffenedGas, StiffenedGasParameters};
use smpm::{Body, Boundary, BoundaryKind, BulkViscosity, Config, Fill, Side, Simulation, Transfer};

use crate::case::{Case, CaseError, Context, Profile, Schedule};
use crate::cases::lines::Lines;
use crate::report::Claim;
use crate::smpm::riemann::{Gas, Riemann};

pub(crate) const CASE: Case = Case {
    id: "smpm/shock-tubes",
    title: "Riemann problems: Sod's, water, steel",
    source: "exact solution of the Riemann problem; Sod 1978, Toro 2009",
    cost: Profile::Quick,
    schedule: Schedule::Together,
    run,
};

/// A tube from -1 to 1 with the contact at zero.
struct Tube {
    name: &'static str,
    left: Gas,
    right: Gas,
    time: f64,
    /// What is seen of the first-order error with 200 cells, and twice that.
    tolerance: f64,
}

const fn gas(density: f64, velocity: f64, pressure: f64, exponent: f64, stiffness: f64) -> Gas {
    Gas { density, velocity, pressure, exponent, stiffness }
}

/// Centimetre, gram, microsecond but for Sod's pure numbers.
const TUBES: [Tube; 3] = [
    Tube {
        name: "sod",
        left: gas(1.0, 0.0, 1.0, 1.4, 0.0),
        right: gas(0.125, 0.0, 0.1, 1.4, 0.0),
        time: 0.4,
        tolerance: 0.04,
    },
    Tube {
        name: "water",
        left: gas(1.0, 0.0, 0.01, 4.4, 0.006),
        right: gas(1.0, 0.0, 1e-6, 4.4, 0.006),
        time: 3.0,
        tolerance: 0.04,
    },
    Tube {
        name: "steel",
        left: gas(7.83, 0.01, 1e-9, 3.0, 0.544_857_362_1),
        right: gas(7.83, 0.0, 1e-9, 3.0, 0.544_857_362_1),
        time: 1.5,
        tolerance: 0.04,
    },
];

/// Error of pressure and velocity, each the mean over the particles between the walls' waves, over the largest.
fn errors(tube: &Tube, n_cells: u32) -> Result<[f64; 2], CaseError> {
    let exact = Riemann::new(tube.left, tube.right)?;
    let cell = 2.0 / f64::from(n_cells);
    let body = |gas: &Gas, from: f64, to: f64| -> Result<Body<f64, 1>, CaseError> {
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

fn run(context: &Context<'_>) -> Result<Vec<Claim>, CaseError> {
    let mut claims = Vec::new();
    for tube in &TUBES {
        context.progress(tube.name);
        let (coarse, fine) = (errors(tube, 100)?, errors(tube, 200)?);
        let method =
            "quadratic B-splines, APIC, MUSL, viscosity 1.5 and 0.3, 200 cells, 2 particles a cell";
        let lines = Lines { context, id: tube.name, method: method.to_owned() };
        for (k, quantity) in ["pressure", "velocity"].into_iter().enumerate() {
            claims.push(lines.bounded(
                (quantity, "mean absolute error, over the largest value", ""),
                fine[k],
                tube.tolerance,
                "first order: shocks and contact are a few cells wide",
            ));
            claims.push(lines.measured(
                (&format!("{quantity}/order"), "order of that error between 100 and 200 cells", ""),
                (coarse[k] / fine[k]).log2(),
                (0.5, 1.5),
                "one in the mean norm",
            ));
        }
    }
    Ok(claims)
}
