//! An inference scene as written in its JSON file: parameters of a crack scene from cracks that were measured.

use crack_inference::{Error, Parameter, ParameterSpace, Prior, SamplerConfig, Scale};
use peridyn_sde::statistics::{LoadSummary, SummaryConfig};
use scene_runs::scene::{Objection, Scene, WrongKey, read_keys};
use schemars::JsonSchema;
use sde_integrators::Noise;
use serde::{Deserialize, Serialize};
use serde_json::Value;

use crate::keys::named::named;

/// Parameters of a crack scene from measured crack paths and failure loads: model, data, parameters, design of ensembles, sampler.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct InferenceScene {
    /// Always `peridyn-sde-inference`.
    pub solver: String,
    /// Title, one line.
    pub title: String,
    /// The model: the file of a scene of `peridyn-sde`, relative to the folder of this scene. Its numbers of realisations, its seed
    /// and its output are not used.
    pub plate: String,
    /// What was measured.
    pub measured: MeasuredScene,
    /// Numbers by which measured and computed plates are compared.
    pub summaries: SummariesScene,
    /// Unknown parameters, at most six.
    pub parameters: Vec<ParameterScene>,
    /// Ensembles to which the likelihood is fitted.
    pub design: DesignScene,
    /// Sampling of the posterior.
    #[serde(default)]
    #[schemars(example = SamplerScene::default())]
    pub sampler: SamplerScene,
    /// Ensembles at draws of the posterior, compared with the measured plates.
    #[serde(default)]
    #[schemars(example = PredictiveScene::default())]
    pub predictive: PredictiveScene,
    /// Seed of all random numbers (no unit).
    pub seed: u64,
}

/// Measured plates.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct MeasuredScene {
    /// A `.csv` file of paths, relative to the folder of this scene: columns `plate` (any name), `x` and `y` (m), with the points of a
    /// plate in the order of the crack.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub paths: Option<String>,
    /// A `.csv` file of failure loads, relative to the folder of this scene: columns `plate` and `failure_load` (N), one row for each
    /// plate.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub failure_loads: Option<String>,
    /// Standard error of a measured height (m).
    #[serde(default)]
    pub height_error: f64,
    /// Standard error of a measured failure load as a fraction of it (no unit).
    #[serde(default)]
    pub load_error: f64,
}

/// Numbers of a plate that are compared.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct SummariesScene {
    /// Abscissae at which the height of the crack is compared (m); none for the load alone.
    #[serde(default)]
    pub abscissae: Vec<f64>,
    /// What of the load is compared.
    #[serde(default)]
    pub load: LoadScene,
}

named! {
    /// What of the load is compared.
    LoadScene => LoadSummary {
        /// Nothing.
        #[default]
        None,
        /// The largest load, as a mean over a window of the plate's `output.windows`.
        FailureLoad,
        /// Its natural logarithm: nearer to a linear function of the logarithm of a strength.
        LogFailureLoad,
    }
}

/// An unknown parameter.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ParameterScene {
    /// Path of a number in the scene of the plate, as error messages write it, e.g. `strength.field.correlation.length`.
    pub key: String,
    /// Lowest value (unit of the key).
    pub low: f64,
    /// Highest value (unit of the key).
    pub high: f64,
    /// Scale on which the prior is uniform or normal and the likelihood is fitted by a quadratic polynomial.
    #[serde(default)]
    pub scale: ScaleScene,
    /// Prior distribution, between the lowest and the highest value.
    #[serde(default)]
    #[schemars(example = PriorScene::Normal { median: 4.0, standard_deviation: 0.3 })]
    pub prior: PriorScene,
}

named! {
    /// Scale of a parameter.
    ScaleScene => Scale {
        /// The value itself.
        #[default]
        Linear,
        /// Its natural logarithm; both bounds are then positive.
        Logarithmic,
    }
}

/// Prior distribution of a parameter.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
pub enum PriorScene {
    /// Uniform on the scale.
    #[default]
    Uniform,
    /// Normal on the scale, cut off at the bounds: lognormal for a logarithmic scale.
    Normal {
        /// The median before it is cut off, between the bounds (unit of the key).
        median: f64,
        /// Standard deviation (unit of the scale): of the value, or of its natural logarithm.
        standard_deviation: f64,
    },
}

/// Ensembles to which the likelihood is fitted.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct DesignScene {
    /// Number of points of the parameters with an ensemble each (no unit). For `d` parameters at least `(d + 1)(d + 2)/2 + 4`.
    pub points: u64,
    /// Realisations of each ensemble (no unit): at least four more than there are summaries.
    pub realisations: u64,
    /// Number of fits, each with the errors of finite ensembles drawn anew, over which the likelihood is averaged, at least 8 (no unit).
    #[serde(default = "emulators")]
    #[schemars(example = 24)]
    pub emulators: u64,
}

const fn emulators() -> u64 {
    24
}

/// Sampling of the posterior: a cloud of points that moves from the prior to it, then chains.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct SamplerScene {
    /// Points of the cloud, at least 100 (no unit).
    pub particles: u64,
    /// Steps of each point at each power of the likelihood, at least 1 (no unit).
    pub moves: u64,
    /// Chains from points of the cloud, at least 4 (no unit).
    pub chains: u64,
    /// Steps of each chain before its draws (no unit).
    pub warm_up: u64,
    /// Draws of each chain, at least 100 (no unit).
    pub draws: u64,
}

impl Default for SamplerScene {
    fn default() -> Self {
        let SamplerConfig { n_particles, n_moves, n_chains, n_warm_up, n_draws, .. } =
            SamplerConfig::new(Noise::new(0));
        let [particles, moves, chains] = [n_particles, n_moves, n_chains].map(|n| n as u64);
        Self { particles, moves, chains, warm_up: n_warm_up as u64, draws: n_draws as u64 }
    }
}

/// Ensembles at draws of the posterior.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct PredictiveScene {
    /// Number of draws with an ensemble each, at least 4 (no unit).
    pub draws: u64,
    /// Realisations of each ensemble, at least 8 (no unit).
    pub realisations: u64,
}

impl Default for PredictiveScene {
    fn default() -> Self {
        Self { draws: 12, realisations: 32 }
    }
}

/// Most parameters of a design: beyond, its points are not even.
const MOST_PARAMETERS: usize = 6;
/// Most of anything that is counted.
const MOST: u64 = 1_000_000;

impl Scene for InferenceScene {
    type Built = ParameterSpace;

    fn from_keys(keys: &Value) -> Result<Self, WrongKey> {
        read_keys(keys)
    }

    fn check(&self) -> Result<ParameterSpace, Objection> {
        self.check_measured()?;
        self.check_summaries()?;
        let space = self.space()?;
        self.check_counts()?;
        Ok(space)
    }

    fn seed(&mut self) -> Option<&mut u64> {
        Some(&mut self.seed)
    }
}

impl InferenceScene {
    /// The summaries that are compared.
    #[must_use]
    pub fn summary_config(&self) -> SummaryConfig {
        let load = self.summaries.load.into();
        SummaryConfig { abscissae: self.summaries.abscissae.clone(), load }
    }

    /// Number of summaries of a plate.
    #[must_use]
    pub fn n_summaries(&self) -> usize {
        self.summaries.abscissae.len() + usize::from(self.summaries.load != LoadScene::None)
    }

    fn check_measured(&self) -> Result<(), Objection> {
        let MeasuredScene { height_error, load_error, .. } = self.measured;
        for (name, value) in [("height_error", height_error), ("load_error", load_error)] {
            if !(value.is_finite() && value >= 0.0) {
                let message = format!("the standard error is {value}; it must not be negative");
                return Err(Objection::new(format!("measured.{name}"), message));
            }
        }
        let needs = [
            ("paths", "summaries.abscissae", !self.summaries.abscissae.is_empty()),
            ("failure_loads", "summaries.load", self.summaries.load != LoadScene::None),
        ];
        for ((name, of, is_needed), file) in
            needs.into_iter().zip([&self.measured.paths, &self.measured.failure_loads])
        {
            if is_needed && file.is_none() {
                let message =
                    format!("the key `{name}` is missing, and `{of}` compares its numbers");
                return Err(Objection::new("measured", message));
            }
        }
        Ok(())
    }

    fn check_summaries(&self) -> Result<(), Objection> {
        if self.n_summaries() == 0 {
            let message = "nothing is compared: there are no abscissae, and no load";
            return Err(Objection::new("summaries", message));
        }
        let abscissae = &self.summaries.abscissae;
        for (i, x) in abscissae.iter().enumerate() {
            if abscissae[..i].contains(x) {
                let message = format!("the abscissa {x} m is given twice");
                return Err(Objection::new(format!("summaries.abscissae[{i}]"), message));
            }
        }
        Ok(())
    }

    fn check_counts(&self) -> Result<(), Objection> {
        let d = self.parameters.len() as u64;
        let least = (d + 1) * (d + 2) / 2 + 4;
        let DesignScene { points, realisations, emulators } = self.design;
        let why = format!("a quadratic in {d} parameters has four terms fewer");
        counted("design.points", points, least, &why)?;
        let why = "four more than the summaries";
        counted("design.realisations", realisations, self.n_summaries() as u64 + 4, why)?;
        counted("design.emulators", emulators, 8, "the least to average over")?;
        let SamplerScene { particles, moves, chains, warm_up, draws } = self.sampler;
        counted(
            "sampler.particles",
            particles,
            100,
            "a cloud of fewer has no covariance to speak of",
        )?;
        counted("sampler.moves", moves, 1, "each point must move")?;
        counted("sampler.chains", chains, 4, "R-hat compares them")?;
        counted("sampler.warm_up", warm_up, 0, "")?;
        counted("sampler.draws", draws, 100, "R-hat compares halves of chains")?;
        let PredictiveScene { draws, realisations } = self.predictive;
        counted("predictive.draws", draws, 4, "errors come from leaving out one at a time")?;
        counted("predictive.realisations", realisations, 8, "those that run side by side")
    }

    fn space(&self) -> Result<ParameterSpace, Objection> {
        let n = self.parameters.len();
        if n == 0 || n > MOST_PARAMETERS {
            let message = format!("{n} parameters; there must be 1 to {MOST_PARAMETERS}");
            return Err(Objection::new("parameters", message));
        }
        for (i, parameter) in self.parameters.iter().enumerate() {
            let at = format!("parameters[{i}]");
            if self.parameters[..i].iter().any(|other| other.key == parameter.key) {
                let message = format!("the parameter `{}` is given twice", parameter.key);
                return Err(Objection::new(format!("{at}.key"), message));
            }
            ParameterSpace::new(vec![parameter.build()]).map_err(|error| {
                let (key, message) = match (&error, parameter.prior) {
                    (Error::Bounds { .. }, _) => ("low", error.to_string()),
                    (Error::OutOfBounds { .. }, PriorScene::Normal { median, .. }) => {
                        let (low, high) = (parameter.low, parameter.high);
                        let message =
                            format!("the median is {median}; it must lie between {low} and {high}");
                        ("prior.normal.median", message)
                    }
                    _ => ("prior.normal.standard_deviation", error.to_string()),
                };
                Objection::new(format!("{at}.{key}"), message)
            })?;
        }
        let all = self.parameters.iter().map(ParameterScene::build).collect();
        ParameterSpace::new(all).map_err(|error| Objection::new("parameters", error.to_string()))
    }
}

impl ParameterScene {
    fn build(&self) -> Parameter {
        let scale = self.scale.into();
        let prior = match self.prior {
            PriorScene::Uniform => Prior::Uniform,
            PriorScene::Normal { median, standard_deviation } => {
                let mean = if scale == Scale::Linear { median } else { median.ln() };
                Prior::Normal { mean, standard_deviation }
            }
        };
        Parameter { name: self.key.clone(), scale, low: self.low, high: self.high, prior }
    }
}

fn counted(key: &str, value: u64, least: u64, why: &str) -> Result<(), Objection> {
    if value < least {
        let message = format!("{value} is too few: at least {least}");
        return Err(Objection::new(key, message).with_help(why));
    }
    if value > MOST {
        return Err(Objection::new(key, format!("{value} is too many: at most {MOST}")));
    }
    Ok(())
}
