//! Ladders of models that accept the same random input.

use std::fmt;

/// Why a model could not be run; any error converts into it with `?`.
pub type Failure = Box<dyn std::error::Error + Send + Sync>;

/// A level of a ladder, with the coarser level that is run on the same random input.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Pair {
    /// The finer level, from 0 for the cheapest model.
    pub fine: usize,
    /// The coarser level; none for the coarsest level of an estimate, which is run alone.
    pub coarse: Option<usize>,
}

impl Pair {
    /// Two neighbouring levels; level 0 alone.
    #[must_use]
    pub const fn neighbours(level: usize) -> Self {
        Self { fine: level, coarse: level.checked_sub(1) }
    }

    /// A level alone.
    #[must_use]
    pub const fn alone(level: usize) -> Self {
        Self { fine: level, coarse: None }
    }

    /// Cost of a sample.
    pub(crate) fn cost(self, costs: impl Fn(usize) -> f64) -> f64 {
        costs(self.fine) + self.coarse.map_or(0.0, &costs)
    }

    /// Number of the random input of sample `k`: samples of different pairs never share one.
    pub(crate) const fn realisation(self, k: u64) -> u64 {
        let place = 2 * self.fine as u64 + self.coarse.is_some() as u64;
        place << SAMPLE_BITS | k
    }
}

impl fmt::Display for Pair {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.coarse {
            Some(coarse) => write!(f, "level {} less level {coarse}", self.fine),
            None => write!(f, "level {}", self.fine),
        }
    }
}

/// Samples of a pair are numbered below `2^40`.
pub(crate) const SAMPLE_BITS: u32 = 40;

/// Largest number of levels.
pub(crate) const MOST_LEVELS: usize = 1 << 20;

/// Models of increasing accuracy and cost that accept the same random input.
///
/// Level 0 is the cheapest. A sample runs one level, or two on the same random input: the same Brownian path at two step
/// lengths, the same parameters on two meshes. The distribution of the responses of a level must be the same in both
/// roles; otherwise the levels do not nest, and an estimate is refused.
pub trait Ladder: Sync {
    /// Number of levels.
    fn n_levels(&self) -> usize;

    /// Number of responses of a sample.
    fn n_responses(&self) -> usize;

    /// Cost of one run of a level alone, in any unit: steps, or seconds measured before.
    ///
    /// It increases with the level. The number of samples follows from it, so a run is reproducible if the costs are.
    fn cost(&self, level: usize) -> f64;

    /// Whether the responses of a level are a function of level and random input alone, so that levels nest by construction.
    ///
    /// Without it the means of each level in both roles are compared, which refuses a sound ladder now and then if it has many
    /// responses.
    fn nests_by_construction(&self) -> bool {
        false
    }

    /// Runs the levels of `pair` on random input number `realisation` and writes their responses.
    ///
    /// The random input is a pure function of pair and number, and independent between numbers. `coarse` is empty for a
    /// level alone.
    ///
    /// # Errors
    /// If a model cannot be run. A response that is not finite is refused by the caller.
    fn sample(
        &self,
        pair: Pair,
        realisation: u64,
        fine: &mut [f64],
        coarse: &mut [f64],
    ) -> Result<(), Failure>;
}

/// A ladder from a closure that runs one level on one random input.
///
/// The closure takes the level and the number of the random input, and writes the responses. For one number it must use
/// the same random input at every level.
#[derive(Debug, Clone, Copy)]
pub struct Levels<'a, F> {
    /// Cost of a run of each level.
    pub costs: &'a [f64],
    /// Number of responses.
    pub n_responses: usize,
    /// Runs a level: `(level, realisation, responses)`.
    pub run: F,
}

impl<F> Ladder for Levels<'_, F>
where
    F: Fn(usize, u64, &mut [f64]) -> Result<(), Failure> + Sync,
{
    fn n_levels(&self) -> usize {
        self.costs.len()
    }

    fn n_responses(&self) -> usize {
        self.n_responses
    }

    fn cost(&self, level: usize) -> f64 {
        self.costs[level]
    }

    fn sample(
        &self,
        pair: Pair,
        realisation: u64,
        fine: &mut [f64],
        coarse: &mut [f64],
    ) -> Result<(), Failure> {
        (self.run)(pair.fine, realisation, fine)?;
        pair.coarse.map_or(Ok(()), |level| (self.run)(level, realisation, coarse))
    }
}
