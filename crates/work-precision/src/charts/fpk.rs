//! Error against cost of all methods for the same quantities, with the cheapest method for a tolerance; and the exceedance
//! probability of the damper over time.

mod question;
mod records;
mod runs;
mod table;

use fpk_sph::InitialLattice;
use random_vibration::{Linearisation, Quadrature};
use result_figures::{
    Drawing, Line, Reference, ReferencePoint, ReferencePoints, Scale, TimeSeries, Words,
};
use scenes::fpk::density::{Demand, Requested};
use scenes::machine::Machine;
use sde_integrators::{Shark, StrangOscillator};
use vibrating_systems::StrangBoucWen;

use self::question::{LEVELS, Question};
use self::records::{Scene, charts};
use self::runs::{Ladder, Setting, papers_ladder, usual};
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
    name: "fpk",
    title: "particles, grid, linearisation, Monte Carlo, guided paths, subset simulation: error against CPU time; exceedance over time",
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
        drawings.push(exceedance(context)?);
        Ok(drawings)
    })
}

/// Thresholds at which a normal distribution has exactly the probabilities of [`LEVELS`], by bisection.
fn normal_targets<const D: usize>(law: &NormalLaw<D>) -> Vec<(f64, Reference)> {
    let mut weights = [0.0; D];
    weights[0] = 1.0;
    let deviation = law.covariance[0][0].sqrt();
    let target = |(_, level): (&'static str, f64)| {
        let (mut low, mut high) = (0.0, 10.0 * deviation);
        for _ in 0..60 {
            let middle = f64::midpoint(low, high);
            let beyond = law.exceedance(&weights, middle).value > level;
            if beyond { low = middle } else { high = middle }
        }
        (low, law.exceedance(&weights, low))
    };
    LEVELS.into_iter().map(target).collect()
}

/// Thresholds of a table of references.
fn tabled_targets(
    thresholds: [f64; 3],
    reference: impl Fn(f64) -> Option<Reference>,
) -> Result<Vec<(f64, Reference)>, CaseError> {
    let target =
        |threshold| Ok((threshold, reference(threshold).ok_or("no reference at this threshold")?));
    thresholds.into_iter().map(target).collect()
}

/// The lattices of boxes.
fn boxes() -> Vec<InitialLattice<2>> {
    [21, 29, 41, 57, 81].map(InitialLattice::box_of).to_vec()
}

fn linear(context: &Context<'_>) -> Result<Scene, CaseError> {
    let problem = Problem::linear_oscillator()?;
    let Oscillator::Linear(system) = &problem.system else { return Err("another system".into()) };
    let law = linear_moments(system, &problem.law, &[6.0], 2e-3)?[0];
    let setting = Setting {
        context,
        name: "fpk-choice-linear",
        system,
        law: &problem.law,
        period: system.period(),
        integrator: &StrangOscillator,
        rule: &OF_OSCILLATOR,
    };
    let moments = [([2, 0], law.second_moment(0, 0)), ([0, 2], law.second_moment(1, 1))];
    let question = Question::moments_and_tails(6.0, 150, moments, &normal_targets(&law));
    let mut scene = Scene::new("fpk-choice-linear", "Linear oscillator, t = 6 s");
    scene.add(&question, setting.by_density(&question, &ladders_of_oscillator())?);
    scene.records.extend(setting.on_grid(&question)?);
    scene.records.extend(setting.sampled(&question)?);
    Ok(scene)
}

/// The flow-map fit on boxes, and the paper's method on its rectangles.
fn ladders_of_oscillator() -> Vec<Ladder<2>> {
    let mut ladders = usual(&boxes());
    ladders.push(papers_ladder());
    ladders
}

fn damper(context: &Context<'_>) -> Result<Scene, CaseError> {
    let problem = Problem::viscous_damper()?;
    let Oscillator::Damper(system) = &problem.system else { return Err("another system".into()) };
    let time = 6.0;
    let moment = |powers| problem.reference.moment(powers, time).ok_or("no reference moment");
    let setting = Setting {
        context,
        name: "fpk-choice-damper",
        system,
        law: &problem.law,
        period: system.period(),
        integrator: &StrangOscillator,
        rule: &OF_OSCILLATOR,
    };
    let moments = [([2, 0], moment([2, 0])?), ([0, 2], moment([0, 2])?)];
    let targets = tabled_targets([0.75, 1.25, 1.5], |t| problem.reference.exceedance(t, time))?;
    let title = "Oscillator with a nonlinear viscous damper, t = 6 s";
    let mut scene = Scene::new("fpk-choice-damper", title);
    for (question, ladders) in [
        (Question::moments_and_tails(time, 150, moments, &targets), ladders_of_oscillator()),
        (Question::surface(ExceedanceSurface::viscous_damper()?, 19), usual(&boxes())),
    ] {
        scene.add(&question, setting.by_density(&question, &ladders)?);
        scene.records.extend(setting.on_grid(&question)?);
        scene.records.extend(setting.sampled(&question)?);
    }
    Ok(scene)
}

fn hysteresis(context: &Context<'_>) -> Result<Scene, CaseError> {
    let (system, law, reference) = bouc_wen()?;
    let time = 3.6;
    let moment = |powers| reference.moment(powers, time).ok_or("no reference moment");
    let setting = Setting {
        context,
        name: "fpk-choice-bouc-wen",
        system: &system,
        law: &law,
        period: system.period(),
        integrator: &StrangBoucWen,
        rule: &OF_HYSTERESIS,
    };
    let moments = [([2, 0, 0], moment([2, 0, 0])?), ([0, 2, 0], moment([0, 2, 0])?)];
    let targets = tabled_targets([1.5, 2.0, 2.5], |t| reference.exceedance(t, time))?;
    // Up to the lattices of the claims; with the reach that the smallest probability of the surface needs.
    let near = [1.8, 1.5, 1.25, 1.0].map(|coarser: f64| BOUC_WEN_LATTICE.refined(coarser.recip()));
    let far = [0.8, 0.7, 0.6, 0.5].map(|step| InitialLattice::ball_down_to(SMALLEST, step));
    let far = far.into_iter().collect::<Result<Vec<_>, _>>()?;
    let mut scene = Scene::new("fpk-choice-bouc-wen", "Bouc-Wen hysteresis, t = 3.6 s");
    for (question, ladders) in [
        (Question::moments_and_tails(time, 180, moments, &targets), usual(&near)),
        (Question::surface(ExceedanceSurface::bouc_wen()?, 23), usual(&far)),
    ] {
        scene.add(&question, setting.by_density(&question, &ladders)?);
        scene.records.extend(setting.sampled(&question)?);
    }
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
        context,
        name: "fpk-choice-kanai-tajimi",
        system: &system,
        law: &law,
        period: system.filter().period(),
        integrator: &Shark,
        rule: &OF_SHAKEN,
    };
    let moments =
        [([2, 0, 0, 0], exact.second_moment(0, 0)), ([0, 2, 0, 0], exact.second_moment(1, 1))];
    let question = Question::moments_and_tails(time, 200, moments, &normal_targets(&exact));
    // Lattices around that of the claims.
    let lattices =
        [1.2, 1.0, 0.9].map(|coarser: f64| KANAI_TAJIMI_LATTICE.refined(coarser.recip()));
    let title = "Linear oscillator behind the Kanai-Tajimi filter, four states, t = 4 s";
    let mut scene = Scene::new("fpk-choice-kanai-tajimi", title);
    scene.add(&question, setting.by_density(&question, &usual(&lattices))?);
    scene.records.extend(setting.sampled(&question)?);
    Ok(scene)
}

/// Smallest probability on the chart over time: one decade below the claims.
const SHOWN: f64 = 1e-10;

/// Exceedance probability of every threshold of the damper over time, with references as points.
fn exceedance(context: &Context<'_>) -> Result<Drawing, CaseError> {
    let problem = Problem::viscous_damper()?;
    context.progress("damper: exceedance over time");
    let thresholds = &problem.scene.thresholds;
    let asked = Requested {
        times: problem.scene.times.list(),
        powers: vec![],
        demand: Demand::displacement(),
        thresholds: thresholds.clone(),
        kinks: Vec::new(),
        cells: true,
    };
    let run = problem.density(&problem.density_config(1.0)?, &asked)?;
    let line = |(k, threshold): (usize, &f64)| {
        let rows = run.rows.iter();
        let shown = |p: &f64| *p >= SHOWN;
        let points =
            rows.map(|row| (row.t, row.exceedances[k].cell_integrated.filter(shown))).collect();
        Line { name: format!("T = {threshold}"), points }
    };
    let table = &problem.reference;
    let reference = |threshold: f64| {
        table.times().iter().filter_map(move |&x| {
            let Reference { value: y, error } = table.exceedance(threshold, x)?;
            (y >= SHOWN).then_some(ReferencePoint { x, y, error })
        })
    };
    let drawn_by = run.words("Lines: flow-map fit, cell estimator");
    let chart = TimeSeries {
        words: Words {
            title: "Probability of exceedance P(|q| > T), one deterministic run".into(),
            subtitle: problem.scene.title.clone(),
            x_label: "time t (s)".into(),
            y_label: "P(|q| > T)".into(),
            caption: vec![
                format!("{drawn_by}; values below {SHOWN:e} are left out."),
                Machine::read().caption(),
            ],
        },
        scale: Scale::Log,
        lines: thresholds.iter().enumerate().map(line).collect(),
        bands: Vec::new(),
        references: vec![ReferencePoints {
            name: "reference".into(),
            points: thresholds.iter().flat_map(|&threshold| reference(threshold)).collect(),
        }],
    };
    Ok(Drawing::time_series("fpk-damper-exceedance", &chart)?)
}
