//! The exact law of a linear system under a method, without sampling: a step is an affine map of state and noise,
//! found by probing it with unit vectors.

use sde_integrators::{Increment, Integrator, StepError};

/// A matrix, row by row.
pub type Matrix = Vec<Vec<f64>>;

/// `x -> a x + by_w w + by_h H` for one Brownian motion, of a system without a constant term.
#[derive(Debug, Clone)]
pub struct StepMap {
    /// How the state enters.
    pub a: Matrix,
    /// How `w` enters.
    pub by_w: Vec<f64>,
    /// How `H` enters.
    pub by_h: Vec<f64>,
}

/// The map of one step, and that from the state to what the method remembers: `read(memory)`.
pub fn probe<S, I, const D: usize, const R: usize>(
    system: &S,
    method: &I,
    dt: f64,
    read: impl Fn(&[f64; D], &I::Memory) -> [f64; R],
) -> Result<(StepMap, StepMap), StepError>
where
    I: Integrator<S, D, 1>,
{
    let image = |x: [f64; D], w: f64, h: f64| -> Result<(Vec<f64>, Vec<f64>), StepError> {
        let dw = Increment { brownian: [w], space_time_area: [h] };
        let (mut x, mut memory) = (x, I::Memory::default());
        method.step(system, 0.0, dt, &dw, &mut x, &mut memory)?;
        Ok((x.to_vec(), read(&x, &memory).to_vec()))
    };
    let state = StepMap::of(|x, w, h| Ok(image(x, w, h)?.0))?;
    let memory = StepMap::of(|x, w, h| Ok(image(x, w, h)?.1))?;
    Ok((state, memory))
}

impl StepMap {
    /// The map of a function of state, `w` and `H` that is linear in all of them.
    pub fn of<E, const D: usize>(
        image: impl Fn([f64; D], f64, f64) -> Result<Vec<f64>, E>,
    ) -> Result<Self, E> {
        let unit = |j: usize| std::array::from_fn(|i| f64::from(u8::from(i == j)));
        let columns: Matrix = (0..D).map(|j| image(unit(j), 0.0, 0.0)).collect::<Result<_, _>>()?;
        let (by_w, by_h) = (image([0.0; D], 1.0, 0.0)?, image([0.0; D], 0.0, 1.0)?);
        Ok(Self { a: transpose(&columns), by_w, by_h })
    }

    /// `a P a^T` and the covariance that the noise of one step of length `dt` adds.
    #[must_use]
    pub fn covariance(&self, p: &Matrix, dt: f64) -> Matrix {
        let noise = |i: usize, j: usize| {
            dt * self.by_w[i] * self.by_w[j] + dt / 12.0 * self.by_h[i] * self.by_h[j]
        };
        let mut moved = multiply(&multiply(&self.a, p), &transpose(&self.a));
        for (i, row) in moved.iter_mut().enumerate() {
            for (j, entry) in row.iter_mut().enumerate() {
                *entry += noise(i, j);
            }
        }
        moved
    }

    /// The solution of `P = a P a^T + Q`, the discrete Lyapunov equation, by doubling: after `k` rounds the first `2^k`
    /// terms of its series. `None` where the method is unstable.
    #[must_use]
    pub fn stationary(&self, dt: f64) -> Option<Matrix> {
        let n = self.by_w.len();
        let zero = vec![vec![0.0; n]; n];
        let (mut a, mut p) = (self.a.clone(), self.covariance(&zero, dt));
        for _ in 0..60 {
            let moved = multiply(&multiply(&a, &p), &transpose(&a));
            for (row, by) in p.iter_mut().zip(&moved) {
                row.iter_mut().zip(by).for_each(|(p, by)| *p += by);
            }
            a = multiply(&a, &a);
        }
        let settled = a.iter().flatten().all(|entry| entry.abs() < 1e-30);
        (settled && p.iter().flatten().all(|entry| entry.is_finite())).then_some(p)
    }

    /// The largest modulus of the eigenvalues of a 2 x 2 map.
    #[must_use]
    pub fn spectral_radius(&self) -> f64 {
        let a = &self.a;
        let half_trace = 0.5 * (a[0][0] + a[1][1]);
        let determinant = a[0][0] * a[1][1] - a[0][1] * a[1][0];
        let discriminant = half_trace * half_trace - determinant;
        if discriminant < 0.0 { determinant.sqrt() } else { half_trace.abs() + discriminant.sqrt() }
    }
}

fn transpose(a: &Matrix) -> Matrix {
    (0..a.first().map_or(0, Vec::len)).map(|j| a.iter().map(|row| row[j]).collect()).collect()
}

fn multiply(a: &Matrix, b: &Matrix) -> Matrix {
    let columns = transpose(b);
    let dot = |x: &[f64], y: &[f64]| x.iter().zip(y).map(|(x, y)| x * y).sum();
    a.iter().map(|row| columns.iter().map(|column| dot(row, column)).collect()).collect()
}
