//! Which integrator steps which system of a scene.

use fpk_sph::systems::{
    Bistable, BoucWen, CoxIngersollRoss, Duffing, Filtered, GeometricBrownianMotion,
    LinearOscillator, OrnsteinUhlenbeck, StrangBoucWen, TwoStorey, VanDerPolRayleigh,
    ViscousDamper,
};
use sde_integrators::{
    Ensemble, EnsembleConfig, Error, EulerMaruyama, GaussianMixture, Observable, Sde,
    SemiImplicitEuler, Shark, StrangOscillator, simulate,
};

use super::scene::IntegratorScene;

/// A system whose paths can be sampled.
pub trait Paths<const D: usize, const M: usize>: Sde<D, M> + Clone + Send {
    /// The integrators that step it.
    const INTEGRATORS: &'static [IntegratorScene];

    /// An ensemble by one of [`INTEGRATORS`](Self::INTEGRATORS).
    ///
    /// # Errors
    /// [`PathsError`].
    fn sample(
        &self,
        integrator: IntegratorScene,
        law: &GaussianMixture<D>,
        config: &EnsembleConfig,
        observables: &[Observable<'_, D>],
    ) -> Result<Ensemble, PathsError>;
}

/// Why there is no ensemble.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum PathsError {
    /// The ensemble was refused or failed.
    #[error(transparent)]
    Ensemble(#[from] Error),
    /// The integrator asks for what the system does not have.
    #[error("the integrator {} does not step this system", .0.name())]
    NotOffered(IntegratorScene),
}

/// One line for each system: its dimensions, and its integrators.
macro_rules! paths {
    ($($system:ty, $d:literal, $m:literal: $($integrator:ident),+;)+) => { $(
        impl Paths<$d, $m> for $system {
            const INTEGRATORS: &'static [IntegratorScene] = &[$(IntegratorScene::$integrator),+];

            fn sample(
                &self,
                integrator: IntegratorScene,
                law: &GaussianMixture<$d>,
                config: &EnsembleConfig,
                observables: &[Observable<'_, $d>],
            ) -> Result<Ensemble, PathsError> {
                match integrator {
                    $(IntegratorScene::$integrator => {
                        Ok(simulate(self, &$integrator, law, config, observables)?)
                    })+
                    #[allow(unreachable_patterns, reason = "a system may be stepped by all")]
                    other => Err(PathsError::NotOffered(other)),
                }
            }
        }
    )+ };
}

paths! {
    LinearOscillator, 2, 1: EulerMaruyama, SemiImplicitEuler, StrangOscillator;
    ViscousDamper, 2, 1: EulerMaruyama, SemiImplicitEuler, StrangOscillator;
    BoucWen, 3, 1: EulerMaruyama, StrangBoucWen;
    Duffing, 2, 1: EulerMaruyama, StrangOscillator;
    VanDerPolRayleigh, 2, 1: EulerMaruyama, StrangOscillator;
    TwoStorey, 4, 1: EulerMaruyama, Shark;
    Filtered<LinearOscillator, 2, 2>, 4, 1: EulerMaruyama, Shark;
    Filtered<ViscousDamper, 2, 2>, 4, 1: EulerMaruyama, Shark;
    Filtered<BoucWen, 3, 2>, 5, 1: EulerMaruyama, Shark;
    Filtered<TwoStorey, 4, 2>, 6, 1: EulerMaruyama, Shark;
    Filtered<LinearOscillator, 2, 4>, 6, 1: EulerMaruyama, Shark;
    Filtered<ViscousDamper, 2, 4>, 6, 1: EulerMaruyama, Shark;
    OrnsteinUhlenbeck<1>, 1, 1: EulerMaruyama, Shark;
    OrnsteinUhlenbeck<2>, 2, 2: EulerMaruyama, Shark;
    OrnsteinUhlenbeck<3>, 3, 3: EulerMaruyama, Shark;
    OrnsteinUhlenbeck<4>, 4, 4: EulerMaruyama, Shark;
    Bistable, 1, 1: EulerMaruyama, Shark;
    CoxIngersollRoss, 1, 1: EulerMaruyama;
    GeometricBrownianMotion, 1, 1: EulerMaruyama;
}
