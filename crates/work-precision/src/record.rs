//! Results that go into the documents: where they stand, and when they may.

use std::path::{Path, PathBuf};

use scenes::machine;

use crate::context::Profile;

/// The folder of the recorded pictures, from the root of the workspace.
const CHARTS: &str = "docs/charts";
/// The recorded proof.
const VERIFICATION: &str = "docs/verification.md";

/// Whether results go into the documents too.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Recording {
    /// They do not.
    Off,
    /// Into those of the workspace with this root.
    On(PathBuf),
}

/// Why results are not recorded.
#[derive(Debug, thiserror::Error, miette::Diagnostic, PartialEq, Eq)]
#[non_exhaustive]
pub enum RecordError {
    /// A quick run shows the least.
    #[error("a quick run is not recorded")]
    #[diagnostic(help("leave out --quick"))]
    Quick,
    /// The build is not the one whose times are published.
    #[error("this build has checks of overflow: its CPU times are not those of a release")]
    #[diagnostic(help("leave out --checked"))]
    Checked,
    /// A page of some cases would lose those of the others.
    #[error("the proof is recorded as a whole, not the part that `{filter}` selects")]
    Part {
        /// The first filter.
        filter: String,
    },
    /// Git does not say what is recorded.
    #[error("there is no commit to record at {}", .root.display())]
    NoCommit {
        /// Where git was asked.
        root: PathBuf,
    },
    /// The commit is not what runs.
    #[error("not as committed: {first}{}; the recorded commit would be wrong", more(*.rest))]
    #[diagnostic(help("commit them or put them away; what lies in docs may differ"))]
    Uncommitted {
        /// The first of them.
        first: String,
        /// How many others.
        rest: usize,
    },
}

fn more(rest: usize) -> String {
    if rest == 0 { String::new() } else { format!(" and {rest} more") }
}

/// How the program was built.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Build {
    /// For speed.
    Release,
    /// With checks of overflow.
    Checked,
}

impl Build {
    const fn of_this_program() -> Self {
        if cfg!(debug_assertions) { Self::Checked } else { Self::Release }
    }
}

impl Recording {
    /// Into the documents of this workspace, if what runs is what is committed.
    ///
    /// # Errors
    /// [`RecordError`] for a quick run, a build with checks, and files that are not as committed.
    pub fn on(profile: Profile) -> Result<Self, RecordError> {
        let root = workspace();
        check(profile, Build::of_this_program(), machine::uncommitted(), &root)?;
        Ok(Self::On(root))
    }

    /// The folder for pictures.
    #[must_use]
    pub fn charts(&self) -> Option<PathBuf> {
        match self {
            Self::Off => None,
            Self::On(root) => Some(root.join(CHARTS)),
        }
    }
}

/// The recorded proof of the workspace at `root`.
#[must_use]
pub fn verification(root: &Path) -> PathBuf {
    root.join(VERIFICATION)
}

/// Refuses what would publish a number under a wrong name.
fn check(
    profile: Profile,
    build: Build,
    uncommitted: Option<Vec<String>>,
    root: &Path,
) -> Result<(), RecordError> {
    if profile == Profile::Quick {
        return Err(RecordError::Quick);
    }
    if build == Build::Checked {
        return Err(RecordError::Checked);
    }
    let uncommitted = uncommitted.ok_or_else(|| RecordError::NoCommit { root: root.into() })?;
    match uncommitted.first() {
        None => Ok(()),
        Some(first) => {
            Err(RecordError::Uncommitted { first: first.clone(), rest: uncommitted.len() - 1 })
        }
    }
}

/// The root of the workspace: the nearest folder with a lock file, above the package that cargo runs or else above the current
/// folder, which is taken where there is none.
#[must_use]
pub fn workspace() -> PathBuf {
    let package = std::env::var_os("CARGO_MANIFEST_DIR").map(PathBuf::from);
    let start = package.or_else(|| std::env::current_dir().ok()).unwrap_or_default();
    let root = start.ancestors().find(|folder| folder.join("Cargo.lock").is_file());
    root.map(Path::to_owned).unwrap_or_default()
}

/// `target/<name>` of the workspace.
#[must_use]
pub fn default_folder(name: &str) -> PathBuf {
    workspace().join("target").join(name)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn checked(
        profile: Profile,
        build: Build,
        uncommitted: Option<&[&str]>,
    ) -> Result<(), RecordError> {
        let uncommitted =
            uncommitted.map(|files| files.iter().map(|&file| file.to_owned()).collect());
        check(profile, build, uncommitted, Path::new("here"))
    }

    #[test]
    fn only_a_whole_run_of_a_commit_built_for_speed_is_recorded() {
        use Build::{Checked, Release};
        assert_eq!(checked(Profile::Default, Release, Some(&[])), Ok(()));
        assert_eq!(checked(Profile::Full, Release, Some(&[])), Ok(()));
        assert_eq!(checked(Profile::Quick, Release, Some(&[])), Err(RecordError::Quick));
        assert_eq!(checked(Profile::Full, Checked, Some(&[])), Err(RecordError::Checked));
        let none = checked(Profile::Full, Release, None);
        assert_eq!(none, Err(RecordError::NoCommit { root: "here".into() }));
        let error = checked(Profile::Full, Release, Some(&["tests/src/claim.rs", "b"]));
        assert_eq!(
            error.unwrap_err().to_string(),
            "not as committed: tests/src/claim.rs and 1 more; the recorded commit would be wrong"
        );
    }

    #[test]
    fn pictures_are_recorded_in_one_folder_and_only_where_asked() {
        assert_eq!(Recording::Off.charts(), None);
        let folder = Recording::On("root".into()).charts();
        assert_eq!(folder, Some(PathBuf::from("root/docs/charts")));
    }
}
