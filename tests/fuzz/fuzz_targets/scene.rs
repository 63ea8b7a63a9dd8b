//! Texts of scenes, read and checked: built-in ones, changed by what `any_input` does to them in turns with what libFuzzer does.
#![no_main]

#[path = "../../../crates/scenes/tests/any_input/scene.rs"]
mod scene;

use libfuzzer_sys::{fuzz_mutator, fuzz_target, fuzzer_mutate};

/// A text with another value, key or byte; a built-in one where there is none yet. None where it is no text, or does not fit.
fn other(data: &[u8], max_size: usize, seed: u32) -> Option<String> {
    let text = std::str::from_utf8(data).ok()?;
    let other = if text.len() <= 1 {
        scene::SCENES[seed as usize % scene::SCENES.len()].clone()
    } else {
        let change = fuzz_targets::drawn(&scene::change(), &seed.to_le_bytes())?;
        scene::changed(text, &change)?
    };
    (other.len() <= max_size).then_some(other)
}

fuzz_mutator!(|data: &mut [u8], size: usize, max_size: usize, seed: u32| {
    let is_by_tree = size <= 1 || seed % 2 == 0;
    match is_by_tree.then(|| other(&data[..size], max_size, seed)).flatten() {
        Some(text) => {
            data[..text.len()].copy_from_slice(text.as_bytes());
            text.len()
        }
        None => fuzzer_mutate(data, size, max_size),
    }
});

fuzz_target!(|bytes: &[u8]| {
    fuzz_targets::holds(scene::is_read_or_says_why_not(&String::from_utf8_lossy(bytes)));
});
