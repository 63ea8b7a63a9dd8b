//! Files that a scene names.

use std::io;
use std::path::Path;

use serde::{Deserialize, Serialize};
use twox_hash::XxHash64;

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
    /// Errors of the file system.
    pub fn read(path: &str, folder: &Path) -> io::Result<(Self, Vec<u8>)> {
        let bytes = std::fs::read(folder.join(path))?;
        Ok((Self::of(path, &bytes), bytes))
    }

    /// The identity of a file with these bytes.
    #[must_use]
    pub fn of(path: &str, bytes: &[u8]) -> Self {
        let xxh64 = format!("{:016x}", XxHash64::oneshot(0, bytes));
        Self { path: path.to_owned(), xxh64 }
    }
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
        std::fs::remove_dir_all(&folder).unwrap();
        assert!(NamedFile::read("points.csv", &folder).is_err());
    }
}
