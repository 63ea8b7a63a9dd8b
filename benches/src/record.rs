//! Record of a run of a target: tables, measurements of criterion, and conditions.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::{fs, io};

use serde::{Deserialize, Serialize};

/// Environment variable with the file for a target's tables.
pub const TABLES: &str = "BENCHES_TABLES";

/// All targets, in the order of the page.
pub const TARGETS: [&str; 9] =
    ["plain", "kernels", "neighbour", "particles", "sde", "moments", "fpk", "smpm", "peridynamics"];

/// Error of recording.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum RecordError {
    /// The target does not exist.
    #[error("there is no target `{name}`; available: {}", TARGETS.join(", "))]
    NoTarget {
        /// Its name.
        name: String,
    },
    /// Files differ from the commit.
    #[error("not recorded: these files differ from the commit: {}", .files.join(", "))]
    Uncommitted {
        /// Files outside `docs`.
        files: Vec<String>,
    },
    /// There is no commit.
    #[error("not recorded: there is no commit")]
    NoCommit,
    /// A target failed.
    #[error("the target `{name}` failed")]
    Failed {
        /// Its name.
        name: String,
    },
    /// Access to a file failed.
    #[error("{}: {source}", .path.display())]
    File {
        /// The file.
        path: PathBuf,
        /// Error of the file system.
        source: io::Error,
    },
    /// A file has the wrong contents.
    #[error("{}: {source}", .path.display())]
    Json {
        /// The file.
        path: PathBuf,
        /// Position and cause.
        source: serde_json::Error,
    },
}

/// A table with its title, printed by a target and recorded.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Listed {
    /// Title.
    pub title: String,
    /// Column heads.
    pub head: Vec<String>,
    /// Rows with as many cells.
    pub rows: Vec<Vec<String>>,
}

/// Tables of a target.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Tables {
    /// Tables in order.
    pub tables: Vec<Listed>,
    /// Lines below them.
    pub notes: Vec<String>,
}

/// A measurement of criterion.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Measured {
    /// Group and function.
    pub name: String,
    /// Median CPU time (ns).
    pub median: f64,
    /// Lower and upper end of its 95 % interval (ns).
    pub interval: [f64; 2],
    /// Number of elements of one run, if counted.
    pub elements: Option<u64>,
}

/// A run of a target.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Recorded {
    /// Its name.
    pub target: String,
    /// Command line.
    pub command: String,
    /// Commit of the build.
    pub commit: String,
    /// Date in UTC.
    pub date: Option<String>,
    /// Model of the processor.
    pub cpu: Option<String>,
    /// Logical processors.
    pub cores: usize,
    /// Widest registers used.
    pub instruction_set: String,
    /// Load average over a minute, before and after.
    pub load: [String; 2],
    /// Printed tables.
    pub tables: Tables,
    /// Measurements of criterion.
    pub measured: Vec<Measured>,
}

/// Writes tables for a record; without a record it does nothing.
///
/// # Errors
/// Errors of the file.
pub fn leave(tables: &Tables) -> Result<(), RecordError> {
    match std::env::var_os(TABLES) {
        None => Ok(()),
        Some(path) => write(Path::new(&path), tables),
    }
}

/// Writes a value as JSON; creates missing folders.
///
/// # Errors
/// Errors of the file.
pub fn write<T: Serialize>(path: &Path, value: &T) -> Result<(), RecordError> {
    let json = |source| RecordError::Json { path: path.into(), source };
    let text = serde_json::to_string_pretty(value).map_err(json)? + "\n";
    write_text(path, &text)
}

/// Writes text; creates missing folders.
///
/// # Errors
/// Errors of the file.
pub fn write_text(path: &Path, text: &str) -> Result<(), RecordError> {
    let file = |source| RecordError::File { path: path.into(), source };
    path.parent().map_or(Ok(()), fs::create_dir_all).map_err(file)?;
    fs::write(path, text).map_err(file)
}

/// Reads a value; the default if the file does not exist.
///
/// # Errors
/// Errors of the file and of its contents.
pub fn read<T: for<'a> Deserialize<'a> + Default>(path: &Path) -> Result<T, RecordError> {
    match fs::read_to_string(path) {
        Ok(text) => serde_json::from_str(&text)
            .map_err(|source| RecordError::Json { path: path.into(), source }),
        Err(error) if error.kind() == io::ErrorKind::NotFound => Ok(T::default()),
        Err(source) => Err(RecordError::File { path: path.into(), source }),
    }
}

/// The used part of criterion's output for a benchmark.
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

/// All measurements of criterion in a folder, by name; none if the folder does not exist.
///
/// # Errors
/// Errors of the files.
pub fn measured(folder: &Path) -> Result<Vec<Measured>, RecordError> {
    let mut found = Vec::new();
    let mut folders = vec![folder.to_owned()];
    while let Some(folder) = folders.pop() {
        // A path that is no folder has no entries.
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
