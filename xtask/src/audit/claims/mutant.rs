//! The list of mutants, and what their outcomes depend on.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use serde_json::Value;

/// One wrong constant or sign.
#[derive(Debug, Clone, Default, PartialEq)]
pub(super) struct Mutant {
    pub(super) name: String,
    /// The crate that it changes.
    pub(super) package: String,
    /// Path from the root of the workspace.
    pub(super) file: String,
    /// The text that is replaced; it occurs once in the file.
    pub(super) text: String,
    pub(super) replacement: String,
    /// The physics that it breaks.
    pub(super) what: String,
    /// Whether it breaks a count, an order or a refusal: then a structural claim may catch it.
    pub(super) is_structural: bool,
    /// The filters of `verify` whose cases have to catch it.
    pub(super) filters: Vec<String>,
    /// The packages whose tests have to catch it.
    pub(super) packages: Vec<String>,
    /// Whether its cases need the default profile; the quick one otherwise.
    pub(super) is_default_profile: bool,
}

impl Mutant {
    /// The text of its file with the replacement.
    pub(super) fn applied(&self, text: &str) -> Result<String, String> {
        let count = text.matches(&self.text).count();
        if count != 1 {
            let Self { name, file, .. } = self;
            return Err(format!(
                "mutant `{name}`: its text occurs {count} times in {file}, not once"
            ));
        }
        Ok(text.replacen(&self.text, &self.replacement, 1))
    }
}

/// All mutants, in the order of the file.
pub(super) fn all() -> Result<Vec<Mutant>, String> {
    let list: Value = serde_json::from_str(include_str!("../mutants.json"))
        .map_err(|error| format!("mutants.json: {error}"))?;
    list.as_array().ok_or("mutants.json: a list is needed")?.iter().map(read).collect()
}

fn read(entry: &Value) -> Result<Mutant, String> {
    let text = |key: &str| {
        let value = entry.get(key).and_then(Value::as_str).map(str::to_owned);
        value.ok_or(format!("mutants.json: `{key}` is missing in {entry}"))
    };
    let list = |key: &str| -> Vec<String> {
        let words = entry.get(key).and_then(Value::as_array).into_iter().flatten();
        words.filter_map(Value::as_str).map(str::to_owned).collect()
    };
    Ok(Mutant {
        name: text("name")?,
        package: text("crate")?,
        file: text("file")?,
        text: text("text")?,
        replacement: text("replacement")?,
        what: text("breaks")?,
        is_structural: match text("kind")?.as_str() {
            "accuracy" => false,
            "structural" => true,
            other => return Err(format!("mutants.json: `{other}` is no kind of a mutant")),
        },
        filters: list("verify"),
        packages: list("test"),
        is_default_profile: entry.get("profile").and_then(Value::as_str) == Some("default"),
    })
}

/// A hash for each mutant of its entry, the file that it changes, the files that define its cases, and the tests of its packages.
/// An outcome counts until the hash changes; helpers that several cases share are not part of it.
pub(super) fn hashes(root: &Path, mutants: &[Mutant]) -> Result<BTreeMap<String, String>, String> {
    let cases = sources(&root.join("tests/src/cases"))?;
    let mut hashes = BTreeMap::new();
    for mutant in mutants {
        let mut parts = vec![format!("{:?}", Mutant { what: String::new(), ..mutant.clone() })];
        let path = root.join(&mutant.file);
        let file = std::fs::read_to_string(&path);
        parts.push(code(&file.map_err(|error| format!("{}: {error}", path.display()))?));
        let defines = |text: &str| {
            mutant.filters.iter().any(|filter| text.contains(&format!("id: \"{filter}")))
        };
        parts.extend(cases.iter().filter(|text| defines(text)).cloned());
        for package in &mutant.packages {
            parts.extend(sources(&root.join("crates").join(package).join("tests"))?);
        }
        // FNV-1a, a zero after each part.
        let bytes = parts.iter().flat_map(|part| part.bytes().chain([0]));
        let hash = bytes.fold(0xcbf2_9ce4_8422_2325_u64, |hash, byte| {
            (hash ^ u64::from(byte)).wrapping_mul(0x0100_0000_01b3)
        });
        hashes.insert(mutant.name.clone(), format!("{hash:016x}"));
    }
    Ok(hashes)
}

/// The code of all Rust files below a folder, in the order of their paths.
fn sources(folder: &Path) -> Result<Vec<String>, String> {
    let error = |error: std::io::Error| format!("{}: {error}", folder.display());
    let entries = std::fs::read_dir(folder).map_err(error)?;
    let mut paths: Vec<PathBuf> =
        entries.map(|entry| entry.map(|it| it.path())).collect::<Result<_, _>>().map_err(error)?;
    paths.sort();
    let mut all = Vec::new();
    for path in paths {
        if path.is_dir() {
            all.extend(sources(&path)?);
        } else if path.extension().is_some_and(|ending| ending == "rs") {
            all.push(code(&std::fs::read_to_string(&path).map_err(error)?));
        }
    }
    Ok(all)
}

/// The lines of a file without indentation and comments.
fn code(text: &str) -> String {
    let is_code = |line: &&str| !line.is_empty() && !line.starts_with("//");
    text.lines().map(str::trim).filter(is_code).collect::<Vec<_>>().join("\n")
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::workspace;

    #[test]
    fn an_entry_without_a_key_is_refused() {
        let error = read(&serde_json::json!({ "name": "x" })).unwrap_err();
        assert!(error.contains("`crate`"), "{error}");
    }

    #[test]
    fn a_text_is_replaced_only_if_it_occurs_once() {
        let mutant = Mutant { text: "2".into(), replacement: "3".into(), ..Mutant::default() };
        assert_eq!(mutant.applied("1 + 2").unwrap(), "1 + 3");
        for (text, count) in [("1 + 1", "0 times"), ("2 + 2", "2 times")] {
            let error = mutant.applied(text).unwrap_err();
            assert!(error.contains(count), "{error}");
        }
    }

    #[test]
    fn a_hash_depends_on_the_mutant_and_its_cases_but_not_on_its_description() {
        let mutant = all().unwrap().swap_remove(0);
        let hash = |mutant: &Mutant| {
            hashes(&workspace(), std::slice::from_ref(mutant)).unwrap()[&mutant.name].clone()
        };
        let start = hash(&mutant);
        assert_eq!(hash(&Mutant { what: "a sign".to_owned(), ..mutant.clone() }), start);
        assert_ne!(hash(&Mutant { replacement: "4".to_owned(), ..mutant.clone() }), start);
        assert_ne!(hash(&Mutant { filters: vec!["smpm/".to_owned()], ..mutant.clone() }), start);
        assert_eq!(code("// Two.\n  const N: usize = 2;\n\n"), "const N: usize = 2;");
    }
}
