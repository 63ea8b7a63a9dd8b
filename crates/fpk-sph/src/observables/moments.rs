//! Sums over particles: moments, total mass, entropy, and the two estimators of exceedance that only count masses.

use sde_integrators::Sde;

use crate::error::{Error, finite};
use crate::simulation::Simulation;
use crate::solver::Solver;
use crate::solver::evaluation::Evaluation;

impl<S: Sde<D, M>, const D: usize, const M: usize> Simulation<S, D, M> {
    /// `E[x_1^a_1 .. x_D^a_D] = sum_i mu_i prod_k x_ik^a_k` (Canor & Denoël 2013, eq 22, where `psi_i dV_i` is `mu_i` by
    /// definition). It is not divided by the total mass.
    pub fn raw_moment(&self, powers: [u32; D]) -> f64 {
        self.expectation(|x| monomial(x, powers))
    }

    /// `sum_i mu_i prod_k |x_ik|^a_k`: the scale of the error of a moment whose terms cancel.
    pub fn absolute_moment(&self, powers: [u32; D]) -> f64 {
        self.expectation(|x| monomial(x, powers).abs())
    }

    /// `E[f(x)] = sum_i mu_i f(x_i)`.
    pub fn expectation(&self, f: impl Fn(&[f64; D]) -> f64) -> f64 {
        self.positions().iter().zip(self.masses()).map(|(x, mu)| mu * f(x)).sum()
    }

    /// `sum mu_i`: 1 less what lay beyond the lattice at the start.
    pub fn total_mass(&self) -> f64 {
        self.masses().iter().sum()
    }

    /// The probability that no particle carries, at most: what lay beyond the lattice at the start, `|1 - sum mu_i|`, and the
    /// method's limit for the outermost layer, once for each remeshing.
    ///
    /// A probability of exceedance by counting masses is low by up to this much.
    pub fn mass_outside(&self) -> f64 {
        self.solver.mass_outside()
    }

    /// Density at the particles, in the units of the state, by the method's own estimator.
    ///
    /// # Errors
    /// Those of the metric and of the estimator.
    pub fn density(&self) -> Result<Vec<f64>, Error> {
        density(&self.solver)
    }

    /// `E[-log psi] = -sum mu_i log psi_i`, in nats.
    ///
    /// # Errors
    /// Those of [`Self::density`].
    pub fn entropy(&self) -> Result<f64, Error> {
        entropy(&self.solver)
    }

    /// Relative L2 error against a density that is known,
    /// `sqrt(sum V_i (psi_i - psi(x_i))^2 / sum V_i psi(x_i)^2)`, with the particles' volumes as weights.
    ///
    /// # Errors
    /// Those of [`Self::density`].
    pub fn density_error(&self, exact: impl Fn(&[f64; D]) -> f64) -> Result<f64, Error> {
        let exact: Vec<f64> = self.positions().iter().map(exact).collect();
        density_error(&self.solver, &exact)
    }

    /// `P(y > T) = sum mu_i I(y(x_i) > T)`: the paper's estimator (Canor & Denoël 2013, eq 25). It is a staircase in `T`.
    ///
    /// # Errors
    /// [`Error::NotFinite`] for the threshold.
    pub fn exceedance_indicator(
        &self,
        demand: impl Fn(&[f64; D]) -> f64,
        threshold: f64,
    ) -> Result<f64, Error> {
        finite("threshold", threshold)?;
        Ok(self.expectation(|x| f64::from(u8::from(demand(x) > threshold))))
    }

    /// `P(y > T)` by interpolating the logarithm of the particles' complementary distribution linearly in `y`, a
    /// particle's own mass counted half at its place. Zero beyond the last particle: then no
    /// more is known than that it is below [`Self::mass_outside`].
    ///
    /// # Errors
    /// [`Error::NotFinite`] for the threshold or a demand.
    pub fn exceedance_log_interpolated(
        &self,
        demand: impl Fn(&[f64; D]) -> f64,
        threshold: f64,
    ) -> Result<f64, Error> {
        finite("threshold", threshold)?;
        let particles = self.positions().iter().map(demand).zip(self.masses().iter().copied());
        log_interpolated(particles.collect(), threshold)
    }
}

fn monomial<const D: usize>(x: &[f64; D], powers: [u32; D]) -> f64 {
    let power = |(x_k, a): (&f64, u32)| x_k.powi(i32::try_from(a).unwrap_or(i32::MAX));
    x.iter().zip(powers).map(power).product()
}

fn density<const D: usize>(solver: &Solver<D>) -> Result<Vec<f64>, Error> {
    let evaluation = solver.evaluated()?;
    let determinant = evaluation.cloud.whitening.determinant();
    Ok(evaluation.estimates.density.iter().map(|psi| psi / determinant).collect())
}

fn entropy<const D: usize>(solver: &Solver<D>) -> Result<f64, Error> {
    let density = density(solver)?;
    Ok(density.iter().zip(&solver.state.masses).map(|(psi, mu)| -mu * psi.ln()).sum())
}

/// The error against the exact density at every particle.
fn density_error<const D: usize>(solver: &Solver<D>, exact: &[f64]) -> Result<f64, Error> {
    let Evaluation { cloud, estimates, .. } = solver.evaluated()?;
    let determinant = cloud.whitening.determinant();
    let (mut square_error, mut square) = (0.0, 0.0);
    for ((reference, psi), volume) in exact.iter().zip(&estimates.density).zip(&estimates.volume) {
        square_error += volume * (psi / determinant - reference).powi(2);
        square += volume * reference * reference;
    }
    Ok((square_error / square).sqrt())
}

/// `P(y > T)` from the demand and the mass of every particle.
fn log_interpolated(mut particles: Vec<(f64, f64)>, threshold: f64) -> Result<f64, Error> {
    if let Some(&(value, _)) = particles.iter().find(|(y, _)| !y.is_finite()) {
        return Err(Error::NotFinite { name: "demand", value });
    }
    particles.sort_unstable_by(|a, b| b.0.total_cmp(&a.0));
    let mut above: Option<(f64, f64)> = None;
    let mut mass_beyond = 0.0;
    for level in particles.chunk_by(|a, b| a.0.total_cmp(&b.0).is_eq()) {
        let y = level[0].0;
        let mass: f64 = level.iter().map(|(_, mu)| mu).sum();
        let exceeded = mass_beyond + 0.5 * mass;
        if y <= threshold {
            return Ok(above.map_or(0.0, |(y_above, exceeded_above)| {
                let fraction = (threshold - y) / (y_above - y);
                (exceeded.ln() + fraction * (exceeded_above / exceeded).ln()).exp()
            }));
        }
        above = Some((y, exceeded));
        mass_beyond += mass;
    }
    Ok(mass_beyond)
}
