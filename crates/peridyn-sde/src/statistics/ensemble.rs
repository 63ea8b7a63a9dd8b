//! Statistics over the records of an ensemble.

use sde_integrators::{Accumulator, Estimate, Samples, Uncertainty};

use super::{Bootstrap, CrackOutcome, CrackRecord, Interval, QUANTILES};
use crate::error::{Error, at_least, finite};
use crate::path::height_at;

/// The records of all realisations of an ensemble, from number 0 on.
#[derive(Debug, Clone, PartialEq)]
pub struct CrackEnsemble {
    records: Vec<CrackRecord>,
}

/// What is known of the law of a number from the realisations that have it.
#[derive(Debug, Clone, PartialEq)]
pub struct Distribution {
    /// How many realisations have it.
    pub n: usize,
    /// How many do not: cracks that did not come so far or do not count, and loads not observed.
    pub missing: usize,
    /// The mean with its standard error.
    pub mean: Estimate,
    /// The standard deviation with its bootstrap interval; none for fewer than 10 values.
    pub deviation: Option<Interval>,
    /// The quantiles of [`QUANTILES`], each the value of rank `ceil(n p)`; with a standard error where 10 values are expected on
    /// either side, unknown where not: of 5 % from 200 values on.
    pub quantiles: [Estimate; 5],
}

/// Where cracks pass an abscissa.
#[derive(Debug, Clone, PartialEq)]
pub struct Band {
    /// The abscissa (length).
    pub x: f64,
    /// The share of the realisations that count whose crack comes there.
    pub reach: Estimate,
    /// The heights at which those cross it; none where fewer than two do.
    pub heights: Option<Distribution>,
}

impl CrackEnsemble {
    /// From the records of all shards, in any order.
    ///
    /// # Errors
    /// [`Error::TooFew`] for no realisation, [`Error::NoSuchRealisation`], [`Error::Doubled`], [`Error::Missing`] for a number that
    /// is not below `n_realisations`, there twice, or not there; [`Error::Parameter`] for a number in a record.
    pub fn new(
        n_realisations: u64,
        records: impl IntoIterator<Item = CrackRecord>,
    ) -> Result<Self, Error> {
        let mut records: Vec<CrackRecord> = records.into_iter().collect();
        records.sort_by_key(|record| record.realisation);
        for record in &records {
            record.check()?;
        }
        if n_realisations == 0 {
            return Err(Error::TooFew { name: "realisations", value: 0, limit: 1 });
        }
        if let Some(pair) = records.windows(2).find(|w| w[0].realisation == w[1].realisation) {
            return Err(Error::Doubled { realisation: pair[0].realisation });
        }
        if let Some(last) = records.last().filter(|last| last.realisation >= n_realisations) {
            let (realisation, limit) = (last.realisation, n_realisations);
            return Err(Error::NoSuchRealisation { realisation, limit });
        }
        let gap = (0..).zip(&records).find(|(id, record)| *id != record.realisation);
        let missing = gap.map_or(records.len() as u64, |(id, _)| id);
        if missing < n_realisations {
            return Err(Error::Missing { realisation: missing, n_realisations });
        }
        Ok(Self { records })
    }

    /// All records, by their numbers.
    #[must_use]
    pub fn records(&self) -> &[CrackRecord] {
        &self.records
    }

    /// The records whose crack counts.
    pub fn counted(&self) -> impl Iterator<Item = &CrackRecord> {
        self.records.iter().filter(|record| record.outcome.counts())
    }

    /// Records without a valid crack: broken prescribed edges, bodies in pieces, failed runs.
    pub fn failures(&self) -> impl Iterator<Item = &CrackRecord> {
        self.records.iter().filter(|record| !record.outcome.counts())
    }

    /// The probability of each outcome, by [`CrackOutcome::name`], of all realisations.
    ///
    /// # Errors
    /// None that can occur: there is a realisation.
    pub fn outcomes(&self) -> Result<Vec<(&'static str, Estimate)>, Error> {
        let of = |&name: &&'static str| {
            let hits = self.records.iter().filter(|record| record.outcome.name() == name).count();
            Ok((name, probability(hits, self.records.len())?))
        };
        CrackOutcome::NAMES.iter().map(of).collect()
    }

    /// The heights at which cracks that count first come to an abscissa, by realisation.
    #[must_use]
    pub fn heights(&self, x: f64) -> Vec<f64> {
        self.counted().filter_map(|record| height_at(&record.path, x)).collect()
    }

    /// Where cracks pass each of some abscissae.
    ///
    /// # Errors
    /// [`Error::Parameter`] for an abscissa, [`Error::TooFew`] where no realisation counts.
    pub fn bands(&self, abscissae: &[f64], bootstrap: &Bootstrap) -> Result<Vec<Band>, Error> {
        let n = self.counted().count();
        let band = |&x: &f64| {
            finite("an abscissa", x)?;
            let heights = self.heights(x);
            let reach = probability(heights.len(), n)?;
            let heights = match heights.len() {
                0 | 1 => None,
                _ => Some(self.distribution(&heights, bootstrap)?),
            };
            Ok(Band { x, reach, heights })
        };
        abscissae.iter().map(band).collect()
    }

    /// The law of the exit.
    ///
    /// # Errors
    /// [`Error::TooFew`] for fewer than two realisations that count and have one.
    pub fn exit(&self, bootstrap: &Bootstrap) -> Result<Distribution, Error> {
        let exits: Vec<f64> = self.counted().filter_map(|record| record.exit).collect();
        self.distribution(&exits, bootstrap)
    }

    /// The law of the length, zero where no crack grew.
    ///
    /// # Errors
    /// As [`CrackEnsemble::exit`].
    pub fn length(&self, bootstrap: &Bootstrap) -> Result<Distribution, Error> {
        let lengths: Vec<f64> = self.counted().map(|record| record.length).collect();
        self.distribution(&lengths, bootstrap)
    }

    /// The law of the failure load.
    ///
    /// # Errors
    /// As [`CrackEnsemble::exit`].
    pub fn failure_load(&self, bootstrap: &Bootstrap) -> Result<Distribution, Error> {
        let loads: Vec<f64> = self.counted().filter_map(|record| record.failure_load).collect();
        self.distribution(&loads, bootstrap)
    }

    fn distribution(&self, values: &[f64], bootstrap: &Bootstrap) -> Result<Distribution, Error> {
        let n = values.len();
        let too_few = |_| Error::TooFew { name: "realisations with a value", value: n, limit: 2 };
        let mut sample = Accumulator::default();
        for &value in values {
            sample.push(value);
        }
        let mean = sample.estimate().map_err(too_few)?;
        let samples = Samples::new(values.to_vec()).map_err(too_few)?;
        let enough = n >= Bootstrap::LEAST_VALUES;
        let deviation = if enough { Some(bootstrap.deviation(values)?) } else { None };
        let quantiles = QUANTILES.map(|p| quantile(&samples, p));
        Ok(Distribution { n, missing: self.records.len() - n, mean, deviation, quantiles })
    }
}

fn quantile(samples: &Samples, p: f64) -> Estimate {
    samples.quantile(p).unwrap_or_else(|_| {
        let values = samples.values();
        #[allow(
            clippy::cast_possible_truncation,
            clippy::cast_sign_loss,
            reason = "a rank, from 1 to the number of values"
        )]
        let rank = (values.len() as f64 * p).ceil().max(1.0) as usize;
        Estimate { value: values[rank - 1], uncertainty: Uncertainty::Unknown }
    })
}

fn probability(hits: usize, trials: usize) -> Result<Estimate, Error> {
    at_least("realisations that count", trials, 1)?;
    let too_few = |_| Error::TooFew { name: "realisations that count", value: trials, limit: 1 };
    Estimate::probability(hits as u64, trials as u64).map_err(too_few)
}

#[cfg(test)]
mod tests {
    use sde_integrators::Noise;

    use super::*;
    use crate::path::CrackPath;

    /// Straight cracks from (0, 0) that rise by `k/n`: at x the heights are x k/n. Every fifth ends at x = 0.5; the load is 10 k.
    fn record(k: u64, n: u64) -> CrackRecord {
        let end = if k % 5 == 4 { 0.5 } else { 1.0 };
        let slope = k as f64 / n as f64;
        let path = CrackPath::from_points(vec![[0.0; 2], [end, end * slope]]).unwrap();
        CrackRecord::of_path(k, Some(&path), Some(1.0), Some(10.0 * k as f64))
    }

    fn ensemble(n: u64) -> CrackEnsemble {
        CrackEnsemble::new(n, (0..n).map(|k| record(k, n))).unwrap()
    }

    fn bootstrap() -> Bootstrap {
        Bootstrap::new(Noise::new(11))
    }

    #[test]
    fn bands_tell_how_many_cracks_come_how_far_and_where() {
        let bands = ensemble(400).bands(&[0.4, 0.8, 1.2], &bootstrap()).unwrap();
        let [near, far, beyond] = &bands[..] else { unreachable!() };
        assert!(near.reach.value >= 1.0);
        assert_eq!(far.reach, Estimate::probability(320, 400).unwrap());
        assert!(beyond.reach.value <= 0.0 && beyond.heights.is_none());
        let heights = near.heights.as_ref().unwrap();
        // Heights 0.4 k/400 for k from 0 to 399: the value of rank ceil(400 p) is 0.4 (p - 1/400).
        for (quantile, p) in heights.quantiles.iter().zip(QUANTILES) {
            assert!((quantile.value - 0.4 * (p - 0.0025)).abs() < 1e-12, "{quantile}");
            // Uniform: sqrt(p (1 - p)/400) of the range, rounded to ranks.
            let expected = 0.4 * (p * (1.0 - p) / 400.0).sqrt();
            assert!((quantile.standard_error().unwrap() - expected).abs() < 0.0011, "{quantile}");
        }
        // The deviation of a uniform law: the range over sqrt(12), within 2 in 400 for the lattice of its values.
        let deviation = heights.deviation.unwrap();
        assert!((deviation.value - 0.4 / 12_f64.sqrt()).abs() < 0.0006);
        assert!(deviation.low < deviation.value && deviation.value < deviation.high);
        assert_eq!(
            (far.heights.as_ref().unwrap().n, far.heights.as_ref().unwrap().missing),
            (320, 80)
        );
    }

    #[test]
    fn exits_lengths_and_loads_have_their_laws() {
        let ensemble = ensemble(100);
        let exit = ensemble.exit(&bootstrap()).unwrap();
        assert_eq!((exit.n, exit.missing), (80, 20));
        // 80 of 100 values: of 5 % no error is known, of the quartiles it is.
        let known: Vec<bool> =
            exit.quantiles.iter().map(|quantile| quantile.standard_error().is_some()).collect();
        assert_eq!(known, [false, true, true, true, false]);
        // Rank 4 of the slopes 0, 0.01, 0.02, 0.03, 0.05.
        assert!((exit.quantiles[0].value - 0.03).abs() < 1e-12);
        let load = ensemble.failure_load(&bootstrap()).unwrap();
        // Of 0, 10, ..., 990.
        assert!((load.mean.value - 495.0).abs() < 1e-10 && load.n == 100);
        let deviation = (10_f64 * 10.0 * (100.0 * 101.0) / 12.0).sqrt();
        assert!((load.deviation.unwrap().value - deviation).abs() < 1e-10);
        assert!((load.mean.standard_error().unwrap() - deviation / 10.0).abs() < 1e-11);
        assert_eq!(ensemble.length(&bootstrap()).unwrap().missing, 0);
    }

    #[test]
    fn shards_in_any_order_give_the_same_bits() {
        let whole = ensemble(60);
        let shards = [40..60, 0..25, 25..40];
        let mixed = shards.into_iter().flat_map(|ids| ids.rev().map(|k| record(k, 60)));
        let mixed = CrackEnsemble::new(60, mixed).unwrap();
        assert_eq!(mixed, whole);
        let bands = |of: &CrackEnsemble| of.bands(&[0.3, 0.9], &bootstrap()).unwrap();
        assert_eq!(bands(&mixed), bands(&whole));
    }

    #[test]
    fn failures_are_counted_and_named_and_leave_the_statistics() {
        let mut records: Vec<CrackRecord> = (0..20).map(|k| record(k, 20)).collect();
        records[3].outcome = CrackOutcome::GripsBroken;
        records[7] = CrackRecord::without_crack(7, CrackOutcome::Failed("step 3: NaN".into()));
        records[8] = CrackRecord::of_path(8, None, Some(1.0), None);
        let ensemble = CrackEnsemble::new(20, records).unwrap();
        let failed: Vec<u64> = ensemble.failures().map(|record| record.realisation).collect();
        assert_eq!(failed, [3, 7]);
        let outcomes = ensemble.outcomes().unwrap();
        let shares: Vec<(&str, f64)> =
            outcomes.iter().map(|(name, share)| (*name, (share.value * 20.0).round())).collect();
        let expected = [
            ("through", 13.0),
            ("arrested", 4.0),
            ("no crack", 1.0),
            ("grips broken", 1.0),
            ("disconnected", 0.0),
            ("failed", 1.0),
        ];
        assert_eq!(shares, expected);
        assert_eq!(outcomes[4].1.uncertainty, Uncertainty::Bound(0.15));
        let length = ensemble.length(&bootstrap()).unwrap();
        assert_eq!((length.n, length.missing), (18, 2));
        // Of 18 that count, one has no crack.
        let band = &ensemble.bands(&[0.2], &bootstrap()).unwrap()[0];
        assert!((band.reach.value - 17.0 / 18.0).abs() < 1e-15);
    }

    #[test]
    fn records_missing_doubled_or_strange_are_refused() {
        let of = |ids: &[u64]| CrackEnsemble::new(3, ids.iter().map(|&k| record(k, 3)));
        assert!(of(&[2, 0, 1]).is_ok());
        assert_eq!(of(&[0, 2]), Err(Error::Missing { realisation: 1, n_realisations: 3 }));
        assert_eq!(of(&[1, 0]), Err(Error::Missing { realisation: 2, n_realisations: 3 }));
        assert_eq!(of(&[0, 2, 1, 2]), Err(Error::Doubled { realisation: 2 }));
        assert_eq!(of(&[0, 1, 2, 3]), Err(Error::NoSuchRealisation { realisation: 3, limit: 3 }));
        let mut nan = record(0, 3);
        nan.failure_load = Some(f64::NAN);
        assert!(matches!(CrackEnsemble::new(1, [nan]), Err(Error::Parameter { .. })));
        assert!(matches!(CrackEnsemble::new(0, []), Err(Error::TooFew { .. })));
        let lost = CrackRecord::without_crack(0, CrackOutcome::Disconnected);
        let lost = CrackEnsemble::new(1, [lost]).unwrap();
        assert!(matches!(lost.bands(&[0.0], &bootstrap()), Err(Error::TooFew { .. })));
        assert!(matches!(lost.exit(&bootstrap()), Err(Error::TooFew { .. })));
    }
}
