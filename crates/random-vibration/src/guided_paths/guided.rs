//! Paths under a feedback control of their noise.

use sde_integrators::{
    Additive, Error, GaussianMixture, Integrator, PairwiseSde, Sde, SmallPaths, WongZakai,
    small_cholesky,
};

use crate::guided_paths::guided_config::PairwiseRule;
use crate::guided_paths::path_runner::{PathRunner, check_span};
use crate::guided_paths::pilots::STRENGTHS;
use crate::guides::adjoints::{Loads, backward_at_ends};
use crate::guides::backward::{Backward, Start, Stepping};
use crate::guides::pairwise_regression::PairwiseLaws;
use crate::guides::regression::{Regressions, RunningLaw};
use crate::guides::small_regression;
use crate::linearisation::Linearisation;
use crate::tail::TailError;

/// Largest number of coefficients of all guides and backward functions: four gigabytes.
const MOST_COEFFICIENTS: f64 = 536_870_912.0;

/// Makes the regressions towards an event of some states.
type Regressing<'a> = dyn Fn(&[usize]) -> Regressions + Sync + 'a;

/// `P(y > T)` or `P(|y| > T)` of a demand `y = w . X(t)`, from paths guided to the event.
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
    pub(crate) runner: PathRunner<'a>,
    loads: Loads<'a>,
    /// The regressions towards an event of some states.
    regressions: Box<Regressing<'a>>,
    pub(crate) hold: usize,
    unmodelled: f64,
    pub(crate) weights: Vec<f64>,
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
        check_span(span)?;
        let factor = small_cholesky(&law.covariance(), 0.0).map_err(TailError::of_pivot)?;
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
        let runner = PathRunner::new::<_, M>(paths, start, span);
        Ok(Self::of(runner, loads, Box::new(move |_| regressions.clone()), (1, 0.0)))
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
        rule.check()?;
        check_span(span)?;
        let rest = RunningLaw::at_rest(system.n_states());
        let laws = PairwiseLaws::new(system, &rest, (span.0, rule.step))?;
        let regressions = Box::new(move |states: &[usize]| laws.regressions(states, &STRENGTHS));
        let noise = |t: f64, g: &mut [f64]| system.noise(t, g);
        let loads = Loads { n_motions: 1, noise: Box::new(noise) };
        let runner = PathRunner::new::<_, 1>(WongZakai(system), Start::of(rest), span);
        Ok(Self::of(runner, loads, regressions, (rule.hold, rule.unmodelled)))
    }

    fn of(
        runner: PathRunner<'a>,
        loads: Loads<'a>,
        regressions: Box<Regressing<'a>>,
        (hold, unmodelled): (usize, f64),
    ) -> Self {
        let mut weights = vec![0.0; runner.n_states()];
        if let Some(first) = weights.first_mut() {
            *first = 1.0;
        }
        Self { runner, loads, regressions, hold, unmodelled, weights }
    }

    /// Number of states.
    #[must_use]
    pub fn n_states(&self) -> usize {
        self.runner.n_states()
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

    /// The backward functions of a weighted sum of the states after some numbers of steps: one pass for all of them.
    pub(crate) fn backward(
        &self,
        regressions: &Regressions,
        strength: usize,
        weights: &[f64],
        ends: &[usize],
    ) -> Vec<Backward> {
        let Self { hold, unmodelled, .. } = *self;
        let stepping = Stepping { dt: self.runner.dt, hold, unmodelled };
        backward_at_ends(&self.loads, (regressions, strength), weights, (ends, stepping))
    }

    /// The regressions towards an event of a weighted sum of the states.
    pub(crate) fn regressions(&self, weights: &[f64]) -> Regressions {
        let states: Vec<usize> = (0..weights.len()).filter(|&i| weights[i].abs() > 0.0).collect();
        (self.regressions)(&states)
    }

    /// Number of coefficients of a guide, or of a backward function, that ends after some steps.
    pub(crate) fn n_coefficients(&self, end: usize) -> f64 {
        let of_step = 2.0 * self.loads.n_motions as f64;
        end.div_ceil(self.hold) as f64 * (self.n_states() as f64 + 1.0) + of_step * end as f64
    }
}

/// Rejects guides that take more than four gigabytes.
pub(crate) fn check_memory(n_coefficients: f64) -> Result<(), Error> {
    if n_coefficients > MOST_COEFFICIENTS {
        let quantity = "coefficients of guides (take larger steps, fewer thresholds or times, hold guides longer, or use \
                        subset simulation or Monte Carlo)";
        return Err(Error::TooMany { quantity, value: n_coefficients, limit: MOST_COEFFICIENTS });
    }
    Ok(())
}

impl std::fmt::Debug for GuidedPaths<'_> {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let Self { hold, weights, .. } = self;
        f.debug_struct("GuidedPaths")
            .field("hold", hold)
            .field("weights", weights)
            .finish_non_exhaustive()
    }
}
