//! Exceedance probabilities from paths under a feedback control of their noise.

use std::ops::Range;

use sde_integrators::{
    Additive, Error, GaussianMixture, Guide, GuidedEnsemble, GuidedPath, Integrator, Response, Sde,
};

use crate::backward::{Backward, Start, Steps};
use crate::cholesky::cholesky;
use crate::linearisation::Linearisation;
use crate::normal_tail::upper_tail;
use crate::regression::Regressions;
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

/// Adds a path to sums.
type Collect<'c, const D: usize> =
    &'c (dyn Fn(&GuidedPath<'_, D>, &mut [Contributions]) + Sync + 'c);

/// One run of guided paths.
pub(crate) struct Ensemble<'r, const D: usize, const M: usize> {
    pub(crate) guides: &'r [Guide<D, M>],
    pub(crate) passage: Option<(&'r Response<'r, D>, f64)>,
    pub(crate) seed: u64,
    pub(crate) realisations: Range<u64>,
    pub(crate) n_sums: usize,
}

/// Runs guided paths and collects sums over them.
type Runner<'a, const D: usize, const M: usize> =
    dyn Fn(&Ensemble<'_, D, M>, Collect<'_, D>) -> Result<Vec<Contributions>, Error> + Sync + 'a;

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
pub struct GuidedPaths<'a, const D: usize, const M: usize> {
    pub(crate) system: Box<dyn Sde<D, M, Noise = Additive> + 'a>,
    runner: Box<Runner<'a, D, M>>,
    pub(crate) regressions: Regressions<D>,
    pub(crate) start: Start<D>,
    pub(crate) steps: Steps,
    pub(crate) weights: [f64; D],
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

impl<'a, const D: usize, const M: usize> GuidedPaths<'a, D, M> {
    /// Paths from a normal distribution to a time; the demand is the first state.
    ///
    /// The step of the linearisation need not resolve the path: a tenth of a period suffices for a guide.
    ///
    /// # Errors
    /// [`TailError::Mixture`], [`TailError::NotACovariance`], [`TailError::Linearisation`]; [`TailError::Sampling`] for a
    /// time that is not positive, no step, or more than 2^22.
    pub fn new<S, I>(
        system: &'a S,
        integrator: &'a I,
        law: &GaussianMixture<D>,
        (time, n_steps): (f64, usize),
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
        if !(time > 0.0 && time.is_finite()) {
            return Err(Error::NotPositive { quantity: "time", value: time }.into());
        }
        if n_steps == 0 {
            return Err(Error::TooFew { quantity: "steps", value: 0, limit: 1 }.into());
        }
        if n_steps > MOST_STEPS {
            let (value, limit) = (n_steps as f64, MOST_STEPS as f64);
            return Err(Error::TooMany { quantity: "steps of guided paths", value, limit }.into());
        }
        let mean = law.mean();
        let factor = cholesky(&law.covariance())
            .map_err(|(state, value)| TailError::NotACovariance { state, value })?;
        let behind = Box::new(Behind(system));
        let regressions = Regressions::new(linearisation, &*behind, law, time, &STRENGTHS)?;
        let dt = time / n_steps as f64;
        let runner = Box::new(move |run: &Ensemble<'_, D, M>, collect: Collect<'_, D>| {
            let Ensemble { guides, passage, seed, ref realisations, n_sums } = *run;
            let ensemble = GuidedEnsemble {
                system,
                integrator,
                mean,
                factor,
                dt,
                n_steps,
                guides,
                passage,
                seed,
            };
            let merge = |mut earlier: Vec<Contributions>, later: Vec<Contributions>| {
                for (sum, more) in earlier.iter_mut().zip(&later) {
                    sum.merge(more);
                }
                earlier
            };
            let new = || vec![Contributions::default(); n_sums];
            let push =
                |sums: &mut Vec<Contributions>, path: &GuidedPath<'_, D>| collect(path, sums);
            ensemble.run(realisations.clone(), new, push, merge)
        });
        let weights = std::array::from_fn(|i| if i == 0 { 1.0 } else { 0.0 });
        let (start, steps) = (Start { mean, factor }, Steps { dt, n_steps });
        Ok(Self { system: behind, runner, regressions, start, steps, weights })
    }

    /// The same paths with another demand.
    #[must_use]
    pub fn with_demand(self, weights: [f64; D]) -> Self {
        Self { weights, ..self }
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
        let backward: Vec<_> = (0..STRENGTHS.len())
            .map(|strength| self.backward(strength, &self.weights, self.steps.n_steps))
            .collect();
        let guides = |strength: usize, share: f64| -> Vec<Guide<D, M>> {
            let backward = &backward[strength];
            let shares = self.shares(backward, threshold, tails);
            let sides = shares.into_iter().filter(|(_, part)| *part > 0.0);
            sides
                .map(|(side, part)| backward.guide(&self.start, side, threshold, share * part))
                .collect()
        };
        let demand = |path: &GuidedPath<'_, D>| -> f64 {
            self.weights.iter().zip(&path.end).map(|(w, x)| w * x).sum()
        };
        let is_hit = |path: &GuidedPath<'_, D>| match tails {
            Tails::Both => demand(path).abs() > threshold,
            Tails::Doubled | Tails::Upper => demand(path) > threshold,
        };
        let sides = if tails == Tails::Doubled { 2.0 } else { 1.0 };
        let event = Event { is_hit: &is_hit, response: None, sides, threshold };
        let strength = self.strongest(&guides, &event, config)?;
        self.estimate(&guides(strength, 1.0 - config.unguided), &event, STRENGTHS[strength], config)
    }

    /// The backward function of a weighted sum of the states after some of the steps.
    pub(crate) fn backward(
        &self,
        strength: usize,
        weights: &[f64; D],
        n_steps: usize,
    ) -> Backward<D, M> {
        let steps = Steps { n_steps, ..self.steps };
        Backward::new(&*self.system, &self.regressions, strength, weights, steps)
    }

    /// The sides of the event with their shares of the guided paths, by the probability of the linearised system.
    fn shares(&self, backward: &Backward<D, M>, threshold: f64, tails: Tails) -> [(f64, f64); 2] {
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

    /// The strength whose weights have the smallest second moment over the pilot paths.
    pub(crate) fn strongest(
        &self,
        guides: &dyn Fn(usize, f64) -> Vec<Guide<D, M>>,
        event: &Event<'_, D>,
        config: &GuidedConfig,
    ) -> Result<usize, TailError> {
        if config.n_pilots == 0 {
            return Ok(STRENGTHS.len() / 2);
        }
        let part = (1.0 - config.unguided) / STRENGTHS.len() as f64;
        let groups: Vec<_> = (0..STRENGTHS.len()).map(|strength| guides(strength, part)).collect();
        let all: Vec<_> = groups.iter().flatten().cloned().collect();
        let unguided = config.unguided;
        let collect = |path: &GuidedPath<'_, D>, sums: &mut [Contributions]| {
            if !(event.is_hit)(path) {
                for sum in sums {
                    sum.push(None);
                }
                return;
            }
            let mut first = 0;
            for (sum, group) in sums.iter_mut().zip(&groups) {
                // The density of the mixture with this strength alone, over that of the pilots.
                let ratios = &path.log_ratios[first..first + group.len()];
                first += group.len();
                let mut density = unguided;
                for (guide, ratio) in group.iter().zip(ratios) {
                    density += STRENGTHS.len() as f64 * guide.share * ratio.exp();
                }
                sum.push(Some(path.log_weight.exp() / density));
            }
        };
        let realisations = FIRST_PILOT..FIRST_PILOT + config.n_pilots;
        let (seed, n_sums) = (config.seed, STRENGTHS.len());
        let run = Ensemble { guides: &all, passage: event.passage(), seed, realisations, n_sums };
        let sums = (self.runner)(&run, &collect)?;
        let best = (0..n_sums).min_by(|&a, &b| sums[a].mean().total_cmp(&sums[b].mean()));
        Ok(best.unwrap_or_default())
    }

    /// The probability of an event from paths under the guides.
    pub(crate) fn estimate(
        &self,
        guides: &[Guide<D, M>],
        event: &Event<'_, D>,
        strength: f64,
        config: &GuidedConfig,
    ) -> Result<GuidedEstimate, TailError> {
        let collect = |path: &GuidedPath<'_, D>, sums: &mut [Contributions]| {
            let contribution = (event.is_hit)(path).then(|| event.sides * path.log_weight.exp());
            for sum in sums {
                sum.push(contribution);
            }
        };
        let (seed, realisations) = (config.seed, 0..config.n_paths);
        let run = Ensemble { guides, passage: event.passage(), seed, realisations, n_sums: 1 };
        let sums = (self.runner)(&run, &collect)?;
        let sum = sums.first().copied().unwrap_or_default();
        sum.estimate(event.threshold, strength)
    }
}

/// An event of a path.
pub(crate) struct Event<'e, const D: usize> {
    pub(crate) is_hit: &'e (dyn Fn(&GuidedPath<'_, D>) -> bool + Sync + 'e),
    /// Response whose passage of the threshold is the event, if it is one.
    pub(crate) response: Option<&'e Response<'e, D>>,
    /// Factor on the probability: 2 if one of two equal tails is sampled.
    pub(crate) sides: f64,
    pub(crate) threshold: f64,
}

impl<'e, const D: usize> Event<'e, D> {
    fn passage(&self) -> Option<(&'e Response<'e, D>, f64)> {
        self.response.map(|response| (response, self.threshold))
    }
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

impl<const D: usize, const M: usize> std::fmt::Debug for GuidedPaths<'_, D, M> {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let Self { steps, weights, .. } = self;
        f.debug_struct("GuidedPaths")
            .field("steps", steps)
            .field("weights", weights)
            .finish_non_exhaustive()
    }
}
