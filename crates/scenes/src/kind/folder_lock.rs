//! One run at a time in a folder of results.

use std::fs::{File, TryLockError};
use std::path::Path;

use super::run_error::RunError;
use crate::output::OutputError;

/// Held while a run writes into its folder. The operating system releases it with the process, however that ends.
#[derive(Debug)]
pub(super) struct FolderLock {
    _folder: Option<File>,
}

impl FolderLock {
    /// Creates the folder if there is none. Where a folder is no file, or its file system has no locks, none is taken.
    ///
    /// # Errors
    /// [`RunError::Occupied`] while another run holds it, and errors of the file system.
    pub(super) fn take(folder: &Path) -> Result<Self, RunError> {
        std::fs::create_dir_all(folder)
            .map_err(|source| OutputError::Io { path: folder.to_owned(), source })?;
        let Ok(file) = File::open(folder) else { return Ok(Self { _folder: None }) };
        match file.try_lock() {
            Ok(()) => Ok(Self { _folder: Some(file) }),
            Err(TryLockError::WouldBlock) => Err(RunError::Occupied { folder: folder.to_owned() }),
            Err(TryLockError::Error(_)) => Ok(Self { _folder: None }),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_folder_is_held_by_one_run_at_a_time() {
        let folder = std::env::temp_dir().join(format!("folder-lock-{}", std::process::id()));
        let held = FolderLock::take(&folder).unwrap();
        // Elsewhere a folder may not be lockable.
        if cfg!(target_os = "linux") {
            let refused = FolderLock::take(&folder).unwrap_err();
            assert!(matches!(&refused, RunError::Occupied { folder: at } if *at == folder));
        }
        drop(held);
        FolderLock::take(&folder).unwrap();
        std::fs::remove_dir_all(&folder).unwrap();
    }
}
