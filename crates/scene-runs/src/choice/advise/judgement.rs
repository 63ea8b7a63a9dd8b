//! Best value of each quantity from all trials, and the error of each trial.

use super::curve::{Curve, Point};
use crate::answers::{Answer, Statistic};
use crate::ladder::{Growth, Ladder, Standing, Trial};

/// Result of all trials for a quantity.
#[derive(Debug, Clone, PartialEq)]
pub struct Judgement {
    /// Id, e.g. `moment/2-0`.
    pub id: String,
    /// Description.
    pub words: String,
    /// What of a random quantity it is.
    pub statistic: Statistic,
    /// Value of the most accurate trial.
    pub value: f64,
    /// Error of that value.
    pub error: f64,
    /// Scale of the errors.
    pub scale: f64,
    /// Index of the most accurate trial.
    pub best: usize,
    /// Errors over `scale`, and costs, of each method of the ladder.
    pub curves: Vec<Curve>,
}

impl Judgement {
    /// Error of a trial over the scale; none where the trial has no value of the quantity.
    #[must_use]
    pub fn error_of(&self, trial: &Trial) -> Option<f64> {
        let points = &self.curves.get(trial.method)?.points;
        let is_its = |point: &&Point| point.size.total_cmp(&trial.rung.size).is_eq();
        points.iter().find(is_its).map(Point::error)
    }
}

/// Result of a trial for a quantity.
struct TrialValue<'t> {
    trial: usize,
    method: usize,
    size: f64,
    cost: f64,
    answer: &'t Answer,
    /// Its error; none where the run gives no estimate.
    error: Option<f64>,
}

impl TrialValue<'_> {
    const fn value(&self) -> f64 {
        self.answer.last.number.value
    }
}

/// Compares the trials of all methods; `None` if no trial has an error estimate.
///
/// A run's own estimate is accepted with two exceptions. From one lattice to the next an error decreases at most by
/// the fourth power; a smaller estimate is an error that happens to cross zero. A value that deviates from a judge by
/// more than twice the judge's error, four standard errors, has an error of at least that deviation. The factor is two
/// because each judge is compared for every quantity, and two standard errors are exceeded once in twenty comparisons.
#[must_use]
pub fn judge(ladder: &Ladder, trials: &[Trial], id: &str) -> Option<Judgement> {
    let mut words = words(trials, id);
    for method in 0..ladder.methods.len() {
        if matches!(ladder.methods[method].growth, Growth::Lattice { .. }) {
            no_faster_than(&mut words, method);
        }
    }
    raise_by_judges(ladder, &mut words);
    let known = words.iter().filter(|word| may_be_best(ladder, word.method));
    let known = known.filter_map(|word| Some((word, word.error?)));
    let (best, error) = known.min_by(|a, b| a.1.total_cmp(&b.1))?;
    let (name, value) = (&best.answer.words, best.value());
    // Scale of the most accurate trial: an inaccurate one has the wrong scale too.
    let scale = best.answer.scale;
    let curve = |method: usize| {
        let of_method = words.iter().filter(|word| word.method == method);
        let points = of_method.map(|word| {
            let off = (word.value() - value).abs();
            let (own, excess) = match word.error {
                Some(own) => (own, (off - error - own).max(0.0)),
                None => (0.0, off + error),
            };
            let relative = |of: f64| if scale > 0.0 { of / scale } else { f64::INFINITY };
            Point { size: word.size, cost: word.cost, own: relative(own), excess: relative(excess) }
        });
        Curve { growth: ladder.methods[method].growth, points: points.collect() }
    };
    let curves = (0..ladder.methods.len()).map(curve).collect();
    let (id, words) = (id.to_owned(), name.clone());
    let statistic = best.answer.statistic;
    Some(Judgement { id, words, statistic, value, error, scale, best: best.trial, curves })
}

/// Whether a method may be the most accurate.
///
/// A method with a bias in its samples, such as forward Euler, estimates only its scatter.
fn may_be_best(ladder: &Ladder, method: usize) -> bool {
    let method = &ladder.methods[method];
    method.growth != Growth::Samples || method.standing == Standing::Judge
}

fn words<'t>(trials: &'t [Trial], id: &str) -> Vec<TrialValue<'t>> {
    let word = |(place, trial): (usize, &'t Trial)| {
        let answers = trial.answers()?;
        let answer = answers.get(id)?;
        Some(TrialValue {
            trial: place,
            method: trial.method,
            size: trial.rung.size,
            cost: answers.cpu_seconds,
            answer,
            error: answer.margin(),
        })
    };
    let mut words: Vec<TrialValue<'_>> = trials.iter().enumerate().filter_map(word).collect();
    words.sort_by(|a, b| a.size.total_cmp(&b.size));
    words
}

/// Largest order with which an error may decrease from one lattice to the next.
///
/// Observed: 3 to 5 where a lattice begins to resolve a density, and 2 beyond.
const FASTEST: f64 = 4.0;

fn no_faster_than(words: &mut [TrialValue<'_>], method: usize) {
    let mut coarser: Option<(f64, f64)> = None;
    for word in words.iter_mut().filter(|word| word.method == method) {
        let Some(error) = &mut word.error else { continue };
        let own = *error;
        if let Some((coarse, size)) = coarser {
            *error = own.max(coarse * (size / word.size).powf(FASTEST));
        }
        coarser = Some((own, word.size));
    }
}

/// Raises errors on a lattice to their deviations from the largest ensembles of the judges.
fn raise_by_judges(ladder: &Ladder, words: &mut [TrialValue<'_>]) {
    let standing = |method: usize| ladder.methods[method].standing;
    let largest = |method: usize| {
        // Results are in the order of their sizes.
        let word = words.iter().rev().find(|word| word.method == method)?;
        Some((word.value(), word.error?))
    };
    let judges = (0..ladder.methods.len()).filter(|&method| standing(method) == Standing::Judge);
    let judges: Vec<(f64, f64)> = judges.filter_map(largest).collect();
    for word in words.iter_mut().filter(|word| standing(word.method) == Standing::Judged) {
        if ladder.methods[word.method].growth == Growth::Samples {
            // Its own estimate covers only scatter.
            continue;
        }
        let own = word.value();
        let Some(error) = &mut word.error else { continue };
        for (value, judges_error) in &judges {
            *error = error.max((own - value).abs() - 2.0 * judges_error);
        }
    }
}

#[cfg(test)]
mod tests {
    use serde_json::Map;

    use super::*;
    use crate::answers::{AnswerValue, Answers, ErrorOrigin, Number};
    use crate::ladder::{Method, Outcome, Rung};

    fn method(growth: Growth) -> Method {
        let standing = if growth == Growth::Samples { Standing::Judge } else { Standing::Judged };
        Method { name: String::new(), growth, standing, first: 1.0, rung: Box::new(|_| None) }
    }

    fn ladder() -> Ladder {
        let lattice = || method(Growth::Lattice { dimensions: 2 });
        let methods = vec![lattice(), lattice(), method(Growth::Samples)];
        Ladder { methods, left_out: "" }
    }

    fn trial(method: usize, size: f64, value: f64, error: Option<f64>) -> Trial {
        let none = Map::new();
        let rung = Rung::new((size, String::new()), &none, &none, &[]).unwrap();
        let error_kind = ErrorOrigin::TwoResolutions;
        let last = AnswerValue::of(Number { value, error, error_kind });
        let answer = Answer::new("a".into(), "a".into(), Statistic::Mean, last);
        let answers = Answers { cpu_seconds: size, list: vec![answer] };
        Trial { method, rung, outcome: Outcome::Answered(answers) }
    }

    #[test]
    fn an_error_that_crosses_zero_is_not_believed() {
        let trials = [
            trial(0, 10.0, 1.1, Some(0.1)),
            trial(0, 20.0, 1.0, Some(1e-9)),
            trial(1, 10.0, 1.01, Some(0.02)),
        ];
        let judged = judge(&ladder(), &trials, "a").unwrap();
        assert_eq!(judged.best, 1);
        assert!((judged.curves[0].points[1].own * judged.scale - 0.1 / 16.0).abs() < 1e-12);
    }

    #[test]
    fn a_method_that_sampling_contradicts_is_wrong_by_as_much() {
        // Two trials of one method agree, and both err by a fifth.
        let trials = [
            trial(0, 20.0, 1.2, Some(1e-6)),
            trial(1, 20.0, 1.004, Some(0.004)),
            trial(2, 1000.0, 1.0, Some(0.01)),
        ];
        let judged = judge(&ladder(), &trials, "a").unwrap();
        assert_eq!(judged.best, 1);
        let wrong = judged.curves[0].points[0];
        let error = (wrong.own + wrong.excess) * judged.scale;
        assert!((error - 0.192).abs() < 1e-9, "{error}");
        let sampled = judged.curves[2].points[0];
        assert!(sampled.excess.abs() < 1e-15);
    }

    #[test]
    fn samples_with_a_bias_contradict_nobody_and_are_contradicted() {
        let mut ladder = ladder();
        ladder.methods[2].standing = Standing::Judged;
        let trials = [trial(0, 20.0, 1.0, Some(0.01)), trial(2, 1000.0, 1.2, Some(0.001))];
        let judged = judge(&ladder, &trials, "a").unwrap();
        assert!(judged.best == 0 && judged.curves[0].points[0].excess.abs() < 1e-15);
        let biased = judged.curves[2].points[0];
        assert!((biased.own + biased.excess - 0.19).abs() < 1e-12);
    }

    #[test]
    fn without_an_error_nothing_is_known_and_one_that_tells_none_is_judged_by_others() {
        assert_eq!(judge(&ladder(), &[trial(0, 10.0, 1.0, None)], "a"), None);
        let trials = [trial(0, 10.0, 1.1, None), trial(2, 100.0, 1.0, Some(0.05))];
        let judged = judge(&ladder(), &trials, "a").unwrap();
        let point = judged.curves[0].points[0];
        assert!((point.own + point.excess - 0.15).abs() < 1e-12);
    }
}
