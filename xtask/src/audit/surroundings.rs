//! What a check finds around it.

use std::io;
use std::process::Command;

use crate::workspace;

/// What plans are made from.
pub(super) struct Surroundings {
    /// The crates to be published: folders under `crates`, each named as its package, in alphabetical order.
    pub(super) crates: Vec<String>,
    /// The targets of cargo-fuzz: files in `tests/fuzz/fuzz_targets`, without `.rs`, in alphabetical order.
    pub(super) fuzz_targets: Vec<String>,
    /// What `rustup toolchain list` prints; nothing without rustup.
    pub(super) toolchains: String,
    /// Tags of releases, the newest first, one to a line; nothing without git.
    pub(super) release_tags: String,
}

impl Surroundings {
    /// Looks around.
    ///
    /// # Errors
    ///
    /// If the folder `crates` or that of the targets of cargo-fuzz cannot be read.
    pub(super) fn look() -> io::Result<Self> {
        let targets = names("tests/fuzz/fuzz_targets")?.into_iter();
        let fuzz_targets =
            targets.filter_map(|name| name.strip_suffix(".rs").map(str::to_owned)).collect();
        Ok(Self {
            crates: names("crates")?,
            fuzz_targets,
            toolchains: output("rustup", &["toolchain", "list"]),
            release_tags: output("git", &["tag", "--list", "v*", "--sort=-version:refname"]),
        })
    }
}

/// Entries of a folder of the workspace, in alphabetical order.
fn names(folder: &str) -> io::Result<Vec<String>> {
    let mut names = Vec::new();
    for entry in std::fs::read_dir(workspace().join(folder))? {
        names.push(entry?.file_name().to_string_lossy().into_owned());
    }
    names.sort_unstable();
    Ok(names)
}

/// What a program prints; nothing if it is absent or fails.
fn output(program: &str, arguments: &[&str]) -> String {
    let run = Command::new(program).args(arguments).current_dir(workspace()).output();
    let Ok(run) = run else { return String::new() };
    if run.status.success() {
        String::from_utf8_lossy(&run.stdout).into_owned()
    } else {
        String::new()
    }
}
