//! What an outcome depends on: the mutant, the file that it changes, and the cases that have to catch it.

use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;

use super::mutant::{Breaks, Mutant};

/// Files by their path from the root of the workspace, as code.
#[derive(Debug, Default)]
pub(super) struct Sources {
    code: BTreeMap<String, String>,
}

const CASES: &str = "tests/src/cases/";

/// The frame of every case: how it is run and how claims are judged. A change there voids no outcome.
const FRAME: [&str; 6] = ["case", "cases", "claim", "cli", "report", "verify"];

impl Sources {
    /// The files of the cases, their reference data, and those that the mutants change.
    pub(super) fn read(root: &Path, mutants: &[Mutant]) -> Result<Self, String> {
        let mut sources = Self::default();
        for folder in ["tests/src", "tests/reference"] {
            sources.take_folder(root, folder)?;
        }
        for Mutant { file, .. } in mutants {
            sources.take(root, file)?;
        }
        Ok(sources)
    }

    fn take_folder(&mut self, root: &Path, folder: &str) -> Result<(), String> {
        let error = |error: std::io::Error| format!("{folder}: {error}");
        for entry in std::fs::read_dir(root.join(folder)).map_err(error)? {
            let entry = entry.map_err(error)?;
            let path = format!("{folder}/{}", entry.file_name().to_string_lossy());
            if entry.path().is_dir() {
                self.take_folder(root, &path)?;
            } else if Path::new(&path).extension().is_some_and(|end| end == "rs" || end == "json") {
                self.take(root, &path)?;
            }
        }
        Ok(())
    }

    fn take(&mut self, root: &Path, path: &str) -> Result<(), String> {
        let text =
            std::fs::read_to_string(root.join(path)).map_err(|error| format!("{path}: {error}"))?;
        self.code.insert(path.to_owned(), code(&text));
        Ok(())
    }

    /// A hash of all that an outcome depends on. While it stays the same, the outcome need not be found again.
    pub(super) fn hash(&self, mutant: &Mutant) -> String {
        let Mutant { file, text, replacement, breaks, filters, is_default_profile, .. } = mutant;
        let kind = if *breaks == Breaks::Structure { "structural" } else { "accuracy" };
        let profile = if *is_default_profile { "default" } else { "quick" };
        let mut parts = vec![file.as_str(), text, replacement, kind, profile];
        parts.extend(filters.iter().map(String::as_str));
        parts.extend(self.code.get(file).map(String::as_str));
        for case in self.of_cases(mutant) {
            parts.extend([case, &self.code[case]]);
        }
        // FNV-1a, a zero after each part.
        let bytes = parts.iter().flat_map(|part| part.bytes().chain([0]));
        let hash = bytes.fold(0xcbf2_9ce4_8422_2325_u64, |hash, byte| {
            (hash ^ u64::from(byte)).wrapping_mul(0x0100_0000_01b3)
        });
        format!("{hash:016x}")
    }

    /// The files that define the cases of a mutant, and those that they use.
    fn of_cases(&self, mutant: &Mutant) -> BTreeSet<&str> {
        let defines = |code: &str| {
            code.split("id: \"")
                .skip(1)
                .any(|rest| mutant.is_of(rest.split('"').next().unwrap_or("")))
        };
        let all = self.code.iter().filter(|(path, code)| path.starts_with(CASES) && defines(code));
        let mut open: Vec<&str> = all.map(|(path, _)| path.as_str()).collect();
        let mut found = BTreeSet::new();
        while let Some(path) = open.pop() {
            if found.insert(path) {
                open.extend(self.used_by(path));
            }
        }
        found
    }

    /// Files that another names: submodules, siblings, modules beside the cases, data.
    fn used_by(&self, path: &str) -> Vec<&str> {
        let code = &self.code[path];
        let (folder, _) = path.rsplit_once('/').unwrap_or_default();
        let (above, _) = folder.rsplit_once('/').unwrap_or_default();
        let stem = path.strip_suffix(".rs").unwrap_or(path);
        let mut names: Vec<String> = Vec::new();
        for name in after(code, "super::") {
            names.extend([format!("{folder}/{name}.rs"), format!("{above}/{name}.rs")]);
        }
        names.extend(after(code, "mod ").map(|name| format!("{stem}/{name}.rs")));
        names.extend(code.split("include_str!(\"").skip(1).map(|rest| {
            resolved(&format!("{folder}/{}", rest.split('"').next().unwrap_or_default()))
        }));
        let mut used: Vec<&str> = names
            .iter()
            .filter_map(|name| self.code.get_key_value(name))
            .map(|(path, _)| path.as_str())
            .collect();
        for name in after(code, "crate::").filter(|name| !FRAME.contains(name)) {
            let (file, folder) = (format!("tests/src/{name}.rs"), format!("tests/src/{name}/"));
            let is_of = |path: &&String| **path == file || path.starts_with(&folder);
            used.extend(self.code.keys().filter(is_of).map(String::as_str));
        }
        used
    }
}

/// The lines of a file without indentation, comments and unit tests, which are at its end.
fn code(text: &str) -> String {
    let is_code = |line: &&str| !line.is_empty() && !line.starts_with("//");
    let lines: Vec<&str> = text.lines().map(str::trim).filter(is_code).collect();
    let begins_tests =
        |pair: &[&str]| pair[0] == "#[cfg(test)]" && pair[1].ends_with("mod tests {");
    let end = lines.windows(2).position(begins_tests).unwrap_or(lines.len());
    lines[..end].join("\n")
}

/// The names that follow a word: one, or those of a list in braces.
fn after<'a>(code: &'a str, word: &'a str) -> impl Iterator<Item = &'a str> {
    let is_part = |c: char| c.is_alphanumeric() || c == '_';
    code.split(word).skip(1).flat_map(move |rest| {
        let list = rest.strip_prefix('{').map_or(rest, |rest| rest.split('}').next().unwrap_or(""));
        let most = if list.len() == rest.len() { 1 } else { usize::MAX };
        list.split(',').take(most).map(move |name| {
            let name = name.trim_start();
            &name[..name.find(|c| !is_part(c)).unwrap_or(name.len())]
        })
    })
}

/// A path without `..`.
fn resolved(path: &str) -> String {
    let mut parts: Vec<&str> = Vec::new();
    for part in path.split('/') {
        if part == ".." {
            parts.pop();
        } else {
            parts.push(part);
        }
    }
    parts.join("/")
}

#[cfg(test)]
mod tests {
    use super::super::mutant::tests::mutant;
    use super::*;

    fn sources(files: &[(&str, &str)]) -> Sources {
        let code = files.iter().map(|(path, text)| ((*path).to_owned(), code(text)));
        Sources { code: code.collect() }
    }

    const DISKS: &str = "use super::{incline, methods::METHODS};\nuse crate::claim::Claim;\n\
        const CASE: Case = Case { id: \"smpm/disks\" };\ninclude_str!(\"../../../reference/disks.json\")";
    const BAR: &str = "const CASE: Case = Case { id: \"smpm/bar\" };";

    fn tree() -> Vec<(&'static str, &'static str)> {
        vec![
            ("crates/smpm/src/lib.rs", "const N: usize = 2;"),
            ("tests/reference/disks.json", "0.91"),
            ("tests/src/cases/smpm/bar.rs", BAR),
            ("tests/src/cases/smpm/disks.rs", DISKS),
            ("tests/src/cases/smpm/incline.rs", "use crate::slopes::at;\nmod block;"),
            ("tests/src/cases/smpm/incline/block.rs", "use super::super::worst;"),
            ("tests/src/cases/smpm/methods.rs", ""),
            ("tests/src/cases/smpm/worst.rs", ""),
            ("tests/src/claim.rs", "fn judge() {}"),
            ("tests/src/slopes.rs", "fn at() {}"),
        ]
    }

    #[test]
    fn the_files_of_a_mutants_cases_are_those_that_they_use() {
        let sources = sources(&tree());
        let of = sources.of_cases(&mutant("x", "smpm", "smpm/disks"));
        let names: Vec<&str> = of.iter().map(|path| path.rsplit('/').next().unwrap()).collect();
        let expected = [
            "disks.json",
            "disks.rs",
            "incline.rs",
            "block.rs",
            "methods.rs",
            "worst.rs",
            "slopes.rs",
        ];
        assert_eq!(names, expected);
    }

    #[test]
    fn a_hash_changes_with_the_mutant_its_file_and_its_cases_alone() {
        let mutant = mutant("x", "smpm", "smpm/disks");
        let hash = |files: &[(&str, &str)]| sources(files).hash(&mutant);
        let start = hash(&tree());
        let changed = |path: &str, text: &'static str| {
            let mut files = tree();
            files.iter_mut().find(|(name, _)| *name == path).unwrap().1 = text;
            hash(&files) != start
        };
        assert!(changed("crates/smpm/src/lib.rs", "const N: usize = 3;"));
        assert!(changed("tests/src/cases/smpm/incline.rs", "const TOLERANCE: f64 = 1.0;"));
        assert!(changed("tests/reference/disks.json", "0.92"));
        // Another case, the frame, a comment, a unit test.
        assert!(!changed(
            "tests/src/cases/smpm/bar.rs",
            "const CASE: Case = Case { id: \"smpm/b\" };"
        ));
        assert!(!changed("tests/src/claim.rs", "fn judged() {}"));
        let text = "// Two.\n  const N: usize = 2;\n\n#[cfg(test)]\nmod tests {\n}";
        assert!(!changed("crates/smpm/src/lib.rs", text));
        let replaced = Mutant { replacement: "4".to_owned(), ..mutant.clone() };
        let filtered = Mutant { filters: vec!["smpm/dis".to_owned()], ..mutant.clone() };
        let renamed = Mutant { name: "y".to_owned(), what: "a sign".to_owned(), ..mutant.clone() };
        let of = |mutant: &Mutant| sources(&tree()).hash(mutant);
        assert!(of(&replaced) != start && of(&filtered) != start);
        assert_eq!(of(&renamed), start);
    }
}
