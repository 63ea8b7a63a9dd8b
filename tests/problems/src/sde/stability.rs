//! Mean-square amplification on `dX = l X dt + m X dB`: by quadrature over a step, and by formula.

use sde_integrators::{
    DiagonalNoise, EulerMaruyama, Heun, Increment, Integrator, Milstein, StepError,
    StochasticTheta, StratonovichForm,
};

use super::problems::Geometric;
use super::quadrature::{expectation, gauss_hermite};
use crate::context::CaseError;

/// `R(w, H)` of one step from 1.
pub type Factor<'a> =
    dyn Fn(&DiagonalNoise<Geometric>, f64, &Increment<1>) -> Result<f64, StepError> + 'a;

/// A method whose amplification has a closed form.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Formula {
    /// The theta method; 0 is Euler-Maruyama.
    Theta(f64),
    /// Milstein.
    Milstein,
    /// Heun on the Stratonovich form.
    Heun,
}

impl Formula {
    /// `E|R|^2` at `p = l h` and `q = m^2 h`.
    #[must_use]
    pub fn amplification(self, p: f64, q: f64) -> f64 {
        match self {
            Self::Theta(theta) => {
                ((1.0 + (1.0 - theta) * p).powi(2) + q) / (1.0 - theta * p).powi(2)
            }
            Self::Milstein => (1.0 + p).powi(2) + q + 0.5 * q * q,
            Self::Heun => {
                // E(1 + X + X^2/2)^2 with X normal of mean a and variance q.
                let a = p - 0.5 * q;
                let second = a * a + q;
                let third = a * a * a + 3.0 * a * q;
                let fourth = a.powi(4) + 6.0 * a * a * q + 3.0 * q * q;
                1.0 + 2.0 * a + 2.0 * second + third + 0.25 * fourth
            }
        }
    }
}

/// `E|R|^2` by quadrature.
pub fn amplification(
    system: &DiagonalNoise<Geometric>,
    dt: f64,
    factor: &Factor<'_>,
) -> Result<f64, StepError> {
    // R is of degree 4 at most in w and 1 in H: eight nodes are exact for its square.
    expectation(dt, &gauss_hermite(8), |dw| Ok(factor(system, dt, dw)?.powi(2)))
}

/// The amplification of the method that a formula belongs to, by quadrature.
pub fn amplification_of(formula: Formula, l: f64, m: f64, dt: f64) -> Result<f64, CaseError> {
    let system = DiagonalNoise(Geometric { drift: l, intensity: m });
    let by = |factor: &Factor<'_>| Ok(amplification(&system, dt, factor)?);
    match formula {
        Formula::Theta(theta) if theta > 0.0 => by(&of(&StochasticTheta::new(theta)?)),
        Formula::Theta(_) => by(&of(&EulerMaruyama)),
        Formula::Milstein => by(&of(&Milstein)),
        Formula::Heun => by(&|system, dt, dw| {
            let mut x = [1.0];
            Heun.step(&StratonovichForm(system.0), 0.0, dt, dw, &mut x, &mut ())?;
            Ok(x[0])
        }),
    }
}

/// One step from 1.
pub fn of<I>(
    method: &I,
) -> impl Fn(&DiagonalNoise<Geometric>, f64, &Increment<1>) -> Result<f64, StepError> + '_
where
    I: Integrator<DiagonalNoise<Geometric>, 1, 1>,
{
    |system, dt, dw| {
        let mut x = [1.0];
        method.step(system, 0.0, dt, dw, &mut x, &mut I::Memory::default())?;
        Ok(x[0])
    }
}

/// The largest `|l| h` up to which a method is stable on the ray `m^2 = 2 r |l|`, by quadrature. `None` above 10^4.
pub fn boundary(ray: f64, factor: &Factor<'_>) -> Result<Option<f64>, CaseError> {
    let system = DiagonalNoise(Geometric { drift: -1.0, intensity: (2.0 * ray).sqrt() });
    Ok(first_crossing(|size| amplification(&system, size, factor))?)
}

/// The boundary of the method that a formula belongs to, by quadrature.
pub fn measured_boundary(ray: f64, formula: Formula) -> Result<Option<f64>, CaseError> {
    first_crossing(|size| amplification_of(formula, -1.0, (2.0 * ray).sqrt(), size))
}

/// The same by formula.
#[must_use]
pub fn formula_boundary(ray: f64, formula: Formula) -> Option<f64> {
    let crossing = first_crossing(|size| {
        Ok::<_, std::convert::Infallible>(formula.amplification(-size, 2.0 * ray * size))
    });
    match crossing {
        Ok(size) => size,
        Err(never) => match never {},
    }
}

/// Where an amplification first exceeds 1, sought in factors of 1.005 and bisected.
fn first_crossing<E>(amplification: impl Fn(f64) -> Result<f64, E>) -> Result<Option<f64>, E> {
    let mut above = 1e-3;
    // Roundoff of a sum of terms of size 1.
    while amplification(above)? <= 1.0 + 1e-13 {
        above *= 1.005;
        if above > 1e4 {
            return Ok(None);
        }
    }
    let mut below = above / 1.005;
    for _ in 0..40 {
        let middle = 0.5 * (below + above);
        if amplification(middle)? <= 1.0 + 1e-13 { below = middle } else { above = middle }
    }
    Ok(Some(below))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// `2 (1 - r)` for Euler-Maruyama and `2 (1 - r)/(1 + 2 r^2)` for Milstein, by hand.
    #[test]
    fn the_boundaries_of_euler_and_milstein_are_those_found_by_hand() {
        for ray in [0.0_f64, 0.25, 0.5, 0.9] {
            let euler = formula_boundary(ray, Formula::Theta(0.0)).unwrap();
            assert!((euler / (2.0 - 2.0 * ray) - 1.0).abs() < 1e-9, "{euler}");
            let milstein = formula_boundary(ray, Formula::Milstein).unwrap();
            let by_hand = 2.0 * (1.0 - ray) / (1.0 + 2.0 * ray * ray);
            assert!((milstein / by_hand - 1.0).abs() < 1e-9, "{milstein}");
        }
        assert_eq!(formula_boundary(0.5, Formula::Theta(0.5)), None);
    }
}
