//! Variances, rates, allocation and bias from the blocks that are known.

use sde_integrators::{Estimate, Uncertainty};

use crate::comoments::Comoments;
use crate::error::Error;
use crate::ladder::{Ladder, Pair, SAMPLE_BITS};
use crate::levels::blocks::Progress;
use crate::levels::multilevel_result::{LevelReport, MultilevelResult, TargetResult};
use crate::levels::statistic::{COMPONENTS, Statistic, Target, TargetSums};
use crate::rates::{Bias, error_of_variance, extrapolated, floored, with_error};

/// Variances, rates and bias of a study, from its blocks.
pub(crate) struct Survey<'a> {
    targets: &'a [Target],
    bias: Bias,
    /// Finest level with a pilot.
    pub(crate) top: usize,
    /// Coarsest level of the estimate.
    coarsest: usize,
    /// Cost of each level alone, to `top`.
    costs: Vec<f64>,
    /// Sums of neighbouring levels by target, from level 0.
    neighbours: Vec<Vec<Comoments>>,
    /// Sums of the coarsest level alone by target, once it is planned.
    alone: Option<Vec<Comoments>>,
    /// Variances of the differences by target, from level 0: floored by the fitted rate.
    variances: Vec<Vec<f64>>,
    /// Tolerances in the units of the targets; infinite where nothing is asked.
    tolerances: Vec<f64>,
}

impl<'a> Survey<'a> {
    pub(crate) fn new<L: Ladder + ?Sized>(
        targets: &'a [Target],
        bias: Bias,
        pilot_blocks: u64,
        ladder: &L,
        progress: &Progress,
    ) -> Result<Self, Error> {
        let sums_of = |most| {
            let of = |level| progress.sums(Pair::neighbours(level), most);
            (0..ladder.n_levels()).map_while(of).collect::<Vec<_>>()
        };
        let neighbours = sums_of(u64::MAX);
        let Some(top) = neighbours.len().checked_sub(1) else {
            let pair = Pair::neighbours(0).to_string();
            return Err(Error::MissingBlocks { missing: 1, pair, block: 0 });
        };
        let costs: Vec<f64> = (0..=top).map(|level| ladder.cost(level)).collect();
        // The choice of the coarsest level is by the pilot alone: it does not change as samples are added.
        let mut by_pilot = Self {
            targets,
            bias,
            top,
            coarsest: 0,
            costs: costs.clone(),
            neighbours: sums_of(pilot_blocks),
            alone: None,
            variances: Vec::new(),
            tolerances: Vec::new(),
        }
        .with_variances();
        // Levels that have nothing in common would spoil a sum over all of them.
        by_pilot.tolerances = (0..targets.len())
            .map(|target| by_pilot.tolerance(target, by_pilot.of(top, target).fine_value()))
            .collect();
        let coarsest = by_pilot.cheapest();
        let pair = Pair::alone(coarsest);
        let alone = if coarsest == 0 { None } else { progress.sums(pair, u64::MAX) };
        let mut survey = Self { coarsest, neighbours, alone, ..by_pilot }.with_variances();
        survey.tolerances = (0..targets.len())
            .map(|target| survey.tolerance(target, survey.value(target)))
            .collect();
        if !ladder.nests_by_construction() {
            survey.require_nested()?;
        }
        Ok(survey)
    }

    /// A target on the finest level, from the levels that are used.
    fn value(&self, target: usize) -> f64 {
        self.sum_over_levels(target, |sums, is_alone| {
            if is_alone { sums.fine_value() } else { sums.difference_value() }
        })
    }

    /// Means of the components of a target on the finest level, likewise.
    fn means(&self, target: usize) -> [f64; COMPONENTS] {
        std::array::from_fn(|c| {
            self.sum_over_levels(target, |sums, is_alone| {
                let means = if is_alone { sums.fine_means() } else { sums.difference_means() };
                means[c]
            })
        })
    }

    /// Sum over the levels that are used: of the coarsest alone, and of the differences above it.
    fn sum_over_levels(&self, target: usize, of: impl Fn(TargetSums<'_>, bool) -> f64) -> f64 {
        let of_level = |level: usize| {
            // The samples of the coarsest alone are not planned at first: it has those of a difference.
            let is_alone = level == self.coarsest && level > 0 && self.alone.is_none();
            let sums = if is_alone { self.of(level, target) } else { self.term(level, target) };
            of(sums, is_alone)
        };
        (self.coarsest..=self.top).map(of_level).sum()
    }

    /// The tolerance of a target in its unit, for this value of it on the finest level.
    fn tolerance(&self, target: usize, value: f64) -> f64 {
        let (asked, finest) = (&self.targets[target], self.of(self.top, target));
        let magnitude =
            |value| asked.magnitude(value, finest.fine_deviation(), finest.sums.count());
        let own = || magnitude(finest.fine_value());
        asked.tolerance.of(magnitude(value).or_else(own).unwrap_or(0.0))
    }

    fn with_variances(mut self) -> Self {
        self.variances = (0..self.targets.len())
            .map(|target| {
                let of = |level| {
                    let of_level = self.of(level, target);
                    let n = of_level.sums.count() as f64;
                    let variance = of_level.difference_variance();
                    let is_indicator =
                        matches!(self.targets[target].statistic, Statistic::Exceedance { .. });
                    // No sample on either side: the rule of three, as in `Estimate::probability`.
                    if is_indicator && variance == 0.0 { 3.0 / n } else { variance }
                };
                floored((0..=self.top).map(of).collect())
            })
            .collect();
        self
    }

    fn of(&self, level: usize, target: usize) -> TargetSums<'_> {
        self.sums(&self.neighbours[level], target)
    }

    fn sums<'b>(&self, of_pair: &'b [Comoments], target: usize) -> TargetSums<'b> {
        let is_variance = self.targets[target].statistic == Statistic::Variance;
        TargetSums { sums: &of_pair[target], is_variance }
    }

    /// Sums of a term of the estimate: the coarsest level alone, or a difference above it.
    fn term(&self, level: usize, target: usize) -> TargetSums<'_> {
        match &self.alone {
            Some(sums) if level == self.coarsest => self.sums(sums, target),
            _ => self.of(level, target),
        }
    }

    /// Variance of a sample of a term, for a choice of the coarsest level.
    fn term_variance(&self, coarsest: usize, level: usize, target: usize) -> f64 {
        if level > coarsest || level == 0 {
            return self.variances[target][level];
        }
        match &self.alone {
            Some(_) if level == self.coarsest => self.term(level, target).difference_variance(),
            _ => self.of(level, target).fine_variance(),
        }
    }

    fn term_pair(coarsest: usize, level: usize) -> Pair {
        if level == coarsest { Pair::alone(level) } else { Pair::neighbours(level) }
    }

    fn term_cost(&self, coarsest: usize, level: usize) -> f64 {
        Self::term_pair(coarsest, level).cost(|level| self.costs[level])
    }

    /// Number of samples of each term, from the coarsest level on: the largest that a target needs.
    fn allocation(&self, coarsest: usize) -> Vec<f64> {
        let mut samples = vec![2.0_f64; self.top + 1 - coarsest];
        for (target, tolerance) in self.tolerances.iter().enumerate() {
            let terms: Vec<(f64, f64)> = (coarsest..=self.top)
                .map(|level| {
                    let cost = self.term_cost(coarsest, level);
                    (self.term_variance(coarsest, level, target), cost)
                })
                .collect();
            let root: f64 = terms.iter().map(|(variance, cost)| (variance * cost).sqrt()).sum();
            if root == 0.0 {
                continue;
            }
            let scale = self.bias.share_of_variance().recip() / (tolerance * tolerance) * root;
            for (n, (variance, cost)) in samples.iter_mut().zip(terms) {
                let needed = (scale * (variance / cost).sqrt()).ceil();
                if needed > *n {
                    *n = needed;
                }
            }
        }
        samples
    }

    /// The coarsest level with the lowest predicted cost.
    fn cheapest(&self) -> usize {
        let mut best = (0, f64::INFINITY);
        for coarsest in 0..=self.top {
            let samples = self.allocation(coarsest);
            let cost: f64 = (coarsest..)
                .zip(&samples)
                .map(|(level, n)| n * self.term_cost(coarsest, level))
                .sum();
            if cost < best.1 {
                best = (coarsest, cost);
            }
        }
        best.0
    }

    /// Number of samples that each term of the estimate must have.
    pub(crate) fn wanted(&self) -> Result<Vec<(Pair, u64)>, Error> {
        let most = (1_u64 << (SAMPLE_BITS - 1)) as f64;
        (self.coarsest..)
            .zip(self.allocation(self.coarsest))
            .map(|(level, n)| {
                if n > most {
                    let (quantity, value) = ("samples of a level", n);
                    return Err(Error::TooMany { quantity, value, limit: most });
                }
                #[allow(
                    clippy::cast_possible_truncation,
                    clippy::cast_sign_loss,
                    reason = "a whole number from 2 to 2^39; NaN becomes 0"
                )]
                let n = n as u64;
                Ok((Self::term_pair(self.coarsest, level), n))
            })
            .collect()
    }

    /// Means of the differences of a target from level 1 on, with their standard errors.
    fn differences(&self, target: usize) -> Vec<[f64; 2]> {
        let of = |level| {
            let sums = self.of(level, target);
            let error = (sums.difference_variance() / sums.sums.count() as f64).sqrt();
            [sums.difference_value(), error]
        };
        (1..=self.top).map(of).collect()
    }

    pub(crate) fn is_bias_small(&self) -> bool {
        (0..self.targets.len()).all(|target| {
            let bias = extrapolated(self.bias, &self.differences(target));
            bias.bound <= self.parts_of_tolerance(target)[1]
        })
    }

    /// The largest standard error and the largest bias: with half of the squared tolerance for each, or all of it for the first.
    fn parts_of_tolerance(&self, target: usize) -> [f64; 2] {
        let share = self.bias.share_of_variance();
        let tolerance = self.tolerances[target];
        [share, 1.0 - share].map(|share| if share > 0.0 { tolerance * share.sqrt() } else { 0.0 })
    }

    /// Means of a level in its two roles: Giles 2015, the test of section 3.
    fn require_nested(&self) -> Result<(), Error> {
        for (target, level) in
            (0..self.targets.len()).flat_map(|target| (0..self.top).map(move |l| (target, l)))
        {
            let (below, above) = (self.of(level, target), self.of(level + 1, target));
            for component in 0..COMPONENTS {
                let as_coarse = above.fine_means()[component] - above.difference_means()[component];
                let difference = below.fine_means()[component] - as_coarse;
                let error = |variance: f64, sums: &TargetSums<'_>| {
                    (variance / sums.sums.count() as f64).sqrt()
                };
                let [fine, _] = below.component_variances(component);
                let [_, coarse] = above.component_variances(component);
                let limit = 3.0 * (error(fine, &below) + error(coarse, &above));
                // One sample of a rare event on one side alone has no variance on the other.
                let event = 3.0 / below.sums.count().min(above.sums.count()) as f64;
                let is_probability = !matches!(
                    self.targets[target].statistic,
                    Statistic::Mean | Statistic::Variance
                );
                let limit = if is_probability { limit + event } else { limit };
                let roundoff = 1e-12 * below.fine_means()[component].abs();
                if difference.abs() > limit + roundoff {
                    return Err(Error::NotNested { target, level, difference, limit });
                }
            }
        }
        Ok(())
    }

    pub(crate) fn result(&self, cost: f64) -> MultilevelResult {
        let n_targets = self.targets.len();
        let single = |target: usize| {
            let variance = self.of(self.top, target).fine_variance();
            let [limit, _] = self.parts_of_tolerance(target);
            if variance == 0.0 { 0.0 } else { variance / limit.powi(2) * self.costs[self.top] }
        };
        MultilevelResult {
            targets: (0..n_targets).map(|target| self.target_result(target)).collect(),
            levels: (0..=self.top).map(|level| self.level_report(level)).collect(),
            coarsest: self.coarsest,
            cost,
            single_level_cost: (0..n_targets).map(single).fold(0.0, f64::max),
        }
    }

    fn target_result(&self, target: usize) -> TargetResult {
        let asked = &self.targets[target];
        let mut squared_error = 0.0;
        for level in self.coarsest..=self.top {
            let term = self.term(level, target);
            // The floor of the allocation holds for the error too: a pilot may differ by chance too little.
            let floor = self.term_variance(self.coarsest, level, target);
            squared_error += term.difference_variance().max(floor) / term.sums.count() as f64;
        }
        let standard_error = squared_error.sqrt();
        let mut estimate = with_error(self.value(target), standard_error);
        if asked.statistic == Statistic::Variance {
            let n = self.term(self.coarsest, target).sums.count();
            let error = error_of_variance(estimate.value, standard_error, n);
            estimate.uncertainty = Uncertainty::StandardError(error);
        }
        if squared_error == 0.0 {
            // Samples of a rare event that none has met are all equal, too.
            estimate.uncertainty = Uncertainty::Unknown;
        }
        let bias = extrapolated(self.bias, &self.differences(target));
        let [most_error, most_bias] = self.parts_of_tolerance(target);
        TargetResult {
            estimate,
            bias: bias.estimate,
            bias_bound: bias.bound,
            smoothing: asked.smoothing(self.means(target)),
            order: bias.order,
            is_reached: standard_error <= most_error && bias.bound <= most_bias,
        }
    }

    fn level_report(&self, level: usize) -> LevelReport {
        let is_used = level >= self.coarsest;
        let pair =
            if is_used { Self::term_pair(self.coarsest, level) } else { Pair::neighbours(level) };
        let n_targets = self.targets.len();
        let sums = |target| if is_used { self.term(level, target) } else { self.of(level, target) };
        let difference = |target: usize| -> Estimate {
            let sums = sums(target);
            let variance = sums.difference_variance() / sums.sums.count() as f64;
            let uncertainty = Uncertainty::StandardError(variance.sqrt());
            Estimate { value: sums.difference_value(), uncertainty }
        };
        LevelReport {
            pair,
            n_samples: sums(0).sums.count(),
            cost: pair.cost(|level| self.costs[level]),
            is_used,
            differences: (0..n_targets).map(difference).collect(),
            difference_variances: (0..n_targets)
                .map(|target| self.of(level, target).difference_variance())
                .collect(),
            variances: (0..n_targets)
                .map(|target| self.of(level, target).fine_variance())
                .collect(),
        }
    }
}
