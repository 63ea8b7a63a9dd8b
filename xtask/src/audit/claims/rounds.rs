//! Which mutants share a build.

use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;

use super::mutant::Mutant;

/// The crates of the workspace that each of them depends on, itself among them.
pub(super) type Reaches = BTreeMap<String, BTreeSet<String>>;

/// Read from the manifests under `crates`.
pub(super) fn reaches(root: &Path) -> Result<Reaches, String> {
    let crates = root.join("crates");
    let error = |error: std::io::Error| format!("{}: {error}", crates.display());
    let mut direct = Reaches::new();
    for entry in std::fs::read_dir(&crates).map_err(error)? {
        let entry = entry.map_err(error)?;
        let manifest = std::fs::read_to_string(entry.path().join("Cargo.toml")).unwrap_or_default();
        let name = entry.file_name().to_string_lossy().into_owned();
        direct.insert(name, dependencies(&manifest));
    }
    Ok(closure(&direct))
}

/// The keys under `[dependencies]`.
fn dependencies(manifest: &str) -> BTreeSet<String> {
    let mut section = "";
    let mut keys = BTreeSet::new();
    for line in manifest.lines().map(str::trim) {
        if line.starts_with('[') {
            section = line;
        } else if section == "[dependencies]"
            && let Some(key) = line.split(['.', ' ', '=']).next().filter(|key| !key.is_empty())
        {
            keys.insert(key.to_owned());
        }
    }
    keys
}

fn closure(direct: &Reaches) -> Reaches {
    let of = |name: &String| {
        let (mut reached, mut open) = (BTreeSet::new(), vec![name.clone()]);
        while let Some(name) = open.pop() {
            if let Some(further) = direct.get(&name).filter(|_| reached.insert(name)) {
                open.extend(further.iter().cloned());
            }
        }
        (name.clone(), reached)
    };
    direct.keys().map(of).collect()
}

/// Each mutant joins the first round in which no case of one reaches the crate of another.
pub(super) fn rounds<'a>(mutants: &'a [Mutant], reaches: &Reaches) -> Vec<Vec<&'a Mutant>> {
    let mut rounds: Vec<Vec<&Mutant>> = Vec::new();
    for mutant in mutants {
        let fits = |round: &&mut Vec<&Mutant>| {
            round.iter().all(|other| {
                other.is_default_profile == mutant.is_default_profile
                    && !is_seen(other, mutant, reaches)
                    && !is_seen(mutant, other, reaches)
            })
        };
        match rounds.iter_mut().find(fits) {
            Some(round) => round.push(mutant),
            None => rounds.push(vec![mutant]),
        }
    }
    rounds
}

/// Whether the cases of `by`, or what they are of, can depend on `mutant`.
fn is_seen(mutant: &Mutant, by: &Mutant, reaches: &Reaches) -> bool {
    let is_reached = |name: &str| {
        name == mutant.package || reaches.get(name).is_some_and(|all| all.contains(&mutant.package))
    };
    let is_of_same_cases = by.case_crates().any(|name| mutant.case_crates().any(|m| m == name));
    is_of_same_cases || is_reached(&by.package) || by.case_crates().any(is_reached)
}

#[cfg(test)]
mod tests {
    use super::super::mutant::tests::mutant;
    use super::*;

    fn reaches() -> Reaches {
        let manifest =
            "[package]\nname = \"b\"\n[dependencies]\nb.workspace = true\nserde = \"1\"\n";
        assert!(dependencies(manifest).contains("b") && !dependencies(manifest).contains("name"));
        let names = |text: &str| text.split(' ').map(str::to_owned).collect();
        closure(&Reaches::from([
            ("a".to_owned(), names("b")),
            ("b".to_owned(), names("c")),
            ("c".to_owned(), BTreeSet::new()),
            ("d".to_owned(), names("c")),
        ]))
    }

    #[test]
    fn what_a_crate_reaches_is_transitive() {
        let expected: BTreeSet<String> = ["a", "b", "c"].map(str::to_owned).into();
        assert_eq!(reaches()["a"], expected);
    }

    #[test]
    fn mutants_share_a_build_only_if_no_case_sees_another() {
        let names = |mutants: &[Mutant]| {
            let rounds = rounds(mutants, &reaches());
            let names = |round: &Vec<&Mutant>| {
                round.iter().map(|mutant| mutant.name.clone()).collect::<Vec<_>>().join(" ")
            };
            rounds.iter().map(names).collect::<Vec<_>>()
        };
        let (a, b, d) = (mutant("a", "a", "a/x"), mutant("b", "b", "b/x"), mutant("d", "d", "d/x"));
        assert_eq!(names(&[a.clone(), b.clone(), d.clone()]), ["a d", "b"]);
        // Of another crate, and yet of the same cases.
        let by_cases = Mutant { filters: vec!["a/y".to_owned()], ..d.clone() };
        assert_eq!(names(&[a.clone(), by_cases]), ["a", "d"]);
        assert_eq!(names(&[a, Mutant { is_default_profile: true, ..d }]), ["a", "d"]);
    }
}
