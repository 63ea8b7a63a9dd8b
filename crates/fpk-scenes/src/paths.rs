//! Sampled paths of each system of a scene, by its integrator.

use random_vibration::{GuidedPaths, Linearisation, TailError, TailPaths};
use sde_integrators::{
    Additive, EnsembleConfig, Error, EulerMaruyama, GaussianMixture, General, Integrator,
    Observable, Sde, ShardRecord, Shark, SimdLevel, StepDifference, StrangOscillator, Study,
};
use vibrating_systems::{
    Bistable, BoucWen, CoxIngersollRoss, Duffing, Filtered, GeometricBrownianMotion,
    LinearOscillator, OrnsteinUhlenbeck, StrangBoucWen, TwoStorey, VanDerPolRayleigh,
    ViscousDamper,
};

/// Integrator of a path. Each system has one, the best that was measured on it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum PathIntegrator {
    /// Forward Euler, for noise that depends on the state.
    EulerMaruyama,
    /// Strang splitting with exact rotation and exact damper flow.
    StrangOscillator,
    /// The same for the hysteretic oscillator.
    StrangBoucWen,
    /// Two drift evaluations, strong order 1.5, for any system with additive noise.
    Shark,
}

impl PathIntegrator {
    /// Bias of a step over the mean change by half of it, to leading order: `2^p / (2^p - 1)` at the weak order `p`.
    pub(crate) const fn bias_over_difference(self) -> f64 {
        match self {
            Self::EulerMaruyama => 2.0,
            Self::StrangOscillator | Self::StrangBoucWen | Self::Shark => 4.0 / 3.0,
        }
    }

    /// Name for output.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::EulerMaruyama => "forward Euler",
            Self::StrangOscillator => "Strang",
            Self::StrangBoucWen => "Strang with hysteresis",
            Self::Shark => "ShARK",
        }
    }
}

/// A system whose paths can be sampled.
pub trait Paths<const D: usize, const M: usize>: Sde<D, M> + Clone + Send {
    /// Integrator of this system.
    const INTEGRATOR: PathIntegrator;

    /// Runs part `place.0` of `place.1` of an ensemble.
    ///
    /// # Errors
    /// [`PathsError`].
    fn shard(
        &self,
        ensemble: &PathEnsemble<'_, D>,
        place: (u64, u64),
    ) -> Result<ShardRecord, PathsError>;

    /// What half the step changes, over pairs of paths with noise of this amplitude relative to that of the system.
    ///
    /// # Errors
    /// [`PathsError`].
    fn step_differences(
        &self,
        ensemble: &PathEnsemble<'_, D>,
        n_pairs: u64,
        amplitude: f64,
    ) -> Result<Vec<Vec<StepDifference>>, PathsError>;

    /// Paths to a time in a given number of steps, as functions of standard normals.
    ///
    /// # Errors
    /// [`PathsError`].
    fn tails<'a>(
        &'a self,
        law: &GaussianMixture<D>,
        span: (f64, usize),
    ) -> Result<TailPaths<'a, D>, PathsError>;

    /// Paths to a time in a given number of steps, guided by a linearisation.
    ///
    /// # Errors
    /// [`PathsError`].
    fn guided<'a>(
        &'a self,
        law: &GaussianMixture<D>,
        span: (f64, usize),
        rule: &Linearisation<D>,
    ) -> Result<GuidedPaths<'a>, PathsError>;

    /// The system, if its noise is additive.
    fn additive(&self) -> Option<&dyn Sde<D, M, Noise = Additive>>;
}

/// Ensemble of a system.
#[derive(Debug, Clone, Copy)]
pub struct PathEnsemble<'a, const D: usize> {
    /// Distribution of the initial state.
    pub law: &'a GaussianMixture<D>,
    /// Number of paths, step and end time.
    pub config: &'a EnsembleConfig,
    /// Observables.
    pub observables: &'a [Observable<'a, D>],
}

impl<const D: usize> PathEnsemble<'_, D> {
    /// Runs part `shard` of `n_shards` by an integrator.
    ///
    /// # Errors
    /// [`PathsError::Ensemble`].
    pub fn shard<S: Sync + ?Sized, I: Integrator<S, D, M>, const M: usize>(
        &self,
        system: &S,
        integrator: &I,
        (shard, n_shards): (u64, u64),
    ) -> Result<ShardRecord, PathsError> {
        Ok(self.study(system, integrator).shard::<M>(shard, n_shards)?)
    }

    /// What half the step changes of the observables by an integrator, over pairs of paths.
    ///
    /// # Errors
    /// [`PathsError::Ensemble`].
    pub fn step_differences<S: Sync + ?Sized, I: Integrator<S, D, M>, const M: usize>(
        &self,
        system: &S,
        integrator: &I,
        (n_pairs, amplitude): (u64, f64),
    ) -> Result<Vec<Vec<StepDifference>>, PathsError> {
        Ok(self.study(system, integrator).step_differences::<M>(n_pairs, amplitude)?)
    }

    fn study<'s, S: ?Sized, I>(
        &'s self,
        system: &'s S,
        integrator: &'s I,
    ) -> Study<'s, S, I, GaussianMixture<D>, D> {
        let Self { law, config, observables } = *self;
        let (name, level) = ("", SimdLevel::best());
        Study { name, system, integrator, law, config, observables, level }
    }
}

/// Error of sampled paths.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum PathsError {
    /// The ensemble was invalid or failed.
    #[error(transparent)]
    Ensemble(#[from] Error),
    /// The tail probability was invalid or failed.
    #[error(transparent)]
    Tails(#[from] TailError),
    /// The shards contain other quantities.
    #[error("the shards have {found} results at each time; the scene requests {expected}")]
    OtherResults {
        /// Number in the shards.
        found: usize,
        /// Number requested.
        expected: usize,
    },
    /// The noise depends on the state.
    #[error("guided paths need additive noise")]
    NotAdditive,
}

/// A system of the named class of noise.
macro_rules! additive {
    (Additive, $system:expr) => {
        Some($system)
    };
    (General, $system:expr) => {
        None
    };
}

/// Guided paths of a system of the named class of noise.
macro_rules! guided {
    (Additive, $system:expr, $integrator:expr, $($rest:expr),+) => {
        Ok(GuidedPaths::new($system, $integrator, $($rest),+)?)
    };
    (General, $($all:expr),+) => {{
        let _ = ($($all),+);
        Err(PathsError::NotAdditive)
    }};
}

/// Type by which a system is integrated: its own, or one behind a reference.
macro_rules! integrated {
    (compiled, $system:ty, $($behind:tt)+) => { $system };
    (behind_reference, $system:ty, $noise:ident, $d:literal, $m:literal) => {
        dyn Sde<$d, $m, Noise = $noise>
    };
}

/// One line for each system: its dimensions and its integrator. A system that is compiled has vector lanes; those behind a reference
/// are compiled once for a dimension, and are slower by the calls.
macro_rules! paths {
    ($noise:ident, $how:ident: $($system:ty, $d:literal, $m:literal: $integrator:ident;)+) => { $(
        impl Paths<$d, $m> for $system {
            const INTEGRATOR: PathIntegrator = PathIntegrator::$integrator;

            fn shard(
                &self,
                ensemble: &PathEnsemble<'_, $d>,
                place: (u64, u64),
            ) -> Result<ShardRecord, PathsError> {
                let system: &integrated!($how, $system, $noise, $d, $m) = self;
                ensemble.shard::<_, _, $m>(system, &$integrator, place)
            }

            fn step_differences(
                &self,
                ensemble: &PathEnsemble<'_, $d>,
                n_pairs: u64,
                amplitude: f64,
            ) -> Result<Vec<Vec<StepDifference>>, PathsError> {
                let system: &integrated!($how, $system, $noise, $d, $m) = self;
                ensemble.step_differences::<_, _, $m>(system, &$integrator, (n_pairs, amplitude))
            }

            fn tails<'a>(
                &'a self,
                law: &GaussianMixture<$d>,
                span: (f64, usize),
            ) -> Result<TailPaths<'a, $d>, PathsError> {
                let system: &integrated!($how, $system, $noise, $d, $m) = self;
                Ok(TailPaths::new::<_, _, $m>(system, &$integrator, law, span)?)
            }

            fn guided<'a>(
                &'a self,
                law: &GaussianMixture<$d>,
                span: (f64, usize),
                rule: &Linearisation<$d>,
            ) -> Result<GuidedPaths<'a>, PathsError> {
                let system: &integrated!($how, $system, $noise, $d, $m) = self;
                guided!($noise, system, &$integrator, law, span, rule)
            }

            fn additive(&self) -> Option<&dyn Sde<$d, $m, Noise = Additive>> {
                additive!($noise, self)
            }
        }
    )+ };
}

paths! {
    Additive, compiled:
    LinearOscillator, 2, 1: StrangOscillator;
    ViscousDamper, 2, 1: StrangOscillator;
    BoucWen, 3, 1: StrangBoucWen;
    Filtered<ViscousDamper, 2, 2>, 4, 1: Shark;
    Filtered<BoucWen, 3, 2>, 5, 1: Shark;
}

paths! {
    Additive, behind_reference:
    Duffing, 2, 1: Shark;
    VanDerPolRayleigh, 2, 1: Shark;
    TwoStorey, 4, 1: Shark;
    Filtered<LinearOscillator, 2, 2>, 4, 1: Shark;
    Filtered<Duffing, 2, 2>, 4, 1: Shark;
    Filtered<TwoStorey, 4, 2>, 6, 1: Shark;
    Filtered<LinearOscillator, 2, 4>, 6, 1: Shark;
    Filtered<ViscousDamper, 2, 4>, 6, 1: Shark;
    Filtered<Duffing, 2, 4>, 6, 1: Shark;
    OrnsteinUhlenbeck<1>, 1, 1: Shark;
    OrnsteinUhlenbeck<2>, 2, 2: Shark;
    OrnsteinUhlenbeck<3>, 3, 3: Shark;
    OrnsteinUhlenbeck<4>, 4, 4: Shark;
    Bistable, 1, 1: Shark;
}

paths! {
    General, behind_reference:
    CoxIngersollRoss, 1, 1: EulerMaruyama;
    GeometricBrownianMotion, 1, 1: EulerMaruyama;
}
