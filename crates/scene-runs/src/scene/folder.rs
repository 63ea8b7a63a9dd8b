//! The scenes in a folder.

use std::io;
use std::path::{Path, PathBuf};

/// Name and path of each JSON file in the folders of a folder, by name, e.g. `fpk/duffing`.
///
/// # Errors
/// The folder that cannot be listed, and the error of the file system.
pub(crate) fn files_by_name(root: &Path) -> Result<Vec<(String, PathBuf)>, (PathBuf, io::Error)> {
    let mut files = Vec::new();
    for folder in listed(root)?.into_iter().filter(|path| path.is_dir()) {
        let is_json = |path: &PathBuf| path.extension().is_some_and(|ending| ending == "json");
        for path in listed(&folder)?.into_iter().filter(is_json) {
            let stem = |path: &Path| path.file_stem().unwrap_or_default().display().to_string();
            files.push((format!("{}/{}", stem(&folder), stem(&path)), path));
        }
    }
    Ok(files)
}

/// Entries of a folder, by name.
fn listed(folder: &Path) -> Result<Vec<PathBuf>, (PathBuf, io::Error)> {
    let entries = std::fs::read_dir(folder)
        .and_then(|entries| entries.map(|entry| Ok(entry?.path())).collect::<io::Result<Vec<_>>>());
    let mut paths = entries.map_err(|source| (folder.to_owned(), source))?;
    paths.sort();
    Ok(paths)
}
