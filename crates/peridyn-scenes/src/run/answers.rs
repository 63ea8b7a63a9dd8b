//! Answers of a scene of cracks: load, exit and length of cracks, and the probability of each outcome.

use result_figures::number::counted;
use scene_runs::answers::{Answer, AnswerValue, Answers, ErrorOrigin, Number, Role, Statistic};

use super::record::{Distributed, LEAST_REALISATIONS, Record};

/// Share of failed realisations above which the error of a mean over the others is unknown: they are not those of any strength.
const MOST_FAILED: f64 = 0.02;

/// Means and standard deviations of failure load, exit and length; probabilities of outcomes.
pub(super) fn answers(record: &Record, cpu_seconds: f64) -> Answers {
    let mut list = Vec::new();
    for Distributed { key, words, unit, law } in record.distributions() {
        let n_failed = record.failures.len();
        let n = record.realisations.len();
        let many_failed = n_failed as f64 > MOST_FAILED * n as f64;
        let value = |number: Number| {
            let mut number = number;
            let mut remark = number.error.is_none().then(|| match law.realisations {
                few @ ..LEAST_REALISATIONS => format!(
                    "error unknown: {} without known scatter, run {LEAST_REALISATIONS} or more",
                    counted(few, "realisation")
                ),
                _ => "no realisation differs from another, error unknown".to_owned(),
            });
            if many_failed {
                number = Number::sampled(number.value, None);
                remark = Some(format!(
                    "error unknown: {n_failed} of {n} realisations ended in errors and did not count"
                ));
            }
            AnswerValue { remark, ..AnswerValue::of(number) }
        };
        let answer = |statistic, part: &str, role, number| Answer {
            unit: unit.to_owned(),
            role,
            ..Answer::new(
                format!("{key}/{}", part.replace(' ', "_")),
                format!("{words}, {part}"),
                statistic,
                value(number),
            )
        };
        list.push(answer(Statistic::Mean, "mean", Role::Headline, law.mean));
        if let Some(deviation) = law.standard_deviation {
            // A 95 % interval extends two standard errors to each side.
            let error = Some(0.5 * (deviation.high - deviation.low));
            let number =
                Number { value: deviation.value, error, error_kind: ErrorOrigin::Interval };
            let role = if key == "failure_load" { Role::Headline } else { Role::Compared };
            list.push(answer(Statistic::StandardDeviation, "standard deviation", role, number));
        }
    }
    let likely = record.outcomes.iter().filter(|it| it.probability.value > 0.0);
    list.extend(likely.map(|it| Answer {
        role: Role::Shown,
        ..Answer::new(
            format!("outcome/{}", it.outcome),
            format!("P({})", it.outcome),
            Statistic::Probability,
            AnswerValue::of(it.probability),
        )
    }));
    Answers { cpu_seconds, list }
}
