use super::error::Reason;
use super::*;
use crate::scene::NamedFile;

const OFTEN: Duration = Duration::ZERO;

/// A temporary folder, removed at the end.
struct Folder(PathBuf);

impl Folder {
    fn new(name: &str) -> Self {
        Self(std::env::temp_dir().join(format!("checkpoint-{name}-{}", std::process::id())))
    }
}

impl Drop for Folder {
    fn drop(&mut self) {
        let _ = std::fs::remove_dir_all(&self.0);
    }
}

fn head(scene: &str) -> Head {
    Head::new("a-solver", &serde_json::json!({ "what": scene }), None, &[])
}

fn open(folder: &Folder, start: Start) -> Result<(Checkpoint, Found), CheckpointError> {
    Checkpoint::open(&folder.0, head("a scene"), start, OFTEN)
}

/// Two checkpoints; the second contains the number 2.
fn written(name: &str) -> Folder {
    let folder = Folder::new(name);
    let (checkpoint, _) = open(&folder, Start::Anew).unwrap();
    checkpoint.keep("number", &1_u64).unwrap();
    checkpoint.keep("number", &2_u64).unwrap();
    folder
}

fn refusals(error: CheckpointError) -> Vec<Reason> {
    let CheckpointError::Refused(refused) = error else { panic!("{error}") };
    refused.into_iter().map(|refusal| refusal.reason).collect()
}

#[test]
fn a_run_goes_on_from_the_newer_file_and_starts_anew_where_it_is_told_to_or_nothing_is_there() {
    let folder = written("newer");
    let (checkpoint, found) = open(&folder, Start::GoOn).unwrap();
    assert_eq!(checkpoint.part("number").unwrap(), Some(2_u64));
    assert!(found.file.unwrap().ends_with("checkpoint-0.bin"));
    let (over, _) = open(&folder, Start::Overwrite).unwrap();
    assert_eq!(over.part::<u64>("number").unwrap(), None);
    let (empty, found) = open(&Folder::new("empty"), Start::GoOn).unwrap();
    assert_eq!((empty.part::<u64>("number").unwrap(), found.file), (None, None));
}

#[test]
fn a_run_starts_anew_over_one_that_has_ended_and_over_another_only_where_it_is_told_to() {
    let folder = written("anew");
    for scene in ["a scene", "another"] {
        let refused = Checkpoint::open(&folder.0, head(scene), Start::Anew, OFTEN).unwrap_err();
        let CheckpointError::Unfinished { path } = &refused else { panic!("{refused}") };
        assert!(path.ends_with("checkpoint-0.bin"));
    }
    // A run with that option is unfinished too, and its first file is the newest.
    let over = Checkpoint::open(&folder.0, head("another"), Start::Overwrite, OFTEN).unwrap().0;
    over.keep("number", &3_u64).unwrap();
    let refused = open(&folder, Start::Anew).unwrap_err();
    assert!(refused.to_string().contains("checkpoint-1.bin belongs to an unfinished run"));
    over.end().unwrap();
    let (anew, found) = open(&folder, Start::Anew).unwrap();
    assert_eq!((anew.part::<u64>("number").unwrap(), found.file), (None, None));
    // It has stored nothing yet, so the other run can still be resumed.
    let go_on = || Checkpoint::open(&folder.0, head("another"), Start::GoOn, OFTEN).unwrap().0;
    assert_eq!(go_on().part("number").unwrap(), Some(3_u64));
    anew.end().unwrap();
    assert_eq!(go_on().part("number").unwrap(), Some(3_u64));
    anew.keep("number", &4_u64).unwrap();
    assert!(matches!(open(&folder, Start::Anew), Err(CheckpointError::Unfinished { .. })));
}

#[test]
fn files_of_which_nothing_can_be_read_do_not_stop_a_run_that_starts_anew() {
    let folder = written("unreadable");
    for name in ["checkpoint-0.bin", "checkpoint-1.bin"] {
        std::fs::write(folder.0.join(name), "{}").unwrap();
    }
    let (anew, found) = open(&folder, Start::Anew).unwrap();
    assert_eq!((anew.part::<u64>("number").unwrap(), found.refused), (None, Vec::new()));
}

#[test]
fn a_file_that_is_cut_off_or_has_one_bit_turned_is_refused_by_name_and_the_older_one_is_taken() {
    let folder = written("bits");
    let newer = folder.0.join("checkpoint-0.bin");
    let whole = std::fs::read(&newer).unwrap();
    let mut spoilt: Vec<Vec<u8>> = (0..whole.len()).map(|n| whole[..n].to_vec()).collect();
    spoilt.extend((0..8 * whole.len()).map(|bit| {
        let mut bytes = whole.clone();
        bytes[bit / 8] ^= 1 << (bit % 8);
        bytes
    }));
    for bytes in spoilt {
        std::fs::write(&newer, &bytes).unwrap();
        let (checkpoint, found) = open(&folder, Start::GoOn).unwrap();
        assert_eq!(checkpoint.part("number").unwrap(), Some(1_u64));
        assert_eq!(found.refused.len(), 1);
        assert!(found.refused[0].to_string().contains("checkpoint-0.bin is "));
    }
}

#[test]
fn files_of_another_scene_are_refused_by_name_and_nothing_is_run() {
    let folder = written("foreign");
    let error = Checkpoint::open(&folder.0, head("another scene"), Start::GoOn, OFTEN)
        .unwrap_err()
        .to_string();
    assert!(
        error.contains(
            "checkpoint-1.bin is of another scene: what was \"a scene\" and is \"another scene\""
        ),
        "{error}"
    );
    std::fs::write(folder.0.join("checkpoint-0.bin"), "{}").unwrap();
    let reasons = |magic: &[u8; 8]| {
        let bytes = [magic.as_slice(), &[255; 8]].concat();
        std::fs::write(folder.0.join("checkpoint-1.bin"), bytes).unwrap();
        refusals(open(&folder, Start::GoOn).unwrap_err())
    };
    let cut_off = Reason::CutOff { found: 16, expected: u64::MAX };
    assert_eq!(reasons(b"SPCHECK4"), [Reason::NoCheckpoint, cut_off]);
    assert_eq!(reasons(b"SPCHECK3"), [Reason::NoCheckpoint, Reason::OtherLayout]);
}

#[test]
fn a_file_of_other_bytes_or_one_that_was_not_there_is_refused_by_its_name() {
    let folder = Folder::new("named-files");
    let head = |files: &[(&str, &str)]| {
        let file = |&(path, xxh64): &(&str, &str)| NamedFile {
            path: path.to_owned(),
            xxh64: xxh64.to_owned(),
        };
        let files: Vec<NamedFile> = files.iter().map(file).collect();
        Head::new("a-solver", &serde_json::json!({}), None, &files)
    };
    let path = folder.0.join("shard.bin");
    let files = head(&[("a.csv", "1"), ("b.csv", "2")]);
    write_file(&path, &files, &7_u64, Survives::Machine).unwrap();
    assert_eq!(read_file::<u64>(&path, &head(&[("a.csv", "1"), ("b.csv", "2")])).unwrap(), 7);
    for (files, file, found, expected) in [
        (vec![("a.csv", "1"), ("b.csv", "3")], "b.csv", "2", "3"),
        (vec![("a.csv", "1")], "b.csv", "2", "none"),
        (vec![("a.csv", "1"), ("b.csv", "2"), ("c.csv", "4")], "c.csv", "none", "4"),
    ] {
        let [file, found, expected] = [file, found, expected].map(str::to_owned);
        let reasons = refusals(read_file::<u64>(&path, &head(&files)).unwrap_err());
        assert_eq!(reasons, [Reason::OtherFile { file, found, expected }]);
    }
}

#[test]
fn keys_that_differ_are_named_with_their_values() {
    let folder = Folder::new("keys");
    let head = |scene: serde_json::Value| Head::new("a-solver", &scene, None, &[]);
    let old = serde_json::json!({ "a": { "b": [1, { "c": 2 }] }, "d": null, "e": 1, "f": 1, "g": 1, "h": 1 });
    let (checkpoint, _) = Checkpoint::open(&folder.0, head(old), Start::Anew, OFTEN).unwrap();
    checkpoint.keep("number", &1_u64).unwrap();
    let error = |scene: serde_json::Value| {
        Checkpoint::open(&folder.0, head(scene), Start::GoOn, OFTEN).unwrap_err().to_string()
    };
    let new = serde_json::json!({ "a": { "b": [1, { "c": 3 }] }, "d": "x", "e": 1, "f": 1, "g": 1, "h": 1 });
    let found = error(new);
    assert!(
        found.ends_with("another scene: a.b[1].c was 2 and is 3; d was null and is \"x\""),
        "{found}"
    );
    let found =
        error(serde_json::json!({ "a": 0, "d": null, "e": 2, "f": 2, "g": 2, "h": 2 , "i": 2 }));
    assert!(found.ends_with("g was 1 and is 2; h was 1 and is 2; and 1 more"), "{found}");
}

#[test]
fn a_checkpoint_is_due_when_the_last_was_long_ago() {
    let folder = Folder::new("due");
    let hour = Duration::from_secs(3600);
    let (rarely, _) = Checkpoint::open(&folder.0, head("x"), Start::Anew, hour).unwrap();
    let (often, _) = Checkpoint::open(&folder.0, head("x"), Start::Anew, OFTEN).unwrap();
    assert!(often.is_due() && !rarely.is_due());
}

#[test]
fn parts_in_quick_succession_are_written_together_at_the_end() {
    let folder = Folder::new("quick");
    let hour = Duration::from_secs(3600);
    let open = |start| Checkpoint::open(&folder.0, head("x"), start, hour).unwrap();
    let (checkpoint, _) = open(Start::Anew);
    checkpoint.keep_if_due("one", &1_u64).unwrap();
    checkpoint.keep_if_due("two", &2_u64).unwrap();
    assert_eq!(checkpoint.part("one").unwrap(), Some(1_u64));
    assert!(open(Start::GoOn).1.file.is_none());
    checkpoint.end().unwrap();
    let (again, _) = open(Start::GoOn);
    let parts = ["one", "two"].map(|name| again.part::<u64>(name).unwrap());
    assert_eq!(parts, [Some(1), Some(2)]);
}
