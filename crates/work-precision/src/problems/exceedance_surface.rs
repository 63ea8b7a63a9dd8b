//! Reference surfaces `P(|q| > T)` over time and threshold.

use result_figures::Reference;
use serde::Deserialize;

use reference_problems::context::CaseError;

/// Smallest probability that counts.
pub(crate) const SMALLEST: f64 = 1e-6;

/// Probabilities of exceedance over times and thresholds, with their errors.
///
/// Its thresholds are such that the smallest probability at the last time is about [`SMALLEST`].
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct ExceedanceSurface {
    /// The times (s), at equal intervals.
    pub(crate) times: Vec<f64>,
    /// The thresholds (m).
    pub(crate) thresholds: Vec<f64>,
    /// Per time and threshold.
    values: Vec<Vec<f64>>,
    /// Their errors; a standard error where the values are sampled.
    errors: Vec<Vec<f64>>,
}

#[derive(Debug, Deserialize)]
struct File {
    viscous_damper: ExceedanceSurface,
    bouc_wen: ExceedanceSurface,
}

impl ExceedanceSurface {
    /// The oscillator with the viscous damper: a grid.
    pub(crate) fn viscous_damper() -> Result<Self, CaseError> {
        Ok(file()?.viscous_damper)
    }

    /// The Bouc-Wen oscillator: guided paths.
    pub(crate) fn bouc_wen() -> Result<Self, CaseError> {
        Ok(file()?.bouc_wen)
    }

    /// The cells of at least [`SMALLEST`]: index of time and threshold, and the reference.
    pub(crate) fn cells(&self) -> impl Iterator<Item = ((usize, usize), Reference)> {
        let of_time = |(time, (values, errors)): (usize, (&Vec<f64>, &Vec<f64>))| {
            let both: Vec<(f64, f64)> =
                values.iter().copied().zip(errors.iter().copied()).collect();
            both.into_iter().enumerate().map(move |(threshold, (value, error))| {
                ((time, threshold), Reference::uncertain(value, error))
            })
        };
        let all = self.values.iter().zip(&self.errors).enumerate().flat_map(of_time);
        all.filter(|(_, reference)| reference.value >= SMALLEST)
    }

    /// Largest relative error of the cells.
    pub(crate) fn relative_error(&self) -> f64 {
        let relative = |(_, reference): ((usize, usize), Reference)| {
            reference.error.unwrap_or(f64::INFINITY) / reference.value
        };
        self.cells().map(relative).fold(0.0, f64::max)
    }
}

fn file() -> Result<File, CaseError> {
    Ok(serde_json::from_str(include_str!(
        "../../../../tests/reference/derived/fpk/exceedance_surfaces.json"
    ))?)
}

#[cfg(test)]
mod tests {
    use reference_problems::fpk::reference::ReferenceTable;

    use super::*;

    /// Other programs, and other methods, at common times and thresholds; both errors are one standard deviation at most.
    #[test]
    fn the_surfaces_are_those_of_the_tables_where_they_meet() {
        for (surface, table) in [
            (ExceedanceSurface::viscous_damper(), ReferenceTable::viscous_damper()),
            (ExceedanceSurface::bouc_wen(), ReferenceTable::bouc_wen()),
        ] {
            let (surface, table) = (surface.unwrap(), table.unwrap());
            assert_eq!((surface.times.len(), surface.thresholds.len()), (8, 7));
            let mut n_common = 0;
            for ((time, threshold), found) in surface.cells() {
                let (t, level) = (surface.times[time], surface.thresholds[threshold]);
                let Some(expected) = table.exceedance(level, t) else { continue };
                let error = found.error.unwrap().hypot(expected.error.unwrap());
                let off = found.value - expected.value;
                assert!(off.abs() < 4.0 * error, "{t} {level}: {found:?} {expected:?}");
                n_common += 1;
            }
            assert!(n_common >= 3, "{n_common}");
            assert!(surface.cells().count() >= 30 && surface.relative_error() < 0.01);
            let smallest = surface.cells().map(|(_, found)| found.value).fold(1.0, f64::min);
            assert!((SMALLEST..2.0 * SMALLEST).contains(&smallest), "{smallest}");
        }
    }
}
