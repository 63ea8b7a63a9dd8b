//! Posterior prediction: plates at draws of the posterior beside those that were measured.

use crack_inference::Summaries;
use peridyn_sde::statistics::{CrackRecord, SummaryConfig};
use peridyn_sde::{CrackPath, Error};
use scene_runs::answers::Number;
use scene_runs::kind::RunError;
use sde_integrators::{Estimate, Noise, Purpose, Uncertainty};
use serde::Serialize;

use super::ensembles::Ended;
use crate::crack_inference::measured::summaries;
use crate::run::rank;

/// Probabilities of the ends of a band and of its middle.
const BAND: [f64; 3] = [0.05, 0.5, 0.95];

/// Predicted values of one number of a plate.
#[derive(Debug, Clone, Copy, Serialize)]
pub(super) struct Band {
    /// Number of values.
    values: usize,
    /// The quantile of 5 %, with the error that finite draws and realisations leave.
    pub(super) low: Number,
    pub(super) median: Number,
    /// The quantile of 95 %.
    pub(super) high: Number,
}

/// A summary of the measured plates beside its prediction.
#[derive(Debug, Serialize)]
pub(super) struct Compared {
    pub(super) summary: String,
    /// Share of the measured values inside the band.
    pub(super) inside: Number,
    /// Whether so few are inside by accident in less than one case of 500, or more than half are farther from the band than its width.
    pub(super) is_outside: bool,
    #[serde(flatten)]
    pub(super) band: Band,
    /// Number of measured values inside the band, and of all.
    #[serde(skip)]
    counts: [u64; 2],
}

/// Predicted heights of the crack at an abscissa.
#[derive(Debug, Serialize)]
pub(super) struct PathBand {
    pub(super) x: f64,
    #[serde(flatten)]
    pub(super) band: Band,
}

/// Plates at draws of the posterior, measured with the errors of the measured ones.
#[derive(Debug)]
pub(super) struct Predicted<'a> {
    /// Ensembles at the draws.
    pub(super) ensembles: &'a [Ended],
    pub(super) summaries: &'a SummaryConfig,
    /// Standard deviations of the errors of measurement, one for each summary.
    pub(super) errors: &'a [f64],
    /// Standard deviation of that of a height (m).
    pub(super) height_error: f64,
    pub(super) seed: u64,
}

impl Predicted<'_> {
    /// Each summary of the measured plates, by its name, beside its predicted band.
    pub(super) fn compare(
        &self,
        measured: &Summaries,
        names: &[String],
    ) -> Result<Vec<Compared>, RunError> {
        let k = measured.n_summaries();
        // The values by summary, draw and realisation.
        let mut values = vec![Vec::new(); k];
        for ended in self.ensembles {
            let rows = summaries(self.summaries, &ended.records)?;
            let mut of_draw = vec![Vec::new(); k];
            // A stream for each row, by the number of the first realisation of its draw.
            let first = ended.records.first().map_or(0, |record| record.realisation);
            for (number, row) in (first..).zip(rows.rows()) {
                let normals = self.normals(number, 0, k);
                for i in 0..k {
                    of_draw[i].push(row[i] + self.errors[i] * normals[i]);
                }
            }
            for (values, of_draw) in values.iter_mut().zip(of_draw) {
                values.push(of_draw);
            }
        }
        let compared = |(i, values): (usize, &Vec<Vec<f64>>)| {
            let band = band(values)?;
            let inside = |row: &&[f64]| (band.low.value..=band.high.value).contains(&row[i]);
            let width = band.high.value - band.low.value;
            let near = band.low.value - width..=band.high.value + width;
            let n_far = measured.rows().filter(|row| !near.contains(&row[i])).count();
            let counts @ [inside, plates] =
                [measured.rows().filter(inside).count(), measured.n_realisations()]
                    .map(|count| count as u64);
            let is_outside = 2 * n_far as u64 > plates || at_most(inside, plates) < ACCIDENT;
            let inside = Estimate::probability(inside, plates).map_err(RunError::solver);
            let summary = names[i].clone();
            Some(inside.map(|inside| Compared {
                summary,
                inside: inside.into(),
                is_outside,
                band,
                counts,
            }))
        };
        values.iter().enumerate().filter_map(compared).collect()
    }

    /// Bands of the height of the crack at abscissae that at least half of the cracks come to.
    pub(super) fn heights(&self, abscissae: &[f64]) -> Result<Vec<PathBand>, Error> {
        let mut values = vec![Vec::new(); abscissae.len()];
        let mut n_cracks = 0;
        for ended in self.ensembles {
            let mut of_draw = vec![Vec::new(); abscissae.len()];
            for record in ended.records.iter().filter(|record| record.outcome.counts()) {
                n_cracks += 1;
                let normals = self.normals(record.realisation, 1, abscissae.len());
                for (i, height) in heights(record, abscissae)?.into_iter().enumerate() {
                    of_draw[i].extend(height.map(|y| y + self.height_error * normals[i]));
                }
            }
            for (values, of_draw) in values.iter_mut().zip(of_draw) {
                values.push(of_draw);
            }
        }
        let bands = abscissae.iter().zip(&values);
        let bands = bands.filter_map(|(&x, values)| Some(PathBand { x, band: band(values)? }));
        Ok(bands.filter(|at| 2 * at.band.values >= n_cracks).collect())
    }

    /// Standard normals of a realisation.
    fn normals(&self, number: u64, kind: u64, n: usize) -> Vec<f64> {
        let mut stream = Noise::new(self.seed).stream(Purpose::Bootstrap, 2 * number + kind);
        let mut normals = vec![0.0; n];
        stream.fill_normal(&mut normals);
        normals
    }
}

fn heights(record: &CrackRecord, abscissae: &[f64]) -> Result<Vec<Option<f64>>, Error> {
    if record.path.is_empty() {
        return Ok(vec![None; abscissae.len()]);
    }
    let path = CrackPath::from_points(record.path.clone())?;
    Ok(abscissae.iter().map(|&x| path.height_at(x)).collect())
}

/// Probability of so few values inside the bands by accident, below which they are outside.
const ACCIDENT: f64 = 2e-3;

/// Probability that of `n` values at most so many are inside a band of 90 %: binomial.
fn at_most(inside: u64, n: u64) -> f64 {
    let (mut term, mut sum) = (0.1_f64.powf(n as f64), 0.0);
    for k in 0..=inside {
        sum += term;
        term *= 9.0 * (n - k) as f64 / (k + 1) as f64;
    }
    sum
}

/// Share of all measured values that lie inside their bands.
///
/// Its error is that of as many independent values as there are plates, since the values of one plate depend on each other; for none
/// or all inside it is the bound `3/P`.
pub(super) fn share(compared: &[Compared]) -> Option<Estimate> {
    let plates = compared.iter().map(|it| it.counts[1]).min()? as f64;
    let [inside, all] = [0, 1].map(|k| compared.iter().map(|it| it.counts[k]).sum::<u64>());
    Estimate::share(inside as f64 / all as f64, plates).ok()
}

/// The band of values by draw; none without values.
///
/// Standard errors by the jackknife that leaves out a draw at a time with all its realisations:
/// `s^2 = (D - 1)/D sum_j (q_j - q)^2`, with `q_j` the quantile without draw `j` and `q` their mean (Shao and Wu 1989).
fn band(by_draw: &[Vec<f64>]) -> Option<Band> {
    let all = quantiles(by_draw.iter())?;
    let without = |left_out: usize| {
        let others = by_draw.iter().enumerate().filter(|(draw, _)| *draw != left_out);
        quantiles(others.map(|(_, values)| values))
    };
    let without: Option<Vec<[f64; 3]>> = (0..by_draw.len()).map(without).collect();
    let quantile = |k: usize| {
        let error = without.as_ref().map(|without| {
            let n = without.len() as f64;
            let mean = without.iter().map(|q| q[k]).sum::<f64>() / n;
            let squares = without.iter().map(|q| (q[k] - mean).powi(2)).sum::<f64>();
            ((n - 1.0) / n * squares).sqrt()
        });
        let uncertainty = error.map_or(Uncertainty::Unknown, Uncertainty::StandardError);
        Estimate { value: all[k], uncertainty }
    };
    let [low, median, high] = [0, 1, 2].map(|k| quantile(k).into());
    Some(Band { values: by_draw.iter().map(Vec::len).sum(), low, median, high })
}

/// Quantiles at [`BAND`]; none without values.
fn quantiles<'a>(values: impl Iterator<Item = &'a Vec<f64>>) -> Option<[f64; 3]> {
    let mut all: Vec<f64> = values.flatten().copied().collect();
    all.sort_unstable_by(f64::total_cmp);
    let [low, middle, high] = BAND.map(|p| rank(&all, p));
    Some([low?, middle?, high?])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_band_has_the_quantiles_of_all_draws_and_the_error_of_leaving_one_out() {
        let by_draw: Vec<Vec<f64>> =
            (0..5).map(|draw| (0..20).map(|k| f64::from(5 * k + draw)).collect()).collect();
        let Band { values, low, median, high } = band(&by_draw).unwrap();
        // 0 to 99: ranks 5, 50 and 95.
        assert_eq!((values, [low, median, high].map(|it| it.value)), (100, [4.0, 49.0, 94.0]));
        // Without draw 4 the value of rank 4 of 80 is 3; without another one it is 4.
        let error = low.error.unwrap();
        let expected = (0.8 * (4.0 * 0.2_f64.powi(2) + 0.8_f64.powi(2))).sqrt();
        assert!((error - expected).abs() < 1e-12, "{error}");
        assert!(band(&[vec![], vec![]]).is_none());
    }

    #[test]
    fn few_values_inside_are_an_accident_as_often_as_the_binomial_distribution_says() {
        // 0.1^3; 1 - 0.9^2; all.
        for (inside, n, expected) in [(0, 3, 1e-3), (1, 2, 0.19), (16, 16, 1.0)] {
            assert!((at_most(inside, n) - expected).abs() < 1e-12);
        }
        assert!(at_most(11, 16) > ACCIDENT && at_most(9, 16) < ACCIDENT);
    }

    #[test]
    fn the_share_counts_plates_and_not_values() {
        let number = Number::sampled(0.5, None);
        let band = Band { values: 1, low: number, median: number, high: number };
        let of = |inside| Compared {
            summary: String::new(),
            inside: number,
            band,
            is_outside: false,
            counts: [inside, 10],
        };
        let found = share(&[of(10), of(8)]).unwrap();
        assert_eq!(found, Estimate::probability(9, 10).unwrap());
        assert_eq!(share(&[of(10)]).unwrap().uncertainty, Uncertainty::Bound(0.3));
        assert_eq!(share(&[]), None);
    }
}
