//! Quantities of a density scene by which methods are compared.

use serde_json::Value;

use crate::ladder::Quantity;

/// Estimates of one probability, best first; ids of other estimates are omitted.
const EXCEEDANCES: [&str; 3] = ["exceedance-cell/", "exceedance-log-interpolated/", "exceedance/"];

/// Moments and probabilities at the last time.
///
/// The scale of a moment is the product of its states' deviations where the scene requests their second moments,
/// because a covariance may be zero.
pub(super) fn quantities(result: &Value) -> Vec<Quantity> {
    let series = result["quantities"].as_array().map_or(&[][..], Vec::as_slice);
    let last = |series: &Value| -> Option<(String, String, f64, Option<f64>)> {
        let values = series["values"].as_array()?.last()?;
        let text = |key: &str| series[key].as_str().map(str::to_owned);
        let (id, value) = (text("id")?, values["value"].as_f64()?);
        let error = values["error"].as_f64().map(|error| match values["error_kind"].as_str() {
            Some("standard_error") if id.starts_with("exceedance") => of_counts(value, error),
            Some("standard_error") => 2.0 * error,
            _ => error,
        });
        Some((id, text("quantity")?, value, error))
    };
    let all: Vec<_> = series.iter().filter_map(last).collect();
    let best =
        EXCEEDANCES.iter().find(|prefix| all.iter().any(|(id, ..)| id.starts_with(**prefix)));
    let second = |k: usize, states: usize| {
        let powers: Vec<&str> = (0..states).map(|i| if i == k { "2" } else { "0" }).collect();
        let id = format!("moment/{}", powers.join("-"));
        all.iter().find(|(other, ..)| *other == id).map(|&(_, _, value, _)| value)
    };
    let quantity = |(id, words, value, error): &(String, String, f64, Option<f64>)| {
        let (value, error) = (*value, *error);
        if let Some(powers) = id.strip_prefix("moment/") {
            let powers: Vec<f64> = powers.split('-').filter_map(|a| a.parse().ok()).collect();
            let terms = powers.iter().enumerate().filter(|(_, a)| **a > 0.0);
            let deviations =
                terms.map(|(k, a)| Some(second(k, powers.len())?.max(0.0).powf(0.5 * a)));
            let product: Option<f64> = deviations.product();
            let scale = product.unwrap_or(0.0).max(value.abs());
            return Some(Quantity { id: id.clone(), words: words.clone(), value, error, scale });
        }
        let threshold = id.strip_prefix(*best?)?;
        let (id, scale) = (format!("exceedance/{threshold}"), value.abs());
        Some(Quantity { id, words: words.clone(), value, error, scale })
    };
    all.iter().filter_map(quantity).collect()
}

/// Upper limit of a probability above its counted frequency at two standard errors [wilson1927].
///
/// With few counted events the deviation of the frequency is as uncertain as their number.
fn of_counts(frequency: f64, standard_error: f64) -> f64 {
    const Z: f64 = 2.0;
    // n in s.e.^2 = p (1 - p) / n.
    let z2_over_n = (Z * standard_error).powi(2) / (frequency * (1.0 - frequency));
    let half = (Z * Z * standard_error.powi(2) + 0.25 * z2_over_n * z2_over_n).sqrt();
    (frequency + 0.5 * z2_over_n + half) / (1.0 + z2_over_n) - frequency
}

#[cfg(test)]
mod tests {
    use serde_json::json;

    use super::*;

    #[test]
    fn the_best_estimate_stands_for_a_probability_and_a_covariance_is_related_to_its_deviations() {
        let series = |id: &str, value: f64, kind: &str| {
            let values = json!([
                { "t": 1, "value": 9, "error": 9, "error_kind": kind },
                { "t": 2, "value": value, "error": 0.01, "error_kind": kind }
            ]);
            json!({ "id": id, "quantity": id, "unit": "", "values": values })
        };
        let result = json!({ "quantities": [
            series("moment/2-0", 4.0, "two_resolutions"),
            series("moment/1-1", 0.1, "two_resolutions"),
            series("moment/0-2", 9.0, "two_resolutions"),
            series("exceedance-cell/1", 0.5, "two_resolutions"),
            series("exceedance-indicator/1", 0.4, "two_resolutions"),
            series("exceedance-log-interpolated/1", 0.3, "two_resolutions"),
            series("total-mass", 1.0, "two_resolutions"),
        ]});
        let found: Vec<_> =
            quantities(&result).into_iter().map(|q| (q.id, q.value, q.scale)).collect();
        let expected = [
            ("moment/2-0", 4.0, 4.0),
            ("moment/1-1", 0.1, 6.0),
            ("moment/0-2", 9.0, 9.0),
            ("exceedance/1", 0.5, 0.5),
        ];
        assert_eq!(found.len(), expected.len());
        for ((id, value, scale), expected) in found.iter().zip(expected) {
            assert_eq!((id.as_str(), *value), (expected.0, expected.1));
            assert!((scale - expected.2).abs() < 1e-12);
        }
        let sampled = json!({ "quantities": [series("exceedance/1", 0.2, "standard_error")] });
        let found = quantities(&sampled);
        assert_eq!(found[0].id, "exceedance/1");
        // 1,600 samples.
        assert!((found[0].error.unwrap() - 0.0207).abs() < 1e-4, "{:?}", found[0].error);
    }

    #[test]
    fn one_event_is_not_known_to_within_two_of_its_deviations() {
        // (1 + 2 + 2 sqrt(1 + 1)) / n - 1 / n.
        let n = 1e6;
        let above = of_counts(1.0 / n, 1.0 / n);
        assert!((above * n - 4.828).abs() < 1e-3, "{above}");
    }
}
