//! The systems that a scene can name, and what of them holds whatever their dimension.

use fpk_sph::Error;
use fpk_sph::systems::{
    Bistable, BistableParameters, BoucWen, BoucWenParameters, CloughPenzienParameters,
    CoxIngersollRoss, CoxIngersollRossParameters, Duffing, DuffingParameters, Filter, Filtered,
    GeometricBrownianMotion, KanaiTajimiParameters, LinearOscillator, LinearOscillatorParameters,
    OrnsteinUhlenbeck, OrnsteinUhlenbeckParameters, TabulatedWindow, TwoStorey,
    TwoStoreyParameters, VanDerPolRayleigh, VanDerPolRayleighParameters, ViscousDamper,
    ViscousDamperParameters, Window,
};
use serde::{Deserialize, Serialize};

use super::paths::Paths;
use super::scene::System;
use crate::scene::Objection;

/// The system, by its name.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
pub enum SystemScene {
    /// `q'' + 2 xi w q' + w^2 q = a(t) W`.
    LinearOscillator(StructureScene),
    /// `q'' + 2 xi w q' + eta sign(q') |q'|^alpha + w^2 q = a(t) W` (Canor & Denoël 2013, eq 26).
    ViscousDamper(DamperScene),
    /// The hysteretic oscillator (Canor & Denoël 2013, eq 28).
    BoucWen(BoucWenScene),
    /// `q'' + 2 xi w q' + w^2 (q + epsilon q^3) = a(t) W`.
    Duffing {
        /// The oscillator without its cubic spring.
        structure: StructureScene,
        /// `epsilon`.
        cubic_stiffness: f64,
    },
    /// `q'' + (-a + b (w^2 q^2 + q'^2)) q' + w^2 q = W`.
    VanDerPol {
        /// `w` (rad/s).
        natural_frequency: f64,
        /// `a` (1/s).
        self_excitation: f64,
        /// `b`.
        energy_damping: f64,
        /// `S_0`.
        noise_intensity: f64,
        /// The window of the noise.
        window: WindowScene,
    },
    /// A shear frame of two storeys.
    TwoStorey(TwoStoreyScene),
    /// A structure behind the filter of Kanai and Tajimi.
    KanaiTajimi {
        /// The structure; its window modulates the ground motion.
        structure: ShakenScene,
        /// `omega_g` (rad/s).
        ground_frequency: f64,
        /// `zeta_g`.
        ground_damping: f64,
        /// The window of the white noise below the ground.
        #[serde(default)]
        noise_window: WindowScene,
    },
    /// A structure behind the filter of Clough and Penzien.
    CloughPenzien {
        /// The structure; its window modulates the ground motion.
        structure: ShakenScene,
        /// `omega_g` (rad/s).
        ground_frequency: f64,
        /// `zeta_g`.
        ground_damping: f64,
        /// `omega_f` (rad/s).
        low_cut_frequency: f64,
        /// `zeta_f`.
        low_cut_damping: f64,
        /// The window of the white noise below the ground.
        #[serde(default)]
        noise_window: WindowScene,
    },
    /// `dX = -Theta (X - m) dt + G dB` in one to four dimensions.
    OrnsteinUhlenbeck {
        /// `Theta`, row by row.
        rates: Vec<Vec<f64>>,
        /// `m`.
        mean: Vec<f64>,
        /// `G`, row by row.
        noise: Vec<Vec<f64>>,
    },
    /// `dX = (a X - b X^3) dt + sqrt(2 D) dB`.
    Bistable {
        /// `a`.
        growth: f64,
        /// `b`.
        cubic: f64,
        /// `D`.
        diffusion: f64,
    },
    /// `dX = kappa (theta - X) dt + sigma sqrt(X) dB`.
    CoxIngersollRoss {
        /// `kappa`.
        rate: f64,
        /// `theta`.
        mean: f64,
        /// `sigma`.
        volatility: f64,
    },
    /// `dX = mu X dt + sigma X dB`.
    GeometricBrownianMotion {
        /// `mu`.
        growth: f64,
        /// `sigma`.
        volatility: f64,
    },
}

/// A structure in its first mode.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
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

/// A structure with a nonlinear viscous damper.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct DamperScene {
    /// The structure.
    pub structure: StructureScene,
    /// `eta`.
    pub damper_coefficient: f64,
    /// `alpha`.
    pub damper_exponent: f64,
}

/// A hysteretic oscillator.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct BoucWenScene {
    /// `omega_0` (rad/s).
    pub natural_frequency: f64,
    /// `xi`.
    pub damping_ratio: f64,
    /// `alpha`, the share of the linear stiffness.
    pub hardening: f64,
    /// `A`.
    pub initial_slope: f64,
    /// `beta`.
    pub beta: f64,
    /// `gamma`.
    pub gamma: f64,
    /// `n`.
    pub exponent: f64,
    /// `S_0`.
    pub noise_intensity: f64,
    /// `a(t)`.
    pub window: WindowScene,
}

/// A building of two storeys; lists hold the lower storey first.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct TwoStoreyScene {
    /// `m_1, m_2`.
    pub mass: [f64; 2],
    /// `k_1, k_2`.
    pub stiffness: [f64; 2],
    /// `c_1, c_2`.
    pub damping: [f64; 2],
    /// `eta_1, eta_2`; 0 for none.
    pub damper_coefficient: [f64; 2],
    /// `alpha`.
    pub damper_exponent: f64,
    /// `S_0` of the ground acceleration.
    pub noise_intensity: f64,
    /// `a(t)`.
    pub window: WindowScene,
}

/// A structure behind a filter.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
pub enum ShakenScene {
    /// A linear oscillator.
    LinearOscillator(StructureScene),
    /// With a viscous damper.
    ViscousDamper(DamperScene),
    /// A hysteretic oscillator.
    BoucWen(BoucWenScene),
    /// A building of two storeys.
    TwoStorey(TwoStoreyScene),
}

/// The window of the noise.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
pub enum WindowScene {
    /// `a = 1`.
    #[default]
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
    /// Canor & Denoël 2013, eq 29.
    SinglePeak {
        /// `f_max`.
        peak: f64,
        /// `t_max` (s).
        peak_time: f64,
    },
    /// Linear between rows `[t, a]`.
    Tabulated(Vec<[f64; 2]>),
}

/// A system that has been checked, of any dimension.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub enum SceneSystem {
    /// See [`SystemScene`], here and below.
    LinearOscillator(LinearOscillator),
    /// A viscous damper.
    ViscousDamper(ViscousDamper),
    /// A hysteretic oscillator.
    BoucWen(BoucWen),
    /// A cubic spring.
    Duffing(Duffing),
    /// A self-excited oscillator.
    VanDerPol(VanDerPolRayleigh),
    /// A building of two storeys.
    TwoStorey(TwoStorey),
    /// A linear oscillator behind Kanai and Tajimi.
    KanaiTajimiLinear(Filtered<LinearOscillator, 2, 2>),
    /// A viscous damper behind Kanai and Tajimi.
    KanaiTajimiDamper(Filtered<ViscousDamper, 2, 2>),
    /// A hysteretic oscillator behind Kanai and Tajimi.
    KanaiTajimiBoucWen(Filtered<BoucWen, 3, 2>),
    /// A building behind Kanai and Tajimi.
    KanaiTajimiTwoStorey(Filtered<TwoStorey, 4, 2>),
    /// A linear oscillator behind Clough and Penzien.
    CloughPenzienLinear(Filtered<LinearOscillator, 2, 4>),
    /// A viscous damper behind Clough and Penzien.
    CloughPenzienDamper(Filtered<ViscousDamper, 2, 4>),
    /// Ornstein-Uhlenbeck in one dimension.
    OrnsteinUhlenbeck1(OrnsteinUhlenbeck<1>),
    /// In two.
    OrnsteinUhlenbeck2(OrnsteinUhlenbeck<2>),
    /// In three.
    OrnsteinUhlenbeck3(OrnsteinUhlenbeck<3>),
    /// In four.
    OrnsteinUhlenbeck4(OrnsteinUhlenbeck<4>),
    /// A double well.
    Bistable(Bistable),
    /// A square-root process.
    CoxIngersollRoss(CoxIngersollRoss),
    /// Geometric Brownian motion.
    GeometricBrownianMotion(GeometricBrownianMotion),
}

/// What is done with a system, whatever its type.
pub trait Visitor {
    /// What comes of it.
    type Output;

    /// Does it.
    fn visit<S, const D: usize, const M: usize>(self, system: &S) -> Self::Output
    where
        S: Paths<D, M>;
}

impl SceneSystem {
    /// Hands the system to a visitor as its own type.
    pub fn visit<V: Visitor>(&self, visitor: V) -> V::Output {
        match self {
            Self::LinearOscillator(system) => visitor.visit::<_, 2, 1>(system),
            Self::ViscousDamper(system) => visitor.visit::<_, 2, 1>(system),
            Self::BoucWen(system) => visitor.visit::<_, 3, 1>(system),
            Self::Duffing(system) => visitor.visit::<_, 2, 1>(system),
            Self::VanDerPol(system) => visitor.visit::<_, 2, 1>(system),
            Self::TwoStorey(system) => visitor.visit::<_, 4, 1>(system),
            Self::KanaiTajimiLinear(system) => visitor.visit::<_, 4, 1>(system),
            Self::KanaiTajimiDamper(system) => visitor.visit::<_, 4, 1>(system),
            Self::KanaiTajimiBoucWen(system) => visitor.visit::<_, 5, 1>(system),
            Self::KanaiTajimiTwoStorey(system) => visitor.visit::<_, 6, 1>(system),
            Self::CloughPenzienLinear(system) => visitor.visit::<_, 6, 1>(system),
            Self::CloughPenzienDamper(system) => visitor.visit::<_, 6, 1>(system),
            Self::OrnsteinUhlenbeck1(system) => visitor.visit::<_, 1, 1>(system),
            Self::OrnsteinUhlenbeck2(system) => visitor.visit::<_, 2, 2>(system),
            Self::OrnsteinUhlenbeck3(system) => visitor.visit::<_, 3, 3>(system),
            Self::OrnsteinUhlenbeck4(system) => visitor.visit::<_, 4, 4>(system),
            Self::Bistable(system) => visitor.visit::<_, 1, 1>(system),
            Self::CoxIngersollRoss(system) => visitor.visit::<_, 1, 1>(system),
            Self::GeometricBrownianMotion(system) => visitor.visit::<_, 1, 1>(system),
        }
    }

    /// The names of its states.
    #[must_use]
    pub fn states(&self) -> &'static [&'static str] {
        match self {
            Self::LinearOscillator(_)
            | Self::ViscousDamper(_)
            | Self::Duffing(_)
            | Self::VanDerPol(_) => &["q", "v"],
            Self::BoucWen(_) => &["q", "v", "z"],
            Self::TwoStorey(_) => &["q1", "q2", "v1", "v2"],
            Self::KanaiTajimiLinear(_) | Self::KanaiTajimiDamper(_) => &["q", "v", "xg", "vg"],
            Self::KanaiTajimiBoucWen(_) => &["q", "v", "z", "xg", "vg"],
            Self::KanaiTajimiTwoStorey(_) => &["q1", "q2", "v1", "v2", "xg", "vg"],
            Self::CloughPenzienLinear(_) | Self::CloughPenzienDamper(_) => {
                &["q", "v", "xg", "vg", "xf", "vf"]
            }
            Self::OrnsteinUhlenbeck1(_)
            | Self::Bistable(_)
            | Self::CoxIngersollRoss(_)
            | Self::GeometricBrownianMotion(_) => &["x"],
            Self::OrnsteinUhlenbeck2(_) => &["x1", "x2"],
            Self::OrnsteinUhlenbeck3(_) => &["x1", "x2", "x3"],
            Self::OrnsteinUhlenbeck4(_) => &["x1", "x2", "x3", "x4"],
        }
    }

    /// The time by which steps are measured: the shortest period of an oscillation, else a time of relaxation (s).
    #[must_use]
    pub fn reference_period(&self) -> f64 {
        let frame = |system: &TwoStorey| std::f64::consts::TAU / system.natural_frequencies()[1];
        match self {
            Self::LinearOscillator(system) => system.period(),
            Self::ViscousDamper(system) => system.period(),
            Self::BoucWen(system) => system.period(),
            Self::Duffing(system) => system.period(),
            Self::VanDerPol(system) => system.period(),
            Self::TwoStorey(system) => frame(system),
            Self::KanaiTajimiLinear(system) => {
                system.structure().period().min(system.filter().period())
            }
            Self::KanaiTajimiDamper(system) => {
                system.structure().period().min(system.filter().period())
            }
            Self::KanaiTajimiBoucWen(system) => {
                system.structure().period().min(system.filter().period())
            }
            Self::KanaiTajimiTwoStorey(system) => {
                frame(system.structure()).min(system.filter().period())
            }
            Self::CloughPenzienLinear(system) => {
                system.structure().period().min(system.filter().period())
            }
            Self::CloughPenzienDamper(system) => {
                system.structure().period().min(system.filter().period())
            }
            Self::OrnsteinUhlenbeck1(system) => fastest(&system.parameters().rates),
            Self::OrnsteinUhlenbeck2(system) => fastest(&system.parameters().rates),
            Self::OrnsteinUhlenbeck3(system) => fastest(&system.parameters().rates),
            Self::OrnsteinUhlenbeck4(system) => fastest(&system.parameters().rates),
            Self::Bistable(system) => std::f64::consts::TAU * system.relaxation_time(),
            Self::CoxIngersollRoss(system) => std::f64::consts::TAU / system.parameters().rate,
            // In units of its own time: nothing returns.
            Self::GeometricBrownianMotion(_) => 1.0,
        }
    }

    /// The stationary covariance of the filter's states, which come last.
    #[must_use]
    pub fn filter_covariance(&self) -> Option<Vec<Vec<f64>>> {
        fn rows<const F: usize>(covariance: &[[f64; F]; F]) -> Vec<Vec<f64>> {
            covariance.iter().map(|row| row.to_vec()).collect()
        }
        Some(match self {
            Self::KanaiTajimiLinear(system) => rows(system.filter().stationary_covariance()),
            Self::KanaiTajimiDamper(system) => rows(system.filter().stationary_covariance()),
            Self::KanaiTajimiBoucWen(system) => rows(system.filter().stationary_covariance()),
            Self::KanaiTajimiTwoStorey(system) => rows(system.filter().stationary_covariance()),
            Self::CloughPenzienLinear(system) => rows(system.filter().stationary_covariance()),
            Self::CloughPenzienDamper(system) => rows(system.filter().stationary_covariance()),
            _ => return None,
        })
    }

    /// The system, where it is one of the two of section 4.1 of the paper.
    #[must_use]
    pub fn plane(&self) -> Option<System> {
        match self {
            Self::LinearOscillator(system) => Some(System::Linear(system.clone())),
            Self::ViscousDamper(system) => Some(System::Damper(system.clone())),
            _ => None,
        }
    }
}

/// `2 pi` over the largest rate, a bound of the eigenvalues by the sums over rows.
fn fastest<const D: usize>(rates: &[[f64; D]; D]) -> f64 {
    let sums = rates.iter().map(|row| row.iter().map(|rate| rate.abs()).sum::<f64>());
    std::f64::consts::TAU / sums.fold(f64::MIN_POSITIVE, f64::max)
}

/// Why a scene's system could not be built: an error with the parameter it names, or a shape.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum SystemError {
    /// A parameter was refused.
    #[error(transparent)]
    Parameter(#[from] Error),
    /// A list has another length than the system has states.
    #[error("`{key}` has {count} entries; {wanted}")]
    Shape {
        /// The key.
        key: &'static str,
        /// How many entries it has.
        count: usize,
        /// What it should have.
        wanted: String,
    },
    /// Structure and filter have more states than the solver takes.
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
    /// The key that it is about, as it stands in a scene.
    fn key(&self) -> Option<&'static str> {
        match self {
            Self::Shape { key, .. } => Some(key),
            Self::TooManyStates { .. } => Some("structure"),
            Self::Parameter(error) => match error {
                Error::TooFewRows { .. } | Error::NotIncreasing { .. } => Some("tabulated"),
                Error::NotFinite { name, .. }
                | Error::NotPositive { name, .. }
                | Error::Negative { name, .. }
                | Error::OutOfRange { name, .. }
                    if name.ends_with(" of the window") =>
                {
                    Some("tabulated")
                }
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

impl SystemScene {
    /// The system, checked.
    ///
    /// # Errors
    /// [`SystemError`], naming the parameter.
    pub fn build(&self) -> Result<SceneSystem, SystemError> {
        Ok(match self {
            Self::LinearOscillator(structure) => SceneSystem::LinearOscillator(structure.build()?),
            Self::ViscousDamper(damper) => SceneSystem::ViscousDamper(damper.build()?),
            Self::BoucWen(hysteretic) => SceneSystem::BoucWen(hysteretic.build()?),
            Self::Duffing { structure, cubic_stiffness } => {
                let (structure, cubic_stiffness) = (structure.parameters()?, *cubic_stiffness);
                SceneSystem::Duffing(Duffing::new(DuffingParameters {
                    structure,
                    cubic_stiffness,
                })?)
            }
            &Self::VanDerPol {
                natural_frequency,
                self_excitation,
                energy_damping,
                noise_intensity,
                ref window,
            } => SceneSystem::VanDerPol(VanDerPolRayleigh::new(VanDerPolRayleighParameters {
                natural_frequency,
                self_excitation,
                energy_damping,
                noise_intensity,
                window: window.build()?,
            })?),
            Self::TwoStorey(frame) => SceneSystem::TwoStorey(frame.build()?),
            &Self::KanaiTajimi {
                ref structure,
                ground_frequency,
                ground_damping,
                ref noise_window,
            } => {
                let soil = KanaiTajimiParameters { ground_frequency, ground_damping };
                let (filter, window) = (Filter::kanai_tajimi(soil)?, noise_window.build()?);
                behind_kanai_tajimi(structure, filter, window)?
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
                let filter = Filter::clough_penzien(CloughPenzienParameters {
                    soil,
                    low_cut_frequency,
                    low_cut_damping,
                })?;
                behind_clough_penzien(structure, &filter, noise_window.build()?)?
            }
            Self::OrnsteinUhlenbeck { rates, mean, noise } => {
                ornstein_uhlenbeck(rates, mean, noise)?
            }
            &Self::Bistable { growth, cubic, diffusion } => {
                let parameters = BistableParameters { growth, cubic, diffusion };
                SceneSystem::Bistable(Bistable::new(parameters)?)
            }
            &Self::CoxIngersollRoss { rate, mean, volatility } => {
                let parameters = CoxIngersollRossParameters { rate, mean, volatility };
                SceneSystem::CoxIngersollRoss(CoxIngersollRoss::new(parameters)?)
            }
            &Self::GeometricBrownianMotion { growth, volatility } => {
                let system = GeometricBrownianMotion::new(growth, volatility)?;
                SceneSystem::GeometricBrownianMotion(system)
            }
        })
    }

    /// The objection to a system that could not be built, at the key that the error names.
    #[must_use]
    pub fn objection(&self, error: &SystemError) -> Objection {
        let tree = serde_json::to_value(self).unwrap_or_default();
        let path = error.key().and_then(|key| path_of(&tree, key));
        let path = path.map_or_else(|| "system".to_owned(), |path| format!("system.{path}"));
        Objection::new(path, error.to_string())
    }
}

/// The path of the first key of this name, from the outside inward.
fn path_of(tree: &serde_json::Value, key: &str) -> Option<String> {
    let object = tree.as_object()?;
    if object.contains_key(key) {
        return Some(key.to_owned());
    }
    object.iter().find_map(|(name, inner)| Some(format!("{name}.{}", path_of(inner, key)?)))
}

fn behind_kanai_tajimi(
    structure: &ShakenScene,
    filter: Filter<2>,
    window: Window,
) -> Result<SceneSystem, SystemError> {
    Ok(match structure {
        ShakenScene::LinearOscillator(structure) => {
            SceneSystem::KanaiTajimiLinear(Filtered::new(structure.build()?, filter, window)?)
        }
        ShakenScene::ViscousDamper(damper) => {
            SceneSystem::KanaiTajimiDamper(Filtered::new(damper.build()?, filter, window)?)
        }
        ShakenScene::BoucWen(hysteretic) => {
            SceneSystem::KanaiTajimiBoucWen(Filtered::new(hysteretic.build()?, filter, window)?)
        }
        ShakenScene::TwoStorey(frame) => {
            SceneSystem::KanaiTajimiTwoStorey(Filtered::new(frame.build()?, filter, window)?)
        }
    })
}

fn behind_clough_penzien(
    structure: &ShakenScene,
    filter: &Filter<4>,
    window: Window,
) -> Result<SceneSystem, SystemError> {
    let too_many = |structure, states| Err(SystemError::TooManyStates { structure, states });
    Ok(match structure {
        ShakenScene::LinearOscillator(structure) => {
            SceneSystem::CloughPenzienLinear(Filtered::new(structure.build()?, *filter, window)?)
        }
        ShakenScene::ViscousDamper(damper) => {
            SceneSystem::CloughPenzienDamper(Filtered::new(damper.build()?, *filter, window)?)
        }
        ShakenScene::BoucWen(_) => return too_many("hysteretic oscillator", 7),
        ShakenScene::TwoStorey(_) => return too_many("building of two storeys", 8),
    })
}

fn ornstein_uhlenbeck(
    rates: &[Vec<f64>],
    mean: &[f64],
    noise: &[Vec<f64>],
) -> Result<SceneSystem, SystemError> {
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
        1 => SceneSystem::OrnsteinUhlenbeck1(process(rates, mean, noise)?),
        2 => SceneSystem::OrnsteinUhlenbeck2(process(rates, mean, noise)?),
        3 => SceneSystem::OrnsteinUhlenbeck3(process(rates, mean, noise)?),
        4 => SceneSystem::OrnsteinUhlenbeck4(process(rates, mean, noise)?),
        count => {
            let wanted = "there must be 1 to 4".to_owned();
            return Err(SystemError::Shape { key: "mean", count, wanted });
        }
    })
}

/// A list of the length that its type asks for.
pub(super) fn list<const D: usize>(
    key: &'static str,
    values: &[f64],
) -> Result<[f64; D], SystemError> {
    let wanted = || format!("the system has {D} states");
    values.try_into().map_err(|_| SystemError::Shape { key, count: values.len(), wanted: wanted() })
}

/// A square matrix of the size that its type asks for.
pub(super) fn square<const D: usize>(
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

impl StructureScene {
    fn parameters(&self) -> Result<LinearOscillatorParameters, Error> {
        let &Self { natural_frequency, damping_ratio, noise_intensity, ref window } = self;
        let window = window.build()?;
        Ok(LinearOscillatorParameters { natural_frequency, damping_ratio, noise_intensity, window })
    }

    fn build(&self) -> Result<LinearOscillator, Error> {
        LinearOscillator::new(self.parameters()?)
    }
}

impl DamperScene {
    fn build(&self) -> Result<ViscousDamper, Error> {
        let &Self { ref structure, damper_coefficient, damper_exponent } = self;
        let structure = structure.parameters()?;
        ViscousDamper::new(ViscousDamperParameters {
            structure,
            damper_coefficient,
            damper_exponent,
        })
    }
}

impl BoucWenScene {
    fn build(&self) -> Result<BoucWen, Error> {
        let &Self {
            natural_frequency,
            damping_ratio,
            hardening,
            initial_slope,
            beta,
            gamma,
            exponent,
            noise_intensity,
            ref window,
        } = self;
        BoucWen::new(BoucWenParameters {
            natural_frequency,
            damping_ratio,
            hardening,
            initial_slope,
            beta,
            gamma,
            exponent,
            noise_intensity,
            window: window.build()?,
        })
    }
}

impl TwoStoreyScene {
    fn build(&self) -> Result<TwoStorey, Error> {
        let &Self {
            mass,
            stiffness,
            damping,
            damper_coefficient,
            damper_exponent,
            noise_intensity,
            ref window,
        } = self;
        TwoStorey::new(TwoStoreyParameters {
            mass,
            stiffness,
            damping,
            damper_coefficient,
            damper_exponent,
            noise_intensity,
            window: window.build()?,
        })
    }
}

impl WindowScene {
    fn build(&self) -> Result<Window, Error> {
        Ok(match *self {
            Self::Stationary => Window::Stationary,
            Self::RisePlateauDecay { rise_exponent, rise_end, decay_rate, decay_start } => {
                Window::RisePlateauDecay { rise_exponent, rise_end, decay_rate, decay_start }
            }
            Self::SinglePeak { peak, peak_time } => Window::SinglePeak { peak, peak_time },
            Self::Tabulated(ref rows) => Window::Tabulated(TabulatedWindow::new(rows)?),
        })
    }
}
