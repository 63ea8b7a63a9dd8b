//! Location of the workspace.

use std::path::{Path, PathBuf};

/// The root of the workspace; the current folder if cargo did not start the program.
#[must_use]
pub fn workspace() -> PathBuf {
    let package = std::env::var_os("CARGO_MANIFEST_DIR").map(PathBuf::from);
    package.as_deref().and_then(Path::parent).map(Path::to_owned).unwrap_or_default()
}
