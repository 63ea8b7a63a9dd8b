//! The building of a scene, and the ground beneath it.

use scene_runs::scene::Objection;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use vibrating_systems::Error;
use vibrating_systems::{
    CloughPenzienParameters, Ground, Hysteresis, KanaiTajimiParameters, ShearBuilding,
    ShearBuildingParameters, Storey, Window,
};

/// A shear building; lists hold the storeys from the ground upwards.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct BuildingScene {
    /// `m_i`, the masses of the floors (kg).
    pub mass: Vec<f64>,
    /// `k_i`, the stiffness of the storeys before yielding (N/m).
    pub stiffness: Vec<f64>,
    /// The damping.
    pub damping: DampingScene,
    /// Hysteresis of the storeys.
    pub hysteresis: HysteresisScene,
}

/// Damping of a building.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
#[schemars(example = Self::Storeys(vec![80_000.0, 80_000.0]))]
pub enum DampingScene {
    /// Proportional to masses and stiffness, by the damping ratios of two modes before yielding.
    Rayleigh {
        /// The two modes, counted from 1, increasing (no unit).
        modes: [usize; 2],
        /// Their damping over the critical one (no unit).
        ratios: [f64; 2],
    },
    /// `c_i`, the damping of each storey (N s/m).
    Storeys(Vec<f64>),
}

/// Hysteresis of the storeys.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
#[schemars(example = Self::None)]
#[schemars(example = Self::Bilinear { post_yield_ratio: 0.05, yield_drift: vec![0.01, 0.008] })]
pub enum HysteresisScene {
    /// Linear springs.
    None,
    /// The loop of Bouc and Wen, `z' = u' (1 - (beta sign(u' z) + 1 - beta) |z/x_y|^n)`.
    BoucWen {
        /// `alpha`, the stiffness after yielding over that before, from 0 to 1 (no unit).
        post_yield_ratio: f64,
        /// `x_y`, the yield drift of each storey (m).
        yield_drift: Vec<f64>,
        /// `beta`, which widens the loop, from 0 to 1 (no unit).
        beta: f64,
        /// `n`, the sharpness of yielding (no unit).
        exponent: f64,
    },
    /// Elastic and perfectly plastic in parallel with a spring.
    Bilinear {
        /// `alpha`, the stiffness after yielding over that before, from 0 to 1 (no unit).
        post_yield_ratio: f64,
        /// `x_y`, the yield drift of each storey (m).
        yield_drift: Vec<f64>,
    },
}

/// The ground acceleration.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct GroundScene {
    /// What the white noise passes on its way to the building.
    pub soil: SoilScene,
    /// `S_0 >= 0`, intensity of the white noise, `E[W(t) W(t + tau)] = 2 S_0 delta(tau)` (m^2/s^3): `pi` times a two-sided spectral
    /// density per rad/s, a quarter of a one-sided one per Hz.
    pub noise_intensity: f64,
    /// `e(t)`, the modulating function of the white noise, before a filter.
    #[serde(default)]
    #[schemars(example = Window::SinglePeak { peak: 1.0, peak_time: 2.0 })]
    pub window: Window,
}

/// What the white noise passes on its way to the building.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
#[schemars(example = Self::None)]
#[schemars(example = Self::CloughPenzien { ground_frequency: 15.6, ground_damping: 0.6, low_cut_frequency: 1.5, low_cut_damping: 0.6 })]
pub enum SoilScene {
    /// Nothing: the ground acceleration is white noise.
    None,
    /// The soil of Kanai and Tajimi.
    KanaiTajimi {
        /// `omega_g`, the circular frequency of the soil; 15.6 for firm soil (rad/s).
        ground_frequency: f64,
        /// `zeta_g`, the damping ratio of the soil; 0.6 for firm soil (no unit).
        ground_damping: f64,
    },
    /// Soil and high-pass filter of Clough and Penzien.
    CloughPenzien {
        /// `omega_g`, the circular frequency of the soil; 15.6 for firm soil (rad/s).
        ground_frequency: f64,
        /// `zeta_g`, the damping ratio of the soil; 0.6 for firm soil (no unit).
        ground_damping: f64,
        /// `omega_f`, the low-cut frequency below which ground motion is filtered out (rad/s).
        low_cut_frequency: f64,
        /// `zeta_f`, the damping ratio of the low-cut filter (no unit).
        low_cut_damping: f64,
    },
}

impl BuildingScene {
    /// Builds and checks the building on its ground.
    pub(super) fn build(&self, ground: &GroundScene) -> Result<ShearBuilding, Objection> {
        self.check_lengths()?;
        let hysteresis = |i: usize| match &self.hysteresis {
            HysteresisScene::None => Hysteresis::None,
            &HysteresisScene::BoucWen { post_yield_ratio, ref yield_drift, beta, exponent } => {
                let yield_drift = yield_drift[i];
                Hysteresis::BoucWen { post_yield_ratio, yield_drift, beta, exponent }
            }
            &HysteresisScene::Bilinear { post_yield_ratio, ref yield_drift } => {
                Hysteresis::Bilinear { post_yield_ratio, yield_drift: yield_drift[i] }
            }
        };
        let storey = |i: usize| Storey {
            mass: self.mass[i],
            stiffness: self.stiffness[i],
            damping: match &self.damping {
                DampingScene::Storeys(damping) => damping[i],
                DampingScene::Rayleigh { .. } => 0.0,
            },
            hysteresis: hysteresis(i),
        };
        let build = || -> Result<ShearBuilding, Error> {
            let parameters = ShearBuildingParameters {
                storeys: (0..self.mass.len()).map(storey).collect(),
                mass_damping: 0.0,
                ground: ground.soil.build(),
                noise_intensity: ground.noise_intensity,
                window: ground.window.clone(),
            };
            ShearBuilding::new(match self.damping {
                DampingScene::Rayleigh { modes, ratios } => {
                    parameters.with_rayleigh_damping(modes, ratios)?
                }
                DampingScene::Storeys(_) => parameters,
            })
        };
        build().map_err(|error| objection(&error))
    }

    fn check_lengths(&self) -> Result<(), Objection> {
        let n = self.mass.len();
        let mut lists = vec![("stiffness", self.stiffness.len())];
        match &self.hysteresis {
            HysteresisScene::None => {}
            HysteresisScene::BoucWen { yield_drift, .. } => {
                lists.push(("hysteresis.bouc_wen.yield_drift", yield_drift.len()));
            }
            HysteresisScene::Bilinear { yield_drift, .. } => {
                lists.push(("hysteresis.bilinear.yield_drift", yield_drift.len()));
            }
        }
        if let DampingScene::Storeys(damping) = &self.damping {
            lists.push(("damping.storeys", damping.len()));
        }
        match lists.into_iter().find(|(_, length)| *length != n) {
            None => Ok(()),
            Some((key, length)) => {
                let message = format!("there are {length} entries; `mass` has {n}");
                Err(Objection::new(format!("building.{key}"), message))
            }
        }
    }
}

/// The objection at the key that an error names.
fn objection(error: &Error) -> Objection {
    let path = match error {
        Error::NotFinite { name, .. }
        | Error::NotPositive { name, .. }
        | Error::Negative { name, .. }
        | Error::OutOfRange { name, .. }
        | Error::OutOfOrder { name, .. } => match *name {
            "mass" | "stiffness" => format!("building.{name}"),
            "noise_intensity" => "ground.noise_intensity".to_owned(),
            "damping" | "modes" | "ratios" | "Rayleigh damping of these ratios" => {
                "building.damping".to_owned()
            }
            "post_yield_ratio" | "yield_drift" | "beta" | "exponent" => {
                "building.hysteresis".to_owned()
            }
            "ground_frequency" | "ground_damping" | "low_cut_frequency" | "low_cut_damping" => {
                "ground.soil".to_owned()
            }
            _ => "ground.window".to_owned(),
        },
        Error::TooFewRows { name: "storeys", .. } => "building.mass".to_owned(),
        _ => "ground".to_owned(),
    };
    Objection::new(path, error.to_string())
}

impl SoilScene {
    fn build(self) -> Ground {
        match self {
            Self::None => Ground::WhiteNoise,
            Self::KanaiTajimi { ground_frequency, ground_damping } => {
                Ground::KanaiTajimi(KanaiTajimiParameters { ground_frequency, ground_damping })
            }
            Self::CloughPenzien {
                ground_frequency,
                ground_damping,
                low_cut_frequency,
                low_cut_damping,
            } => Ground::CloughPenzien(CloughPenzienParameters {
                soil: KanaiTajimiParameters { ground_frequency, ground_damping },
                low_cut_frequency,
                low_cut_damping,
            }),
        }
    }
}
