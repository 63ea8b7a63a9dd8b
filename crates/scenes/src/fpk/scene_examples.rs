//! Examples of what no built-in scene shows, for the schema and the page of scenes.

use super::lattice_scene::{DegreeScene, FreshLatticesScene, LatticeScene};
use super::law_scene::{ComponentScene, LawScene};
use super::method_scene::{IntegratorScene, MethodScene};
use super::scheme_scene::SchemeScene;
use super::structure_scene::{StructureScene, TwoStoreyScene, WindowScene};
use super::system_scene::{ShakenScene, SystemScene};

const RISE: WindowScene = WindowScene::RisePlateauDecay {
    rise_exponent: 1.0,
    rise_end: 2.0,
    decay_rate: 2.0,
    decay_start: 6.0,
};

pub(super) fn clough_penzien() -> SystemScene {
    let structure = StructureScene {
        natural_frequency: 3.0,
        damping_ratio: 0.05,
        noise_intensity: 0.2,
        window: RISE,
    };
    SystemScene::CloughPenzien {
        structure: ShakenScene::LinearOscillator(structure),
        ground_frequency: 15.6,
        ground_damping: 0.6,
        low_cut_frequency: 1.5,
        low_cut_damping: 0.6,
        noise_window: WindowScene::Stationary,
    }
}

pub(super) fn kanai_tajimi() -> SystemScene {
    let frame = TwoStoreyScene {
        mass: [1.0, 1.0],
        stiffness: [40.0, 40.0],
        damping: [0.4, 0.4],
        damper_coefficient: [0.25, 0.0],
        damper_exponent: 0.5,
        noise_intensity: 0.2,
        window: WindowScene::Stationary,
    };
    SystemScene::KanaiTajimi {
        structure: ShakenScene::TwoStorey(frame),
        ground_frequency: 15.6,
        ground_damping: 0.6,
        noise_window: RISE,
    }
}

pub(super) fn ornstein_uhlenbeck() -> SystemScene {
    SystemScene::OrnsteinUhlenbeck {
        rates: vec![vec![1.0, 0.5], vec![0.0, 2.0]],
        mean: vec![0.0, 0.0],
        noise: vec![vec![0.5, 0.0], vec![0.0, 0.5]],
    }
}

pub(super) fn mixture() -> LawScene {
    let component = |weight, place| ComponentScene {
        weight,
        mean: vec![place, 0.0],
        covariance: vec![vec![0.04, 0.0], vec![0.0, 0.01]],
    };
    LawScene::Mixture(vec![component(0.25, -1.0), component(0.75, 1.0)])
}

/// That of section 4.1 of Canor & Denoël 2013.
pub(super) fn paper() -> MethodScene {
    MethodScene::CanorDenoel2013 {
        count: vec![50, 33],
        half_width: vec![0.6, 0.4],
        courant: 0.8,
        support_over_spacing: 2.5,
        scheme: Some(SchemeScene::RungeKutta4),
    }
}

pub(super) fn sampled() -> MethodScene {
    MethodScene::MonteCarlo {
        paths: 100_000,
        step: 0.01,
        integrator: IntegratorScene::StrangOscillator,
        seed: 1,
    }
}

pub(super) fn fit() -> MethodScene {
    MethodScene::FlowMapFit(LatticeScene {
        count: None,
        spacing: Some(0.3),
        reach: 6.0,
        fresh_lattices: Some(FreshLatticesScene { most_uneven: 1.5, ..Default::default() }),
        steps_per_period: Some(80.0),
        scheme: Some(SchemeScene::Heun),
        degree: Some(DegreeScene::Quadratic),
    })
}

#[cfg(test)]
mod tests {
    use schemars::schema_for;

    use super::*;

    #[test]
    fn the_systems_and_laws_that_the_schema_shows_can_be_built() {
        let schema = schema_for!(SystemScene);
        let systems: Vec<SystemScene> =
            serde_json::from_value(schema.get("examples").cloned().unwrap_or_default()).unwrap();
        assert!(!systems.is_empty());
        for system in systems {
            assert!(system.build().is_ok(), "{system:?}");
        }
        assert!(mixture().build::<2>(None).is_ok());
    }
}
