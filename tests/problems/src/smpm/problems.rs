//! The scenes that cases and charts look at, each with what varies between them.

use smpm_scenes::experiment::SceneExperiment;
use smpm_scenes::scene::{SmpmScene, TimeScene};

use crate::context::CaseError;

/// A scene of the workspace.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Problem {
    /// Uniaxial shock.
    PlateImpact,
    /// The second example of Chen et al. 2019: a thin plate whose flow stress is random.
    ContactExplosion,
    /// The first: a thick plate whose equation of state is random.
    ThickPlate,
    /// A cylinder of copper against a wall, axisymmetric.
    TaylorBar,
    /// A quarter of it in three dimensions.
    TaylorBarQuarter,
    /// A column under its weight whose stiffness is a random field.
    RandomColumn,
    /// The thin plate with a random field of the yield stress.
    RandomPlate,
    /// The cylinder with a random field of the yield stress.
    RandomTaylorBar,
    /// A slope of clay whose strength is a random field.
    RandomSlope,
}

impl Problem {
    const fn text(self) -> (&'static str, &'static str) {
        match self {
            Self::PlateImpact => (
                "tests/scenes/smpm/plate_impact.json",
                include_str!("../../../../tests/scenes/smpm/plate_impact.json"),
            ),
            Self::ContactExplosion => (
                "tests/scenes/smpm/contact_explosion.json",
                include_str!("../../../../tests/scenes/smpm/contact_explosion.json"),
            ),
            Self::ThickPlate => (
                "tests/scenes/smpm/contact_explosion_thick.json",
                include_str!("../../../../tests/scenes/smpm/contact_explosion_thick.json"),
            ),
            Self::TaylorBar => (
                "tests/scenes/smpm/taylor_bar.json",
                include_str!("../../../../tests/scenes/smpm/taylor_bar.json"),
            ),
            Self::TaylorBarQuarter => (
                "tests/scenes/smpm/taylor_bar_quarter.json",
                include_str!("../../../../tests/scenes/smpm/taylor_bar_quarter.json"),
            ),
            Self::RandomColumn => (
                "tests/scenes/smpm/random_column.json",
                include_str!("../../../../tests/scenes/smpm/random_column.json"),
            ),
            Self::RandomPlate => (
                "tests/scenes/smpm/random_plate.json",
                include_str!("../../../../tests/scenes/smpm/random_plate.json"),
            ),
            Self::RandomTaylorBar => (
                "tests/scenes/smpm/random_taylor_bar.json",
                include_str!("../../../../tests/scenes/smpm/random_taylor_bar.json"),
            ),
            Self::RandomSlope => (
                "tests/scenes/smpm/random_slope.json",
                include_str!("../../../../tests/scenes/smpm/random_slope.json"),
            ),
        }
    }

    /// The scene unchanged.
    pub fn scene(self) -> Result<SmpmScene, CaseError> {
        let (name, text) = self.text();
        Ok(SmpmScene::read(name, text)?)
    }

    /// The scene with one coefficient of variation for all its parameters, looked at at given times.
    pub fn scene_with(
        self,
        coefficient_of_variation: f64,
        times: &[f64],
    ) -> Result<SmpmScene, CaseError> {
        let mut scene = self.scene()?;
        for random in &mut scene.random {
            random.coefficient_of_variation = coefficient_of_variation;
        }
        scene.times = times.iter().map(|&time| TimeScene::At(time)).collect();
        Ok(scene)
    }
}

/// A scene, read as an experiment.
pub fn experiment<const D: usize>(scene: &SmpmScene) -> Result<SceneExperiment<D>, CaseError> {
    Ok(SceneExperiment::new(scene)?)
}
