//! Polynomial chaos as a control variate, fitted to the same samples.

use sde_integrators::{Accumulator, Cholesky, Estimate, Uncertainty};

use crate::error::{Error, require_at_least, require_finite_responses};
use crate::rates::{jackknife, mean_square, with_error};
use crate::surrogates::control::SampledMoments;
use crate::surrogates::hermite::{Hermite, MOST_DEGREE};
use crate::surrogates::normal_equations::factors_without_each_fold;

/// Polynomials of independent standard normals, fitted to samples fold by fold.
///
/// With orthonormal Hermite polynomials $\psi_\alpha$ up to a total degree, least squares over all folds but one give
///
/// $$ s(z) = \sum_\alpha c_\alpha \psi_\alpha(z), \qquad \operatorname{E} s = c_0, \quad
///    \operatorname{Var} s = \sum_{\alpha \ne 0} c_\alpha^2 , $$
///
/// which is independent of the samples of that fold: they correct it without bias,
///
/// $$ \hat\mu_r = c_0 + \overline{(y - s)}_r, \qquad \hat V_r = \operatorname{Var} s + (V_r(y) - V_r(s)) . $$
///
/// Mean and standard error follow from the folds, which are the replicas of a quasi-random design or parts of independent
/// samples: sample `k` is of fold `k mod n_folds`. The degree is the one, up to three, with the smallest mean square of
/// $y - s$ over the samples that a fit has not seen; a fit has at least twice as many samples as terms.
///
/// What a polynomial of degree `d` leaves of a smooth response has mostly the next degree, and so heavy tails that few
/// samples seldom show. The squared standard errors are those of the folds times $1 + \sqrt{(\kappa - 1)/n}$, one relative
/// deviation of a sample variance more, with the kurtosis $\kappa$ of the Hermite polynomial of degree `d + 1`: 3,
/// 15, 93, 639 for `d` from 0 to 3. The variance depends more on tails: with the share $q$ of the terms of degree `d` in the variance
/// of the polynomial, its standard error is that of the folds times $\min(1 + 25 \sqrt q, 5)$, if that is more. Both factors were
/// measured on $e^w$ with a normal $w$ of deviation 0.1 to 1; for a bounded response they are more than is needed.
/// What no sample has met is in no error, as of [`ControlledSamples`](crate::ControlledSamples).
/// Of values that are all equal every error is unknown. A polynomial with $q$ above a tenth that leaves more than a hundredth has not
/// converged, and the error of the variance is unknown.
///
/// Sources: Ghanem and Spanos 1991, Stochastic finite elements: a spectral approach (polynomial chaos); Sudret 2008,
/// Global sensitivity analysis using polynomial chaos expansions, eqs 36 to 42 (Sobol' indices); Glasserman 2003, Monte
/// Carlo methods in financial engineering, section 4.1 (control variates).
///
/// ```
/// use uq_estimators::{PolynomialControl, Sampling, UnitCube};
///
/// // exp(0.1 z_0 + 0.2 z_1) at 64 runs: the mean is exp(0.025).
/// let cube = UnitCube {
///     dimension: 2, sampling: Sampling::ScrambledSobol, seed: 1, n_points: 8, n_replicas: 8,
/// };
/// let runs = cube.runs()?;
/// let mut inputs = vec![0.0; 2 * 64];
/// inputs.chunks_exact_mut(2).zip(0..).for_each(|(z, run)| runs.normals(run, z));
/// let values: Vec<f64> = inputs.chunks_exact(2).map(|z| (0.1 * z[0] + 0.2 * z[1]).exp()).collect();
/// let found = PolynomialControl::new(&inputs, 2, 8)?.moments(&values)?;
/// assert_eq!(found.degree, 3);
/// assert!((found.moments.mean.value - 0.025_f64.exp()).abs() < 3e-4);
/// assert!((found.total[1].value - 0.8).abs() < 0.01);
/// # Ok::<(), uq_estimators::Error>(())
/// ```
#[derive(Debug)]
pub struct PolynomialControl {
    basis: Hermite,
    n_folds: usize,
    /// The polynomials at each sample, row by row, up to the largest degree that the samples can fit.
    rows: Vec<f64>,
    /// Normal equations without each fold, by degree from zero.
    fits: Vec<Vec<Cholesky>>,
}

/// Mean, variance and Sobol' indices of a response.
#[derive(Debug, Clone, PartialEq)]
#[must_use]
pub struct PolynomialMoments {
    /// Mean and variance with the polynomial as control variate.
    pub moments: SampledMoments,
    /// Degree of the polynomial.
    pub degree: usize,
    /// Its number of terms.
    pub n_terms: usize,
    /// Part of the variance that the polynomial leaves, from samples that its fit has not seen.
    pub unexplained: f64,
    /// First-order Sobol' index of each input by the polynomial: wrong by at most the unexplained part, besides its error.
    pub first: Vec<Estimate>,
    /// Total Sobol' index of each input, likewise.
    pub total: Vec<Estimate>,
}

/// Samples of a fit for each of its terms.
const SAMPLES_PER_TERM: usize = 2;

/// Kurtosis of the Hermite polynomials of one degree more, by the degree of the fit.
const KURTOSIS: [f64; MOST_DEGREE + 1] = [3.0, 15.0, 93.0, 639.0];

/// Folds from which a standard error is known to a quarter, as of replicas.
const FEWEST_FOLDS: usize = 8;

impl PolynomialControl {
    /// Polynomials of samples at these inputs, `dimension` independent standard normals each.
    ///
    /// # Errors
    /// [`Error::TooFew`] below eight folds, or two samples in each; [`Error::Length`] for an incomplete sample or folds of
    /// different size; [`Error::NonFiniteSample`] for the lowest sample with such an input.
    pub fn new(inputs: &[f64], dimension: usize, n_folds: usize) -> Result<Self, Error> {
        require_at_least("dimensions", dimension as u64, 1)?;
        require_at_least("folds", n_folds as u64, FEWEST_FOLDS as u64)?;
        let (value, unit) = (inputs.len(), dimension.saturating_mul(n_folds));
        if !value.is_multiple_of(unit) {
            let expected = value / unit * unit;
            return Err(Error::Length { quantity: "inputs in equal folds", value, expected });
        }
        let n = value / dimension;
        require_at_least("samples in a fold", (n / n_folds) as u64, 2)?;
        for (realisation, input) in (0..).zip(inputs.chunks_exact(dimension)) {
            require_finite_responses(&"the inputs of a polynomial", realisation, input)?;
        }
        let n_seen = n - n / n_folds;
        let can_fit = |degree: &usize| {
            Hermite::n_terms(dimension, *degree).is_some_and(|p| SAMPLES_PER_TERM * p <= n_seen)
        };
        let largest = (1..=MOST_DEGREE).take_while(can_fit).last().unwrap_or(0);
        let basis = Hermite::new(dimension, largest);
        let width = basis.len();
        let mut rows = vec![0.0; n * width];
        for (row, z) in rows.chunks_exact_mut(width).zip(inputs.chunks_exact(dimension)) {
            basis.at(z, row);
        }
        let of_degree = |degree: usize| {
            let p = basis.len_to(degree);
            factors_without_each_fold(&rows, width, p, n_folds)
        };
        // A degree whose equations are singular ends the list: samples may share a plane.
        let fits = (0..=largest).map_while(of_degree).collect();
        Ok(Self { basis, n_folds, rows, fits })
    }

    /// Mean and variance of a response from its value at each sample.
    ///
    /// # Errors
    /// [`Error::Length`] for another number of values; [`Error::NonFiniteSample`] for the lowest one that is not finite.
    pub fn moments(&self, values: &[f64]) -> Result<PolynomialMoments, Error> {
        let width = self.basis.len();
        let (value, expected) = (values.len(), self.rows.len() / width);
        if value != expected {
            return Err(Error::Length { quantity: "values of all samples", value, expected });
        }
        for (realisation, value) in (0..).zip(values) {
            require_finite_responses(&"the response", realisation, &[*value])?;
        }
        if let Some(moments) = SampledMoments::of_equal(values.iter().copied()) {
            let shares = vec![moments.variance; self.basis.dimension()];
            let (first, total) = (shares.clone(), shares);
            let (degree, n_terms, unexplained) = (0, 1, 0.0);
            return Ok(PolynomialMoments { moments, degree, n_terms, unexplained, first, total });
        }
        let centre = values.iter().sum::<f64>() / values.len() as f64;
        let y: Vec<f64> = values.iter().map(|value| value - centre).collect();
        let fitted = |degree: usize| Fitted::new(self, &y, degree);
        let all: Vec<Fitted> = (0..self.fits.len()).map(fitted).collect();
        let best = all.iter().min_by(|a, b| a.unexplained.total_cmp(&b.unexplained));
        let Some(best) = best else {
            return Err(Error::TooFew { quantity: "samples", value: value as u64, limit: 2 });
        };
        Ok(self.result(best, &y, centre))
    }

    /// The samples of a fold, by their places.
    fn fold(&self, r: usize) -> impl Iterator<Item = (usize, &[f64])> {
        self.rows.chunks_exact(self.basis.len()).enumerate().skip(r).step_by(self.n_folds)
    }

    fn result(&self, best: &Fitted, y: &[f64], centre: f64) -> PolynomialMoments {
        let n = self.n_folds as f64;
        let mut of_values = vec![Accumulator::default(); self.n_folds];
        let mut of_fit = of_values.clone();
        for r in 0..self.n_folds {
            for (k, row) in self.fold(r) {
                of_values[r].push(y[k]);
                of_fit[r].push(best.at(r, row));
            }
        }
        let mean = of_values.iter().map(Accumulator::mean).sum::<f64>() / n;
        let (mut means, mut variances) = (Accumulator::default(), Accumulator::default());
        for (r, (values, fit)) in of_values.iter().zip(&of_fit).enumerate() {
            let exact = best.coefficients[r][0];
            means.push(values.mean() - fit.mean() + exact);
            // Each unbiased: about the mean of the fold, and the square of that mean's error.
            let variance = mean_square(values) + n / (n - 1.0) * (values.mean() - mean).powi(2);
            let of_fit = mean_square(fit) + (fit.mean() - exact).powi(2);
            variances.push(variance - of_fit + squares(&best.coefficients[r]));
        }
        // The mean square of n values of kurtosis k has the relative variance (k - 1)/n.
        let unseen = ((KURTOSIS[best.degree] - 1.0) / y.len() as f64).sqrt();
        let factor = 1.0 + unseen;
        let (mut mean, mut variance) =
            (of_folds(&means, factor), of_folds(&variances, factor.max(best.of_tails.powi(2))));
        mean.value += centre;
        if best.has_not_converged {
            variance.uncertainty = Uncertainty::Unknown;
        }
        let (first, total) = self.indices(best, variance.value, factor);
        PolynomialMoments {
            moments: SampledMoments { mean, variance },
            degree: best.degree,
            n_terms: self.basis.len_to(best.degree),
            unexplained: best.unexplained,
            first,
            total,
        }
    }

    /// Sobol' indices of each input, with a multiple of the square of the error by the jackknife over the folds.
    fn indices(&self, best: &Fitted, variance: f64, factor: f64) -> (Vec<Estimate>, Vec<Estimate>) {
        // What the polynomial leaves is part of the variance, too.
        let left = best.unexplained * variance.max(0.0);
        let share = |coefficients: &[f64], of: &dyn Fn(&[u8]) -> bool| {
            let terms = coefficients.iter().enumerate().skip(1);
            let part: f64 =
                terms.filter(|(t, _)| of(self.basis.exponents(*t))).map(|(_, c)| c * c).sum();
            let whole = squares(coefficients) + left;
            if whole > 0.0 { part / whole } else { 0.0 }
        };
        let estimate = |of: &dyn Fn(&[u8]) -> bool| {
            let left_out: Vec<f64> =
                best.coefficients.iter().map(|coefficients| share(coefficients, of)).collect();
            let found = jackknife(share(&best.of_all, of), &left_out);
            let error = found.standard_error().unwrap_or(f64::INFINITY);
            with_error(found.value, factor.sqrt() * error)
        };
        let alone = |i: usize| {
            estimate(&|powers| powers.iter().enumerate().all(|(k, &p)| (k == i) == (p > 0)))
        };
        let at_all = |i: usize| estimate(&|powers| powers[i] > 0);
        let inputs = 0..self.basis.dimension();
        (inputs.clone().map(alone).collect(), inputs.map(at_all).collect())
    }
}

/// Fits of one degree to a response.
struct Fitted {
    degree: usize,
    /// Coefficients without each fold.
    coefficients: Vec<Vec<f64>>,
    /// Coefficients from all samples.
    of_all: Vec<f64>,
    /// Mean square of the samples that a fit has not seen over that of a constant.
    unexplained: f64,
    /// Factor of the error of the variance for tails that few samples show.
    of_tails: f64,
    /// Whether the terms of the highest degree and what is left of the samples are large.
    has_not_converged: bool,
}

/// Slope and limit of the factor for tails, by the root of the share of the highest degree.
const TAILS: [f64; 2] = [25.0, 5.0];

/// Share of the highest degree, and unexplained part, above which both a polynomial has not converged.
const NOT_CONVERGED: [f64; 2] = [0.1, 0.01];

impl Fitted {
    fn new(control: &PolynomialControl, y: &[f64], degree: usize) -> Self {
        let p = control.basis.len_to(degree);
        let mut right = vec![vec![0.0; p]; control.n_folds];
        for (r, right) in right.iter_mut().enumerate() {
            for (k, row) in control.fold(r) {
                right.iter_mut().zip(row).for_each(|(sum, psi)| *sum += y[k] * psi);
            }
        }
        let all: Vec<f64> = (0..p).map(|t| right.iter().map(|fold| fold[t]).sum()).collect();
        let fits = &control.fits[degree];
        let without = |(r, fit): (usize, &Cholesky)| {
            let others: Vec<f64> = all.iter().zip(&right[r]).map(|(all, own)| all - own).collect();
            fit.solve(others)
        };
        let coefficients: Vec<Vec<f64>> =
            fits.iter().take(control.n_folds).enumerate().map(without).collect();
        // The last factor is that of all samples.
        let of_all = fits.last().map_or_else(Vec::new, |fit| fit.solve(all));
        let lower = if degree > 0 { control.basis.len_to(degree - 1) } else { p };
        let (highest, all) = (square_sum(&of_all[lower..]), squares(&of_all));
        let share = if all > 0.0 { highest / all } else { 0.0 };
        let of_tails = (1.0 + TAILS[0] * share.sqrt()).min(TAILS[1]);
        let (unexplained, has_not_converged) = (0.0, false);
        let mut fitted =
            Self { degree, coefficients, of_all, unexplained, of_tails, has_not_converged };
        let (mut left, mut whole) = (0.0, 0.0);
        for r in 0..control.n_folds {
            for (k, row) in control.fold(r) {
                left += (y[k] - fitted.at(r, row)).powi(2);
                whole += y[k] * y[k];
            }
        }
        fitted.unexplained = if whole > 0.0 { left / whole } else { 0.0 };
        fitted.has_not_converged =
            share > NOT_CONVERGED[0] && fitted.unexplained > NOT_CONVERGED[1];
        fitted
    }

    /// The polynomial fitted without fold `r`.
    fn at(&self, r: usize, row: &[f64]) -> f64 {
        self.coefficients[r].iter().zip(row).map(|(c, psi)| c * psi).sum()
    }
}

/// Mean over the folds, with a multiple of the square of the error from their scatter.
fn of_folds(folds: &Accumulator, factor: f64) -> Estimate {
    let variance = folds.variance().unwrap_or(f64::INFINITY);
    with_error(folds.mean(), (factor * variance / folds.count() as f64).sqrt())
}

/// Variance of a polynomial.
fn squares(coefficients: &[f64]) -> f64 {
    square_sum(coefficients.get(1..).unwrap_or_default())
}

fn square_sum(coefficients: &[f64]) -> f64 {
    coefficients.iter().map(|c| c * c).sum()
}
