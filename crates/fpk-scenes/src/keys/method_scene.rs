//! The method of a scene.

use fpk_sph::{Combination, Config, DEFAULT_MOST_STEPS, InitialLattice, Method, StepRule};
use result_figures::number::exact;
use scene_runs::scene::Objection;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::checks::{check_length, must};
use super::lattice_scene::{
    DegreeScene, FilterScene, FreshLatticesScene, LatticeScene, SettlingScene, check_counts,
    scaled_counts,
};
use super::law_scene::LawScene;
use super::scheme_scene::SchemeScene;
use crate::system::System;

/// The method, by its name.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
#[schemars(example = Self::paper())]
#[schemars(example = Self::MonteCarlo { paths: 100_000, step: 0.01, seed: 1 })]
#[schemars(example = Self::fit())]
#[schemars(example = Self::ConservativeGrid { cells: 128, reach: 8.0, steps_per_period: 80.0 })]
#[schemars(example = Self::StatisticalLinearisation { step: 0.05 })]
#[schemars(example = Self::GuidedPaths { samples: 2_000, step: 0.04, seed: 1 })]
#[schemars(example = Self::SubsetSimulation { samples: 500, correlation: 0.8, runs: 8, step: 0.04, seed: 1 })]
pub enum MethodScene {
    /// Flow-map fit: local polynomials over the initial lattice, without a neighbour search.
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
    },
    /// Monte Carlo: sampled paths.
    MonteCarlo {
        /// Number of paths (no unit).
        paths: u64,
        /// Longest step (s).
        step: f64,
        /// Seed of all random numbers (no unit).
        seed: u64,
    },
    /// The density of an oscillator on a conservative grid.
    ConservativeGrid {
        /// Cells along each axis, 24 to 8192 (no unit).
        cells: usize,
        /// Half the edge of the grid in standard deviations along the widest direction, at least 4 (no unit).
        reach: f64,
        /// Steps per period, at least 6 (no unit).
        steps_per_period: f64,
    },
    /// Mean and covariance of a normal distribution by statistical linearisation.
    StatisticalLinearisation {
        /// Longest step (s).
        step: f64,
    },
    /// Exceedance probabilities by paths guided to all thresholds, one set of paths for each time.
    GuidedPaths {
        /// Number of paths for each time and threshold; a quarter as many pilot paths, at least 200, precede all (no unit).
        samples: u64,
        /// Longest step; an interval between times has a whole number of steps (s).
        step: f64,
        /// Seed of all random numbers (no unit).
        seed: u64,
    },
    /// Exceedance probabilities by subset simulation, for each time and threshold.
    SubsetSimulation {
        /// Number of paths per level, at least 100 (no unit).
        samples: usize,
        /// Correlation of the proposal with the current path, between 0 and 1 (no unit).
        correlation: f64,
        /// Number of independent runs, from 4 to 65536; the standard error is from their scatter (no unit).
        runs: u64,
        /// Longest step (s).
        step: f64,
        /// Seed of all random numbers (no unit).
        seed: u64,
    },
}

/// Smallest number of cells: the coarser run for the error has 0.7 of them, and the grid requires 16.
const FEWEST_CELLS: usize = 24;
/// Largest number of cells: the grid then takes half a gigabyte.
pub(crate) const MOST_CELLS: usize = 8_192;
/// Smallest number of steps per period, for the same reason.
pub(crate) const FEWEST_STEPS_PER_PERIOD: f64 = 6.0;
/// Largest number of steps of a path whose gradient is computed for each of its normals.
const MOST_STEPS: f64 = 1e5;

/// Examples for the schema and the page of scenes; no built-in scene shows them.
impl MethodScene {
    /// The method of section 4.1 of Canor & Denoël 2013.
    fn paper() -> Self {
        Self::CanorDenoel2013 {
            count: vec![50, 33],
            half_width: vec![0.6, 0.4],
            courant: 0.8,
            support_over_spacing: 2.5,
        }
    }

    fn fit() -> Self {
        Self::FlowMapFit(LatticeScene {
            spacing: Some(0.3),
            smallest_probability: Some(1e-6),
            fresh_lattices: Some(FreshLatticesScene { most_uneven: 1.5, ..Default::default() }),
            steps_per_period: Some(80.0),
            scheme: Some(SchemeScene::LawsonAdamsBashforth2),
            negligible: Some(1e-4),
            settling: Some(SettlingScene::Graded),
            degree: Some(DegreeScene::Quadratic),
            ..Default::default()
        })
    }
}

impl MethodScene {
    /// Configuration of the density solver, if the method is one; `scale` multiplies the particles per axis.
    ///
    /// Also `None` if the lattice has another dimension, which the check of the scene rejects.
    #[must_use]
    pub fn density_config<const D: usize>(&self, period: f64, scale: f64) -> Option<Config<D>> {
        let (method, lattice) = match self {
            Self::FlowMapFit(lattice) => {
                (lattice.method::<D>(Method::FlowMapFit), lattice.build(scale)?)
            }
            Self::CanorDenoel2013 { count, half_width, courant, support_over_spacing } => {
                let paper = Method::CanorDenoel2013.combination();
                let combination = Combination {
                    step: StepRule::Courant { number: *courant },
                    support_over_spacing: *support_over_spacing,
                    ..paper
                };
                let half_width = half_width.as_slice().try_into().ok()?;
                let lattice =
                    InitialLattice::Rectangle { half_width, count: scaled_counts(count, scale)? };
                (Method::Custom(combination), lattice)
            }
            _ => return None,
        };
        Some(Config { method, lattice, reference_period: period, most_steps: DEFAULT_MOST_STEPS })
    }

    /// Whether the states of a filter are conditioned out.
    #[must_use]
    pub fn conditions_filter(&self) -> bool {
        matches!(self, Self::FlowMapFit(lattice) if lattice.filter == Some(FilterScene::Conditioned))
    }

    /// Whether it samples paths, which may start at a point; a density and its covariance may not.
    pub(crate) const fn starts_at_points(&self) -> bool {
        matches!(self, Self::MonteCarlo { .. } | Self::SubsetSimulation { .. })
    }

    /// Whether the density is carried by a flow map.
    pub(crate) const fn follows_flow_map(&self) -> bool {
        matches!(self, Self::FlowMapFit(_))
    }

    /// The flow-map fit with remeshing, if it has none.
    pub(crate) fn remeshed(&self) -> Option<Self> {
        match self {
            Self::FlowMapFit(lattice) if lattice.fresh_lattices.is_none() => {
                let fresh_lattices = Some(FreshLatticesScene::default());
                Some(Self::FlowMapFit(LatticeScene { fresh_lattices, ..lattice.clone() }))
            }
            _ => None,
        }
    }

    /// Rejects numbers outside their range, lists of another length, and schemes of another system.
    pub(crate) fn check(
        &self,
        system: &System,
        initial: &LawScene,
        times: &[f64],
    ) -> Result<(), Objection> {
        let states = system.states();
        match self {
            Self::FlowMapFit(lattice) if self.conditions_filter() => {
                let of_structure = check_conditioned(lattice, system, initial)?;
                lattice.check("method.flow_map_fit", of_structure)
            }
            Self::FlowMapFit(lattice) => {
                if let Some(scheme) = lattice.scheme {
                    scheme.check("method.flow_map_fit.scheme", system)?;
                }
                lattice.check("method.flow_map_fit", states)
            }
            Self::CanorDenoel2013 { count, half_width, courant, support_over_spacing } => {
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
            Self::MonteCarlo { paths, step, .. } => {
                let path = "method.monte_carlo.paths";
                must(path, *paths as f64, *paths >= FEWEST_PATHS, "at least 20")?;
                check_step("method.monte_carlo.step", *step, (system, times))
            }
            Self::ConservativeGrid { .. } => self.check_grid(system),
            Self::StatisticalLinearisation { step } => {
                let path = "method.statistical_linearisation";
                let key = format!("{path}.step");
                must(&key, *step, *step > 0.0, "greater than 0")?;
                let longest = system.reference_period() / FEWEST_LINEARISED_STEPS;
                // An interval between observations has one step at least.
                let taken = times.first().map_or(*step, |every| step.min(*every));
                let limit = format!(
                    "at most {}, a fifth of the shortest period of the system, where its steps are stable",
                    exact(longest)
                );
                must(&key, *step, taken <= longest, &limit)?;
                check_additive(path, system)
            }
            Self::GuidedPaths { samples, step, .. } => {
                let path = "method.guided_paths";
                must(&format!("{path}.samples"), *samples as f64, *samples >= 100, "at least 100")?;
                check_additive(path, system)?;
                check_path(path, *step, (system, initial, times))
            }
            Self::SubsetSimulation { samples, correlation, runs, step, .. } => {
                let path = "method.subset_simulation";
                must(&format!("{path}.samples"), *samples as f64, *samples >= 100, "at least 100")?;
                let (rho, is_between) = (*correlation, *correlation > 0.0 && *correlation < 1.0);
                must(&format!("{path}.correlation"), rho, is_between, "between 0 and 1")?;
                let few = (4..=65_536).contains(runs);
                must(&format!("{path}.runs"), *runs as f64, few, "from 4 to 65536")?;
                check_path(path, *step, (system, initial, times))
            }
        }
    }

    /// Rejects a grid too coarse for its error estimate, and a system that is no oscillator.
    fn check_grid(&self, system: &System) -> Result<(), Objection> {
        let Self::ConservativeGrid { cells, reach, steps_per_period } = *self else {
            return Ok(());
        };
        let path = "method.conservative_grid";
        let fits = (FEWEST_CELLS..=MOST_CELLS).contains(&cells);
        must(&format!("{path}.cells"), cells as f64, fits, "from 24 to 8192")?;
        must(&format!("{path}.reach"), reach, reach >= 4.0, "at least 4")?;
        let fits = steps_per_period >= FEWEST_STEPS_PER_PERIOD;
        must(&format!("{path}.steps_per_period"), steps_per_period, fits, "at least 6")?;
        if system.oscillator().is_some() {
            return Ok(());
        }
        let states = system.states().join(", ");
        let message = format!(
            "the grid solves an oscillator with the states q, v; this system has the states {states}"
        );
        Err(Objection::new(path, message).with_help(
            "use `flow_map_fit` for the density, `statistical_linearisation` for moments",
        ))
    }
}

/// Rejects what conditioning a filter out does not serve; returns the states of the structure.
fn check_conditioned<'a>(
    lattice: &LatticeScene,
    system: &System,
    initial: &LawScene,
) -> Result<&'a [&'static str], Objection> {
    let path = |key: &str| format!("method.flow_map_fit.{key}");
    let Some(of_structure) = system.structure_states() else {
        return Err(Objection::new(path("filter"), "the system has no filter")
            .with_help("leave out `filter`"));
    };
    if lattice.scheme.is_some_and(|scheme| scheme != SchemeScene::RungeKutta4) {
        let message = "filter states are conditioned out with the scheme runge_kutta_4 alone";
        return Err(Objection::new(path("scheme"), message).with_help("leave it out"));
    }
    if matches!(initial, LawScene::Mixture(components) if components.len() > 1) {
        let message = "filter states are conditioned out of one normal distribution at the start";
        return Err(Objection::new("initial.mixture", message)
            .with_help("use `gaussian`, `stationary_filter` or a mixture of one component"));
    }
    Ok(of_structure)
}

/// Rejects noise that depends on the state.
fn check_additive(path: &str, system: &System) -> Result<(), Objection> {
    if system.has_additive_noise() {
        return Ok(());
    }
    let message = "linearisation needs additive noise; that of this system depends on the state";
    Err(Objection::new(path, message).with_help("use `monte_carlo` or a density method"))
}

/// Fewest steps of linearisation in a period: Runge-Kutta 4 is stable for second moments, which oscillate and decay twice as fast as the
/// states, up to 0.22 periods.
const FEWEST_LINEARISED_STEPS: f64 = 5.0;

/// Fewest paths: the scatter of fewer says little of a standard error.
const FEWEST_PATHS: u64 = 20;

/// Fewest steps of a path in a period: with fewer its bias, which no standard error shows, is of the size of the response.
const FEWEST_PATH_STEPS: f64 = 8.0;

/// Most steps of a path: more would take a processor hours for a thousand paths.
const MOST_PATH_STEPS: f64 = 1e7;

/// Rejects steps that do not follow the motion of a system, and those that would never end.
fn check_step(key: &str, step: f64, (system, times): (&System, &[f64])) -> Result<(), Objection> {
    must(key, step, step > 0.0, "greater than 0")?;
    let steps = times.last().copied().unwrap_or_default() / step;
    must(key, step, steps <= MOST_PATH_STEPS, "such that a path has at most 1e7 steps")?;
    let longest = system.reference_period() / FEWEST_PATH_STEPS;
    let limit =
        format!("at most {}, an eighth of the shortest period of the system", exact(longest));
    must(key, step, step <= longest, &limit)
}

/// Rejects distributions and steps for which a path is no function of independent normals.
fn check_path(
    path: &str,
    step: f64,
    (system, initial, times): (&System, &LawScene, &[f64]),
) -> Result<(), Objection> {
    let key = format!("{path}.step");
    check_step(&key, step, (system, times))?;
    let longest = times.last().copied().unwrap_or_default();
    must(&key, step, longest / step <= MOST_STEPS, "such that a path has at most 100000 steps")?;
    if matches!(initial, LawScene::Mixture(components) if components.len() > 1) {
        let message = "the method needs one normal distribution at the start";
        return Err(Objection::new("initial.mixture", message)
            .with_help("use `gaussian`, a mixture of one component, or `monte_carlo`"));
    }
    Ok(())
}
