//! Systems with diagonal noise.

use crate::stratonovich::StratonovichSde;
use crate::system::{General, Sde};

/// An Ito system with diagonal noise.
///
/// Motion `i` drives state `i` alone, with an intensity that depends on `x_i` alone,
///
/// $$ dX_i = f_i(t, X) dt + b_i(t, X_i) dB_i . $$
///
/// Its noise commutes, so methods of strong order above one half need no Lévy area between motions. As an [`Sde`] it
/// is [`DiagonalNoise`], as a [`StratonovichSde`] it is [`StratonovichForm`].
pub trait DiagonalSde<const D: usize>: Sync {
    /// `f(t, x)`, per unit of time.
    fn drift(&self, t: f64, x: &[f64; D]) -> [f64; D];

    /// `b_i(t, x_i)`, per square root of time.
    fn intensity(&self, t: f64, x: &[f64; D]) -> [f64; D];

    /// `db_i/dx_i`; [`check_diagonal_noise`] compares it with differences of [`intensity`](Self::intensity).
    fn intensity_derivative(&self, t: f64, x: &[f64; D]) -> [f64; D];
}

impl<S, const D: usize> DiagonalSde<D> for &S
where
    S: DiagonalSde<D> + ?Sized,
{
    #[inline]
    fn drift(&self, t: f64, x: &[f64; D]) -> [f64; D] {
        (**self).drift(t, x)
    }

    #[inline]
    fn intensity(&self, t: f64, x: &[f64; D]) -> [f64; D] {
        (**self).intensity(t, x)
    }

    #[inline]
    fn intensity_derivative(&self, t: f64, x: &[f64; D]) -> [f64; D] {
        (**self).intensity_derivative(t, x)
    }
}

/// A [`DiagonalSde`] as an [`Sde`] with as many motions as states; it also implements [`DiagonalSde`].
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct DiagonalNoise<S>(
    /// The system with diagonal noise.
    pub S,
);

impl<S, const D: usize> Sde<D, D> for DiagonalNoise<S>
where
    S: DiagonalSde<D>,
{
    type Noise = General;

    #[inline]
    fn drift(&self, t: f64, x: &[f64; D]) -> [f64; D] {
        self.0.drift(t, x)
    }

    #[inline]
    fn noise(&self, t: f64, x: &[f64; D]) -> [[f64; D]; D] {
        diagonal(self.0.intensity(t, x))
    }

    /// `b_i b_i'`.
    fn diffusion_divergence(&self, t: f64, x: &[f64; D]) -> [f64; D] {
        let (b, slope) = (self.0.intensity(t, x), self.0.intensity_derivative(t, x));
        std::array::from_fn(|i| b[i] * slope[i])
    }
}

impl<S, const D: usize> DiagonalSde<D> for DiagonalNoise<S>
where
    S: DiagonalSde<D>,
{
    #[inline]
    fn drift(&self, t: f64, x: &[f64; D]) -> [f64; D] {
        self.0.drift(t, x)
    }

    #[inline]
    fn intensity(&self, t: f64, x: &[f64; D]) -> [f64; D] {
        self.0.intensity(t, x)
    }

    #[inline]
    fn intensity_derivative(&self, t: f64, x: &[f64; D]) -> [f64; D] {
        self.0.intensity_derivative(t, x)
    }
}

/// The same process as a [`DiagonalSde`] in Stratonovich form: the drift is `f - b b'/2`.
///
/// Source: Kloeden and Platen 1992, eq 4.9.11.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct StratonovichForm<S>(
    /// The system in Ito form.
    pub S,
);

impl<S, const D: usize> StratonovichSde<D, D> for StratonovichForm<S>
where
    S: DiagonalSde<D>,
{
    #[inline]
    fn drift(&self, t: f64, x: &[f64; D]) -> [f64; D] {
        let mut drift = self.0.drift(t, x);
        let (b, slope) = (self.0.intensity(t, x), self.0.intensity_derivative(t, x));
        for i in 0..D {
            drift[i] -= 0.5 * b[i] * slope[i];
        }
        drift
    }

    #[inline]
    fn noise(&self, t: f64, x: &[f64; D]) -> [[f64; D]; D] {
        diagonal(self.0.intensity(t, x))
    }
}

#[inline]
fn diagonal<const D: usize>(entries: [f64; D]) -> [[f64; D]; D] {
    let mut matrix = [[0.0; D]; D];
    for i in 0..D {
        matrix[i][i] = entries[i];
    }
    matrix
}

/// Largest deviation of a system from the definition of [`DiagonalSde`] over the given states.
///
/// It compares `db_i/dx_j` by central differences with the system's derivative (`j = i`) or zero (`j != i`).
#[must_use]
pub fn check_diagonal_noise<S, const D: usize>(system: &S, t: f64, states: &[[f64; D]]) -> f64
where
    S: DiagonalSde<D>,
{
    let mut largest = 0.0_f64;
    for x in states {
        let given = system.intensity_derivative(t, x);
        for j in 0..D {
            let step = f64::EPSILON.cbrt() * x[j].abs().max(1.0);
            let (mut above, mut below) = (*x, *x);
            above[j] += step;
            below[j] -= step;
            let (b_above, b_below) = (system.intensity(t, &above), system.intensity(t, &below));
            for i in 0..D {
                let slope = (b_above[i] - b_below[i]) / (above[j] - below[j]);
                let difference = (slope - if i == j { given[i] } else { 0.0 }).abs();
                if difference.is_nan() {
                    return f64::NAN;
                }
                largest = largest.max(difference);
            }
        }
    }
    largest
}
