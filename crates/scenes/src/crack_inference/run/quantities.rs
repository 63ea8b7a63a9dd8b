//! Quantities of a result of the schema `crack-inference/1`.

use serde_json::Value;

use crate::ladder::Quantity;

/// Means and standard deviations of the posterior, with two standard errors each.
pub(super) fn quantities(result: &Value) -> Vec<Quantity> {
    let parameters = result["parameters"].as_array().into_iter().flatten();
    parameters.flat_map(of_parameter).collect()
}

fn of_parameter(parameter: &Value) -> Vec<Quantity> {
    let key = parameter["key"].as_str().unwrap_or_default();
    let scale = parameter["mean"]["value"].as_f64().unwrap_or(0.0).abs();
    let quantity = |name: &str| {
        let number = &parameter[name];
        let value = number["value"].as_f64()?;
        Some(Quantity {
            id: format!("{key}/{name}"),
            words: format!("{} of {key}", name.replace('_', " ")),
            value,
            error: number["error"].as_f64().map(|error| 2.0 * error),
            scale,
        })
    };
    ["mean", "standard_deviation"].into_iter().filter_map(quantity).collect()
}

#[cfg(test)]
mod tests {
    use serde_json::json;

    use super::*;

    #[test]
    fn means_and_deviations_have_two_standard_errors() {
        let number = |value: f64, error: f64| json!({ "value": value, "error": error });
        let result = json!({ "parameters": [
            { "key": "a.b", "mean": number(4.0, 0.1), "standard_deviation": number(0.5, 0.02) }] });
        let found = quantities(&result);
        let ids: Vec<&str> = found.iter().map(|quantity| quantity.id.as_str()).collect();
        assert_eq!(ids, ["a.b/mean", "a.b/standard_deviation"]);
        assert_eq!((found[0].error, found[1].error), (Some(0.2), Some(0.04)));
    }
}
