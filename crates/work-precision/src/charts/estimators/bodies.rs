//! Random parameters of bodies: samples, Sobol' points, and what corrects them.

use perturbation_moments::MonteCarlo;
use result_figures::{Drawing, Words};
use scenes::smpm::experiment::SceneExperiment;
use scenes::smpm::scene::SmpmScene;
use smpm::uncertainty::{Design, Study};
use uq_estimators::{Sampling, UnitCube};

use super::measured::{Size, drawing, method};
use crate::problems::shock;
use reference_problems::context::{CaseError, Context, Profile};
use reference_problems::quantile::quantile;
use reference_problems::smpm::problems::{Problem, experiment};

/// Step of the differences of a Taylor series, in standard deviations.
const DIFFERENCE: f64 = 0.1;
/// Replicas of Sobol' points.
const REPLICAS: u64 = 8;
/// Coefficient of variation of the steel behind the explosion.
const STRENGTH: f64 = 0.15;

pub(super) fn draw(context: &Context<'_>) -> Result<Vec<Drawing>, CaseError> {
    Ok(vec![shock(context)?, explosion(context)?])
}

/// Reference variance of each response.
enum Truth {
    Exact(Vec<f64>),
    /// By polynomials on that many points of 16 replicas.
    Reference(u64),
}

struct Question<'a> {
    name: &'a str,
    title: &'a str,
    subtitle: String,
    letter: &'a str,
    truth: Truth,
    n_seeds: u64,
    /// Points of a replica: at most so many.
    most_points: u64,
}

fn shock(context: &Context<'_>) -> Result<Drawing, CaseError> {
    let usual = Problem::PlateImpact.scene()?;
    let mut scene = shock::scene(&usual.scheme, usual.grid.cell)?;
    let strength = scene.random[0].coefficient_of_variation;
    scene.times.truncate(1);
    let question = Question {
        name: "estimators-shock",
        title: "Variance of the pressure behind a plane shock in steel, against cost",
        subtitle: format!("S1, gamma0 and a normal, coefficient of variation {strength}"),
        letter: "p",
        truth: Truth::Exact(vec![shock::variance(strength)]),
        n_seeds: 8,
        most_points: 32,
    };
    chart::<1>(context, &scene, question)
}

fn explosion(context: &Context<'_>) -> Result<Drawing, CaseError> {
    let mut scene = Problem::ContactExplosion.scene_with(STRENGTH, &[9.0, 10.0, 11.0, 12.0])?;
    scene.quantities = vec!["flow_stress".to_owned()];
    let question = Question {
        name: "estimators-explosion",
        title: "Variance of the flow stress behind a contact explosion, against cost",
        subtitle: format!(
            "4340 steel, A, B, n, C, m normal, coefficient of variation {STRENGTH}; four gauges at 9, 10, 11, 12 us"
        ),
        letter: "sigma_y",
        truth: Truth::Reference(128),
        n_seeds: 4,
        most_points: 32,
    };
    chart::<2>(context, &scene, question)
}

/// A study with the reference variance of each response.
struct Compared<'a, const D: usize> {
    study: Study<'a, SceneExperiment<D>, D>,
    dimension: usize,
    truth: Vec<f64>,
}

impl<const D: usize> Compared<'_, D> {
    const fn cube(&self, n_points: u64, n_replicas: u64, seed: u64) -> UnitCube {
        let (dimension, sampling) = (self.dimension, Sampling::ScrambledSobol);
        UnitCube { dimension, sampling, seed, n_points, n_replicas }
    }

    /// Variances by polynomials on that many points of 16 replicas; the median of their relative errors.
    fn reference(&self, points: u64) -> Result<(Vec<f64>, f64), CaseError> {
        let sampled = self.study.sampled(Design::QuasiRandom(self.cube(points, 16, 7)))?;
        let polynomial = sampled.polynomial_control()?;
        let (mut values, mut errors) = (Vec::new(), Vec::new());
        for response in 0..self.study.plan().n_responses() {
            let found = polynomial.moments(&sampled.values(response)?)?.moments.variance;
            values.push(found.value);
            errors.push(found.standard_error().unwrap_or(f64::NAN) / found.value);
        }
        Ok((values, quantile(&errors, 0.5)))
    }

    /// Relative errors of the variances.
    fn errors(&self, of: impl Fn(usize) -> Result<f64, CaseError>) -> Result<Vec<f64>, CaseError> {
        self.truth.iter().enumerate().map(|(i, truth)| Ok(of(i)? / truth - 1.0)).collect()
    }

    /// Independent samples, as many as points of all replicas; with a Taylor series from differences or not.
    fn samples(&self, n: u64, with_series: bool) -> Size<'_> {
        let run = move |seed| {
            let sampled = self.study.monte_carlo(MonteCarlo { seed, n_samples: n * REPLICAS })?;
            let series =
                if with_series { self.study.finite_difference(DIFFERENCE)? } else { Vec::new() };
            self.errors(|i| {
                let found = match series.get(i) {
                    Some(series) => sampled.controlled(i, series)?,
                    None => sampled.raw(i)?,
                };
                Ok(found.variance.value)
            })
        };
        Size { label: (n * REPLICAS).to_string(), run: Box::new(run) }
    }

    /// Replicas of Sobol' points, with a fitted polynomial or not.
    fn quasi(&self, n: u64, with_polynomial: bool) -> Size<'_> {
        let run = move |seed| {
            let design = Design::QuasiRandom(self.cube(n, REPLICAS, seed));
            let sampled = self.study.sampled(design)?;
            let polynomial = sampled.polynomial_control()?;
            self.errors(|i| {
                let found = if with_polynomial {
                    polynomial.moments(&sampled.values(i)?)?.moments
                } else {
                    sampled.raw(i)?
                };
                Ok(found.variance.value)
            })
        };
        Size { label: format!("{REPLICAS} x {n}"), run: Box::new(run) }
    }
}

fn chart<const D: usize>(
    context: &Context<'_>,
    scene: &SmpmScene,
    question: Question<'_>,
) -> Result<Drawing, CaseError> {
    context.progress(question.name);
    let experiment = experiment::<D>(scene)?;
    let study = Study::new(&experiment, scene.inputs()?, scene.plan::<D>()?)?;
    let mut compared = Compared { study, dimension: scene.random.len(), truth: Vec::new() };
    let is_quick = context.profile == Profile::Quick;
    let (truth, truth_error) = match question.truth {
        Truth::Exact(variances) => (variances, 0.0),
        Truth::Reference(points) => compared.reference(if is_quick { 2 } else { points })?,
    };
    compared.truth = truth;
    let n = if is_quick { 1 } else { question.most_points.trailing_zeros() };
    let seeds = if is_quick { 2 } else { question.n_seeds };
    let plain: Vec<Size<'_>> = (1..=n).map(|k| compared.samples(1 << k, false)).collect();
    let series: Vec<Size<'_>> = (1..=n).map(|k| compared.samples(1 << k, true)).collect();
    let quasi: Vec<Size<'_>> = (1..=n).map(|k| compared.quasi(1 << k, false)).collect();
    let fitted: Vec<Size<'_>> = (1..=n).map(|k| compared.quasi(1 << k, true)).collect();
    let methods = vec![
        method("Monte Carlo (samples)", &plain, seeds),
        method("Monte Carlo, Taylor series as control variate (samples)", &series, seeds),
        method("quasi-Monte Carlo (replicas x points)", &quasi, seeds),
        method("quasi-Monte Carlo, fitted polynomial as control variate", &fitted, seeds),
    ];
    let caption = if truth_error > 0.0 {
        format!(
            "Against other runs at Sobol' points with a polynomial, whose own standard error is {truth_error:.1e} (median)."
        )
    } else {
        "Against the exact variance: what remains at the right is the grid error.".to_owned()
    };
    let words = Words {
        title: question.title.into(),
        subtitle: question.subtitle,
        x_label: String::new(),
        y_label: format!("relative error of Var {}", question.letter),
        caption: vec![caption],
    };
    drawing(question.name, words, methods, (truth_error, seeds))
}
