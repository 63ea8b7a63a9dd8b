//! Gaussian fields on lattices by circulant embedding.

use rustfft::num_complex::Complex;
use rustfft::{Fft, FftPlannerScalar};
use sde_integrators::Stream;

use crate::correlation::Correlation;
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
    /// On `counts` points along each axis.
    pub(crate) fn new(
        counts: [usize; 3],
        spacing: f64,
        correlation: &Correlation,
    ) -> Result<Self, Error> {
        let mut refused = None;
        for lengths in LENGTHS {
            let least = lengths * correlation.length / spacing;
            let sizes = counts.map(|count| period(count, least));
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
        Err(refused.unwrap_or(Error::TooManyNodes { value, limit: MOST_POINTS }))
    }

    fn with_period(
        sizes: [usize; 3],
        spacing: f64,
        correlation: &Correlation,
    ) -> Result<Self, Error> {
        let n = product(sizes);
        let mut row: Vec<Complex<f64>> = (0..n)
            .map(|point| {
                let lag = coordinates(point, sizes);
                let square: f64 =
                    (0..3).map(|k| (lag[k].min(sizes[k] - lag[k]) as f64 * spacing).powi(2)).sum();
                Complex::new(correlation.at(square.sqrt()), 0.0)
            })
            .collect();
        transform(&mut row, sizes);
        let negative = || row.iter().map(|lambda| lambda.re).filter(|&lambda| lambda < 0.0);
        let change = -negative().sum::<f64>() / n as f64;
        if change > MOST_CHANGE {
            return Err(Error::NoEmbedding {
                length: correlation.length,
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
    use crate::correlation::CorrelationFunction;

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

    #[test]
    fn covariance_of_the_embedding_is_the_correlation_at_every_lag_of_the_lattice() {
        // The covariance of a field of independent amplitudes is the transform of their squares.
        for function in CorrelationFunction::ALL {
            for (counts, spacing) in [([40, 1, 1], 0.3), ([9, 14, 1], 0.5), ([5, 4, 6], 0.7)] {
                let correlation = Correlation { function, length: 1.0 };
                let field = LatticeField::new(counts, spacing, &correlation).unwrap();
                let square = |a: &f64| Complex::new(a * a, 0.0);
                let mut covariance: Vec<_> = field.amplitudes.iter().map(square).collect();
                transform(&mut covariance, field.sizes);
                for point in 0..product(counts) {
                    let lag = coordinates(point, counts);
                    let r = lag.map(|k| (k as f64 * spacing).powi(2)).iter().sum::<f64>().sqrt();
                    let found = covariance[field.place(lag)].re;
                    // The limit of what is left out, and as much for the transforms.
                    let difference = (found - correlation.at(r)).abs();
                    assert!(difference < 2e-12, "{function:?} {lag:?}: {difference:e}");
                }
            }
        }
    }

    #[test]
    fn correlation_that_would_need_too_long_a_period_is_refused_with_its_eigenvalue() {
        let function = CorrelationFunction::Gaussian;
        let correlation = Correlation { function, length: 100.0 };
        let refused = LatticeField::new([60, 60, 60], 1.0, &correlation);
        let Err(Error::NoEmbedding { eigenvalue, change, limit, .. }) = refused else {
            unreachable!("{refused:?}")
        };
        assert!(eigenvalue < 0.0 && change > limit);
    }

    #[test]
    fn lattice_that_is_too_large_is_refused() {
        let correlation = Correlation { function: CorrelationFunction::Exponential, length: 1.0 };
        let refused = LatticeField::new([300, 300, 300], 1.0, &correlation);
        assert!(matches!(refused, Err(Error::TooManyNodes { .. })));
    }
}
