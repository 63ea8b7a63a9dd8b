//! Sums and products of functions of one normal each, by the estimators of the library: no scene file has all of them.

use std::time::Duration;

use perturbation_moments::{Expansion, Moments, MonteCarlo, RandomVector, Verdict as Trusted};
use scenes::RunError;
use scenes::answers::{ErrorOrigin, Number};
use sde_integrators::{normal_probability, normal_quantile};
use serde::Deserialize;
use serde_json::{Value, json};
use uq_estimators::{
    Bias, ControlledSamples, Error, Estimate, Failure, Levels, Multilevel, NormalModel,
    PolynomialControl, SampledMoments, Sampling, Statistic, SubsetConfig, Surrogate, TailSampling,
    Target, Tolerance, UnitCube, quantile,
};

use super::functions::Function;
use crate::draw::{Draw, rounded};
use crate::{Family, Truth, Verdict};

pub(super) const FAMILY: Family = Family {
    name: "estimators",
    known_by: "closed moments of functions of one normal, and their sums and products; not judged above a kurtosis of eight and a quarter \
               of the samples",
    weight: 1.5,
    draw,
    truths: |problem| Problem::read(problem).map(|problem| problem.truths()),
    judge,
};

/// A response and how it is estimated.
#[derive(Deserialize)]
struct Problem {
    solver: String,
    is_product: bool,
    functions: Vec<Function>,
    method: String,
    points: u64,
    replicas: u64,
    seed: u64,
    /// Probability of a quantile, level of a tail, or tolerance.
    at: f64,
}

/// Kurtosis that few samples can show, and samples for each of it where there are more: no sample knows the variance of rarer events.
const KURTOSIS: f64 = 8.0;
const RUNS_OF_KURTOSIS: f64 = 4.0;

const METHODS: [&str; 12] = [
    "cube",
    "cube-controlled",
    "polynomial",
    "indices",
    "samples",
    "samples-controlled",
    "quantile",
    "cube-quantile",
    "multilevel",
    "lines",
    "subset",
    "taylor",
];

fn draw(draw: &mut Draw, hostile: bool) -> (Value, &'static str) {
    let method = *draw.one_of(&METHODS);
    let is_tail = ["lines", "subset"].contains(&method);
    let n = match method {
        "taylor" => 2,
        _ => draw.whole(1, if hostile { 20 } else { 6 }),
    };
    let size = if hostile { draw.between(0.5, 2.0) } else { draw.scaled(0.1, 0.7) };
    let each = size / (n as f64).sqrt();
    let kind = draw.whole(
        0,
        if is_tail {
            2
        } else if method.contains("quantile") {
            1
        } else {
            4
        },
    );
    let function = |draw: &mut Draw, k: u64| {
        let a = rounded(each * draw.between(0.3, 1.3));
        let name = match kind {
            0 => "exponential",
            1 => "linear",
            2 if k == 0 => "linear",
            2 => "quadratic",
            _ if hostile && method != "taylor" && draw.chance(0.3) => "step",
            _ => draw.one_of(&["exponential", "linear", "quadratic", "bell"]),
        };
        let a = if kind == 2 && k == 0 { 1.0 } else { a };
        json!({ name: a })
    };
    let functions: Vec<Value> = (0..n).map(|k| function(draw, k)).collect();
    let (points, replicas) = if hostile {
        (1 << draw.whole(1, 3), 8)
    } else {
        (1 << draw.whole(5, 8), draw.whole(8, 24))
    };
    let is_product = kind == 0 || kind == 3;
    let mut problem = json!({
        "solver": "uq-estimators", "title": "a sum or a product", "is_product": is_product,
        "functions": functions, "method": method, "points": points, "replicas": replicas,
        "seed": draw.whole(1, 1 << 30), "at": 0.5,
    });
    problem["at"] = json!(match method {
        "multilevel" if hostile => draw.between(0.1, 0.5),
        "multilevel" => draw.scaled(0.01, 0.1),
        _ if is_tail => {
            let index =
                draw.between(if hostile { 0.5 } else { 1.5 }, if hostile { 7.0 } else { 4.5 });
            let deviation = Problem::read(&problem).map_or(1.0, |it| it.length());
            match kind {
                0 => rounded((index * deviation).exp()),
                1 => n as f64 + rounded(index * deviation),
                _ => n as f64 + rounded(index),
            }
        }
        _ if hostile => draw.between(0.001, 0.999),
        _ => draw.between(0.1, 0.9),
    });
    (problem, method)
}

impl Problem {
    fn read(problem: &Value) -> Option<Self> {
        serde_json::from_value(problem.clone())
            .ok()
            .filter(|it: &Self| it.solver == "uq-estimators")
    }

    fn value(&self, z: &[f64], scale: f64) -> f64 {
        let values = self.functions.iter().zip(z).map(|(f, z)| f.scaled(scale).at(*z));
        if self.is_product { values.product() } else { values.sum() }
    }

    /// Slopes at the origin.
    fn slopes(&self) -> Vec<f64> {
        self.functions.iter().map(|f| f.derivatives()[1]).collect()
    }

    /// Length of the slopes: the deviation of a normal sum, and that of the logarithm of a lognormal product.
    fn length(&self) -> f64 {
        self.slopes().iter().map(|slope| slope * slope).sum::<f64>().sqrt()
    }

    /// Mean, variance, Sobol' indices, and where it is known the quantile or the probability.
    fn truths(&self) -> Vec<Truth> {
        let moments: Vec<[f64; 4]> = self.functions.iter().map(|f| f.moments()).collect();
        let own = |i: usize| moments[i][1] - moments[i][0].powi(2);
        let without = |i: usize, k: usize, power: i32| -> f64 {
            let others = moments.iter().enumerate().filter(|(j, _)| *j != i);
            others.map(|(_, m)| m[k].powi(power)).product()
        };
        let all = moments.len();
        let (mean, variance) = if self.is_product {
            (without(all, 0, 1), without(all, 1, 1) - without(all, 0, 2))
        } else {
            (moments.iter().map(|m| m[0]).sum(), (0..all).map(own).sum())
        };
        let central = |[m, second, third, fourth]: [f64; 4]| {
            fourth - 4.0 * m * third + 6.0 * m * m * second - 3.0 * m.powi(4)
        };
        let fourth = if self.is_product {
            central([0, 1, 2, 3].map(|k| without(all, k, 1)))
        } else {
            // Fourth cumulants add.
            let excess = |i: usize| central(moments[i]) - 3.0 * own(i).powi(2);
            (0..all).map(excess).sum::<f64>() + 3.0 * variance * variance
        };
        // The pilot of a multilevel estimate may be all that there is.
        let is_pilot = self.method == "multilevel";
        let runs = if is_pilot { 0.0 } else { (self.points * self.replicas) as f64 };
        let most = KURTOSIS.max(runs / RUNS_OF_KURTOSIS);
        let is_rare = fourth > most * variance * variance;
        let mut truths = Vec::new();
        let mut known = |id: String, value: f64| {
            if !is_rare || ["quantile", "probability"].contains(&id.as_str()) {
                truths.push(Truth { id, time: None, value, error: 1e-9 * value.abs() + 1e-14 });
            }
        };
        known("mean".to_owned(), mean);
        known("variance".to_owned(), variance);
        for i in 0..all {
            let [first, total] =
                if self.is_product { [without(i, 0, 2), without(i, 1, 1)] } else { [1.0; 2] };
            // Rare events of one function decide its indices.
            if central(moments[i]) <= most * own(i).powi(2) {
                known(format!("first/{i}"), own(i) * first / variance);
                known(format!("total/{i}"), own(i) * total / variance);
            }
        }
        let (n, length) = (all as f64, self.length());
        let z = if self.at > 0.0 && self.at < 1.0 { normal_quantile(self.at) } else { 0.0 };
        match self.functions.as_slice() {
            [Function::Exponential(_), ..] if self.is_product => {
                known("quantile".to_owned(), (length * z).exp());
                known("probability".to_owned(), normal_probability(-self.at.ln() / length));
            }
            [Function::Linear(a), Function::Quadratic(_), ..] => {
                known("probability".to_owned(), self.beyond(*a));
            }
            _ => {
                known("quantile".to_owned(), n + length * z);
                known("probability".to_owned(), normal_probability((n - self.at) / length));
            }
        }
        truths
    }

    /// `P(n + a z_0 + sum_k c_k z_k^2 > at)` by the characteristic function (Gil-Pelaez 1951).
    fn beyond(&self, a: f64) -> f64 {
        let level = self.at - self.functions.len() as f64;
        let step = 2e-3 / a;
        let term = |k: u32| {
            let t = (f64::from(k) + 0.5) * step;
            let (mut size, mut phase) = (-0.5 * (a * t).powi(2), -t * level);
            for function in &self.functions {
                if let Function::Quadratic(c) = function {
                    let b = 2.0 * c * t;
                    size -= 0.25 * (b * b).ln_1p();
                    phase += 0.5 * b.atan();
                }
            }
            size.exp() * phase.sin() / t
        };
        0.5 + step * (0..4500).map(term).sum::<f64>() / std::f64::consts::PI
    }

    /// The estimates of the method, by the names of the truths.
    fn estimates(&self) -> Result<Vec<(String, Number)>, RunError> {
        let found = match self.method.as_str() {
            "multilevel" => self.multilevel(),
            "lines" | "subset" => self.tail(),
            "samples" | "samples-controlled" | "quantile" => self.sampled(),
            "taylor" => return self.taylor().map_err(RunError::solver),
            _ => self.designed(),
        };
        found.map_err(RunError::solver)
    }

    fn samples(&self) -> MonteCarlo {
        MonteCarlo { seed: self.seed, n_samples: self.points * self.replicas }
    }

    fn is_controlled(&self) -> bool {
        self.method.ends_with("controlled")
    }

    /// Normals of all samples.
    fn inputs(&self, fill: impl Fn(u64, &mut [f64])) -> Vec<f64> {
        let n = self.functions.len();
        let mut inputs = vec![0.0; n * whole(self.points * self.replicas)];
        (0..).zip(inputs.chunks_exact_mut(n)).for_each(|(run, z)| fill(run, z));
        inputs
    }

    /// The response at all samples, each followed by its linear surrogate if that is used.
    fn rows(&self, inputs: &[f64]) -> Vec<f64> {
        let slopes = self.slopes();
        let linear = |z: &[f64]| z.iter().zip(&slopes).map(|(z, g)| z * g).sum::<f64>();
        let rows = inputs.chunks_exact(slopes.len()).map(|z| [self.value(z, 1.0), linear(z)]);
        rows.flat_map(|row| row.into_iter().take(1 + usize::from(self.is_controlled()))).collect()
    }

    fn surrogates(&self) -> Vec<Surrogate> {
        let linear = Surrogate { mean: 0.0, variance: Some(self.length().powi(2)) };
        vec![linear; usize::from(self.is_controlled())]
    }

    /// By independent samples.
    fn sampled(&self) -> Result<Vec<(String, Number)>, Error> {
        let rows = self.rows(&self.inputs(|run, z| self.samples().fill_normals(run, z)));
        if self.method == "quantile" {
            let [low, high] = quantile(&rows, self.at, 0.95)?.interval;
            let (value, error) = (0.5 * (low + high), Some(0.5 * (high - low)));
            let number = Number { value, error, error_kind: ErrorOrigin::Interval };
            return Ok(named([("quantile", number)]));
        }
        let surrogates = &self.surrogates();
        let samples = ControlledSamples { samples: &rows, surrogates, seed: self.seed };
        let found = if self.is_controlled() { samples.estimate() } else { samples.raw() };
        found.map(|found| moments(&found))
    }

    /// By replicas of scrambled Sobol' points.
    fn designed(&self) -> Result<Vec<(String, Number)>, Error> {
        let cube = UnitCube {
            dimension: self.functions.len(),
            sampling: Sampling::ScrambledSobol,
            seed: self.seed,
            n_points: self.points,
            n_replicas: self.replicas,
        };
        if self.method == "indices" {
            let response = |x: &[f64], y: &mut [f64]| {
                let z: Vec<f64> = x.iter().map(|x| normal_quantile(*x)).collect();
                y[0] = self.value(&z, 1.0);
                Ok(())
            };
            let found = &cube.sobol_indices(1, response)?[0];
            let mut all = named([("mean", found.mean.into()), ("variance", found.variance.into())]);
            all.extend(indices([&found.first, &found.total], 0.0));
            return Ok(all);
        }
        let runs = cube.runs()?;
        let inputs = self.inputs(|run, z| runs.normals(run, z));
        let rows = self.rows(&inputs);
        match self.method.as_str() {
            "polynomial" => {
                let found =
                    PolynomialControl::new(&inputs, self.functions.len(), whole(self.replicas))?
                        .moments(&rows)?;
                let mut all = moments(&found.moments);
                // An index may be off by the unexplained part, besides its standard error.
                all.extend(indices([&found.first, &found.total], found.unexplained));
                Ok(all)
            }
            "cube-quantile" => {
                Ok(named([("quantile", cube.quantile_of_runs(&rows, self.at)?.into())]))
            }
            _ => cube.moments_of_runs(&rows, &self.surrogates()).map(|found| moments(&found)),
        }
    }

    /// The probability of a rare event.
    fn tail(&self) -> Result<Vec<(String, Number)>, Error> {
        let tail = TailSampling { model: self, level: self.at, seed: self.seed };
        let n_samples = self.samples().n_samples;
        let found = if self.method == "lines" {
            tail.line_sampling(&tail.design_point()?, n_samples.clamp(64, 1000))?
        } else {
            let n_samples = whole(n_samples).clamp(100, 1000);
            tail.subset(&SubsetConfig { n_samples, correlation: 0.8, n_runs: self.replicas })?
        };
        Ok(named([("probability", found.probability.into())]))
    }

    /// Mean and variance over levels whose parameters approach those of the response, with a bias or up to it.
    fn multilevel(&self) -> Result<Vec<(String, Number)>, Error> {
        let is_exact = self.seed.is_multiple_of(2);
        let run = |level: usize, realisation: u64, y: &mut [f64]| {
            let mut z = vec![0.0; self.functions.len()];
            MonteCarlo { seed: self.seed, n_samples: 0 }.fill_normals(realisation, &mut z);
            let is_last = is_exact && level == 4;
            let scale = if is_last { 1.0 } else { 1.0 - (0..=level).map(|_| 0.5).product::<f64>() };
            y[0] = self.value(&z, scale);
            Ok(())
        };
        let n_levels = if is_exact { 5 } else { 12 };
        let costs: Vec<f64> = (0..n_levels).map(|level| f64::from(level).exp2()).collect();
        let of = |statistic, tolerance| Target { response: 0, statistic, tolerance };
        let open =
            if self.points > 8 { Tolerance::Relative(2.0 * self.at) } else { Tolerance::Open };
        let targets =
            [of(Statistic::Mean, Tolerance::Relative(self.at)), of(Statistic::Variance, open)];
        let study = Multilevel {
            name: "functions",
            targets: &targets,
            bias: if is_exact { Bias::FinestIsExact } else { Bias::FittedOrder },
            block_length: 8,
            pilot_blocks: if self.points > 8 { 4 } else { 1 },
            budget: 3e6,
        };
        let found = study.run(&Levels { costs: &costs, n_responses: 1, run })?;
        let number = |k: usize| {
            let target = &found.targets[k];
            let error = Some(target.root_mean_square_error()).filter(|error| !error.is_nan());
            Number::sampled(target.estimate.value, error)
        };
        Ok(named([("mean", number(0)), ("variance", number(1))]))
    }

    /// Moments from derivatives, which promise a tenth of the variance where their indicators are small, and samples with the series.
    fn taylor(&self) -> Result<Vec<(String, Number)>, perturbation_moments::Error> {
        let of = |by: &[usize]| {
            let derivative = |k: usize| {
                self.functions[k].derivatives()[by.iter().filter(|input| **input == k).count()]
            };
            match by {
                _ if self.is_product => derivative(0) * derivative(1),
                [] => derivative(0) + derivative(1),
                [k, rest @ ..] if rest.iter().all(|other| other == k) => derivative(*k),
                _ => 0.0,
            }
        };
        let inputs = RandomVector::independent([0.0; 2], [1.0; 2])?;
        let moments = Moments::new(&inputs, &Expansion::from_derivatives(of))?;
        let first_order = moments.variance_first_order();
        let is_trusted = moments.trust()?.verdict() == Trusted::InPeace;
        let error = is_trusted.then_some(0.1 * first_order);
        let found = self.samples().judge(&inputs, &moments, |z| self.value(z, 1.0))?;
        Ok(named([
            ("variance", Number::sampled(first_order, error)),
            ("mean", found.raw_mean.into()),
            ("variance", found.raw_variance.into()),
            ("mean", found.controlled_mean.into()),
            ("variance", found.controlled_variance.into()),
        ]))
    }
}

impl NormalModel for Problem {
    fn n_normals(&self) -> usize {
        self.functions.len()
    }

    fn value(&self, normals: &[f64]) -> Result<f64, Failure> {
        Ok(self.value(normals, 1.0))
    }
}

fn whole(n: u64) -> usize {
    usize::try_from(n).unwrap_or(usize::MAX)
}

fn moments(found: &SampledMoments) -> Vec<(String, Number)> {
    named([("mean", found.mean.into()), ("variance", found.variance.into())])
}

/// First-order and total indices, which may be off by more than their own errors.
fn indices(found: [&Vec<Estimate>; 2], more: f64) -> Vec<(String, Number)> {
    let number = |estimate: &Estimate| {
        let number = Number::from(*estimate);
        Number { error: number.error.map(|error| error + more), ..number }
    };
    let of = |(name, indices): (&'static str, &Vec<Estimate>)| {
        let named = |(i, it)| (format!("{name}/{i}"), number(it));
        indices.iter().enumerate().map(named).collect::<Vec<_>>()
    };
    ["first", "total"].into_iter().zip(found).flat_map(of).collect()
}

fn named<const N: usize>(numbers: [(&str, Number); N]) -> Vec<(String, Number)> {
    numbers.map(|(name, number)| (name.to_owned(), number)).into()
}

fn judge(problem: &Value, truths: &[Truth], _: Duration) -> Result<Vec<Verdict>, RunError> {
    let problem = Problem::read(problem).ok_or(RunError::NoKinds)?;
    let verdict = |(name, number): (String, Number)| {
        let truth = truths.iter().find(|truth| truth.id == name)?.clone();
        Some(Verdict { truth, number, is_warned: false })
    };
    Ok(problem.estimates()?.into_iter().filter_map(verdict).collect())
}
