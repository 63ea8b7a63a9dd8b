//! Files that a run leaves behind.

use std::fs::File;
use std::io::{self, BufWriter, IntoInnerError};
use std::path::{Path, PathBuf};

use serde::Serialize;

use crate::finite::{self, JsonError};

/// A result that could not be written.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum OutputError {
    /// It holds a number that is not finite.
    #[error("cannot write {}", .path.display())]
    Json {
        /// Which file.
        path: PathBuf,
        /// Which number.
        source: JsonError,
    },
    /// The system refused.
    #[error("cannot write {}", .path.display())]
    Io {
        /// Which file.
        path: PathBuf,
        /// What the system said.
        source: io::Error,
    },
}

/// Writes `value` as JSON, numbers checked to be finite; missing folders are made.
///
/// # Errors
/// [`OutputError`], naming the file.
pub fn write_json<T: Serialize + ?Sized>(path: &Path, value: &T) -> Result<(), OutputError> {
    let text =
        finite::to_json(value).map_err(|source| OutputError::Json { path: path.into(), source })?;
    write_text(path, &text).map_err(|source| OutputError::Io { path: path.into(), source })
}

/// Writes `text`, making missing folders.
///
/// # Errors
/// Those of the file system.
pub fn write_text(path: &Path, text: &str) -> io::Result<()> {
    if let Some(folder) = path.parent().filter(|folder| !folder.as_os_str().is_empty()) {
        std::fs::create_dir_all(folder)?;
    }
    std::fs::write(path, text)
}

/// Writes a file that a checkpoint says is there: when this returns it is on the disk, and not cut off by a machine that ends.
///
/// # Errors
/// Those of `write`, and of the file system.
pub fn write_to_disk<E: From<io::Error>>(
    path: &Path,
    write: impl FnOnce(&mut BufWriter<File>) -> Result<(), E>,
) -> Result<(), E> {
    let mut out = BufWriter::new(File::create(path)?);
    write(&mut out)?;
    out.into_inner().map_err(IntoInnerError::into_error)?.sync_all()?;
    Ok(())
}

/// The root of the workspace; the current folder where cargo did not start the program.
#[must_use]
pub fn workspace() -> PathBuf {
    let package = std::env::var_os("CARGO_MANIFEST_DIR").map(PathBuf::from);
    package.as_deref().and_then(Path::parent).map(Path::to_owned).unwrap_or_default()
}

/// `target/<name>` of the workspace.
#[must_use]
pub fn default_folder(name: &str) -> PathBuf {
    workspace().join("target").join(name)
}
