//! One run at a time in a folder of results.

use std::fs::{File, TryLockError};
use std::path::Path;

use super::run_error::RunError;
use crate::output::OutputError;

/// Held while a run writes into its folder. The operating system releases it with the process, however that ends.
#[derive(Debug)]
pub(super) struct FolderLock {
    folder: Option<File>,
}

/// The lock belongs to the open file: without unlocking it, a process that was started meanwhile would hold it until it runs its
/// own program.
impl Drop for FolderLock {
    fn drop(&mut self) {
        if let Some(folder) = &self.folder {
            // One that cannot be released now ends with the process.
            let _ = folder.unlock();
        }
    }
}

impl FolderLock {
    /// Creates the folder if there is none. Where a folder is no file, or its file system has no locks, none is taken.
    ///
    /// # Errors
    /// [`RunError::Occupied`] while another run holds it, and errors of the file system.
    pub(super) fn take(folder: &Path) -> Result<Self, RunError> {
        std::fs::create_dir_all(folder)
            .map_err(|source| OutputError::Io { path: folder.to_owned(), source })?;
        let Ok(file) = File::open(folder) else { return Ok(Self { folder: None }) };
        match file.try_lock() {
            Ok(()) => Ok(Self { folder: Some(file) }),
            Err(TryLockError::WouldBlock) => Err(RunError::Occupied { folder: folder.to_owned() }),
            Err(TryLockError::Error(_)) => Ok(Self { folder: None }),
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
        // As a process that is being started holds it.
        let inherited = held.folder.as_ref().map(|file| file.try_clone().unwrap());
        drop(held);
        FolderLock::take(&folder).unwrap();
        drop(inherited);
        std::fs::remove_dir_all(&folder).unwrap();
    }
}
