//! Shards of cracks, joined to another.
#![no_main]

#[path = "../../../crates/scenes/tests/any_input/changes.rs"]
mod changes;
#[path = "../../../crates/scenes/tests/any_input/shard.rs"]
mod shard;

use proptest::test_runner::TestCaseError;

fn is_joined_or_refused(body: &[u8]) -> Result<(), TestCaseError> {
    // An error is an answer.
    let _ = shard::CRACKS.forged(body);
    Ok(())
}

fuzz_targets::fuzz_read!(shard::CRACKS.body().to_vec(), is_joined_or_refused);
