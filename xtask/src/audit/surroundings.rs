//! What a check finds around it.

use std::io;
use std::process::Command;

use crate::workspace;

/// What plans are made from.
pub(super) struct Surroundings {
    /// The crates to be published: folders under `crates`, each named as its package, in alphabetical order.
    pub(super) crates: Vec<String>,
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
    /// If the folder `crates` cannot be read.
    pub(super) fn look() -> io::Result<Self> {
        let mut crates = Vec::new();
        for entry in std::fs::read_dir(workspace().join("crates"))? {
            crates.push(entry?.file_name().to_string_lossy().into_owned());
        }
        crates.sort_unstable();
        Ok(Self {
            crates,
            toolchains: output("rustup", &["toolchain", "list"]),
            release_tags: output("git", &["tag", "--list", "v*", "--sort=-version:refname"]),
        })
    }
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
