//! The whole surface `P(|q| > T)` over time and threshold by each method: one question with many answers.
//!
//! Its error is the worst of all cells of the surface, the one that a user who reads any of them may meet.

use fpk_sph::Config;
use random_vibration::{
    ExceedanceQuestion, GridConfig, GridDensity, GuidedConfig, GuidedPaths, Linearisation,
    SubsetConfig, TailError, TailPaths, Tails,
};
use scenes::fpk::density::{self, Asked, Demand, Erased};
use scenes::fpk::monte_carlo::{self, Sampling};
use scenes::fpk::paths::Paths;
use sde_integrators::{Additive, Estimate, Integrator, Sde};

use super::records::{Outcome, Quantity, Record};
use super::runs::{GRIDS, LONG, Ladder, SUBSET_RUNS, Setting, guide_rule, rungs};
use crate::charts::fpk::{group_thousands_u64, timed};
use crate::problems::exceedance_surface::{ExceedanceSurface, SMALLEST};
use reference_problems::context::{CaseError, Context};

/// Name of the quantity.
const SURFACE: &str = "surface";

/// A surface of a setting.
pub(super) struct SurfaceOf<'a, S, I, const D: usize> {
    pub(super) setting: &'a Setting<'a, S, I, D>,
    pub(super) surface: ExceedanceSurface,
    /// Steps of a path from one time to the next.
    pub(super) steps_each: usize,
}

/// What a method found.
enum Found {
    /// Per time and threshold.
    Values(Vec<Vec<f64>>),
    /// Per time and threshold, each with its standard error.
    Estimates(Vec<Vec<Estimate>>),
}

impl<S, I, const D: usize> SurfaceOf<'_, S, I, D> {
    /// The quantity.
    pub(super) fn quantity(&self) -> Quantity {
        let ExceedanceSurface { times, thresholds, .. } = &self.surface;
        Quantity {
            name: SURFACE,
            title: format!(
                "Surface P(|q| > T) at {} times and {} thresholds: the worst of its {} cells above {SMALLEST:.0e}",
                times.len(),
                thresholds.len(),
                self.surface.cells().count()
            ),
            reference_error: self.surface.relative_error(),
        }
    }

    fn asked(&self, cells: bool) -> Asked<D> {
        Asked {
            times: self.surface.times.clone(),
            powers: Vec::new(),
            demand: Demand::of_state(0, "q", D),
            thresholds: self.surface.thresholds.clone(),
            cells,
        }
    }

    /// Numbers of steps to the times.
    fn n_steps(&self) -> Vec<usize> {
        (1..=self.surface.times.len()).map(|k| k * self.steps_each).collect()
    }

    /// Last time and its number of steps.
    fn span(&self) -> (f64, usize) {
        let last = self.surface.times.last().copied().unwrap_or_default();
        (last, self.surface.times.len() * self.steps_each)
    }

    /// The worst cell.
    fn worst(&self, found: &Found) -> Outcome {
        let (mut off, mut predicted) = (0.0_f64, 0.0_f64);
        for ((time, threshold), reference) in self.surface.cells() {
            let (value, error) = match found {
                Found::Values(rows) => (rows[time][threshold], 0.0),
                Found::Estimates(rows) => {
                    let estimate = rows[time][threshold];
                    (estimate.value, estimate.standard_error().unwrap_or(f64::INFINITY))
                }
            };
            let relative = (value / reference.value - 1.0).abs();
            // A value that is no number is as wrong as can be.
            off = if relative.is_nan() { f64::INFINITY } else { off.max(relative) };
            predicted = predicted.max(error / reference.value);
        }
        match found {
            Found::Values(_) if off.is_finite() => Outcome::Off { error: off },
            Found::Estimates(_) if predicted.is_finite() => {
                Outcome::Sampled { predicted, uncertainty: None, seen: Some(off) }
            }
            _ => Outcome::Nothing { reason: "a cell without a value or an error".into() },
        }
    }

    /// Runs a method; an error that says why it cannot answer is a result.
    fn record(
        &self,
        context: &Context<'_>,
        (method, label): (&str, &str),
        mut run: impl FnMut() -> Result<Result<Found, String>, CaseError>,
    ) -> Result<Record, CaseError> {
        let (found, cpu_seconds, cpu_spread) = timed(LONG, &mut run)?;
        context.progress(&format!(
            "{}: surface by {method}, {label}, {cpu_seconds:.2} s",
            self.setting.name
        ));
        let outcome = match found {
            Ok(found) => self.worst(&found),
            Err(reason) => Outcome::Nothing { reason },
        };
        let (quantity, method, label) = (SURFACE.into(), method.into(), label.into());
        Ok(Record { quantity, method, label, cpu_seconds, cpu_spread, outcome })
    }

    /// The density solver on successively finer lattices: one run observed at all times.
    pub(super) fn with_particles(
        &self,
        context: &Context<'_>,
        ladders: &[Ladder<D>],
    ) -> Result<Vec<Record>, CaseError>
    where
        S: Sde<D, 1, Noise = Additive>,
    {
        let (setting, asked) = (self.setting, self.asked(true));
        let mut records = Vec::new();
        for &Ladder { name, method, ref lattices } in ladders {
            for lattice in rungs(context, lattices) {
                let (reference_period, most_steps) = (setting.period, fpk_sph::DEFAULT_MOST_STEPS);
                let config = Config { method, lattice, reference_period, most_steps };
                let mut n_particles = 0;
                let mut record = self.record(context, (name, "particles"), || {
                    let system: Erased<'_, Additive, D, 1> = Erased(setting.system);
                    let run = density::run_on(system, setting.law, &config, &asked, |_, _| ())?;
                    n_particles = run.n_particles;
                    if let Some(stopped) = run.stopped {
                        return Ok(Err(stopped.to_string()));
                    }
                    let of_row = |row: &density::Row| -> Vec<f64> {
                        let value = |p: &density::Exceedances| {
                            p.cell_integrated.unwrap_or(p.log_interpolated)
                        };
                        row.exceedances.iter().map(value).collect()
                    };
                    Ok(Ok(Found::Values(run.rows.iter().map(of_row).collect())))
                })?;
                record.label = group_thousands_u64(n_particles as u64);
                records.push(record);
            }
        }
        Ok(records)
    }

    /// Statistical linearisation: one run, with the tails of its normal distributions.
    pub(super) fn linearised(
        &self,
        context: &Context<'_>,
        rule: &Linearisation<D>,
    ) -> Result<Record, CaseError>
    where
        S: Sde<D, 1, Noise = Additive>,
    {
        let ExceedanceSurface { times, thresholds, .. } = &self.surface;
        let displacement = std::array::from_fn(|i| f64::from(u8::from(i == 0)));
        self.record(context, ("statistical linearisation", ""), || {
            let laws = rule.laws(self.setting.system, self.setting.law, times)?;
            let row = |law: &random_vibration::GaussianLaw<D>| -> Vec<f64> {
                thresholds.iter().map(|t| law.exceedance(&displacement, *t)).collect()
            };
            Ok(Ok(Found::Values(laws.iter().map(row).collect())))
        })
    }

    /// Monte Carlo, guided paths and subset simulation.
    pub(super) fn sampled(
        &self,
        context: &Context<'_>,
        rule: &Linearisation<D>,
    ) -> Result<Vec<Record>, CaseError>
    where
        S: Paths<D, 1> + Sde<D, 1, Noise = Additive>,
        I: Integrator<S, D, 1>,
    {
        let mut records = Vec::new();
        for paths in rungs(context, &[10_000_u64, 100_000, 1_000_000]) {
            records.push(self.plain(context, paths)?);
        }
        for samples in rungs(context, &[500_u64, 2_000, 20_000, 100_000]) {
            let label = group_thousands_u64(samples);
            let run = || self.guided(rule, samples);
            records.push(self.record(context, ("guided paths", &label), run)?);
        }
        let n_samples = 200;
        let config = SubsetConfig { n_samples, correlation: 0.8, n_runs: SUBSET_RUNS };
        let label = format!("{SUBSET_RUNS} x {n_samples}");
        let one = |paths: &TailPaths<'_, D>, threshold: f64| {
            paths.subset(threshold, &config, n_samples as u64)
        };
        records
            .push(self.record(context, ("subset simulation", &label), || self.one_by_one(&one))?);
        Ok(records)
    }

    /// One run of free paths, observed at all times. The standard error is that of the binomial distribution.
    fn plain(&self, context: &Context<'_>, paths: u64) -> Result<Record, CaseError>
    where
        S: Paths<D, 1>,
    {
        let setting = self.setting;
        let (until, n_steps) = self.span();
        let sampling = Sampling { paths, step: until / n_steps as f64, seed: paths };
        let asked = self.asked(false);
        let method = format!("Monte Carlo, {}", S::INTEGRATOR.name());
        let label = group_thousands_u64(paths);
        let mut record = self.record(context, (&method, &label), || {
            let run = monte_carlo::run_on(setting.system, setting.law, &sampling, &asked)?;
            let values = |row: &monte_carlo::SampledRow| -> Vec<f64> {
                row.exceedances.iter().map(|estimate| estimate.value).collect()
            };
            Ok(Ok(Found::Values(run.rows.iter().map(values).collect())))
        })?;
        let smallest = self.surface.cells().map(|(_, p)| p.value).fold(1.0, f64::min);
        let expected = smallest * paths as f64;
        record.outcome = match record.outcome {
            Outcome::Off { error } if expected >= 1.0 => Outcome::Sampled {
                predicted: ((1.0 - smallest) / expected).sqrt(),
                uncertainty: None,
                seen: Some(error),
            },
            _ => Outcome::Nothing { reason: format!("{expected:.0e} paths expected beyond it") },
        };
        Ok(record)
    }

    /// Guided paths: a set for each time, which serves all thresholds.
    fn guided(
        &self,
        rule: &Linearisation<D>,
        samples: u64,
    ) -> Result<Result<Found, String>, CaseError>
    where
        S: Sde<D, 1, Noise = Additive>,
        I: Integrator<S, D, 1>,
    {
        let Setting { system, integrator, law, period, .. } = *self.setting;
        let rule = guide_rule(rule, period);
        let paths = GuidedPaths::new(system, integrator, law, self.span(), &rule)?;
        let config = GuidedConfig {
            n_paths: samples,
            n_pilots: (samples / 4).clamp(200, 1_000),
            unguided: 0.05,
            seed: samples,
        };
        let question = ExceedanceQuestion {
            thresholds: &self.surface.thresholds,
            n_steps: &self.n_steps(),
            tails: Tails::Doubled,
            smallest: SMALLEST,
        };
        let found = paths.exceedances(&question, &config)?;
        let mut rows: Vec<Vec<Estimate>> = Vec::new();
        for (time, row) in found.into_iter().enumerate() {
            let mut estimates = Vec::new();
            for (threshold, found) in row.into_iter().enumerate() {
                let counts = self.surface.cells().any(|(cell, _)| cell == (time, threshold));
                match found {
                    Ok(found) => estimates.push(found.estimate),
                    Err(error) if counts => return Ok(Err(error.to_string())),
                    // Below the smallest probability of interest.
                    Err(_) => estimates.push(Estimate::probability(0, samples)?),
                }
            }
            rows.push(estimates);
        }
        Ok(Ok(Found::Estimates(rows)))
    }

    /// A method that estimates one probability at a time, for the cells that count alone.
    fn one_by_one(
        &self,
        one: &dyn Fn(&TailPaths<'_, D>, f64) -> Result<Estimate, TailError>,
    ) -> Result<Result<Found, String>, CaseError>
    where
        S: Sync,
        I: Integrator<S, D, 1>,
    {
        let Setting { system, integrator, law, .. } = *self.setting;
        let ExceedanceSurface { times, thresholds, .. } = &self.surface;
        let nothing = Estimate::probability(0, 1)?;
        let mut rows = vec![vec![nothing; thresholds.len()]; times.len()];
        for (time, n_steps) in self.n_steps().into_iter().enumerate() {
            let paths = TailPaths::new::<_, _, 1>(system, integrator, law, (times[time], n_steps))?;
            for ((_, threshold), _) in self.surface.cells().filter(|((at, _), _)| *at == time) {
                match one(&paths, thresholds[threshold]) {
                    Ok(estimate) => rows[time][threshold] = estimate,
                    Err(error) => return Ok(Err(error.to_string())),
                }
            }
        }
        Ok(Ok(Found::Estimates(rows)))
    }
}

impl<S, I> SurfaceOf<'_, S, I, 2>
where
    S: Sde<2, 1, Noise = Additive>,
{
    /// The grid: one run observed at all times.
    pub(super) fn on_grid(&self, context: &Context<'_>) -> Result<Vec<Record>, CaseError> {
        let mut records = Vec::new();
        let ExceedanceSurface { times, thresholds, .. } = &self.surface;
        for (cells, steps_per_period) in rungs(context, &GRIDS) {
            let period = self.setting.period;
            let config = GridConfig { cells, reach: 8.0, period, steps_per_period };
            let label = format!("{cells}²");
            records.push(self.record(context, ("grid", &label), || {
                let mut density = GridDensity::new(self.setting.system, self.setting.law, config)?;
                let mut rows = Vec::new();
                for &t in times {
                    density.advance_to(t)?;
                    rows.push(thresholds.iter().map(|t| density.exceedance(*t)).collect());
                }
                Ok(Ok(Found::Values(rows)))
            })?);
        }
        Ok(records)
    }
}
