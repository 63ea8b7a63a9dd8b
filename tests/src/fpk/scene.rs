//! A density scene as it stands in its JSON file.

use fpk_sph::systems::{
    LinearOscillator, LinearOscillatorParameters, ViscousDamper, ViscousDamperParameters, Window,
};
use fpk_sph::{Combination, Config, DEFAULT_MOST_STEPS, InitialLattice, Method, StepRule};
use sde_integrators::{GaussianComponent, GaussianMixture};
use serde::{Deserialize, Serialize};

use crate::scene::{Objection, Scene};

/// What is modelled, what is asked, and with which method.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct FpkScene {
    /// Always `fpk-sph`.
    pub solver: String,
    /// One line for the reader.
    pub title: String,
    /// The system.
    pub system: SystemScene,
    /// The law of the state at `t = 0`.
    pub initial: LawScene,
    /// How it is solved.
    pub method: MethodScene,
    /// When it is observed.
    pub times: Times,
    /// Raw moments `E[q^a v^b]`, as `[a, b]`.
    pub moments: Vec<[u32; 2]>,
    /// Thresholds `T` of `P(|q| > T)`, in the unit of `q`.
    pub thresholds: Vec<f64>,
}

/// The system, by its name.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
pub enum SystemScene {
    /// `q'' + 2 xi w q' + w^2 q = a(t) W`.
    LinearOscillator(StructureScene),
    /// `q'' + 2 xi w q' + eta sign(q') |q'|^alpha + w^2 q = a(t) W` (Canor & Denoël 2013, eq 26).
    ViscousDamper {
        /// The structure.
        structure: StructureScene,
        /// `eta`.
        damper_coefficient: f64,
        /// `alpha`.
        damper_exponent: f64,
    },
}

/// A structure in its first mode.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct StructureScene {
    /// `w` (rad/s).
    pub natural_frequency: f64,
    /// `xi`.
    pub damping_ratio: f64,
    /// `S_0`, the diffusion of the velocity at `a = 1`.
    pub noise_intensity: f64,
    /// `a(t)`.
    pub window: WindowScene,
}

/// The window of the noise.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
pub enum WindowScene {
    /// `a = 1`.
    Stationary,
    /// Canor & Denoël 2013, eq 27.
    RisePlateauDecay {
        /// `n_1`.
        rise_exponent: f64,
        /// `t_1` (s).
        rise_end: f64,
        /// `n_2` (1/s).
        decay_rate: f64,
        /// `t_2` (s).
        decay_start: f64,
    },
}

/// The initial law.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
pub enum LawScene {
    /// Independent Gaussian components.
    Gaussian {
        /// Means of `(q, q')`.
        mean: [f64; 2],
        /// Standard deviations of `(q, q')`.
        standard_deviation: [f64; 2],
    },
    /// A mixture of Gaussians.
    Mixture(Vec<ComponentScene>),
}

/// One Gaussian of a mixture.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ComponentScene {
    /// Its weight; the weights sum to 1.
    pub weight: f64,
    /// Its mean.
    pub mean: [f64; 2],
    /// Its covariance.
    pub covariance: [[f64; 2]; 2],
}

/// The method, by its name.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
pub enum MethodScene {
    /// Whitened log-density fit, Runge-Kutta 4.
    LogDensityFit {
        /// Particles along each axis of the initial lattice.
        count: [usize; 2],
        /// Half the edge of the lattice, in standard deviations.
        reach: f64,
    },
    /// The paper's method.
    #[serde(rename = "canor_denoel_2013")]
    CanorDenoel2013 {
        /// Particles along each axis.
        count: [usize; 2],
        /// Half the edges of the lattice, in the units of the state.
        half_width: [f64; 2],
        /// Courant number.
        courant: f64,
        /// `support_radius / spacing` at the start.
        support_over_spacing: f64,
    },
    /// The rival: sampled paths.
    MonteCarlo {
        /// Number of paths.
        paths: u64,
        /// Longest step (s).
        step: f64,
        /// How a path is stepped.
        integrator: IntegratorScene,
        /// Seed.
        seed: u64,
    },
}

/// How a path is stepped.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum IntegratorScene {
    /// Forward Euler, the paper's.
    EulerMaruyama,
    /// Semi-implicit Euler.
    SemiImplicitEuler,
    /// Strang splitting with exact rotation and damper flow.
    StrangOscillator,
}

/// Equal intervals of observation, from `every` to `until`.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Times {
    /// The last time (s).
    pub until: f64,
    /// The interval (s).
    pub every: f64,
}

/// A system that has been checked.
#[derive(Debug, Clone, PartialEq)]
pub enum System {
    /// The linear oscillator.
    Linear(LinearOscillator),
    /// The viscous damper.
    Damper(ViscousDamper),
}

/// Most output times of a scene: beyond it a result file is no longer read by anyone.
const MOST_TIMES: f64 = 10_000.0;

impl Times {
    /// The times themselves.
    #[must_use]
    pub fn list(&self) -> Vec<f64> {
        // The slack takes in an end that roundoff put just below a multiple.
        let n = (self.until / self.every + 1e-9).floor().min(MOST_TIMES);
        (1..=10_000_u32)
            .take_while(|&k| f64::from(k) <= n)
            .map(|k| f64::from(k) * self.every)
            .collect()
    }

    fn check(&self) -> Result<(), Objection> {
        must("times.until", self.until, self.until > 0.0, "greater than 0")?;
        must(
            "times.every",
            self.every,
            self.every > 0.0 && self.every <= self.until,
            "greater than 0 and at most `until`",
        )?;
        let n = self.until / self.every;
        must("times.every", self.every, n <= MOST_TIMES, "such that there are at most 10000 times")
    }
}

impl SystemScene {
    /// The system, checked.
    ///
    /// # Errors
    /// [`fpk_sph::Error`], naming the parameter.
    pub fn build(&self) -> Result<System, fpk_sph::Error> {
        match *self {
            Self::LinearOscillator(structure) => {
                Ok(System::Linear(LinearOscillator::new(structure.parameters())?))
            }
            Self::ViscousDamper { structure, damper_coefficient, damper_exponent } => {
                let structure = structure.parameters();
                let parameters =
                    ViscousDamperParameters { structure, damper_coefficient, damper_exponent };
                Ok(System::Damper(ViscousDamper::new(parameters)?))
            }
        }
    }

    /// The structure, and where it stands in the scene.
    fn structure(&self) -> (&StructureScene, &'static str) {
        match self {
            Self::LinearOscillator(structure) => (structure, "system.linear_oscillator"),
            Self::ViscousDamper { structure, .. } => (structure, "system.viscous_damper.structure"),
        }
    }
}

impl StructureScene {
    fn parameters(&self) -> LinearOscillatorParameters {
        let Self { natural_frequency, damping_ratio, noise_intensity, window } = *self;
        let window = match window {
            WindowScene::Stationary => Window::Stationary,
            WindowScene::RisePlateauDecay { rise_exponent, rise_end, decay_rate, decay_start } => {
                Window::RisePlateauDecay { rise_exponent, rise_end, decay_rate, decay_start }
            }
        };
        LinearOscillatorParameters { natural_frequency, damping_ratio, noise_intensity, window }
    }
}

impl System {
    /// The natural period (s).
    #[must_use]
    pub fn period(&self) -> f64 {
        match self {
            Self::Linear(system) => system.period(),
            Self::Damper(system) => system.period(),
        }
    }
}

impl LawScene {
    /// The law, checked.
    ///
    /// # Errors
    /// [`sde_integrators::Error`], naming what is wrong.
    pub fn build(&self) -> Result<GaussianMixture<2>, sde_integrators::Error> {
        match self {
            Self::Gaussian { mean, standard_deviation } => {
                GaussianMixture::independent(*mean, *standard_deviation)
            }
            Self::Mixture(components) => {
                let components: Vec<_> = components
                    .iter()
                    .map(|&ComponentScene { weight, mean, covariance }| GaussianComponent {
                        weight,
                        mean,
                        covariance,
                    })
                    .collect();
                GaussianMixture::mixture(&components)
            }
        }
    }
}

impl FpkScene {
    /// The configuration of the density solver, where the method is one; `scale` multiplies the particles per axis.
    #[must_use]
    pub fn density_config(&self, period: f64, scale: f64) -> Option<Config<2>> {
        let scaled = |count: [usize; 2]| count.map(|n| scaled_count(n, scale));
        let (method, lattice) = match self.method {
            MethodScene::LogDensityFit { count, reach } => {
                (Method::LogDensityFit, InitialLattice::Box { reach, count: scaled(count) })
            }
            MethodScene::CanorDenoel2013 { count, half_width, courant, support_over_spacing } => {
                let combination = Combination {
                    step: StepRule::Courant { number: courant },
                    support_over_spacing,
                    ..Method::CanorDenoel2013.combination()
                };
                (
                    Method::Custom(combination),
                    InitialLattice::Rectangle { half_width, count: scaled(count) },
                )
            }
            MethodScene::MonteCarlo { .. } => return None,
        };
        Some(Config { method, lattice, reference_period: period, most_steps: DEFAULT_MOST_STEPS })
    }
}

/// Particles along an axis at `scale` times the resolution; the ends of the lattice stay where they are.
fn scaled_count(count: usize, scale: f64) -> usize {
    let intervals = count.saturating_sub(1) as f64 * scale;
    // The nearest whole number of intervals.
    1 + (1..=MOST_PER_AXIS).take_while(|&n| n as f64 <= intervals + 0.5).last().unwrap_or(0)
}

impl Scene for FpkScene {
    fn check(&self) -> Result<(), Objection> {
        let (structure, path) = self.system.structure();
        let StructureScene { natural_frequency: w, damping_ratio: xi, noise_intensity: s, .. } =
            *structure;
        must(&format!("{path}.natural_frequency"), w, w > 0.0, "greater than 0")?;
        must(&format!("{path}.damping_ratio"), xi, xi >= 0.0, "0 or greater")?;
        must(&format!("{path}.noise_intensity"), s, s >= 0.0, "0 or greater: it is a diffusion")?;
        if let SystemScene::ViscousDamper {
            damper_coefficient: eta, damper_exponent: alpha, ..
        } = self.system
        {
            must("system.viscous_damper.damper_coefficient", eta, eta >= 0.0, "0 or greater")?;
            must("system.viscous_damper.damper_exponent", alpha, alpha > 0.0, "greater than 0")?;
        }
        if let LawScene::Gaussian { standard_deviation, .. } = &self.initial {
            for (k, &deviation) in standard_deviation.iter().enumerate() {
                let path = format!("initial.gaussian.standard_deviation[{k}]");
                must(&path, deviation, deviation > 0.0, "greater than 0")?;
            }
        }
        self.system.build().map_err(|error| Objection::new("system", error.to_string()))?;
        self.initial.build().map_err(|error| Objection::new("initial", error.to_string()))?;
        self.times.check()?;
        self.check_method()?;
        for (k, &threshold) in self.thresholds.iter().enumerate() {
            must(&format!("thresholds[{k}]"), threshold, threshold > 0.0, "greater than 0")?;
            let sorted = k == 0 || threshold > self.thresholds[k - 1];
            must(&format!("thresholds[{k}]"), threshold, sorted, "greater than the one before it")?;
        }
        for (k, powers) in self.moments.iter().enumerate() {
            let order = powers.iter().sum::<u32>();
            must(
                &format!("moments[{k}]"),
                f64::from(order),
                (1..=8).contains(&order),
                "of order 1 to 8",
            )?;
        }
        Ok(())
    }
}

impl FpkScene {
    fn check_method(&self) -> Result<(), Objection> {
        match self.method {
            MethodScene::LogDensityFit { count, reach } => {
                check_counts("method.log_density_fit", count)?;
                must(
                    "method.log_density_fit.reach",
                    reach,
                    reach > 0.0,
                    "greater than 0 standard deviations",
                )
            }
            MethodScene::CanorDenoel2013 { count, half_width, courant, support_over_spacing } => {
                let path = "method.canor_denoel_2013";
                check_counts(path, count)?;
                for (k, &width) in half_width.iter().enumerate() {
                    must(&format!("{path}.half_width[{k}]"), width, width > 0.0, "greater than 0")?;
                }
                must(&format!("{path}.courant"), courant, courant > 0.0, "greater than 0")?;
                let ratio = support_over_spacing;
                must(&format!("{path}.support_over_spacing"), ratio, ratio > 0.0, "greater than 0")
            }
            MethodScene::MonteCarlo { paths, step, .. } => {
                must("method.monte_carlo.paths", paths as f64, paths >= 2, "at least 2")?;
                must("method.monte_carlo.step", step, step > 0.0, "greater than 0")
            }
        }
    }
}

/// Most particles along an axis: their square still fits the neighbour lists and the memory of a workstation.
const MOST_PER_AXIS: usize = 2_000;

fn check_counts(path: &str, count: [usize; 2]) -> Result<(), Objection> {
    for (k, &n) in count.iter().enumerate() {
        let allowed = (3..=MOST_PER_AXIS).contains(&n);
        must(&format!("{path}.count[{k}]"), n as f64, allowed, "from 3 to 2000 particles")?;
    }
    Ok(())
}

/// Objects to the value at a path unless it is as it must be.
fn must(path: &str, value: f64, holds: bool, limit: &str) -> Result<(), Objection> {
    if holds {
        Ok(())
    } else {
        Err(Objection::new(path, format!("{value} was given; it must be {limit}")))
    }
}
