//! Error against cost of all methods for the same quantities: the cheapest method for a tolerance.

mod records;
mod runs;
mod surface;
mod table;

use fpk_sph::InitialLattice;
use random_vibration::{Linearisation, Quadrature};
use result_figures::{Drawing, Reference};
use sde_integrators::{Shark, StrangOscillator};
use vibrating_systems::StrangBoucWen;

use self::records::{Scene, charts};
use self::runs::{
    Setting, Target, sample, solve_linearised, solve_on_grid, solve_with_particles, usual,
};
use self::surface::SurfaceOf;
use self::table::page;
use crate::draw::ChartKind;
use crate::problems::exceedance_surface::{ExceedanceSurface, SMALLEST};
use reference_problems::context::{CaseError, Context};
use reference_problems::fpk::linear_moments::{NormalLaw, linear_moments};
use reference_problems::fpk::methods::{
    BOUC_WEN_LATTICE, KANAI_TAJIMI_LATTICE, OF_HYSTERESIS, OF_OSCILLATOR,
};
use reference_problems::fpk::oscillator::Oscillator;
use reference_problems::fpk::problem::{Problem, bouc_wen, kanai_tajimi};

pub(crate) const CHART: ChartKind = ChartKind {
    name: "fpk-choice",
    title: "particles, grid, linearisation, Monte Carlo, guided paths, subset simulation: error against CPU time",
    draw,
};

fn draw(context: &Context<'_>) -> Result<Vec<Drawing>, CaseError> {
    // One thread, so CPU time is that of one core.
    let pool = rayon::ThreadPoolBuilder::new().num_threads(1).build()?;
    pool.install(|| {
        let scenes = [linear(context)?, damper(context)?, hysteresis(context)?, shaken(context)?];
        let mut drawings = Vec::new();
        for scene in &scenes {
            drawings.extend(charts(scene)?);
        }
        drawings.push(page(&scenes)?);
        Ok(drawings)
    })
}

/// Levels of the probabilities.
const LEVELS: [(&str, f64); 3] = [("tail-3", 1e-3), ("tail-6", 1e-6), ("tail-9", 1e-9)];

/// Thresholds at which a normal distribution has exactly the probabilities of [`LEVELS`], by bisection.
fn normal_targets<const D: usize>(law: &NormalLaw<D>) -> Vec<Target> {
    let mut weights = [0.0; D];
    weights[0] = 1.0;
    let deviation = law.covariance[0][0].sqrt();
    let target = |(name, level): (&'static str, f64)| {
        let (mut low, mut high) = (0.0, 10.0 * deviation);
        for _ in 0..60 {
            let middle = f64::midpoint(low, high);
            let beyond = law.exceedance(&weights, middle).value > level;
            if beyond { low = middle } else { high = middle }
        }
        Target { name, threshold: low, reference: law.exceedance(&weights, low) }
    };
    LEVELS.into_iter().map(target).collect()
}

/// Thresholds of a table of references.
fn tabled_targets(
    thresholds: [f64; 3],
    reference: impl Fn(f64) -> Option<Reference>,
) -> Result<Vec<Target>, CaseError> {
    LEVELS
        .into_iter()
        .zip(thresholds)
        .map(|((name, _), threshold)| {
            let reference = reference(threshold).ok_or("no reference at this threshold")?;
            Ok(Target { name, threshold, reference })
        })
        .collect()
}

/// Numbers of particles along each side of a box.
const SIDES: [usize; 5] = [21, 29, 41, 57, 81];

fn linear(context: &Context<'_>) -> Result<Scene, CaseError> {
    let problem = Problem::linear_oscillator()?;
    let Oscillator::Linear(system) = &problem.system else { return Err("another system".into()) };
    let law = linear_moments(system, &problem.law, &[6.0], 2e-3)?[0];
    let setting = Setting {
        name: "fpk-choice-linear",
        title: "Linear oscillator, t = 6 s".into(),
        system,
        law: &problem.law,
        period: system.period(),
        time: 6.0,
        moments: [([2, 0], law.second_moment(0, 0)), ([0, 2], law.second_moment(1, 1))],
        targets: normal_targets(&law),
        integrator: &StrangOscillator,
        n_steps: 150,
    };
    let mut scene = setting.scene();
    let ladders = usual(&SIDES.map(InitialLattice::box_of));
    scene.records.extend(solve_with_particles(context, &setting, &ladders)?);
    scene.records.extend(solve_on_grid(context, &setting)?);
    scene.records.extend(solve_linearised(&setting, &OF_OSCILLATOR)?);
    scene.records.extend(sample(context, &setting, &OF_OSCILLATOR)?);
    Ok(scene)
}

fn damper(context: &Context<'_>) -> Result<Scene, CaseError> {
    let problem = Problem::viscous_damper()?;
    let Oscillator::Damper(system) = &problem.system else { return Err("another system".into()) };
    let time = 6.0;
    let moment = |powers| problem.reference.moment(powers, time).ok_or("no reference moment");
    let setting = Setting {
        name: "fpk-choice-damper",
        title: "Oscillator with a nonlinear viscous damper, t = 6 s".into(),
        system,
        law: &problem.law,
        period: system.period(),
        time,
        moments: [([2, 0], moment([2, 0])?), ([0, 2], moment([0, 2])?)],
        targets: tabled_targets([0.75, 1.25, 1.5], |t| problem.reference.exceedance(t, time))?,
        integrator: &StrangOscillator,
        n_steps: 150,
    };
    let mut scene = setting.scene();
    let ladders = usual(&SIDES.map(InitialLattice::box_of));
    scene.records.extend(solve_with_particles(context, &setting, &ladders)?);
    scene.records.extend(solve_on_grid(context, &setting)?);
    scene.records.extend(solve_linearised(&setting, &OF_OSCILLATOR)?);
    scene.records.extend(sample(context, &setting, &OF_OSCILLATOR)?);
    let surface = ExceedanceSurface::viscous_damper()?;
    let surface = SurfaceOf { setting: &setting, surface, steps_each: 19 };
    scene.quantities.push(surface.quantity());
    scene.records.extend(surface.with_particles(context, &ladders)?);
    scene.records.extend(surface.on_grid(context)?);
    scene.records.push(surface.linearised(context, &OF_OSCILLATOR)?);
    scene.records.extend(surface.sampled(context, &OF_OSCILLATOR)?);
    Ok(scene)
}

/// A lattice with `coarser` times its spacing.
fn coarsened<const D: usize>(lattice: InitialLattice<D>, coarser: f64) -> InitialLattice<D> {
    lattice.refined(coarser.recip())
}

fn hysteresis(context: &Context<'_>) -> Result<Scene, CaseError> {
    let (system, law, reference) = bouc_wen()?;
    let time = 3.6;
    let moment = |powers| reference.moment(powers, time).ok_or("no reference moment");
    let setting = Setting {
        name: "fpk-choice-bouc-wen",
        title: "Bouc-Wen hysteresis, t = 3.6 s".into(),
        system: &system,
        law: &law,
        period: system.period(),
        time,
        moments: [([2, 0, 0], moment([2, 0, 0])?), ([0, 2, 0], moment([0, 2, 0])?)],
        targets: tabled_targets([1.5, 2.0, 2.5], |t| reference.exceedance(t, time))?,
        integrator: &StrangBoucWen,
        n_steps: 180,
    };
    let mut scene = setting.scene();
    // Up to the lattices of the claims.
    let ladders = usual(&[1.8, 1.5, 1.25, 1.0].map(|c| coarsened(BOUC_WEN_LATTICE, c)));
    scene.records.extend(solve_with_particles(context, &setting, &ladders)?);
    scene.records.extend(solve_linearised(&setting, &OF_HYSTERESIS)?);
    scene.records.extend(sample(context, &setting, &OF_HYSTERESIS)?);
    let surface = ExceedanceSurface::bouc_wen()?;
    let surface = SurfaceOf { setting: &setting, surface, steps_each: 23 };
    scene.quantities.push(surface.quantity());
    // With the reach that the smallest probability needs.
    let far = |spacing: f64| InitialLattice::ball_down_to(SMALLEST, spacing);
    let far = [0.8, 0.7, 0.6, 0.5].map(far).into_iter().collect::<Result<Vec<_>, _>>()?;
    scene.records.extend(surface.with_particles(context, &usual(&far))?);
    scene.records.push(surface.linearised(context, &OF_HYSTERESIS)?);
    scene.records.extend(surface.sampled(context, &OF_HYSTERESIS)?);
    Ok(scene)
}

/// The system is linear, so any rule is exact.
const OF_SHAKEN: Linearisation<4> = Linearisation {
    order: [
        (0, Quadrature::Hermite),
        (1, Quadrature::Hermite),
        (2, Quadrature::Hermite),
        (3, Quadrature::Hermite),
    ],
    step: 0.02,
};

fn shaken(context: &Context<'_>) -> Result<Scene, CaseError> {
    let (system, law) = kanai_tajimi()?;
    let time = 4.0;
    // The window has a kink at t = 2.
    let exact = linear_moments(&system, &law, &[2.0, time], 2e-3)?[1];
    let setting = Setting {
        name: "fpk-choice-kanai-tajimi",
        title: "Linear oscillator behind the Kanai-Tajimi filter, four states, t = 4 s".into(),
        system: &system,
        law: &law,
        period: system.filter().period(),
        time,
        moments: [
            ([2, 0, 0, 0], exact.second_moment(0, 0)),
            ([0, 2, 0, 0], exact.second_moment(1, 1)),
        ],
        targets: normal_targets(&exact),
        integrator: &Shark,
        n_steps: 200,
    };
    let mut scene = setting.scene();
    // Lattices around that of the claims.
    let ladders = usual(&[1.2, 1.0, 0.9].map(|c| coarsened(KANAI_TAJIMI_LATTICE, c)));
    scene.records.extend(solve_with_particles(context, &setting, &ladders)?);
    scene.records.extend(solve_linearised(&setting, &OF_SHAKEN)?);
    scene.records.extend(sample(context, &setting, &OF_SHAKEN)?);
    Ok(scene)
}
