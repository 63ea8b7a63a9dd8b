//! Scenes: JSON files whose every mistake is shown at its line and column.
//!
//! A scene type derives `Deserialize` with `deny_unknown_fields`; its enums stay externally tagged
//! (`{"viscous_damper": {...}}`), for tagged ones lose the place of what they hold.
//! Keys are checked while reading, meanings afterwards by [`Scene::check`].

mod error;
mod keys;
mod named_file;
mod objection;
mod place;
#[cfg(test)]
mod tests;

use std::path::{Path, PathBuf};

use serde_json::Value;

use self::error::Origin;
pub use self::error::SceneError;
pub use self::keys::{WrongKey, read_keys};
pub use self::named_file::NamedFile;
pub use self::objection::Objection;

/// A type of scene.
pub trait Scene: Sized {
    /// What the check builds and a run needs again.
    type Built;

    /// Reads the keys, by [`read_keys`]: written by each type, so that its reading is compiled where the type is and
    /// not with each program that reads one.
    ///
    /// # Errors
    /// [`WrongKey`] for an unknown, missing or ill-typed key.
    fn from_keys(keys: &Value) -> Result<Self, WrongKey>;

    /// Refuses what the types allow and the problem does not, e.g. a negative diffusion.
    ///
    /// # Errors
    /// An [`Objection`] that names the key.
    fn check(&self) -> Result<Self::Built, Objection>;

    /// The seed of what it draws at random; `None` where it draws nothing.
    fn seed(&mut self) -> Option<&mut u64> {
        None
    }
}

/// The text of a scene that is well-formed JSON: no key twice, no number out of range.
#[derive(Debug, Clone)]
pub struct SceneFile {
    origin: Origin,
    keys: Value,
    folder: PathBuf,
}

impl SceneFile {
    /// Reads a file.
    ///
    /// # Errors
    /// [`SceneError`] for a missing file, bytes that are not UTF-8, and all that [`SceneFile::from_text`] refuses.
    pub fn read(path: &Path) -> Result<Self, SceneError> {
        let bytes = std::fs::read(path).map_err(|source| SceneError::Unreadable {
            path: path.display().to_string(),
            source,
        })?;
        let text = String::from_utf8(bytes).map_err(|error| SceneError::NotUtf8 {
            path: path.display().to_string(),
            offset: error.utf8_error().valid_up_to(),
        })?;
        let folder = path.parent().map(Path::to_owned).unwrap_or_default();
        Ok(Self { folder, ..Self::from_text(&path.display().to_string(), text)? })
    }

    /// Takes a text under a name for messages.
    ///
    /// # Errors
    /// [`SceneError`] for an empty text, a syntax error, text behind the end, a key given twice, a number beyond
    /// the range of a double.
    pub fn from_text(name: &str, text: String) -> Result<Self, SceneError> {
        let origin = Origin { name: name.to_owned(), text };
        if origin.text.trim().is_empty() {
            return Err(SceneError::Empty { path: origin.name });
        }
        let keys = place::keys(&origin)?;
        Ok(Self { origin, keys, folder: PathBuf::new() })
    }

    /// Other keys in place of these, under the same name and in the same folder.
    #[must_use]
    pub fn with_keys(&self, keys: Value) -> Self {
        let origin = Origin { name: self.origin.name.clone(), text: keys.to_string() };
        Self { origin, keys, folder: self.folder.clone() }
    }

    /// All that the text says.
    #[must_use]
    pub fn keys(&self) -> &Value {
        &self.keys
    }

    /// The folder of the file, from which paths in it are taken; that of the process for a text.
    #[must_use]
    pub fn folder(&self) -> &Path {
        &self.folder
    }

    /// The value of a text key at the top, e.g. `solver`, which names the kind of scene.
    ///
    /// # Errors
    /// [`SceneError`] if the key is missing or no text.
    pub fn text_at_top(&self, key: &str) -> Result<String, SceneError> {
        match self.keys.get(key) {
            Some(Value::String(text)) => Ok(text.clone()),
            Some(_) => Err(self.object_to(&Objection::new(key, format!("`{key}` must be a text")))),
            None => Err(self
                .object_to(&Objection::new("", format!("the key `{key}` is missing at the top")))),
        }
    }

    /// Reads the scene as a `T` and checks what it means.
    ///
    /// # Errors
    /// [`SceneError`] for an unknown, missing or ill-typed key, and for what [`Scene::check`] refuses.
    pub fn parse<T: Scene>(&self) -> Result<T, SceneError> {
        Ok(self.build::<T>()?.0)
    }

    /// Reads the scene as a `T`, checks what it means, and returns what the check built.
    ///
    /// # Errors
    /// As [`SceneFile::parse`].
    pub fn build<T: Scene>(&self) -> Result<(T, T::Built), SceneError> {
        let read = T::from_keys(&self.keys);
        let scene = read.map_err(|wrong| place::locate(&self.origin, &wrong))?;
        let built = scene.check().map_err(|objection| self.object_to(&objection))?;
        Ok((scene, built))
    }

    /// Shows an objection at the line and column of the value it names, or of the nearest one around it.
    #[must_use]
    pub fn object_to(&self, objection: &Objection) -> SceneError {
        place::object_to(&self.origin, objection)
    }
}
