//! The built-in problems: each is a scene file, and has references.

use fpk_scenes::density::{self, DensityRun, Requested};
use fpk_scenes::monte_carlo::{self, SampledRun, Sampling, Shard};
use fpk_scenes::paths::PathsError;
use fpk_scenes::scene::FpkScene;
use fpk_scenes::system::System;
use fpk_sph::{Config, Error};
use sde_integrators::{EulerMaruyama, GaussianMixture};
use vibrating_systems::{BoucWen, Duffing, Filtered, LinearOscillator};

use super::oscillator::Oscillator;
use super::reference::ReferenceTable;
use crate::context::CaseError;

/// A built-in scene with its references.
#[derive(Debug)]
pub struct Problem {
    /// The scene as in its file.
    pub scene: FpkScene,
    /// Its system.
    pub system: Oscillator,
    /// Its initial density.
    pub law: GaussianMixture<2>,
    /// Its references.
    pub reference: ReferenceTable,
}

impl Problem {
    /// The linear oscillator of section 4.1 without its damper.
    pub fn linear_oscillator() -> Result<Self, CaseError> {
        let text = include_str!("../../../../tests/scenes/fpk/linear_oscillator.json");
        Self::new(
            "tests/scenes/fpk/linear_oscillator.json",
            text,
            ReferenceTable::linear_oscillator()?,
        )
    }

    /// The oscillator with a viscous damper of section 4.1.
    pub fn viscous_damper() -> Result<Self, CaseError> {
        let text = include_str!("../../../../tests/scenes/fpk/viscous_damper.json");
        Self::new("tests/scenes/fpk/viscous_damper.json", text, ReferenceTable::viscous_damper()?)
    }

    fn new(name: &str, text: &str, reference: ReferenceTable) -> Result<Self, CaseError> {
        let (scene, system) = FpkScene::read(name, text)?;
        let system = Oscillator::of(system).ok_or("not a system of section 4.1")?;
        let law = scene.initial.build(None)?;
        Ok(Self { scene, system, law, reference })
    }

    /// The configuration of the scene's density method, with so many times its intervals along each axis.
    pub fn density_config(&self, refinement: f64) -> Result<Config<2>, CaseError> {
        let config = self.scene.method.density_config(self.system.period(), refinement);
        config.ok_or_else(|| "the scene has no density method".into())
    }

    /// Runs the density solver on it.
    ///
    /// A run that ends early is a result: its rows so far, with the reason in [`DensityRun::stopped`].
    ///
    /// # Errors
    /// [`Error`] where the run could not start.
    pub fn density(&self, config: &Config<2>, asked: &Requested) -> Result<DensityRun, Error> {
        match self.system.clone() {
            Oscillator::Linear(system) => {
                density::run_on(system, &self.law, config, asked, |_, _| ())
            }
            Oscillator::Damper(system) => {
                density::run_on(system, &self.law, config, asked, |_, _| ())
            }
        }
    }

    /// Samples paths of it; [`Requested::cells`] has no meaning here.
    pub fn sampled(
        &self,
        sampling: &Sampling,
        asked: &Requested,
    ) -> Result<SampledRun, PathsError> {
        match &self.system {
            Oscillator::Linear(system) => monte_carlo::run_on(system, &self.law, sampling, asked),
            Oscillator::Damper(system) => monte_carlo::run_on(system, &self.law, sampling, asked),
        }
    }

    /// As [`Self::sampled`] by forward Euler, the integrator of the paper.
    pub fn sampled_by_euler(
        &self,
        sampling: &Sampling,
        asked: &Requested,
    ) -> Result<SampledRun, PathsError> {
        let shard: Shard<'_, 2> = &|paths, place| match &self.system {
            Oscillator::Linear(system) => paths.shard(system, &EulerMaruyama, place),
            Oscillator::Damper(system) => paths.shard(system, &EulerMaruyama, place),
        };
        monte_carlo::run_by(shard, &self.law, sampling, asked)
    }
}

/// A scene of any dimension with its system, which `pick` takes out of those that a scene can name.
fn picked<S, const D: usize>(
    name: &str,
    text: &str,
    pick: impl FnOnce(System) -> Option<S>,
) -> Result<(S, GaussianMixture<D>), CaseError> {
    let (scene, system) = FpkScene::read(name, text)?;
    let law = scene.initial.build(system.filter_covariance().as_deref())?;
    let system = pick(system).ok_or_else(|| format!("{name} holds another system"))?;
    Ok((system, law))
}

/// The Bouc-Wen oscillator of section 4.2, its initial density and its references.
pub fn bouc_wen() -> Result<(BoucWen, GaussianMixture<3>, ReferenceTable), CaseError> {
    let text = include_str!("../../../../tests/scenes/fpk/bouc_wen.json");
    let (system, law) = picked("tests/scenes/fpk/bouc_wen.json", text, |system| match system {
        System::BoucWen(system) => Some(system),
        _ => None,
    })?;
    Ok((system, law, ReferenceTable::bouc_wen()?))
}

/// The hardening spring and its initial density.
pub fn duffing() -> Result<(Duffing, GaussianMixture<2>), CaseError> {
    let text = include_str!("../../../../tests/scenes/fpk/duffing.json");
    picked("tests/scenes/fpk/duffing.json", text, |system| match system {
        System::Duffing(system) => Some(system),
        _ => None,
    })
}

/// A linear oscillator behind the filter of Kanai and Tajimi.
pub type ShakenOscillator = Filtered<LinearOscillator, 2, 2>;

/// The linear building on firm soil and its initial density; its density at all times follows from
/// [`linear_moments`](super::linear_moments::linear_moments).
pub fn kanai_tajimi() -> Result<(ShakenOscillator, GaussianMixture<4>), CaseError> {
    let text = include_str!("../../../../tests/scenes/fpk/kanai_tajimi.json");
    picked("tests/scenes/fpk/kanai_tajimi.json", text, |system| match system {
        System::KanaiTajimiLinear(system) => Some(system),
        _ => None,
    })
}
