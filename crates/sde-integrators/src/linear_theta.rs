//! The stochastic theta method for fields, implicit in a linear part of the drift.

use crate::error::{Error, StepError};
use crate::field::{FieldIncrement, FieldIntegrator, FieldSde, Workspace};
use crate::noise_factor::{DiagonalFactor, NoiseFactor, SparseFactor};

/// A symmetric, negative semidefinite linear operator on a field.
///
/// It is the stiff part of the drift, such as a discrete Laplacian.
///
/// Implement it for a matrix-free operator. A [`SparseFactor`] with as many columns as rows and a [`DiagonalFactor`]
/// implement it with their entries.
pub trait LinearOperator: Sync {
    /// Number of rows and columns.
    fn n_unknowns(&self) -> usize;

    /// Writes `A x` into `result`.
    fn apply(&self, x: &[f64], result: &mut [f64]);
}

impl LinearOperator for SparseFactor {
    fn n_unknowns(&self) -> usize {
        NoiseFactor::n_unknowns(self)
    }

    fn apply(&self, x: &[f64], result: &mut [f64]) {
        NoiseFactor::apply(self, x, result);
    }
}

impl LinearOperator for DiagonalFactor {
    fn n_unknowns(&self) -> usize {
        NoiseFactor::n_unknowns(self)
    }

    fn apply(&self, x: &[f64], result: &mut [f64]) {
        NoiseFactor::apply(self, x, result);
    }
}

/// The stochastic theta method for fields, implicit in a linear operator `A`.
///
/// $$ (1 - \theta h A)(X_{n+1} - X_n) = h f(t_n, X_n) + a(t_n) L w $$
///
/// Solves `dX = f dt + a L dB` with additive noise. Symbols: `h` = `dt`, `f` = drift, `a` = intensity, `L w` =
/// `dw.brownian`. For `f = A x` it is the theta method itself; for `f = A x + r` the rest `r` is explicit. `A` need
/// not be the linear part of `f`: it affects stability but not the order (a W method).
///
/// Order: strong 1, weak 1; for `f = A x`, weak 2 and noise-free 2 at `theta = 1/2`.
///
/// Stable for: with `f = A x`, every `h` for `theta >= 1/2`. The stationary variance on the eigenvalue `-l` of `A` is
/// then `1/(2 l)` times `1/(1 + (theta - 1/2) h l)`: exact for the trapezoidal rule. That rule damps stiff modes by a
/// factor that tends to -1, so their initial values decay slowly.
///
/// Conjugate gradients solve the equation to a residual of [`TOLERANCE`](Self::TOLERANCE) relative to the right side,
/// in at most about `11 sqrt(1 + theta h |A|)` products with `A`.
///
/// Sources: Kloeden and Platen 1992, eq 12.2.2; the linearly implicit form: Hairer and Wanner 1996, section IV.7 (W
/// methods); the solver: Hestenes and Stiefel 1952.
///
/// ```
/// use sde_integrators::{
///     DiagonalFactor, FieldPath, FieldSde, LinearOperator, LinearTheta, Noise,
/// };
///
/// /// Second differences on a rod with cold ends, `k (x_{i-1} - 2 x_i + x_{i+1})`.
/// struct Laplacian { k: f64, n: usize }
/// impl LinearOperator for Laplacian {
///     fn n_unknowns(&self) -> usize { self.n }
///     fn apply(&self, x: &[f64], result: &mut [f64]) {
///         for i in 0..self.n {
///             let left = if i > 0 { x[i - 1] } else { 0.0 };
///             let right = if i + 1 < self.n { x[i + 1] } else { 0.0 };
///             result[i] = self.k * (left - 2.0 * x[i] + right);
///         }
///     }
/// }
///
/// struct Heat { laplacian: Laplacian, factor: DiagonalFactor }
/// impl FieldSde for Heat {
///     type Factor = DiagonalFactor;
///     fn drift(&self, _t: f64, x: &[f64], drift: &mut [f64]) { self.laplacian.apply(x, drift); }
///     fn factor(&self) -> &DiagonalFactor { &self.factor }
/// }
///
/// let n = 100;
/// let heat = Heat {
///     laplacian: Laplacian { k: 1e4, n },
///     factor: DiagonalFactor::new(vec![1.0; n])?,
/// };
/// let method = LinearTheta::new(0.5, Laplacian { k: 1e4, n })?;
/// let mut path = FieldPath::new(&heat, &method, &Noise::new(1), 0, vec![0.0; n])?;
/// // 400 times the largest step of an explicit method.
/// path.step(0.02)?;
/// # Ok::<(), sde_integrators::Error>(())
/// ```
#[derive(Debug, Clone, PartialEq)]
pub struct LinearTheta<A> {
    theta: f64,
    operator: A,
}

impl<A: LinearOperator> LinearTheta<A> {
    /// Residual that ends the iteration, relative to the right side.
    pub const TOLERANCE: f64 = 1e-10;
    /// Largest number of iterations.
    pub const MAX_ITERATIONS: usize = 10_000;

    /// A method with `0 <= theta <= 1`.
    ///
    /// # Errors
    /// [`Error::OutOfRange`].
    pub fn new(theta: f64, operator: A) -> Result<Self, Error> {
        if (0.0..=1.0).contains(&theta) {
            Ok(Self { theta, operator })
        } else {
            Err(Error::OutOfRange { quantity: "theta", value: theta, from: 0.0, to: 1.0 })
        }
    }

    /// `theta`.
    #[must_use]
    pub const fn theta(&self) -> f64 {
        self.theta
    }
}

fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

impl<A: LinearOperator> FieldIntegrator for LinearTheta<A> {
    type Memory = ();

    /// Errors: [`StepError::OperatorLength`], [`StepError::OperatorIndefinite`], [`StepError::NotConverged`].
    fn step<S: FieldSde + ?Sized>(
        &self,
        system: &S,
        t: f64,
        dt: f64,
        dw: FieldIncrement<'_>,
        x: &mut [f64],
        workspace: &mut Workspace,
        _memory: &mut (),
    ) -> Result<(), StepError> {
        let n = x.len();
        let value = self.operator.n_unknowns();
        if value != n {
            return Err(StepError::OperatorLength { value, expected: n });
        }
        let [residual, direction, image, change] = workspace.buffers(n);
        system.drift(t, x, residual);
        let intensity = system.intensity(t);
        for k in 0..n {
            residual[k] = dt * residual[k] + intensity * dw.brownian[k];
        }
        self.solve(self.theta * dt, residual, direction, image, change)?;
        for k in 0..n {
            x[k] += change[k];
        }
        Ok(())
    }
}

impl<A: LinearOperator> LinearTheta<A> {
    /// Solves `(1 - tau A) change = residual` by conjugate gradients; the right side is the first direction.
    fn solve(
        &self,
        tau: f64,
        residual: &mut [f64],
        direction: &mut [f64],
        image: &mut [f64],
        change: &mut [f64],
    ) -> Result<(), StepError> {
        let n = residual.len();
        change.fill(0.0);
        direction.copy_from_slice(residual);
        let mut square = dot(residual, residual);
        let limit = Self::TOLERANCE * square.sqrt();
        for _ in 0..Self::MAX_ITERATIONS {
            // A right side that is not finite goes into the state, where the caller detects it.
            if !square.is_finite() {
                change.copy_from_slice(residual);
                return Ok(());
            }
            if square.sqrt() <= limit {
                return Ok(());
            }
            self.operator.apply(direction, image);
            for k in 0..n {
                image[k] = direction[k] - tau * image[k];
            }
            let curvature = dot(direction, image);
            if curvature.is_nan() || curvature <= 0.0 {
                let curvature = curvature / dot(direction, direction);
                return Err(StepError::OperatorIndefinite { curvature });
            }
            let length = square / curvature;
            for k in 0..n {
                change[k] += length * direction[k];
                residual[k] -= length * image[k];
            }
            let before = std::mem::replace(&mut square, dot(residual, residual));
            for k in 0..n {
                direction[k] = residual[k] + square / before * direction[k];
            }
        }
        let (iterations, residual) = (Self::MAX_ITERATIONS, square.sqrt());
        Err(StepError::NotConverged { iterations, residual, limit })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{FieldPath, Noise};

    struct Springs {
        rates: DiagonalFactor,
        factor: DiagonalFactor,
    }

    impl FieldSde for Springs {
        type Factor = DiagonalFactor;

        fn drift(&self, _t: f64, x: &[f64], drift: &mut [f64]) {
            LinearOperator::apply(&self.rates, x, drift);
        }

        fn factor(&self) -> &DiagonalFactor {
            &self.factor
        }
    }

    fn springs(rates: [f64; 3]) -> Springs {
        let rates = DiagonalFactor::new(rates.to_vec()).unwrap();
        Springs { rates, factor: DiagonalFactor::new(vec![1.0; 3]).unwrap() }
    }

    /// On the eigenvalue `-l` a step is `x + (-l h x + w)/(1 + theta h l)`; the solver error is 1e-10.
    #[test]
    fn a_step_is_that_of_the_theta_method_on_each_eigenvalue() {
        let (system, dt) = (springs([-1.0, -30.0, -1000.0]), 0.1);
        for theta in [0.0, 0.5, 1.0] {
            let method = LinearTheta::new(theta, system.rates.clone()).unwrap();
            let w = [0.3, -0.2, 0.5];
            let mut x = [1.0, 2.0, -1.0];
            let expected: Vec<f64> = [1.0, 30.0, 1000.0]
                .iter()
                .zip(x.iter().zip(w))
                .map(|(l, (x, w))| x + (-l * dt * x + w) / (1.0 + theta * dt * l))
                .collect();
            let dw = FieldIncrement { brownian: &w, space_time_area: &[0.0; 3] };
            let mut workspace = Workspace::default();
            method.step(&system, 0.0, dt, dw, &mut x, &mut workspace, &mut ()).unwrap();
            for (x, expected) in x.iter().zip(expected) {
                assert!((x - expected).abs() < 1e-8, "theta {theta}: {x} {expected}");
            }
        }
    }

    #[test]
    fn operators_that_do_not_fit_are_typed_errors() {
        let system = springs([-1.0, -2.0, -3.0]);
        let step = |rates: Vec<f64>| {
            let method = LinearTheta::new(0.5, DiagonalFactor::new(rates).unwrap()).unwrap();
            let mut path =
                FieldPath::new(&system, &method, &Noise::new(1), 0, vec![1.0; 3]).unwrap();
            let error = path.step(1.0).unwrap_err();
            assert_eq!(path.state(), [1.0; 3]);
            let Error::Step { source, .. } = error else { panic!("{error}") };
            source
        };
        assert_eq!(step(vec![-1.0; 2]), StepError::OperatorLength { value: 2, expected: 3 });
        assert!(matches!(
            step(vec![9.0; 3]),
            StepError::OperatorIndefinite { curvature } if (curvature + 3.5).abs() < 1e-12
        ));
        for theta in [-0.1, 1.1, f64::NAN] {
            let rates = system.rates.clone();
            assert!(matches!(LinearTheta::new(theta, rates), Err(Error::OutOfRange { .. })));
        }
    }
}
