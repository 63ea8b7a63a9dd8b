//! Gaussian fields on lattices by circulant embedding.

use rustfft::num_complex::Complex;
use rustfft::{Fft, FftPlannerScalar};
use sde_integrators::Stream;

use crate::correlations::spatial_correlation::SpatialCorrelation;
use crate::error::Error;

/// Most points of an embedding: 400 MB of it.
pub(crate) const MOST_POINTS: usize = 1 << 24;
/// By how much any covariance may change where negative eigenvalues are left out: roundoff of the transform.
const MOST_CHANGE: f64 = 1e-12;
/// Half a period is at least so many correlation lengths, one after the other.
const LENGTHS: [f64; 8] = [0.0, 3.0, 4.5, 6.0, 9.0, 13.0, 18.0, 27.0];
/// Lines that are transformed side by side.
const LINES: usize = 16;

/// A stationary Gaussian field of unit variance on a lattice, as part of a periodic one that is larger.
///
/// The covariance matrix of the periodic lattice is circulant, so that its eigenvalues are the discrete Fourier transform of
/// one row. With those and white noise in the place of amplitudes, one transform gives a field whose covariance on the lattice
/// is exact. A period too short for the correlation has negative eigenvalues; it is then made longer. Those that are roundoff,
/// together less than 1e-12 of the variance, are left out.
///
/// `O(N log N)` for `N` points of the periodic lattice.
///
/// Sources: Dietrich and Newsam 1997, Fast and exact simulation of stationary Gaussian processes through circulant embedding;
/// Graham, Kuo, Nuyens, Scheichl and Sloan 2018, Analysis of circulant embedding methods.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct LatticeField {
    /// Points of a period along each axis, the first fastest.
    sizes: [usize; 3],
    /// `sqrt(lambda / N)`.
    amplitudes: Vec<f64>,
}

impl LatticeField {
    /// On `counts` points along each axis; those beyond the dimension are one.
    pub(crate) fn new<const D: usize>(
        counts: [usize; 3],
        spacing: f64,
        correlation: &SpatialCorrelation<D>,
    ) -> Result<Self, Error> {
        let extents = extents(correlation);
        // About inclined axes the point half a period away has two correlations: the lattice must not reach it.
        let is_inclined =
            correlation.axes().iter().flatten().any(|e| e.abs() > 0.0 && e.abs() < 1.0);
        let beyond = |count: usize| count.saturating_add(usize::from(is_inclined && count > 1));
        let counts = counts.map(beyond);
        let mut refused = None;
        for lengths in LENGTHS {
            let least = extents.map(|extent| lengths * extent / spacing);
            let sizes = std::array::from_fn(|k| period(counts[k], least[k]));
            let points = product(sizes);
            if points > MOST_POINTS {
                break;
            }
            match Self::with_period(sizes, spacing, correlation) {
                Err(error) => refused = Some(error),
                found => return found,
            }
        }
        let value = product(counts.map(|count| period(count, 0.0)));
        Err(refused.unwrap_or(Error::TooManyPoints { value, limit: MOST_POINTS }))
    }

    fn with_period<const D: usize>(
        sizes: [usize; 3],
        spacing: f64,
        correlation: &SpatialCorrelation<D>,
    ) -> Result<Self, Error> {
        let n = product(sizes);
        let mut row: Vec<Complex<f64>> = (0..n)
            .map(|point| Complex::new(periodic(point, sizes, spacing, correlation), 0.0))
            .collect();
        transform(&mut row, sizes);
        let negative = || row.iter().map(|lambda| lambda.re).filter(|&lambda| lambda < 0.0);
        let change = -negative().sum::<f64>() / n as f64;
        if change > MOST_CHANGE {
            return Err(Error::NoEmbedding {
                length: correlation.lengths().into_iter().fold(0.0, f64::max),
                points: n,
                eigenvalue: negative().fold(0.0, f64::min),
                change,
                limit: MOST_CHANGE,
            });
        }
        let amplitude = |lambda: &Complex<f64>| (lambda.re.max(0.0) / n as f64).sqrt();
        Ok(Self { sizes, amplitudes: row.iter().map(amplitude).collect() })
    }

    /// Index of a lattice point within the period.
    pub(crate) fn place(&self, index: [usize; 3]) -> usize {
        index[0] + self.sizes[0] * (index[1] + self.sizes[1] * index[2])
    }

    /// The field at some points of the period. The imaginary part would be another one; it is not used.
    pub(crate) fn sample(&self, stream: &mut Stream, places: &[usize], out: &mut [f64]) {
        let mut normals = vec![0.0; 2 * self.amplitudes.len()];
        stream.fill_normal(&mut normals);
        let mut field: Vec<Complex<f64>> = self
            .amplitudes
            .iter()
            .zip(normals.chunks_exact(2))
            .map(|(amplitude, z)| Complex::new(amplitude * z[0], amplitude * z[1]))
            .collect();
        transform(&mut field, self.sizes);
        for (out, &place) in out.iter_mut().zip(places) {
            *out = field[place].re;
        }
    }
}

/// The correlation length along each axis of the lattice.
fn extents<const D: usize>(correlation: &SpatialCorrelation<D>) -> [f64; 3] {
    let (axes, lengths) = (correlation.axes(), correlation.lengths());
    let mut extents = [0.0; 3];
    for k in 0..D {
        extents[k] = match correlation {
            SpatialCorrelation::Isotropic(correlation) => correlation.length,
            _ => (0..D).map(|m| (axes[m][k] * lengths[m]).powi(2)).sum::<f64>().sqrt(),
        };
    }
    extents
}

/// The correlation of a point of the period with the first, by the shorter way round. Half a period away both ways are as
/// long; their mean is taken, so that the matrix is symmetric where axes are inclined.
fn periodic<const D: usize>(
    point: usize,
    sizes: [usize; 3],
    spacing: f64,
    correlation: &SpatialCorrelation<D>,
) -> f64 {
    let at = coordinates(point, sizes);
    let mut ways = [[0.0; D]; 2];
    let mut is_half = false;
    for k in 0..D {
        let (lag, is_back) = (at[k].min(sizes[k] - at[k]), 2 * at[k] > sizes[k]);
        let along = lag as f64 * spacing;
        ways[0][k] = if is_back { -along } else { along };
        is_half |= lag > 0 && 2 * lag == sizes[k];
        ways[1][k] = if lag > 0 && 2 * lag == sizes[k] { -along } else { ways[0][k] };
    }
    let [there, back] = ways.map(|way| if is_half { way } else { ways[0] });
    let first = correlation.between(&there, &[0.0; D]);
    if is_half { 0.5 * (first + correlation.between(&back, &[0.0; D])) } else { first }
}

fn product(sizes: [usize; 3]) -> usize {
    sizes.iter().fold(1, |product: usize, &size| product.saturating_mul(size))
}

fn coordinates(point: usize, sizes: [usize; 3]) -> [usize; 3] {
    [point % sizes[0], point / sizes[0] % sizes[1], point / (sizes[0] * sizes[1])]
}

/// The points of a period whose half holds a lattice and a number of spacings; of which the transform is quick.
fn period(count: usize, least_half: f64) -> usize {
    if count == 1 {
        return 1;
    }
    if count > MOST_POINTS {
        // Refused for its number, whatever its factors.
        return count.saturating_mul(2);
    }
    #[allow(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "a count of points, cut well above the most that are possible"
    )]
    let least = least_half.min(MOST_POINTS as f64).ceil() as usize;
    let mut half = (count - 1).max(least);
    while !has_small_factors(half) {
        half += 1;
    }
    2 * half
}

fn has_small_factors(mut number: usize) -> bool {
    for factor in [2, 3, 5] {
        while number.is_multiple_of(factor) {
            number /= factor;
        }
    }
    number == 1
}

/// The discrete Fourier transform along every axis, without a factor. By the portable code of the library, whose bits do not
/// depend on the instructions of the machine; its sines are those of the platform's mathematics library.
fn transform(values: &mut [Complex<f64>], sizes: [usize; 3]) {
    let mut planner = FftPlannerScalar::new();
    let mut stride = 1;
    for size in sizes {
        if size > 1 {
            along_axis(values, stride, size, planner.plan_fft_forward(size).as_ref());
        }
        stride *= size;
    }
}

fn along_axis(values: &mut [Complex<f64>], stride: usize, size: usize, fft: &dyn Fft<f64>) {
    let mut scratch = vec![Complex::ZERO; fft.get_inplace_scratch_len()];
    let mut lines = vec![Complex::ZERO; LINES * size];
    for slab in values.chunks_exact_mut(stride * size) {
        for first in (0..stride).step_by(LINES) {
            let width = LINES.min(stride - first);
            for k in 0..size {
                for line in 0..width {
                    lines[line * size + k] = slab[k * stride + first + line];
                }
            }
            fft.process_with_scratch(&mut lines[..width * size], &mut scratch);
            for k in 0..size {
                for line in 0..width {
                    slab[k * stride + first + line] = lines[line * size + k];
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "a test ends by it")]

    use super::*;
    use crate::correlations::correlation::{Correlation, CorrelationFunction};

    #[test]
    fn transform_of_a_wave_is_one_amplitude() {
        let sizes = [6, 4, 3];
        let wave = |point| {
            let [x, y, z] = coordinates(point, sizes).map(|k| k as f64);
            Complex::cis(std::f64::consts::TAU * (2.0 * x / 6.0 + y / 4.0 + 2.0 * z / 3.0))
        };
        let mut values: Vec<_> = (0..72).map(wave).collect();
        transform(&mut values, sizes);
        for (point, value) in values.iter().enumerate() {
            let expected = if coordinates(point, sizes) == [2, 1, 2] { 72.0 } else { 0.0 };
            assert!((value - expected).norm() < 1e-12, "{point}: {value}");
        }
    }

    #[test]
    fn period_holds_the_lattice_twice_and_has_small_factors() {
        assert_eq!(period(1, 50.0), 1);
        assert_eq!(period(2, 0.0), 2);
        // 63 and 7 have a factor 7.
        assert_eq!(period(64, 0.0), 128);
        assert_eq!(period(3, 6.5), 16);
    }

    fn covariance_is_that_of<const D: usize>(
        counts: [usize; 3],
        spacing: f64,
        correlation: &SpatialCorrelation<D>,
    ) {
        // The covariance of a field of independent amplitudes is the transform of their squares.
        let field = LatticeField::new(counts, spacing, correlation).unwrap();
        let square = |a: &f64| Complex::new(a * a, 0.0);
        let mut covariance: Vec<_> = field.amplitudes.iter().map(square).collect();
        transform(&mut covariance, field.sizes);
        for point in 0..product(counts) {
            let lag = coordinates(point, counts);
            let x = std::array::from_fn(|k| lag[k] as f64 * spacing);
            let found = covariance[field.place(lag)].re;
            // The limit of what is left out, and as much for the transforms.
            let difference = (found - correlation.between(&x, &[0.0; D])).abs();
            assert!(difference < 2e-12, "{correlation:?} {lag:?}: {difference:e}");
        }
    }

    #[test]
    fn covariance_of_the_embedding_is_the_correlation_at_every_lag_of_the_lattice() {
        for function in CorrelationFunction::ALL {
            let correlation = Correlation { function, length: 1.0 };
            covariance_is_that_of::<1>([40, 1, 1], 0.3, &correlation.into());
            covariance_is_that_of::<2>([9, 14, 1], 0.5, &correlation.into());
            covariance_is_that_of::<3>([5, 4, 6], 0.7, &correlation.into());
        }
    }

    #[test]
    fn covariance_has_a_length_for_each_axis_also_about_inclined_ones() {
        let (sine, cosine) = (0.6, 0.8);
        let inclined = [[cosine, sine], [-sine, cosine]];
        for function in [CorrelationFunction::Exponential, CorrelationFunction::Matern32] {
            let along = |length| Correlation { function, length };
            for correlation in [
                SpatialCorrelation::elliptic(function, [2.0, 0.5]),
                SpatialCorrelation::separable([along(0.4), along(1.5)]),
            ] {
                covariance_is_that_of([12, 9, 1], 0.5, &correlation);
                covariance_is_that_of([12, 9, 1], 0.5, &correlation.with_axes(inclined));
            }
        }
    }

    #[test]
    fn correlation_that_would_need_too_long_a_period_is_refused_with_its_eigenvalue() {
        let function = CorrelationFunction::Gaussian;
        let correlation = SpatialCorrelation::<3>::from(Correlation { function, length: 100.0 });
        let refused = LatticeField::new([60, 60, 60], 1.0, &correlation);
        let Err(Error::NoEmbedding { eigenvalue, change, limit, .. }) = refused else {
            unreachable!("{refused:?}")
        };
        assert!(eigenvalue < 0.0 && change > limit);
    }

    #[test]
    fn lattice_that_is_too_large_is_refused() {
        let function = CorrelationFunction::Exponential;
        let correlation = SpatialCorrelation::<3>::from(Correlation { function, length: 1.0 });
        let refused = LatticeField::new([300, 300, 300], 1.0, &correlation);
        assert!(matches!(refused, Err(Error::TooManyPoints { .. })));
    }
}
