//! From the keys of a scene to its type.

use serde::de::DeserializeOwned;
use serde_json::Value;

/// A key that is unknown, missing or of another type, by its path.
pub type WrongKey = serde_path_to_error::Error<serde_json::Error>;

/// Reads keys as a type that serde knows.
///
/// # Errors
/// [`WrongKey`].
pub fn read_keys<T: DeserializeOwned>(keys: &Value) -> Result<T, WrongKey> {
    serde_path_to_error::deserialize(keys)
}
