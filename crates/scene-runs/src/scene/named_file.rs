//! Files that a scene names.

use std::fs::File;
use std::io::{self, Read};
use std::path::Path;

use serde::{Deserialize, Serialize};
use twox_hash::XxHash64;

use super::error::Objection;

/// A file that a scene names, identified by its bytes: its contents may change under the same path.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct NamedFile {
    /// Path as given in the scene, relative to its folder.
    pub path: String,
    /// XXH64 of the bytes with the seed 0, in 16 hexadecimal digits, as `xxh64sum` prints it.
    pub xxh64: String,
}

impl NamedFile {
    /// Reads a file relative to the folder of a scene, and computes its hash.
    ///
    /// # Errors
    /// Errors of the file system; [`io::ErrorKind::FileTooLarge`] above 1 GiB, also of a device without an end.
    pub fn read(path: &str, folder: &Path) -> io::Result<(Self, Vec<u8>)> {
        let bytes = read_at_most(&folder.join(path), MOST_BYTES)?;
        Ok((Self::of(path, &bytes), bytes))
    }

    /// Reads a file that a key names, from the folder of the scene. `what` precedes its name in a message.
    ///
    /// # Errors
    /// An [`Objection`] at the key, for the errors of [`read`](Self::read).
    pub fn beside(
        (file, folder): (&str, &Path),
        key: &str,
        what: &str,
    ) -> Result<(Self, Vec<u8>), Objection> {
        Self::read(file, folder).map_err(|error| {
            let folder = if folder.as_os_str().is_empty() { Path::new(".") } else { folder };
            let help =
                format!("a path is taken from the folder of the scene, {}", folder.display());
            Objection::new(key, format!("cannot read {what}{file}: {error}")).with_help(help)
        })
    }

    /// The identity of a file with these bytes.
    #[must_use]
    pub fn of(path: &str, bytes: &[u8]) -> Self {
        let xxh64 = format!("{:016x}", XxHash64::oneshot(0, bytes));
        Self { path: path.to_owned(), xxh64 }
    }
}

/// Most bytes of a file that a scene names.
const MOST_BYTES: u64 = 1 << 30;

/// Reads a file of at most so many bytes.
pub(super) fn read_at_most(path: &Path, most: u64) -> io::Result<Vec<u8>> {
    let mut bytes = Vec::new();
    File::open(path)?.take(most + 1).read_to_end(&mut bytes)?;
    if bytes.len() as u64 > most {
        let message = format!("it has more than {most} bytes, the most that is read");
        return Err(io::Error::new(io::ErrorKind::FileTooLarge, message));
    }
    Ok(bytes)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_file_is_known_by_the_hash_that_others_print_of_its_bytes() {
        let folder = std::env::temp_dir().join(format!("named-file-{}", std::process::id()));
        std::fs::create_dir_all(&folder).unwrap();
        // Test vectors of XXH64.
        for (contents, xxh64) in [("", "ef46db3751d8e999"), ("abc", "44bc2cf5ad770999")] {
            std::fs::write(folder.join("points.csv"), contents).unwrap();
            let (file, bytes) = NamedFile::read("points.csv", &folder).unwrap();
            assert_eq!((file.xxh64.as_str(), bytes.as_slice()), (xxh64, contents.as_bytes()));
        }
        let path = folder.join("points.csv");
        assert_eq!(read_at_most(&path, 3).unwrap(), b"abc");
        let error = read_at_most(&path, 2).unwrap_err();
        assert_eq!(error.kind(), io::ErrorKind::FileTooLarge);
        std::fs::remove_dir_all(&folder).unwrap();
        assert!(NamedFile::read("points.csv", &folder).is_err());
    }
}
