//! Random numbers of a scene.

use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::{Rng, SeedableRng};

/// Random numbers of one scene: the same for the same seed and index.
#[derive(Debug)]
pub struct Draw(ChaCha8Rng);

impl Draw {
    /// The numbers of scene `index` of a hunt.
    #[must_use]
    pub fn new(seed: u64, index: u64) -> Self {
        let mut random = ChaCha8Rng::seed_from_u64(seed);
        random.set_stream(index);
        Self(random)
    }

    /// Uniform between two numbers.
    pub fn between(&mut self, low: f64, high: f64) -> f64 {
        let unit = (self.0.next_u64() >> 11) as f64 / (1_u64 << 53) as f64;
        rounded(low + (high - low) * unit)
    }

    /// Uniform in the logarithm.
    pub fn scaled(&mut self, low: f64, high: f64) -> f64 {
        rounded(self.between(low.ln(), high.ln()).exp())
    }

    /// A whole number, both ends included.
    pub fn whole(&mut self, low: u64, high: u64) -> u64 {
        low + self.0.next_u64() % (high - low + 1)
    }

    /// True with a probability.
    pub fn chance(&mut self, probability: f64) -> bool {
        self.between(0.0, 1.0) < probability
    }

    /// One of several.
    pub fn one_of<'a, T>(&mut self, all: &'a [T]) -> &'a T {
        let k = self.0.next_u64() % all.len() as u64;
        &all[usize::try_from(k).unwrap_or_default()]
    }
}

/// With four digits, as one would write it.
pub(crate) fn rounded(value: f64) -> f64 {
    if value == 0.0 || !value.is_finite() {
        return value;
    }
    format!("{value:.3e}").parse().unwrap_or(value)
}
