//! Output files of a run.

use std::fs::File;
use std::io::{self, BufWriter, IntoInnerError};
use std::path::{Path, PathBuf};

use result_figures::finite::{self, JsonError};
use result_figures::{Drawing, Face};
use serde::Serialize;

/// A result could not be written.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum OutputError {
    /// A number is not finite.
    #[error("cannot write {}", .path.display())]
    Json {
        /// The file.
        path: PathBuf,
        /// The number.
        source: JsonError,
    },
    /// The file system returned an error.
    #[error("cannot write {}", .path.display())]
    Io {
        /// The file.
        path: PathBuf,
        /// Error of the file system.
        source: io::Error,
    },
}

/// Writes `value` as JSON after checking that its numbers are finite; creates missing folders.
///
/// # Errors
/// [`OutputError`] with the name of the file.
pub fn write_json<T: Serialize + ?Sized>(path: &Path, value: &T) -> Result<(), OutputError> {
    let text =
        finite::to_json(value).map_err(|source| OutputError::Json { path: path.into(), source })?;
    write_text(path, &text).map_err(|source| OutputError::Io { path: path.into(), source })
}

/// Writes `text`; creates missing folders.
///
/// # Errors
/// Errors of the file system.
pub fn write_text(path: &Path, text: &str) -> io::Result<()> {
    if let Some(folder) = path.parent().filter(|folder| !folder.as_os_str().is_empty()) {
        std::fs::create_dir_all(folder)?;
    }
    std::fs::write(path, text)
}

/// Writes a file that a checkpoint refers to, and waits until it is on disk, so a crash cannot truncate it.
///
/// # Errors
/// Those of `write`, and errors of the file system.
pub fn write_to_disk<E: From<io::Error>>(
    path: &Path,
    write: impl FnOnce(&mut BufWriter<File>) -> Result<(), E>,
) -> Result<(), E> {
    let mut out = BufWriter::new(File::create(path)?);
    write(&mut out)?;
    out.into_inner().map_err(IntoInnerError::into_error)?.sync_all()?;
    Ok(())
}

/// Writes `<name>.svg`, or `<name>.md` for a page, and `<name>.json` into `folder`; returns the path of the first.
///
/// # Errors
/// Errors of the file system.
pub fn write_drawing(drawing: &Drawing, folder: &Path) -> io::Result<PathBuf> {
    let (ending, text) = match &drawing.face {
        Face::Picture(svg) => ("svg", svg),
        Face::Page(markdown) => ("md", markdown),
    };
    let file = folder.join(format!("{}.{ending}", drawing.name));
    write_text(&file, text)?;
    write_text(&folder.join(format!("{}.json", drawing.name)), &drawing.data)?;
    Ok(file)
}
