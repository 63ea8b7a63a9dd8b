//! Central differences with an error estimate, for a response that is a program.

use crate::derivatives::{Derivatives, Known};
use crate::error::{Error, require_finite, require_positive};
use crate::expansion::Expansion;
use crate::forward::input_scales;
use crate::random_vector::RandomVector;

/// Ratio of successive steps, as in the source.
const RATIO: f64 = 1.4;
/// Number of steps; the smallest is `1.4^-9 = 0.05` of the first.
const LEVELS: usize = 10;

/// Derivatives up to the third by central differences of values, extrapolated to step zero with an error estimate.
///
/// $$ \frac{\partial^m y}{\partial x_{i_1} .. \partial x_{i_m}} \approx \frac{1}{2^m h_{i_1} .. h_{i_m}}
///    \sum_{s \in \lbrace -1, 1 \rbrace^m} s_1 .. s_m \; y(x + s_1 h_{i_1} e_{i_1} + .. + s_m h_{i_m} e_{i_m}) $$
///
/// The formula holds for all orders, with an error in even powers of the step. Each derivative takes ten steps, from
/// `first_step` deviations of its inputs down by factors of 1.4, and Neville's table; the entry with the smallest
/// estimated error is the result. A derivative whose error exceeds `largest_error` is rejected, which detects kinks,
/// jumps and noise.
///
/// Cost: `10 (2N + 4N(N+1)/2 + 8N(N+1)(N+2)/6)` values with third derivatives, without them the last term is absent.
/// Relative to the deviation, the accuracy for smooth responses is about 1e-11 for gradients, 1e-9 for Hessians, 1e-7
/// for third derivatives.
///
/// Source: Ridders 1982, Accurate computation of F'(x) and F'(x) F''(x).
#[derive(Debug, Clone, Copy)]
pub struct CentralDifferences<F> {
    /// The response: a value at a point.
    pub response: F,
    /// Largest step over the deviation of an input; the response must be smooth within three steps.
    pub first_step: f64,
    /// Largest accepted error, relative to the first-order deviation of the response.
    ///
    /// It is the error of a derivative times the deviations of its inputs.
    pub largest_error: f64,
    /// Highest order of the derivatives.
    pub order: crate::forward::HighestOrder,
}

/// Rounding error of a value of the response, over its magnitude: a few operations.
const ROUNDING: f64 = 4.0 * f64::EPSILON;

/// A value and its estimated error.
#[derive(Debug, Clone, Copy)]
struct Settled {
    value: f64,
    error: f64,
}

/// Derivatives with their largest errors.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Differenced<const N: usize> {
    /// The derivatives.
    pub expansion: Expansion<N>,
    /// Estimated errors of the worst first, second and third derivative.
    ///
    /// Each is multiplied by the deviations of its inputs and divided by the first-order deviation of the response.
    pub largest_errors: [f64; 3],
}

impl<F> CentralDifferences<F> {
    /// Default steps and tolerance, for moments and trust accurate to three digits.
    ///
    /// The first step is half a deviation; the tolerance of derivatives is 1e-4 of the deviation.
    pub const fn new(response: F, order: crate::forward::HighestOrder) -> Self {
        Self { response, first_step: 0.5, largest_error: 1e-4, order }
    }

    /// The derivatives at the centre of `inputs`, with their estimated errors.
    ///
    /// # Errors
    /// [`Error::NotPositive`] for `first_step` or `largest_error`, [`Error::NotFinite`] for the response,
    /// [`Error::DifferencesUnsettled`] with the first derivative whose error exceeds the limit.
    pub fn differenced<const N: usize>(
        &self,
        inputs: &RandomVector<N>,
    ) -> Result<Differenced<N>, Error>
    where
        F: Fn(&[f64; N]) -> f64,
    {
        require_positive("first step", self.first_step)?;
        require_positive("largest error", self.largest_error)?;
        let (centre, scales) = (inputs.centre(), input_scales(inputs));
        let value = (self.response)(&centre);
        require_finite("value of the response", 0, value)?;
        let along = Along { response: &self.response, centre: &centre, scales: &scales };
        let mut entries: Vec<([Option<usize>; 3], Settled)> = Vec::new();
        for i in 0..N {
            entries.push(([Some(i), None, None], along.settle(&[i], self.first_step)?));
            for j in i..N {
                entries.push(([Some(i), Some(j), None], along.settle(&[i, j], self.first_step)?));
                if self.order == crate::forward::HighestOrder::Third {
                    for k in j..N {
                        let inputs = [Some(i), Some(j), Some(k)];
                        entries.push((inputs, along.settle(&[i, j, k], self.first_step)?));
                    }
                }
            }
        }
        self.gather(value, &scales, &entries)
    }

    fn gather<const N: usize>(
        &self,
        value: f64,
        scales: &[f64; N],
        entries: &[([Option<usize>; 3], Settled)],
    ) -> Result<Differenced<N>, Error> {
        let order = |inputs: &[Option<usize>; 3]| inputs.iter().flatten().count();
        let slopes = entries.iter().filter(|(inputs, _)| order(inputs) == 1);
        let squares: f64 = slopes.map(|(_, slope)| slope.value * slope.value).sum();
        // For a flat response the only scale is its own magnitude.
        let deviation =
            if squares > 0.0 { squares.sqrt() } else { value.abs().max(f64::MIN_POSITIVE) };
        let mut largest_errors = [0.0_f64; 3];
        for &(inputs, settled) in entries {
            let (error, limit) = (settled.error / deviation, self.largest_error);
            if error.is_nan() || error > limit {
                return Err(Error::DifferencesUnsettled { inputs, error, limit });
            }
            let largest = &mut largest_errors[order(&inputs) - 1];
            *largest = largest.max(error);
        }
        let found = |by: &[usize]| {
            let mut key = [None; 3];
            key.iter_mut().zip(by).for_each(|(slot, &i)| *slot = Some(i));
            let scale: f64 = by.iter().map(|&i| scales[i]).product();
            entries.iter().find(|(inputs, _)| *inputs == key).map_or(value, |e| e.1.value / scale)
        };
        let mut expansion = Expansion::from_derivatives(found);
        if self.order == crate::forward::HighestOrder::Second {
            expansion.third = None;
        }
        Ok(Differenced { expansion, largest_errors })
    }
}

impl<const N: usize, F: Fn(&[f64; N]) -> f64> Derivatives<N> for CentralDifferences<F> {
    fn know(&self, inputs: &RandomVector<N>) -> Result<Known<N>, Error> {
        Ok(Known::ByInputs(self.differenced(inputs)?.expansion))
    }
}

struct Along<'a, F, const N: usize> {
    response: &'a F,
    centre: &'a [f64; N],
    scales: &'a [f64; N],
}

impl<F: Fn(&[f64; N]) -> f64, const N: usize> Along<'_, F, N> {
    /// The derivative with respect to the scaled inputs `by`, from Neville's table over decreasing steps.
    fn settle(&self, by: &[usize], first_step: f64) -> Result<Settled, Error> {
        let mut best = Settled { value: f64::NAN, error: f64::INFINITY };
        // Values with their rounding errors, which extrapolation amplifies.
        let mut previous: Vec<Settled> = Vec::new();
        let mut step = first_step;
        for _ in 0..LEVELS {
            let mut row = vec![self.difference(by, step)?];
            let mut factor = 1.0;
            for older in &previous {
                factor *= RATIO * RATIO;
                let newest = row[row.len() - 1];
                let value = (factor * newest.value - older.value) / (factor - 1.0);
                let noise = (factor * newest.error + older.error) / (factor - 1.0);
                // The distance to both parents, and at least the noise.
                let distance = (value - newest.value).abs().max((value - older.value).abs());
                if distance.max(noise) < best.error {
                    best = Settled { value, error: distance.max(noise) };
                }
                row.push(Settled { value, error: noise });
            }
            previous = row;
            step /= RATIO;
        }
        Ok(best)
    }

    /// The central difference at one step, and its rounding error.
    fn difference(&self, by: &[usize], step: f64) -> Result<Settled, Error> {
        let (mut sum, mut size) = (0.0, 0.0_f64);
        for signs in 0..1_u32 << by.len() {
            let mut x = *self.centre;
            let mut sign = 1.0;
            for (place, &i) in by.iter().enumerate() {
                let s = if signs >> place & 1 == 1 { -1.0 } else { 1.0 };
                sign *= s;
                x[i] += s * step * self.scales[i];
            }
            let y = (self.response)(&x);
            require_finite("response at difference point", signs as usize, y)?;
            sum += sign * y;
            size = size.max(y.abs());
        }
        let scale: f64 = by.iter().map(|_| 2.0 * step).product();
        Ok(Settled { value: sum / scale, error: ROUNDING * size / scale })
    }
}
