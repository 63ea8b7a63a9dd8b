//! A plane shock: its state and the variance of its pressure, exact by the Hugoniot.

use reference_problems::smpm::problems::{Problem, experiment};
use scenes::smpm::scene::{ShapeScene, SmpmScene, TimeScene, TransferScene, ViscosityScene};
use smpm::uncertainty::{FrozenForm, Study};

use crate::cases::prelude::*;

pub(crate) const CASE: Case = Case {
    id: "smpm/plate-impact",
    title: "A plane shock in steel: pressure, density, front, and the variance of its pressure",
    source: "Hugoniot u_s = C + S_1 u_p, exact: p = rho_0 u_s u_p; Meyers 1994, chapter 4",
    cost: Profile::Quick,
    run: Together(run),
};

/// Particle velocities: half those of symmetric impacts at 0.2 to 4 km/s (cm/us).
const PARTICLE_VELOCITIES: [f64; 6] = [0.01, 0.025, 0.05, 0.1, 0.15, 0.2];
const DENSITY: f64 = 7.83;
const SOUND_SPEED: f64 = 0.4569;
const SLOPE: f64 = 1.49;

/// The ratio of the frozen to the true derivative by `S_1` where it was computed by hand: at fixed volume and energy,
/// `dp/dS_1 = 2 p_H mu/D (1 - (gamma_0 + a mu) mu/(2 (1 + mu)))` with `D = 1 - (S_1 - 1) mu`, over `rho_0 u_p^2`.
fn frozen_over_true(particle_velocity: f64) -> f64 {
    let (shock, pressure) = hugoniot(particle_velocity);
    let mu = shock / (shock - particle_velocity) - 1.0;
    let gruneisen = 2.17 + 0.46 * mu;
    let by_slope = 2.0 * pressure * mu / (1.0 - (SLOPE - 1.0) * mu);
    by_slope * (1.0 - 0.5 * gruneisen * mu / (1.0 + mu))
        / (DENSITY * particle_velocity * particle_velocity)
}

/// Speed of the front in the material at rest and the pressure behind it.
fn hugoniot(particle_velocity: f64) -> (f64, f64) {
    let shock = SOUND_SPEED + SLOPE * particle_velocity;
    (shock, DENSITY * shock * particle_velocity)
}

/// The best scheme for a shock, and the default.
#[derive(Debug, Clone, Copy)]
enum Scheme {
    Best,
    Default,
}

fn scene(scheme: Scheme, particle_velocity: f64) -> CaseResult<SmpmScene> {
    let mut scene = Problem::PlateImpact.scene()?;
    scene.bodies[0].velocity = vec![-particle_velocity];
    if let Scheme::Default = scheme {
        scene.scheme.shape = Some(ShapeScene::QuadraticBSpline);
        scene.scheme.transfer = Some(TransferScene::Flip {});
        scene.scheme.viscosity = Some(ViscosityScene { quadratic: 1.5, linear: 0.06 });
    }
    // The front is between five and six centimetres of the eight, in the material.
    let (shock, _) = hugoniot(particle_velocity);
    let (from, to) = (5.0 / shock, 6.0 / shock);
    scene.times = vec![TimeScene::Mean([from, to]), TimeScene::At(to)];
    Ok(scene)
}

/// Up to this particle velocity, an impact at 2 km/s, the default is fit for shocks (cm/us).
const LAST_OF_DEFAULT: f64 = 0.1;

fn run(context: &Context<'_>) -> CaseResult {
    let mut best: [Worst; 5] = std::array::from_fn(|_| Worst::of_errors());
    let mut default: [[Worst; 2]; 2] =
        std::array::from_fn(|_| std::array::from_fn(|_| Worst::of_errors()));
    for particle_velocity in PARTICLE_VELOCITIES {
        let place = format!("{} km/s", 20.0 * particle_velocity);
        context.progress(&place);
        for (worst, error) in best.iter_mut().zip(errors_of_best(particle_velocity)?) {
            worst.take(error, &place);
        }
        let of_speed = &mut default[usize::from(particle_velocity > LAST_OF_DEFAULT)];
        for (worst, error) in of_speed.iter_mut().zip(errors_of_default(particle_velocity)?) {
            worst.take(error, &place);
        }
    }
    let [slow, fast] = &default;
    let mut claims = claims_of_best(context, &best).to_vec();
    claims.extend(claims_of_default(context, "default", slow, [0.012, 0.08]));
    claims.extend(claims_of_default(context, "default/above-2-km-s", fast, [0.035, 0.2]));
    Ok(claims)
}

const BEST: &str =
    "cubic B-splines, APIC, MUSL, viscosity 1.5 and 1, h = 0.5 mm, 2 particles a cell";
const DEFAULT: &str =
    "quadratic B-splines, FLIP, MUSL, viscosity 1.5 and 0.06, h = 0.5 mm, 2 particles a cell";

/// Relative errors of pressure and density, the post-shock oscillation, relative errors of `dp/dS_1` and of the ratio of the frozen one.
fn errors_of_best(particle_velocity: f64) -> CaseResult<[f64; 5]> {
    let scene = scene(Scheme::Best, particle_velocity)?;
    let (shock, pressure) = hugoniot(particle_velocity);
    let experiment = experiment::<1>(&scene)?;
    let study = Study::new(&experiment, scene.inputs()?, scene.plan::<1>()?)?;
    let density = DENSITY * shock / (shock - particle_velocity);
    let deviation = 0.05 * SLOPE;
    let exact = DENSITY * particle_velocity * particle_velocity;
    let slope = study.propagated()?.moments[0].gradient[0].abs() / deviation;
    let frozen = study.frozen(FrozenForm::Corrected)?;
    let frozen = frozen[0].as_ref().ok_or("no frozen moments")?.gradient[0].abs();
    let frozen = frozen / deviation / exact;
    Ok([
        study.centre()[0] / pressure - 1.0,
        study.centre()[2] / density - 1.0,
        ripple(&scene, pressure)?,
        slope / exact - 1.0,
        frozen / frozen_over_true(particle_velocity) - 1.0,
    ])
}

fn claims_of_best(context: &Context<'_>, worst: &[Worst; 5]) -> [Claim; 5] {
    let of = |worst: &Worst, name: &str, quantity: &str| {
        context.lines("", worst.method(BEST)).of(name, quantity)
    };
    let [pressure, density, ripple, slope, frozen] = worst;
    [
        of(pressure, "pressure", "relative error of p")
            .bounded(pressure.value(), 3e-3)
            .because("mean over 50 cells and the time in which the front runs ten: the remainder of the post-shock oscillation"),
        of(density, "density", "relative error of rho")
            .bounded(density.value(), 3e-3)
            .because("as the pressure"),
        of(ripple, "ripple", "standard deviation of p behind the front, over p")
            .bounded(ripple.value(), 0.015)
            .because("the ringing that the linear viscosity leaves"),
        of(slope, "slope", "relative error of dp/dS_1")
            .bounded(slope.value(), 0.05)
            .because("mean over the window; at 0.5 mm the smeared front is still felt in it, most where the shock is weak"),
        of(frozen, "frozen-over-true", "relative error of frozen dp/dS_1 over the true one")
            .bounded(frozen.value(), 0.03)
            .because("the same integral over the window, at the run's volume and energy: a frozen code is wrong by this ratio of 2.01 to 2.28"),
    ]
}

/// Relative errors of the pressure and of `dp/dS_1`.
fn errors_of_default(particle_velocity: f64) -> CaseResult<[f64; 2]> {
    let scene = scene(Scheme::Default, particle_velocity)?;
    let (_, pressure) = hugoniot(particle_velocity);
    let experiment = experiment::<1>(&scene)?;
    let study = Study::new(&experiment, scene.inputs()?, scene.plan::<1>()?)?;
    let slope = study.propagated()?.moments[0].gradient[0].abs();
    let exact = DENSITY * particle_velocity * particle_velocity;
    Ok([study.centre()[0] / pressure - 1.0, slope / (0.05 * SLOPE) / exact - 1.0])
}

fn claims_of_default(
    context: &Context<'_>,
    id: &str,
    [pressure, slope]: &[Worst; 2],
    [of_pressure, of_slope]: [f64; 2],
) -> [Claim; 2] {
    let lines = |worst: &Worst| context.lines(id, worst.method(DEFAULT));
    [
        lines(pressure)
            .of("pressure", "relative error of p")
            .bounded(pressure.value(), of_pressure)
            .because("the mean of a post-shock oscillation of up to 15 %"),
        lines(slope)
            .of("slope", "relative error of dp/dS_1")
            .bounded(slope.value(), of_slope)
            .because("what the ringing of FLIP leaves of the mean over 50 cells and the time in which the front runs ten"),
    ]
}

/// The spread of the pressure over single particles behind the front, over the exact one.
fn ripple(scene: &SmpmScene, pressure: f64) -> CaseResult<f64> {
    use smpm::uncertainty::Experiment;
    let experiment = experiment::<1>(scene)?;
    let centre = scene.inputs()?.centre();
    let mut run = Experiment::simulation::<f64>(&experiment, &centre)?;
    let starts: Vec<f64> = run.bodies()[0].positions().iter().map(|x| x[0]).collect();
    let TimeScene::At(time) = scene.times[1] else { return Err("no instant".into()) };
    run.advance_to(time)?;
    let body = &run.bodies()[0];
    let wake: Vec<f64> = (0..starts.len())
        .filter(|&p| (0.5..3.0).contains(&starts[p]))
        .map(|p| body.pressure(p) / pressure)
        .collect();
    let n = wake.len() as f64;
    let mean = wake.iter().sum::<f64>() / n;
    Ok((wake.iter().map(|p| (p - mean).powi(2)).sum::<f64>() / n).sqrt())
}
