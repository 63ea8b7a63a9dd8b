//! Systems that a scene can name, and their properties in any dimension.

use scene_runs::scene::Objection;
use schemars::JsonSchema;
use sde_integrators::{Additive, Sde};
use serde::{Deserialize, Serialize};
use vibrating_systems::Error;
use vibrating_systems::{
    Bistable, BistableParameters, BoucWen, BoucWenParameters, CloughPenzienParameters,
    CoxIngersollRoss, CoxIngersollRossParameters, Duffing, DuffingParameters, Filter, Filtered,
    GeometricBrownianMotion, KanaiTajimiParameters, LinearOscillator, LinearOscillatorParameters,
    OrnsteinUhlenbeck, OrnsteinUhlenbeckParameters, TwoStorey, TwoStoreyParameters,
    VanDerPolRayleigh, VanDerPolRayleighParameters, ViscousDamper, ViscousDamperParameters, Window,
};

use crate::system::System;

/// The system, by its name.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
#[schemars(example = Self::clough_penzien())]
#[schemars(example = Self::kanai_tajimi())]
#[schemars(example = Self::ornstein_uhlenbeck())]
#[schemars(example = Self::Bistable { growth: 1.0, cubic: 1.0, diffusion: 0.25 })]
#[schemars(example = Self::CoxIngersollRoss { rate: 1.0, mean: 1.0, volatility: 0.3 })]
#[schemars(example = Self::GeometricBrownianMotion { growth: 0.1, volatility: 0.3 })]
pub enum SystemScene {
    /// `q'' + 2 xi w q' + w^2 q = a(t) W`.
    LinearOscillator(LinearOscillatorParameters),
    /// `q'' + 2 xi w q' + eta sign(q') |q'|^alpha + w^2 q = a(t) W` (Canor & Denoël 2013, eq 26).
    ViscousDamper(ViscousDamperParameters),
    /// The hysteretic oscillator (Canor & Denoël 2013, eq 28).
    BoucWen(BoucWenParameters),
    /// `q'' + 2 xi w q' + w^2 (q + epsilon q^3) = a(t) W`.
    Duffing(DuffingParameters),
    /// `q'' + (-a + b (w^2 q^2 + q'^2)) q' + w^2 q = W` (van der Pol, Rayleigh).
    VanDerPol {
        /// `w`, the natural circular frequency (rad/s).
        natural_frequency: f64,
        /// `a`, the negative damping at rest (1/s).
        self_excitation: f64,
        /// `b`, the damping that grows with the energy (s/m^2).
        energy_damping: f64,
        /// `S_0 >= 0`, intensity of the white noise, `E[W(t) W(t + tau)] = 2 S_0 delta(tau)` (m^2/s^3): `pi` times a two-sided spectral
        /// density per rad/s, a quarter of a one-sided one per Hz.
        noise_intensity: f64,
        /// Modulating function of the noise.
        window: Window,
    },
    /// A shear frame of two storeys, with dampers between its floors.
    TwoStorey(TwoStoreyParameters),
    /// A structure behind a Kanai-Tajimi filter.
    KanaiTajimi {
        /// The structure; its modulating function acts on the ground motion.
        structure: ShakenScene,
        /// `omega_g`, the circular frequency of the soil; 15.6 for firm soil (rad/s).
        ground_frequency: f64,
        /// `zeta_g`, the damping ratio of the soil; 0.6 for firm soil (no unit).
        ground_damping: f64,
        /// Modulating function of the white noise at the bedrock.
        #[serde(default)]
        noise_window: Window,
    },
    /// A structure behind a Clough-Penzien filter.
    CloughPenzien {
        /// The structure; its modulating function acts on the ground motion.
        structure: ShakenScene,
        /// `omega_g`, the circular frequency of the soil; 15.6 for firm soil (rad/s).
        ground_frequency: f64,
        /// `zeta_g`, the damping ratio of the soil; 0.6 for firm soil (no unit).
        ground_damping: f64,
        /// `omega_f`, the low-cut frequency below which ground motion is filtered out (rad/s).
        low_cut_frequency: f64,
        /// `zeta_f`, the damping ratio of the low-cut filter (no unit).
        low_cut_damping: f64,
        /// Modulating function of the white noise at the bedrock.
        #[serde(default)]
        noise_window: Window,
    },
    /// `dX = -Theta (X - m) dt + G dB` in one to four dimensions.
    OrnsteinUhlenbeck {
        /// `Theta`, the relaxation rates, row by row (1/s).
        rates: Vec<Vec<f64>>,
        /// `m`, the mean (unit of each state).
        mean: Vec<f64>,
        /// `G`, row by row (unit of each state per s^0.5).
        noise: Vec<Vec<f64>>,
    },
    /// `dX = (a X - b X^3) dt + sqrt(2 D) dB`, with two wells for `a > 0`; `u` is the unit of `X`.
    Bistable {
        /// `a`, the growth at the origin (1/s).
        growth: f64,
        /// `b`, the cubic restoring force (1/(u^2 s)).
        cubic: f64,
        /// `D`, the diffusion (u^2/s).
        diffusion: f64,
    },
    /// `dX = kappa (theta - X) dt + sigma sqrt(X) dB`; `u` is the unit of `X`.
    CoxIngersollRoss {
        /// `kappa`, the relaxation rate (1/s).
        rate: f64,
        /// `theta`, the mean (u).
        mean: f64,
        /// `sigma`, the intensity of the noise (u^0.5/s^0.5).
        volatility: f64,
    },
    /// `dX = mu X dt + sigma X dB`.
    GeometricBrownianMotion {
        /// `mu`, the growth (1/s).
        growth: f64,
        /// `sigma`, the intensity of the noise (1/s^0.5).
        volatility: f64,
    },
}

/// A structure behind a filter.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
pub enum ShakenScene {
    /// A linear oscillator.
    LinearOscillator(LinearOscillatorParameters),
    /// A linear oscillator with a viscous damper.
    ViscousDamper(ViscousDamperParameters),
    /// A hysteretic oscillator.
    BoucWen(BoucWenParameters),
    /// An oscillator with a cubic spring.
    Duffing(DuffingParameters),
    /// A building of two storeys.
    TwoStorey(TwoStoreyParameters),
}

impl ShakenScene {
    const fn window(&self) -> &Window {
        match self {
            Self::LinearOscillator(structure) => &structure.window,
            Self::ViscousDamper(damper) => &damper.structure.window,
            Self::BoucWen(hysteretic) => &hysteretic.window,
            Self::Duffing(hardening) => &hardening.structure.window,
            Self::TwoStorey(frame) => &frame.window,
        }
    }
}

/// Why the system of a scene could not be built: an invalid parameter or list.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum SystemError {
    /// A parameter is invalid.
    #[error(transparent)]
    Parameter(#[from] Error),
    /// The length of a list is not the number of states.
    #[error("`{key}` has {count} entries; {wanted}")]
    Shape {
        /// The key.
        key: &'static str,
        /// Number of its entries.
        count: usize,
        /// Required number.
        wanted: String,
    },
    /// Structure and filter have more states than the solver supports.
    #[error(
        "a {structure} behind this filter has {states} states; the density solver takes 6 at most"
    )]
    TooManyStates {
        /// The structure.
        structure: &'static str,
        /// States of both.
        states: usize,
    },
}

impl SystemError {
    /// The key of the error, as in a scene.
    fn key(&self) -> Option<&'static str> {
        match self {
            Self::Shape { key, .. } => Some(key),
            Self::TooManyStates { .. } => Some("structure"),
            Self::Parameter(error) => match error {
                Error::NotFinite { name, .. }
                | Error::NotPositive { name, .. }
                | Error::Negative { name, .. }
                | Error::OutOfRange { name, .. }
                | Error::OutOfOrder { name, .. } => Some(name),
                _ => None,
            },
        }
    }
}

/// Modulating function of the examples.
const RISE: Window = Window::RisePlateauDecay {
    rise_exponent: 1.0,
    rise_end: 2.0,
    decay_rate: 2.0,
    decay_start: 6.0,
};

/// Examples for the schema and the page of scenes; no built-in scene shows them.
impl SystemScene {
    fn clough_penzien() -> Self {
        let structure = LinearOscillatorParameters {
            natural_frequency: 3.0,
            damping_ratio: 0.05,
            noise_intensity: 0.2,
            window: RISE,
        };
        Self::CloughPenzien {
            structure: ShakenScene::LinearOscillator(structure),
            ground_frequency: 15.6,
            ground_damping: 0.6,
            low_cut_frequency: 1.5,
            low_cut_damping: 0.6,
            noise_window: Window::Stationary,
        }
    }

    fn kanai_tajimi() -> Self {
        let frame = TwoStoreyParameters {
            mass: [1.0, 1.0],
            stiffness: [40.0, 40.0],
            damping: [0.4, 0.4],
            damper_coefficient: [0.25, 0.0],
            damper_exponent: 0.5,
            noise_intensity: 0.2,
            window: Window::Stationary,
        };
        Self::KanaiTajimi {
            structure: ShakenScene::TwoStorey(frame),
            ground_frequency: 15.6,
            ground_damping: 0.6,
            noise_window: RISE,
        }
    }

    fn ornstein_uhlenbeck() -> Self {
        Self::OrnsteinUhlenbeck {
            rates: vec![vec![1.0, 0.5], vec![0.0, 2.0]],
            mean: vec![0.0, 0.0],
            noise: vec![vec![0.5, 0.0], vec![0.0, 0.5]],
        }
    }
}

impl SystemScene {
    /// Builds and checks the system.
    ///
    /// # Errors
    /// [`SystemError`] with the name of the parameter.
    pub fn build(&self) -> Result<System, SystemError> {
        Ok(match self {
            Self::LinearOscillator(structure) => {
                System::LinearOscillator(LinearOscillator::new(structure.clone())?)
            }
            Self::ViscousDamper(damper) => {
                System::ViscousDamper(ViscousDamper::new(damper.clone())?)
            }
            Self::BoucWen(hysteretic) => System::BoucWen(BoucWen::new(hysteretic.clone())?),
            Self::Duffing(hardening) => System::Duffing(Duffing::new(hardening.clone())?),
            &Self::VanDerPol {
                natural_frequency,
                self_excitation,
                energy_damping,
                noise_intensity,
                ref window,
            } => System::VanDerPol(VanDerPolRayleigh::new(VanDerPolRayleighParameters {
                natural_frequency,
                self_excitation,
                energy_damping,
                noise_intensity,
                window: window.clone(),
            })?),
            Self::TwoStorey(frame) => System::TwoStorey(TwoStorey::new(frame.clone())?),
            &Self::KanaiTajimi {
                ref structure,
                ground_frequency,
                ground_damping,
                ref noise_window,
            } => {
                let soil = KanaiTajimiParameters { ground_frequency, ground_damping };
                behind_kanai_tajimi(structure, soil, noise_window)?
            }
            &Self::CloughPenzien {
                ref structure,
                ground_frequency,
                ground_damping,
                low_cut_frequency,
                low_cut_damping,
                ref noise_window,
            } => {
                let soil = KanaiTajimiParameters { ground_frequency, ground_damping };
                let filter = CloughPenzienParameters { soil, low_cut_frequency, low_cut_damping };
                behind_clough_penzien(structure, filter, noise_window)?
            }
            Self::OrnsteinUhlenbeck { rates, mean, noise } => {
                ornstein_uhlenbeck(rates, mean, noise)?
            }
            &Self::Bistable { growth, cubic, diffusion } => {
                let parameters = BistableParameters { growth, cubic, diffusion };
                System::Bistable(Bistable::new(parameters)?)
            }
            &Self::CoxIngersollRoss { rate, mean, volatility } => {
                let parameters = CoxIngersollRossParameters { rate, mean, volatility };
                System::CoxIngersollRoss(CoxIngersollRoss::new(parameters)?)
            }
            &Self::GeometricBrownianMotion { growth, volatility } => {
                let system = GeometricBrownianMotion::new(growth, volatility)?;
                System::GeometricBrownianMotion(system)
            }
        })
    }

    /// Whether it is a structure with a cubic spring behind a filter.
    #[must_use]
    pub fn shakes_cubic_spring(&self) -> bool {
        let (Self::KanaiTajimi { structure, .. } | Self::CloughPenzien { structure, .. }) = self
        else {
            return false;
        };
        matches!(structure, ShakenScene::Duffing(hardening) if hardening.cubic_stiffness > 0.0)
    }

    /// Times at which a modulating function has a kink.
    #[must_use]
    pub fn kinks(&self) -> Vec<f64> {
        match self {
            Self::LinearOscillator(structure) => structure.window.kinks(),
            Self::ViscousDamper(damper) => damper.structure.window.kinks(),
            Self::BoucWen(hysteretic) => hysteretic.window.kinks(),
            Self::Duffing(hardening) => hardening.structure.window.kinks(),
            Self::TwoStorey(frame) => frame.window.kinks(),
            Self::VanDerPol { window, .. } => window.kinks(),
            Self::KanaiTajimi { structure, noise_window, .. }
            | Self::CloughPenzien { structure, noise_window, .. } => {
                [structure.window().kinks(), noise_window.kinks()].concat()
            }
            Self::OrnsteinUhlenbeck { .. }
            | Self::Bistable { .. }
            | Self::CoxIngersollRoss { .. }
            | Self::GeometricBrownianMotion { .. } => Vec::new(),
        }
    }

    /// The objection for a system error, at the key that it names.
    #[must_use]
    pub fn objection(&self, error: &SystemError) -> Objection {
        let tree = serde_json::to_value(self).unwrap_or_default();
        let path = error.key().and_then(|key| path_of(&tree, key));
        let path = path.map_or_else(|| "system".to_owned(), |path| format!("system.{path}"));
        Objection::new(path, error.to_string())
    }
}

/// Path of the first key of this name, from the outermost inwards.
fn path_of(tree: &serde_json::Value, key: &str) -> Option<String> {
    let object = tree.as_object()?;
    if object.contains_key(key) {
        return Some(key.to_owned());
    }
    object.iter().find_map(|(name, inner)| Some(format!("{name}.{}", path_of(inner, key)?)))
}

fn behind_kanai_tajimi(
    structure: &ShakenScene,
    soil: KanaiTajimiParameters,
    window: &Window,
) -> Result<System, SystemError> {
    use ShakenScene as Shaken;
    let filter = Filter::kanai_tajimi(soil)?;
    Ok(match structure.clone() {
        Shaken::LinearOscillator(structure) => {
            System::KanaiTajimiLinear(behind(LinearOscillator::new(structure), filter, window)?)
        }
        Shaken::ViscousDamper(damper) => {
            System::KanaiTajimiDamper(behind(ViscousDamper::new(damper), filter, window)?)
        }
        Shaken::BoucWen(hysteretic) => {
            System::KanaiTajimiBoucWen(behind(BoucWen::new(hysteretic), filter, window)?)
        }
        Shaken::Duffing(hardening) => {
            System::KanaiTajimiDuffing(behind(Duffing::new(hardening), filter, window)?)
        }
        Shaken::TwoStorey(frame) => {
            System::KanaiTajimiTwoStorey(behind(TwoStorey::new(frame), filter, window)?)
        }
    })
}

fn behind_clough_penzien(
    structure: &ShakenScene,
    filter: CloughPenzienParameters,
    window: &Window,
) -> Result<System, SystemError> {
    use ShakenScene as Shaken;
    let filter = Filter::clough_penzien(filter)?;
    let too_many = |structure, states| Err(SystemError::TooManyStates { structure, states });
    Ok(match structure.clone() {
        Shaken::LinearOscillator(structure) => {
            System::CloughPenzienLinear(behind(LinearOscillator::new(structure), filter, window)?)
        }
        Shaken::ViscousDamper(damper) => {
            System::CloughPenzienDamper(behind(ViscousDamper::new(damper), filter, window)?)
        }
        Shaken::Duffing(hardening) => {
            System::CloughPenzienDuffing(behind(Duffing::new(hardening), filter, window)?)
        }
        Shaken::BoucWen(_) => return too_many("hysteretic oscillator", 7),
        Shaken::TwoStorey(_) => return too_many("building of two storeys", 8),
    })
}

/// A structure behind a filter of a noise with a modulating function.
fn behind<S: Sde<DS, 1, Noise = Additive>, const DS: usize, const DF: usize>(
    structure: Result<S, Error>,
    filter: Filter<DF>,
    window: &Window,
) -> Result<Filtered<S, DS, DF>, Error> {
    Filtered::new(structure?, filter, window.clone())
}

fn ornstein_uhlenbeck(
    rates: &[Vec<f64>],
    mean: &[f64],
    noise: &[Vec<f64>],
) -> Result<System, SystemError> {
    fn process<const D: usize>(
        rates: &[Vec<f64>],
        mean: &[f64],
        noise: &[Vec<f64>],
    ) -> Result<OrnsteinUhlenbeck<D>, SystemError> {
        Ok(OrnsteinUhlenbeck::new(OrnsteinUhlenbeckParameters {
            rates: square("rates", rates)?,
            mean: list("mean", mean)?,
            noise: square("noise", noise)?,
        })?)
    }
    Ok(match mean.len() {
        1 => System::OrnsteinUhlenbeck1(process(rates, mean, noise)?),
        2 => System::OrnsteinUhlenbeck2(process(rates, mean, noise)?),
        3 => System::OrnsteinUhlenbeck3(process(rates, mean, noise)?),
        4 => System::OrnsteinUhlenbeck4(process(rates, mean, noise)?),
        count => {
            let wanted = "there must be 1 to 4".to_owned();
            return Err(SystemError::Shape { key: "mean", count, wanted });
        }
    })
}

/// A list of the length that its type requires.
pub(crate) fn list<const D: usize>(
    key: &'static str,
    values: &[f64],
) -> Result<[f64; D], SystemError> {
    let wanted = || format!("the system has {D} states");
    values.try_into().map_err(|_| SystemError::Shape { key, count: values.len(), wanted: wanted() })
}

/// A square matrix of the size that its type requires.
pub(crate) fn square<const D: usize>(
    key: &'static str,
    rows: &[Vec<f64>],
) -> Result<[[f64; D]; D], SystemError> {
    let wanted = || format!("the system has {D} states");
    if rows.len() != D {
        return Err(SystemError::Shape { key, count: rows.len(), wanted: wanted() });
    }
    let mut matrix = [[0.0; D]; D];
    for (row, values) in matrix.iter_mut().zip(rows) {
        *row = list(key, values)?;
    }
    Ok(matrix)
}

#[cfg(test)]
mod tests {
    use schemars::schema_for;

    use super::*;

    #[test]
    fn the_systems_that_the_schema_shows_can_be_built() {
        let schema = schema_for!(SystemScene);
        let systems: Vec<SystemScene> =
            serde_json::from_value(schema.get("examples").cloned().unwrap_or_default()).unwrap();
        assert!(!systems.is_empty());
        for system in systems {
            assert!(system.build().is_ok(), "{system:?}");
        }
    }
}
