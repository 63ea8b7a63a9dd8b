//! Files of a folder, for the tests of this package that read sources or pages.

use std::fs;
use std::path::{Path, PathBuf};

/// The root of the workspace.
pub(crate) fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("..")
}

/// Files below a folder whose names have an ending, each by its path from there, with `/`, and its text; build output is
/// excluded.
pub(crate) fn texts(folder: &Path, ending: &str) -> std::io::Result<Vec<(String, String)>> {
    let (mut folders, mut found) = (vec![folder.to_owned()], Vec::new());
    while let Some(inner) = folders.pop() {
        for entry in fs::read_dir(inner)? {
            let path = entry?.path();
            let name = path.file_name().unwrap_or_default().to_string_lossy().into_owned();
            if path.is_dir() && name != "target" && !name.starts_with('.') {
                folders.push(path);
            } else if path.is_file() && name.ends_with(ending) {
                let from_there = path.strip_prefix(folder).unwrap_or(&path).to_string_lossy();
                found.push((from_there.replace('\\', "/"), fs::read_to_string(&path)?));
            }
        }
    }
    found.sort();
    Ok(found)
}
