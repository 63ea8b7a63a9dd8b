//! Edges between packages of the workspace match those that `docs/ARCHITECTURE.md` states.

use std::collections::{BTreeMap, BTreeSet};
use std::process::Command;

use crate::folder::{root, texts};
use crate::packages::{packages, word};
use serde_json::Value;

/// Dependencies of a package: always, and for its tests only.
type Edges = BTreeMap<String, [BTreeSet<String>; 2]>;

/// Packages of the workspace and their edges.
fn edges() -> Edges {
    packages().iter().map(|package| (word(&package["name"]), of_package(package))).collect()
}

fn of_package(package: &Value) -> [BTreeSet<String>; 2] {
    let dependencies = package["dependencies"].as_array().expect("dependencies");
    let ours = || dependencies.iter().filter(|dependency| dependency["path"].is_string());
    let of_kind = |is_dev: bool| -> BTreeSet<String> {
        let chosen = ours().filter(|dependency| (dependency["kind"] == "dev") == is_dev);
        chosen.map(|dependency| word(&dependency["name"])).collect()
    };
    let always = of_kind(false);
    let for_tests = of_kind(true).difference(&always).cloned().collect();
    [always, for_tests]
}

/// Rows of the table, one for each package that depends on another.
fn rows(edges: &Edges) -> Vec<String> {
    let list = |names: &BTreeSet<String>| names.iter().cloned().collect::<Vec<_>>().join(", ");
    let of_some = edges.iter().filter(|(_, [always, tests])| always.len() + tests.len() > 0);
    let row = |(name, [always, tests]): (&String, &[BTreeSet<String>; 2])| {
        format!("| {name} | {} | {} |", list(always), list(tests))
    };
    of_some.map(row).collect()
}

#[test]
fn the_page_of_the_architecture_states_all_edges_and_no_other() {
    const HEAD: &str = "| from | to | for tests alone |\n|---|---|---|\n";
    let page = std::fs::read_to_string(root().join("docs/ARCHITECTURE.md")).expect("the page");
    let (_, rest) = page.split_once(HEAD).expect("the table of edges");
    let stated: Vec<&str> = rest.lines().take_while(|line| line.starts_with('|')).collect();
    let found = rows(&edges());
    assert!(stated == found, "docs/ARCHITECTURE.md:\n{stated:#?}\nthe manifests:\n{found:#?}");
}

#[test]
fn no_package_reaches_itself_tests_included() {
    let edges = edges();
    for start in edges.keys() {
        let (mut reached, mut next) = (BTreeSet::new(), vec![start]);
        while let Some(name) = next.pop() {
            for to in edges[name].iter().flatten() {
                assert_ne!(to, start, "{start} is reached from {name}");
                if reached.insert(to) {
                    next.push(to);
                }
            }
        }
    }
}

#[test]
fn solvers_do_not_know_each_other_and_figures_knows_no_solver() {
    let edges = edges();
    let solvers = ["fpk-sph", "smpm", "peridyn-sde"];
    for package in
        [&solvers[..], &["result-figures", "mpi-ensembles", "random-vibration", "xtask"]].concat()
    {
        let [always, _] = &edges[package];
        assert!(solvers.iter().all(|solver| !always.contains(*solver)), "{package}: {always:?}");
    }
    assert!(edges["simd-lanes"][0].is_empty() && edges["xtask"][0].is_empty());
}

/// A program that embeds one solver compiles no other.
#[test]
fn scenes_of_one_solver_build_no_other() {
    for (feature, solver) in [("fpk", "fpk-sph"), ("smpm", "smpm"), ("peridyn", "peridyn-sde")] {
        let tree = ["tree", "--locked", "-p", "scenes", "--no-default-features", "-e", "normal"];
        let run = Command::new(env!("CARGO"))
            .args(tree)
            .args(["--prefix", "none", "--features", feature])
            .current_dir(root())
            .output()
            .expect("cargo tree");
        let text = String::from_utf8_lossy(&run.stdout);
        for other in ["fpk-sph", "smpm", "peridyn-sde"] {
            let is_built = text.lines().any(|line| line.starts_with(&format!("{other} ")));
            assert_eq!(is_built, other == solver, "{feature}: {other}");
        }
    }
}

/// A unit test that names a table of runs, cases or charts compiles all of them once more, with the test.
#[test]
fn no_unit_test_names_a_table_of_whole_programs() -> std::io::Result<()> {
    let mut named = Vec::new();
    for (path, text) in texts(&root(), ".rs")? {
        let tests = text.split_once("#[cfg(test)]\n").filter(|_| path.contains("/src/"));
        let tables = ["run::KIND", "cases::ALL", "charts::ALL"];
        let found = tables.iter().filter(|table| tests.is_some_and(|(_, it)| it.contains(**table)));
        named.extend(found.map(|table| format!("{path}: {table}")));
    }
    assert!(named.is_empty(), "test these from outside, in tests/:\n{}", named.join("\n"));
    Ok(())
}
