//! Guided paths: a feedback shifts the normals of a path towards an event, and likelihood ratios undo its effect.

use std::cmp::Ordering;
use std::ops::Range;

use crate::blocks::{BLOCK_LENGTH, reduce_blocks_of, reduce_in_tree};
use crate::ensembles::follow::Lives;
use crate::ensembles::guide::Guide;
use crate::ensembles::guided_group::{Group, Shared};
use crate::ensembles::guided_watch::{EndAlone, Largest, Peaks};
use crate::ensembles::maximum::Response;
use crate::error::Error;
use crate::methods::lane_paths::LanePaths;
use crate::noise::lane_increments::LANES;

/// A path of a [`GuidedEnsemble`].
#[derive(Debug)]
pub struct GuidedPath<'a> {
    /// Its number.
    pub realisation: u64,
    /// The last state.
    pub end: &'a [f64],
    /// Largest response, if one is asked for; otherwise `-inf`.
    pub largest: f64,
    /// Logarithm of the density of its normals under each guide over that without a guide.
    pub log_ratios: &'a [f64],
    /// Logarithm of the weight: the density without a guide over that of the mixture.
    pub log_weight: f64,
    /// First passage of each level, if the path passes it.
    pub passages: &'a [Option<Passage<'a>>],
}

/// First passage of a level by a path.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Passage<'a> {
    /// Number of steps after which the largest response exceeds the level.
    pub steps: u64,
    /// Logarithm of the density of the normals up to the passage under each guide over that without a guide.
    pub log_ratios: &'a [f64],
    /// Logarithm of the weight of the passage: the density of these normals without a guide over that of the mixture.
    pub log_weight: f64,
}

/// The passages that a [`GuidedEnsemble`] records: of the largest of some responses, through increasing levels.
#[derive(Debug, Clone, Copy)]
pub struct Passages<'a> {
    /// The responses; the largest of them counts.
    pub responses: &'a [Response<'a>],
    /// The levels (unit of the responses).
    pub levels: &'a [f64],
}

/// Paths from a normal initial distribution, each under one of several guides.
///
/// The guide of a path is drawn by its share; the rest, `1 - sum`, is without a guide. The draws are stratified: path `j` of the
/// `n` of a block takes the guide at the place `(j + U)/n` of the shares, with `U` uniform, so that a block has hardly more or
/// fewer paths of a guide than its share. Means over a block keep their expectation, and their variance is smaller than that of
/// independent paths; squared differences of successive paths estimate it (von Neumann 1941, Distribution of the ratio of the
/// mean square successive difference to the variance). For a function `F` of the path
///
/// $$ E\[F\] = E_q\[F w\], \qquad w = \Big( c_0 + \sum_j c_j r_j \Big)^{-1}, \qquad
///    \ln r_j = \sum_k \Big( \theta_{jk} \cdot n_k - \tfrac12 |\theta_{jk}|^2 \Big), $$
///
/// with the shares `c`, the normals `n_k` of step `k` (and of the start), the shift `theta_jk` that guide `j` gives at
/// the state before the step, and `q` the mixture. A weight is at most `1/c_0`. The weights are exact for any guide and
/// any method, because they are those of the discrete normals; the guides determine the variance alone.
///
/// The likelihood ratios are martingales of the free paths. An event that is known at a stopping time, such as the first
/// passage of a level up to some time, therefore has the weight of the mixture at that time: what follows would only
/// scatter it. One set of paths so serves many levels and times, each with its own [`Passage`]. A guide ends after the
/// step in which a path passes the level of the guide.
///
/// Choice of the guide and normals of the start are drawn from [`Purpose::InitialDistribution`](crate::Purpose), the others
/// as in [`simulate`](crate::simulate). Paths advance in groups of [`LANES`]; a step allocates nothing.
///
/// Sources: Girsanov 1960, On transforming a certain class of stochastic processes by absolutely continuous
/// substitution of measures; mixture weights (balance heuristic): Veach and Guibas 1995, Optimally combining sampling
/// techniques for Monte Carlo rendering; defensive share: Hesterberg 1995, Weighted average importance sampling and
/// defensive mixture distributions; stratified draws: Cochran 1977, Sampling techniques, section 5.
#[derive(Debug)]
pub struct GuidedEnsemble<'a, P, const M: usize> {
    /// System and method.
    pub paths: &'a P,
    /// Mean of the initial distribution (units of the states).
    pub mean: &'a [f64],
    /// `L`, row by row, with the initial covariance `L L^T`; zero for a start at the mean.
    pub factor: &'a [f64],
    /// Step length (time).
    pub dt: f64,
    /// Number of steps.
    pub n_steps: usize,
    /// The guides.
    pub guides: &'a [Guide],
    /// Passages that are recorded, if any.
    pub passages: Option<Passages<'a>>,
    /// Seed of all random numbers.
    pub seed: u64,
}

impl<P: LanePaths<M>, const M: usize> GuidedEnsemble<'_, P, M> {
    /// Simulates the paths of a range of realisations and collects them in blocks, by realisation in each.
    ///
    /// `new` makes an empty collection, `push` adds a path, `merge(earlier, later)` joins two, in the order of
    /// [`reduce_blocks`](crate::reduce_blocks): the result is bitwise identical for any number of threads.
    ///
    /// # Errors
    /// Those of [`blocks`](Self::blocks).
    pub fn run<A: Send + Clone>(
        &self,
        realisations: Range<u64>,
        new: impl Fn() -> A + Sync,
        push: impl Fn(&mut A, &GuidedPath<'_>) + Sync,
        merge: impl Fn(A, A) -> A + Sync,
    ) -> Result<A, Error> {
        let n_blocks = count(&realisations).div_ceil(BLOCK_LENGTH);
        let all = self.blocks((realisations, BLOCK_LENGTH), 0..n_blocks, new, push)?;
        let too_few = Error::TooFew { quantity: "paths", value: 0, limit: 1 };
        reduce_in_tree(&all, &A::clone, &merge).ok_or(too_few)
    }

    /// Simulates some blocks of a range of realisations, each of `length` of them, and returns the collection of each.
    ///
    /// `new` makes an empty collection, `push` adds a path, by realisation in each block. Blocks run in parallel, and a block
    /// is bitwise identical whatever runs beside it. [`reduce_in_tree`] joins all blocks of a range as [`run`](Self::run) does.
    ///
    /// # Errors
    /// [`Error::NotPositive`] for the step length; [`Error::WrongLength`], [`Error::NotFinite`] and [`Error::TooFew`] for
    /// the start and the guides; [`Error::OutOfRange`] for shares that are not positive or exceed 1 together, and for
    /// levels that do not increase; those of [`maxima`](crate::maxima) for a response; [`Error::TooFew`] for a length of
    /// zero, and for no realisations, responses or levels; a failed path, [`Error::Step`] or [`Error::NonFiniteState`],
    /// always the lowest.
    pub fn blocks<A: Send>(
        &self,
        (realisations, length): (Range<u64>, u64),
        blocks: Range<u64>,
        new: impl Fn() -> A + Sync,
        push: impl Fn(&mut A, &GuidedPath<'_>) + Sync,
    ) -> Result<Vec<A>, Error> {
        let unguided = self.check()?;
        for (quantity, value) in [("paths of a block", length), ("paths", count(&realisations))] {
            if value == 0 {
                return Err(Error::TooFew { quantity, value: 0, limit: 1 });
            }
        }
        let bound = |block: u64| {
            realisations.start.saturating_add(block.saturating_mul(length)).min(realisations.end)
        };
        let (first, last) = (bound(blocks.start), bound(blocks.end));
        let block = |ids: Range<u64>| {
            let mut collected = new();
            let ids = first + ids.start..first + ids.end;
            let push = |path: &GuidedPath<'_>| push(&mut collected, path);
            match self.passages {
                Some(Passages { responses, .. }) => {
                    let watch = Peaks::new(responses, self.seed);
                    self.block(ids, unguided, watch, push)?;
                }
                None => self.block(ids, unguided, EndAlone, push)?,
            }
            Ok(vec![collected])
        };
        let append = |mut earlier: Vec<A>, mut later: Vec<A>| {
            earlier.append(&mut later);
            earlier
        };
        let n = count(&(first..last));
        Ok(reduce_blocks_of(length, n, block, append)?.unwrap_or_default())
    }

    /// Checks the input; returns the share of the paths without a guide.
    fn check(&self) -> Result<f64, Error> {
        if !(self.dt.is_finite() && self.dt > 0.0) {
            return Err(Error::NotPositive { quantity: "dt", value: self.dt });
        }
        let n_states = self.paths.start().0.as_ref().len();
        for (quantity, values, expected) in [
            ("means of the start", self.mean, n_states),
            ("entries of the factor of the start", self.factor, n_states * n_states),
        ] {
            if values.len() != expected {
                return Err(Error::WrongLength { quantity, value: values.len(), expected });
            }
        }
        let n_levels = self.check_passages(n_states)?;
        let mut unguided = 1.0;
        for (index, guide) in self.guides.iter().enumerate() {
            guide.check(index, (n_states, M, n_levels))?;
            unguided -= guide.share;
            let value = guide.share;
            // Shares that add up to one within roundoff leave none.
            if !(value > 0.0 && unguided > -1e-12) {
                let (quantity, to) = ("share of a guide", (unguided + value).max(0.0));
                return Err(Error::OutOfRange { quantity, value, from: 0.0, to });
            }
        }
        Ok(if unguided < 1e-12 { 0.0 } else { unguided })
    }

    /// Checks responses and levels; returns the number of levels.
    fn check_passages(&self, n_states: usize) -> Result<usize, Error> {
        let Some(Passages { responses, levels }) = self.passages else { return Ok(0) };
        for (quantity, value) in [("responses", responses.len()), ("levels", levels.len())] {
            if value == 0 {
                return Err(Error::TooFew { quantity, value: 0, limit: 1 });
            }
        }
        for response in responses {
            response.check(n_states, self.dt)?;
        }
        for pair in levels.windows(2) {
            if pair[0].partial_cmp(&pair[1]) != Some(Ordering::Less) {
                let (quantity, value) = ("level, which must exceed the one before it,", pair[1]);
                return Err(Error::OutOfRange {
                    quantity,
                    value,
                    from: pair[0],
                    to: f64::INFINITY,
                });
            }
        }
        Ok(levels.len())
    }

    fn block<W: Largest>(
        &self,
        ids: Range<u64>,
        unguided: f64,
        mut watch: W,
        mut push: impl FnMut(&GuidedPath<'_>),
    ) -> Result<(), Error> {
        let n_guides = self.guides.len();
        let Self { paths, mean, factor, dt, n_steps, guides, passages, seed } = *self;
        let levels = passages.map_or(&[][..], |passages| passages.levels);
        let n_levels = levels.len();
        let strata = (ids.start, count(&ids));
        let shared = Shared { paths, mean, factor, dt, n_steps, guides, levels, seed, strata };
        let mut group = Group::new(shared);
        let mut end = vec![0.0; mean.len()];
        // The ratios at the end of the path, then those at the passage of each level.
        let mut ratios = vec![0.0; n_guides * (1 + n_levels)];
        let mut first = ids.start;
        while first < ids.end {
            let stop = ids.end.min(first + LANES as u64);
            let mut lives = Lives::new(&(first..stop));
            let (x, largest) = group.follow(&mut lives, &mut watch);
            let n_active = lives.n_active;
            if let Some((_, error)) = lives.into_failures().next() {
                return Err(error);
            }
            for lane in 0..n_active {
                for (value, row) in end.iter_mut().zip(x.as_ref()) {
                    *value = row[lane];
                }
                group.ratios(lane, &mut ratios);
                let (log_ratios, at_passages) = ratios.split_at(n_guides);
                let passages: Vec<Option<Passage<'_>>> = (0..n_levels)
                    .map(|level| {
                        let log_ratios = &at_passages[level * n_guides..(level + 1) * n_guides];
                        let steps = group.passage(level, lane)?;
                        let log_weight = -self.log_mixture(unguided, log_ratios);
                        Some(Passage { steps, log_ratios, log_weight })
                    })
                    .collect();
                push(&GuidedPath {
                    realisation: first + lane as u64,
                    end: &end,
                    largest: largest[lane],
                    log_ratios,
                    log_weight: -self.log_mixture(unguided, log_ratios),
                    passages: &passages,
                });
            }
            first = stop;
        }
        Ok(())
    }

    /// `ln(c_0 + sum_j c_j r_j)`.
    fn log_mixture(&self, unguided: f64, log_ratios: &[f64]) -> f64 {
        let none = if unguided > 0.0 { 0.0 } else { f64::NEG_INFINITY };
        let largest = log_ratios.iter().copied().fold(none, f64::max);
        let mut sum = unguided * (-largest).exp();
        for (guide, ratio) in self.guides.iter().zip(log_ratios) {
            sum += guide.share * (ratio - largest).exp();
        }
        largest + sum.ln()
    }
}

const fn count(realisations: &Range<u64>) -> u64 {
    realisations.end.saturating_sub(realisations.start)
}
