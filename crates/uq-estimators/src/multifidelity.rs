//! Multifidelity Monte Carlo: surrogates with unknown means.

use sde_integrators::Estimate;

use crate::comoments::Comoments;
use crate::error::{Error, require_at_least, require_finite_responses, require_positive};
use crate::ladder::Failure;
use crate::multifidelity_progress::{ModelBlock, ModelRange, MultifidelityProgress, PILOT_START};
use crate::parallel::map_in_order;
use crate::rates::with_error;

/// Mean of an expensive model with the help of cheaper ones whose means are unknown.
///
/// Model 1 (index 0 here) is the truth, the others are surrogates on the same random input, ordered by their correlation
/// $\rho_i$ with it. With $m_1 \le m_2 \le \dots$ runs of the models on the first $m_i$ samples,
///
/// $$ \hat s = \bar y^{(1)}_{m_1} + \sum_{i \ge 2} \alpha_i \left( \bar y^{(i)}_{m_i} - \bar y^{(i)}_{m_{i-1}} \right),
///    \quad \alpha_i = \rho_i \frac{\sigma_1}{\sigma_i}, \qquad
///    \operatorname{Var} \hat s = \sum_i \frac{v_i}{m_i}, \quad v_i = \sigma_1^2 (\rho_i^2 - \rho_{i+1}^2), $$
///
/// and the cheapest allocation for a standard error $\epsilon$ is
/// $m_i = \epsilon^{-2} \sqrt{v_i / w_i} \sum_k \sqrt{v_k w_k}$ with the costs $w_i$.
///
/// A pilot of its own measures the correlations; of all sets of surrogates for which the numbers of runs increase, the one
/// with the lowest cost is used, which may be none. The coefficients are those of the pilot, so they are independent of the
/// samples that they weigh, and the estimate is unbiased whatever they are. The standard error is that of the samples, not
/// the predicted one; samples are added until it is at most the tolerance.
///
/// The result depends on models and fields alone: bitwise identical for any number of threads, after an interruption, and for
/// blocks computed apart. [`run`](Self::run) does everything; for shards and resumption use [`begin`](Self::begin),
/// [`MultifidelityProgress::missing`], [`block`](Self::block), [`MultifidelityProgress::insert`], [`advance`](Self::advance)
/// and [`finish`](Self::finish).
///
/// Source: Peherstorfer, Willcox and Gunzburger 2016, Optimal model management for multifidelity Monte Carlo estimation,
/// eq 3.3 to 3.7, theorem 3.4 and algorithm 1.
///
/// ```
/// use uq_estimators::Multifidelity;
/// use sde_integrators::{Noise, Purpose};
///
/// // exp(u), u uniform, with its expansion to second order as surrogate.
/// let run = |model: usize, sample: u64| {
///     let u = Noise::new(1).stream(Purpose::Field, sample).next_uniform();
///     Ok(if model == 0 { u.exp() } else { 1.0 + u + 0.5 * u * u })
/// };
/// let study = Multifidelity {
///     name: "exp", costs: &[1.0, 1e-3], tolerance: 1e-3, pilot: 50, block_length: 64, budget: 1e6,
/// };
/// let found = study.run(run)?;
/// assert!((found.mean.value - (1_f64.exp() - 1.0)).abs() < 4e-3 && found.cost < found.single_model_cost);
/// # Ok::<(), uq_estimators::Error>(())
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Multifidelity<'a> {
    /// Name of the study: blocks of studies with different names are not merged. It represents what cannot be compared:
    /// the models and their seed.
    pub name: &'a str,
    /// Cost of a run of each model, in any unit; the first is the model whose mean is estimated.
    pub costs: &'a [f64],
    /// Standard error asked for, in the unit of the response.
    pub tolerance: f64,
    /// Samples of all models that measure the correlations, at least eight.
    pub pilot: u64,
    /// Runs per block, the unit of parallel work; one where a run takes minutes.
    pub block_length: u64,
    /// Largest cost of all runs, in the unit of the costs.
    pub budget: f64,
}

/// Result of a multifidelity estimate.
#[derive(Debug, Clone, PartialEq)]
#[must_use]
pub struct MultifidelityResult {
    /// The mean, with its standard error.
    pub mean: Estimate,
    /// The models used, the truth first, with their runs and coefficients.
    pub models: Vec<ModelReport>,
    /// Cost of all runs, the pilot included.
    pub cost: f64,
    /// Cost of plain Monte Carlo with the same tolerance, from the variance in the pilot.
    pub single_model_cost: f64,
}

/// A model that was used.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ModelReport {
    /// Its index.
    pub model: usize,
    /// Number of its runs, without the pilot.
    pub n_runs: u64,
    /// Its coefficient; 1 for the truth.
    pub coefficient: f64,
    /// Its correlation with the truth in the pilot.
    pub correlation: f64,
}

/// Smallest pilot.
const FEWEST_SAMPLES: u64 = 8;

/// Largest number of surrogates: all sets of them are compared.
const MOST_SURROGATES: usize = 12;

/// A model of the chosen set.
#[derive(Debug, Clone, Copy)]
struct Chosen {
    model: usize,
    correlation: f64,
    coefficient: f64,
    /// Number of samples for a standard error of one.
    share: f64,
}

impl Multifidelity<'_> {
    /// Runs the models: `run(model, sample)` is the response of a model to random input number `sample`, the same input for
    /// every model.
    ///
    /// With the feature `rayon` blocks run in parallel on the current pool; the result is bitwise identical for any number of
    /// threads.
    ///
    /// # Errors
    /// [`Error::NotPositive`], [`Error::TooFew`], [`Error::TooMany`] for the fields; [`Error::SampleFailed`],
    /// [`Error::NonFiniteSample`] for the lowest such sample; [`Error::NoVariance`] for a truth that does not vary in the
    /// pilot; [`Error::OverBudget`] before the runs that exceed it.
    pub fn run(
        &self,
        run: impl Fn(usize, u64) -> Result<f64, Failure> + Sync + Send,
    ) -> Result<MultifidelityResult, Error> {
        let mut progress = self.begin()?;
        while self.advance(&mut progress)? {
            let missing = progress.missing();
            for block in map_in_order(&missing, |&range| self.block(&run, range)) {
                progress.insert(block?)?;
            }
        }
        self.finish(&progress)
    }

    /// Checks the fields, and plans nothing yet.
    ///
    /// # Errors
    /// As [`run`](Self::run).
    pub fn begin(&self) -> Result<MultifidelityProgress, Error> {
        self.check()?;
        Ok(MultifidelityProgress::new(self.fields(), self.block_length))
    }

    /// Runs one block, in order.
    ///
    /// # Errors
    /// [`Error::SampleFailed`], [`Error::NonFiniteSample`].
    pub fn block(
        &self,
        run: impl Fn(usize, u64) -> Result<f64, Failure>,
        range: ModelRange,
    ) -> Result<ModelBlock, Error> {
        let name = || format!("model {}", range.model);
        let one =
            |realisation: u64| {
                let value = run(range.model, realisation).map_err(|failure| {
                    Error::SampleFailed { model: name(), realisation, message: failure.to_string() }
                })?;
                require_finite_responses(&name(), realisation, &[value])?;
                Ok(value)
            };
        let values = (range.start..range.end).map(one).collect::<Result<_, Error>>()?;
        Ok(ModelBlock { study: self.name.into(), range, values })
    }

    /// Plans further blocks from those that are known; returns whether there are any. Without, the estimate is complete.
    ///
    /// # Errors
    /// [`Error::MissingBlocks`] while planned blocks are missing; [`Error::ForeignBlock`] for the state of another study;
    /// [`Error::NoVariance`], [`Error::OverBudget`]; those of [`begin`](Self::begin).
    pub fn advance(&self, progress: &mut MultifidelityProgress) -> Result<bool, Error> {
        self.check()?;
        progress.require_fields(&self.fields())?;
        progress.require_complete()?;
        if !progress.has_plan() {
            for model in 0..self.costs.len() {
                progress.plan(model, PILOT_START..PILOT_START + self.pilot);
            }
            return Ok(true);
        }
        let (_, chosen) = self.pilot(progress)?;
        let target = match progress.target {
            None => self.tolerance,
            Some(target) => {
                let error = mean_of(&chosen, progress).standard_error().unwrap_or(f64::INFINITY);
                if error <= self.tolerance {
                    return Ok(false);
                }
                // The pilot promised too much: as many more samples as the measured error needs.
                target * (self.tolerance / error).min(MOST_PER_ROUND)
            }
        };
        let numbers = numbers_of_runs(&chosen, target);
        let value = self.cost(&chosen, numbers.iter().copied());
        if value.is_nan() || value > self.budget {
            return Err(Error::OverBudget { value, limit: self.budget });
        }
        let limit = PILOT_START as f64;
        if let Some(&value) = numbers.iter().find(|m| **m > limit) {
            return Err(Error::TooMany { quantity: "runs of a model", value, limit });
        }
        for (chosen, m) in chosen.iter().zip(numbers) {
            #[allow(
                clippy::cast_possible_truncation,
                clippy::cast_sign_loss,
                reason = "a whole number from 4 to 2^40"
            )]
            progress.plan(chosen.model, progress.n_runs(chosen.model)..m as u64);
        }
        progress.target = Some(target);
        Ok(true)
    }

    /// The estimate from the blocks that are known.
    ///
    /// # Errors
    /// [`Error::MissingBlocks`] while planned blocks are missing, or [`advance`](Self::advance) has more to plan;
    /// [`Error::ForeignBlock`] for the state of another study.
    pub fn finish(&self, progress: &MultifidelityProgress) -> Result<MultifidelityResult, Error> {
        if self.advance(&mut progress.clone())? {
            let pair = "the next round".to_owned();
            return Err(Error::MissingBlocks { missing: 1, pair, block: 0 });
        }
        let (pilot, chosen) = self.pilot(progress)?;
        let models = chosen.iter().map(|chosen| ModelReport {
            model: chosen.model,
            n_runs: progress.n_runs(chosen.model),
            coefficient: chosen.coefficient,
            correlation: chosen.correlation,
        });
        let numbers = chosen.iter().map(|chosen| progress.n_runs(chosen.model) as f64);
        Ok(MultifidelityResult {
            mean: mean_of(&chosen, progress),
            models: models.collect(),
            cost: self.cost(&chosen, numbers),
            single_model_cost: pilot.variance(0) / self.tolerance.powi(2) * self.costs[0],
        })
    }

    /// Cost of the pilot and of so many runs of the chosen models.
    fn cost(&self, chosen: &[Chosen], numbers: impl Iterator<Item = f64>) -> f64 {
        let of_runs: f64 =
            numbers.zip(chosen).map(|(m, chosen)| m * self.costs[chosen.model]).sum();
        self.pilot as f64 * self.costs.iter().sum::<f64>() + of_runs
    }

    /// What two studies must share for their blocks to be merged.
    fn fields(&self) -> [(&'static str, String); 5] {
        let costs: Vec<String> = self.costs.iter().map(|cost| format!("{cost:e}")).collect();
        [
            ("name", self.name.to_owned()),
            ("block length", self.block_length.to_string()),
            ("pilot", self.pilot.to_string()),
            ("costs", costs.join(" ")),
            ("tolerance", format!("{:e}", self.tolerance)),
        ]
    }

    fn check(&self) -> Result<(), Error> {
        require_positive("tolerance", 0, self.tolerance)?;
        require_at_least("models", self.costs.len() as u64, 1)?;
        if self.costs.len() > 1 + MOST_SURROGATES {
            let (value, limit) = ((self.costs.len() - 1) as f64, MOST_SURROGATES as f64);
            return Err(Error::TooMany { quantity: "surrogates", value, limit });
        }
        for (index, &cost) in self.costs.iter().enumerate() {
            require_positive("cost of model", index, cost)?;
        }
        require_at_least("samples in the pilot", self.pilot, FEWEST_SAMPLES)?;
        require_at_least("runs in a block", self.block_length, 1)?;
        if self.pilot > PILOT_START {
            let (value, limit) = (self.pilot as f64, PILOT_START as f64);
            return Err(Error::TooMany { quantity: "samples in the pilot", value, limit });
        }
        let value = self.pilot as f64 * self.costs.iter().sum::<f64>();
        if self.budget.is_nan() || value > self.budget {
            return Err(Error::OverBudget { value, limit: self.budget });
        }
        Ok(())
    }

    /// Moments of the pilot, and the models chosen by it.
    fn pilot(&self, progress: &MultifidelityProgress) -> Result<(Comoments, Vec<Chosen>), Error> {
        let columns: Vec<Vec<f64>> =
            (0..self.costs.len()).map(|model| progress.pilot(model)).collect();
        let mut sums = Comoments::new(columns.len());
        let mut row = vec![0.0; columns.len()];
        for k in 0..columns[0].len() {
            row.iter_mut().zip(&columns).for_each(|(entry, column)| *entry = column[k]);
            sums.push(&row);
        }
        let (value, mean) = (sums.variance(0), sums.mean(0));
        let limit = (4.0 * f64::EPSILON * mean).powi(2);
        if value.is_nan() || value <= limit {
            return Err(Error::NoVariance { response: 0, value, limit });
        }
        let chosen = self.choose(&sums);
        Ok((sums, chosen))
    }

    /// The set of models with the lowest cost, in the order of their correlations.
    fn choose(&self, pilot: &Comoments) -> Vec<Chosen> {
        let variance = pilot.variance(0);
        let correlation =
            |model: usize| pilot.covariance(0, model) / (variance * pilot.variance(model)).sqrt();
        let mut surrogates: Vec<(usize, f64)> = (1..self.costs.len())
            .map(|model| (model, correlation(model)))
            .filter(|(_, rho)| rho.is_finite() && *rho != 0.0)
            .collect();
        surrogates.sort_by(|a, b| b.1.abs().total_cmp(&a.1.abs()).then(a.0.cmp(&b.0)));
        let mut best: (f64, Vec<Chosen>) = (f64::INFINITY, Vec::new());
        for set in 0_u32..1 << surrogates.len() {
            let members = surrogates.iter().enumerate().filter(|(k, _)| set >> k & 1 == 1);
            let mut models = vec![(0, 1.0)];
            models.extend(members.map(|(_, surrogate)| *surrogate));
            let root_of = |k: usize| {
                let next = models.get(k + 1).map_or(0.0, |(_, rho)| rho * rho);
                (variance * (models[k].1 * models[k].1 - next).max(0.0)).sqrt()
            };
            let root: f64 =
                (0..models.len()).map(|k| root_of(k) * self.costs[models[k].0].sqrt()).sum();
            let chosen: Vec<Chosen> = (0..models.len())
                .map(|k| {
                    let (model, correlation) = models[k];
                    let coefficient = pilot.covariance(0, model) / pilot.variance(model);
                    let share = root * root_of(k) / self.costs[model].sqrt();
                    Chosen { model, correlation, coefficient, share }
                })
                .collect();
            let increases = chosen.windows(2).all(|pair| pair[0].share < pair[1].share);
            if increases && root * root < best.0 {
                best = (root * root, chosen);
            }
        }
        best.1
    }
}

/// Largest factor between the tolerance and the error that one round of further samples corrects.
const MOST_PER_ROUND: f64 = 0.99;

/// Fewest runs of the truth, and fewest further runs of each surrogate: their variance is estimated.
const FEWEST_RUNS: f64 = 4.0;

fn numbers_of_runs(chosen: &[Chosen], tolerance: f64) -> Vec<f64> {
    let mut before = 0.0;
    let of = |chosen: &Chosen| {
        let needed = (chosen.share / (tolerance * tolerance)).ceil();
        before = if needed > before + FEWEST_RUNS { needed } else { before + FEWEST_RUNS };
        before
    };
    chosen.iter().map(of).collect()
}

/// The estimate from all runs that are known.
fn mean_of(chosen: &[Chosen], progress: &MultifidelityProgress) -> Estimate {
    let values: Vec<Vec<f64>> =
        chosen.iter().map(|chosen| progress.responses(chosen.model)).collect();
    estimate(chosen, &values)
}

/// The estimate: in each range of samples that the same models have run, the mean of their weighted responses.
fn estimate(chosen: &[Chosen], values: &[Vec<f64>]) -> Estimate {
    let (mut mean, mut squared_error) = (0.0, 0.0);
    let mut start = 0;
    for first in 0..chosen.len() {
        let end = values[first].len();
        // Weight of a response of each model that has run there.
        let weights: Vec<f64> = (first..chosen.len())
            .map(|k| {
                let own = 1.0 / values[k].len() as f64;
                let before = if k > first { 1.0 / values[k - 1].len() as f64 } else { 0.0 };
                chosen[k].coefficient * (own - before)
            })
            .collect();
        let mut sums = Comoments::new(1);
        for sample in start..end {
            let terms = weights.iter().zip(&values[first..]);
            sums.push(&[terms.map(|(weight, values)| weight * values[sample]).sum()]);
        }
        let n = sums.count() as f64;
        mean += n * sums.mean(0);
        squared_error += n * sums.variance(0);
        start = end;
    }
    with_error(mean, squared_error.sqrt())
}
