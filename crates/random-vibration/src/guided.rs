//! Exceedance probabilities from paths under a feedback control of their noise.

use std::ops::Range;

use sde_integrators::{
    Additive, Error, GaussianMixture, Guide, GuidedEnsemble, GuidedPath, Integrator, LanePaths,
    PairwiseSde, Passages, Sde, SmallPaths, WongZakai,
};

use crate::backward::{Backward, Loads, Start, Stepping};
use crate::cholesky::cholesky;
use crate::event::Event;
use crate::linearisation::Linearisation;
use crate::normal_tail::upper_tail;
use crate::pairwise_regression::PairwiseLaws;
use crate::regression::{Regressions, RunningLaw};
use crate::small_regression;
use crate::tail::{TailError, Tails};
use crate::weights::{Contributions, GuidedEstimate};

/// Strengths among which the pilot paths choose: factors on the running deviations in the linearisation.
pub(crate) const STRENGTHS: [f64; 5] = [1.0, 1.5, 2.0, 2.5, 3.0];
/// The first realisation of the pilot paths: no ensemble reaches it.
const FIRST_PILOT: u64 = 1 << 63;
/// Largest number of steps: the guides of all strengths then take two gigabytes with four states.
const MOST_STEPS: usize = 1 << 22;
/// Smallest share of the paths for one of two tails.
const SMALLEST_SIDE: f64 = 0.05;

/// Parameters of guided paths.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct GuidedConfig {
    /// Number of paths, at least 2 and at most 2^62.
    pub n_paths: u64,
    /// Number of pilot paths that choose the strength, for each threshold; none of them enters the estimate.
    pub n_pilots: u64,
    /// Share of the paths without a guide, in `[0, 1)`: bounds every weight by its inverse.
    pub unguided: f64,
    /// Seed of all random numbers; pilot paths are realisations of their own.
    pub seed: u64,
}

/// How a system of many states is linearised and guided.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PairwiseRule {
    /// Longest step of the linearisation (time): a tenth of the shortest period suffices for a guide.
    pub step: f64,
    /// Number of steps of a path for which its guide is held, at least 1.
    pub hold: usize,
    /// Standard deviation of a response that its linearised system leaves out, over that of the response (no unit).
    ///
    /// 0 for a linear system; 0.25 for a building whose storeys yield. It keeps guides from insisting on a response that the
    /// linearised system predicts badly: weights are then more even, and fewer paths reach the event.
    pub unmodelled: f64,
}

/// Adds a path to sums.
type Collect<'c> = &'c (dyn Fn(&GuidedPath<'_>, &mut [Contributions]) + Sync + 'c);

/// One run of guided paths.
pub(crate) struct Ensemble<'r> {
    pub(crate) guides: &'r [Guide],
    pub(crate) passages: Option<Passages<'r>>,
    pub(crate) seed: u64,
    pub(crate) realisations: Range<u64>,
    pub(crate) n_sums: usize,
}

/// Makes the regressions towards an event of some states.
type Regressing<'a> = dyn Fn(&[usize]) -> Regressions + Sync + 'a;

/// Runs guided paths and collects sums over them.
type Runner<'a> =
    dyn Fn(&Ensemble<'_>, Collect<'_>) -> Result<Vec<Contributions>, Error> + Sync + 'a;

/// `P(y > T)` or `P(|y| > T)` of a demand `y = w . X(t)` at one time, from paths guided to the event.
///
/// The backward function of the linearised system, `Phi((a(t) . x + c(t) - T)/s(t))`, gives the drift of the driving
/// noise that leads paths to the event:
///
/// $$ \theta(t, x) = g^T \nabla \log \Phi\left(\frac{a(t) \cdot x + c(t) - T}{s(t)}\right)
///    = \frac{g^T a}{s} \frac{\varphi}{\Phi}\left(\frac{a \cdot x + c - T}{s}\right), \qquad
///    \hat p = \frac1n \sum_k 1_{y_k > T} w_k . $$
///
/// Letters: `a` = adjoint of the linearised system with `a(t_end) = w`, `c` = effect of its constant drift, `s^2` = variance
/// of `y` from the noise ahead, `g` = noise of the system. `w_k` is the weight of a path: the density of its normals
/// without a guide over that of the mixture it is drawn from.
///
/// The estimate is unbiased for the discrete paths, whatever the linearisation, which determines the variance alone. For a
/// linear system the weights are equal in the limit of small steps. The step has the bias of its integrator.
///
/// The linearisation takes its expectations under `kappa` times the running deviations. Pilot paths under all
/// strengths `kappa` in equal shares estimate the second moment of the weights of each, `E_q[1 w / r_kappa]`, and the
/// smallest is taken. A share of the paths has no guide.
///
/// Sources: Tanaka 1998, Application of an importance sampling method to time-dependent system reliability analyses
/// using the Girsanov transformation; Macke and Bucher 2003, Importance sampling for randomly excited dynamical systems;
/// the backward function as a control: Fleming and Soner 2006, section VI.
pub struct GuidedPaths<'a> {
    runner: Box<Runner<'a>>,
    loads: Loads<'a>,
    /// The regressions towards an event of some states.
    regressions: Box<Regressing<'a>>,
    pub(crate) start: Start,
    pub(crate) steps: Stepping,
    weights: Vec<f64>,
}

/// A system behind a reference, which may be a trait object itself.
struct Behind<'a, S: ?Sized>(&'a S);

impl<S: Sde<D, M> + ?Sized, const D: usize, const M: usize> Sde<D, M> for Behind<'_, S> {
    type Noise = S::Noise;
    fn drift(&self, t: f64, x: &[f64; D]) -> [f64; D] {
        self.0.drift(t, x)
    }
    fn noise(&self, t: f64, x: &[f64; D]) -> [[f64; M]; D] {
        self.0.noise(t, x)
    }
    fn diffusion(&self, t: f64, x: &[f64; D]) -> [[f64; D]; D] {
        self.0.diffusion(t, x)
    }
}

impl<'a> GuidedPaths<'a> {
    /// Paths from a normal distribution to a time; the demand is the first state.
    ///
    /// The step of the linearisation need not resolve the path: a tenth of a period suffices for a guide.
    ///
    /// # Errors
    /// [`TailError::Mixture`], [`TailError::NotACovariance`], [`TailError::Linearisation`]; [`TailError::Sampling`] for a
    /// time that is not positive, no step, or more than 2^22.
    pub fn new<S, I, const D: usize, const M: usize>(
        system: &'a S,
        integrator: &'a I,
        law: &GaussianMixture<D>,
        span: (f64, usize),
        linearisation: &Linearisation<D>,
    ) -> Result<Self, TailError>
    where
        S: Sde<D, M, Noise = Additive> + ?Sized,
        I: Integrator<S, D, M>,
    {
        let value = law.components().len();
        if value != 1 {
            return Err(TailError::Mixture { value });
        }
        let guiding = PairwiseRule { step: linearisation.step, hold: 1, unmodelled: 0.0 };
        check_span(span, &guiding)?;
        let factor = cholesky(&law.covariance())
            .map_err(|(state, value)| TailError::NotACovariance { state, value })?;
        let behind = Behind(system);
        let regressions =
            small_regression::regressions(linearisation, &behind, law, span.0, &STRENGTHS)?;
        // Additive noise: the same at every state.
        let anywhere = law.mean();
        let noise = move |t: f64, g: &mut [f64]| {
            g.copy_from_slice(behind.noise(t, &anywhere).as_flattened());
        };
        let loads = Loads { n_motions: M, noise: Box::new(noise) };
        let start = Start { mean: anywhere.to_vec(), factor: factor.as_flattened().to_vec() };
        let paths = SmallPaths::<_, _, D> { system, integrator };
        let regressions = Box::new(move |_: &[usize]| regressions.clone());
        Ok(Self::of::<_, M>(paths, loads, regressions, start, (span, &guiding)))
    }

    /// Paths of a system of any number of states from rest, all states zero, to a time; the demand is the first state.
    ///
    /// Their steps are those of [`WongZakai`].
    ///
    /// # Errors
    /// [`TailError::Linearisation`]; [`TailError::Sampling`] for a time that is not positive, no step or more than 2^22, and
    /// for a guide held over no step or an unmodelled deviation that is negative or not finite.
    pub fn from_rest<S: PairwiseSde>(
        system: &'a S,
        span: (f64, usize),
        rule: &PairwiseRule,
    ) -> Result<Self, TailError> {
        check_span(span, rule)?;
        let n = system.n_states();
        let rest = RunningLaw { mean: vec![0.0; n], covariance: vec![0.0; n * n] };
        let laws = PairwiseLaws::new(system, &rest, (span.0, rule.step))?;
        let regressions = Box::new(move |states: &[usize]| laws.regressions(states, &STRENGTHS));
        let noise = |t: f64, g: &mut [f64]| system.noise(t, g);
        let loads = Loads { n_motions: 1, noise: Box::new(noise) };
        let start = Start { mean: rest.mean, factor: rest.covariance };
        Ok(Self::of::<_, 1>(WongZakai(system), loads, regressions, start, (span, rule)))
    }

    fn of<P: LanePaths<M> + 'a, const M: usize>(
        paths: P,
        loads: Loads<'a>,
        regressions: Box<Regressing<'a>>,
        start: Start,
        ((time, n_steps), rule): ((f64, usize), &PairwiseRule),
    ) -> Self {
        let dt = time / n_steps as f64;
        let Start { mean, factor } = start.clone();
        let runner = move |run: &Ensemble<'_>, collect: Collect<'_>| {
            let Ensemble { guides, passages, seed, ref realisations, n_sums } = *run;
            let (paths, mean, factor) = (&paths, &mean[..], &factor[..]);
            let ensemble =
                GuidedEnsemble::<_, M> { paths, mean, factor, dt, n_steps, guides, passages, seed };
            let merge = |mut earlier: Vec<Contributions>, later: Vec<Contributions>| {
                for (sum, more) in earlier.iter_mut().zip(&later) {
                    sum.merge(more);
                }
                earlier
            };
            let new = || vec![Contributions::default(); n_sums];
            let push = |sums: &mut Vec<Contributions>, path: &GuidedPath<'_>| collect(path, sums);
            ensemble.run(realisations.clone(), new, push, merge)
        };
        let mut weights = vec![0.0; start.mean.len()];
        if let Some(first) = weights.first_mut() {
            *first = 1.0;
        }
        let PairwiseRule { hold, unmodelled, .. } = *rule;
        let steps = Stepping { dt, n_steps, hold, unmodelled };
        Self { runner: Box::new(runner), loads, regressions, start, steps, weights }
    }

    /// Number of states.
    #[must_use]
    pub fn n_states(&self) -> usize {
        self.start.mean.len()
    }

    /// The same paths with another demand, a weighted sum of the states.
    ///
    /// # Errors
    /// [`TailError::Sampling`] for a number of weights that is not that of the states.
    pub fn with_demand(self, weights: &[f64]) -> Result<Self, TailError> {
        let (value, expected) = (weights.len(), self.n_states());
        if value != expected {
            return Err(Error::WrongLength { quantity: "weights", value, expected }.into());
        }
        Ok(Self { weights: weights.to_vec(), ..self })
    }

    /// The probability that the demand exceeds a threshold at the end of the paths.
    ///
    /// # Errors
    /// [`TailError::Untrusted`] where the weights are too uneven; [`TailError::Sampling`] for fewer than two paths, a share
    /// outside `[0, 1)`, a threshold that is not finite, or a failed path.
    pub fn exceedance(
        &self,
        threshold: f64,
        tails: Tails,
        config: &GuidedConfig,
    ) -> Result<GuidedEstimate, TailError> {
        config.check(threshold)?;
        let regressions = self.regressions(&self.weights);
        let n_steps = self.steps.n_steps;
        let backward: Vec<_> = (0..STRENGTHS.len())
            .map(|strength| self.backward(&regressions, strength, &self.weights, n_steps))
            .collect();
        let guides = |strength: usize, share: f64| -> Vec<Guide> {
            let backward = &backward[strength];
            let shares = self.shares(backward, threshold, tails);
            let sides = shares.into_iter().filter(|(_, part)| *part > 0.0);
            sides
                .map(|(side, part)| backward.guide(&self.start, (side, threshold, 0), share * part))
                .collect()
        };
        let event = Event::AtEnd { weights: &self.weights, threshold, tails };
        let candidates = |_: usize, strength: usize, share: f64| guides(strength, share);
        let best = self.strongest(&candidates, &[event], None, config)?;
        let strength = best.first().copied().unwrap_or_default();
        let guides = guides(strength, 1.0 - config.unguided);
        let sums = self.sums(&guides, &[event], None, config)?;
        let sum = sums.first().copied().unwrap_or_default();
        sum.estimate(threshold, STRENGTHS[strength])
    }

    /// The backward function of a weighted sum of the states after some of the steps.
    pub(crate) fn backward(
        &self,
        regressions: &Regressions,
        strength: usize,
        weights: &[f64],
        n_steps: usize,
    ) -> Backward {
        let steps = Stepping { n_steps, ..self.steps };
        Backward::new(&self.loads, regressions, strength, weights, steps)
    }

    /// The regressions towards an event of a weighted sum of the states.
    pub(crate) fn regressions(&self, weights: &[f64]) -> Regressions {
        let states: Vec<usize> = (0..weights.len()).filter(|&i| weights[i].abs() > 0.0).collect();
        (self.regressions)(&states)
    }

    /// The sides of the event with their shares of the guided paths, by the probability of the linearised system.
    fn shares(&self, backward: &Backward, threshold: f64, tails: Tails) -> [(f64, f64); 2] {
        if tails != Tails::Both {
            return [(1.0, 1.0), (-1.0, 0.0)];
        }
        let [upper, lower] =
            [1.0, -1.0].map(|side| upper_tail(-backward.reliability(&self.start, side, threshold)));
        let sum = upper + lower;
        let part = if sum > 0.0 { upper / sum } else { 0.5 };
        let part = part.clamp(SMALLEST_SIDE, 1.0 - SMALLEST_SIDE);
        [(1.0, part), (-1.0, 1.0 - part)]
    }

    /// For each event the strength whose weights have the smallest second moment over the pilot paths.
    ///
    /// `candidates` makes the guides to an event of a strength with a share.
    pub(crate) fn strongest(
        &self,
        candidates: &dyn Fn(usize, usize, f64) -> Vec<Guide>,
        events: &[Event<'_>],
        passages: Option<Passages<'_>>,
        config: &GuidedConfig,
    ) -> Result<Vec<usize>, TailError> {
        let n_strengths = STRENGTHS.len();
        if config.n_pilots == 0 {
            return Ok(vec![n_strengths / 2; events.len()]);
        }
        let n_groups = events.len() * n_strengths;
        let (unguided, of_group) = (config.unguided, n_groups as f64);
        let part = (1.0 - unguided) / of_group;
        let groups: Vec<Vec<Guide>> = (0..n_groups)
            .map(|group| candidates(group / n_strengths, group % n_strengths, part))
            .collect();
        let all: Vec<_> = groups.iter().flatten().cloned().collect();
        let collect = |path: &GuidedPath<'_>, sums: &mut [Contributions]| {
            let mut first = 0;
            for (group, (sum, guides)) in sums.iter_mut().zip(&groups).enumerate() {
                let place = first..first + guides.len();
                first = place.end;
                let Some(known) = events[group / n_strengths].known(path) else {
                    sum.push(None);
                    continue;
                };
                // The density of the mixture with this event and strength alone, over that of the pilots.
                let mut density = unguided;
                for (guide, ratio) in guides.iter().zip(&known.log_ratios[place]) {
                    density += of_group * guide.share * ratio.exp();
                }
                sum.push(Some(known.log_weight.exp() / density));
            }
        };
        let realisations = FIRST_PILOT..FIRST_PILOT + config.n_pilots;
        let (seed, n_sums) = (config.seed, n_groups);
        let run = Ensemble { guides: &all, passages, seed, realisations, n_sums };
        let sums = (self.runner)(&run, &collect)?;
        let best = |sums: &[Contributions]| {
            let smallest = |a: &usize, b: &usize| sums[*a].mean().total_cmp(&sums[*b].mean());
            (0..sums.len()).min_by(smallest).unwrap_or_default()
        };
        Ok(sums.chunks_exact(n_strengths).map(best).collect())
    }

    /// Contributions of the paths under the guides to the probability of each event.
    pub(crate) fn sums(
        &self,
        guides: &[Guide],
        events: &[Event<'_>],
        passages: Option<Passages<'_>>,
        config: &GuidedConfig,
    ) -> Result<Vec<Contributions>, TailError> {
        let collect = |path: &GuidedPath<'_>, sums: &mut [Contributions]| {
            for (sum, event) in sums.iter_mut().zip(events) {
                let known = event.known(path);
                sum.push(known.map(|known| event.sides() * known.log_weight.exp()));
            }
        };
        let (seed, realisations, n_sums) = (config.seed, 0..config.n_paths, events.len());
        let run = Ensemble { guides, passages, seed, realisations, n_sums };
        Ok((self.runner)(&run, &collect)?)
    }
}

/// Rejects a time and a number of steps that cannot be simulated.
fn check_span((time, n_steps): (f64, usize), rule: &PairwiseRule) -> Result<(), Error> {
    let PairwiseRule { hold, unmodelled, .. } = *rule;
    if !(unmodelled.is_finite() && unmodelled >= 0.0) {
        let (quantity, value) = ("unmodelled deviation of a response", unmodelled);
        return Err(Error::OutOfRange { quantity, value, from: 0.0, to: f64::INFINITY });
    }
    if !(time > 0.0 && time.is_finite()) {
        return Err(Error::NotPositive { quantity: "time", value: time });
    }
    for (quantity, value) in [("steps", n_steps), ("steps for which a guide is held", hold)] {
        if value == 0 {
            return Err(Error::TooFew { quantity, value: 0, limit: 1 });
        }
    }
    if n_steps > MOST_STEPS {
        let (value, limit) = (n_steps as f64, MOST_STEPS as f64);
        return Err(Error::TooMany { quantity: "steps of guided paths", value, limit });
    }
    Ok(())
}

impl GuidedConfig {
    pub(crate) fn check(&self, threshold: f64) -> Result<(), Error> {
        const MOST: u64 = 1 << 62;
        if !threshold.is_finite() {
            return Err(Error::NotFinite { quantity: "threshold", index: 0, value: threshold });
        }
        if !(self.unguided >= 0.0 && self.unguided < 1.0) {
            let (quantity, value) =
                ("share of unguided paths, which must be below 1,", self.unguided);
            return Err(Error::OutOfRange { quantity, value, from: 0.0, to: 1.0 });
        }
        for (quantity, value) in [("paths", self.n_paths), ("pilot paths", self.n_pilots)] {
            if value > MOST {
                let (value, limit) = (value as f64, MOST as f64);
                return Err(Error::TooMany { quantity, value, limit });
            }
        }
        Ok(())
    }
}

impl std::fmt::Debug for GuidedPaths<'_> {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let Self { steps, weights, .. } = self;
        f.debug_struct("GuidedPaths")
            .field("steps", steps)
            .field("weights", weights)
            .finish_non_exhaustive()
    }
}
