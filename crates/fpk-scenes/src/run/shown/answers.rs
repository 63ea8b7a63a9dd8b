//! Answers of a density scene or of a scene of a building: its moments, and its probabilities by the best estimator.

use scene_runs::answers::{Answer, AnswerValue, Answers, Role, Statistic};

use super::observed::Observed;
use super::record::{Quantity, Series, WorkRecord, best_probabilities};

/// Probabilities, and moments, that are shown first; more of one where there are fewer of the other.
const FIRST: usize = 3;

/// Probabilities, then moments.
///
/// The scale of a moment is the product of its states' deviations where the scene requests their second moments,
/// because a covariance may be zero.
pub(crate) fn answers(quantities: &[Series], work: &WorkRecord) -> Answers {
    let mut tails: Vec<Answer> = best_probabilities(quantities)
        .filter_map(|series| {
            let id = series.of.shared_id();
            answer(series, id, Statistic::Probability)
        })
        .collect();
    let moment = |series: &Series| {
        let Quantity::Moment(powers) = &series.of else { return None };
        let moment = answer(series, series.of.to_string(), Statistic::Moment)?;
        let scale = moment.scale.max(product_of_deviations(quantities, powers).unwrap_or(0.0));
        Some(Answer { scale, ..moment })
    };
    let mut moments: Vec<Answer> = quantities.iter().filter_map(moment).collect();
    let n_tails = FIRST.max((2 * FIRST).saturating_sub(moments.len()));
    let n_moments = FIRST.max((2 * FIRST).saturating_sub(tails.len()));
    let first = tails.iter_mut().take(n_tails).chain(moments.iter_mut().take(n_moments));
    first.for_each(|answer| answer.role = Role::Headline);
    Answers { cpu_seconds: work.cpu_seconds, list: [tails, moments].concat() }
}

fn answer(series: &Series, id: String, statistic: Statistic) -> Option<Answer> {
    let value = |observed: &Observed| AnswerValue::at(observed.t, observed.number());
    let (last, earlier) = series.values.split_last()?;
    Some(Answer {
        unit: series.unit.clone(),
        time_unit: "s",
        earlier: earlier.iter().map(value).collect(),
        ..Answer::new(id, series.quantity.clone(), statistic, value(last))
    })
}

/// The product of the deviations of states to the powers of a moment, at the last time; none without their second moments.
fn product_of_deviations(quantities: &[Series], powers: &[u32]) -> Option<f64> {
    let second = |k: usize| {
        let powers = (0..powers.len()).map(|i| if i == k { 2 } else { 0 }).collect();
        let wanted = Quantity::Moment(powers);
        Some(quantities.iter().find(|series| series.of == wanted)?.values.last()?.value)
    };
    let terms = powers.iter().enumerate().filter(|(_, power)| **power > 0);
    terms.map(|(k, &power)| Some(second(k)?.max(0.0).powf(0.5 * f64::from(power)))).product()
}

#[cfg(test)]
mod tests {
    use super::super::record::Probability;
    use super::*;
    use scene_runs::answers::ErrorOrigin;

    fn series(of: Quantity, value: f64) -> Series {
        let observed = |t: f64, value: f64| Observed::by_two(t, value, Some(0.01));
        let values = vec![observed(1.0, 9.0), observed(2.0, value)];
        Series { quantity: of.to_string(), of, unit: String::new(), values }
    }

    #[test]
    fn the_best_estimate_stands_for_a_probability_and_a_covariance_is_related_to_its_deviations() {
        let exceedance = |by| Quantity::Probability { by, threshold: 1.0 };
        let all = [
            series(Quantity::Moment(vec![2, 0]), 4.0),
            series(Quantity::Moment(vec![1, 1]), 0.1),
            series(Quantity::Moment(vec![0, 2]), 9.0),
            series(exceedance(Probability::Cell), 0.5),
            series(exceedance(Probability::Indicator), 0.4),
            series(exceedance(Probability::LogInterpolated), 0.3),
            series(Quantity::TotalMass, 1.0),
        ];
        assert_eq!(all[3].of.to_string(), "exceedance-cell/1");
        let found = answers(&all, &WorkRecord { cpu_seconds: 3.0, ..WorkRecord::default() });
        let expected = [
            ("exceedance/1", 0.5, 0.5),
            ("moment/2-0", 4.0, 4.0),
            ("moment/1-1", 0.1, 6.0),
            ("moment/0-2", 9.0, 9.0),
        ];
        assert_eq!(found.list.len(), expected.len());
        for (answer, expected) in found.list.iter().zip(expected) {
            assert_eq!((answer.id.as_str(), answer.last.number.value), (expected.0, expected.1));
            assert!((answer.scale - expected.2).abs() < 1e-12);
            assert_eq!(answer.last.number.error_kind, ErrorOrigin::TwoResolutions);
            assert_eq!((answer.earlier.len(), answer.role), (1, Role::Headline));
        }
    }
}
