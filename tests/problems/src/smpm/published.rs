//! Tables 6 to 8 of Chen et al. 2019 as printed, and the scene with the strength behind them.

use std::collections::BTreeMap;

use perturbation_moments::{Estimate, MonteCarlo};
use serde::Deserialize;
use smpm::uncertainty::{FrozenForm, Sampled, Series, Study};
use smpm::{Plan, Quantity};
use smpm_scenes::scene::{BoundaryKindScene, BoundaryScene, SideScene, SmpmScene, SolidScene};

use super::problems::{Problem, experiment};
use crate::context::CaseError;

/// The tables: name in the file of the print, symbol, quantity.
pub const TABLES: [(&str, &str, Quantity); 3] = [
    ("flow_stress", "σ_y", Quantity::FlowStress),
    ("deviator_11", "S11", Quantity::Deviator(0, 0)),
    ("deviator_22", "S22", Quantity::Deviator(1, 1)),
];

/// A printed row: means in Mbar, variances in Mbar^2.
#[derive(Debug, Clone, PartialEq)]
pub struct PrintedRow {
    /// Index in [`TABLES`].
    pub table: usize,
    /// Name of the gauge.
    pub gauge: String,
    /// Coefficient of variation of the five parameters.
    pub coefficient_of_variation: f64,
    /// Mean and variance in the column of the stochastic material point method.
    pub method: [f64; 2],
    /// Mean and variance in the column of Monte Carlo, 10,000 samples.
    pub monte_carlo: [f64; 2],
}

#[derive(Debug, Deserialize)]
struct File {
    tables: BTreeMap<String, Vec<FileRow>>,
}

/// Means in 1e-2 Mbar, variances in 1e-6 Mbar^2.
#[derive(Debug, Deserialize)]
struct FileRow {
    gauge: String,
    coefficient_of_variation: f64,
    mean_monte_carlo: f64,
    mean: f64,
    variance_monte_carlo: f64,
    variance: f64,
}

/// All 24 rows of Tables 6 to 8, in the order of [`TABLES`] and of the print.
///
/// # Errors
/// That of the JSON; a table that the file lacks.
pub fn printed() -> Result<Vec<PrintedRow>, CaseError> {
    let text = include_str!("../../../../tests/reference/published/smpm/chen_2019_tables.json");
    let file: File = serde_json::from_str(text)?;
    let mut rows = Vec::new();
    for (table, (name, ..)) in TABLES.into_iter().enumerate() {
        let read = file.tables.get(name).ok_or_else(|| format!("the file lacks {name}"))?;
        rows.extend(read.iter().map(|row| PrintedRow {
            table,
            gauge: row.gauge.clone(),
            coefficient_of_variation: row.coefficient_of_variation,
            method: [1e-2 * row.mean, 1e-6 * row.variance],
            monte_carlo: [1e-2 * row.mean_monte_carlo, 1e-6 * row.variance_monte_carlo],
        }));
    }
    Ok(rows)
}

/// The second example with the strength that reproduces Table 6: a reference rate of 1 per microsecond and no thermal
/// softening. Observed quantities are those of [`TABLES`], in order.
pub fn scene_as_printed(
    coefficient_of_variation: f64,
    times: &[f64],
) -> Result<SmpmScene, CaseError> {
    let mut scene = Problem::ContactExplosion.scene_with(coefficient_of_variation, times)?;
    scene.quantities = TABLES.iter().map(|(name, ..)| (*name).to_owned()).collect();
    let steel = scene.materials.get_mut("steel").and_then(|steel| steel.strength.as_mut());
    steel.ok_or("the plate has no strength")?.take_from("steel_as_published");
    Ok(scene)
}

/// A scene of an explosion with its water from `-half_length` to `half_length` and as high as `height` (cm), and the plate
/// as high.
pub fn widen(scene: &mut SmpmScene, half_length: f64, height: f64) {
    for body in &mut scene.bodies {
        if let SolidScene::Box { from, to } = &mut body.shape {
            match body.name.as_str() {
                "water" => (*from, *to) = (vec![-half_length, 0.0], vec![half_length, height]),
                "plate" => to[1] = height,
                _ => {}
            }
        }
        for except in &mut body.except {
            if let SolidScene::Box { from, to } = except
                && from[0] > 0.0
            {
                to[1] = height;
            }
        }
    }
}

/// Clamps the three edges of a scene of an explosion whose water ends at `half_length` and `height` (cm).
pub fn clamp(scene: &mut SmpmScene, half_length: f64, height: f64) {
    let edges = [
        (1, -half_length, SideScene::Above),
        (1, half_length, SideScene::Below),
        (2, height, SideScene::Below),
    ];
    let kind = BoundaryKindScene::Clamped;
    scene.boundaries.extend(edges.map(|(axis, position, side)| BoundaryScene {
        axis,
        position,
        side,
        kind,
    }));
}

/// The second example as printed, solved by the frozen formulas, by carried derivatives and by sampling.
#[derive(Debug)]
pub struct Solved {
    /// What was observed.
    pub plan: Plan<2>,
    /// Taylor moments by [`FrozenForm::Corrected`].
    pub frozen: Vec<Series>,
    /// Taylor moments by derivatives of the whole run.
    pub propagated: Vec<Series>,
    /// Whole runs.
    pub sampled: Sampled,
}

/// Mean (Mbar) and variance (Mbar^2) with their standard errors, zero for a Taylor series.
pub type MeanAndVariance = [(f64, f64); 2];

impl Solved {
    /// Solves the example at a coefficient of variation.
    pub fn new(
        coefficient_of_variation: f64,
        times: &[f64],
        n_samples: u64,
    ) -> Result<Self, CaseError> {
        let scene = scene_as_printed(coefficient_of_variation, times)?;
        let experiment = experiment::<2>(&scene)?;
        let study = Study::new(&experiment, scene.inputs()?, scene.plan::<2>()?)?;
        let frozen = study.frozen(FrozenForm::Corrected)?.into_iter().flatten().collect();
        let propagated = study.propagated()?.moments;
        let sampled = study.monte_carlo(MonteCarlo { seed: 2019, n_samples })?;
        Ok(Self { plan: study.plan().clone(), frozen, propagated, sampled })
    }

    /// The response of a table at a gauge and a time.
    ///
    /// # Errors
    /// A gauge or a time that was not observed.
    pub fn response(&self, table: usize, gauge: &str, time: f64) -> Result<usize, CaseError> {
        let gauge = self.plan.gauges.iter().position(|other| other.name == gauge);
        let window = self.plan.windows.iter().position(|window| (window.to - time).abs() < 1e-9);
        let (gauge, window) = gauge.zip(window).ok_or("not observed")?;
        Ok(self.plan.index(gauge, table, window))
    }

    /// Moments of a response by whole runs, with the carried derivatives as control variate.
    ///
    /// # Errors
    /// Too few samples.
    pub fn by_samples(&self, response: usize) -> Result<MeanAndVariance, CaseError> {
        let found = self.sampled.controlled(response, &self.propagated[response])?;
        let of =
            |estimate: Estimate| (estimate.value, estimate.standard_error().unwrap_or(f64::NAN));
        Ok([of(found.mean), of(found.variance)])
    }
}

/// Second-order mean and first-order variance of a Taylor series.
#[must_use]
pub fn by_series(moments: &Series) -> MeanAndVariance {
    [(moments.mean(), 0.0), (moments.variance(), 0.0)]
}

/// The one time at which all tables are compared (us): of `times` the one at which the largest relative distance of the
/// frozen mean of the flow stress from Table 6, over the rows of a coefficient of variation, is least.
///
/// # Errors
/// A time that was not observed.
pub fn one_time(
    solved: &Solved,
    coefficient_of_variation: f64,
    times: &[f64],
) -> Result<f64, CaseError> {
    let rows = printed()?;
    let of_table_6 = |row: &&PrintedRow| {
        row.table == 0 && (row.coefficient_of_variation - coefficient_of_variation).abs() < 1e-9
    };
    let mut nearest = (f64::INFINITY, f64::NAN);
    for &time in times {
        let mut apart = 0.0_f64;
        for row in rows.iter().filter(of_table_6) {
            let response = solved.response(row.table, &row.gauge, time)?;
            let mean = by_series(&solved.frozen[response])[0].0;
            apart = apart.max((mean / row.method[0] - 1.0).abs());
        }
        if apart < nearest.0 {
            nearest = (apart, time);
        }
    }
    Ok(nearest.1)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn all_24_rows_are_read_in_megabar() {
        let rows = printed().unwrap();
        assert_eq!(rows.len(), 24);
        let last = &rows[23];
        assert_eq!((last.table, last.gauge.as_str()), (2, "K"));
        assert!((last.method[0] - 0.0037983724).abs() < 1e-15, "{last:?}");
        assert!((last.monte_carlo[1] - 0.23554921e-6).abs() < 1e-18, "{last:?}");
    }
}
