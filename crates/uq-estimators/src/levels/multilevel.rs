//! Multilevel Monte Carlo.

use crate::comoments::Comoments;
use crate::error::{Error, require_at_least, require_finite_responses, require_positive};
use crate::ladder::{Ladder, MOST_LEVELS, Pair, SAMPLE_BITS};
use crate::levels::blocks::{Block, BlockId, Progress, blocks_for, samples_of};
use crate::levels::multilevel_result::MultilevelResult;
use crate::levels::statistic::{COMPONENTS, Target, Tolerance};
use crate::levels::survey::Survey;
use crate::parallel::map_in_order;
use crate::rates::Bias;

/// Multilevel Monte Carlo over a [`Ladder`].
///
/// $$ E Y_L = E Y_b + \sum_{l = b+1}^{L} E (Y_l - Y_{l-1}), \qquad
///    N_l = \frac{2}{\epsilon^2} \sqrt{V_l / C_l} \sum_k \sqrt{V_k C_k} , $$
///
/// each term from its own $N_l$ samples, with the variance $V_l$ and the cost $C_l$ of a sample. Half of the squared
/// tolerance $\epsilon^2$ is for the variance of the estimate, half for the squared bias
/// $\lvert m_L \rvert / (2^\alpha - 1)$ of the finest level, with $m_l$ the mean of the difference and $\alpha$ the weak
/// order; all of it is for the variance by [`Bias::FinestIsExact`]. Levels are added until the bias is small enough. With
/// several targets each level takes the largest number of samples that one of them needs.
///
/// A pilot on each level measures the variances. The coarsest level $b$ is the one with the lowest predicted cost:
/// levels below it do not pay and are dropped; for $b = L$ multilevel does not pay at all, and the result is plain Monte
/// Carlo. A level whose pilot differs by chance too little takes at least half of the variance that the fitted rate
/// predicts from the level below.
///
/// The result depends on ladder and fields alone: bitwise identical for any number of threads, after an interruption, and
/// for blocks computed apart. [`run`](Self::run) does everything; for shards and resumption use
/// [`begin`](Self::begin), [`Progress::missing`], [`block`](Self::block), [`Progress::insert`],
/// [`advance`](Self::advance) and [`finish`](Self::finish).
///
/// Sources: Giles 2008, Multilevel Monte Carlo path simulation, section 5; Giles 2015, Multilevel Monte Carlo methods,
/// sections 2 and 3 (estimates of bias, rates from the pilot, test of the nesting).
///
/// ```
/// use uq_estimators::{Bias, Levels, Multilevel, Statistic, Target, Tolerance};
/// use sde_integrators::{Noise, Purpose};
///
/// // exp(u) by Taylor polynomials of degree 1, 2, 4: the mean over u in [0, 1] is e - 1.
/// let run = |level: usize, realisation: u64, y: &mut [f64]| {
///     let u = Noise::new(1).stream(Purpose::Field, realisation).next_uniform();
///     y[0] = (0..1 << level).rev().fold(1.0, |sum, k| 1.0 + u * sum / (k + 1) as f64);
///     Ok(())
/// };
/// let ladder = Levels { costs: &[1.0, 2.0, 4.0, 8.0], n_responses: 1, run };
/// let tolerance = Tolerance::Absolute(2e-3);
/// let targets = [Target { response: 0, statistic: Statistic::Mean, tolerance }];
/// let study = Multilevel {
///     name: "exp", targets: &targets, bias: Bias::FinestIsExact, block_length: 64, pilot_blocks: 2,
///     budget: 1e6,
/// };
/// let found = study.run(&ladder)?;
/// let mean = found.targets[0].estimate;
/// assert!((mean.value - (1_f64.exp() - 1.0)).abs() < 4.0 * mean.standard_error().unwrap());
/// # Ok::<(), uq_estimators::Error>(())
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Multilevel<'a> {
    /// Name of the study: blocks of studies with different names are not merged. It represents what cannot be compared:
    /// the models and their seed.
    pub name: &'a str,
    /// What is estimated.
    pub targets: &'a [Target],
    /// The bias of the finest level.
    pub bias: Bias,
    /// Samples per block, the unit of parallel work; one where a sample takes minutes. Further blocks grow slowly.
    pub block_length: u64,
    /// Blocks of the pilot on each level; together at least eight samples.
    pub pilot_blocks: u64,
    /// Largest cost of all samples, in the unit of [`Ladder::cost`].
    pub budget: f64,
}

/// Levels of the first pilot.
const FIRST_LEVELS: usize = 3;

/// Smallest pilot.
const FEWEST_SAMPLES: u64 = 8;

impl Multilevel<'_> {
    /// Runs all samples and returns the estimates.
    ///
    /// With the feature `rayon` blocks run in parallel on the current pool.
    ///
    /// # Errors
    /// [`Error::NotPositive`], [`Error::NoSuchResponse`], [`Error::TooFew`], [`Error::CostNotIncreasing`] for fields and
    /// ladder; [`Error::SampleFailed`], [`Error::NonFiniteSample`] for the lowest block with such a sample;
    /// [`Error::NotNested`]; [`Error::OverBudget`] before the samples are run that exceed it.
    pub fn run<L: Ladder + ?Sized>(&self, ladder: &L) -> Result<MultilevelResult, Error> {
        let mut progress = self.begin(ladder)?;
        while self.advance(ladder, &mut progress)? {
            let missing = progress.missing();
            for block in map_in_order(&missing, |&id| self.block(ladder, &progress, id)) {
                progress.insert(block?)?;
            }
        }
        self.finish(ladder, &progress)
    }

    /// Checks the fields, runs one sample of level 0, and plans nothing yet.
    ///
    /// # Errors
    /// As [`run`](Self::run).
    pub fn begin<L: Ladder + ?Sized>(&self, ladder: &L) -> Result<Progress, Error> {
        self.check(ladder)?;
        let (id, mut centres) = (Pair::alone(0), vec![0.0; ladder.n_responses()]);
        run_sample(ladder, id, id.realisation(0), &mut centres, &mut [])?;
        Ok(Progress::new(self.name.into(), self.block_length, centres))
    }

    fn check<L: Ladder + ?Sized>(&self, ladder: &L) -> Result<(), Error> {
        require_at_least("targets", self.targets.len() as u64, 1)?;
        for (index, target) in self.targets.iter().enumerate() {
            target.check(index, ladder.n_responses())?;
        }
        let n_asked = self.targets.iter().filter(|target| target.tolerance != Tolerance::Open);
        require_at_least("targets with a tolerance", n_asked.count() as u64, 1)?;
        if let Bias::Order(order) = self.bias {
            require_positive("weak order", 0, order)?;
        }
        require_at_least("samples in a block", self.block_length, 1)?;
        let pilot = self.block_length.saturating_mul(self.pilot_blocks);
        require_at_least("samples in the pilot", pilot, FEWEST_SAMPLES)?;
        let most = 1_u64 << (SAMPLE_BITS - 8);
        if pilot > most {
            let (value, limit) = (pilot as f64, most as f64);
            return Err(Error::TooMany { quantity: "samples in the pilot", value, limit });
        }
        if self.budget.is_nan() || self.budget <= 0.0 {
            let (quantity, value) = ("budget", self.budget);
            return Err(Error::NotPositive { quantity, index: 0, value });
        }
        let n_levels = ladder.n_levels();
        let least = if self.bias == Bias::FinestIsExact { 1 } else { 2 };
        require_at_least("levels", n_levels as u64, least)?;
        if n_levels > MOST_LEVELS {
            let (value, limit) = (n_levels as f64, MOST_LEVELS as f64);
            return Err(Error::TooMany { quantity: "levels", value, limit });
        }
        let mut limit = 0.0;
        for level in 0..n_levels {
            let value = ladder.cost(level);
            require_positive("cost of level", level, value)?;
            if value <= limit {
                return Err(Error::CostNotIncreasing { level, value, limit });
            }
            limit = value;
        }
        Ok(())
    }

    /// Runs the samples of one block, in order.
    ///
    /// # Errors
    /// [`Error::SampleFailed`], [`Error::NonFiniteSample`].
    pub fn block<L: Ladder + ?Sized>(
        &self,
        ladder: &L,
        progress: &Progress,
        id: BlockId,
    ) -> Result<Block, Error> {
        let n = ladder.n_responses();
        let (mut fine, mut coarse) =
            (vec![0.0; n], vec![0.0; if id.pair.coarse.is_some() { n } else { 0 }]);
        let mut sums = vec![Comoments::new(2 * COMPONENTS); self.targets.len()];
        for k in samples_of(self.block_length, id.block) {
            run_sample(ladder, id.pair, id.pair.realisation(k), &mut fine, &mut coarse)?;
            for (sums, target) in sums.iter_mut().zip(self.targets) {
                let centre = progress.centres[target.response];
                let of_fine = target.components(fine[target.response], centre);
                let mut difference = of_fine;
                if let Some(&y) = coarse.get(target.response) {
                    let below = target.components(y, centre);
                    difference = std::array::from_fn(|c| of_fine[c] - below[c]);
                }
                sums.push([difference, of_fine].as_flattened());
            }
        }
        Ok(Block { study: self.name.into(), id, sums })
    }

    /// Plans further blocks from those that are known; returns whether there are any. Without, the estimate is complete.
    ///
    /// # Errors
    /// [`Error::MissingBlocks`] while planned blocks are missing; [`Error::NotNested`], [`Error::OverBudget`]; those of
    /// [`begin`](Self::begin) for fields and ladder.
    pub fn advance<L: Ladder + ?Sized>(
        &self,
        ladder: &L,
        progress: &mut Progress,
    ) -> Result<bool, Error> {
        self.check(ladder)?;
        self.check_progress(ladder, progress)?;
        progress.require_complete()?;
        let n_levels = ladder.n_levels();
        let mut next = progress.clone();
        let mut is_new = false;
        if progress.pairs().next().is_none() {
            let is_all = self.bias == Bias::FinestIsExact;
            for level in 0..if is_all { n_levels } else { n_levels.min(FIRST_LEVELS) } {
                is_new |= next.plan(Pair::neighbours(level), self.pilot_blocks);
            }
        } else {
            let survey = Survey::new(self.targets, self.bias, self.pilot_blocks, ladder, progress)?;
            for (pair, n_samples) in survey.wanted()? {
                is_new |= next.plan(pair, blocks_for(self.block_length, n_samples));
            }
            if !is_new && survey.top + 1 < n_levels && !survey.is_bias_small() {
                is_new = next.plan(Pair::neighbours(survey.top + 1), self.pilot_blocks);
            }
        }
        let value = total_cost(ladder, &next);
        if is_new && value > self.budget {
            return Err(Error::OverBudget { value, limit: self.budget });
        }
        *progress = next;
        Ok(is_new)
    }

    /// The estimates from the blocks that are known.
    ///
    /// # Errors
    /// [`Error::MissingBlocks`] while planned blocks are missing, or none are planned; [`Error::NotNested`].
    pub fn finish<L: Ladder + ?Sized>(
        &self,
        ladder: &L,
        progress: &Progress,
    ) -> Result<MultilevelResult, Error> {
        self.check_progress(ladder, progress)?;
        progress.require_complete()?;
        let survey = Survey::new(self.targets, self.bias, self.pilot_blocks, ladder, progress)?;
        if let Some((pair, _)) = survey.wanted()?.first()
            && progress.n_blocks(*pair) == 0
        {
            let pair = pair.to_string();
            return Err(Error::MissingBlocks { missing: 1, pair, block: 0 });
        }
        Ok(survey.result(total_cost(ladder, progress)))
    }

    /// Whether the state is of this study.
    fn check_progress<L: Ladder + ?Sized>(
        &self,
        ladder: &L,
        progress: &Progress,
    ) -> Result<(), Error> {
        let fields = [
            ("name", progress.study.clone(), self.name.to_owned()),
            ("block length", progress.block_length.to_string(), self.block_length.to_string()),
            (
                "number of responses",
                progress.centres.len().to_string(),
                ladder.n_responses().to_string(),
            ),
        ];
        for (field, value, expected) in fields {
            if value != expected {
                return Err(Error::ForeignBlock { field, value, expected });
            }
        }
        Ok(())
    }
}

fn run_sample<L: Ladder + ?Sized>(
    ladder: &L,
    pair: Pair,
    realisation: u64,
    fine: &mut [f64],
    coarse: &mut [f64],
) -> Result<(), Error> {
    ladder.sample(pair, realisation, fine, coarse).map_err(|failure| Error::SampleFailed {
        model: pair.to_string(),
        realisation,
        message: failure.to_string(),
    })?;
    require_finite_responses(&pair, realisation, fine)?;
    require_finite_responses(&pair, realisation, coarse)
}

/// Cost of all planned samples.
fn total_cost<L: Ladder + ?Sized>(ladder: &L, progress: &Progress) -> f64 {
    let of = |(pair, n_blocks): (Pair, u64)| {
        let n_samples = samples_of(progress.block_length, n_blocks).start;
        n_samples as f64 * pair.cost(|level| ladder.cost(level))
    };
    progress.pairs().map(of).sum()
}
