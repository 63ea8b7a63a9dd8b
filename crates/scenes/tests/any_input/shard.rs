//! Shards of small ensembles with changed bytes, as they are and with a corrected hash.

use std::path::PathBuf;
use std::sync::LazyLock;

use proptest::prelude::*;
use scenes::checkpoint::CheckpointError;
use scenes::{ALL, EnsemblePart, Options, Progress, RunError, run};
use twox_hash::XxHash64;

use super::changes::changes;

/// The body of a file follows its kind and the length of the body; a hash follows the body.
const BEFORE: usize = 16;
const BEHIND: usize = 8;

/// Factor by which fewer inputs are tried where the merge takes longer.
const SLOWER: u32 = 100;

/// Two shards of a scene, and the folder of the merge.
pub(crate) struct Ensemble {
    scene: PathBuf,
    folder: PathBuf,
    first: Vec<u8>,
    second: PathBuf,
}

impl Ensemble {
    fn new(name: &str, text: &str) -> Self {
        // A cargo-fuzz target has no temporary folder of cargo.
        let tests = option_env!("CARGO_TARGET_TMPDIR").map(PathBuf::from);
        let root = tests.unwrap_or_else(std::env::temp_dir);
        let folder = root.join(format!("any-input-{name}"));
        let _ = std::fs::remove_dir_all(&folder);
        std::fs::create_dir_all(&folder).unwrap();
        let scene = folder.join("scene.json");
        std::fs::write(&scene, text).unwrap();
        let [first, second] = ["1/2", "2/2"].map(|place| {
            let part = EnsemblePart::Shard(place.parse().unwrap());
            let options = Options { part, ..Options::new(folder.join("shards")) };
            run(ALL, &scene, &options, &Progress::silent()).unwrap().files.swap_remove(0)
        });
        let first = std::fs::read(first).unwrap();
        Self { scene, folder, first, second }
    }

    /// Merges these bytes with the second shard.
    fn join(&self, name: &str, first: &[u8]) -> Result<Vec<PathBuf>, RunError> {
        let file = self.folder.join(format!("{name}.bin"));
        // An overwritten file is on disk before this continues; a new one need not be.
        let _ = std::fs::remove_file(&file);
        std::fs::write(&file, first).unwrap();
        let options = Options {
            part: EnsemblePart::Merged(vec![file, self.second.clone()]),
            ..Options::new(self.folder.join(format!("{name}-joined")))
        };
        run(ALL, &self.scene, &options, &Progress::silent()).map(|it| it.files)
    }
}

pub(crate) static PATHS: LazyLock<Ensemble> =
    LazyLock::new(|| Ensemble::new("paths", include_str!("shards/paths.json")));

pub(crate) static SAMPLES: LazyLock<Ensemble> =
    LazyLock::new(|| Ensemble::new("samples", include_str!("shards/samples.json")));

pub(crate) static CRACKS: LazyLock<Ensemble> =
    LazyLock::new(|| Ensemble::new("cracks", include_str!("shards/cracks.json")));

impl Ensemble {
    /// The first shard between its head and its hash.
    pub(crate) fn body(&self) -> &[u8] {
        &self.first[BEFORE..self.first.len() - BEHIND]
    }

    /// The first shard with a forged body merges with the second or is rejected with an error.
    pub(crate) fn forged(&self, body: &[u8]) -> Result<Vec<PathBuf>, RunError> {
        self.forged_as("forged", body)
    }

    /// The same in a folder of a certain name: two merges at once take two folders.
    fn forged_as(&self, name: &str, body: &[u8]) -> Result<Vec<PathBuf>, RunError> {
        let mut forged = self.first[..8].to_vec();
        forged.extend((body.len() as u64).to_le_bytes());
        forged.extend(body);
        let hash = XxHash64::oneshot(0, &forged);
        forged.extend(hash.to_le_bytes());
        self.join(name, &forged)
    }
}

#[test]
fn shards_that_nobody_changed_are_joined() {
    for ensemble in [&PATHS, &SAMPLES, &CRACKS] {
        ensemble.join("whole", &ensemble.first).unwrap();
        ensemble.forged_as("whole-forged", ensemble.body()).unwrap();
    }
}

proptest! {
    #[test]
    fn a_shard_with_other_bytes_is_refused(changes in changes()) {
        let bytes = changes.of(&PATHS.first);
        let joined = PATHS.join("changed", &bytes);
        let is_refused = matches!(joined, Err(RunError::Checkpoint(CheckpointError::Refused(_))));
        prop_assert!(is_refused || bytes == PATHS.first, "{joined:?}");
    }

    #[test]
    fn forged_paths_are_joined_or_say_why_not(changes in changes()) {
        let _ = PATHS.forged(&changes.of(PATHS.body()));
    }
}

proptest! {
    // The merge computes the reference run, or the bonds of a plate.
    #![proptest_config(ProptestConfig::with_cases(ProptestConfig::default().cases.div_ceil(SLOWER)))]

    #[test]
    fn forged_samples_are_joined_or_say_why_not(changes in changes()) {
        let _ = SAMPLES.forged(&changes.of(SAMPLES.body()));
    }

    #[test]
    fn forged_cracks_are_joined_or_say_why_not(changes in changes()) {
        let _ = CRACKS.forged(&changes.of(CRACKS.body()));
    }
}
