//! First passage up to some times, from paths guided to some thresholds at many times.

use sde_integrators::{Error, Guide, Passages, Response, Side};

use crate::guided_paths::event::Event;
use crate::guided_paths::guided::{GuidedPaths, check_memory};
use crate::guided_paths::guided_config::{GuidedConfig, check_times};
use crate::guided_paths::guided_study::{GuidedEstimates, GuidedStudy, StudySet, StudySets};
use crate::guided_paths::pilots::{STRENGTHS, strongest};
use crate::guided_paths::weights::GuidedEstimate;
use crate::guides::backward::Backward;
use crate::guides::regression::Regressions;
use crate::tail::TailError;

/// Distance of the ends of guides over the mean duration of an excursion.
///
/// Measured on linear oscillators: half the distance lowers the error by a tenth, 1.6 times the distance doubles it.
const SPACING: f64 = 1.0;
/// Smallest probability of a guide's event over the largest: rarer ones have no guide.
const LEAST: f64 = 1e-3;
/// Share of the guided paths that all guides receive alike.
const EVEN: f64 = 0.03;

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
            (&[*response][..], &[threshold], &[self.runner.n_steps]);
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
    /// the times. Two ends are `d`, a mean excursion, apart, which takes `sqrt(2 pi) sigma_y^2/(sigma_y' T)` in the
    /// linearised system. An excursion that just reaches `T` between two ends is below it at both, by
    /// `(d/2)^2 T sigma_y'^2/(2 sigma_y^2)` on average. Guides aim as much below `T`, so that every excursion has a guide:
    /// `1/r_e` stays bounded, and with it the weights.
    ///
    /// Ends with a probability below a thousandth of the largest of their interval have no guide. For a magnitude both signs
    /// have guides. Pilot paths choose a strength for each threshold.
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
    /// four gigabytes, and as [`exceedance`](Self::exceedance); those of [`maxima`](sde_integrators::maxima) for a response.
    pub fn first_passages(
        &self,
        question: &PassageQuestion<'_>,
        config: &GuidedConfig,
    ) -> Result<GuidedEstimates, TailError> {
        self.passage_study(question, config)?.run()
    }

    /// The study of [`first_passages`](Self::first_passages), whose blocks may run apart.
    ///
    /// # Errors
    /// Those of [`first_passages`](Self::first_passages).
    pub fn passage_study<'q>(
        &'q self,
        question: &PassageQuestion<'q>,
        config: &GuidedConfig,
    ) -> Result<GuidedStudy<'q>, TailError> {
        let PassageQuestion { responses, thresholds, n_steps } = *question;
        config.check(thresholds)?;
        question.check(self.n_states(), self.runner.n_steps)?;
        let towards = self.towards(question)?;
        let passages = Some(Passages { responses, levels: thresholds });
        let last = n_steps.last().copied().unwrap_or_default();
        let pilot = |level| Event::Passage { level, n_steps: last as u64 };
        let pilots: Vec<_> = (0..thresholds.len()).map(pilot).collect();
        let candidates = |level: usize, strength: usize, share: f64| {
            self.to_passages(question, &towards, level, strength, share)
        };
        let best = strongest(&self.runner, &candidates, &pilots, (last, passages), config)?;
        let share = (1.0 - config.unguided) / thresholds.len() as f64;
        let guides: Vec<Guide> = best
            .iter()
            .enumerate()
            .flat_map(|(level, &strength)| candidates(level, strength, share))
            .collect();
        let of_time = thresholds.iter().zip(&best).map(|(t, &strength)| (*t, STRENGTHS[strength]));
        let of_time: Vec<(f64, f64)> = of_time.collect();
        let GuidedConfig { n_paths, n_pilots, seed, .. } = *config;
        let set = StudySet { guides, passages, n_steps: last, events: question.events() };
        Ok(GuidedStudy {
            sets: StudySets { runner: &self.runner, all: vec![set], n_paths, seed },
            thresholds: of_time.repeat(n_steps.len()),
            n_thresholds: thresholds.len(),
            pilot_steps: n_pilots.saturating_mul(last as u64),
        })
    }

    /// The backward functions towards each response, after a check of the memory that they and all guides take.
    ///
    /// Those of ends that are too rare for a guide, beside the responses so far, are left out.
    fn towards(&self, question: &PassageQuestion<'_>) -> Result<Vec<Towards>, Error> {
        let PassageQuestion { responses, thresholds, n_steps } = *question;
        let mut held = 0.0;
        // The largest probability of an end, per strength, threshold and interval between the times.
        let none = vec![vec![0.0; n_steps.len()]; thresholds.len()];
        let mut largest = vec![none; STRENGTHS.len()];
        let mut all = Vec::new();
        for response in responses {
            let mut weights = vec![0.0; self.n_states()];
            weights[response.component] = 1.0;
            let regressions = self.regressions(&weights);
            let ends =
                |threshold: &f64| self.ends(&regressions, response.component, *threshold, n_steps);
            let ends: Vec<Vec<Vec<End>>> = thresholds.iter().map(ends).collect();
            let mut different: Vec<usize> =
                ends.iter().flatten().flatten().map(|end| end.step).collect();
            different.sort_unstable();
            different.dedup();
            let at_once: f64 = different.iter().map(|&end| self.n_coefficients(end)).sum();
            let mut towards = Towards { ends, different, backward: Vec::new() };
            for (strength, largest) in largest.iter_mut().enumerate() {
                check_memory(held + at_once)?;
                let found = self.backward(&regressions, strength, &weights, &towards.different);
                held += self.keep(&mut towards, (response.side, thresholds), found, largest);
            }
            all.push(towards);
        }
        check_memory(held)?;
        Ok(all)
    }

    /// Keeps the backward functions of a strength to ends that may have a guide; returns their number of coefficients with guides.
    fn keep(
        &self,
        towards: &mut Towards,
        (side, thresholds): (Side, &[f64]),
        found: Vec<Backward>,
        largest: &mut [Vec<f64>],
    ) -> f64 {
        let (start, sides) = (&self.runner.start, sides(side));
        let mut held = 0.0;
        let mut is_kept = vec![false; found.len()];
        let of_levels = towards.ends.iter().zip(thresholds).zip(largest);
        for ((intervals, threshold), largest) in of_levels {
            for (ends, largest) in intervals.iter().zip(largest) {
                let likely = |end: &End| {
                    let place = towards.different.binary_search(&end.step).ok()?;
                    let of = |side: &f64| found[place].likely(start, *side, threshold - end.below);
                    Some((place, sides.iter().map(of).fold(0.0, f64::max)))
                };
                let likely: Vec<(usize, f64)> = ends.iter().filter_map(likely).collect();
                *largest = likely.iter().fold(*largest, |largest, (_, p)| largest.max(*p));
                for (place, _) in likely.into_iter().filter(|(_, p)| *p >= LEAST * *largest) {
                    held += sides.len() as f64 * found[place].n_of_guide(start);
                    is_kept[place] = true;
                }
            }
        }
        let kept = is_kept.iter().zip(&towards.different).filter(|(is_kept, _)| **is_kept);
        held += kept.map(|(_, &end)| self.n_coefficients(end)).sum::<f64>();
        let found = found.into_iter().zip(is_kept);
        towards.backward.push(found.map(|(it, is_kept)| is_kept.then_some(it)).collect());
        held
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
        let start = &self.runner.start;
        let mut groups: Vec<Vec<(&Backward, f64, f64, f64)>> = vec![Vec::new(); n_steps.len()];
        for (response, towards) in responses.iter().zip(towards) {
            let sides = sides(response.side);
            for (group, ends) in groups.iter_mut().zip(&towards.ends[level]) {
                for end in ends {
                    let Some(backward) = towards.backward(strength, end.step) else { continue };
                    let target = threshold - end.below;
                    for &side in sides {
                        group.push((backward, side, target, backward.likely(start, side, target)));
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
            for (backward, side, target, p) in &group {
                let likely = if sum > 0.0 { p / sum } else { even };
                let part = EVEN * even + (1.0 - EVEN) * likely;
                guides.push(backward.guide(start, (*side, *target, level), share * part));
            }
        }
        guides
    }

    /// The ends of guides of each interval between the times, from its last one backwards.
    fn ends(
        &self,
        regressions: &Regressions,
        component: usize,
        threshold: f64,
        n_steps: &[usize],
    ) -> Vec<Vec<End>> {
        let dt = self.runner.dt;
        let (mut from, mut later_gap) = (0, 0);
        let mut all = Vec::new();
        for &until in n_steps {
            let (mut ends, mut step) = (Vec::new(), until);
            while step > from {
                let t = step as f64 * dt;
                let law = regressions.law_at(t);
                let variance = law.covariance(component, component);
                // That of the rate of the response, in the linearised system.
                let of_rate = regressions.rate_variance(component, t);
                let distance = (threshold.abs() - law.mean[component].abs()).max(variance.sqrt());
                let excursion =
                    std::f64::consts::TAU.sqrt() * variance / (of_rate.sqrt() * distance);
                #[expect(
                    clippy::cast_possible_truncation,
                    clippy::cast_sign_loss,
                    reason = "a number of steps, and a cast saturates"
                )]
                let spacing = ((SPACING * excursion / dt).round() as usize).max(1);
                // The first step has an end of its own, for paths that start near the threshold.
                let first = from.max(usize::from(step > 1));
                let earlier = step.saturating_sub(spacing).max(first);
                let gap = step - earlier;
                let half = 0.5 * gap.max(later_gap) as f64 * dt;
                let curvature = if variance > 0.0 { distance * of_rate / variance } else { 0.0 };
                // Where a step is longer than the distance of the ends, no excursion is between two of them.
                let most = 0.25 * std::f64::consts::PI * SPACING * SPACING * variance / distance;
                let below = (0.5 * curvature * half * half).min(most);
                ends.push(End { step, below });
                (step, later_gap) = (earlier, gap);
            }
            (from, later_gap) = (until, 0);
            all.push(ends);
        }
        all
    }
}

/// Where a guide ends.
#[derive(Debug, Clone, Copy)]
struct End {
    /// Number of steps.
    step: usize,
    /// How far below the threshold the guide aims (unit of the response).
    below: f64,
}

/// The linearised system towards one response.
struct Towards {
    /// Per threshold and interval between the times: the steps after which guides end.
    ends: Vec<Vec<Vec<End>>>,
    /// All of them, increasing.
    different: Vec<usize>,
    /// Per strength: the backward functions to [`different`](Self::different) that may have guides.
    backward: Vec<Vec<Option<Backward>>>,
}

/// The signs of a response whose excess over a threshold is a passage.
const fn sides(side: Side) -> &'static [f64] {
    match side {
        Side::Above => &[1.0],
        Side::Magnitude => &[1.0, -1.0],
    }
}

impl Towards {
    fn backward(&self, strength: usize, end: usize) -> Option<&Backward> {
        self.backward[strength].get(self.different.binary_search(&end).ok()?)?.as_ref()
    }
}

impl PassageQuestion<'_> {
    /// Rejects components, times and thresholds that have no guides.
    pub(crate) fn check(&self, n_states: usize, most_steps: usize) -> Result<(), Error> {
        let Self { responses, thresholds, n_steps } = *self;
        for (quantity, value) in [("responses", responses.len()), ("thresholds", thresholds.len())]
        {
            if value == 0 {
                return Err(Error::TooFew { quantity, value: 0, limit: 1 });
            }
        }
        let other = responses.iter().find(|response| response.component >= n_states);
        if let Some(&Response { component, .. }) = other {
            return Err(Error::NoSuchComponent { component, limit: n_states });
        }
        check_times(n_steps, most_steps)
    }

    /// The passages of all times and thresholds, time by time.
    pub(crate) fn events<'e>(&self) -> Vec<Event<'e>> {
        let of_time = |&n_steps: &usize| {
            (0..self.thresholds.len())
                .map(move |level| Event::Passage { level, n_steps: n_steps as u64 })
        };
        self.n_steps.iter().flat_map(of_time).collect()
    }
}
