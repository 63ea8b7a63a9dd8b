//! Results at one time of observation.

use std::ops::Range;

use fpk_sph::observables::{CellIntegral, Probability};
use fpk_sph::{Correction, Error, Simulation};
use sde_integrators::Sde;
use serde::{Deserialize, Serialize};

use super::requested::Requested;

/// Three estimates of an exceedance probability.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Exceedances {
    /// Sum of the masses beyond the threshold (eq 25).
    pub indicator: f64,
    /// From the log-interpolated distribution.
    pub log_interpolated: f64,
    /// Integral over deformed cells; `None` if not requested.
    pub cell_integrated: Option<f64>,
    /// What that integral rests on, in words, where it is less than particles.
    pub note: Option<String>,
    /// Its error by the moment equations.
    pub offset: f64,
    /// What may lie beyond the threshold although no particle does: the second moment of the magnitude that is missing by the moment
    /// equations, over the square of the threshold (Markov's inequality).
    pub missing: f64,
}

/// Results at one time.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Row {
    /// The time.
    pub t: f64,
    /// Raw moments, in the requested order.
    pub moments: Vec<f64>,
    /// Moments of the absolute values, in the same order: scales of the errors.
    pub scales: Vec<f64>,
    /// Errors of the moments by the moment equations, in the same order.
    pub offsets: Vec<f64>,
    /// Relative error of standard deviations by the moment equations.
    pub violation: f64,
    /// Probabilities, in the order of the thresholds.
    pub exceedances: Vec<Exceedances>,
    /// Integrals over the cells at the thresholds beside those of the scene.
    pub beside: Vec<f64>,
    /// `sum mu_i`.
    pub total_mass: f64,
    /// Probability that no particle carries, at most.
    pub mass_outside: f64,
    /// Whether the cloud was remeshed.
    pub is_remeshed: bool,
    /// Entropy (nats).
    pub entropy: f64,
    /// Integral of the density over the cells, if requested.
    pub cell_mass: Option<f64>,
    /// CPU time of the solver so far (s), without observation.
    pub cpu_seconds: f64,
}

pub(super) fn observe<S: Sde<D, M>, const D: usize, const M: usize>(
    simulation: &Simulation<S, D, M>,
    asked: &Requested<D>,
    correction: Option<Correction<D>>,
    cpu_seconds: f64,
) -> Result<Row, Error> {
    let cells = asked.cells.then(|| simulation.cell_integral()).transpose()?;
    let corrected = |x: &[f64; D]| correction.map_or(*x, |correction| correction.of(x));
    let (exceedances, beside) = exceedances(simulation, cells.as_ref(), asked, &corrected)?;
    let moments: Vec<f64> = asked.powers.iter().map(|&it| simulation.raw_moment(it)).collect();
    let offset = |(moment, &powers): (&f64, &[u32; D])| {
        moment - simulation.expectation(|x| monomial(powers, &corrected(x)))
    };
    Ok(Row {
        t: simulation.time(),
        offsets: moments.iter().zip(&asked.powers).map(offset).collect(),
        scales: asked.powers.iter().map(|&it| simulation.absolute_moment(it)).collect(),
        violation: correction.map_or(0.0, |correction| correction.relative_change()),
        moments,
        exceedances,
        beside,
        total_mass: simulation.total_mass(),
        mass_outside: simulation.mass_outside(),
        is_remeshed: simulation.n_remaps() > 0,
        entropy: simulation.entropy()?,
        cell_mass: cells.as_ref().map(CellIntegral::total_mass),
        cpu_seconds,
    })
}

/// At the thresholds of the scene, and over the cells at those beside them.
fn exceedances<S: Sde<D, M>, const D: usize, const M: usize>(
    simulation: &Simulation<S, D, M>,
    cells: Option<&CellIntegral<D>>,
    asked: &Requested<D>,
    corrected: &dyn Fn(&[f64; D]) -> [f64; D],
) -> Result<(Vec<Exceedances>, Vec<f64>), Error> {
    let magnitude = |x: &[f64; D]| asked.demand.magnitude(x);
    let thresholds = [&asked.thresholds[..], &thresholds_beside(&asked.thresholds)].concat();
    let over_cells = cells.map(|cells| cells.exceedances(magnitude, &thresholds));
    let over_cells = over_cells.transpose()?.unwrap_or_default();
    let beside = over_cells.iter().skip(asked.thresholds.len());
    let beside = beside.map(|over| estimate(over.probability())).collect();
    let at = |(k, &threshold): (usize, &f64)| {
        let over_cells = over_cells.get(k);
        let log_interpolated = simulation.exceedance_log_interpolated(magnitude, threshold)?;
        let moved = |x: &[f64; D]| magnitude(&corrected(x));
        let change = |x: &[f64; D]| moved(x).powi(2) - magnitude(x).powi(2);
        let missing = simulation.expectation(change).abs() / threshold.powi(2);
        Ok(Exceedances {
            indicator: simulation.exceedance_indicator(magnitude, threshold)?,
            log_interpolated,
            offset: log_interpolated - simulation.exceedance_log_interpolated(moved, threshold)?,
            cell_integrated: over_cells.map(|over| estimate(over.probability())),
            note: over_cells.and_then(|over| note(over.probability())),
            // Every magnitude is beyond the threshold zero.
            missing: if threshold > 0.0 { missing } else { 0.0 },
        })
    };
    let exceedances: Result<_, Error> = asked.thresholds.iter().enumerate().map(at).collect();
    Ok((exceedances?, beside))
}

/// Ratios to a threshold of those beside it, below and above (no unit).
const BESIDE: [Range<f64>; 2] = [0.5..0.95, 1.05..2.0];

/// Ratios of the thresholds that are taken where a scene asks none below its own (no unit).
const TAKEN: [f64; 2] = [0.85, 1.15];

/// Whether the error of a probability at one threshold says something about that at another.
///
/// The difference of two runs may change its sign at a threshold, where it says nothing; it hardly does at one beside it as well.
pub(crate) fn is_beside(other: f64, threshold: f64) -> bool {
    BESIDE.iter().any(|ratios| ratios.contains(&(other / threshold)))
}

/// Thresholds beside those of a scene that have none of the scene below them: one above may be too far in the tail to say much.
pub(crate) fn thresholds_beside(asked: &[f64]) -> Vec<f64> {
    let is_alone = |threshold: &&f64| {
        **threshold > 0.0 && !asked.iter().any(|other| BESIDE[0].contains(&(other / **threshold)))
    };
    let alone = asked.iter().filter(is_alone);
    alone.flat_map(|threshold| TAKEN.map(|taken| taken * threshold)).collect()
}

/// `x_1^a_1 .. x_D^a_D`.
pub(crate) fn monomial<const D: usize>(powers: [u32; D], x: &[f64; D]) -> f64 {
    let power = |base: f64, exponent: u32| (0..exponent).fold(1.0, |product, _| product * base);
    x.iter().zip(powers).map(|(&x, a)| power(x, a)).product()
}

/// What a probability rests on, where it is less than particles.
fn note(probability: Probability) -> Option<String> {
    probability.resolved().is_none().then(|| probability.basis())
}

/// The estimate whatever it rests on, for a record that has the note next to it and for comparison with a reference.
#[must_use]
pub const fn estimate(probability: Probability) -> f64 {
    match probability {
        Probability::Resolved(estimate)
        | Probability::Truncated { estimate, .. }
        | Probability::Extrapolated { estimate, .. }
        | Probability::Unresolved { estimate, .. }
        | Probability::Below { estimate, .. } => estimate,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn thresholds_are_taken_beside_lone_ones_only() {
        assert_eq!(thresholds_beside(&[1.0]), [0.85, 1.15]);
        assert_eq!(thresholds_beside(&[1.0, 1.25, 3.0]), [0.85, 1.15, 0.85 * 3.0, 1.15 * 3.0]);
        // Equal ones and those close by change their sign together.
        assert_eq!(thresholds_beside(&[1.0, 1.01]), [0.85, 1.15, 0.85 * 1.01, 1.15 * 1.01]);
        assert!(thresholds_beside(&[0.0]).is_empty());
        assert!(is_beside(0.8, 1.0) && is_beside(1.25, 1.0) && !is_beside(1.01, 1.0));
    }
}
