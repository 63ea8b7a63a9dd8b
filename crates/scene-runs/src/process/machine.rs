//! Machine, load and commit: the conditions of a measurement.

use std::process::Command;

use serde::{Deserialize, Serialize};

/// Conditions of a run; unknown entries are `null`, never guessed.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Machine {
    /// Model of the processor.
    pub cpu: Option<String>,
    /// Logical processors that this process may use.
    pub cores: usize,
    /// Threads that parallel loops use.
    pub threads: usize,
    /// Load average over the last minute.
    pub load_average: Option<f64>,
    /// Operating system.
    pub os: String,
    /// Instruction set.
    pub arch: String,
}

impl Machine {
    /// Reads them from the operating system.
    #[must_use]
    pub fn read() -> Self {
        Self {
            cpu: cpu_model(),
            cores: std::thread::available_parallelism().map_or(1, usize::from),
            threads: rayon::current_num_threads(),
            load_average: load_average(),
            os: os_name(),
            arch: std::env::consts::ARCH.to_owned(),
        }
    }

    /// One line for the caption of a chart: processor, threads, load, commit.
    #[must_use]
    pub fn caption(&self) -> String {
        format!("{}, {}", self.hardware(), commit_words(commit().as_deref()))
    }

    /// Processor, threads, load.
    #[must_use]
    pub fn hardware(&self) -> String {
        let cpu = self.cpu.as_deref().unwrap_or("unknown processor");
        let threads = if self.threads == 1 {
            "1 thread".to_owned()
        } else {
            format!("{} threads", self.threads)
        };
        let load = self
            .load_average
            .map_or_else(|| "load unknown".to_owned(), |load| format!("load {load:.1}"));
        format!("{cpu}, {threads} of {} cores, {load}", self.cores)
    }
}

/// The commit of the working tree, with `-dirty` if a tracked file outside `docs` differs from it; `None` outside git.
///
/// Documents do not affect results, and recorded ones change while others are still being produced.
#[must_use]
pub fn commit() -> Option<String> {
    let hash = git(&["rev-parse", "HEAD"])?;
    let is_clean = differing(&status()?).all(|file| file.state == State::Untracked);
    Some(if is_clean { hash } else { format!("{hash}-dirty") })
}

/// Modified or untracked files outside `docs`; `None` outside git.
#[must_use]
pub fn uncommitted() -> Option<Vec<String>> {
    Some(differing(&status()?).map(|file| file.path.to_owned()).collect())
}

fn status() -> Option<String> {
    git(&["status", "--porcelain", "--untracked-files=all"])
}

fn git(arguments: &[&str]) -> Option<String> {
    answer("git", arguments)
}

/// Whether git tracks a file.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum State {
    Tracked,
    Untracked,
}

/// A modified or untracked file.
#[derive(Debug, PartialEq, Eq)]
struct Differing<'a> {
    state: State,
    path: &'a str,
}

/// Parses the output of `git status --porcelain`, without documents.
fn differing(status: &str) -> impl Iterator<Item = Differing<'_>> {
    status.lines().filter_map(differing_line)
}

/// A line is two letters, a space and a path, or the two paths of a moved file.
fn differing_line(line: &str) -> Option<Differing<'_>> {
    let (letters, paths) = line.trim_start().split_once(' ')?;
    let state = if letters == "??" { State::Untracked } else { State::Tracked };
    let is_document = |path: &&str| path.trim_matches('"').starts_with("docs/");
    let path = paths.trim_start().split(" -> ").find(|path| !is_document(path))?;
    Some(Differing { state, path })
}

/// `commit 0123456789ab`, or `no commit`.
#[must_use]
pub fn commit_words(commit: Option<&str>) -> String {
    commit.map_or_else(|| "no commit".to_owned(), |commit| format!("commit {}", short(commit)))
}

/// Current date in UTC, as `2026-11-21`; `None` if the system does not report it.
#[must_use]
pub fn date() -> Option<String> {
    answer("date", &["-u", "+%Y-%m-%d"])
}

/// The first twelve digits of a commit, with its dirty flag.
#[must_use]
pub fn short(commit: &str) -> String {
    let dirty = if commit.ends_with("-dirty") { "-dirty" } else { "" };
    let digits: String = commit.chars().take_while(char::is_ascii_hexdigit).take(12).collect();
    format!("{digits}{dirty}")
}

fn answer(program: &str, arguments: &[&str]) -> Option<String> {
    let output = Command::new(program).args(arguments).output().ok()?;
    output.status.success().then(|| String::from_utf8_lossy(&output.stdout).trim().to_owned())
}

fn cpu_model() -> Option<String> {
    let from_proc = std::fs::read_to_string("/proc/cpuinfo")
        .ok()
        .and_then(|text| value_of(&text, "model name", ':'));
    from_proc.or_else(|| answer("sysctl", &["-n", "machdep.cpu.brand_string"]))
}

fn load_average() -> Option<f64> {
    let text = std::fs::read_to_string("/proc/loadavg").ok()?;
    text.split_whitespace().next()?.parse().ok()
}

fn os_name() -> String {
    let release = std::fs::read_to_string("/etc/os-release").ok();
    let name = release.and_then(|text| value_of(&text, "PRETTY_NAME", '='));
    name.unwrap_or_else(|| std::env::consts::OS.to_owned())
}

/// The value after the first `key` in lines of the form `key <separator> value`.
fn value_of(text: &str, key: &str, separator: char) -> Option<String> {
    let line = text.lines().find(|line| line.starts_with(key))?;
    let (_, value) = line.split_once(separator)?;
    Some(value.trim().trim_matches('"').to_owned())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_value_is_found_behind_its_key() {
        let text = "processor\t: 0\nmodel name\t: Example CPU @ 2 GHz\nmodel name\t: another\n";
        assert_eq!(value_of(text, "model name", ':').as_deref(), Some("Example CPU @ 2 GHz"));
        assert_eq!(
            value_of("PRETTY_NAME=\"Some OS 12\"\n", "PRETTY_NAME", '=').as_deref(),
            Some("Some OS 12")
        );
        assert_eq!(value_of(text, "cache", ':'), None);
    }

    #[test]
    fn documents_may_differ_and_untracked_files_are_told_apart() {
        let status = "M docs/charts/a.svg\n M tests/src/claim.rs\nR  docs/a.md -> tests/a.md\n?? docs/new.md\n?? notes.txt";
        let files: Vec<_> = differing(status).map(|file| (file.state, file.path)).collect();
        assert_eq!(
            files,
            [
                (State::Tracked, "tests/src/claim.rs"),
                (State::Tracked, "tests/a.md"),
                (State::Untracked, "notes.txt")
            ]
        );
    }

    #[test]
    fn a_short_commit_keeps_the_mark_of_a_changed_tree() {
        let hash = "0123456789abcdef0123456789abcdef01234567";
        assert_eq!(short(hash), "0123456789ab");
        assert_eq!(short(&format!("{hash}-dirty")), "0123456789ab-dirty");
    }
}
