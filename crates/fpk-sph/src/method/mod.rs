//! Which combination of choices carries the density: named methods and their parts, the configuration of a simulation, and
//! the conditions of a remapping.
//!
//! Choices are values that are checked here and carried out elsewhere. This folder names estimators, since a choice builds
//! its own, but it knows no particles, no solver and no step.

pub(crate) mod config;
pub(crate) mod remapping;

use smoothing_kernels::Lucy;

use self::remapping::Remapping;
use crate::cloud::metric::Metric;
use crate::error::{Error, positive, within};
use crate::scheme::Scheme;
use crate::score::settling::Settling;
use crate::score::{Degree, FlowMapFit, ScoreEstimator, SummationDensity};

/// A named combination of estimator, metric, smoothing lengths and time stepping.
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub enum Method {
    /// The paper as printed: summation density with Lucy's kernel, state coordinates, forward Euler with Courant number
    /// 0.8 (Canor & Denoël 2013, eq 9, 15, 16, 18-20, 23). `support_radius / spacing = 2.5` at the start, which the
    /// paper does not give. Its lattice in section 4.1 is
    /// [`InitialLattice::CANOR_DENOEL_2013`](crate::InitialLattice::CANOR_DENOEL_2013).
    CanorDenoel2013,
    /// A cubic flow-map fit over the lattice of the start, in whitened coordinates, with deformed cells as volumes.
    /// Runge-Kutta 4 with steps up to a fortieth of the period, within the diffusion limit. From five states on the fit is
    /// quadratic ([`Self::combination_in`]).
    FlowMapFit,
    /// Any other combination.
    Custom(Combination),
}

/// The parts of a method.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Combination {
    /// How density and score are estimated.
    pub estimator: Estimator,
    /// In which coordinates.
    pub metric: Metric,
    /// `support_radius / spacing` of the initial lattice, whatever the kernel; the spacing is the D-th root of the cell
    /// volume in the coordinates of the metric.
    pub support_over_spacing: f64,
    /// The scheme in time.
    pub scheme: Scheme,
    /// The rule that sets the step.
    pub step: StepRule,
    /// Conditions for remeshing; `None` switches it off.
    pub remapping: Option<Remapping>,
    /// The part of the second moments whose cells the diffusion limit leaves out, from 0 to [`MOST_NEGLIGIBLE`] (no unit):
    /// `sum mu_i |y_i|^2` over the cells that spread fastest, over that of all, in the coordinates of the metric.
    ///
    /// The step may exceed the limit of stability there. Waves of one spacing then grow until cells turn over, which the
    /// estimator repairs, so positions in the tails are less accurate. 0 keeps every cell stable.
    pub negligible: f64,
}

/// The largest [`Combination::negligible`].
pub const MOST_NEGLIGIBLE: f64 = 0.03;

/// The estimators of this crate, with Lucy's kernel. Others come through
/// [`Simulation::with_estimator`](crate::Simulation::with_estimator).
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Estimator {
    /// [`SummationDensity`].
    SummationDensity,
    /// [`FlowMapFit`].
    FlowMapFit {
        /// Degree of the local polynomial.
        degree: Degree,
        /// The thinnest cell that is resolved, in spacings.
        thinnest: f64,
        /// How fast positions lose what the fit does not see.
        settling: Settling,
    },
}

/// What sets the step.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum StepRule {
    /// `dt = C min_i h_i / |v_i|` in the coordinates of the metric (Canor & Denoël 2013, below eq 16, which gives neither
    /// norm nor diffusion limit).
    Courant {
        /// `C`.
        number: f64,
    },
    /// Always `dt`; an error where that exceeds the diffusion limit.
    Fixed {
        /// The step (time).
        dt: f64,
    },
    /// The diffusion limit, at most `longest`.
    DiffusionLimited {
        /// The longest step (time).
        longest: f64,
    },
    /// The diffusion limit, at most the given part of the reference period.
    PeriodFraction {
        /// Steps per reference period at the least.
        steps_per_period: f64,
    },
}

impl StepRule {
    /// The longest step that the rule allows, whatever the limits.
    pub(crate) fn longest(self, reference_period: f64) -> f64 {
        match self {
            Self::Courant { .. } => f64::INFINITY,
            Self::Fixed { dt } => dt,
            Self::DiffusionLimited { longest } => longest,
            Self::PeriodFraction { steps_per_period } => reference_period / steps_per_period,
        }
    }
}

impl Method {
    /// The parts of the method for a state with so many components: those of [`Self::combination`], but for the flow-map
    /// fit.
    ///
    /// In one dimension a support of 2.8 spacings holds five places where the cubic asks six: it is 3.2 there, with seven.
    /// From five on the fit is quadratic over 2.3 spacings: a cubic in five variables has 56 unknowns, and 2.8 spacings
    /// hold 900 neighbours; 1.75 hold 130, which leave modes at the scale of the lattice free to grow.
    #[must_use]
    pub fn combination_in(self, dimension: usize) -> Combination {
        match self {
            Self::FlowMapFit if dimension == 1 => {
                Combination { support_over_spacing: 3.2, ..self.combination() }
            }
            Self::FlowMapFit if dimension >= 5 => Combination {
                estimator: Estimator::FlowMapFit {
                    degree: Degree::Quadratic,
                    thinnest: 0.2,
                    settling: Settling::UNIFORM,
                },
                support_over_spacing: 2.3,
                ..self.combination()
            },
            _ => self.combination(),
        }
    }

    /// The parts of the method in two to four dimensions.
    #[must_use]
    pub fn combination(self) -> Combination {
        match self {
            Self::CanorDenoel2013 => Combination {
                estimator: Estimator::SummationDensity,
                metric: Metric::Isotropic,
                support_over_spacing: 2.5,
                scheme: Scheme::ForwardEuler,
                step: StepRule::Courant { number: 0.8 },
                remapping: None,
                negligible: 0.0,
            },
            Self::FlowMapFit => Combination {
                estimator: Estimator::FlowMapFit {
                    degree: Degree::Cubic,
                    thinnest: 0.2,
                    settling: Settling::UNIFORM,
                },
                metric: Metric::Whitened,
                support_over_spacing: 2.8,
                scheme: Scheme::RungeKutta4,
                step: StepRule::PeriodFraction { steps_per_period: 40.0 },
                remapping: None,
                negligible: 0.0,
            },
            Self::Custom(combination) => combination,
        }
    }
}

impl Combination {
    /// Refuses numbers outside their range.
    pub(crate) fn check(&self) -> Result<(), Error> {
        positive("support_over_spacing", self.support_over_spacing)?;
        within("negligible", self.negligible, 0.0, MOST_NEGLIGIBLE)?;
        if let Estimator::FlowMapFit { thinnest, .. } = self.estimator {
            positive("thinnest", thinnest)?;
        }
        if let Some(remapping) = self.remapping {
            remapping.check()?;
            if self.metric != Metric::Whitened {
                return Err(Error::NotWhitened);
            }
        }
        match self.step {
            StepRule::Courant { number } => positive("courant number", number),
            StepRule::Fixed { dt } => positive("dt", dt),
            StepRule::DiffusionLimited { longest } => positive("longest step", longest),
            StepRule::PeriodFraction { steps_per_period } => {
                positive("steps_per_period", steps_per_period)
            }
        }
    }
}

impl Estimator {
    /// The estimator as an object.
    #[must_use]
    pub fn build<const D: usize>(self) -> Box<dyn ScoreEstimator<D> + Sync> {
        match self {
            Self::SummationDensity => Box::new(SummationDensity { kernel: Lucy }),
            Self::FlowMapFit { degree, thinnest, settling } => {
                Box::new(FlowMapFit::with_settling(degree, thinnest, settling))
            }
        }
    }
}
