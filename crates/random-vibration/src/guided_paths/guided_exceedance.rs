//! Exceedance probabilities of some thresholds at some times, from paths guided to them.

use sde_integrators::{Error, Guide, normal_probability};

use crate::guided_paths::event::Event;
use crate::guided_paths::guided::{GuidedPaths, check_memory};
use crate::guided_paths::guided_config::{GuidedConfig, check_times};
use crate::guided_paths::guided_study::{GuidedEstimates, GuidedStudy, StudySet, StudySets};
use crate::guided_paths::pilots::{STRENGTHS, strongest};
use crate::guided_paths::weights::GuidedEstimate;
use crate::guides::backward::Backward;
use crate::tail::{TailError, Tails};

/// Smallest share of the paths to a threshold for one of two tails.
const SMALLEST_SIDE: f64 = 0.05;
/// Largest number of thresholds: each has a guide, whose ratio every path of its set evaluates.
const MOST_THRESHOLDS: usize = 256;
/// Probability of the linearised system, over the smallest of interest, below which a threshold has no guide.
const FAR_BELOW: f64 = 1e-3;

/// Exceedances that guided paths estimate: of some thresholds at some times.
#[derive(Debug, Clone, Copy)]
pub struct ExceedanceQuestion<'q> {
    /// The thresholds (unit of the demand).
    pub thresholds: &'q [f64],
    /// The times, as numbers of steps, increasing.
    pub n_steps: &'q [usize],
    /// The tails.
    pub tails: Tails,
    /// Smallest probability of interest; 0 for none (no unit).
    ///
    /// A threshold that the linearised system exceeds with less than a thousandth of it, under every strength, has no guide
    /// at that time. Its estimate is then refused, as a rule.
    pub smallest: f64,
}

impl GuidedPaths<'_> {
    /// The probability that the demand exceeds a threshold at the end of the paths.
    ///
    /// One threshold and one time of [`exceedances`](Self::exceedances).
    ///
    /// # Errors
    /// [`TailError::Untrusted`] where the weights are too uneven; those of [`exceedances`](Self::exceedances).
    pub fn exceedance(
        &self,
        threshold: f64,
        tails: Tails,
        config: &GuidedConfig,
    ) -> Result<GuidedEstimate, TailError> {
        let (thresholds, n_steps) = (&[threshold], &[self.runner.n_steps]);
        let question = ExceedanceQuestion { thresholds, n_steps, tails, smallest: 0.0 };
        let mut all = self.exceedances(&question, config)?.into_iter().flatten();
        all.next()
            .unwrap_or_else(|| Err(Error::TooFew { quantity: "times", value: 0, limit: 1 }.into()))
    }

    /// The probabilities that the demand exceeds each threshold at each time: the surface `P(t, T)`.
    ///
    /// Each time has a set of paths that ends there, guided to all thresholds in equal shares. A path to one threshold counts
    /// for all thresholds that it exceeds, with the weight of the whole mixture (the balance heuristic).
    /// Paths of different times share nothing: a path to a threshold at one time is seldom beyond it half a period earlier.
    ///
    /// Regressions and backward functions are computed once for all times and thresholds. Pilot paths to the last time choose
    /// a strength for each threshold; at the other times a threshold takes the strength of the one at the last time that is
    /// nearest in deviations of the linearised system.
    ///
    /// # Errors
    /// [`TailError::Sampling`] for fewer than two paths or a failed one, and for a share or a smallest probability outside
    /// `[0, 1)`; for a threshold that is not finite, and for none or more than 256; for times that do not increase or pass the
    /// end; for guides of more than four gigabytes.
    pub fn exceedances(
        &self,
        question: &ExceedanceQuestion<'_>,
        config: &GuidedConfig,
    ) -> Result<GuidedEstimates, TailError> {
        self.exceedance_study(question, config)?.run()
    }

    /// The study of [`exceedances`](Self::exceedances), whose blocks may run apart.
    ///
    /// # Errors
    /// Those of [`exceedances`](Self::exceedances).
    pub fn exceedance_study<'q>(
        &'q self,
        question: &ExceedanceQuestion<'_>,
        config: &GuidedConfig,
    ) -> Result<GuidedStudy<'q>, TailError> {
        let ExceedanceQuestion { thresholds, n_steps, tails, smallest } = *question;
        config.check(thresholds)?;
        self.check_exceedances(question)?;
        let regressions = self.regressions(&self.weights);
        let of_strength =
            |strength: usize| self.backward(&regressions, strength, &self.weights, n_steps);
        let of_strengths: Vec<_> = (0..STRENGTHS.len()).map(of_strength).collect();
        let towards = Towards { of_strengths, thresholds, tails, paths: self };
        let (last, end) = (n_steps.len() - 1, n_steps[n_steps.len() - 1]);
        let event =
            |threshold: &f64| Event::AtEnd { weights: &self.weights, threshold: *threshold, tails };
        let events: Vec<Event<'q>> = thresholds.iter().map(event).collect();
        let probed: Vec<usize> =
            (0..thresholds.len()).filter(|&k| towards.matters(last, k, smallest)).collect();
        let pilots: Vec<_> = probed.iter().map(|&k| events[k]).collect();
        let candidates = |pilot: usize, strength: usize, share: f64| {
            towards.guides((last, probed[pilot]), strength, share)
        };
        let best = strongest(&self.runner, &candidates, &pilots, (end, None), config)?;
        let chosen: Vec<(f64, usize)> = probed
            .iter()
            .zip(best)
            .map(|(&k, best)| (towards.reliability(last, k), best))
            .collect();
        let sets = n_steps.iter().enumerate();
        let set = |(time, &n_steps): (usize, &usize)| {
            let guides = towards.all_guides(time, &chosen, (smallest, 1.0 - config.unguided));
            StudySet { guides, passages: None, n_steps, events: events.clone() }
        };
        let all = sets.map(set).collect();
        let cells =
            (0..n_steps.len()).flat_map(|time| (0..thresholds.len()).map(move |k| (time, k)));
        let of_cell = |(time, k): (usize, usize)| {
            let strength = nearest(&chosen, towards.reliability(time, k));
            (thresholds[k], STRENGTHS[strength])
        };
        let GuidedConfig { n_paths, n_pilots, seed, .. } = *config;
        Ok(GuidedStudy {
            sets: StudySets { runner: &self.runner, all, n_paths, seed },
            thresholds: cells.map(of_cell).collect(),
            n_thresholds: thresholds.len(),
            pilot_steps: n_pilots.saturating_mul(end as u64),
        })
    }

    fn check_exceedances(&self, question: &ExceedanceQuestion<'_>) -> Result<(), Error> {
        let ExceedanceQuestion { thresholds, n_steps, tails, smallest } = *question;
        let (count, limit) = (thresholds.len(), MOST_THRESHOLDS as f64);
        if count == 0 {
            return Err(Error::TooFew { quantity: "thresholds", value: 0, limit: 1 });
        }
        if count > MOST_THRESHOLDS {
            return Err(Error::TooMany { quantity: "thresholds", value: count as f64, limit });
        }
        if !(0.0..1.0).contains(&smallest) {
            let quantity = "smallest probability, which must be below 1,";
            return Err(Error::OutOfRange { quantity, value: smallest, from: 0.0, to: 1.0 });
        }
        check_times(n_steps, self.runner.n_steps)?;
        let sides = if tails == Tails::Both { 2.0 } else { 1.0 };
        let of_guides = (count as f64 * sides + 1.0) * STRENGTHS.len() as f64;
        let last = n_steps.last().map_or(0.0, |&end| self.n_coefficients(end));
        let of_times: f64 = n_steps.iter().map(|&end| self.n_coefficients(end)).sum();
        check_memory(of_guides * last + (count as f64 * sides + STRENGTHS.len() as f64) * of_times)
    }
}

/// The backward functions of a demand at some times.
struct Towards<'t> {
    paths: &'t GuidedPaths<'t>,
    thresholds: &'t [f64],
    tails: Tails,
    /// Per strength and time.
    of_strengths: Vec<Vec<Backward>>,
}

impl Towards<'_> {
    /// Expected excess of the demand over a threshold, in deviations, under strength 1.
    fn reliability(&self, time: usize, threshold: usize) -> f64 {
        let start = &self.paths.runner.start;
        self.of_strengths[0][time].reliability(start, 1.0, self.thresholds[threshold])
    }

    /// Whether a threshold has a guide at a time.
    fn matters(&self, time: usize, threshold: usize, smallest: f64) -> bool {
        let (start, threshold) = (&self.paths.runner.start, self.thresholds[threshold]);
        let likely = |backward: &Vec<Backward>| {
            let above =
                |side: f64| normal_probability(backward[time].reliability(start, side, threshold));
            above(1.0).max(above(-1.0))
        };
        self.of_strengths.iter().map(likely).fold(0.0, f64::max) >= FAR_BELOW * smallest
    }

    /// Guides to all thresholds that matter at a time, in equal parts of a share.
    fn all_guides(
        &self,
        time: usize,
        chosen: &[(f64, usize)],
        (smallest, share): (f64, f64),
    ) -> Vec<Guide> {
        let all = 0..self.thresholds.len();
        let guided: Vec<usize> = all.filter(|&k| self.matters(time, k, smallest)).collect();
        let part = share / guided.len() as f64;
        let to_threshold = |k: usize| {
            let strength = nearest(chosen, self.reliability(time, k));
            self.guides((time, k), strength, part)
        };
        guided.into_iter().flat_map(to_threshold).collect()
    }

    /// Guides to a threshold at a time, on all sides.
    fn guides(&self, (time, k): (usize, usize), strength: usize, share: f64) -> Vec<Guide> {
        let (start, threshold) = (&self.paths.runner.start, self.thresholds[k]);
        let backward = &self.of_strengths[strength][time];
        let sides = self.shares(backward, threshold).into_iter().filter(|(_, part)| *part > 0.0);
        sides
            .map(|(side, part)| backward.guide(start, (side, threshold, 0), share * part))
            .collect()
    }

    /// The sides of the event with their shares of the guided paths, by the probability of the linearised system.
    fn shares(&self, backward: &Backward, threshold: f64) -> [(f64, f64); 2] {
        if self.tails != Tails::Both {
            return [(1.0, 1.0), (-1.0, 0.0)];
        }
        let start = &self.paths.runner.start;
        let [upper, lower] = [1.0, -1.0]
            .map(|side| normal_probability(backward.reliability(start, side, threshold)));
        let sum = upper + lower;
        let part = if sum > 0.0 { upper / sum } else { 0.5 };
        let part = part.clamp(SMALLEST_SIDE, 1.0 - SMALLEST_SIDE);
        [(1.0, part), (-1.0, 1.0 - part)]
    }
}

/// The strength of the choice whose reliability is nearest; the middle one if there is no choice.
fn nearest(chosen: &[(f64, usize)], reliability: f64) -> usize {
    let distance = |choice: &&(f64, usize)| (choice.0 - reliability).abs();
    let closest = chosen.iter().min_by(|a, b| distance(a).total_cmp(&distance(b)));
    closest.map_or(STRENGTHS.len() / 2, |(_, strength)| *strength)
}
