//! The numbers of the proof by their claims, for pages that state them.

use serde_json::{Map, Value, json};

use crate::report::{Claim, Report};

/// What is measured of every claim, and the CPU time of every case, as JSON with an entry a line.
///
/// `{"claims": {ID: {"measured": ..}}, "cases": {ID: {"cpu_seconds": ..}}}`; of a claim `measured`, `standard_error`,
/// `reference` and `error`, as far as it has them, with seven digits. `xtask/tests/tree/records.rs` compares pages with it.
#[must_use]
pub fn render_numbers(report: &Report) -> String {
    let claims = report.cases.iter().flat_map(|case| &case.claims);
    let claims: Vec<String> = claims.map(|claim| entry(&claim.id, of_claim(claim))).collect();
    let cases = report.cases.iter();
    let seconds = |seconds: f64| Map::from_iter(number("cpu_seconds", Some(seconds)));
    let cases: Vec<String> = cases.map(|case| entry(&case.id, seconds(case.cpu_seconds))).collect();
    let commit = report.commit.as_deref().map_or(Value::Null, Value::from);
    format!(
        "{{\n\"commit\": {commit},\n\"cases\": {{\n{}\n}},\n\"claims\": {{\n{}\n}}\n}}\n",
        cases.join(",\n"),
        claims.join(",\n")
    )
}

fn entry(id: &str, numbers: Map<String, Value>) -> String {
    format!("{}: {}", Value::from(id), Value::Object(numbers))
}

fn of_claim(claim: &Claim) -> Map<String, Value> {
    let all = [
        ("measured", claim.measured),
        ("standard_error", claim.standard_error),
        ("reference", claim.reference),
        ("error", claim.error),
    ];
    all.into_iter().filter_map(|(name, value)| number(name, value)).collect()
}

/// With seven digits: a page shows fewer, and the last ones differ between machines.
fn number(name: &str, value: Option<f64>) -> Option<(String, Value)> {
    let rounded: f64 = format!("{:.6e}", value?).parse().ok()?;
    Some((name.to_owned(), json!(rounded)))
}
