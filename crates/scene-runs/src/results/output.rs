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

/// Writes `text`; creates missing folders. A symbolic link of that name is replaced, so that the file it points to stays as it is.
///
/// # Errors
/// Errors of the file system.
pub fn write_text(path: &Path, text: &str) -> io::Result<()> {
    if path.is_symlink() {
        std::fs::remove_file(path)?;
    }
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

#[cfg(all(test, unix))]
mod tests {
    use super::*;

    #[test]
    fn a_link_is_replaced_and_its_target_stays() {
        let folder = std::env::temp_dir().join(format!("link-{}", std::process::id()));
        std::fs::create_dir_all(&folder).unwrap();
        let (target, link) = (folder.join("notes"), folder.join("result.json"));
        std::fs::write(&target, "mine").unwrap();
        std::os::unix::fs::symlink(&target, &link).unwrap();
        write_text(&link, "{}").unwrap();
        assert!(!link.is_symlink());
        let read = |path| std::fs::read_to_string(path).unwrap();
        assert_eq!((read(&target), read(&link)), ("mine".to_owned(), "{}".to_owned()));
        std::fs::remove_dir_all(&folder).unwrap();
    }
}
