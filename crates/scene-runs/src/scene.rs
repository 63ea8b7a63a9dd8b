//! Scenes: JSON files whose errors are reported with line and column.
//!
//! A scene type derives `Deserialize` with `deny_unknown_fields`. Its enums stay externally tagged
//! (`{"viscous_damper": {...}}`), because tagged ones lose the positions of their contents. Keys are checked during
//! parsing, values afterwards by [`Scene::check`].

mod error;
pub(crate) mod folder;
mod named_file;
mod place;
mod retired;
#[cfg(test)]
mod tests;

use std::path::{Path, PathBuf};

use serde_json::Value;

use self::error::Origin;
pub use self::error::{Mistake, Objection, SceneError};
pub use self::named_file::NamedFile;
pub use self::place::{WrongKey, read_keys};
pub use self::retired::Retired;

/// The key that names the kind of a scene.
pub const KIND_KEY: &str = "solver";

/// A type of scene.
pub trait Scene: Sized {
    /// Value that the check builds and a run uses.
    type Built;

    /// Names that its scenes had once.
    const RETIRED: &[Retired] = &[];

    /// Parses the keys by [`read_keys`].
    ///
    /// Each type implements it, so that its parsing is compiled with the type and not with each program.
    ///
    /// # Errors
    /// [`WrongKey`] for an unknown, missing or ill-typed key.
    fn from_keys(keys: &Value) -> Result<Self, WrongKey>;

    /// Reads the files that it names, from a folder, before the check.
    ///
    /// # Errors
    /// An [`Objection`] to a file that cannot be read, or to what is in it.
    fn read_files(&mut self, _folder: &Path) -> Result<(), Objection> {
        Ok(())
    }

    /// Rejects values that the types allow but the problem does not, e.g. a negative diffusion.
    ///
    /// # Errors
    /// An [`Objection`] with the name of the key.
    fn check(&self) -> Result<Self::Built, Objection>;

    /// Seed of the random numbers; `None` without random numbers.
    fn seed(&mut self) -> Option<&mut u64> {
        None
    }
}

/// Most bytes of a scene; its tree takes ninety times as many in memory.
const MOST_BYTES: u64 = 1 << 24;

/// The text of a scene: well-formed JSON without duplicate keys or numbers out of range.
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
    /// [`SceneError`] for a missing file, one of more than 16 MiB, bytes that are not UTF-8, and all errors of [`SceneFile::from_text`].
    pub fn read(path: &Path) -> Result<Self, SceneError> {
        let bytes = named_file::read_at_most(path, MOST_BYTES).map_err(|source| {
            SceneError::Unreadable { path: path.display().to_string(), source }
        })?;
        let text = String::from_utf8(bytes).map_err(|error| SceneError::NotUtf8 {
            path: path.display().to_string(),
            offset: error.utf8_error().valid_up_to(),
        })?;
        let folder = path.parent().map(Path::to_owned).unwrap_or_default();
        Ok(Self { folder, ..Self::from_text(&path.display().to_string(), text)? })
    }

    /// Parses a text; messages refer to it by name.
    ///
    /// # Errors
    /// [`SceneError`] for an empty text, a syntax error, trailing text, a duplicate key, or a number beyond the range
    /// of a double.
    pub fn from_text(name: &str, text: String) -> Result<Self, SceneError> {
        let origin = Origin { name: name.to_owned(), text };
        if origin.text.trim().is_empty() {
            return Err(SceneError::Empty { path: origin.name });
        }
        let keys = place::keys(&origin)?;
        Ok(Self { origin, keys, folder: PathBuf::new() })
    }

    /// Replaces the keys and keeps name and folder.
    #[must_use]
    pub fn with_keys(&self, keys: Value) -> Self {
        let origin = Origin { name: self.origin.name.clone(), text: keys.to_string() };
        Self { origin, keys, folder: self.folder.clone() }
    }

    /// All keys of the text.
    #[must_use]
    pub fn keys(&self) -> &Value {
        &self.keys
    }

    /// Folder of the file, from which its relative paths start; for a text, that of the process.
    #[must_use]
    pub fn folder(&self) -> &Path {
        &self.folder
    }

    /// The value of a top-level text key, e.g. `solver`, which names the scene kind.
    ///
    /// # Errors
    /// [`SceneError`] if the key is missing or not a text.
    pub fn text_at_top(&self, key: &str) -> Result<String, SceneError> {
        match self.keys.get(key) {
            Some(Value::String(text)) => Ok(text.clone()),
            Some(_) => Err(self.object_to(&Objection::new(key, format!("`{key}` must be a text")))),
            None => Err(self
                .object_to(&Objection::new("", format!("the key `{key}` is missing at the top")))),
        }
    }

    /// Parses the scene as a `T`, reads the files of [`Scene::read_files`], and checks its values.
    ///
    /// # Errors
    /// [`SceneError`] for an unknown, missing or ill-typed key, and for the objections of [`Scene::read_files`] and [`Scene::check`].
    pub fn parse<T: Scene>(&self) -> Result<T, SceneError> {
        Ok(self.build::<T>()?.0)
    }

    /// Parses the scene as a `T`, checks its values, and returns the result of the check.
    ///
    /// # Errors
    /// Those of [`SceneFile::parse`].
    pub fn build<T: Scene>(&self) -> Result<(T, T::Built), SceneError> {
        let read = T::from_keys(&self.keys);
        let mut scene = read.map_err(|wrong| place::locate(&self.origin, T::RETIRED, &wrong))?;
        let built = scene.read_files(&self.folder).and_then(|()| scene.check());
        let built = built.map_err(|objection| self.object_to(&objection))?;
        Ok((scene, built))
    }

    /// Reports an objection at the line and column of its value, or of the nearest enclosing one.
    #[must_use]
    pub fn object_to(&self, objection: &Objection) -> SceneError {
        place::object_to(&self.origin, objection)
    }
}
