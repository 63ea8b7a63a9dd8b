//! The density of a structure behind a filter whose states are conditioned out.

use std::io::{Read, Write};

use particle_store::ParticleStore;
use sde_integrators::{Additive, GaussianComponent, GaussianMixture, Sde};

use crate::compiled::passes;
use crate::conditional_step::Conditional;
use crate::error::Error;
use crate::method::StepRule;
use crate::method::config::Config;
use crate::parallel::in_pool;
use crate::remap::rim_extrapolation::RimExtrapolation;
use crate::scheme::Scheme;
use crate::score::inverse;
use crate::simulation::Simulation;
use crate::solver::report::StepReport;
use crate::system::coefficients::OfSystem;
use crate::system::linear_filter::{FilterMoments, LinearFilter, MOST_FILTER_STATES};
use vibrating_systems::Filtered;

/// The density of a structure behind a [filter](vibrating_systems::Filter) on a lattice of the structure's states alone.
///
/// Of `dS = (a(t, S) + g(t) u) dt`, `u = c . Y`, `dY = A Y dt + b w(t) dB` it carries the density `rho` of `S`, the mean
/// `m(s)` of `Y` given `S = s` and the covariance of `Y` given `S`. Given it, the first two are exact:
///
/// $$ \frac{\partial\rho}{\partial t} + \nabla \cdot \left( (a + g\, c \cdot m) \rho \right) = 0, \qquad
///    \frac{Dm}{Dt} = A m - \frac{1}{\rho} \nabla \cdot (\rho\, g\, c^T C) . $$
///
/// Assumption: `C` does not depend on `s`. By the law of total covariance it is then that of all less that of the means,
///
/// $$ C = P - \mathrm{Cov}(m), \qquad \frac{dP}{dt} = A P + P A^T + w^2 b b^T, $$
///
/// and `P` is exact. For a linear structure and a normal start the assumption holds, and there is no error but that of
/// the lattice. For a nonlinear one the second moments of the filter stay exact, and `E[g(S) Y]` is for `g` of degree 1. The
/// error of what is nonlinear is that of the assumption: a fine lattice does not reduce it. Behind the soil of Kanai and Tajimi
/// the second moments of a damper were seen within 0.1 %, those of hysteresis that yields within 1.5 %.
///
/// **Use it** for four to six states, of which the last are a filter's: two states in place of four, three in place of
/// five. **Do not use it** where the filter is slow beside the structure and the structure is strongly nonlinear (two wells): then the
/// filter's states given those of the structure are not near a normal distribution of one covariance. Where a hardening
/// spring winds the cloud up, give the method a [`Remapping`](crate::Remapping): on one lattice the tail is lost first, then the
/// moments. With it the moments of a cubic spring stay within 0.2 %.
///
/// Particles carry `s` and `m`. The density and its gradient are those of the flow-map fit.
/// Source: this project; the equations are the first two moments of the Fokker-Planck equation of `(S, Y)` in `Y`.
///
/// ```
/// use vibrating_systems::{
///     Filter, Filtered, KanaiTajimiParameters, LinearOscillator, LinearOscillatorParameters, Window,
/// };
/// use fpk_sph::{ConditionedSimulation, Config, DEFAULT_MOST_STEPS, InitialLattice, Method};
/// use sde_integrators::GaussianMixture;
///
/// let structure = LinearOscillator::new(LinearOscillatorParameters {
///     natural_frequency: 3.14,
///     damping_ratio: 0.05,
///     noise_intensity: 0.2,
///     window: Window::CANOR_DENOEL_2013,
/// })?;
/// let soil = KanaiTajimiParameters { ground_frequency: 15.6, ground_damping: 0.6 };
/// let shaken = Filtered::new(structure, Filter::kanai_tajimi(soil)?, Window::Stationary)?;
/// let law: GaussianMixture<4> = shaken.initial_distribution(&[0.0, 0.0], &[0.05, 0.15])?;
/// let config = Config {
///     method: Method::FlowMapFit,
///     lattice: InitialLattice::Ball { reach: 5.0, spacing: 0.5 },
///     reference_period: 2.0,
///     most_steps: DEFAULT_MOST_STEPS,
/// };
/// let mut simulation = ConditionedSimulation::new(&shaken, &law, &config)?;
/// simulation.advance_to(1.0)?;
/// // E[q q], and E[x_g x_g], which stays 1/(4 zeta_g omega_g^3).
/// let moments = simulation.second_moments::<4>();
/// assert!((moments[0][0] - simulation.structure().raw_moment([2, 0])).abs() < 1e-15);
/// assert!((moments[2][2] * 4.0 * 0.6 * 15.6_f64.powi(3) - 1.0).abs() < 1e-5);
/// # Ok::<(), fpk_sph::Error>(())
/// ```
#[derive(Debug)]
pub struct ConditionedSimulation<S, const DS: usize, const DF: usize> {
    structure: Simulation<S, DS, 1>,
    conditional: Conditional<DS>,
}

impl<S, const DS: usize, const DF: usize> ConditionedSimulation<S, DS, DF>
where
    S: Sde<DS, 1, Noise = Additive>,
{
    /// Places the particles on a lattice over the structure's initial distribution, at `t = 0`, with the means of the filter
    /// given their places. `law` is that of the structure's and the filter's states, `D = DS + DF`.
    ///
    /// # Errors
    /// Those of [`Simulation::new`]; [`Error::NotConditioned`] for a method other than a flow-map fit stepped by
    /// Runge-Kutta 4, or with the rule of Courant; [`Error::ConditionedMixture`] for a distribution of
    /// several components; [`Error::SingularCovariance`] for a filter with a state that its noise does not reach.
    pub fn new<const D: usize>(
        system: &Filtered<S, DS, DF>,
        law: &GaussianMixture<D>,
        config: &Config<DS>,
    ) -> Result<Self, Error>
    where
        S: Clone,
    {
        const { assert!(D == DS + DF, "the law needs the states of structure and filter") };
        const { assert!(DF <= MOST_FILTER_STATES, "a state has six entries at most") };
        check(config)?;
        let count = law.components().len();
        let (1, Some(normal)) = (count, law.components().next()) else {
            return Err(Error::ConditionedMixture { count });
        };
        let split: Split<DS, DF> = split(normal)?;
        let Split { structure: of_structure, gain, filter_mean, covariance } = split;
        let mean = of_structure.mean();
        let structure = Simulation::new(system.structure().clone(), &of_structure, config)?;
        let discretisation = &structure.solver.discretisation;
        if discretisation.estimator.criterion().is_some() {
            let found = "an estimator that searches its neighbours".to_owned();
            return Err(Error::NotConditioned { found, must: "the flow-map fit" });
        }
        let rim = RimExtrapolation::new(&discretisation.lattice)?;
        let filter = LinearFilter::new(system.filter(), system.noise_window())?;
        let mut moments = FilterMoments::zeros(structure.n_particles(), DF);
        for (m, x) in moments.means.chunks_exact_mut(DF).zip(structure.positions()) {
            for k in 0..DF {
                let departure = (0..DS).map(|l| gain[k][l] * (x[l] - mean[l])).sum::<f64>();
                m[k] = filter_mean[k] + departure;
            }
        }
        for k in 0..DF {
            moments.covariance[k][..DF].copy_from_slice(&covariance[k]);
        }
        Ok(Self { structure, conditional: Conditional::new(filter, moments, rim) })
    }

    /// The density of the structure alone: positions, masses, moments, probabilities of exceedance, entropy. Its system is the
    /// structure without the filter.
    pub fn structure(&self) -> &Simulation<S, DS, 1> {
        &self.structure
    }

    /// Time of the state.
    pub fn time(&self) -> f64 {
        self.structure.time()
    }

    /// The means of the filter's states given the structure's, at every particle.
    pub fn conditional_means(&self) -> impl ExactSizeIterator<Item = [f64; DF]> {
        let means = &self.conditional.moments.means;
        means.chunks_exact(DF).map(|m| std::array::from_fn(|k| m[k]))
    }

    /// The covariance `C` of the filter's states given the structure's, the same for all.
    #[must_use]
    pub fn conditional_covariance(&self) -> [[f64; DF]; DF] {
        let Conditional { filter, moments, .. } = &self.conditional;
        let covariance = filter.conditional_covariance(moments, self.structure.masses());
        std::array::from_fn(|k| std::array::from_fn(|l| covariance[k][l]))
    }

    /// `E[x_k x_l]` over the states of the structure and then of the filter, `D = DS + DF`, as
    /// [`Simulation::raw_moment`] not divided by the total mass.
    #[must_use]
    pub fn second_moments<const D: usize>(&self) -> [[f64; D]; D] {
        const { assert!(D == DS + DF, "the moments are those of structure and filter") };
        let (covariance, mut moments) = (self.conditional_covariance(), [[0.0; D]; D]);
        let particles = self.structure.positions().iter().zip(self.structure.masses());
        for ((s, mu), m) in particles.zip(self.conditional_means()) {
            let x: [f64; D] = std::array::from_fn(|k| if k < DS { s[k] } else { m[k - DS] });
            for k in 0..D {
                for l in 0..D {
                    let spread = if k.min(l) < DS { 0.0 } else { covariance[k - DS][l - DS] };
                    moments[k][l] += mu * (x[k] * x[l] + spread);
                }
            }
        }
        moments
    }

    /// One step of the rule's own length, after a remeshing where the method has one and the cloud is too uneven: the means are
    /// interpolated as the density is, and extrapolated to the rim.
    ///
    /// # Errors
    /// As [`Simulation::step`]; [`Error::NoConditionalVariance`] where the means leave the filter no variance. The state is then
    /// that before the step, or that after the remeshing before it.
    pub fn step(&mut self) -> Result<StepReport, Error> {
        self.step_towards(f64::INFINITY)
    }

    /// One step, not beyond `end`. [`StepReport::diffusion_limit`] is the largest step that keeps waves of one spacing stable.
    ///
    /// # Errors
    /// As [`Self::step`]; [`Error::TimeInThePast`] unless `end` lies ahead.
    pub fn step_towards(&mut self, end: f64) -> Result<StepReport, Error> {
        let Simulation { system, solver } = &mut self.structure;
        let (n, conditional) = (solver.n_particles(), &mut self.conditional);
        let system = OfSystem(&*system);
        in_pool(n, || (passes().conditional_step)(solver, conditional, &system, end))
    }

    /// Steps to the given time, landing on it exactly.
    ///
    /// # Errors
    /// Those of [`Self::step`]; [`Error::TimeInThePast`].
    pub fn advance_to(&mut self, time: f64) -> Result<(), Error> {
        self.advance_while(time, |_| true)
    }

    /// As [`Simulation::advance_while`].
    ///
    /// # Errors
    /// As [`advance_to`](Self::advance_to).
    pub fn advance_while(
        &mut self,
        time: f64,
        mut goes_on: impl FnMut(f64) -> bool,
    ) -> Result<(), Error> {
        self.structure.solver.check_not_past(time)?;
        while self.time() < time && goes_on(self.time()) {
            let _ = self.step_towards(time)?;
        }
        Ok(())
    }

    /// Writes the state and its lattice; reading restores both bitwise.
    ///
    /// # Errors
    /// [`Error::Store`] where the writer fails.
    pub fn snapshot(&self, mut writer: impl Write) -> Result<(), Error> {
        let mut store = self.structure.solver.store()?;
        self.conditional.save(&mut store)?;
        store.snapshot(&mut writer)?;
        Ok(())
    }

    /// Takes state and lattice from a snapshot of a simulation with the same configuration; the run continues bitwise
    /// identically.
    ///
    /// # Errors
    /// [`Error::ForeignSnapshot`], [`Error::SnapshotWithoutTime`], [`Error::SnapshotNumber`], [`Error::Store`]; the state is
    /// then as it was.
    pub fn restore(&mut self, mut reader: impl Read) -> Result<(), Error> {
        let store = ParticleStore::<DS>::restore(&mut reader)?;
        let moments = self.conditional.read(&store)?;
        let Simulation { solver, .. } = &mut self.structure;
        let before = solver.store()?;
        solver.take(&store)?;
        match RimExtrapolation::new(&solver.discretisation.lattice) {
            Ok(rim) => self.conditional.start_on(moments, rim),
            Err(error) => {
                solver.take(&before)?;
                return Err(error);
            }
        }
        Ok(())
    }
}

/// Refuses a method whose scheme, rule or lattices do not carry the means.
fn check<const D: usize>(config: &Config<D>) -> Result<(), Error> {
    let combination = config.method.combination_in(D);
    let refuse = |found, must| Err(Error::NotConditioned { found, must });
    if combination.scheme != Scheme::RungeKutta4 {
        return refuse(format!("the scheme {:?}", combination.scheme), "the scheme RungeKutta4");
    }
    if let StepRule::Courant { number } = combination.step {
        return refuse(format!("the Courant number {number}"), "steps that the waves limit");
    }
    Ok(())
}

/// A normal distribution of structure and filter: that of the structure, and the filter's given the structure's states,
/// `filter_mean + gain (s - mean)`, with the covariance of the filter's states in all.
struct Split<const DS: usize, const DF: usize> {
    structure: GaussianMixture<DS>,
    gain: [[f64; DS]; DF],
    filter_mean: [f64; DF],
    covariance: [[f64; DF]; DF],
}

fn split<const DS: usize, const DF: usize, const D: usize>(
    normal: &GaussianComponent<D>,
) -> Result<Split<DS, DF>, Error> {
    let GaussianComponent { mean, covariance, .. } = normal;
    let of_structure: [[f64; DS]; DS] =
        std::array::from_fn(|k| std::array::from_fn(|l| covariance[k][l]));
    let structure = GaussianMixture::gaussian(std::array::from_fn(|k| mean[k]), of_structure)?;
    let Some(inverse) = inverse(&of_structure) else {
        return Err(Error::NotFinite { name: "inverse of the covariance", value: f64::INFINITY });
    };
    let cross = |k: usize, l: usize| -> f64 {
        (0..DS).map(|j| covariance[DS + k][j] * inverse[j][l]).sum()
    };
    Ok(Split {
        structure,
        gain: std::array::from_fn(|k| std::array::from_fn(|l| cross(k, l))),
        filter_mean: std::array::from_fn(|k| mean[DS + k]),
        covariance: std::array::from_fn(|k| std::array::from_fn(|l| covariance[DS + k][DS + l])),
    })
}
