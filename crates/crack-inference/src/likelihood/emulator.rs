//! A likelihood anywhere in the parameters, from ensembles at some points of them.

use sde_integrators::{Estimate, Uncertainty};

use crate::error::{Error, at_least, same_count};
use crate::factor::product;
use crate::likelihood::gaussian::{At, Observations, Slopes};
use crate::likelihood::lack_of_fit::{ComponentFit, lack_of_fit};
use crate::likelihood::polynomial::{Polynomial, dot, terms, variance};
use crate::likelihood::regressions::{Layout, Regressions};
use crate::parameter_space::ParameterSpace;
use crate::summaries::Summaries;

/// The synthetic likelihood, `sum_p ln N(y_p; m, S + R)` of the summaries `y_p` of plates with errors of measurement of the variances
/// `R`. The mean `m` and the covariance `S` are functions of the parameters, fitted to ensembles at the points of a design. The
/// summaries are assumed to be nearly normal.
///
/// Each summary is regressed on those before it; means, slopes and the logarithms of the variances of what is left are quadratic
/// polynomials in the parameters on their scales, by least squares with the numbers of realisations as weights. Any values of them
/// make a covariance that is positive definite.
///
/// Noise of the ensembles averages out over the design. What is left is stated with each log-likelihood: with `h_j(x)` the share
/// of point `j` in the fit at `x`, `s(x)` the slopes of the log-likelihood in the numbers fitted, and `C_j` the covariance of their
/// errors in ensemble `j`, which is estimated without a law,
///
/// $$ s.e.^2 = \sum_j h_j^2 s^T C_j s . $$
///
/// A sampler takes the noise for information where these errors are near one or above: then ask [`EmulatorMixture`], or run larger
/// ensembles. The error does not hold what a quadratic cannot follow: that is seen in [`Emulator::fit`]. There is no value beyond the bounds of the
/// parameters.
///
/// [`EmulatorMixture`]: crate::EmulatorMixture
///
/// Sources: Wood 2010, Nature 466; Pourahmadi 1999 (regressions); Box and Draper 2007, Response surfaces, mixtures, and ridge
/// analyses, chapters 3 and 5 (least squares, lack of fit).
#[derive(Debug, Clone, PartialEq)]
pub struct Emulator {
    space: ParameterSpace,
    layout: Layout,
    polynomial: Polynomial,
    /// For each number of the law.
    coefficients: Vec<Vec<f64>>,
    design: Vec<Vec<f64>>,
    ensembles: Vec<Regressions>,
    least_share: f64,
}

/// The law of the summaries at a place, and a log-density under it.
struct Place {
    mixing: Vec<f64>,
    numbers: Vec<f64>,
    covariance: Vec<f64>,
    at: At,
}

impl Emulator {
    /// From an ensemble at each point of a design, such as that of [`ParameterSpace::design`].
    ///
    /// # Errors
    /// [`Error::TooFew`] for fewer than 4 points more than the `(d + 1)(d + 2)/2` terms of a quadratic in `d` parameters;
    /// [`Error::Count`] for another number of ensembles than points; [`Error::Count`] and [`Error::OutOfBounds`] for a point;
    /// [`Error::NotPositiveDefinite`] for a design that does not determine the terms; [`Error::Ensemble`] for one of fewer than
    /// `K + 4` realisations, with other summaries, or with one that is constant or follows from others.
    pub fn new(
        space: &ParameterSpace,
        points: &[Vec<f64>],
        ensembles: &[Summaries],
    ) -> Result<Self, Error> {
        same_count("ensembles", ensembles.len(), points.len())?;
        let design: Result<Vec<_>, _> = points.iter().map(|point| space.units(point)).collect();
        let design = design?;
        let weights: Vec<f64> = ensembles.iter().map(|e| e.n_realisations() as f64).collect();
        let polynomial = Polynomial::new(&design, &weights)?;
        let layout = Layout { n_summaries: ensembles[0].n_summaries() };
        let (mut regressions, mut least_share) = (vec![], 1.0_f64);
        for (number, ensemble) in ensembles.iter().enumerate() {
            least_share = least_share.min(ensemble.share()?.value);
            let of_ensemble = checked(ensemble, layout.n_summaries);
            regressions.push(of_ensemble.map_err(|reason| Error::Ensemble {
                ensemble: number,
                reason: Box::new(reason),
            })?);
        }
        let of = |q: usize| polynomial.coefficients(regressions.iter().map(|r| r.numbers[q]));
        let coefficients = (0..layout.len()).map(of).collect();
        let (space, ensembles) = (space.clone(), regressions);
        Ok(Self { space, layout, polynomial, coefficients, design, ensembles, least_share })
    }

    /// The least share of realisations with summaries among the ensembles. Where it is well below one, the information in the probability of a
    /// complete crack is not used; see [`Summaries`].
    #[must_use]
    pub fn least_share(&self) -> f64 {
        self.least_share
    }

    /// Mean (`K`) and covariance (`K` rows of `K`) of the summaries at a point of the parameters.
    ///
    /// # Errors
    /// [`Error::Count`], [`Error::OutOfBounds`] for the point.
    pub fn moments(&self, point: &[f64]) -> Result<(Vec<f64>, Vec<f64>), Error> {
        let numbers = self.numbers(&self.space.units(point)?);
        let covariance = self.layout.covariance(&numbers, &self.layout.mixing(&numbers));
        Ok((numbers[..self.layout.n_summaries].to_vec(), covariance))
    }

    /// The log-likelihood of all plates at a point, without its error: what a sampler asks for.
    ///
    /// # Errors
    /// [`Error::Count`] for the point or plates with other summaries; [`Error::OutOfBounds`]; [`Error::NotFinite`] for a plate too
    /// far away for numbers.
    pub fn value(&self, point: &[f64], data: &Observations) -> Result<f64, Error> {
        Ok(self.place(&self.space.units(point)?, data)?.at.value)
    }

    /// The log-likelihood of all plates at a point, with its standard error from the finite ensembles.
    ///
    /// # Errors
    /// As [`Emulator::value`].
    pub fn log_likelihood(&self, point: &[f64], data: &Observations) -> Result<Estimate, Error> {
        let units = self.space.units(point)?;
        let place = self.place(&units, data)?;
        let slopes = self.slopes(&place, &data.slopes(&place.at));
        let variance = variance(&self.polynomial.shares(&units), &slopes, self.covariances());
        let uncertainty = Uncertainty::StandardError(variance.sqrt());
        Ok(Estimate { value: place.at.value, uncertainty })
    }

    /// The standard errors of posterior means, on the scale of each parameter, from the finite ensembles. An error `dl(x)` of the
    /// log-likelihood moves the mean by `Cov(x, dl(x))` over the posterior, to first order. From draws of it, of which a few
    /// hundred are enough; see [`Posterior::thinned`](crate::Posterior::thinned).
    ///
    /// # Errors
    /// As [`Emulator::value`]; [`Error::TooFew`] for fewer than 100 draws.
    pub fn error_of_means(
        &self,
        draws: &[Vec<f64>],
        data: &Observations,
    ) -> Result<Vec<f64>, Error> {
        at_least("draws", draws.len(), 100)?;
        let (n, dimension) = (draws.len() as f64, self.space.parameters().len());
        let on_scale = |draw: &[f64], i: usize| self.space.parameters()[i].on_scale(draw[i]);
        let mean = |i: usize| draws.iter().map(|draw| on_scale(draw, i)).sum::<f64>() / n;
        let means: Vec<f64> = (0..dimension).map(mean).collect();
        // Cov(x_i, h_j s), for each parameter, point and number.
        let width = self.layout.len();
        let mut moved = vec![vec![0.0; self.design.len() * width]; dimension];
        for draw in draws {
            let units = self.space.units(draw)?;
            let place = self.place(&units, data)?;
            let slopes = self.slopes(&place, &data.slopes(&place.at));
            for (i, moved) in moved.iter_mut().enumerate() {
                let away = (on_scale(draw, i) - means[i]) / n;
                for (row, h) in moved.chunks_exact_mut(width).zip(self.polynomial.shares(&units)) {
                    for (moved, slope) in row.iter_mut().zip(&slopes) {
                        *moved += away * h * slope;
                    }
                }
            }
        }
        let error = |moved: &Vec<f64>| {
            let points = moved.chunks_exact(width).zip(self.covariances());
            points.map(|(row, c)| variance(&[1.0], row, std::iter::once(c))).sum::<f64>().sqrt()
        };
        Ok(moved.iter().map(error).collect())
    }

    /// How well quadratics do: for the means, the slopes and the logarithms of the variances.
    #[must_use]
    pub fn fit(&self) -> Vec<ComponentFit> {
        lack_of_fit(self.layout, &self.design, &self.ensembles, &self.coefficients)
    }

    pub(crate) fn ensembles(&self) -> &[Regressions] {
        &self.ensembles
    }

    /// The same with other numbers at the points of the design.
    pub(crate) fn with_numbers(&self, numbers: &[Vec<f64>]) -> Self {
        let of = |q: usize| self.polynomial.coefficients(numbers.iter().map(|of| of[q]));
        let coefficients = (0..self.layout.len()).map(of).collect();
        Self { coefficients, ..self.clone() }
    }

    fn covariances(&self) -> impl Iterator<Item = &[f64]> {
        self.ensembles.iter().map(|ensemble| &ensemble.covariance[..])
    }

    fn numbers(&self, units: &[f64]) -> Vec<f64> {
        let terms = terms(units);
        self.coefficients.iter().map(|of| dot(of, &terms)).collect()
    }

    fn place(&self, units: &[f64], data: &Observations) -> Result<Place, Error> {
        let k = self.layout.n_summaries;
        same_count("summaries of the plates", data.n_summaries(), k)?;
        let numbers = self.numbers(units);
        let mixing = self.layout.mixing(&numbers);
        let covariance = self.layout.covariance(&numbers, &mixing);
        let at = data.under(&numbers[..k], &covariance)?;
        Ok(Place { mixing, numbers, covariance, at })
    }

    /// From slopes in mean and covariance `S = U D U^T` to those in the numbers fitted: with `dU = U dphi U`, those in `ln d_i` are
    /// `d_i (U^T G U)_ii`, those in `phi_ij` are `2 (S G U)_ji`.
    fn slopes(&self, place: &Place, of: &Slopes) -> Vec<f64> {
        let k = self.layout.n_summaries;
        let gu = product(k, &of.covariance, &place.mixing);
        let sgu = product(k, &place.covariance, &gu);
        let mut slopes = vec![0.0; self.layout.len()];
        slopes[..k].copy_from_slice(&of.mean);
        for i in 0..k {
            for j in 0..i {
                slopes[self.layout.slope(i, j)] = 2.0 * sgu[j * k + i];
            }
            let ugu: f64 = (0..k).map(|l| place.mixing[l * k + i] * gu[l * k + i]).sum();
            let number = self.layout.log_variance(i);
            slopes[number] = simd_lanes::exp(place.numbers[number]) * ugu;
        }
        slopes
    }
}

fn checked(ensemble: &Summaries, n_summaries: usize) -> Result<Regressions, Error> {
    same_count("summaries of a realisation", ensemble.n_summaries(), n_summaries)?;
    at_least("realisations with summaries", ensemble.n_realisations(), n_summaries + 4)?;
    Regressions::new(ensemble)
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "a test ends by it")]

    use sde_integrators::{Noise, Purpose};

    use super::*;
    use crate::likelihood::lack_of_fit::Component;
    use crate::parameter::{Parameter, Prior, Scale};
    use crate::summaries::Absent;

    fn space() -> ParameterSpace {
        let (scale, prior) = (Scale::Linear, Prior::Uniform);
        let parameter = Parameter { name: "a".into(), scale, low: 0.0, high: 2.0, prior };
        ParameterSpace::new(vec![parameter]).unwrap()
    }

    /// `x_0 = a^3 + e_0`, `x_1 = a + x_0/2 + e_1`.
    fn ensemble(a: f64, id: u64, n: usize) -> Summaries {
        let mut stream = Noise::new(8).stream(Purpose::Field, id);
        let row = |_| {
            let [e, f] = stream.next_normal_pair();
            let x = a * a * a + e;
            vec![x, a + 0.5 * x + f]
        };
        Summaries::new(&(0..n).map(row).collect::<Vec<_>>(), Absent::default()).unwrap()
    }

    fn emulator(n_points: usize, n: usize) -> Emulator {
        let points = space().design(n_points).unwrap();
        let ensembles: Vec<Summaries> =
            points.iter().zip(0..).map(|(point, id)| ensemble(point[0], id, n)).collect();
        Emulator::new(&space(), &points, &ensembles).unwrap()
    }

    #[test]
    fn slopes_in_the_numbers_fitted_are_those_of_differences() {
        let mut emulator = emulator(12, 20);
        let data = Observations::new(&ensemble(1.2, 99, 3), &[0.1, 0.2]).unwrap();
        let place = emulator.place(&[0.3], &data).unwrap();
        let slopes = emulator.slopes(&place, &data.slopes(&place.at));
        let h = 1e-5;
        for number in 0..emulator.layout.len() {
            let mut value = |step: f64| {
                emulator.coefficients[number][0] += step;
                let value = emulator.place(&[0.3], &data).unwrap().at.value;
                emulator.coefficients[number][0] -= step;
                value
            };
            let slope = (value(h) - value(-h)) / (2.0 * h);
            // Central differences: h^2 times third derivatives of order 100.
            assert!((slope - slopes[number]).abs() < 1e-7 * slope.abs().max(1.0), "{number}");
        }
    }

    #[test]
    fn cubic_is_seen_as_lack_of_fit_where_it_is_and_nowhere_else() {
        for fit in emulator(60, 1000).fit() {
            let deviation = (2.0 * fit.degrees_of_freedom as f64).sqrt();
            let excess = fit.chi_square - fit.degrees_of_freedom as f64;
            match fit.component {
                // What a quadratic leaves of x^3 on [-1, 1] is the Legendre polynomial 2/5 P_3, of root mean square 0.4/sqrt(7) =
                // 0.15 but for what the largest values near the ends lose; residuals have errors of 0.03 each. The mean of the
                // second holds half of it.
                Component::Mean(0) => {
                    assert!(excess > 100.0 && (fit.misfit - 0.15).abs() < 0.03, "{fit:?}");
                }
                Component::Mean(_) => assert!(excess > 20.0, "{fit:?}"),
                _ => assert!(excess < 4.0 * deviation && fit.misfit < 0.05, "{fit:?}"),
            }
        }
    }

    #[test]
    fn ensembles_that_do_not_fit_each_other_are_refused() {
        let points = space().design(7).unwrap();
        let of = |n: usize| (0..7).map(|id| ensemble(1.0, id, n)).collect::<Vec<_>>();
        assert!(Emulator::new(&space(), &points, &of(6)).is_ok());
        let few = Emulator::new(&space(), &points, &of(5)).unwrap_err().to_string();
        assert_eq!(few, "ensemble 0: 5 realisations with summaries; at least 6 are needed");
        let few = Emulator::new(&space(), &points[..6], &of(9)[..6]);
        assert!(matches!(few, Err(Error::TooFew { value: 6, limit: 7, .. })));
        let odd = Emulator::new(&space(), &points, &of(9)[..6]);
        assert!(matches!(odd, Err(Error::Count { value: 6, expected: 7, .. })));
        let one = Summaries::new(&vec![vec![1.0]; 9], Absent::default()).unwrap();
        let mut mixed = of(9);
        mixed[3] = one.clone();
        let mixed = Emulator::new(&space(), &points, &mixed);
        assert!(matches!(mixed, Err(Error::Ensemble { ensemble: 3, .. })), "{mixed:?}");
        let emulator = Emulator::new(&space(), &points, &of(9)).unwrap();
        let foreign = Observations::new(&one, &[0.0]).unwrap();
        assert!(matches!(emulator.value(&[1.0], &foreign), Err(Error::Count { .. })));
        let data = Observations::new(&ensemble(1.0, 9, 2), &[0.0; 2]).unwrap();
        assert!(matches!(emulator.value(&[2.5], &data), Err(Error::OutOfBounds { .. })));
    }
}
