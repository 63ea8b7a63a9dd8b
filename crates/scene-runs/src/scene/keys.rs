//! Conversion of keys to a scene type.

use serde::de::DeserializeOwned;
use serde_json::Value;

/// A key that is unknown, missing or of another type, with its path.
pub type WrongKey = serde_path_to_error::Error<serde_json::Error>;

/// Parses keys as a type that implements `Deserialize`.
///
/// # Errors
/// [`WrongKey`].
pub fn read_keys<T: DeserializeOwned>(keys: &Value) -> Result<T, WrongKey> {
    serde_path_to_error::deserialize(keys)
}
