//! One file of a checkpoint.
//!
//! Its layout is `SPCHECK4`, the length of the rest without its hash (8 bytes, little endian), head and parts, and
//! XXH64 of all preceding bytes.

use std::collections::BTreeMap;
use std::fs::File;
use std::io::{self, Write};
use std::path::{Path, PathBuf};

use serde::{Deserialize, Serialize};
use serde_json::Value;
use twox_hash::XxHash64;

use super::error::{CheckpointError, Reason};
use crate::scene::NamedFile;

const MAGIC: &[u8; 8] = b"SPCHECK4";
/// Length of signature and length field.
const BEFORE: usize = 16;
/// Length of the hash.
const BEHIND: usize = 8;

/// Identity of a checkpoint: a run resumes only if all fields are equal.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct Head {
    version: String,
    simd: String,
    solver: String,
    /// All keys that affect the results, as JSON.
    scene: String,
    /// `none` for a run without random numbers.
    seed: String,
    files: Vec<NamedFile>,
}

impl Head {
    /// The identity of a scene with this version of a solver and the instruction set of this machine.
    ///
    /// `scene` contains all keys that affect the results. Title, end time and output keys are excluded, so a longer
    /// run can resume from a shorter one. The seed is stored separately, so that an error can name it. `files` are the
    /// files named by the scene.
    #[must_use]
    pub fn new(solver: &str, scene: &Value, seed: Option<u64>, files: &[NamedFile]) -> Self {
        Self {
            version: env!("CARGO_PKG_VERSION").to_owned(),
            simd: sde_integrators::SimdLevel::best().name().to_owned(),
            solver: solver.to_owned(),
            scene: scene.to_string(),
            seed: seed.map_or_else(|| "none".to_owned(), |seed| seed.to_string()),
            files: files.to_vec(),
        }
    }

    /// The same for results joined from several machines: they are bitwise identical for all instruction sets.
    #[must_use]
    pub fn of_shards(solver: &str, scene: &Value, seed: Option<u64>, files: &[NamedFile]) -> Self {
        Self { simd: "any".to_owned(), ..Self::new(solver, scene, seed, files) }
    }

    /// All fields of the identity with their names.
    #[must_use]
    pub fn fields(&self) -> Vec<(String, String)> {
        let Self { version, simd, solver, scene, seed, files } = self;
        let scene = &format!("{:016x}", hash(scene.as_bytes()));
        let words = [
            ("version", version),
            ("solver", solver),
            ("seed", seed),
            ("scene (hash)", scene),
            ("instruction set", simd),
        ];
        let words = words.into_iter().map(|(name, value)| (name.to_owned(), value.clone()));
        let of_file = |file: &NamedFile| (format!("file {}", file.path), file.xxh64.clone());
        words.chain(files.iter().map(of_file)).collect()
    }

    /// The first difference.
    fn foreign(&self, found: &Self) -> Option<Reason> {
        let fields = [
            ("version", &self.version, &found.version),
            ("solver", &self.solver, &found.solver),
            ("seed", &self.seed, &found.seed),
            ("instruction set", &self.simd, &found.simd),
        ];
        if self.scene != found.scene && self.solver == found.solver && self.seed == found.seed {
            return Some(Reason::OtherScene { keys: changed(&found.scene, &self.scene) });
        }
        let differs = fields.into_iter().find(|(_, expected, found)| expected != found);
        match differs {
            Some((what, expected, found)) => {
                Some(Reason::Foreign { what, found: found.clone(), expected: expected.clone() })
            }
            None => self.other_file(found),
        }
    }

    /// The first file whose bytes differ, or that exists on one side only.
    fn other_file(&self, found: &Self) -> Option<Reason> {
        let hash = |head: &Self, path: &str| {
            let file = head.files.iter().find(|file| file.path == path);
            file.map_or_else(|| "none".to_owned(), |file| file.xxh64.clone())
        };
        self.files.iter().chain(&found.files).find_map(|NamedFile { path, .. }| {
            let (found, expected) = (hash(found, path), hash(self, path));
            let file = path.clone();
            (found != expected).then_some(Reason::OtherFile { file, found, expected })
        })
    }
}

/// Most keys that a message lists.
const MOST_KEYS: usize = 5;

/// The keys in which two scenes differ, with their values.
fn changed(found: &str, expected: &str) -> String {
    let [found, expected] =
        [found, expected].map(|text| serde_json::from_str::<Value>(text).unwrap_or_default());
    let mut keys = Vec::new();
    compare("", &found, &expected, &mut keys);
    let more = keys.len().saturating_sub(MOST_KEYS);
    keys.truncate(MOST_KEYS);
    if more > 0 {
        keys.push(format!("and {more} more"));
    }
    keys.join("; ")
}

fn compare(key: &str, found: &Value, expected: &Value, keys: &mut Vec<String>) {
    match (found, expected) {
        (Value::Object(a), Value::Object(b)) => {
            for name in a.keys().chain(b.keys().filter(|name| !a.contains_key(*name))) {
                let dot = if key.is_empty() { "" } else { "." };
                let of =
                    |it: &serde_json::Map<String, Value>| it.get(name).cloned().unwrap_or_default();
                compare(&format!("{key}{dot}{name}"), &of(a), &of(b), keys);
            }
        }
        (Value::Array(a), Value::Array(b)) if a.len() == b.len() => {
            for (k, (a, b)) in a.iter().zip(b).enumerate() {
                compare(&format!("{key}[{k}]"), a, b, keys);
            }
        }
        (found, expected) if found == expected => {}
        (found, expected) => keys.push(format!("{key} was {found} and is {expected}")),
    }
}

/// State of the run that wrote a file.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub(super) enum Stage {
    /// The run is unfinished.
    UnderWay,
    /// Its results are written.
    Ended,
}

/// Parts by their names, as bytes.
pub(super) type Parts = BTreeMap<String, Vec<u8>>;

/// Content of a file.
#[derive(Debug, Serialize, Deserialize)]
pub(super) struct Content<H = Head, P = Parts> {
    head: H,
    /// Number of files written before.
    pub(super) sequence: u64,
    pub(super) stage: Stage,
    pub(super) parts: P,
}

impl Content {
    /// Returns the content if its identity equals the head.
    pub(super) fn of(self, head: &Head) -> Result<Self, Reason> {
        head.foreign(&self.head).map_or(Ok(self), Err)
    }
}

/// The two files in a folder.
pub(super) fn names(folder: &Path) -> [PathBuf; 2] {
    ["checkpoint-0.bin", "checkpoint-1.bin"].map(|name| folder.join(name))
}

/// Reads a file of any run, or the reason why it is invalid; `None` if it does not exist.
pub(super) fn read(path: &Path) -> Result<Option<Result<Content, Reason>>, CheckpointError> {
    match std::fs::read(path) {
        Ok(bytes) => Ok(Some(content(&bytes))),
        Err(error) if error.kind() == io::ErrorKind::NotFound => Ok(None),
        Err(source) => Err(CheckpointError::Io { path: path.to_owned(), source }),
    }
}

fn content(bytes: &[u8]) -> Result<Content, Reason> {
    let Some((magic, rest)) = bytes.split_first_chunk::<8>() else {
        return Err(Reason::NoCheckpoint);
    };
    if magic != MAGIC {
        let is_older = magic[..7] == MAGIC[..7];
        return Err(if is_older { Reason::OtherLayout } else { Reason::NoCheckpoint });
    }
    let found = bytes.len() as u64;
    let Some((length, rest)) = rest.split_first_chunk::<8>() else {
        return Err(Reason::CutOff { found, expected: (BEFORE + BEHIND) as u64 });
    };
    let expected = u64::from_le_bytes(*length).saturating_add((BEFORE + BEHIND) as u64);
    let whole = (found == expected).then(|| rest.split_last_chunk::<BEHIND>()).flatten();
    let Some((body, written)) = whole else {
        return Err(Reason::CutOff { found, expected });
    };
    let (written, of_bytes) = (u64::from_le_bytes(*written), hash(&bytes[..BEFORE + body.len()]));
    if written != of_bytes {
        return Err(Reason::Damaged { found: of_bytes, expected: written });
    }
    // A file with the right hash that cannot be decoded comes from another program.
    postcard::from_bytes(body).map_err(|_| Reason::NoCheckpoint)
}

/// Writes a temporary file and renames it, so the file is old or new and never partial.
pub(super) fn write(
    path: &Path,
    head: &Head,
    (sequence, stage): (u64, Stage),
    parts: &Parts,
    survives: Survives,
) -> Result<(), CheckpointError> {
    let body = postcard::to_stdvec(&Content { head, sequence, stage, parts })
        .map_err(|source| CheckpointError::Part { name: "head".to_owned(), source })?;
    let mut bytes = Vec::with_capacity(BEFORE + body.len() + BEHIND);
    bytes.extend_from_slice(MAGIC);
    bytes.extend_from_slice(&(body.len() as u64).to_le_bytes());
    bytes.extend_from_slice(&body);
    let hash = hash(&bytes);
    bytes.extend_from_slice(&hash.to_le_bytes());
    replace(path, &bytes, survives)
        .map_err(|source| CheckpointError::Io { path: path.to_owned(), source })
}

/// Event that a written file survives.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Survives {
    /// A crash of the machine: the file is on disk before it gets its name.
    Machine,
    /// The end of the process, for one of many files that are cheap to recompute: it does not wait for the disk. A crash of the machine
    /// may truncate it, which is detected on reading.
    Process,
}

fn replace(path: &Path, bytes: &[u8], survives: Survives) -> io::Result<()> {
    if let Some(folder) = path.parent().filter(|folder| !folder.as_os_str().is_empty()) {
        std::fs::create_dir_all(folder)?;
    }
    let beside = path.with_extension("tmp");
    let mut file = File::create(&beside)?;
    file.write_all(bytes)?;
    if survives == Survives::Machine {
        file.sync_all()?;
    }
    std::fs::rename(&beside, path)
}

fn hash(bytes: &[u8]) -> u64 {
    XxHash64::oneshot(0, bytes)
}
