//! The list of mutants.

use serde_json::Value;

/// What a mutant breaks: which claims have to catch it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Breaks {
    /// A number: a claim of accuracy has to fail.
    Accuracy,
    /// A count, an order or a refusal: a structural claim may catch it.
    Structure,
}

/// One wrong constant or sign.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Mutant {
    pub(super) name: String,
    /// The crate it is of.
    pub(super) package: String,
    /// From the root of the workspace.
    pub(super) file: String,
    /// The text that is replaced; it occurs once in the file.
    pub(super) text: String,
    pub(super) replacement: String,
    /// The physics that it breaks.
    pub(super) what: String,
    pub(super) breaks: Breaks,
    /// The filters of `verify` that have to catch it.
    pub(super) filters: Vec<String>,
    /// Whether its cases need the default profile; the quick one otherwise.
    pub(super) is_default_profile: bool,
}

impl Mutant {
    /// Whether a case is among those that have to catch it.
    pub(super) fn is_of(&self, case_id: &str) -> bool {
        self.filters.iter().any(|filter| case_id.contains(filter.as_str()))
    }

    /// The crates whose cases have to catch it: the first word of each filter.
    pub(super) fn case_crates(&self) -> impl Iterator<Item = &str> {
        self.filters.iter().map(|filter| filter.split('/').next().unwrap_or(filter))
    }
}

/// All mutants, in the order of the file.
pub(super) fn all() -> Result<Vec<Mutant>, String> {
    let list: Value = serde_json::from_str(include_str!("../mutants.json"))
        .map_err(|error| format!("mutants.json: {error}"))?;
    let entries = list.as_array().ok_or("mutants.json: a list is needed")?;
    entries.iter().map(read).collect()
}

fn read(entry: &Value) -> Result<Mutant, String> {
    let text = |key: &str| {
        let value = entry.get(key).and_then(Value::as_str).map(str::to_owned);
        value.ok_or(format!("mutants.json: `{key}` is missing in {entry}"))
    };
    let filters = entry.get("verify").and_then(Value::as_array).into_iter().flatten();
    Ok(Mutant {
        name: text("name")?,
        package: text("crate")?,
        file: text("file")?,
        text: text("text")?,
        replacement: text("replacement")?,
        what: text("breaks")?,
        breaks: match text("kind")?.as_str() {
            "accuracy" => Breaks::Accuracy,
            "structural" => Breaks::Structure,
            other => return Err(format!("mutants.json: `{other}` is no kind of a mutant")),
        },
        filters: filters.filter_map(Value::as_str).map(str::to_owned).collect(),
        is_default_profile: entry.get("profile").and_then(Value::as_str) == Some("default"),
    })
}

#[cfg(test)]
pub(super) mod tests {
    use super::*;

    /// A mutant that is nowhere applied.
    pub(in super::super) fn mutant(name: &str, package: &str, filter: &str) -> Mutant {
        Mutant {
            name: name.to_owned(),
            package: package.to_owned(),
            file: format!("crates/{package}/src/lib.rs"),
            text: "2".to_owned(),
            replacement: "3".to_owned(),
            what: "a constant".to_owned(),
            breaks: Breaks::Accuracy,
            filters: vec![filter.to_owned()],
            is_default_profile: false,
        }
    }

    #[test]
    fn an_entry_without_a_key_is_refused() {
        let error = read(&serde_json::json!({ "name": "x" })).unwrap_err();
        assert!(error.contains("`crate`"), "{error}");
    }

    #[test]
    fn a_mutant_is_of_the_cases_that_its_filters_select() {
        let mutant = mutant("x", "smpm", "smpm/disks");
        assert!(mutant.is_of("smpm/disks") && !mutant.is_of("smpm/trust"));
        assert_eq!(mutant.case_crates().collect::<Vec<_>>(), ["smpm"]);
    }
}
