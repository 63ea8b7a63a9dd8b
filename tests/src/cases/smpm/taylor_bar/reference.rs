//! What was measured of recovered bars, and the benchmark of finite elements.

use serde::Deserialize;

use super::bar::Specimen;
use crate::cases::prelude::*;

/// The table of `tests/reference/published/smpm/taylor_impact.json`.
#[derive(Debug, Deserialize)]
pub(super) struct TaylorTests {
    pub(super) benchmark: Benchmark,
    pub(super) tests: Vec<Recovered>,
}

/// A bar with linear hardening that several finite element codes computed.
#[derive(Debug, Deserialize)]
pub(super) struct Benchmark {
    /// mm.
    pub(super) length: f64,
    /// mm.
    pub(super) radius: f64,
    /// m/s.
    pub(super) speed: f64,
    /// kg/m³.
    pub(super) density: f64,
    #[serde(rename = "young_modulus_GPa")]
    pub(super) young_modulus: f64,
    pub(super) poisson_ratio: f64,
    #[serde(rename = "yield_MPa")]
    pub(super) yield_stress: f64,
    #[serde(rename = "hardening_MPa")]
    pub(super) hardening_modulus: f64,
    #[serde(rename = "end_us")]
    pub(super) end: f64,
    /// mm.
    pub(super) final_length: f64,
    /// mm.
    pub(super) final_radius: f64,
}

/// A bar before and after its impact (mm, m/s, kg/m³).
#[derive(Debug, Deserialize)]
pub(super) struct Recovered {
    pub(super) name: String,
    pub(super) make: String,
    pub(super) material: String,
    pub(super) density: f64,
    pub(super) length: f64,
    pub(super) diameter: f64,
    pub(super) speed: f64,
    pub(super) final_length: f64,
    /// Diameter of the impact face.
    pub(super) foot: Option<f64>,
    /// Diameter a fifth of the first length above the wall.
    pub(super) bulge: Option<f64>,
}

impl TaylorTests {
    pub(super) fn read() -> CaseResult<Self> {
        let text = include_str!("../../../../reference/published/smpm/taylor_impact.json");
        Ok(serde_json::from_str(text)?)
    }
}

impl Benchmark {
    /// With so many cells to the radius.
    pub(super) const fn specimen(&self, cells: u32) -> Specimen {
        let Self { length, radius, speed, end, .. } = *self;
        Specimen { length, radius, speed: 1e-3 * speed, end, cells }
    }
}

impl Recovered {
    /// With so many cells to the radius, looked at in the end (us).
    pub(super) fn specimen(&self, cells: u32, end: f64) -> Specimen {
        Specimen {
            length: self.length,
            radius: 0.5 * self.diameter,
            speed: 1e-3 * self.speed,
            end,
            cells,
        }
    }
}
