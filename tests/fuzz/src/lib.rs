//! What the targets share: values drawn from bytes, and snapshots to begin with.

use proptest::strategy::{Strategy, ValueTree};
use proptest::test_runner::{Config, RngAlgorithm, TestCaseError, TestRng, TestRunner};

/// Refused draws after which an input is given up.
const MOST_REJECTS: u32 = 16;

/// The value that a strategy draws from a generator that the bytes seed; none where its filters refuse too often.
///
/// The bytes cannot be the randomness itself (`PassThrough`): each choice between strategies halves what is left of them, and proptest
/// draws for ever from none. So what reached new code is kept, but not built upon.
pub fn drawn<S: Strategy>(strategy: &S, bytes: &[u8]) -> Option<S::Value> {
    let mut seed = [0_u8; 32];
    for (i, byte) in bytes.iter().enumerate() {
        seed[i % 32] = seed[i % 32].rotate_left(3) ^ byte;
    }
    let rng = TestRng::from_seed(RngAlgorithm::ChaCha, &seed);
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

/// A target whose bytes seed the randomness of a strategy, and a check of what is drawn.
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
