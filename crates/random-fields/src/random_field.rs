//! A standard Gaussian field as a function of space.

use sde_integrators::Noise;

use crate::correlations::spatial_correlation::{SpatialCorrelation, bounds};
use crate::error::{Error, same_length};
use crate::gaussian_field::normals_of;
use crate::modes::box_modes::BoxModes;
use crate::modes::pivot_modes::PivotModes;
use crate::modes::truncation::Truncation;

/// A Gaussian field of mean zero and variance one as a function of space: a sum of modes with independent standard normal
/// coefficients,
///
/// $$ g(x) = \sum_{j=1}^n \xi_j \phi_j(x) . $$
///
/// A realisation is given by its coefficients and has a value at any point, the same on every mesh to the last bit. It is what
/// levels of a multilevel estimate, meshes of a convergence study and different solvers share.
///
/// | made by | modes | for |
/// |---|---|---|
/// | [`on_box`](Self::on_box) | eigenfunctions of the exponential correlation, products of them on boxes | separable exponential correlation |
/// | [`on_points`](Self::on_points) | eigenfunctions of the Gaussian process through pivots among points that cover the body | any correlation and body; points outside have a larger error, which is stated |
///
/// Modes are ordered by their share of the mean variance over the body, and truncated. The variance that is left out is stated
/// at any point ([`left_out_variance`](Self::left_out_variance)) and in the mean
/// ([`mean_left_out_variance`](Self::mean_left_out_variance)). The error of the covariance of two points is at most the root of
/// the product of what is left out at each, since the remainder is a covariance. [`with_unit_variance`](Self::with_unit_variance)
/// scales what is kept to unit variance, so that marginals of translations are exact.
///
/// Sources: Ghanem and Spanos 1991, Stochastic finite elements, section 2.3; Harbrecht, Peters and Schneider 2012
/// (pivoted Cholesky); Rasmussen and Williams 2006, section 8.1 (the process through pivots, there Nyström).
///
/// ```
/// use random_fields::{Correlation, CorrelationFunction, RandomField, SpatialCorrelation, Truncation};
/// use sde_integrators::Noise;
///
/// let along = |length| Correlation { function: CorrelationFunction::Exponential, length };
/// let soil = SpatialCorrelation::separable([along(20.0), along(2.0)]);
/// let field = RandomField::on_box([[0.0, 0.0], [30.0, 10.0]], soil, Truncation::Share(0.9))?;
/// let mut coefficients = vec![0.0; field.n_terms()];
/// field.coefficients(&Noise::new(7), 0, 0, &mut coefficients)?;
/// let mut coarse = [0.0; 2];
/// field.values(&coefficients, &[[5.0, 5.0], [15.0, 5.0]], &mut coarse)?;
/// let mut fine = [0.0; 3];
/// field.values(&coefficients, &[[5.0, 5.0], [10.0, 5.0], [15.0, 5.0]], &mut fine)?;
/// assert_eq!([coarse[0], coarse[1]], [fine[0], fine[2]]);
/// assert!(field.mean_left_out_variance() < 0.1);
/// # Ok::<(), random_fields::Error>(())
/// ```
#[derive(Debug, Clone, PartialEq)]
pub struct RandomField<const D: usize> {
    modes: Modes<D>,
    correlation: SpatialCorrelation<D>,
    has_unit_variance: bool,
}

#[derive(Debug, Clone, PartialEq)]
enum Modes<const D: usize> {
    Box(BoxModes<D>),
    Pivots(PivotModes<D>),
}

impl<const D: usize> RandomField<D> {
    /// On the box between two corners (lengths), by eigenfunctions of the exponential correlation. About inclined axes it is the
    /// box along these that holds the given one.
    ///
    /// # Errors
    /// [`Error::NoEigenfunctions`] for another correlation than an exponential one in one dimension or a separable product of
    /// exponential ones; [`Error::EmptyInterval`] and [`Error::Point`] for corners; [`Error::LengthBeyondBody`];
    /// [`Error::TooManyTerms`] where more than 20,000 are needed; those of [`SpatialCorrelation::check`]; [`Error::OutOfRange`]
    /// or [`Error::NotPositive`] for the truncation.
    pub fn on_box(
        corners: [[f64; D]; 2],
        correlation: impl Into<SpatialCorrelation<D>>,
        truncation: Truncation,
    ) -> Result<Self, Error> {
        let correlation = correlation.into();
        truncation.check()?;
        bounds(&corners)?;
        let [lows, highs] = corners;
        for (&low, high) in lows.iter().zip(highs) {
            if low >= high {
                return Err(Error::EmptyInterval { name: "an edge of the box", low, high });
            }
        }
        correlation.check_within(&lows, &highs)?;
        let modes = Modes::Box(BoxModes::new(corners, &correlation, truncation)?);
        Ok(Self { modes, correlation, has_unit_variance: false })
    }

    /// By points of equal volume that cover a body (lengths), a few for each correlation length, for any correlation.
    ///
    /// It takes `O(n k^2 + k^3)` operations for `n` points and `k` pivots, four for each term or as many as leave half of what a
    /// share may leave; at most 1500.
    ///
    /// # Errors
    /// As [`RandomField::on_weighted_points`].
    pub fn on_points(
        points: &[[f64; D]],
        correlation: impl Into<SpatialCorrelation<D>>,
        truncation: Truncation,
    ) -> Result<Self, Error> {
        Self::on_weighted_points(points, &vec![1.0; points.len()], correlation, truncation)
    }

    /// As [`RandomField::on_points`], by points of different volumes, which weigh the mean variance.
    ///
    /// # Errors
    /// [`Error::NoPoints`], [`Error::Point`] for a coordinate or a volume, [`Error::Length`], [`Error::LengthBeyondBody`];
    /// [`Error::TooFewPoints`] for more terms than the covariance has above roundoff, [`Error::TooManyTerms`] for a share that
    /// 1500 pivots do not reach, [`Error::TooManyColumns`]; those of [`SpatialCorrelation::check`] and of the truncation.
    pub fn on_weighted_points(
        points: &[[f64; D]],
        volumes: &[f64],
        correlation: impl Into<SpatialCorrelation<D>>,
        truncation: Truncation,
    ) -> Result<Self, Error> {
        let correlation = correlation.into();
        truncation.check()?;
        let [low, high] = bounds(points)?;
        correlation.check_within(&low, &high)?;
        let modes = Modes::Pivots(PivotModes::new(points, volumes, &correlation, truncation)?);
        Ok(Self { modes, correlation, has_unit_variance: false })
    }

    /// The field scaled to unit variance at each point: modes over the root of the sum of their squares. The correlation changes by
    /// about what is left out.
    #[must_use]
    pub fn with_unit_variance(self) -> Self {
        Self { has_unit_variance: true, ..self }
    }

    /// The correlation that was asked for.
    #[must_use]
    pub fn correlation(&self) -> &SpatialCorrelation<D> {
        &self.correlation
    }

    /// Number of terms.
    #[must_use]
    pub fn n_terms(&self) -> usize {
        self.shares().len()
    }

    /// The share of each term of the mean variance over the body, descending, before it is scaled to unit variance. Over a box it
    /// is the eigenvalue over the volume.
    #[must_use]
    pub fn shares(&self) -> &[f64] {
        match &self.modes {
            Modes::Box(modes) => modes.shares(),
            Modes::Pivots(modes) => modes.shares(),
        }
    }

    /// Mean over the body of the variance that is left out: one less the sum of all shares.
    #[must_use]
    pub fn mean_left_out_variance(&self) -> f64 {
        1.0 - self.shares().iter().sum::<f64>()
    }

    /// The variance that is left out at a point, one less that of the terms, within roundoff: of a field scaled to unit variance
    /// that of its terms before.
    ///
    /// # Errors
    /// [`Error::OutsideBox`], [`Error::Point`].
    pub fn left_out_variance(&self, x: &[f64; D]) -> Result<f64, Error> {
        let mut modes = vec![0.0; self.n_terms()];
        self.terms_at(0, x, &mut self.scratch(), &mut modes)?;
        Ok(1.0 - modes.iter().map(|mode| mode * mode).sum::<f64>())
    }

    /// The covariance of the values at two points that the terms make up.
    ///
    /// # Errors
    /// [`Error::OutsideBox`], [`Error::Point`].
    pub fn covariance(&self, a: &[f64; D], b: &[f64; D]) -> Result<f64, Error> {
        let n_terms = self.n_terms();
        let mut modes = vec![0.0; 2 * n_terms];
        self.modes(&[*a, *b], &mut modes)?;
        let (at_a, at_b) = modes.split_at(n_terms);
        Ok(at_a.iter().zip(at_b).map(|(a, b)| a * b).sum())
    }

    /// All modes at all points into `out`, `out[i * n_terms + j]` for point `i` and term `j`: the derivatives of the values with
    /// respect to the coefficients.
    ///
    /// # Errors
    /// [`Error::Length`]; [`Error::OutsideBox`] and [`Error::Point`] with the index of the point.
    pub fn modes(&self, points: &[[f64; D]], out: &mut [f64]) -> Result<(), Error> {
        let n_terms = self.n_terms();
        same_length("the modes at the points", out.len(), points.len().saturating_mul(n_terms))?;
        let mut scratch = self.scratch();
        for (point, (x, out)) in points.iter().zip(out.chunks_exact_mut(n_terms)).enumerate() {
            self.modes_at(point, x, &mut scratch, out)?;
        }
        Ok(())
    }

    /// The values of a realisation at points into `out`.
    ///
    /// # Errors
    /// [`Error::Length`]; [`Error::NotFinite`] for a coefficient; [`Error::OutsideBox`] and [`Error::Point`] with the index of the
    /// point.
    pub fn values(
        &self,
        coefficients: &[f64],
        points: &[[f64; D]],
        out: &mut [f64],
    ) -> Result<(), Error> {
        same_length("the coefficients", coefficients.len(), self.n_terms())?;
        same_length("the values at the points", out.len(), points.len())?;
        if let Some(&value) = coefficients.iter().find(|xi| !xi.is_finite()) {
            return Err(Error::NotFinite { name: "a coefficient", value });
        }
        if let (Modes::Pivots(modes), false) = (&self.modes, self.has_unit_variance) {
            // The sum over terms is the same at all points.
            let weights = modes.pivot_weights(coefficients);
            for (point, (x, out)) in points.iter().zip(out).enumerate() {
                require_finite(point, x)?;
                *out = modes.value(&weights, x);
            }
            return Ok(());
        }
        let (mut scratch, mut modes) = (self.scratch(), vec![0.0; self.n_terms()]);
        for (point, (x, out)) in points.iter().zip(out).enumerate() {
            self.modes_at(point, x, &mut scratch, &mut modes)?;
            *out = modes.iter().zip(coefficients).map(|(mode, xi)| mode * xi).sum();
        }
        Ok(())
    }

    /// The coefficients of field `number` of a realisation: independent standard normals of
    /// [`Purpose::Field`](sde_integrators::Purpose::Field), a pure function of seed, realisation and number. More terms continue
    /// the same sequence. Fields of other numbers and of other realisations are independent.
    ///
    /// # Errors
    /// [`Error::Length`].
    pub fn coefficients(
        &self,
        noise: &Noise,
        realisation: u64,
        number: u32,
        out: &mut [f64],
    ) -> Result<(), Error> {
        same_length("the coefficients", out.len(), self.n_terms())?;
        normals_of(*noise, realisation, number).fill_normal(out);
        Ok(())
    }

    fn scratch(&self) -> Vec<f64> {
        match &self.modes {
            Modes::Box(modes) => modes.scratch(),
            Modes::Pivots(_) => vec![],
        }
    }

    /// The modes at a point, scaled where this is asked for.
    fn modes_at(
        &self,
        point: usize,
        x: &[f64; D],
        scratch: &mut [f64],
        out: &mut [f64],
    ) -> Result<(), Error> {
        self.terms_at(point, x, scratch, out)?;
        if self.has_unit_variance {
            let square: f64 = out.iter().map(|mode| mode * mode).sum();
            if square <= f64::MIN_POSITIVE {
                let must = "where the terms of the field have a variance";
                return Err(Error::Point { name: "a coordinate", point, value: x[0], must });
            }
            let scale = 1.0 / square.sqrt();
            for mode in out {
                *mode *= scale;
            }
        }
        Ok(())
    }

    /// The terms of the expansion at a point.
    fn terms_at(
        &self,
        point: usize,
        x: &[f64; D],
        scratch: &mut [f64],
        out: &mut [f64],
    ) -> Result<(), Error> {
        require_finite(point, x)?;
        match &self.modes {
            Modes::Box(modes) => modes.values(point, x, scratch, out),
            Modes::Pivots(modes) => {
                modes.values(x, out);
                Ok(())
            }
        }
    }
}

fn require_finite<const D: usize>(point: usize, x: &[f64; D]) -> Result<(), Error> {
    match x.iter().find(|x| !x.is_finite()) {
        Some(&value) => Err(Error::Point { name: "a coordinate", point, value, must: "finite" }),
        None => Ok(()),
    }
}
