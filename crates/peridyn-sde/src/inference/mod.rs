//! From cracks that were observed back to the parameters of the body: strength, correlation length, `kT`.
//!
//! | step | type |
//! |---|---|
//! | numbers of a crack and of a load curve, of ensembles and of observed plates | [`SummaryConfig`], [`Summaries`], [`Observations`] |
//! | parameters with bounds and priors, points to run ensembles at | [`ParameterSpace`] |
//! | the likelihood at one point, from one ensemble | [`SyntheticLikelihood`] |
//! | the likelihood anywhere, from ensembles at the points of a design | [`Emulator`] |
//! | the same, averaged over the noise of these ensembles | [`EmulatorMixture`] |
//! | the posterior by a tempered cloud and chains | [`Posterior`] |
//!
//! Every likelihood has the standard error that finite ensembles leave, every number of the posterior that of its chains, and each
//! parameter a verdict whether the data say more of it than the prior did.
//!
//! **When not to use it.** The likelihood supposes that summaries are nearly normal and says nothing of the error of the model:
//! plates made by another mesh, or real ones, differ from it by more than noise. What a parameter does to the spread of paths is
//! known only as well as spreads are: of `P` plates to `1/sqrt(2 P)`.
//!
//! The sampler is written here, since the kept one (nuts-rs, of PyMC) asks for gradients, brings Arrow and a second version of
//! faer, and draws from generators of its own, not from noise by address.
//!
//! Ten plates whose failure load has the mean `s` and the deviation `s/10`, and of which `kT` says nothing:
//!
//! ```
//! use peridyn_sde::inference::{
//!     Absent, Emulator, Observations, Parameter, ParameterSpace, Posterior, Prior, SamplerConfig, Scale, Summaries, Verdict,
//! };
//! use sde_integrators::{Noise, Purpose};
//!
//! // In place of `SummaryConfig::of_run` of the realisations of a `CrackStudy`.
//! let simulate = |point: &[f64], number: u64, n: usize| {
//!     let mut stream = Noise::new(1).stream(Purpose::Field, number);
//!     let mut load = |_| vec![point[0] * (1.0 + 0.1 * stream.next_normal_pair()[0])];
//!     Summaries::new(&(0..n).map(&mut load).collect::<Vec<_>>(), Absent::default())
//! };
//! let parameter = |name: &str, low, high| {
//!     Parameter { name: name.to_owned(), scale: Scale::Logarithmic, low, high, prior: Prior::Uniform }
//! };
//! let space = ParameterSpace::new(vec![parameter("strength", 0.5, 2.0), parameter("kT", 1e-6, 1e-4)])?;
//!
//! let points = space.design(20)?;
//! let ensembles = points.iter().zip(0..).map(|(point, number)| simulate(point, number, 100));
//! let emulator = Emulator::new(&space, &points, &ensembles.collect::<Result<Vec<_>, _>>()?)?;
//!
//! let plates = Observations::new(&simulate(&[1.0, 1e-5], 1000, 10)?, &[0.0])?;
//! let at_truth = emulator.log_likelihood(&[1.0, 1e-5], &plates)?;
//! assert!(at_truth.standard_error().is_some_and(|error| error < 1.0));
//!
//! let config = SamplerConfig::new(Noise::new(2));
//! let posterior = Posterior::sample(&space, &|point| emulator.value(point, &plates), &config)?;
//! assert!(posterior.has_converged());
//! let [strength, temperature] = posterior.parameters() else { unreachable!() };
//! assert_eq!((strength.verdict, temperature.verdict), (Verdict::Identified, Verdict::NotIdentified));
//! // The mean of ten loads is known to 0.1/sqrt(10).
//! assert!((strength.mean.value - 1.0).abs() < 0.13 && strength.standard_deviation.value < 0.05);
//! # Ok::<(), peridyn_sde::Error>(())
//! ```

mod diagnostics;
mod emulator;
mod factor;
mod gaussian;
mod lack_of_fit;
mod mixture;
mod parameter;
mod parameter_space;
mod polynomial;
mod posterior;
mod regressions;
mod sampler_config;
mod summaries;
mod synthetic;
mod target;
mod tempered;

pub use diagnostics::{bulk_effective_sample_size, effective_sample_size, r_hat};
pub use emulator::Emulator;
pub use gaussian::Observations;
pub use lack_of_fit::{Component, ComponentFit};
pub use mixture::EmulatorMixture;
pub use parameter::{Parameter, Prior, Scale};
pub use parameter_space::ParameterSpace;
pub use posterior::{
    LEAST_CONTRACTION, POSTERIOR_QUANTILES, ParameterPosterior, Posterior, Verdict,
};
pub use sampler_config::SamplerConfig;
pub use summaries::{Absent, LoadSummary, Summaries, SummaryConfig};
pub use synthetic::{Estimator, SyntheticLikelihood};
