//! Answers of a scene of bodies: mean and standard deviation of each response.

use scene_runs::answers::{Answer, AnswerValue, Answers, Number, Role, Statistic};

use super::record::{Content, GaugeResult, QuantityResult};
use super::response::Response;
use crate::method_scene::MethodScene;
use crate::scene::SmpmScene;

/// Answers that are shown first.
const FIRST: usize = 6;

/// Mean and standard deviation of every response, gauge by gauge.
pub(super) fn answers(scene: &SmpmScene, content: &Content) -> Answers {
    let mut list = Vec::new();
    for gauge in &content.gauges {
        for quantity in &gauge.quantities {
            list.extend(of_quantity(scene, gauge, quantity));
        }
    }
    list.iter_mut().take(FIRST).for_each(|answer| answer.role = Role::Headline);
    Answers { cpu_seconds: content.work.cpu_seconds, list }
}

/// The mean of a response, and its standard deviation where it varies.
fn of_quantity(scene: &SmpmScene, gauge: &GaugeResult, quantity: &QuantityResult) -> Vec<Answer> {
    let Some((last, earlier)) = quantity.values.split_last() else { return Vec::new() };
    let [_, time_unit, ..] = scene.units.names();
    let is_propagated = matches!(scene.method, MethodScene::Propagated);
    let (mean, deviation) = (last.mean.abs(), last.standard_deviation);
    let truncation = truncation(last).filter(|_| is_propagated);
    let answer = |statistic, part: &str, scale, number: &dyn Fn(&Response) -> Option<Number>| {
        let value = |response: &Response| {
            let (window, remark) = (Some(response.window), Some(response.how()));
            Some(AnswerValue { window, number: number(response)?, remark })
        };
        let words = format!("{} at {}, {part}", quantity.name.replace('_', " "), gauge.name);
        let id = match statistic {
            Statistic::StandardDeviation => "standard_deviation",
            _ => "mean",
        };
        let id = format!("{}/{}/{id}", gauge.name, quantity.name);
        Some(Answer {
            unit: quantity.unit.to_owned(),
            time_unit,
            earlier: earlier.iter().filter_map(value).collect(),
            scale,
            truncation,
            ..Answer::new(id, words, statistic, value(last)?)
        })
    };
    let part = if deviation.is_some() { "mean" } else { "value" };
    let scale = mean.max(deviation.unwrap_or(0.0));
    let means = answer(Statistic::Mean, part, scale, &|response| Some(response.mean()));
    let (part, scale) = ("standard deviation", deviation.unwrap_or(0.0));
    let deviations = answer(Statistic::StandardDeviation, part, scale, &Response::deviation);
    means.into_iter().chain(deviations).collect()
}

/// What a Taylor series leaves out of a deviation by its own curvature, unless an elastic-plastic switch is near. Of the variance it
/// is the square of the ratio, and the deviation is the root.
fn truncation(response: &Response) -> Option<f64> {
    let trust = response.trust.as_ref().filter(|trust| !trust.switch_within_two_deviations)?;
    Some(0.5 * trust.curvature_ratio?.powi(2) * response.standard_deviation?)
}
