//! The result of a scene, as a user reads it.

use scenes::{ALL, Options, Progress, SceneFile, kind_of};
use serde_json::Value;

use crate::cases::prelude::*;

/// Runs a scene and returns its `result.json`.
pub(super) fn result_of(file: &SceneFile, options: &Options) -> CaseResult<Value> {
    kind_of(ALL, file)?.run_file(file, options, &Progress::silent())?;
    Ok(serde_json::from_str(&std::fs::read_to_string(options.out.join("result.json"))?)?)
}
