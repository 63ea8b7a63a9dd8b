//! A square of material points that stretches, shears and rotates: smpm and hand-written.

use smpm::material::{Model, StiffenedGasParameters};
use smpm::{BulkViscosity, Config, Fill, Simulation};

use crate::case::{Failure, Run, State};

pub(crate) const GAS: StiffenedGasParameters<f64> =
    StiffenedGasParameters { density: 1.0, exponent: 4.4, stiffness: 30.0, pressure: 1.0 };

/// Quadratic coefficient of the bulk viscosity.
pub(crate) const QUADRATIC: f64 = 1.5;
pub(crate) const LINEAR: f64 = 0.06;

/// Largest growth factor of the energy over the run.
pub(crate) const MOST_GROWTH: f64 = 1.2;

pub(crate) const COURANT_NUMBER: f64 = 0.4;

/// Initial particles.
#[derive(Debug)]
pub(crate) struct Body {
    pub(crate) positions: Vec<[f64; 2]>,
    pub(crate) velocities: Vec<[f64; 2]>,
    /// Volume of one particle.
    pub(crate) volume: f64,
    pub(crate) cell: f64,
}

fn velocity(&[x, y]: &[f64; 2]) -> [f64; 2] {
    let (x, y) = (3.0 * (x - 0.5), 3.0 * (y - 0.5));
    [0.1 * (1.0 + x.sin() - y), 0.1 * (x - 0.5 * y.sin())]
}

/// Four particles to a cell.
fn fill(edge: u32) -> Result<(Fill<2>, f64), smpm::Error> {
    let cell = 2.0 / f64::from(edge);
    Ok((Fill::of([0.5 * cell; 2], ([0.0; 2], [1.0; 2]), |_| true)?, cell))
}

/// The particles of a square.
pub(crate) fn body(edge: u32) -> Result<Body, smpm::Error> {
    let (Fill { positions, spacing }, cell) = fill(edge)?;
    let velocities = positions.iter().map(velocity).collect();
    Ok(Body { positions, velocities, volume: spacing[0] * spacing[1], cell })
}

/// The library's run of a square.
pub(crate) fn simulation(
    edge: u32,
    material: impl Into<Model<f64>>,
) -> Result<Simulation<f64, 2>, smpm::Error> {
    let (fill, cell) = fill(edge)?;
    let mut body = smpm::Body::new(material, &fill, [0.0; 2])?;
    body.set_velocities(velocity)?;
    let viscosity = BulkViscosity { quadratic: QUADRATIC, linear: LINEAR };
    let config = Config {
        viscosity,
        courant_number: COURANT_NUMBER,
        most_energy_growth: MOST_GROWTH,
        ..Config::with_cell(cell)
    };
    Simulation::new(config, vec![body])
}

impl Run for Simulation<f64, 2> {
    fn step(&mut self) -> Result<(), Failure> {
        let _ = Self::step(self)?;
        Ok(())
    }

    fn state(&self) -> State {
        let body = &self.bodies()[0];
        let of = |f: &dyn Fn(usize) -> f64| (0..body.n_particles()).map(f).collect();
        vec![
            ("x", of(&|p| body.position(p)[0])),
            ("y", of(&|p| body.position(p)[1])),
            ("velocity x", of(&|p| body.velocity(p)[0])),
            ("velocity y", of(&|p| body.velocity(p)[1])),
            ("stress xx", of(&|p| body.stress(p).0[0])),
            ("stress yy", of(&|p| body.stress(p).0[1])),
            ("stress xy", of(&|p| body.stress(p).0[3])),
            ("energy", of(&|p| body.observe(p).energy)),
        ]
    }

    fn n_elements(&self) -> usize {
        self.bodies()[0].n_particles()
    }
}
