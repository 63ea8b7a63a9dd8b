//! What a recorded proof was made from: the text of cases, scenes and references, each file by its hash.

use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};
use std::{fmt, io};

use twox_hash::XxHash64;

use crate::case::{Case, Profile};

/// What is hashed, from the root of the workspace: a file, or a folder with all in it.
const SOURCES: [&str; 4] =
    ["tests/src/cases.rs", "tests/src/cases", "tests/reference", "tests/scenes"];
/// Around the list in a page, where a reader does not see it.
const BEGIN: &str = "<!-- made from";
const END: &str = "-->";

/// What a proof is made from.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Fingerprint {
    /// How much was run.
    profile: Profile,
    /// The ids of the cases.
    cases: BTreeSet<String>,
    /// XXH64 of each file by its path from the root.
    files: BTreeMap<String, String>,
}

/// A file or folder that could not be read.
#[derive(Debug, thiserror::Error)]
#[error("cannot read {}", .path.display())]
pub struct SourceError {
    /// Which.
    path: PathBuf,
    /// What the system said.
    source: io::Error,
}

/// What makes a recorded proof stale.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Change {
    /// A case that the page does not have.
    CaseAdded(String),
    /// A case that is no more.
    CaseRemoved(String),
    /// A file that was not there.
    FileAdded(String),
    /// A file that is no more.
    FileRemoved(String),
    /// A file with another text.
    FileChanged(String),
}

impl fmt::Display for Change {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::CaseAdded(id) => write!(formatter, "case {id} added"),
            Self::CaseRemoved(id) => write!(formatter, "case {id} removed"),
            Self::FileAdded(path) => write!(formatter, "{path} added"),
            Self::FileRemoved(path) => write!(formatter, "{path} removed"),
            Self::FileChanged(path) => write!(formatter, "{path} changed"),
        }
    }
}

impl Fingerprint {
    /// Reads the files of the workspace at `root`; of `cases` those that `profile` runs.
    ///
    /// # Errors
    /// [`SourceError`], naming the file.
    pub fn read(root: &Path, cases: &[Case], profile: Profile) -> Result<Self, SourceError> {
        let mut files = BTreeMap::new();
        for source in SOURCES {
            hash_into(&mut files, root, source)?;
        }
        let cases = cases.iter().filter(|case| case.cost <= profile);
        Ok(Self { profile, cases: cases.map(|case| case.id.to_owned()).collect(), files })
    }

    /// How much was run.
    #[must_use]
    pub const fn profile(&self) -> Profile {
        self.profile
    }

    /// One hash of everything.
    #[must_use]
    pub fn hash(&self) -> String {
        hash(self.lines().as_bytes())
    }

    /// A comment for the page, which [`Fingerprint::find`] reads.
    #[must_use]
    pub fn comment(&self) -> String {
        format!("{BEGIN}\n{}{END}\n", self.lines())
    }

    /// The fingerprint in the comment of a page; none where there is no such comment.
    #[must_use]
    pub fn find(page: &str) -> Option<Self> {
        let mut lines = page.lines().skip_while(|line| *line != BEGIN).skip(1);
        let profile = Profile::named(lines.next()?.strip_prefix("profile ")?)?;
        let (mut cases, mut files) = (BTreeSet::new(), BTreeMap::new());
        for line in lines.take_while(|line| *line != END) {
            let (kind, rest) = line.split_once(' ')?;
            match kind {
                "case" => {
                    cases.insert(rest.to_owned());
                }
                hash => {
                    files.insert(rest.to_owned(), hash.to_owned());
                }
            }
        }
        Some(Self { profile, cases, files })
    }

    /// What is different in `now`, cases first.
    #[must_use]
    pub fn changes(&self, now: &Self) -> Vec<Change> {
        let mut changes = Vec::new();
        changes.extend(now.cases.difference(&self.cases).cloned().map(Change::CaseAdded));
        changes.extend(self.cases.difference(&now.cases).cloned().map(Change::CaseRemoved));
        for (path, hash) in &now.files {
            match self.files.get(path) {
                None => changes.push(Change::FileAdded(path.clone())),
                Some(recorded) if recorded != hash => {
                    changes.push(Change::FileChanged(path.clone()));
                }
                Some(_) => {}
            }
        }
        let gone = self.files.keys().filter(|path| !now.files.contains_key(*path));
        changes.extend(gone.cloned().map(Change::FileRemoved));
        changes
    }

    fn lines(&self) -> String {
        let profile = format!("profile {}\n", self.profile.name());
        let cases = self.cases.iter().map(|id| format!("case {id}\n"));
        let files = self.files.iter().map(|(path, hash)| format!("{hash} {path}\n"));
        std::iter::once(profile).chain(cases).chain(files).collect()
    }
}

/// Hashes a file, or all files of a folder and those in it.
fn hash_into(
    files: &mut BTreeMap<String, String>,
    root: &Path,
    source: &str,
) -> Result<(), SourceError> {
    let path = root.join(source);
    let refused = |source| SourceError { path: path.clone(), source };
    if !path.is_dir() {
        let text = std::fs::read(&path).map_err(refused)?;
        files.insert(source.to_owned(), hash(&text));
        return Ok(());
    }
    for entry in std::fs::read_dir(&path).map_err(refused)? {
        let name = entry.map_err(refused)?.file_name();
        hash_into(files, root, &format!("{source}/{}", name.to_string_lossy()))?;
    }
    Ok(())
}

/// XXH64 in sixteen digits: two texts that differ by accident share it once in 2^64; it is no proof against intent.
fn hash(text: &[u8]) -> String {
    format!("{:016x}", XxHash64::oneshot(0, text))
}

#[cfg(test)]
pub(super) mod tests {
    use super::*;
    use crate::case::tests::case;

    const CASES: [Case; 3] = [
        case("self-check/a", Profile::Quick),
        case("self-check/b", Profile::Default),
        case("self-check/c", Profile::Full),
    ];

    /// A workspace with a file in each place that counts.
    pub(in crate::verify) fn workspace(name: &str) -> PathBuf {
        let root = std::env::temp_dir().join(format!("{name}-{}", std::process::id()));
        for path in ["cases.rs", "cases/a/deep.rs"] {
            write(&root, &format!("src/{path}"), "a case");
        }
        write(&root, "reference/derived/a.json", "1.0");
        write(&root, "scenes/a.json", "{}");
        root
    }

    pub(in crate::verify) fn write(root: &Path, path: &str, text: &str) {
        scenes::output::write_text(&root.join("tests").join(path), text).unwrap();
    }

    fn read(root: &Path, cases: &[Case]) -> Fingerprint {
        Fingerprint::read(root, cases, Profile::Default).unwrap()
    }

    #[test]
    fn a_page_gives_back_what_was_written_into_it() {
        let root = workspace("fingerprint-page");
        let recorded = read(&root, &CASES);
        let page = format!("# A page\n\n{}", recorded.comment());
        assert_eq!(Fingerprint::find(&page), Some(recorded));
        assert_eq!(Fingerprint::find("# A page\n"), None);
        std::fs::remove_dir_all(&root).unwrap();
    }

    #[test]
    fn every_change_is_named_and_nothing_else() {
        let root = workspace("fingerprint-changes");
        let before = read(&root, &CASES);
        // Outside what is hashed, and a case that the profile leaves out.
        write(&root, "src/claim.rs", "no case");
        assert_eq!(before.changes(&read(&root, &CASES[..2])), []);
        assert_eq!(before.hash(), read(&root, &CASES).hash());
        write(&root, "reference/derived/a.json", "1.1");
        write(&root, "scenes/b.json", "{}");
        std::fs::remove_file(root.join("tests/src/cases/a/deep.rs")).unwrap();
        let now = read(&root, &[CASES[1], case("self-check/d", Profile::Quick)]);
        let words: Vec<String> = before.changes(&now).iter().map(ToString::to_string).collect();
        assert_eq!(
            words,
            [
                "case self-check/d added",
                "case self-check/a removed",
                "tests/reference/derived/a.json changed",
                "tests/scenes/b.json added",
                "tests/src/cases/a/deep.rs removed",
            ]
        );
        assert_ne!(before.hash(), now.hash());
        std::fs::remove_dir_all(&root).unwrap();
    }

    #[test]
    fn a_folder_that_is_not_there_is_an_error() {
        let error = Fingerprint::read(Path::new("nowhere"), &CASES, Profile::Full).unwrap_err();
        assert_eq!(error.to_string(), "cannot read nowhere/tests/src/cases.rs");
    }

    #[test]
    fn the_hash_is_xxh64() {
        // Published value of the empty text with seed 0.
        assert_eq!(hash(b""), "ef46db3751d8e999");
    }
}
