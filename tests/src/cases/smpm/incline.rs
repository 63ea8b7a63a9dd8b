//! A block on an inclined slab: below the angle of friction it stays, above it slides by Coulomb's law.

use smpm::material::{LinearElasticParameters, LinearElasticSolid};
use smpm::{
    Body, Boundary, BoundaryKind, BulkViscosity, Config, Contact, Error, Fill, Side, Simulation,
};

use super::methods::Method;
use crate::cases::prelude::*;

const GRAVITY: f64 = 10.0;
/// Inclination (rad); its tangent is 0.546.
const ANGLE: f64 = 0.5;
const CELL: f64 = 0.1;
/// Until then the weight grows from zero, in ten periods of the slab with the block: sudden weight would make them vibrate.
const SETTLED: f64 = 0.4;
/// Duration of the observed motion after that.
const DURATION: f64 = 0.2;

/// The motion of a block under its whole weight, over that of free fall.
struct Motion {
    /// The largest displacement.
    reach: f64,
    /// The velocity gained.
    velocity: f64,
}

fn incline(method: Method, coefficient: f64) -> Result<Simulation<f64, 2>, Error> {
    let material = LinearElasticSolid::linear_elastic(LinearElasticParameters {
        density: 1.0,
        young_modulus: 1e4,
        poisson_ratio: 0.0,
    })?;
    let body = |low: [f64; 2], high: [f64; 2]| {
        Body::new(material, &Fill::of([0.5 * CELL; 2], (low, high), |_| true)?, [0.0; 2])
    };
    let bodies = vec![body([0.0, 0.0], [4.0, 0.5])?, body([1.0, 0.5], [2.0, 1.0])?];
    let ground =
        Boundary { axis: 1, position: 0.0, side: Side::Above, kind: BoundaryKind::Clamped };
    let config = Config {
        contact: Contact::Friction { coefficient },
        gravity: [GRAVITY * ANGLE.sin(), -GRAVITY * ANGLE.cos()],
        boundaries: vec![ground],
        gravity_history: vec![[0.0, 0.0], [SETTLED, 1.0]],
        viscosity: BulkViscosity { quadratic: 0.0, linear: 0.0 },
        // The fall of the slab under its own weight is energy that no state holds at the start.
        most_energy_growth: f64::MAX,
        ..method.config(CELL)
    };
    Simulation::new(config, bodies)
}

/// Velocity and place of the block along the slab: means over its particles.
fn of_block(run: &Simulation<f64, 2>) -> (f64, f64) {
    let positions = run.bodies()[1].positions();
    let place = positions.iter().map(|x| x[0]).sum::<f64>() / positions.len() as f64;
    let ledger = run.ledgers()[1];
    (ledger.momentum[0] / ledger.mass, place)
}

fn motion(method: Method, coefficient: f64) -> Result<Motion, Error> {
    let mut run = incline(method, coefficient)?;
    run.advance_to(SETTLED)?;
    let (velocity, place) = of_block(&run);
    let mut reach = 0.0_f64;
    for part in 1..=20 {
        run.advance_to(SETTLED + DURATION * f64::from(part) / 20.0)?;
        reach = reach.max((of_block(&run).1 - place).abs());
    }
    let free = GRAVITY * ANGLE.sin();
    Ok(Motion {
        reach: reach / (0.5 * free * DURATION * DURATION),
        velocity: (of_block(&run).0 - velocity) / (free * DURATION),
    })
}

/// Over all methods, a block that sticks and one that slides.
#[derive(Default)]
pub(super) struct Inclines {
    creep: Worst,
    slide: Worst,
}

impl Inclines {
    /// Runs one method.
    pub(super) fn take(&mut self, method: Method) -> CaseResult<()> {
        let (stuck, sliding) = (motion(method, 0.8)?, motion(method, 0.4)?);
        self.creep.take(stuck.reach, &method.name());
        self.slide.take(sliding.velocity - (1.0 - 0.4 / ANGLE.tan()), &method.name());
        Ok(())
    }

    /// Both claims.
    pub(super) fn claims(&self, context: &Context<'_>) -> [Claim; 2] {
        let method = "block on a slab inclined by 0.5 rad, cells of a fifth of the block";
        let lines = |worst: &Worst| context.lines("incline", worst.method(method));
        [
            lines(&self.creep)
                .of("creep", "displacement of a block that sticks, over that of free fall")
                .bounded(self.creep.value(), 2e-3)
                .because("a block that has settled vibrates by less than half a per cent, the target"),
            lines(&self.slide)
                .of(
                    "slide",
                    "velocity gained by a block that slides, over that of free fall, less 1 - mu/tan(angle)",
                )
                .bounded(self.slide.value(), 0.02)
                .because("first order in the cell: the normals at the edges of the block are oblique"),
        ]
    }
}
