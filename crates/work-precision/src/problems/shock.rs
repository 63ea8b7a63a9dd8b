//! Schemes of a step by name, and a plane shock in steel under them: a plate runs into a wall.
//!
//! The state behind the shock is exact by `u_s = C + S_1 u_p`.

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
pub(crate) const SHAPES: [(ShapeScene, &str); 2] =
    [(ShapeScene::QuadraticBSpline, "quadratic"), (ShapeScene::CubicBSpline, "cubic")];

/// FLIP.
pub(crate) const FLIP: TransferScene = TransferScene::Flip {};

/// A scheme: the bulk viscosity 1.5 and a linear one, the usual Courant number.
pub(crate) fn scheme(shape: ShapeScene, transfer: TransferScene, linear: f64) -> SchemeScene {
    SchemeScene {
        shape: Some(shape),
        transfer: Some(transfer),
        viscosity: Some(ViscosityScene { quadratic: 1.5, linear }),
        courant_number: None,
        damping: None,
    }
}

/// The velocity of the plate, half that of an impact at 2 km/s on its equal (cm/us).
const PARTICLE_VELOCITY: f64 = 0.1;

/// Density, sound speed and slope of the Hugoniot of the library's steel.
const STEEL: [f64; 3] = [7.83, 0.4569, 1.49];

/// The speed of the front in the material (cm/us).
fn front() -> f64 {
    let [_, sound_speed, slope] = STEEL;
    sound_speed + slope * PARTICLE_VELOCITY
}

/// The pressure behind it (Mbar).
fn exact_pressure() -> f64 {
    STEEL[0] * front() * PARTICLE_VELOCITY
}

/// Its derivative by the slope of the Hugoniot (Mbar).
fn pressure_by_slope() -> f64 {
    STEEL[0] * PARTICLE_VELOCITY.powi(2)
}

/// The variance of that pressure, of which other parameters have none.
pub(crate) fn variance(coefficient_of_variation: f64) -> f64 {
    (pressure_by_slope() * coefficient_of_variation * STEEL[2]).powi(2)
}

/// The scene: responses are the mean over a window in space and time, and that over space at its end.
pub(crate) fn scene(scheme: &SchemeScene, cell: f64) -> Result<SmpmScene, CaseError> {
    let mut scene = Problem::PlateImpact.scene()?;
    scene.bodies[0].velocity = vec![-PARTICLE_VELOCITY];
    scene.scheme = scheme.clone();
    scene.grid.cell = cell;
    scene.quantities = vec!["pressure".to_owned()];
    // The front is between five and six centimetres of the eight, in the material.
    let (from, to) = (5.0 / front(), 6.0 / front());
    scene.times = vec![TimeScene::Mean([from, to]), TimeScene::At(to)];
    Ok(scene)
}

/// What a run shows of the shock, relative to the exact pressure.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Behind {
    /// The mean pressure over 2.5 cm and the time in which the front runs 1 cm, less the exact one.
    pub(crate) pressure: f64,
    /// The deviation of the pressure over the particles of these 2.5 cm.
    pub(crate) ripple: f64,
}

/// Runs a scene to the end of its window.
pub(crate) fn behind(scene: &SmpmScene, work: &mut Work) -> Result<Behind, CaseError> {
    let experiment = experiment::<1>(scene)?;
    let mut run = at_centre(&experiment, scene)?;
    let is_wake = |x: &[f64; 1]| (0.5..3.0).contains(&x[0]);
    let starts = run.bodies()[0].positions();
    let wake: Vec<usize> = (0..starts.len()).filter(|&p| is_wake(&starts[p])).collect();
    let outcome = run.record(&scene.plan::<1>()?);
    work.spend(run.n_steps())?;
    let mean = outcome?.values[0] / exact_pressure();
    let plate = &run.bodies()[0];
    let values: Vec<f64> = wake.iter().map(|&p| plate.pressure(p) / exact_pressure()).collect();
    let n = values.len() as f64;
    let middle = values.iter().sum::<f64>() / n;
    let square = values.iter().map(|p| (p - middle).powi(2)).sum::<f64>() / n;
    Ok(Behind { pressure: mean - 1.0, ripple: square.sqrt() })
}

/// `dp/dS_1`, carried by jets, over the exact one: over the window, and at its end.
pub(crate) fn slopes(scene: &SmpmScene) -> Result<[f64; 2], CaseError> {
    let experiment = experiment::<1>(scene)?;
    let study = Study::new(&experiment, scene.inputs()?, scene.plan::<1>()?)?;
    let deviation = scene.random[0].coefficient_of_variation * STEEL[2];
    let ratio = |moments: &Series| moments.gradient[0] / (deviation * pressure_by_slope());
    let moments = study.propagated()?.moments;
    Ok([ratio(&moments[0]), ratio(&moments[1])])
}

/// A scene at the centre of its parameters.
pub(crate) fn at_centre<const D: usize>(
    experiment: &SceneExperiment<D>,
    scene: &SmpmScene,
) -> Result<Simulation<f64, D>, CaseError> {
    let centre = scene.inputs()?.centre();
    Ok(Experiment::simulation(experiment, &centre)?)
}
