//! Scenes that run in folders of their own, and their results.

use std::path::{Path, PathBuf};

use mpi_ensembles::ThreadRank;
use scenes::checkpoint::{CheckpointError, Start};
use scenes::scene::{Mistake, SceneError};
use scenes::{ALL, EnsemblePart, Options, Progress, RunError, run, run_on_ranks};
use serde_json::Value;
use tempfile::TempDir;

/// The text with some parts replaced, in which `'` is `"`.
pub(crate) fn changed(text: &str, changes: &[(&str, &str)]) -> String {
    changes.iter().fold(text.to_owned(), |text, (from, to)| {
        let [from, to] = [from, to].map(|part| part.replace('\'', "\""));
        assert!(text.contains(&from), "{from}");
        text.replace(&from, &to)
    })
}

/// A run in a temporary folder: `scene.json`, files that it names, and the results in `out`.
pub(crate) struct SceneRun {
    folder: TempDir,
    pub(crate) written: Result<Vec<PathBuf>, RunError>,
}

impl SceneRun {
    pub(crate) fn of(text: &str) -> Self {
        Self::beside(text, &[])
    }

    /// Runs a text with files in the same folder.
    pub(crate) fn beside(text: &str, files: &[(&str, &[u8])]) -> Self {
        let mut ran = Self { folder: tempfile::tempdir().unwrap(), written: Ok(Vec::new()) };
        for (file, bytes) in files {
            std::fs::write(ran.folder().join(file), bytes).unwrap();
        }
        ran.write(text);
        ran.written = ran.again(&ran.options("out"));
        ran
    }

    pub(crate) fn folder(&self) -> &Path {
        self.folder.path()
    }

    pub(crate) fn out(&self) -> PathBuf {
        self.folder().join("out")
    }

    /// Options of a run into another folder beside the scene.
    pub(crate) fn options(&self, out: &str) -> Options {
        Options::new(self.folder().join(out))
    }

    /// Replaces the scene.
    pub(crate) fn write(&self, text: &str) {
        std::fs::write(self.folder().join("scene.json"), text).unwrap();
    }

    /// Runs the scene of the folder again.
    pub(crate) fn again(&self, options: &Options) -> Result<Vec<PathBuf>, RunError> {
        let scene = self.folder().join("scene.json");
        run(ALL, &scene, options, &Progress::silent()).map(|it| it.files)
    }

    /// Replaces the scene, and continues the run in `out`.
    pub(crate) fn resume(&self, text: &str) -> Result<Vec<PathBuf>, RunError> {
        self.write(text);
        self.again(&Options { start: Start::GoOn, ..self.options("out") })
    }

    /// The file of a shard of the scene, such as `1/3`, in a folder.
    pub(crate) fn shard(&self, place: &str, out: &str) -> Result<PathBuf, RunError> {
        let part = EnsemblePart::Shard(place.parse().unwrap());
        self.again(&Options { part, ..self.options(out) }).map(|mut files| files.remove(0))
    }

    /// Joins shards of the scene in the folder `merged`.
    pub(crate) fn merge(&self, shards: &[&PathBuf]) -> Result<Vec<PathBuf>, RunError> {
        let part = EnsemblePart::Merged(shards.iter().map(|&shard| shard.clone()).collect());
        self.again(&Options { part, ..self.options("merged") })
    }

    /// The result; every file that the run names is there.
    pub(crate) fn result(&self) -> Value {
        let written = self.written.as_ref().unwrap();
        assert!(written.iter().all(|path| path.exists()), "{written:?}");
        result_in(&self.out())
    }

    pub(crate) fn mistake(&self) -> &Mistake {
        mistake_of(self.written.as_ref().unwrap_err())
    }
}

/// What an error objects to in the text of a scene.
pub(crate) fn mistake_of(error: &RunError) -> &Mistake {
    let RunError::Scene(SceneError::Mistake(mistake)) = error else { panic!("{error:?}") };
    mistake
}

/// The result in a folder.
pub(crate) fn result_in(out: &Path) -> Value {
    serde_json::from_slice(&std::fs::read(out.join("result.json")).unwrap()).unwrap()
}

/// The result in a folder without machine, commit and CPU time: a file edited between two runs changes the commit.
pub(crate) fn numbers_in(out: &Path) -> Value {
    let mut result = result_in(out);
    for (parent, key) in [("", "machine"), ("", "commit"), ("/work", "cpu_seconds")] {
        result.pointer_mut(parent).unwrap().as_object_mut().unwrap().remove(key).unwrap();
    }
    result
}

/// The checkpoints in a folder.
pub(crate) fn checkpoints(out: &Path) -> Vec<Vec<u8>> {
    let files = ["checkpoint-0.bin", "checkpoint-1.bin"].map(|name| out.join(name));
    files.iter().filter_map(|file| std::fs::read(file).ok()).collect()
}

/// The folder of a run of the scene on three ranks.
pub(crate) fn on_three_ranks(ran: &SceneRun) -> PathBuf {
    let (scene, options) = (ran.folder().join("scene.json"), ran.options("ranks"));
    std::thread::scope(|scope| {
        for rank in ThreadRank::all(3) {
            let (scene, options) = (&scene, &options);
            scope.spawn(move || {
                run_on_ranks(ALL, scene, options, &Progress::silent(), &rank).unwrap()
            });
        }
    });
    options.out
}

/// Three shards in any order, and three ranks, have the numbers of one run, which are returned. Shards that do not belong together are
/// refused, and those of another scene too.
pub(crate) fn whole_merged_and_on_ranks(text: &str, other: &str) -> Value {
    let ran = SceneRun::of(text);
    ran.result();
    let whole = numbers_in(&ran.out());
    let files =
        ["1/3", "2/3", "3/3"].map(|place| ran.shard(place, &place.replace('/', "-")).unwrap());
    ran.merge(&[&files[2], &files[0], &files[1]]).unwrap();
    assert_eq!(numbers_in(&ran.folder().join("merged")), whole);
    assert_eq!(numbers_in(&on_three_ranks(&ran)), whole);

    let half = ran.shard("1/2", "half").unwrap();
    ran.write(other);
    let foreign = ran.shard("2/3", "foreign").unwrap();
    ran.write(text);
    for (shards, words) in [
        (vec![&files[0], &files[2]], "shard 2/3 is missing"),
        (vec![&files[0], &files[1], &files[1]], "given twice"),
        (vec![&files[0], &half], "1/2"),
        (vec![&files[0], &foreign, &files[2]], "is of another"),
    ] {
        let refused = ran.merge(&shards).unwrap_err().to_string();
        assert!(refused.contains(words), "{words}: {refused}");
    }
    whole
}

/// A file that is no shard is refused, although the scene itself cannot run.
pub(crate) fn no_shard_is_refused_first(ran: &SceneRun) {
    assert!(ran.written.is_err(), "{:?}", ran.written);
    let joined = ran.merge(&[&ran.folder().join("scene.json")]);
    assert!(matches!(joined, Err(RunError::Checkpoint(CheckpointError::Refused(_)))), "{joined:?}");
}
