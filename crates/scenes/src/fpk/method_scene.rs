//! The method of a scene.

use fpk_sph::{Combination, Config, DEFAULT_MOST_STEPS, InitialLattice, Method, StepRule};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::checks::{check_length, must};
use super::integrator_scene::IntegratorScene;
use super::lattice_scene::{
    DegreeScene, FreshLatticesScene, LatticeScene, check_counts, scaled_counts,
};
use super::law_scene::LawScene;
use super::scheme_scene::SchemeScene;
use super::system::System;
use crate::scene::Objection;

/// The method, by its name.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
#[schemars(example = Self::paper())]
#[schemars(example = Self::sampled())]
#[schemars(example = Self::fit())]
pub enum MethodScene {
    /// Whitened log-density fit: local polynomials over the particles near.
    LogDensityFit(LatticeScene),
    /// Flow-map fit: local polynomials over the lattice of the start, without a search.
    FlowMapFit(LatticeScene),
    /// The method of Canor & Denoël 2013 as printed.
    #[serde(rename = "canor_denoel_2013")]
    CanorDenoel2013 {
        /// Particles along each axis (no unit).
        count: Vec<usize>,
        /// Half the edges of the lattice (unit of each state).
        half_width: Vec<f64>,
        /// Courant number (no unit).
        courant: f64,
        /// `support_radius / spacing` at the start (no unit).
        support_over_spacing: f64,
        /// The scheme in time.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        #[schemars(extend("default" = SchemeScene::ForwardEuler))]
        scheme: Option<SchemeScene>,
    },
    /// The rival: sampled paths.
    MonteCarlo {
        /// Number of paths (no unit).
        paths: u64,
        /// Longest step (s).
        step: f64,
        /// How a path is stepped.
        integrator: IntegratorScene,
        /// Seed of all that is drawn (no unit).
        seed: u64,
    },
}

/// Examples of what no built-in scene shows, for the schema and the page of scenes.
impl MethodScene {
    /// That of section 4.1 of Canor & Denoël 2013.
    fn paper() -> Self {
        Self::CanorDenoel2013 {
            count: vec![50, 33],
            half_width: vec![0.6, 0.4],
            courant: 0.8,
            support_over_spacing: 2.5,
            scheme: Some(SchemeScene::RungeKutta4),
        }
    }

    fn sampled() -> Self {
        Self::MonteCarlo {
            paths: 100_000,
            step: 0.01,
            integrator: IntegratorScene::StrangOscillator,
            seed: 1,
        }
    }

    fn fit() -> Self {
        Self::FlowMapFit(LatticeScene {
            count: None,
            spacing: Some(0.3),
            reach: 6.0,
            fresh_lattices: Some(FreshLatticesScene { most_uneven: 1.5, ..Default::default() }),
            steps_per_period: Some(80.0),
            scheme: Some(SchemeScene::Heun),
            degree: Some(DegreeScene::Quadratic),
        })
    }
}

impl MethodScene {
    /// The configuration of the density solver, where the method is one; `scale` multiplies the particles per axis.
    /// `None` too where the lattice is of another dimension, which the check of the scene refuses.
    #[must_use]
    pub fn density_config<const D: usize>(&self, period: f64, scale: f64) -> Option<Config<D>> {
        let (method, lattice) = match self {
            Self::LogDensityFit(lattice) => {
                (lattice.method::<D>(Method::LogDensityFit), lattice.build(scale)?)
            }
            Self::FlowMapFit(lattice) => {
                (lattice.method::<D>(Method::FlowMapFit), lattice.build(scale)?)
            }
            Self::CanorDenoel2013 { count, half_width, courant, support_over_spacing, scheme } => {
                let paper = Method::CanorDenoel2013.combination();
                let combination = Combination {
                    step: StepRule::Courant { number: *courant },
                    support_over_spacing: *support_over_spacing,
                    scheme: scheme.map_or(paper.scheme, SchemeScene::scheme),
                    ..paper
                };
                let half_width = half_width.as_slice().try_into().ok()?;
                let lattice =
                    InitialLattice::Rectangle { half_width, count: scaled_counts(count, scale)? };
                (Method::Custom(combination), lattice)
            }
            Self::MonteCarlo { .. } => return None,
        };
        Some(Config { method, lattice, reference_period: period, most_steps: DEFAULT_MOST_STEPS })
    }

    /// The scheme that the scene names, and the name of the method.
    fn scheme(&self) -> Option<(&'static str, SchemeScene)> {
        match self {
            Self::LogDensityFit(lattice) => Some(("log_density_fit", lattice.scheme?)),
            Self::FlowMapFit(lattice) => Some(("flow_map_fit", lattice.scheme?)),
            Self::CanorDenoel2013 { scheme, .. } => Some(("canor_denoel_2013", (*scheme)?)),
            Self::MonteCarlo { .. } => None,
        }
    }

    /// Refuses numbers outside their range, lists of another length, and integrators and schemes of another system.
    pub(super) fn check(
        &self,
        system: &System,
        initial: &LawScene,
        times: &[f64],
    ) -> Result<(), Objection> {
        if let Some((method, scheme)) = self.scheme() {
            scheme.check(&format!("method.{method}.scheme"), system, initial, times)?;
        }
        let states = system.states();
        match self {
            Self::LogDensityFit(lattice) => lattice.check("method.log_density_fit", states),
            Self::FlowMapFit(lattice) => lattice.check("method.flow_map_fit", states),
            Self::CanorDenoel2013 { count, half_width, courant, support_over_spacing, .. } => {
                let path = "method.canor_denoel_2013";
                check_counts(path, count, states)?;
                check_length(&format!("{path}.half_width"), half_width.len(), states)?;
                for (k, &width) in half_width.iter().enumerate() {
                    must(&format!("{path}.half_width[{k}]"), width, width > 0.0, "greater than 0")?;
                }
                must(&format!("{path}.courant"), *courant, *courant > 0.0, "greater than 0")?;
                let ratio = *support_over_spacing;
                must(&format!("{path}.support_over_spacing"), ratio, ratio > 0.0, "greater than 0")
            }
            Self::MonteCarlo { paths, step, integrator, .. } => {
                must("method.monte_carlo.paths", *paths as f64, *paths >= 2, "at least 2")?;
                must("method.monte_carlo.step", *step, *step > 0.0, "greater than 0")?;
                let offered = system.integrators();
                if offered.contains(integrator) {
                    return Ok(());
                }
                let names: Vec<_> = offered.iter().map(|integrator| integrator.name()).collect();
                let message =
                    format!("the integrator {} does not step this system", integrator.name());
                Err(Objection::new("method.monte_carlo.integrator", message)
                    .with_help(format!("there are: {}", names.join(", "))))
            }
        }
    }
}
