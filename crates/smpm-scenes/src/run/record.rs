//! Keys of `result.json` of a scene of bodies: schema `response-moments/1`.

use scene_runs::scene::NamedFile;
use serde::Serialize;
use smpm::{Plan, Quantity};

use super::balance::BalanceRecord;
use super::levels::multilevel_record::MultilevelRecord;
use super::response::Response;
use crate::random_fields::PreparedField;
use crate::scene::SmpmScene;

/// Keys that this kind adds to every result: schema `response-moments/1`.
#[derive(Debug, Serialize)]
pub(super) struct Content {
    pub(super) work: WorkRecord,
    /// Files that the scene names.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub(super) files: Vec<NamedFile>,
    /// Where the bodies differ from those of the scene, and what a reader must know of the estimate.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub(super) notes: Vec<String>,
    /// Samples that failed, and why.
    pub(super) failures: Vec<Failure>,
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub(super) random_fields: Vec<FieldResult>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) multilevel: Option<MultilevelRecord>,
    /// Of the reference run at the start and at each time; absent with multilevel.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub(super) balance: Vec<BalanceRecord>,
    pub(super) gauges: Vec<GaugeResult>,
}

/// Expansion of a random field.
#[derive(Debug, Serialize)]
pub(super) struct FieldResult {
    pub(super) parameters: Vec<String>,
    pub(super) terms: usize,
    /// Variance of the normal field that the terms leave out, mean over its box: the error of its correlation.
    ///
    /// The field is then scaled to unit variance, so that the distribution at one point is exact.
    pub(super) mean_left_out_variance: f64,
    /// The largest at a particle.
    pub(super) largest_left_out_variance: f64,
}

/// Work counters.
#[derive(Debug, Serialize)]
pub(super) struct WorkRecord {
    pub(super) particles: usize,
    pub(super) steps: usize,
    /// Number of complete runs, including those with derivatives.
    pub(super) runs: u64,
    pub(super) cpu_seconds: f64,
}

/// A sample that failed.
#[derive(Debug, Clone, Serialize)]
pub(super) struct Failure {
    pub(super) sample: u64,
    pub(super) reason: String,
}

/// All quantities at a gauge.
#[derive(Debug, Serialize)]
pub(super) struct GaugeResult {
    pub(super) name: String,
    pub(super) quantities: Vec<QuantityResult>,
}

/// A quantity over time.
#[derive(Debug, Serialize)]
pub(super) struct QuantityResult {
    pub(super) name: String,
    pub(super) unit: &'static str,
    pub(super) values: Vec<Response>,
}

impl FieldResult {
    pub(super) fn of(field: &PreparedField) -> Self {
        let [mean_left_out_variance, largest_left_out_variance] = field.left_out;
        let (parameters, terms) = (field.parameters.clone(), field.n_terms);
        Self { parameters, terms, mean_left_out_variance, largest_left_out_variance }
    }
}

/// Responses by gauge and quantity.
pub(super) fn by_gauge<const D: usize>(
    scene: &SmpmScene,
    plan: &Plan<D>,
    responses: &[Response],
) -> Vec<GaugeResult> {
    let quantity = |g: usize, (q, quantity): (usize, &Quantity)| QuantityResult {
        name: quantity.to_string(),
        unit: scene.units.of(*quantity),
        values: (0..plan.windows.len()).map(|w| responses[plan.index(g, q, w)].clone()).collect(),
    };
    let gauge = |(g, gauge): (usize, &smpm::Gauge<D>)| GaugeResult {
        name: gauge.name.clone(),
        quantities: plan.quantities.iter().enumerate().map(|q| quantity(g, q)).collect(),
    };
    plan.gauges.iter().enumerate().map(gauge).collect()
}
