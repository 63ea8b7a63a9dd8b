//! Schemes of a step by name, and what two problems show of them: a plane shock in steel, an explosion.

use scenes::smpm::experiment::SceneExperiment;
use scenes::smpm::scene::{
    SchemeScene, ShapeScene, SmpmScene, TimeScene, TransferScene, ViscosityScene,
};
use smpm::Simulation;
use smpm::uncertainty::{Experiment, Series, Study};

use super::work::Work;
use reference_problems::context::CaseError;
use reference_problems::smpm::problems::{Problem, experiment};

/// Shape functions with their names.
pub const SHAPES: [(ShapeScene, &str); 2] =
    [(ShapeScene::QuadraticBSpline, "quadratic"), (ShapeScene::CubicBSpline, "cubic")];

/// FLIP.
pub const FLIP: TransferScene = TransferScene::Flip {};

/// A scheme: the bulk viscosity 1.5 and a linear one, the usual Courant number.
#[must_use]
pub fn scheme(shape: ShapeScene, transfer: TransferScene, linear: f64) -> SchemeScene {
    SchemeScene {
        shape: Some(shape),
        transfer: Some(transfer),
        viscosity: Some(ViscosityScene { quadratic: 1.5, linear }),
        courant_number: None,
    }
}

/// A plane shock in steel, whose state is exact by `u_s = C + S_1 u_p`: a plate runs into a wall.
#[derive(Debug, Clone, Copy)]
pub struct Shock {
    /// The velocity of the plate, half that of a symmetric impact (cm/us).
    pub particle_velocity: f64,
}

/// What a run shows of a shock, relative to the exact pressure.
#[derive(Debug, Clone, Copy)]
pub struct Behind {
    /// The mean pressure over 2.5 cm and the time in which the front runs 1 cm, less the exact one.
    pub pressure: f64,
    /// The deviation of the pressure over the particles of these 2.5 cm.
    pub ripple: f64,
    /// The change of the energy, over that of the start.
    pub energy: f64,
}

impl Shock {
    /// An impact at 2 km/s on its equal.
    pub const USUAL: Self = Self { particle_velocity: 0.1 };

    /// Density, sound speed and slope of the Hugoniot of the library's steel.
    const STEEL: [f64; 3] = [7.83, 0.4569, 1.49];

    /// The speed of the front in the material (cm/us).
    fn front(self) -> f64 {
        let [_, sound_speed, slope] = Self::STEEL;
        sound_speed + slope * self.particle_velocity
    }

    /// The pressure behind it (Mbar).
    #[must_use]
    pub fn pressure(self) -> f64 {
        Self::STEEL[0] * self.front() * self.particle_velocity
    }

    /// Its derivative by the slope of the Hugoniot (Mbar).
    #[must_use]
    pub fn pressure_by_slope(self) -> f64 {
        Self::STEEL[0] * self.particle_velocity.powi(2)
    }

    /// The variance of that pressure, of which other parameters have none.
    #[must_use]
    pub fn variance(self, coefficient_of_variation: f64) -> f64 {
        (self.pressure_by_slope() * coefficient_of_variation * Self::STEEL[2]).powi(2)
    }

    /// The scene: responses are the mean over a window in space and time, and that over space at its end.
    ///
    /// # Errors
    /// Those of a scene.
    pub fn scene(self, scheme: &SchemeScene, cell: f64) -> Result<SmpmScene, CaseError> {
        let mut scene = Problem::PlateImpact.scene()?;
        scene.bodies[0].velocity = vec![-self.particle_velocity];
        scene.scheme = scheme.clone();
        scene.grid.cell = cell;
        scene.quantities = vec!["pressure".to_owned()];
        // The front is between five and six centimetres of the eight, in the material.
        let (from, to) = (5.0 / self.front(), 6.0 / self.front());
        scene.times = vec![TimeScene::Mean([from, to]), TimeScene::At(to)];
        Ok(scene)
    }

    /// Runs a scene to the end of its window.
    ///
    /// # Errors
    /// Those of a scene and of a run.
    pub fn behind(self, scene: &SmpmScene, work: &mut Work) -> Result<Behind, CaseError> {
        let experiment = experiment::<1>(scene)?;
        let mut run = at_centre(&experiment, scene)?;
        let is_wake = |x: &[f64; 1]| (0.5..3.0).contains(&x[0]);
        let starts = run.bodies()[0].positions();
        let wake: Vec<usize> = (0..starts.len()).filter(|&p| is_wake(&starts[p])).collect();
        let before = energy(&run);
        let outcome = run.record(&scene.plan::<1>()?);
        work.spend(run.n_steps())?;
        let mean = outcome?.values[0] / self.pressure();
        let plate = &run.bodies()[0];
        let values: Vec<f64> = wake.iter().map(|&p| plate.pressure(p) / self.pressure()).collect();
        let n = values.len() as f64;
        let middle = values.iter().sum::<f64>() / n;
        let square = values.iter().map(|p| (p - middle).powi(2)).sum::<f64>() / n;
        let energy = energy(&run) / before - 1.0;
        Ok(Behind { pressure: mean - 1.0, ripple: square.sqrt(), energy })
    }

    /// `dp/dS_1`, carried by jets, over the exact one: over the window, and at its end.
    ///
    /// # Errors
    /// Those of a scene and of a run.
    pub fn slopes(self, scene: &SmpmScene) -> Result<[f64; 2], CaseError> {
        let experiment = experiment::<1>(scene)?;
        let study = Study::new(&experiment, scene.inputs()?, scene.plan::<1>()?)?;
        let deviation = scene.random[0].coefficient_of_variation * Self::STEEL[2];
        let ratio = |moments: &Series| moments.gradient[0] / (deviation * self.pressure_by_slope());
        let moments = study.propagated()?.moments;
        Ok([ratio(&moments[0]), ratio(&moments[1])])
    }
}

/// A scene at the centre of its parameters.
///
/// # Errors
/// Those of a scene.
pub fn at_centre<const D: usize>(
    experiment: &SceneExperiment<D>,
    scene: &SmpmScene,
) -> Result<Simulation<f64, D>, CaseError> {
    let centre = scene.inputs()?.centre();
    Ok(Experiment::simulation(experiment, &centre)?)
}

/// Kinetic and internal energy.
#[must_use]
pub fn energy<const D: usize>(run: &Simulation<f64, D>) -> f64 {
    let ledger = run.ledger();
    ledger.kinetic + ledger.internal
}

/// The contact explosion of a thin plate under a scheme, up to a time.
#[derive(Debug)]
pub struct Explosion {
    experiment: SceneExperiment<2>,
    scene: SmpmScene,
}

impl Explosion {
    /// The scene with another scheme and cell (cm).
    ///
    /// # Errors
    /// Those of a scene.
    pub fn new(scheme: &SchemeScene, cell: f64, per_cell: u32) -> Result<Self, CaseError> {
        let mut scene = Problem::ContactExplosion.scene()?;
        scene.scheme = scheme.clone();
        scene.grid.cell = cell;
        scene.grid.particles_per_cell = per_cell;
        let experiment = experiment::<2>(&scene)?;
        Ok(Self { experiment, scene })
    }

    /// The energy at a time (us) over that of the start, less one.
    ///
    /// # Errors
    /// Those of a run.
    pub fn energy_change(&self, time: f64, work: &mut Work) -> Result<f64, CaseError> {
        let mut run = at_centre(&self.experiment, &self.scene)?;
        let before = energy(&run);
        let outcome = run.advance_to(time);
        work.spend(run.n_steps())?;
        outcome?;
        Ok(energy(&run) / before - 1.0)
    }
}
