//! Runs of a design by number, for responses that no closure computes one by one: stored, sharded or resumed.

use sde_integrators::{Accumulator, Estimate, normal_quantile};

use crate::comoments::Comoments;
use crate::designs::cube::UnitCube;
use crate::designs::points::{Replica, check_points};
use crate::designs::sensitivity::{SobolIndices, indices_of_sums};
use crate::error::{Error, require_at_least, require_finite, require_finite_responses};
use crate::ladder::Failure;
use crate::parallel::map_in_order;
use crate::rates::of_replicas;
use crate::surrogates::control::{SampledMoments, Surrogate, coefficients};

/// The runs of a design by number.
///
/// Runs of a point are adjacent, points of all replicas alternate: point `k` of replica `r` of `R` is number `k R + r`. So a
/// design of twice the points begins with all runs of this one.
#[derive(Debug)]
pub struct DesignedRuns {
    replicas: Vec<Replica>,
    n_points: u64,
    n_inputs: usize,
    /// One, or that of a design for Sobol' indices: at `a`, at `b`, and at `a` with one coordinate of `b` for each.
    runs_per_point: u64,
}

impl DesignedRuns {
    /// Number of runs.
    #[must_use]
    pub fn n_runs(&self) -> u64 {
        self.n_points * self.replicas.len() as u64 * self.runs_per_point
    }

    /// Writes the input of a run, one coordinate of the unit cube for each dimension.
    ///
    /// Runs beyond the design are those of one with more points.
    pub fn input(&self, run: u64, x: &mut [f64]) {
        let (number, place) = (run / self.runs_per_point, run % self.runs_per_point);
        let n_replicas = self.replicas.len() as u64;
        let Ok(of_replica) = usize::try_from(number % n_replicas) else { return };
        let replica = &self.replicas[of_replica];
        if self.runs_per_point == 1 {
            return replica.point(number / n_replicas, x);
        }
        let mut both = vec![0.0; 2 * self.n_inputs];
        replica.point(number / n_replicas, &mut both);
        let (a, b) = both.split_at(self.n_inputs);
        for (i, x) in x.iter_mut().enumerate().take(self.n_inputs) {
            *x = if place == 1 || place == i as u64 + 2 { b[i] } else { a[i] };
        }
    }

    /// Writes independent standard normals of a run: the quantiles of its coordinates.
    pub fn normals(&self, run: u64, z: &mut [f64]) {
        self.input(run, z);
        for z in z {
            *z = normal_quantile(*z);
        }
    }
}

/// Runs computed by one thread at a time.
const BLOCK: u64 = 64;

impl UnitCube {
    /// Mean and variance of each response.
    ///
    /// With the feature `rayon` runs are computed in parallel on the current pool; the result is bitwise identical for any number
    /// of threads.
    ///
    /// # Errors
    /// [`Error::TooFew`], [`Error::TooMany`], [`Error::NotPowerOfTwo`] for the fields; [`Error::SampleFailed`],
    /// [`Error::NonFiniteSample`] for the lowest run with such a response.
    pub fn moments(
        &self,
        n_responses: usize,
        response: impl Fn(&[f64], &mut [f64]) -> Result<(), Failure> + Sync + Send,
    ) -> Result<Vec<SampledMoments>, Error> {
        let values = self.values(&self.runs()?, n_responses, response)?;
        values.iter().map(|values| self.moments_of_runs(values, &[])).collect()
    }

    /// The values of each response in all runs of a design.
    pub(crate) fn values(
        &self,
        runs: &DesignedRuns,
        n_responses: usize,
        response: impl Fn(&[f64], &mut [f64]) -> Result<(), Failure> + Sync + Send,
    ) -> Result<Vec<Vec<f64>>, Error> {
        require_at_least("responses", n_responses as u64, 1)?;
        let n_runs = runs.n_runs();
        let blocks: Vec<u64> = (0..n_runs.div_ceil(BLOCK)).collect();
        let block = |&number: &u64| {
            let start = number * BLOCK;
            let (mut x, mut rows) = (vec![0.0; self.dimension], Vec::new());
            for run in start..n_runs.min(start + BLOCK) {
                runs.input(run, &mut x);
                let mut y = vec![0.0; n_responses];
                evaluate(&response, &x, run, &mut y)?;
                rows.append(&mut y);
            }
            Ok(rows)
        };
        let mut values = vec![Vec::new(); n_responses];
        for rows in map_in_order(&blocks, block) {
            for row in rows?.chunks_exact(n_responses) {
                values.iter_mut().zip(row).for_each(|(values, y)| values.push(*y));
            }
        }
        Ok(values)
    }

    /// The runs of [`moments`](Self::moments) by number.
    ///
    /// # Errors
    /// [`Error::TooFew`], [`Error::TooMany`], [`Error::NotPowerOfTwo`] for the fields.
    pub fn runs(&self) -> Result<DesignedRuns, Error> {
        self.designed(self.dimension, 1)
    }

    /// The runs of [`sobol_indices`](Self::sobol_indices) by number.
    ///
    /// # Errors
    /// As [`runs`](Self::runs).
    pub fn index_runs(&self) -> Result<DesignedRuns, Error> {
        self.designed(self.dimension.saturating_mul(2), self.dimension as u64 + 2)
    }

    fn designed(&self, dimension: usize, runs_per_point: u64) -> Result<DesignedRuns, Error> {
        check_points(self.sampling, self.n_points, self.n_replicas)?;
        let replica = |number| Replica::new(self.sampling, dimension, self.seed, number);
        let replicas = (0..self.n_replicas).map(replica).collect::<Result<_, _>>()?;
        Ok(DesignedRuns {
            replicas,
            n_points: self.n_points,
            n_inputs: self.dimension,
            runs_per_point,
        })
    }

    /// Mean and variance of a response from its values in all [`runs`](Self::runs), with surrogates as control variates.
    ///
    /// `rows` has for each run the response, then the surrogates, as [`ControlledSamples`](crate::ControlledSamples). Each
    /// replica uses the coefficients of the regression over all others, so that they are independent of the points that they
    /// correct; mean, variance and standard errors then follow from the replicas as in [`moments`](Self::moments). Of responses that
    /// are all equal the errors are unknown.
    ///
    /// Source: Hickernell, Lemieux and Owen 2005, Control variates for quasi-Monte Carlo, section 3: the coefficients of
    /// independent samples are not the best ones of a net, but as good where the surrogate explains nearly all.
    ///
    /// # Errors
    /// As [`runs`](Self::runs); [`Error::Length`] for rows that are not those of all runs; [`Error::NotFinite`] for a moment of
    /// a surrogate, [`Error::NonFiniteSample`] for the lowest run with such a response (number 0) or surrogate (from 1).
    pub fn moments_of_runs(
        &self,
        rows: &[f64],
        surrogates: &[Surrogate],
    ) -> Result<SampledMoments, Error> {
        for (index, surrogate) in surrogates.iter().enumerate() {
            require_finite("mean of surrogate", index, surrogate.mean)?;
            require_finite("variance of surrogate", index, surrogate.variance.unwrap_or(0.0))?;
        }
        let width = 1 + surrogates.len();
        check_rows(&self.runs()?, rows, width)?;
        if let Some(equal) = SampledMoments::of_equal(rows.iter().step_by(width).copied()) {
            return Ok(equal);
        }
        let replicas = self.by_replica(rows, width);
        let n = replicas.len() as f64;
        let sums: Vec<Comoments> = replicas.iter().map(|rows| sums_of(rows, width)).collect();
        let centre: Vec<f64> = (0..width).map(|k| mean_over(&sums, |sum| sum.mean(k))).collect();
        // Unbiased variance from one replica: about its own mean, and of the means.
        let variance = |sum: &Comoments, k: usize| {
            let points = sum.count() as f64;
            let within = sum.variance(k) * ((points - 1.0) / points);
            within + n / (n - 1.0) * (sum.mean(k) - centre[k]).powi(2)
        };
        let (mut means, mut variances) = (Accumulator::default(), Accumulator::default());
        for (r, sum) in sums.iter().enumerate() {
            let [beta, gamma] = coefficients_without(&replicas, r, &centre, surrogates);
            let (mut m, mut v) = (sum.mean(0), variance(sum, 0));
            for (k, surrogate) in surrogates.iter().enumerate() {
                m -= beta[k] * (sum.mean(1 + k) - surrogate.mean);
                if let Some(exact) = surrogate.variance {
                    v -= gamma[k] * (variance(sum, 1 + k) - exact);
                }
            }
            means.push(m);
            variances.push(v);
        }
        Ok(SampledMoments { mean: of_replicas(&means), variance: of_replicas(&variances) })
    }

    /// Mean of a function of the response, such as an indicator, from its values in all [`runs`](Self::runs).
    ///
    /// # Errors
    /// As [`moments_of_runs`](Self::moments_of_runs).
    pub fn mean_of_runs(&self, values: &[f64]) -> Result<Estimate, Error> {
        self.moments_of_runs(values, &[]).map(|moments| moments.mean)
    }

    /// Sobol' indices of a response from its values in all [`index_runs`](Self::index_runs).
    ///
    /// # Errors
    /// As [`moments_of_runs`](Self::moments_of_runs); [`Error::NoVariance`] for a response that does not vary.
    pub fn sobol_indices_of_runs(&self, values: &[f64]) -> Result<SobolIndices, Error> {
        self.indices(0, values)
    }

    /// The same of a response by its number, for errors.
    pub(crate) fn indices(&self, response: usize, values: &[f64]) -> Result<SobolIndices, Error> {
        let width = self.dimension + 2;
        check_rows(&self.index_runs()?, values, 1)?;
        let replicas = self.by_replica(values, width);
        let sums: Vec<Comoments> = replicas.iter().map(|rows| sums_of(rows, width)).collect();
        indices_of_sums(response, self.dimension, &sums)
    }

    /// The rows of each replica, of `width` numbers.
    fn by_replica(&self, rows: &[f64], width: usize) -> Vec<Vec<f64>> {
        let n_replicas = usize::try_from(self.n_replicas).unwrap_or(usize::MAX);
        (0..n_replicas)
            .map(|r| {
                rows.chunks_exact(width).skip(r).step_by(n_replicas).flatten().copied().collect()
            })
            .collect()
    }
}

fn check_rows(runs: &DesignedRuns, rows: &[f64], width: usize) -> Result<(), Error> {
    let (value, expected) = (rows.len(), runs.n_runs().saturating_mul(width as u64));
    if value as u64 != expected {
        let expected = usize::try_from(expected).unwrap_or(usize::MAX);
        return Err(Error::Length { quantity: "numbers of all runs", value, expected });
    }
    for (run, row) in (0..).zip(rows.chunks_exact(width)) {
        require_finite_responses(&"the response on the unit cube", run, row)?;
    }
    Ok(())
}

fn sums_of(rows: &[f64], width: usize) -> Comoments {
    let mut sums = Comoments::new(width);
    rows.chunks_exact(width).for_each(|row| sums.push(row));
    sums
}

fn mean_over(sums: &[Comoments], of: impl Fn(&Comoments) -> f64) -> f64 {
    sums.iter().map(of).sum::<f64>() / sums.len() as f64
}

/// Coefficients of mean and variance from all replicas but one.
fn coefficients_without(
    replicas: &[Vec<f64>],
    left_out: usize,
    centre: &[f64],
    surrogates: &[Surrogate],
) -> [Vec<f64>; 2] {
    if surrogates.is_empty() {
        return [Vec::new(), Vec::new()];
    }
    let width = centre.len();
    let others = replicas.iter().enumerate().filter(|(r, _)| *r != left_out);
    let rows: Vec<f64> = others.flat_map(|(_, rows)| rows.iter().copied()).collect();
    let square = |(place, x): (usize, &f64)| (x - centre[place % width]).powi(2);
    let squares: Vec<f64> = rows.iter().enumerate().map(square).collect();
    let of_squares = sums_of(&squares, width);
    let means: Vec<f64> = (0..width).map(|k| of_squares.mean(k)).collect();
    let is_known = |k: usize| surrogates[k].variance.is_some();
    [coefficients(&rows, centre, |_| true), coefficients(&squares, &means, is_known)]
}

/// Responses of a point, checked.
fn evaluate(
    response: &impl Fn(&[f64], &mut [f64]) -> Result<(), Failure>,
    x: &[f64],
    run: u64,
    y: &mut [f64],
) -> Result<(), Error> {
    const MODEL: &str = "the response on the unit cube";
    response(x, y).map_err(|failure| Error::SampleFailed {
        model: MODEL.into(),
        realisation: run,
        message: failure.to_string(),
    })?;
    require_finite_responses(&MODEL, run, y)
}
