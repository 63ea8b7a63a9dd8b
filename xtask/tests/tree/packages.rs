//! Packages of the workspace, for the tests of this package that compare them with the architecture page.

use std::process::Command;

use serde_json::Value;

/// Packages from their manifests, as cargo reads them.
pub(crate) fn packages() -> Vec<Value> {
    let metadata = ["metadata", "--no-deps", "--locked", "--format-version", "1"];
    let here = env!("CARGO_MANIFEST_DIR");
    let run = Command::new(env!("CARGO")).args(metadata).current_dir(here).output();
    let run = run.expect("cargo metadata");
    assert!(run.status.success(), "{}", String::from_utf8_lossy(&run.stderr));
    let metadata: Value = serde_json::from_slice(&run.stdout).expect("the JSON of cargo metadata");
    metadata["packages"].as_array().expect("packages").clone()
}

pub(crate) fn word(value: &Value) -> String {
    value.as_str().expect("a string").to_owned()
}
