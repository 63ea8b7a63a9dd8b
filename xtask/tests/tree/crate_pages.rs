//! Statements on the page of a crate compared with the crate.
//!
//! Compared are features, picture, number of crates in its build, and changelog.

use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};
use std::process::Command;

use crate::folder::root;

/// Platform for the numbers of crates.
const TARGET: &str = "x86_64-unknown-linux-gnu";

/// Categories of the registry that apply to a crate here.
const CATEGORIES: [&str; 7] = [
    "algorithms",
    "concurrency",
    "data-structures",
    "mathematics",
    "science",
    "simulation",
    "visualization",
];

/// Folders of the crates to be published.
fn crates() -> Vec<PathBuf> {
    let entries = std::fs::read_dir(root().join("crates")).expect("the folder of the crates");
    let mut folders: Vec<_> = entries.map(|entry| entry.expect("an entry").path()).collect();
    folders.sort_unstable();
    assert!(folders.len() >= 8, "{folders:?}");
    folders
}

fn name(folder: &Path) -> &str {
    folder.file_name().and_then(|name| name.to_str()).expect("a name in UTF-8")
}

fn read(folder: &Path, file: &str) -> String {
    std::fs::read_to_string(folder.join(file)).expect(file)
}

/// Entries of a table in a manifest, by key; single-line entries.
fn table(manifest: &str, heading: &str) -> BTreeMap<String, String> {
    let lines = manifest.lines().skip_while(|line| *line != format!("[{heading}]")).skip(1);
    let entries = lines.take_while(|line| !line.starts_with('['));
    let split = entries.filter_map(|line| line.split_once(" = "));
    split.map(|(key, value)| (key.to_owned(), value.to_owned())).collect()
}

/// Words between quotation marks.
fn quoted(list: &str) -> Vec<&str> {
    list.split('"').skip(1).step_by(2).collect()
}

/// Number of different packages in a normal build, including the crate itself.
fn n_crates(name: &str, features: &[&str]) -> usize {
    let tree = ["tree", "--locked", "--target", TARGET, "-p", name, "-e", "normal"];
    let shape = ["--prefix", "none", "--no-dedupe"];
    let run = Command::new(env!("CARGO"))
        .args(tree)
        .args(shape)
        .args(features)
        .current_dir(root())
        .output()
        .expect("cargo tree");
    assert!(run.status.success(), "{}", String::from_utf8_lossy(&run.stderr));
    String::from_utf8_lossy(&run.stdout).lines().collect::<BTreeSet<_>>().len()
}

#[test]
fn a_page_states_how_many_crates_a_build_takes() {
    for folder in crates() {
        let name = name(&folder);
        let (by_default, without) =
            (n_crates(name, &[]), n_crates(name, &["--no-default-features"]));
        let stated = format!(
            "Crates in a build, this one included: {by_default} with the default features, {without} without."
        );
        assert!(read(&folder, "README.md").contains(&stated), "{name} does not say: {stated}");
    }
}

#[test]
fn a_page_has_a_row_for_each_feature_and_says_which_are_default() {
    for folder in crates() {
        let page = read(&folder, "README.md");
        let features = table(&read(&folder, "Cargo.toml"), "features");
        let defaults = features.get("default").map(|list| quoted(list)).unwrap_or_default();
        for feature in features.keys().filter(|feature| *feature != "default") {
            let by_default = if defaults.contains(&feature.as_str()) { "yes" } else { "no" };
            let row = format!("| `{feature}` | {by_default} | ");
            assert!(page.contains(&row), "{}: no row {row}", name(&folder));
        }
        let rows =
            page.lines().filter(|line| line.contains("` | yes | ") || line.contains("` | no | "));
        let n_features = features.len() - usize::from(features.contains_key("default"));
        assert_eq!(rows.count(), n_features, "{}", name(&folder));
    }
}

#[test]
fn a_page_has_a_picture_that_is_there_and_words_for_who_cannot_see_it() {
    for folder in crates() {
        let page = read(&folder, "README.md");
        let (_, rest) = page.split_once("![").expect("a picture");
        let (words, rest) = rest.split_once("](").expect("a place");
        let (place, _) = rest.split_once(')').expect("an end");
        assert!(words.len() > 20, "{}: {words}", name(&folder));
        assert!(folder.join(place).is_file(), "{}: {place}", name(&folder));
    }
}

#[test]
fn a_page_says_when_not_to_use_the_crate_and_which_rust_it_needs() {
    let rust = format!(
        "Rust {}",
        table(&read(&root(), "Cargo.toml"), "workspace.package")["rust-version"].trim_matches('"')
    );
    for folder in crates() {
        let page = read(&folder, "README.md").to_lowercase();
        assert!(page.contains("when not"), "{}", name(&folder));
        assert!(page.contains(&rust.to_lowercase()), "{} does not say {rust}", name(&folder));
        assert!(page.contains("## features"), "{}", name(&folder));
    }
}

#[test]
fn a_changelog_begins_with_what_is_not_released_and_has_results() {
    for folder in crates() {
        let changelog = read(&folder, "CHANGELOG.md");
        let title = format!("# Changelog of {}\n", name(&folder));
        assert!(changelog.starts_with(&title), "{}", name(&folder));
        let sections: Vec<_> = changelog.lines().filter(|line| line.starts_with("## ")).collect();
        assert_eq!(sections.first(), Some(&"## [Unreleased]"), "{}", name(&folder));
        assert!(changelog.contains("\n### Results\n"), "{}", name(&folder));
    }
}

#[test]
fn a_manifest_has_what_the_registry_and_the_documentation_ask_for() {
    for folder in crates() {
        let manifest = read(&folder, "Cargo.toml");
        let package = table(&manifest, "package");
        assert_eq!(quoted(&package["name"]), [name(&folder)]);
        assert!(quoted(&package["description"])[0].len() > 20, "{}", name(&folder));
        for (key, most) in [("keywords", 5), ("categories", 5)] {
            assert!((1..=most).contains(&quoted(&package[key]).len()), "{}: {key}", name(&folder));
        }
        assert!(quoted(&package["keywords"]).iter().all(|word| word.len() <= 20));
        assert!(quoted(&package["categories"]).iter().all(|slug| CATEGORIES.contains(slug)));
        let documentation = table(&manifest, "package.metadata.docs.rs");
        assert!(quoted(&documentation["rustdoc-args"]).contains(&"katex-header.html"));
        assert!(folder.join("katex-header.html").is_file(), "{}", name(&folder));
        for licence in ["LICENSE-MIT", "LICENSE-APACHE"] {
            assert_eq!(read(&folder, licence), read(&root(), licence), "{}", name(&folder));
        }
    }
}
