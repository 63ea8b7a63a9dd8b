//! What the targets share: values drawn from bytes, and snapshots to begin with.

use proptest::strategy::{Strategy, ValueTree};
use proptest::test_runner::{Config, RngAlgorithm, TestCaseError, TestRng, TestRunner};

/// Words behind the bytes of an input. Behind them proptest reads zeros, and a draw that refuses zero would never end.
const WORDS_BEHIND: u64 = 512;

/// Refused draws after which an input is given up.
const MOST_REJECTS: u32 = 16;

/// The value that a strategy draws where its randomness is these bytes; none where its filters refuse too often.
pub fn drawn<S: Strategy>(strategy: &S, bytes: &[u8]) -> Option<S::Value> {
    let mut seed = bytes.to_vec();
    // Steps of the golden ratio: words that are spread evenly, the same behind every input.
    seed.extend(
        (1..=WORDS_BEHIND).flat_map(|k| k.wrapping_mul(0x9e37_79b9_7f4a_7c15).to_le_bytes()),
    );
    let rng = TestRng::from_seed(RngAlgorithm::PassThrough, &seed);
    let config = Config { max_local_rejects: MOST_REJECTS, ..Config::default() };
    let mut runner = TestRunner::new_with_rng(config, rng);
    strategy.new_tree(&mut runner).ok().map(|tree| tree.current())
}

/// Ends the target where a check fails.
///
/// # Panics
/// Then.
pub fn holds(checked: Result<(), TestCaseError>) {
    if let Err(failed) = checked {
        panic!("{failed}");
    }
}

/// Changes an input as libFuzzer does; one that is empty becomes what `start` gives.
pub fn mutated(data: &mut [u8], size: usize, max_size: usize, start: &[u8]) -> usize {
    if size <= 1 && start.len() <= max_size {
        data[..start.len()].copy_from_slice(start);
        return start.len();
    }
    libfuzzer_sys::fuzzer_mutate(data, size, max_size)
}

/// A target whose bytes are the randomness of a strategy, and a check of what is drawn.
#[macro_export]
macro_rules! fuzz_drawn {
    ($strategy:expr, $check:path) => {
        libfuzzer_sys::fuzz_target!(|bytes: &[u8]| {
            if let Some(input) = $crate::drawn(&$strategy, bytes) {
                $crate::holds($check(input));
            }
        });
    };
}

/// A target whose bytes are what a reader reads, beginning with what a writer wrote.
#[macro_export]
macro_rules! fuzz_read {
    ($written:expr, $check:path) => {
        static WRITTEN: std::sync::LazyLock<Vec<u8>> = std::sync::LazyLock::new(|| $written);

        libfuzzer_sys::fuzz_mutator!(|data: &mut [u8],
                                      size: usize,
                                      max_size: usize,
                                      _seed: u32| {
            $crate::mutated(data, size, max_size, &WRITTEN)
        });

        libfuzzer_sys::fuzz_target!(|bytes: &[u8]| $crate::holds($check(bytes)));
    };
}
