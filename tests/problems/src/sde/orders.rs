//! The order harness: every method of a table on the same paths, at every step length, against one reference.
//!
//! A path is drawn once at the finest step; coarser steps see sums of it ([`Increment::from_halves`]). Strong and weak
//! errors are differences to the reference on the same path, so that their sampling noise is small; the error of a
//! slope is that of the jackknife over batches of paths, together with the scatter about the line.

use rayon::prelude::*;
use result_figures::Measured;
use sde_integrators::{Increment, Noise, StepError};

use super::methods::Method;
use crate::context::CaseError;
use crate::order::{self, MIN_LEVELS};

/// Batches of the jackknife.
const BATCHES: u64 = 32;

/// What is measured.
#[derive(Debug, Clone, Copy)]
pub struct Study {
    /// Number of paths, shared evenly by 32 batches.
    pub n_paths: u64,
    /// All noise follows from it.
    pub seed: u64,
    /// The end of the paths; they start at 0.
    pub end: f64,
    /// Steps of the coarsest level; each level doubles them.
    pub coarsest: usize,
    /// How many levels.
    pub n_levels: usize,
    /// How many times the finest level is halved for the reference.
    pub refinements: u32,
}

impl Study {
    fn steps(&self, level: usize) -> usize {
        self.coarsest << level
    }

    fn finest(&self) -> usize {
        self.steps(self.n_levels - 1) << self.refinements
    }
}

/// The state at the end that a path should reach.
pub type Target<'a, const D: usize, const M: usize> =
    dyn Fn(f64, &[Increment<M>]) -> Result<[f64; D], CaseError> + Sync + 'a;

/// An error at a step length.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Level {
    /// The step length.
    pub dt: f64,
    /// The error; a weak one has a sign.
    pub error: Measured,
}

/// The errors of one method on one problem.
#[derive(Debug, Clone)]
pub struct Errors {
    /// Coarsest first.
    pub levels: Vec<Level>,
    /// The order fitted to the errors above their noise, if there are four.
    pub order: Option<Measured>,
}

/// What came of one method.
#[derive(Debug, Clone)]
pub struct Outcome {
    /// `sqrt(E |X_h - X|^2)` at the end.
    pub strong: Errors,
    /// `E(phi(X_h) - phi(X))` at the end, per observable.
    pub weak: Vec<Errors>,
    /// Per level, what the paths met that could not be followed to the end. The errors of such a level are no numbers.
    pub failures: Vec<Option<Failure>>,
}

/// Paths that a method could not follow to the end at one step length.
#[derive(Debug, Clone)]
pub struct Failure {
    /// How many.
    pub n_paths: u64,
    /// The first of them.
    pub first: u64,
    /// What it said.
    pub error: StepError,
}

/// What came of a study.
#[derive(Debug, Clone)]
pub struct Outcomes {
    /// Method by method.
    pub methods: Vec<Outcome>,
    /// `E phi(X)` of the reference, per observable.
    pub reference: Vec<Measured>,
}

/// Sums over the paths of a batch: per method and level, the squared distance and the differences of the observables;
/// and the observables of the reference.
#[derive(Debug, Clone)]
struct Sums {
    strong: Vec<f64>,
    weak: Vec<Vec<f64>>,
    reference: Vec<f64>,
    failures: Vec<Option<Failure>>,
}

impl Sums {
    /// A level without one of its paths is no result: its sums are no numbers from here on.
    fn fail(&mut self, cell: usize, path: u64, error: StepError) {
        self.strong[cell] = f64::NAN;
        self.weak.iter_mut().for_each(|weak| weak[cell] = f64::NAN);
        self.failures[cell].get_or_insert(Failure { n_paths: 0, first: path, error }).n_paths += 1;
    }
}

/// Runs every method on every path.
///
/// # Errors
/// Of a method that could not take a step, or of the reference.
pub fn measure<S, const D: usize, const M: usize>(
    study: &Study,
    problem: (&S, [f64; D]),
    methods: &[Method<S, D, M>],
    target: &Target<'_, D, M>,
    observables: &[fn(&[f64; D]) -> f64],
) -> Result<Outcomes, CaseError>
where
    S: Sync,
{
    let outcomes = attempt(study, problem, methods, target, observables)?;
    match outcomes.methods.iter().flat_map(|outcome| &outcome.failures).flatten().next() {
        Some(failure) => Err(failure.error.clone().into()),
        None => Ok(outcomes),
    }
}

/// The same, where a method that cannot take a step spoils its level and no other.
pub fn attempt<S, const D: usize, const M: usize>(
    study: &Study,
    (system, start): (&S, [f64; D]),
    methods: &[Method<S, D, M>],
    target: &Target<'_, D, M>,
    observables: &[fn(&[f64; D]) -> f64],
) -> Result<Outcomes, CaseError>
where
    S: Sync,
{
    let n_cells = methods.len() * study.n_levels;
    let batch = |batch: u64| -> Result<Sums, CaseError> {
        let empty = vec![0.0; n_cells];
        let n = observables.len();
        let mut sums = Sums {
            strong: empty.clone(),
            weak: vec![empty; n],
            reference: vec![0.0; n],
            failures: vec![None; n_cells],
        };
        let per_batch = study.n_paths / BATCHES;
        for path in batch * per_batch..(batch + 1) * per_batch {
            one_path(study, (system, start), methods, target, observables, path, &mut sums)?;
        }
        Ok(sums)
    };
    let batches: Vec<Sums> = (0..BATCHES).into_par_iter().map(batch).collect::<Result<_, _>>()?;
    let n_observables = observables.len();
    let mean = |phi: usize| {
        let means: Vec<Vec<f64>> = batches
            .iter()
            .map(|sums| vec![sums.reference[phi] / (study.n_paths / BATCHES) as f64])
            .collect();
        errors(&[study.end], &means, |mean| mean).levels[0].error
    };
    Ok(Outcomes {
        methods: (0..methods.len()).map(|k| outcome(study, &batches, k, n_observables)).collect(),
        reference: (0..n_observables).map(mean).collect(),
    })
}

fn one_path<S, const D: usize, const M: usize>(
    study: &Study,
    (system, start): (&S, [f64; D]),
    methods: &[Method<S, D, M>],
    target: &Target<'_, D, M>,
    observables: &[fn(&[f64; D]) -> f64],
    path: u64,
    sums: &mut Sums,
) -> Result<(), CaseError> {
    let mut noise = Noise::new(study.seed).path::<M>(path);
    let finest_dt = study.end / study.finest() as f64;
    let mut increments: Vec<_> =
        (0..study.finest()).map(|_| noise.next_increment(finest_dt)).collect();
    let expected = target(finest_dt, &increments)?;
    for (sum, phi) in sums.reference.iter_mut().zip(observables) {
        *sum += phi(&expected);
    }
    for _ in 0..study.refinements {
        increments = halved(&increments);
    }
    for level in (0..study.n_levels).rev() {
        let dt = study.end / increments.len() as f64;
        for (k, method) in methods.iter().enumerate() {
            let cell = k * study.n_levels + level;
            let x = match (method.run)(system, start, dt, &increments) {
                Ok(x) => x,
                Err(error) => {
                    sums.fail(cell, path, error);
                    continue;
                }
            };
            sums.strong[cell] +=
                x.iter().zip(&expected).map(|(a, b)| (a - b) * (a - b)).sum::<f64>();
            for (weak, phi) in sums.weak.iter_mut().zip(observables) {
                weak[cell] += phi(&x) - phi(&expected);
            }
        }
        increments = halved(&increments);
    }
    Ok(())
}

/// The same path in steps of twice the length.
#[must_use]
pub fn halved<const M: usize>(increments: &[Increment<M>]) -> Vec<Increment<M>> {
    increments.chunks_exact(2).map(|pair| Increment::from_halves(&pair[0], &pair[1])).collect()
}

fn outcome(study: &Study, batches: &[Sums], method: usize, n_observables: usize) -> Outcome {
    let paths = (study.n_paths / BATCHES) as f64;
    let cells = method * study.n_levels..(method + 1) * study.n_levels;
    let per_batch = |of: &dyn Fn(&Sums) -> &[f64]| -> Vec<Vec<f64>> {
        batches
            .iter()
            .map(|sums| of(sums)[cells.clone()].iter().map(|sum| sum / paths).collect())
            .collect()
    };
    let steps: Vec<f64> =
        (0..study.n_levels).map(|level| study.end / study.steps(level) as f64).collect();
    Outcome {
        strong: errors(&steps, &per_batch(&|sums| &sums.strong), f64::sqrt),
        weak: (0..n_observables)
            .map(|phi| errors(&steps, &per_batch(&|sums| &sums.weak[phi]), |mean| mean))
            .collect(),
        failures: cells.clone().map(|cell| failure(batches, cell)).collect(),
    }
}

/// The failures of all batches at one level of a method.
fn failure(batches: &[Sums], cell: usize) -> Option<Failure> {
    let mut failures = batches.iter().filter_map(|sums| sums.failures[cell].as_ref());
    let first = failures.next()?.clone();
    let n_paths = first.n_paths + failures.map(|failure| failure.n_paths).sum::<u64>();
    Some(Failure { n_paths, ..first })
}

/// Errors and their slope from means per batch and level; `of` makes an error of a mean.
fn errors(steps: &[f64], batches: &[Vec<f64>], of: impl Fn(f64) -> f64) -> Errors {
    let n = batches.len() as f64;
    let total = |level: usize| batches.iter().map(|batch| batch[level]).sum::<f64>();
    // The error without batch b, whose spread is what the jackknife asks for.
    let without = |level: usize, b: usize| of((total(level) - batches[b][level]) / (n - 1.0));
    let spread = |values: &[f64]| {
        let mean = values.iter().sum::<f64>() / n;
        ((n - 1.0) / n * values.iter().map(|v| (v - mean) * (v - mean)).sum::<f64>()).sqrt()
    };
    let levels: Vec<Level> = steps
        .iter()
        .enumerate()
        .map(|(level, &dt)| {
            let left: Vec<f64> = (0..batches.len()).map(|b| without(level, b)).collect();
            Level { dt, error: Measured::sampled(of(total(level) / n), spread(&left)) }
        })
        .collect();
    // A level whose noise is a quarter of its error or more says nothing about a slope.
    let usable: Vec<usize> = (0..steps.len())
        .filter(|&k| {
            let Measured { value, standard_error } = levels[k].error;
            4.0 * standard_error.unwrap_or(0.0) < value.abs()
        })
        .collect();
    let positive = |&k: &usize| levels[k].error.value > 0.0;
    let one_sided = usable.iter().all(positive) || !usable.iter().any(positive);
    let slope = |error: &dyn Fn(usize) -> f64| {
        let points: Vec<(f64, f64)> = usable.iter().map(|&k| (steps[k], error(k))).collect();
        order::fit(&points).ok()
    };
    let order = (usable.len() >= MIN_LEVELS && one_sided)
        .then(|| {
            let fitted = slope(&|k| levels[k].error.value)?;
            let left: Option<Vec<f64>> =
                (0..batches.len()).map(|b| Some(slope(&|k| without(k, b))?.value)).collect();
            let scatter = fitted.standard_error.unwrap_or(0.0);
            Some(Measured::sampled(fitted.value, spread(&left?).hypot(scatter)))
        })
        .flatten();
    Errors { levels, order }
}

#[cfg(test)]
mod tests {
    use sde_integrators::EulerMaruyama;

    use super::*;
    use crate::sde::methods::{follow, method};
    use crate::sde::problems::Sine;

    #[test]
    fn a_slope_carries_the_noise_of_its_batches() {
        let steps = [0.4, 0.2, 0.1, 0.05];
        let batch = |b: i32| {
            let tilt = 1.0 + 0.02 * f64::from(b % 5 - 2);
            steps.iter().map(|h| tilt * h * h).collect::<Vec<f64>>()
        };
        let batches: Vec<_> = (0..32).map(batch).collect();
        let errors = errors(&steps, &batches, |mean| mean);
        // A common factor moves all levels alike: no error of the slope.
        let order = errors.order.unwrap();
        assert!((order.value - 2.0).abs() < 1e-12 && order.standard_error.unwrap() < 1e-12);
        assert!(errors.levels[0].error.standard_error.unwrap() > 1e-4);
    }

    #[test]
    fn errors_below_their_noise_and_changes_of_sign_give_no_slope() {
        let steps = [0.4, 0.2, 0.1, 0.05];
        let noisy: Vec<Vec<f64>> =
            (0..32).map(|b| vec![if b % 2 == 0 { 1.0 } else { -0.9 }; 4]).collect();
        assert!(errors(&steps, &noisy, |mean| mean).order.is_none());
        let turning: Vec<Vec<f64>> = (0..32).map(|_| vec![1.0, 0.5, 0.2, -0.1]).collect();
        assert!(errors(&steps, &turning, |mean| mean).order.is_none());
    }

    /// Euler's method, and the same that refuses steps of a quarter whose first motion is upwards.
    #[test]
    fn a_path_that_fails_spoils_its_level_alone_and_is_an_error_where_none_may() {
        let euler = || method("euler-maruyama", "Euler-Maruyama", EulerMaruyama, [1.0; 3]);
        let run = |system: &Sine, start, dt: f64, increments: &[Increment<1>]| {
            if dt > 0.2 && increments[0].brownian[0] > 0.0 {
                return Err(StepError::StepTooLong { dt, limit: 0.2 });
            }
            follow(system, &EulerMaruyama, start, dt, increments)
        };
        let fails: Method<Sine, 1, 1> = Method { id: "fails", run: Box::new(run), ..euler() };
        let study =
            Study { n_paths: 64, seed: 3, end: 1.0, coarsest: 4, n_levels: 3, refinements: 1 };
        let start = [1.0];
        let target = |dt: f64, increments: &[Increment<1>]| {
            Ok(follow(&Sine, &EulerMaruyama, start, dt, increments)?)
        };
        let methods = [euler(), fails];
        let outcomes = attempt(&study, (&Sine, start), &methods, &target, &[|x| x[0]]).unwrap();
        let [whole, part] = [&outcomes.methods[0], &outcomes.methods[1]];
        assert!(whole.failures.iter().all(Option::is_none));
        let failure = part.failures[0].as_ref().unwrap();
        assert!((16..48).contains(&failure.n_paths) && failure.first < 8, "{failure:?}");
        assert!(part.failures[1..].iter().all(Option::is_none));
        for [whole, part] in [[&whole.strong, &part.strong], [&whole.weak[0], &part.weak[0]]] {
            assert!(part.levels[0].error.value.is_nan());
            assert_eq!(whole.levels[1..], part.levels[1..]);
        }
        let refused = measure(&study, (&Sine, start), &methods, &target, &[]).unwrap_err();
        assert_eq!(refused.to_string(), "step length 0.25 exceeds its limit 0.2");
    }
}
