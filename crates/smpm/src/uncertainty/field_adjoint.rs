//! Gradients of a few responses by any number of coefficients, by reverse mode.

use perturbation_moments::{Jet, LANES};

use super::field_study::{FieldExperiment, FieldStudy};
use crate::error::{Error, positive};
use crate::reverse::{SweepCost, Task, sensitivities};

/// Gradients of responses by the coefficients of the fields, without curvatures.
#[derive(Debug, Clone, PartialEq)]
pub struct AdjointGradient {
    /// By response asked for, then coefficient.
    pub gradients: Vec<Vec<f64>>,
    /// What the run has cost, reversed once for all responses.
    pub cost: SweepCost,
}

impl AdjointGradient {
    /// The variance of a response to first order: $\sum_k g_k^2$.
    #[must_use]
    pub fn variance(&self, response: usize) -> f64 {
        self.gradients[response].iter().map(|g| g * g).sum()
    }
}

impl<X: FieldExperiment<D>, const D: usize> FieldStudy<'_, X, D> {
    /// Gradients of responses, by their numbers, by all coefficients: one run forward and one reversed for all of them, whatever the
    /// number of coefficients.
    ///
    /// $$ \frac{\partial y}{\partial \xi_k} = \bar s^0 \cdot \frac{\partial s^0}{\partial \xi_k}, \qquad
    ///    \bar s^n = \Big( \frac{\partial F_n}{\partial s^n} \Big)^T \bar s^{n+1} $$
    ///
    /// Symbols: `s` = all numbers of all particles; `F` = a step. Equal to [`gradient`](Self::gradient) within roundoff; without
    /// curvatures and distances to switches, so the mean is that of first order. At most `memory` bytes of states are kept
    /// between steps; with fewer than one state for each step, steps are run again ([`revolve`](super::revolve)). Derivatives of
    /// eight responses are carried at once: besides the states, each eight of them take 64 bytes for each number of a particle.
    ///
    /// For stress last and modified stress last, FLIP and APIC, hats and B-splines, bonded bodies and every material; the
    /// coefficients may enter by what particles have at the start: constants of [`Body::varying`](crate::Body::varying), densities,
    /// states.
    ///
    /// Source: Griewank and Walther 2000.
    ///
    /// # Errors
    /// [`Error::NotReversed`] for other schemes, and for coefficients in a material that does not vary; [`Error::AdjointMemory`] for
    /// less than one state; [`Error::NoSuchResponse`]; those of the experiment and of the runs.
    pub fn gradient_by_adjoint(
        &self,
        responses: &[usize],
        memory: usize,
    ) -> Result<AdjointGradient, Error> {
        self.gradient_by_adjoint_at(&vec![0.0; self.n_coefficients()], responses, memory)
    }

    /// The same at a realisation, by the steps of the reference run.
    ///
    /// # Errors
    /// As [`gradient_by_adjoint`](Self::gradient_by_adjoint); [`Error::OtherCoefficients`].
    pub fn gradient_by_adjoint_at(
        &self,
        coefficients: &[f64],
        responses: &[usize],
        memory: usize,
    ) -> Result<AdjointGradient, Error> {
        let n = self.n_coefficients();
        self.check(coefficients.len())?;
        // Every coefficient has a slope, in eight ways that do not cancel.
        let slopes =
            |k: usize| std::array::from_fn(|lane| (1.0 + k as f64 + 0.37 * lane as f64).sin());
        let seeds: Vec<Jet> = (0..n).map(|k| Jet::new(coefficients[k], slopes(k))).collect();
        let mut found = sensitivities(Task {
            run: self.experiment().simulation(coefficients)?,
            jets: self.experiment().simulation(&seeds)?,
            plan: self.plan(),
            schedule: self.schedule(),
            responses,
            memory,
        })?;
        let mut gradients = vec![Vec::with_capacity(n); responses.len()];
        for first in (0..n).step_by(LANES) {
            let lane = |k: usize| k.checked_sub(first).unwrap_or(LANES);
            let seeds: Vec<Jet> = (0..n).map(|k| Jet::variable(coefficients[k], lane(k))).collect();
            let slopes = found.by(&self.experiment().simulation(&seeds)?)?;
            for (gradient, slopes) in gradients.iter_mut().zip(&slopes) {
                gradient.extend(&slopes[..LANES.min(n - first)]);
            }
        }
        Ok(AdjointGradient { gradients, cost: found.cost })
    }

    /// Products of the second derivatives of responses with directions, by central differences of gradients by reverse mode, `step` to
    /// either side of the reference run: two gradients for each direction, whatever the number of coefficients. By response asked
    /// for, direction, then coefficient.
    ///
    /// $$ H d \approx \frac{g(h d) - g(-h d)}{2 h} $$
    ///
    /// Symbols: `g` = gradient, `H` = second derivatives, `d` = direction, `h` = step. The error is of second order in the step, and
    /// roundoff of the gradient over it; beyond a switch that lies within a step it is of zeroth order.
    ///
    /// Source: Chen, Villa and Ghattas 2018, who take the leading eigenvalues of `H` from such products.
    ///
    /// # Errors
    /// As [`gradient_by_adjoint`](Self::gradient_by_adjoint); [`Error::NotPositive`] for the step, [`Error::OtherCoefficients`] for a
    /// direction of another length.
    pub fn hessian_products(
        &self,
        responses: &[usize],
        directions: &[Vec<f64>],
        (step, memory): (f64, usize),
    ) -> Result<Vec<Vec<Vec<f64>>>, Error> {
        positive("step of differences", step)?;
        let mut products = vec![Vec::with_capacity(directions.len()); responses.len()];
        for direction in directions {
            let at = |step: f64| {
                let coefficients: Vec<f64> = direction.iter().map(|d| step * d).collect();
                self.gradient_by_adjoint_at(&coefficients, responses, memory)
            };
            let (above, below) = (at(step)?, at(-step)?);
            let both = above.gradients.iter().zip(&below.gradients);
            for (of_response, (above, below)) in products.iter_mut().zip(both) {
                let slope = |(a, b): (&f64, &f64)| (a - b) / (2.0 * step);
                of_response.push(above.iter().zip(below).map(slope).collect());
            }
        }
        Ok(products)
    }
}
