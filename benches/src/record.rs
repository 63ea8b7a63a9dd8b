//! What is kept of a run of a target: its tables, what criterion measured, and where that was.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::{fs, io};

use serde::{Deserialize, Serialize};

/// Names the file that a target leaves its tables in.
pub const TABLES: &str = "BENCHES_TABLES";

/// All targets, in the order of the page.
pub const TARGETS: [&str; 9] =
    ["plain", "kernels", "neighbour", "particles", "sde", "moments", "fpk", "smpm", "peridynamics"];

/// What could not be recorded.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum RecordError {
    /// No such target.
    #[error("there is no target `{name}`; there are {}", TARGETS.join(", "))]
    NoTarget {
        /// Its name.
        name: String,
    },
    /// What is recorded is a commit.
    #[error("not recorded: these files are not as committed: {}", .files.join(", "))]
    Uncommitted {
        /// Outside `docs`.
        files: Vec<String>,
    },
    /// No commit, no record.
    #[error("not recorded: there is no git here, or no commit")]
    NoCommit,
    /// A target that failed.
    #[error("the target `{name}` failed")]
    Failed {
        /// Its name.
        name: String,
    },
    /// A file.
    #[error("{}: {source}", .path.display())]
    File {
        /// Which.
        path: PathBuf,
        /// What the system said.
        source: io::Error,
    },
    /// A file that is not what it should be.
    #[error("{}: {source}", .path.display())]
    Json {
        /// Which.
        path: PathBuf,
        /// Where and why.
        source: serde_json::Error,
    },
}

/// A table with its title: what a target prints, and what is recorded of it.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Listed {
    /// What is listed.
    pub title: String,
    /// Heads of the columns.
    pub head: Vec<String>,
    /// As many cells each.
    pub rows: Vec<Vec<String>>,
}

/// The tables that a target prints.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Tables {
    /// In their order.
    pub tables: Vec<Listed>,
    /// Lines below them.
    pub notes: Vec<String>,
}

/// One measurement of criterion.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Measured {
    /// Group and function.
    pub name: String,
    /// Median CPU time (ns), and its interval of 95 %.
    pub median: f64,
    /// Lower and upper end (ns).
    pub interval: [f64; 2],
    /// Elements of one run, where they are counted.
    pub elements: Option<u64>,
}

/// A target as it was run.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Recorded {
    /// Its name.
    pub target: String,
    /// What was typed.
    pub command: String,
    /// The commit that was built.
    pub commit: String,
    /// The day in Greenwich.
    pub date: Option<String>,
    /// Model of the processor.
    pub cpu: Option<String>,
    /// Logical processors.
    pub cores: usize,
    /// The widest registers that ours use.
    pub instruction_set: String,
    /// Load average over a minute, before and after.
    pub load: [String; 2],
    /// What it printed.
    pub tables: Tables,
    /// What criterion measured.
    pub measured: Vec<Measured>,
}

/// Leaves tables where a record asks for them; without a record it does nothing.
///
/// # Errors
/// Those of the file.
pub fn leave(tables: &Tables) -> Result<(), RecordError> {
    match std::env::var_os(TABLES) {
        None => Ok(()),
        Some(path) => write(Path::new(&path), tables),
    }
}

/// Writes a value as JSON, making missing folders.
///
/// # Errors
/// Those of the file.
pub fn write<T: Serialize>(path: &Path, value: &T) -> Result<(), RecordError> {
    let json = |source| RecordError::Json { path: path.into(), source };
    let text = serde_json::to_string_pretty(value).map_err(json)? + "\n";
    write_text(path, &text)
}

/// Writes text, making missing folders.
///
/// # Errors
/// Those of the file.
pub fn write_text(path: &Path, text: &str) -> Result<(), RecordError> {
    let file = |source| RecordError::File { path: path.into(), source };
    path.parent().map_or(Ok(()), fs::create_dir_all).map_err(file)?;
    fs::write(path, text).map_err(file)
}

/// Reads a value; the default where there is no such file.
///
/// # Errors
/// Those of the file, and of what stands in it.
pub fn read<T: for<'a> Deserialize<'a> + Default>(path: &Path) -> Result<T, RecordError> {
    match fs::read_to_string(path) {
        Ok(text) => serde_json::from_str(&text)
            .map_err(|source| RecordError::Json { path: path.into(), source }),
        Err(error) if error.kind() == io::ErrorKind::NotFound => Ok(T::default()),
        Err(source) => Err(RecordError::File { path: path.into(), source }),
    }
}

/// What criterion writes of a benchmark, as far as it is asked for.
#[derive(Debug, Default, Deserialize)]
struct Benchmark {
    title: String,
    throughput: Option<BTreeMap<String, u64>>,
}

#[derive(Debug, Default, Deserialize)]
struct Estimates {
    median: Estimate,
}

#[derive(Debug, Default, Deserialize)]
struct Estimate {
    point_estimate: f64,
    confidence_interval: Interval,
}

#[derive(Debug, Default, Deserialize)]
struct Interval {
    lower_bound: f64,
    upper_bound: f64,
}

/// All that criterion has measured into a folder, by name; none where there is no such folder.
///
/// # Errors
/// Those of the files.
pub fn measured(folder: &Path) -> Result<Vec<Measured>, RecordError> {
    let mut found = Vec::new();
    let mut folders = vec![folder.to_owned()];
    while let Some(folder) = folders.pop() {
        // What is no folder has nothing in it.
        for entry in fs::read_dir(&folder).into_iter().flatten().flatten() {
            folders.push(entry.path());
        }
        if folder.file_name().is_some_and(|name| name == "new") {
            let benchmark: Benchmark = read(&folder.join("benchmark.json"))?;
            let Estimates { median } = read(&folder.join("estimates.json"))?;
            let Interval { lower_bound, upper_bound } = median.confidence_interval;
            found.push(Measured {
                name: benchmark.title,
                median: median.point_estimate,
                interval: [lower_bound, upper_bound],
                elements: benchmark.throughput.and_then(|of| of.get("Elements").copied()),
            });
        }
    }
    found.sort_by(|a, b| a.name.cmp(&b.name));
    Ok(found)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_target_is_in_the_manifest_and_none_else() {
        let manifest = include_str!("../Cargo.toml");
        let mut listed: Vec<&str> = manifest
            .split("[[bench]]\nname = \"")
            .skip(1)
            .filter_map(|rest| rest.split('"').next())
            .collect();
        let mut targets = TARGETS;
        listed.sort_unstable();
        targets.sort_unstable();
        assert_eq!(listed, targets);
    }
}
