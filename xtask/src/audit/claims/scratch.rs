//! A copy of the tree, in which mutants are applied and undone.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};
use std::process::Command;

use super::mutant::Mutant;

/// The copy.
#[derive(Debug)]
pub(super) struct Scratch {
    root: PathBuf,
}

impl Scratch {
    /// Copies what git tracks or would track; files that are the same already keep their times.
    pub(super) fn copy(from: &Path, to: &Path) -> Result<Self, String> {
        let list = git(from, &["ls-files", "-z", "--cached", "--others", "--exclude-standard"])
            .ok_or("the tree cannot be copied without git")?;
        let files: BTreeSet<PathBuf> = list
            .split('\0')
            .filter(|name| !name.is_empty())
            .map(PathBuf::from)
            .filter(|name| from.join(name).is_file())
            .collect();
        for name in &files {
            copy_changed(&from.join(name), &to.join(name))?;
        }
        remove_others(to, to, &files)?;
        Ok(Self { root: to.to_owned() })
    }

    pub(super) fn root(&self) -> &Path {
        &self.root
    }

    /// Puts in the replacements; the files as they were are given back, for [`restore`].
    pub(super) fn apply(&self, mutants: &[&Mutant]) -> Result<Vec<(PathBuf, String)>, String> {
        let mut originals = Vec::new();
        for mutant in mutants {
            let path = self.root.join(&mutant.file);
            let text = std::fs::read_to_string(&path).map_err(|error| told(&path, &error))?;
            write(&path, &mutated(&text, mutant)?)?;
            originals.push((path, text));
        }
        Ok(originals)
    }
}

/// Puts files back, the last first: a file with two mutants ends as it was.
pub(super) fn restore(originals: &[(PathBuf, String)]) -> Result<(), String> {
    originals.iter().rev().try_for_each(|(path, text)| write(path, text))
}

/// The text with its replacement.
fn mutated(text: &str, mutant: &Mutant) -> Result<String, String> {
    let count = text.matches(&mutant.text).count();
    if count != 1 {
        let Mutant { name, file, .. } = mutant;
        return Err(format!("mutant `{name}`: its text occurs {count} times in {file}, not once"));
    }
    Ok(text.replacen(&mutant.text, &mutant.replacement, 1))
}

fn copy_changed(from: &Path, to: &Path) -> Result<(), String> {
    let bytes = std::fs::read(from).map_err(|error| told(from, &error))?;
    if std::fs::read(to).is_ok_and(|there| there == bytes) {
        return Ok(());
    }
    if let Some(folder) = to.parent() {
        std::fs::create_dir_all(folder).map_err(|error| told(folder, &error))?;
    }
    // With its permissions: scripts are started.
    std::fs::copy(from, to).map(|_| ()).map_err(|error| told(to, &error))
}

/// Removes what an earlier copy left; folders may stay.
fn remove_others(root: &Path, folder: &Path, files: &BTreeSet<PathBuf>) -> Result<(), String> {
    for entry in std::fs::read_dir(folder).map_err(|error| told(folder, &error))? {
        let path = entry.map_err(|error| told(folder, &error))?.path();
        let is_ours = path.strip_prefix(root).is_ok_and(|name| files.contains(name));
        if path.is_dir() {
            // Reports of runs within the copy.
            if path != root.join("target") {
                remove_others(root, &path, files)?;
            }
        } else if !is_ours {
            std::fs::remove_file(&path).map_err(|error| told(&path, &error))?;
        }
    }
    Ok(())
}

fn write(path: &Path, text: &str) -> Result<(), String> {
    std::fs::write(path, text).map_err(|error| told(path, &error))
}

fn told(path: &Path, error: &std::io::Error) -> String {
    format!("{}: {error}", path.display())
}

fn git(root: &Path, arguments: &[&str]) -> Option<String> {
    let output = Command::new("git").args(arguments).current_dir(root).output().ok()?;
    let is_success = output.status.success();
    is_success.then(|| String::from_utf8_lossy(&output.stdout).into_owned())
}

/// Commit of the tree, `-dirty` appended if a tracked file differs; nothing without git.
pub(super) fn commit(root: &Path) -> String {
    let head = git(root, &["rev-parse", "--short=12", "HEAD"]).unwrap_or_default();
    let changed = git(root, &["status", "--porcelain", "--untracked-files=no"]).unwrap_or_default();
    let suffix = if changed.trim().is_empty() { "" } else { "-dirty" };
    format!("{}{suffix}", head.trim())
}

/// The processor and the number of threads.
pub(super) fn machine() -> String {
    let info = std::fs::read_to_string("/proc/cpuinfo").unwrap_or_default();
    let name = info.lines().find_map(|line| line.strip_prefix("model name")?.split(':').nth(1));
    let threads = std::thread::available_parallelism().map_or(1, std::num::NonZero::get);
    format!("{}, {threads} threads", name.map_or("processor unknown", str::trim))
}

#[cfg(test)]
mod tests {
    use super::super::mutant::tests::mutant;
    use super::*;

    #[test]
    fn a_text_is_replaced_only_if_it_occurs_once() {
        let mutant = mutant("x", "smpm", "smpm");
        assert_eq!(mutated("1 + 2", &mutant).unwrap(), "1 + 3");
        for (text, count) in [("1 + 1", "0 times"), ("2 + 2", "2 times")] {
            let error = mutated(text, &mutant).unwrap_err();
            assert!(error.contains(count) && error.contains("`x`"), "{error}");
        }
    }

    #[test]
    fn files_come_back_as_they_were() {
        let root = std::env::temp_dir().join(format!("mutants-{}", std::process::id()));
        let mutant = mutant("x", "smpm", "smpm");
        let path = root.join(&mutant.file);
        std::fs::create_dir_all(path.parent().unwrap()).unwrap();
        std::fs::write(&path, "const N: usize = 2;").unwrap();
        let scratch = Scratch { root: root.clone() };
        let originals = scratch.apply(&[&mutant]).unwrap();
        assert_eq!(std::fs::read_to_string(&path).unwrap(), "const N: usize = 3;");
        restore(&originals).unwrap();
        assert_eq!(std::fs::read_to_string(&path).unwrap(), "const N: usize = 2;");
        std::fs::remove_dir_all(&root).unwrap();
    }
}
