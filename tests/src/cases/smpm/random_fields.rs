//! Constants that vary in space: a column under its weight against its integral, a plate beside an explosion and a Taylor bar by the
//! gradient of all terms against sampled runs.

use perturbation_moments::{Estimate, MonteCarlo};
use reference_problems::smpm::problems::{Problem, experiment};
use scenes::smpm::experiment::SceneExperiment;
use scenes::smpm::scene::SmpmScene;
use smpm::Plan;
use smpm::uncertainty::{Sampled, Series, Study};

use crate::cases::prelude::*;

pub(crate) const COLUMN: Case = Case {
    id: "smpm/random-fields/column",
    title: "Displacement of a column under its weight whose stiffness is a lognormal random field",
    source: "u(x) = -int_0^x rho g (L - s)/M(s) ds; the reciprocal of a lognormal field is lognormal, so mean and variance are integrals of its covariance",
    cost: Profile::Default,
    run: Together(column),
};

pub(crate) const PLATE: Case = Case {
    id: "smpm/random-fields/plate",
    title: "Flow stress in a plate beside an explosion whose yield stress is a random field of 100 terms",
    source: "own whole runs, sampled",
    cost: Profile::Default,
    run: Together(plate),
};

pub(crate) const TAYLOR_BAR: Case = Case {
    id: "smpm/random-fields/taylor-bar",
    title: "Length of a Taylor bar whose yield stress is a random field",
    source: "own whole runs, sampled",
    cost: Profile::Default,
    run: Together(taylor_bar),
};

const SEED: u64 = 2026;

/// Samples of a study, controlled or not by the caller.
fn samples<const D: usize>(
    study: &Study<'_, SceneExperiment<D>, D>,
    n_samples: u64,
) -> CaseResult<Sampled> {
    let sampled = study.monte_carlo(MonteCarlo { seed: SEED, n_samples })?;
    if let Some((_, error)) = sampled.failures.first() {
        return Err(error.clone().into());
    }
    Ok(sampled)
}

pub(super) fn standard_error(estimate: &Estimate) -> f64 {
    estimate.standard_error().unwrap_or(f64::INFINITY)
}

/// Numbers of the scene of the column (m, kg, s).
pub(super) struct Column {
    length: f64,
    density: f64,
    gravity: f64,
    /// `K + 4 G/3`.
    modulus: f64,
    coefficient_of_variation: f64,
    correlation_length: f64,
}

pub(super) const SCENE_COLUMN: Column = Column {
    length: 10.0,
    density: 2400.0,
    gravity: 9.81,
    modulus: 20e9 + 4.0 / 3.0 * 12e9,
    coefficient_of_variation: 0.2,
    correlation_length: 2.0,
};

/// Mean, variance and first-order variance of the displacement at a height, by the midpoint rule.
pub(super) fn column_moments(column: &Column, height: f64) -> [f64; 3] {
    const N: usize = 1000;
    let h = height / N as f64;
    let weight = |k: usize| {
        let x = (k as f64 + 0.5) * h;
        -column.density * column.gravity * (column.length - x) / column.modulus * h
    };
    let square = (1.0 + column.coefficient_of_variation.powi(2)).ln();
    let mean: f64 = (0..N).map(weight).sum::<f64>() * square.exp();
    let (mut variance, mut first_order) = (0.0, 0.0);
    for i in 0..N {
        for j in 0..N {
            let r = (i as f64 - j as f64).abs() * h / column.correlation_length;
            let correlation = (1.0 + 2.0 * r) * (-2.0 * r).exp();
            let both = weight(i) * weight(j);
            variance += both * (2.0 * square).exp() * (square * correlation).exp_m1();
            first_order += both * square * square.exp() * correlation;
        }
    }
    [mean, variance, first_order]
}

fn column(context: &Context<'_>) -> CaseResult {
    let scene = Problem::RandomColumn.scene()?;
    let experiment = experiment::<1>(&scene)?;
    let plan = scene.plan::<1>()?;
    let study = Study::new(&experiment, experiment.inputs(), plan)?;
    context.progress("derivatives");
    let gradient = study.propagated()?;
    let n_samples = if context.profile == Profile::Full { 1600 } else { 400 };
    let sampled = samples(&study, n_samples)?;
    let (lines, mut claims) = (|method| context.lines("", method), Vec::new());
    let fine = refined_column(&scene)?;
    for (g, gauge) in [(0, "middle"), (1, "top")] {
        let start = study.centre()[study.plan().index(g, 0, 0)];
        let response = study.plan().index(g, 0, 1);
        let [mean, variance, first_order] = column_moments(&SCENE_COLUMN, start);
        let series = &gradient.moments[response];
        let found = sampled.controlled(response, series)?;
        let method = format!(
            "{n_samples} samples, Taylor series of {} terms as control variate",
            series.gradient.len()
        );
        let quantity = format!("mean displacement, {gauge}");
        let reason = "statistics: three standard errors of the samples, 6e-4 each";
        let subject = lines(method.clone()).of(format!("mean/{gauge}"), quantity).unit("m");
        claims.push(subject.relative(found.mean.value - start, mean).within(0.002).because(reason));
        let quantity = format!("variance of the displacement, {gauge}");
        let reason = "80 particles, terms left out, and the samples' own error";
        let subject = lines(method).of(format!("variance/{gauge}"), quantity).unit("m^2");
        claims.push(subject.relative(found.variance.value, variance).within(0.01).because(reason));
        let method = format!("gradient by {} runs of jets", gradient.n_runs);
        let quantity = format!("first-order variance, {gauge}");
        let reason = "80 particles and terms left out";
        let subject = lines(method).of(format!("first-order/{gauge}"), quantity).unit("m^2");
        claims.push(subject.relative(series.variance(), first_order).within(0.005).because(reason));
        let coarse = study.run(&study.normals(SEED, 0))?[response] - start;
        claims.push(
            lines("80 particles against 160, one realisation".to_owned())
                .of(format!("two-grids/{gauge}"), format!("displacement of a realisation, {gauge}"))
                .unit("m")
                .relative(coarse, fine[response] - start)
                .within(0.001)
                .because("the error of the grid: the field is the same function of space"),
        );
    }
    Ok(claims)
}

/// The responses of the first realisation on a grid of half the cell.
fn refined_column(scene: &SmpmScene) -> CaseResult<Vec<f64>> {
    let mut scene = scene.clone();
    scene.grid.cell *= 0.5;
    let experiment = experiment::<1>(&scene)?;
    let study = Study::new(&experiment, experiment.inputs(), scene.plan::<1>()?)?;
    Ok(study.run(&study.normals(SEED, 0))?)
}

/// A response by gradient and by samples.
struct Compared {
    /// Relative difference of the variances, and the standard error of the samples' over it.
    variance: [f64; 2],
    /// Difference of the means over the deviation, and the standard error of the samples' over it.
    mean: [f64; 2],
    /// The deviation of the samples.
    deviation: f64,
}

fn compared(sampled: &Sampled, response: usize, series: &Series) -> CaseResult<Compared> {
    let found = sampled.controlled(response, series)?;
    let deviation = found.variance.value.sqrt();
    Ok(Compared {
        variance: [
            series.variance() / found.variance.value - 1.0,
            standard_error(&found.variance) / found.variance.value,
        ],
        mean: [
            (series.mean() - found.mean.value) / deviation,
            standard_error(&found.mean) / deviation,
        ],
        deviation,
    })
}

fn response_of<const D: usize>(
    plan: &Plan<D>,
    gauge: &str,
    quantity: usize,
    window: usize,
) -> usize {
    let gauge = plan.gauges.iter().position(|it| it.name == gauge).unwrap_or(0);
    plan.index(gauge, quantity, window)
}

fn plate(context: &Context<'_>) -> CaseResult {
    let scene = Problem::RandomPlate.scene()?;
    let experiment = experiment::<2>(&scene)?;
    let study = Study::new(&experiment, experiment.inputs(), scene.plan::<2>()?)?;
    context.progress("derivatives");
    let gradient = study.propagated()?;
    let n_samples = if context.profile == Profile::Full { 1000 } else { 250 };
    context.progress("samples");
    let sampled = samples(&study, n_samples)?;
    let mut claims = Vec::new();
    let method = format!(
        "gradient of {} terms by {} runs of jets, against {n_samples} samples with control variate",
        gradient.moments[0].gradient.len(),
        gradient.n_runs
    );
    let lines = context.lines("", method);
    for (window, time) in [(1, "8 us"), (2, "10 us"), (3, "12 us")] {
        let response = response_of(study.plan(), "H", 0, window);
        let of = compared(&sampled, response, &gradient.moments[response])?;
        let id = format!("variance/{}", time.replace(" us", ""));
        let quantity = format!("relative error of the variance of sigma_y at H, {time}");
        let claim = lines.of(&id, quantity).bounded(of.variance[0], 0.001);
        claims.push(claim.because("statistics: four standard errors of the samples, 2e-4 each"));
        let id = format!("mean/{}", time.replace(" us", ""));
        let quantity = format!("error of the mean of sigma_y at H over its deviation, {time}");
        let claim = lines.of(&id, quantity).bounded(of.mean[0], 0.001);
        claims.push(claim.because("statistics: the samples' own error"));
    }
    Ok(claims)
}

fn taylor_bar(context: &Context<'_>) -> CaseResult {
    let scene = Problem::RandomTaylorBar.scene()?;
    let experiment = experiment::<2>(&scene)?;
    let study = Study::new(&experiment, experiment.inputs(), scene.plan::<2>()?)?;
    context.progress("derivatives");
    let gradient = study.propagated()?;
    let n_samples = if context.profile == Profile::Full { 400 } else { 100 };
    context.progress("samples");
    let sampled = samples(&study, n_samples)?;
    let method = format!(
        "gradient of {} terms by {} runs of jets, against {n_samples} samples with control variate",
        gradient.moments[0].gradient.len(),
        gradient.n_runs
    );
    let lines = context.lines("", method);
    // The place of the rear end: the length of the bar.
    let response = response_of(study.plan(), "rear", 1, 0);
    let of = compared(&sampled, response, &gradient.moments[response])?;
    Ok(vec![
        lines
            .of("variance", "relative error of the variance of the length")
            .bounded(of.variance[0], 0.014)
            .because("third derivatives, of the order of cv^2, and the samples' own error"),
        lines
            .of("mean", "error of the mean length over its deviation")
            .bounded(of.mean[0], 0.025)
            .because("fourth order, and the samples' own error"),
        lines
            .of("deviation", "deviation of the length")
            .unit("mm")
            .measured(of.deviation, (0.2, 0.35))
            .because("0.27 mm: 15 % of the yield stress, averaged over some correlation lengths"),
    ])
}
