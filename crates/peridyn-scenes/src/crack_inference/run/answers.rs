//! Answers of an inference: the posterior of each parameter, and whether the model fits.

use scene_runs::answers::{Answer, AnswerValue, Answers, Role, Statistic};

use super::posterior_record::ParameterRecord;
use super::record::Content;

/// Mean and standard deviation of each parameter; the share of measured values inside the predicted bands.
pub(super) fn answers(content: &Content) -> Answers {
    let mut list: Vec<Answer> = content.parameters.iter().flat_map(of_parameter).collect();
    list.extend(content.predictive.share_inside.map(|share| Answer {
        role: Role::Shown,
        ..Answer::new(
            "share-inside".to_owned(),
            "measured values inside the predicted 90 %".to_owned(),
            Statistic::Probability,
            AnswerValue::of(share),
        )
    }));
    Answers { cpu_seconds: content.work.cpu_seconds, list }
}

fn of_parameter(of: &ParameterRecord) -> [Answer; 2] {
    let key = &of.key;
    let deviation = Answer::new(
        format!("{key}/standard_deviation"),
        format!("{key}, standard deviation"),
        Statistic::StandardDeviation,
        AnswerValue::of(of.standard_deviation),
    );
    let verdict = of.verdict;
    let spread = deviation.shown().value_and_error();
    let remark = Some(format!("{verdict}; standard deviation {spread}"));
    let mean = Answer {
        role: Role::Headline,
        ..Answer::new(
            format!("{key}/mean"),
            format!("{key}, mean"),
            Statistic::Mean,
            AnswerValue { remark, ..AnswerValue::of(of.mean) },
        )
    };
    let scale = mean.scale;
    [mean, Answer { scale, ..deviation }]
}
