//! First passage up to some times, from paths guided to some thresholds at many times.

use sde_integrators::{Error, Estimate, Guide, Passages, Response, Side};

use crate::backward::Backward;
use crate::event::Event;
use crate::guided::{GuidedConfig, GuidedPaths, STRENGTHS};
use crate::normal_tail::upper_tail;
use crate::regression::Regressions;
use crate::tail::TailError;
use crate::weights::{Contributions, GuidedEstimate};

/// Largest number of times at which guides of a response to a threshold end.
const MOST_ENDS: usize = 64;
/// Smallest probability of a guide's event over the largest: rarer ones have no guide.
const LEAST: f64 = 1e-3;
/// Share of the guided paths that all guides receive alike.
const EVEN: f64 = 0.03;
/// Largest number of coefficients of all guides: two gigabytes.
const MOST_COEFFICIENTS: f64 = 268_435_456.0;

/// First passages that one set of paths estimates: of the largest of some responses, through some thresholds, up to some times.
#[derive(Debug, Clone, Copy)]
pub struct PassageQuestion<'q> {
    /// The responses; a passage is that of the first of them.
    pub responses: &'q [Response<'q>],
    /// The thresholds, increasing (unit of the responses).
    pub thresholds: &'q [f64],
    /// The times, as numbers of steps, increasing.
    pub n_steps: &'q [usize],
}

/// Per time, per threshold: the estimate, or why its weights cannot be trusted.
pub type PassageEstimates = Vec<Vec<Result<GuidedEstimate, TailError>>>;

impl GuidedPaths<'_> {
    /// The probability that a response passes a threshold up to the end of the paths.
    ///
    /// One threshold and one time of [`first_passages`](Self::first_passages).
    ///
    /// # Errors
    /// Those of [`exceedance`](Self::exceedance) and of [`maxima`](sde_integrators::maxima) for the response.
    pub fn first_passage(
        &self,
        response: &Response<'_>,
        threshold: f64,
        config: &GuidedConfig,
    ) -> Result<GuidedEstimate, TailError> {
        let (responses, thresholds, n_steps) =
            (&[*response][..], &[threshold], &[self.steps.n_steps]);
        let question = PassageQuestion { responses, thresholds, n_steps };
        let mut all = self.first_passages(&question, config)?.into_iter().flatten();
        all.next()
            .unwrap_or_else(|| Err(Error::TooFew { quantity: "times", value: 0, limit: 1 }.into()))
    }

    /// The probabilities that the largest response passes each threshold up to each time, from one set of paths.
    ///
    /// The passage is that of the largest response, `max y(t) > T`. A path is guided to exceed one of the thresholds at one
    /// of many times; where it passes that threshold before, its guide ends. With all guides `e` and their shares `c_e`,
    ///
    /// $$ \hat p(t, T) = \frac1n \sum_k \frac{1[\tau_k(T) \le t]}{c_0 + \sum_e c_e r_e(\tau_k(T))}, \qquad
    ///    c_e \propto \Phi\left(\frac{E y(t_e) - T_e}{\sigma_e}\right), $$
    ///
    /// `r_e` being the likelihood ratio of guide `e` at the passage `tau(T)`: the balance heuristic over all guides, at the
    /// time at which the event is decided. Each threshold has an equal share of the paths, and so has each interval between
    /// the times. Two ends are half a mean excursion apart, which takes `sqrt(2 pi) sigma_y^2/(sigma_y' T)` in the linearised
    /// system; there are at most 64 for a threshold. Ends with a probability below a thousandth of the largest of their
    /// interval have no guide. For a magnitude both signs have guides. Pilot paths choose a strength for each threshold.
    ///
    /// The estimates are unbiased for the discrete paths with the given rule between steps, whose bias remains:
    /// with [`Between::Endpoints`](sde_integrators::Between::Endpoints) passages between steps are missed. They are from the
    /// same paths and so depend on each other.
    ///
    /// Sources: Au and Beck 2001, First excursion probabilities for linear systems by very efficient importance
    /// sampling (a mixture over the times of the passage); Veach and Guibas 1995, Optimally combining sampling techniques for
    /// Monte Carlo rendering (the balance heuristic); for controls towards a running maximum arXiv 2403.12793.
    ///
    /// # Errors
    /// [`TailError::Sampling`] for thresholds or times that do not increase, for a time after the end, for guides of more than
    /// two gigabytes, and as [`exceedance`](Self::exceedance); those of [`maxima`](sde_integrators::maxima) for a response.
    pub fn first_passages(
        &self,
        question: &PassageQuestion<'_>,
        config: &GuidedConfig,
    ) -> Result<PassageEstimates, TailError> {
        let PassageQuestion { responses, thresholds, n_steps } = *question;
        for &threshold in thresholds {
            config.check(threshold)?;
        }
        self.check(question)?;
        let towards = self.towards(question)?;
        let passages = Some(Passages { responses, levels: thresholds });
        let last = n_steps.last().copied().unwrap_or_default() as u64;
        let pilots: Vec<_> =
            (0..thresholds.len()).map(|level| Event::Passage { level, n_steps: last }).collect();
        let candidates = |level: usize, strength: usize, share: f64| {
            self.to_passages(question, &towards, level, strength, share)
        };
        let best = self.strongest(&candidates, &pilots, passages, config)?;
        let share = (1.0 - config.unguided) / thresholds.len() as f64;
        let guides: Vec<Guide> = best
            .iter()
            .enumerate()
            .flat_map(|(level, &strength)| candidates(level, strength, share))
            .collect();
        let sums = self.sums(&guides, &question.events(), passages, config)?;
        let of_time = sums.chunks(thresholds.len()).map(|row| {
            let estimates = row.iter().zip(thresholds).zip(&best);
            estimates
                .map(|((sum, &threshold), &strength)| sum.estimate(threshold, STRENGTHS[strength]))
                .collect()
        });
        Ok(of_time.collect())
    }

    /// The same probabilities by free paths, per time and threshold: crude Monte Carlo.
    ///
    /// # Errors
    /// [`TailError::Sampling`], as for [`first_passages`](Self::first_passages).
    pub fn free_passages(
        &self,
        question: &PassageQuestion<'_>,
        (n_paths, seed): (u64, u64),
    ) -> Result<Vec<Vec<Estimate>>, TailError> {
        let PassageQuestion { responses, thresholds, .. } = *question;
        let config = GuidedConfig { n_paths, n_pilots: 0, unguided: 0.0, seed };
        for &threshold in thresholds {
            config.check(threshold)?;
        }
        self.check(question)?;
        let passages = Some(Passages { responses, levels: thresholds });
        let sums = self.sums(&[], &question.events(), passages, &config)?;
        let row = |row: &[Contributions]| -> Result<Vec<Estimate>, TailError> {
            row.iter().map(|sum| Ok(Estimate::probability(sum.hits(), n_paths)?)).collect()
        };
        sums.chunks(thresholds.len()).map(row).collect()
    }

    /// Rejects components, times and thresholds that have no guides.
    fn check(&self, question: &PassageQuestion<'_>) -> Result<(), Error> {
        let PassageQuestion { responses, thresholds, n_steps } = *question;
        let lengths = [
            ("responses", responses.len()),
            ("thresholds", thresholds.len()),
            ("times", n_steps.len()),
        ];
        if let Some((quantity, _)) = lengths.into_iter().find(|(_, value)| *value == 0) {
            return Err(Error::TooFew { quantity, value: 0, limit: 1 });
        }
        let limit = self.n_states();
        for &Response { component, .. } in responses {
            if component >= limit {
                return Err(Error::NoSuchComponent { component, limit });
            }
        }
        let mut from = 0;
        for &steps in n_steps {
            if !(from < steps && steps <= self.steps.n_steps) {
                let quantity = "number of steps to a time";
                let (value, from, to) =
                    (steps as f64, from as f64 + 1.0, self.steps.n_steps as f64);
                return Err(Error::OutOfRange { quantity, value, from, to });
            }
            from = steps;
        }
        Ok(())
    }

    /// The regressions towards each response, after a check of the memory that all guides take.
    fn towards(&self, question: &PassageQuestion<'_>) -> Result<Vec<Towards>, Error> {
        let PassageQuestion { responses, thresholds, n_steps } = *question;
        let towards = |response: &Response<'_>| {
            let mut weights = vec![0.0; self.n_states()];
            weights[response.component] = 1.0;
            let regressions = self.regressions(&weights);
            let ends =
                |threshold: &f64| self.ends(&regressions, response.component, *threshold, n_steps);
            let ends = thresholds.iter().map(ends).collect();
            Towards { weights, regressions, ends }
        };
        let all: Vec<Towards> = responses.iter().map(towards).collect();
        let mut held = 0.0;
        for (response, Towards { ends, .. }) in responses.iter().zip(&all) {
            let sides = if response.side == Side::Above { 1.0 } else { 2.0 };
            let of_end = |end: &usize| {
                let blocks = end.div_ceil(self.steps.hold) as f64;
                blocks * (self.n_states() as f64 + 1.0) + 2.0 * *end as f64
            };
            held += sides * ends.iter().flatten().flatten().map(of_end).sum::<f64>();
        }
        let value = held * STRENGTHS.len() as f64;
        if value > MOST_COEFFICIENTS {
            let quantity =
                "coefficients of guides (hold them longer, take larger steps or fewer thresholds)";
            return Err(Error::TooMany { quantity, value, limit: MOST_COEFFICIENTS });
        }
        Ok(all)
    }

    /// Guides to a threshold by all responses, at all ends and on all sides, with their shares.
    fn to_passages(
        &self,
        PassageQuestion { responses, thresholds, n_steps }: &PassageQuestion<'_>,
        towards: &[Towards],
        level: usize,
        strength: usize,
        share: f64,
    ) -> Vec<Guide> {
        let threshold = thresholds[level];
        let mut groups: Vec<Vec<(Backward, f64, f64)>> = vec![Vec::new(); n_steps.len()];
        for (response, Towards { weights, regressions, ends }) in responses.iter().zip(towards) {
            let sides: &[f64] = if response.side == Side::Above { &[1.0] } else { &[1.0, -1.0] };
            for (group, ends) in groups.iter_mut().zip(&ends[level]) {
                for &n_steps in ends {
                    let backward = self.backward(regressions, strength, weights, n_steps);
                    for &side in sides {
                        let excess = backward.reliability(&self.start, side, threshold);
                        group.push((backward.clone(), side, upper_tail(-excess)));
                    }
                }
            }
        }
        let share = share / groups.len() as f64;
        let mut guides = Vec::new();
        for mut group in groups {
            let largest = group.iter().fold(0.0_f64, |largest, (.., p)| largest.max(*p));
            group.retain(|(.., p)| *p >= LEAST * largest);
            let (sum, even) =
                (group.iter().map(|(.., p)| p).sum::<f64>(), 1.0 / group.len() as f64);
            for (backward, side, p) in &group {
                let likely = if sum > 0.0 { p / sum } else { even };
                let part = EVEN * even + (1.0 - EVEN) * likely;
                guides.push(backward.guide(&self.start, (*side, threshold, level), share * part));
            }
        }
        guides
    }

    /// The steps after which guides end: those of each interval between the times, from its last one backwards.
    fn ends(
        &self,
        regressions: &Regressions,
        component: usize,
        threshold: f64,
        n_steps: &[usize],
    ) -> Vec<Vec<usize>> {
        let dt = self.steps.dt;
        let shortest = self.steps.n_steps.div_ceil(MOST_ENDS);
        let mut from = 0;
        let mut all = Vec::new();
        for &until in n_steps {
            let (mut ends, mut end) = (Vec::new(), until);
            while end > from {
                ends.push(end);
                let t = end as f64 * dt;
                let law = regressions.law_at(t);
                // The rate of the response in the linearised system, under the running distribution.
                let of_rate = regressions.rate_variance(component, t);
                let variance = law.covariance(component, component);
                let distance = (threshold.abs() - law.mean[component].abs()).max(variance.sqrt());
                let excursion =
                    std::f64::consts::TAU.sqrt() * variance / (of_rate.sqrt() * distance);
                #[expect(
                    clippy::cast_possible_truncation,
                    clippy::cast_sign_loss,
                    reason = "a number of steps, and a cast saturates"
                )]
                let spacing = (0.5 * excursion / dt).round() as usize;
                end = end.saturating_sub(spacing.max(shortest));
            }
            from = until;
            all.push(ends);
        }
        all
    }
}

/// The linearised system towards one response.
struct Towards {
    /// 1 for the response, 0 for the other states.
    weights: Vec<f64>,
    regressions: Regressions,
    /// Per threshold and interval between the times: the steps after which guides end.
    ends: Vec<Vec<Vec<usize>>>,
}

impl PassageQuestion<'_> {
    /// The passages of all times and thresholds, time by time.
    fn events(&self) -> Vec<Event<'static>> {
        let of_time = |&n_steps: &usize| {
            (0..self.thresholds.len())
                .map(move |level| Event::Passage { level, n_steps: n_steps as u64 })
        };
        self.n_steps.iter().flat_map(of_time).collect()
    }
}
