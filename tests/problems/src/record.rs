//! Recording of results in the documents: paths and conditions.

use std::path::{Path, PathBuf};

use scene_runs::machine;

use crate::context::Profile;

/// Folder of the recorded pictures, from the root of the workspace.
const CHARTS: &str = "docs/charts";
/// The recorded verification report.
const VERIFICATION: &str = "docs/verification.md";

/// Whether results are recorded in the documents.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Recording {
    /// No recording.
    Off,
    /// Recording in the documents of the workspace with this root.
    On(PathBuf),
}

/// Why results are not recorded.
#[derive(Debug, thiserror::Error, miette::Diagnostic, PartialEq, Eq)]
#[non_exhaustive]
pub enum RecordError {
    /// The run was quick.
    #[error("a quick run is not recorded")]
    #[diagnostic(help("leave out --quick"))]
    Quick,
    /// The build is not the one whose times are published.
    #[error("this build has checks of overflow: its CPU times are not those of a release")]
    #[diagnostic(help("leave out --checked"))]
    Checked,
    /// A page of selected cases would drop the others.
    #[error("the proof is recorded as a whole, not the part that `{filter}` selects")]
    Part {
        /// The first filter.
        filter: String,
    },
    /// There is no commit.
    #[error("there is no commit to record at {}", .root.display())]
    NoCommit {
        /// Folder of the query.
        root: PathBuf,
    },
    /// The working tree differs from the commit.
    #[error("not as committed: {first}{}; the recorded commit would be wrong", more(*.rest))]
    #[diagnostic(help("commit them or put them away; what lies in docs may differ"))]
    Uncommitted {
        /// The first such file.
        first: String,
        /// Number of further files.
        rest: usize,
    },
}

fn more(rest: usize) -> String {
    if rest == 0 { String::new() } else { format!(" and {rest} more") }
}

/// Build of the program.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Build {
    /// Optimised.
    Release,
    /// With overflow checks.
    Checked,
}

impl Build {
    const fn of_this_program() -> Self {
        if cfg!(debug_assertions) { Self::Checked } else { Self::Release }
    }
}

impl Recording {
    /// Recording in the documents of this workspace, if its tree is the commit.
    ///
    /// # Errors
    /// [`RecordError`] for a quick run, a build with checks, and files that differ from the commit.
    pub fn on(profile: Profile) -> Result<Self, RecordError> {
        let root = workspace();
        check(profile, Build::of_this_program(), machine::uncommitted(), &root)?;
        Ok(Self::On(root))
    }

    /// The recording that a flag requests, if it is allowed.
    pub fn requested(is_asked: bool, profile: Profile) -> Result<Self, RecordError> {
        if is_asked { Self::on(profile) } else { Ok(Self::Off) }
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

/// The recorded verification report of the workspace at `root`.
#[must_use]
pub fn verification(root: &Path) -> PathBuf {
    root.join(VERIFICATION)
}

/// Rejects runs whose results would be published under a wrong description.
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

/// The root of the workspace: the nearest folder with a lock file.
///
/// The search starts at the package that cargo runs or else at the current folder, which is the fallback.
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
