//! Error against CPU time for four problems, strong and weak; and maps of stability.

mod maps;

use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::SeedableRng;
use rand_distr::{Distribution, StandardNormal};
use result_figures::{
    Drawing, Measure, Method as Series, Reading, Run, RunOutcome, Words, WorkPrecision,
};
use scenes::clock::CpuClock;
use scenes::machine::Machine;
use sde_integrators::{
    DiagonalNoise, Increment, Noise, Sra3, Sriw1, StateSpace, StepError, StrangOscillator,
};

use super::cost::{median_and_half_range, run};
use crate::draw::ChartKind;
use reference_problems::context::{CaseError, Context, Profile};
use reference_problems::sde::damper::viscous_damper_at_rest;
use reference_problems::sde::methods::{Method, additive, diagonal, follow, second_order};
use reference_problems::sde::orders::{Errors, Failure, Outcome, Study, Target, attempt};
use reference_problems::sde::problems::{Geometric, Populations, Sine};
use reference_problems::sde::reference::Diffrax;

pub(crate) const CHART: ChartKind = ChartKind {
    name: "sde",
    title: "methods of sde-integrators: strong and weak error against CPU time on four problems, maps of stability",
    draw,
};

fn draw(context: &Context<'_>) -> Result<Vec<Drawing>, CaseError> {
    let mut drawings = sine(context)?;
    drawings.extend(damper(context)?);
    drawings.extend(geometric(context)?);
    drawings.extend(populations(context)?);
    drawings.push(maps::mean_square()?);
    drawings.push(maps::oscillator()?);
    Ok(drawings)
}

/// A scalar Euler loop over one path: from normals, number and length of steps to a state.
type Rival<'a> = dyn Fn(&mut dyn FnMut() -> f64, usize, f64) -> f64 + 'a;

/// A problem and its resolution.
struct Problem<'a, S, const D: usize, const M: usize> {
    name: &'a str,
    equation: &'a str,
    system: &'a S,
    start: [f64; D],
    strong: Study,
    weak: Study,
    observable: (&'a str, fn(&[f64; D]) -> f64),
    rival: Option<&'a Rival<'a>>,
    /// Name of the problem in the record of diffrax.
    diffrax: Option<&'a str>,
}

fn paths(context: &Context<'_>, default: u64) -> u64 {
    match context.profile {
        Profile::Quick => default / 8,
        Profile::Default => default,
        Profile::Full => 8 * default,
    }
}

fn sine(context: &Context<'_>) -> Result<Vec<Drawing>, CaseError> {
    let start = [1.0];
    let reference =
        |dt: f64, increments: &[Increment<1>]| Ok(follow(&Sine, &Sra3, start, dt, increments)?);
    let rival = |normal: &mut dyn FnMut() -> f64, n: usize, dt: f64| {
        let mut x = 1.0_f64;
        for _ in 0..n {
            x += dt * (-(3.0 * x).sin() - 0.2 * x) + 0.8 * dt.sqrt() * normal();
        }
        x
    };
    let study = Study {
        n_paths: paths(context, 8192),
        seed: 61,
        end: 1.0,
        coarsest: 4,
        n_levels: 7,
        refinements: 4,
    };
    let problem = Problem {
        name: "sde-sine",
        equation: "dX = (-sin 3X - 0.2 X) dt + 0.8 dW from 1, t = 1; reference SRA3 at 1/16 (weak: 1/8) of the finest step",
        system: &Sine,
        start,
        strong: study,
        weak: Study {
            n_paths: paths(context, 65_536),
            n_levels: 5,
            refinements: 3,
            seed: 62,
            ..study
        },
        observable: ("E X^2", |x| x[0] * x[0]),
        rival: Some(&rival),
        diffrax: Some("sine"),
    };
    drawings(context, &problem, &additive(), &reference)
}

fn damper(context: &Context<'_>) -> Result<Vec<Drawing>, CaseError> {
    let system = StateSpace(viscous_damper_at_rest()?);
    let start = [0.0; 2];
    let reference = |dt: f64, increments: &[Increment<1>]| {
        Ok(follow(&system, &StrangOscillator, start, dt, increments)?)
    };
    let rival = |normal: &mut dyn FnMut() -> f64, n: usize, dt: f64| {
        let omega = std::f64::consts::PI;
        let (mut q, mut v, kick) = (0.0_f64, 0.0_f64, (2.0 * 0.2 * dt).sqrt());
        for _ in 0..n {
            let damping = 0.02 * omega * v + 0.25 * v.signum() * v.abs().powf(0.35);
            (q, v) = (q + dt * v, v - dt * (damping + omega * omega * q) + kick * normal());
        }
        q
    };
    // The implicit rule is omitted: the damper is not Lipschitz at rest, and Newton's method does not converge there.
    let methods: Vec<_> =
        second_order().into_iter().filter(|method| method.id != "trapezoidal").collect();
    let study = Study {
        n_paths: paths(context, 4096),
        seed: 63,
        end: 10.0,
        coarsest: 128,
        n_levels: 5,
        refinements: 1,
    };
    let problem = Problem {
        name: "sde-damper",
        equation: "oscillator with viscous damper (Canor & Denoël 2013, eq 26, a = 1), from rest, t = 10 s; reference Strang at h = 0.0024",
        system: &system,
        start,
        strong: study,
        weak: Study { n_paths: paths(context, 16_384), seed: 64, ..study },
        observable: ("E q^2", |x| x[0] * x[0]),
        rival: Some(&rival),
        diffrax: Some("damper"),
    };
    drawings(context, &problem, &methods, &reference)
}

fn geometric(context: &Context<'_>) -> Result<Vec<Drawing>, CaseError> {
    let geometric = Geometric { drift: 0.5, intensity: 0.6 };
    let exact = |_: f64, increments: &[Increment<1>]| {
        let w: f64 = increments.iter().map(|dw| dw.brownian[0]).sum();
        Ok([geometric.factor(1.0, w)])
    };
    let rival = |normal: &mut dyn FnMut() -> f64, n: usize, dt: f64| {
        (0..n).fold(1.0, |x, _| x + 0.5 * x * dt + 0.6 * x * dt.sqrt() * normal())
    };
    let study = Study {
        n_paths: paths(context, 8192),
        seed: 65,
        end: 1.0,
        coarsest: 4,
        n_levels: 7,
        refinements: 0,
    };
    let problem = Problem {
        name: "sde-geometric",
        equation: "dX = 0.5 X dt + 0.6 X dB from 1, t = 1; closed form",
        system: &DiagonalNoise(geometric),
        start: [1.0],
        strong: study,
        weak: Study { n_paths: paths(context, 262_144), n_levels: 5, seed: 66, ..study },
        observable: ("E X^2", |x| x[0] * x[0]),
        rival: Some(&rival),
        diffrax: None,
    };
    drawings(context, &problem, &diagonal(), &exact)
}

fn populations(context: &Context<'_>) -> Result<Vec<Drawing>, CaseError> {
    let system = DiagonalNoise(Populations { intensity: [0.9, 0.7] });
    let start = [1.2, 0.8];
    let reference =
        |dt: f64, increments: &[Increment<2>]| Ok(follow(&system, &Sriw1, start, dt, increments)?);
    let study = Study {
        n_paths: paths(context, 4096),
        seed: 67,
        end: 1.0,
        coarsest: 8,
        n_levels: 6,
        refinements: 3,
    };
    let problem = Problem {
        name: "sde-populations",
        equation: "two populations with noise 0.9 X_1, 0.7 X_2 from (1.2, 0.8), t = 1; reference SRIW1 at 1/8 of the finest step",
        system: &system,
        start,
        strong: study,
        weak: Study { n_paths: paths(context, 32_768), n_levels: 5, seed: 68, ..study },
        observable: ("E X_1", |x| x[0]),
        rival: None,
        diffrax: None,
    };
    drawings(context, &problem, &diagonal(), &reference)
}

fn drawings<S, const D: usize, const M: usize>(
    context: &Context<'_>,
    problem: &Problem<'_, S, D, M>,
    methods: &[Method<S, D, M>],
    target: &Target<'_, D, M>,
) -> Result<Vec<Drawing>, CaseError>
where
    S: Sync,
{
    let pair = (problem.system, problem.start);
    let (what, observable) = problem.observable;
    context.progress(&format!("{}: strong errors", problem.name));
    let strong = attempt(&problem.strong, pair, methods, target, &[])?;
    context.progress(&format!("{}: weak errors", problem.name));
    let weak = attempt(&problem.weak, pair, methods, target, &[observable])?;
    context.progress(&format!("{}: CPU time", problem.name));
    // Both studies have the same coarsest level, so the times of the longer one serve both.
    let longer =
        if problem.weak.n_levels > problem.strong.n_levels { problem.weak } else { problem.strong };
    let times: Vec<Vec<Timing>> =
        methods.iter().map(|method| timings(problem, method, &longer)).collect::<Result<_, _>>()?;
    let rival_times = problem.rival.map(|rival| rival_timings(rival, &longer)).transpose()?;
    let picture = |kind: &str, y_label: &str, study: &Study, outcomes: &[Outcome]| {
        let errors = |outcome: &'_ Outcome| -> Errors {
            if kind == "strong" { outcome.strong.clone() } else { outcome.weak[0].clone() }
        };
        let mut series = Vec::new();
        for ((method, outcome), times) in methods.iter().zip(outcomes).zip(&times) {
            series.push(Series {
                name: method.name.into(),
                runs: runs(&errors(outcome), &failures(outcome, study), times),
            });
        }
        if let Some(times) = &rival_times {
            let runs = runs(&errors(&outcomes[0]), &failures(&outcomes[0], study), times);
            series.push(Series { name: "rival: scalar Euler loop".into(), runs });
        }
        // Recorded results of diffrax are strong errors only.
        let recorded = problem.diffrax.filter(|_| kind == "strong");
        let diffrax = Diffrax::read()?;
        if let Some(name) = recorded {
            series.extend(diffrax_series(&diffrax, name));
        }
        let caption = caption(study, problem.rival.is_some(), recorded.map(|_| &diffrax));
        let words = Words {
            title: if kind == "strong" {
                "Strong error against cost".into()
            } else {
                format!("Weak error of {what} against cost")
            },
            subtitle: problem.equation.into(),
            x_label: "CPU time per path, noise included (µs)".into(),
            y_label: y_label.into(),
            caption,
        };
        let name = format!("{}-{kind}", problem.name);
        let reading = Reading::Cost {
            unit: "µs a path".into(),
            errors: Measure::Absolute,
            // The error of a finer reference is unknown; the subtitle states its resolution.
            reference_error: 0.0,
        };
        let chart = WorkPrecision { words, reading, series };
        Ok::<_, CaseError>(Drawing::work_precision(&name, &chart)?)
    };
    let y_label = format!("error of {what}");
    Ok(vec![
        picture("strong", "root mean square error", &problem.strong, &strong.methods)?,
        picture("weak", &y_label, &problem.weak, &weak.methods)?,
    ])
}

fn caption(study: &Study, has_rival: bool, diffrax: Option<&Diffrax>) -> Vec<String> {
    let rival = "The rival takes one StandardNormal of ChaCha8 per step; its error is that of Euler-Maruyama.";
    [
        Some(format!(
            "{} paths, the same for all. Bars: one standard error (jackknife) of the error; half the range of five timings.",
            study.n_paths
        )),
        Some("Labels: steps. The methods draw w and H. A cross: some paths ended in an error, which the JSON file names.".into()),
        has_rival.then(|| rival.into()),
        diffrax.map(diffrax_caption),
        Some(Machine::read().caption()),
    ]
    .into_iter()
    .flatten()
    .collect()
}

/// Recorded results of diffrax on a problem.
fn diffrax_series(record: &Diffrax, problem: &str) -> Vec<Series> {
    [("euler", "Euler"), ("heun", "Heun"), ("shark", "ShARK")]
        .into_iter()
        .map(|(id, name)| Series {
            name: format!("rival: diffrax {name}"),
            runs: record
                .rows
                .iter()
                .filter(|row| row.problem == problem && row.method == id)
                .map(|row| Run {
                    cost: 1e6 * row.cpu_seconds_per_path,
                    cost_error: Some(1e6 * row.cpu_seconds_scatter),
                    outcome: row.strong_error.map_or_else(
                        || RunOutcome::Failed { reason: "a path is not finite".into() },
                        |value| RunOutcome::Error { value, standard_error: row.strong_error_se },
                    ),
                    label: None,
                })
                .collect(),
        })
        .collect()
}

fn diffrax_caption(record: &Diffrax) -> String {
    let version = |package: &str| record.versions.get(package).map_or("?", String::as_str);
    format!(
        "diffrax {} on jax {}, recorded {} ({}, {} thread, load {:.1}), not of this run: {} paths a call, errors of {} paths of its own.",
        version("diffrax"),
        version("jax"),
        record.date,
        record.machine.processor,
        record.machine.threads,
        record.machine.load,
        record.timed_paths,
        record.paths,
    )
}

/// Text for each level at which some paths failed.
fn failures(outcome: &Outcome, study: &Study) -> Vec<Option<String>> {
    let words = |Failure { n_paths, first, error }: &Failure| {
        format!("{n_paths} of {} paths, the first, {first}: {error}", study.n_paths)
    };
    outcome.failures.iter().map(|failure| failure.as_ref().map(words)).collect()
}

fn runs(errors: &Errors, failures: &[Option<String>], times: &[Timing]) -> Vec<Run> {
    let times = &times[..errors.levels.len().min(times.len())];
    let ends = [times.first(), times.last()].map(|end| end.map_or(0, |time| time.n_steps));
    errors
        .levels
        .iter()
        .zip(failures)
        .zip(times)
        .map(|((level, failure), time)| {
            let outcome = match failure.as_ref().or(time.failure.as_ref()) {
                Some(reason) => RunOutcome::Failed { reason: reason.clone() },
                None if level.error.value.abs() > 0.0 && level.error.value.is_finite() => {
                    RunOutcome::Error {
                        value: level.error.value.abs(),
                        standard_error: level.error.standard_error,
                    }
                }
                None => RunOutcome::Failed { reason: format!("error {}", level.error.value) },
            };
            let label = ends.contains(&time.n_steps).then(|| time.n_steps.to_string());
            run((time.cost, time.spread), outcome, label)
        })
        .collect()
}

/// CPU time of one path (microseconds): median and half range of five rounds; and the error of the first failed path.
struct Timing {
    n_steps: usize,
    cost: f64,
    spread: f64,
    failure: Option<String>,
}

fn timed<E: std::fmt::Display>(
    n_steps: usize,
    mut path: impl FnMut(u64) -> Result<f64, E>,
) -> Result<Timing, CaseError> {
    // About two million steps in all five rounds.
    let n_paths = (400_000 / n_steps as u64).max(8);
    let (mut sum, mut times, mut n_failed, mut first) = (0.0, Vec::new(), 0_u64, None);
    for round in 0..5 {
        let start = CpuClock::start();
        for k in 0..n_paths {
            match path(round * n_paths + k) {
                Ok(value) => sum += value,
                Err(error) => {
                    n_failed += 1;
                    first.get_or_insert_with(|| error.to_string());
                }
            }
        }
        times.push(start.seconds() * 1e6 / n_paths as f64);
    }
    if sum.is_nan() {
        return Err("a path that was timed is not a number".into());
    }
    let (cost, spread) = median_and_half_range(times);
    let failure =
        first.map(|text| format!("{n_failed} of {} paths, the first: {text}", 5 * n_paths));
    Ok(Timing { n_steps, cost, spread, failure })
}

fn timings<S, const D: usize, const M: usize>(
    problem: &Problem<'_, S, D, M>,
    method: &Method<S, D, M>,
    study: &Study,
) -> Result<Vec<Timing>, CaseError> {
    (0..study.n_levels)
        .map(|level| {
            let n_steps = study.coarsest << level;
            let dt = study.end / n_steps as f64;
            let mut increments = Vec::with_capacity(n_steps);
            timed(n_steps, |path| {
                let mut noise = Noise::new(1).path::<M>(path);
                increments.clear();
                increments.extend((0..n_steps).map(|_| noise.next_increment(dt)));
                Ok::<_, StepError>((method.run)(problem.system, problem.start, dt, &increments)?[0])
            })
        })
        .collect()
}

fn rival_timings(rival: &Rival<'_>, study: &Study) -> Result<Vec<Timing>, CaseError> {
    let mut generator = ChaCha8Rng::seed_from_u64(1);
    let mut normal = || -> f64 { StandardNormal.sample(&mut generator) };
    (0..study.n_levels)
        .map(|level| {
            let n_steps = study.coarsest << level;
            timed(n_steps, |_| {
                let end = rival(&mut normal, n_steps, study.end / n_steps as f64);
                Ok::<_, std::convert::Infallible>(end)
            })
        })
        .collect()
}
