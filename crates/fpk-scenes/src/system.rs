//! A checked system of a scene, and its properties in any dimension.

use vibrating_systems::{
    Bistable, BoucWen, CoxIngersollRoss, Duffing, Filtered, GeometricBrownianMotion,
    LinearOscillator, OrnsteinUhlenbeck, TwoStorey, VanDerPolRayleigh, ViscousDamper,
};

use random_vibration::Quadrature;
use sde_integrators::{Additive, Sde};

use super::paths::{PathIntegrator, Paths};

/// A system that has been checked, of any dimension.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub enum System {
    /// A linear oscillator.
    LinearOscillator(LinearOscillator),
    /// A viscous damper.
    ViscousDamper(ViscousDamper),
    /// A hysteretic oscillator.
    BoucWen(BoucWen),
    /// A cubic spring.
    Duffing(Duffing),
    /// A self-excited oscillator.
    VanDerPol(VanDerPolRayleigh),
    /// A building of two storeys.
    TwoStorey(TwoStorey),
    /// A linear oscillator behind a Kanai-Tajimi filter.
    KanaiTajimiLinear(Filtered<LinearOscillator, 2, 2>),
    /// A viscous damper behind a Kanai-Tajimi filter.
    KanaiTajimiDamper(Filtered<ViscousDamper, 2, 2>),
    /// A hysteretic oscillator behind a Kanai-Tajimi filter.
    KanaiTajimiBoucWen(Filtered<BoucWen, 3, 2>),
    /// A cubic spring behind a Kanai-Tajimi filter.
    KanaiTajimiDuffing(Filtered<Duffing, 2, 2>),
    /// A building behind a Kanai-Tajimi filter.
    KanaiTajimiTwoStorey(Filtered<TwoStorey, 4, 2>),
    /// A linear oscillator behind a Clough-Penzien filter.
    CloughPenzienLinear(Filtered<LinearOscillator, 2, 4>),
    /// A viscous damper behind a Clough-Penzien filter.
    CloughPenzienDamper(Filtered<ViscousDamper, 2, 4>),
    /// A cubic spring behind a Clough-Penzien filter.
    CloughPenzienDuffing(Filtered<Duffing, 2, 4>),
    /// Ornstein-Uhlenbeck in one dimension.
    OrnsteinUhlenbeck1(OrnsteinUhlenbeck<1>),
    /// Ornstein-Uhlenbeck in two dimensions.
    OrnsteinUhlenbeck2(OrnsteinUhlenbeck<2>),
    /// Ornstein-Uhlenbeck in three dimensions.
    OrnsteinUhlenbeck3(OrnsteinUhlenbeck<3>),
    /// Ornstein-Uhlenbeck in four dimensions.
    OrnsteinUhlenbeck4(OrnsteinUhlenbeck<4>),
    /// A double well.
    Bistable(Bistable),
    /// A square-root process.
    CoxIngersollRoss(CoxIngersollRoss),
    /// Geometric Brownian motion.
    GeometricBrownianMotion(GeometricBrownianMotion),
}

/// A function of a system of any type.
pub trait Visitor {
    /// Return type.
    type Output;

    /// Evaluates the function.
    fn visit<S, const D: usize, const M: usize>(self, system: &S) -> Self::Output
    where
        S: Paths<D, M>;
}

/// A function of a structure behind a filter, of any type.
pub trait FilteredVisitor {
    /// Return type.
    type Output;

    /// Evaluates the function; `D = DS + DF`.
    fn visit<S, const DS: usize, const DF: usize, const D: usize>(
        self,
        system: &Filtered<S, DS, DF>,
    ) -> Self::Output
    where
        S: Sde<DS, 1, Noise = Additive>;
}

impl System {
    /// Calls a visitor with the system as its own type.
    pub fn visit<V: Visitor>(&self, visitor: V) -> V::Output {
        match self {
            Self::LinearOscillator(system) => visitor.visit::<_, 2, 1>(system),
            Self::ViscousDamper(system) => visitor.visit::<_, 2, 1>(system),
            Self::BoucWen(system) => visitor.visit::<_, 3, 1>(system),
            Self::Duffing(system) => visitor.visit::<_, 2, 1>(system),
            Self::VanDerPol(system) => visitor.visit::<_, 2, 1>(system),
            Self::TwoStorey(system) => visitor.visit::<_, 4, 1>(system),
            Self::KanaiTajimiLinear(system) => visitor.visit::<_, 4, 1>(system),
            Self::KanaiTajimiDamper(system) => visitor.visit::<_, 4, 1>(system),
            Self::KanaiTajimiDuffing(system) => visitor.visit::<_, 4, 1>(system),
            Self::KanaiTajimiBoucWen(system) => visitor.visit::<_, 5, 1>(system),
            Self::KanaiTajimiTwoStorey(system) => visitor.visit::<_, 6, 1>(system),
            Self::CloughPenzienLinear(system) => visitor.visit::<_, 6, 1>(system),
            Self::CloughPenzienDamper(system) => visitor.visit::<_, 6, 1>(system),
            Self::CloughPenzienDuffing(system) => visitor.visit::<_, 6, 1>(system),
            Self::OrnsteinUhlenbeck1(system) => visitor.visit::<_, 1, 1>(system),
            Self::OrnsteinUhlenbeck2(system) => visitor.visit::<_, 2, 2>(system),
            Self::OrnsteinUhlenbeck3(system) => visitor.visit::<_, 3, 3>(system),
            Self::OrnsteinUhlenbeck4(system) => visitor.visit::<_, 4, 4>(system),
            Self::Bistable(system) => visitor.visit::<_, 1, 1>(system),
            Self::CoxIngersollRoss(system) => visitor.visit::<_, 1, 1>(system),
            Self::GeometricBrownianMotion(system) => visitor.visit::<_, 1, 1>(system),
        }
    }

    /// Names of its states.
    #[must_use]
    pub fn states(&self) -> &'static [&'static str] {
        match self {
            Self::LinearOscillator(_)
            | Self::ViscousDamper(_)
            | Self::Duffing(_)
            | Self::VanDerPol(_) => &["q", "v"],
            Self::BoucWen(_) => &["q", "v", "z"],
            Self::TwoStorey(_) => &["q1", "q2", "v1", "v2"],
            Self::KanaiTajimiLinear(_)
            | Self::KanaiTajimiDamper(_)
            | Self::KanaiTajimiDuffing(_) => &["q", "v", "xg", "vg"],
            Self::KanaiTajimiBoucWen(_) => &["q", "v", "z", "xg", "vg"],
            Self::KanaiTajimiTwoStorey(_) => &["q1", "q2", "v1", "v2", "xg", "vg"],
            Self::CloughPenzienLinear(_)
            | Self::CloughPenzienDamper(_)
            | Self::CloughPenzienDuffing(_) => &["q", "v", "xg", "vg", "xf", "vf"],
            Self::OrnsteinUhlenbeck1(_)
            | Self::Bistable(_)
            | Self::CoxIngersollRoss(_)
            | Self::GeometricBrownianMotion(_) => &["x"],
            Self::OrnsteinUhlenbeck2(_) => &["x1", "x2"],
            Self::OrnsteinUhlenbeck3(_) => &["x1", "x2", "x3"],
            Self::OrnsteinUhlenbeck4(_) => &["x1", "x2", "x3", "x4"],
        }
    }

    /// The system as an oscillator `(q, v)` with noise on its velocity, if it is one.
    #[must_use]
    pub fn oscillator(&self) -> Option<&dyn Sde<2, 1, Noise = Additive>> {
        match self {
            Self::LinearOscillator(system) => Some(system),
            Self::ViscousDamper(system) => Some(system),
            Self::Duffing(system) => Some(system),
            Self::VanDerPol(system) => Some(system),
            _ => None,
        }
    }

    /// Whether its noise is independent of the state.
    #[must_use]
    pub const fn has_additive_noise(&self) -> bool {
        !matches!(self, Self::CoxIngersollRoss(_) | Self::GeometricBrownianMotion(_))
    }

    /// Whether its drift is linear in the state and its noise additive.
    #[must_use]
    pub const fn is_linear(&self) -> bool {
        matches!(
            self,
            Self::LinearOscillator(_)
                | Self::KanaiTajimiLinear(_)
                | Self::CloughPenzienLinear(_)
                | Self::OrnsteinUhlenbeck1(_)
                | Self::OrnsteinUhlenbeck2(_)
                | Self::OrnsteinUhlenbeck3(_)
                | Self::OrnsteinUhlenbeck4(_)
        )
    }

    /// States in which its drift has a kink or a root, with the rules that split there.
    ///
    /// The drift is polynomial in all others.
    #[must_use]
    pub const fn kinks(&self) -> &'static [(usize, Quadrature)] {
        use Quadrature::{SplitAt, SplitAtZero};
        match self {
            Self::ViscousDamper(_) | Self::KanaiTajimiDamper(_) | Self::CloughPenzienDamper(_) => {
                &[(1, SplitAtZero)]
            }
            Self::BoucWen(_) | Self::KanaiTajimiBoucWen(_) => &[(1, SplitAtZero), (2, SplitAtZero)],
            // The dampers depend on v_1 and v_2 - v_1.
            Self::TwoStorey(_) | Self::KanaiTajimiTwoStorey(_) => {
                &[(2, SplitAtZero), (3, SplitAt(2))]
            }
            _ => &[],
        }
    }

    /// Names of the states of the structure, if it is behind a filter; those of the filter follow.
    #[must_use]
    pub fn structure_states(&self) -> Option<&'static [&'static str]> {
        let n_filter_states = self.filter_covariance()?.len();
        let states = self.states();
        Some(&states[..states.len() - n_filter_states])
    }

    /// Calls a visitor with the structure and its filter, if it is behind one.
    pub fn visit_filtered<V: FilteredVisitor>(&self, visitor: V) -> Option<V::Output> {
        Some(match self {
            Self::KanaiTajimiLinear(system) => visitor.visit::<_, 2, 2, 4>(system),
            Self::KanaiTajimiDamper(system) => visitor.visit::<_, 2, 2, 4>(system),
            Self::KanaiTajimiDuffing(system) => visitor.visit::<_, 2, 2, 4>(system),
            Self::KanaiTajimiBoucWen(system) => visitor.visit::<_, 3, 2, 5>(system),
            Self::KanaiTajimiTwoStorey(system) => visitor.visit::<_, 4, 2, 6>(system),
            Self::CloughPenzienLinear(system) => visitor.visit::<_, 2, 4, 6>(system),
            Self::CloughPenzienDamper(system) => visitor.visit::<_, 2, 4, 6>(system),
            Self::CloughPenzienDuffing(system) => visitor.visit::<_, 2, 4, 6>(system),
            _ => return None,
        })
    }

    /// Reference time of the steps of the structure alone, if it is behind a filter (s).
    #[must_use]
    pub fn structure_period(&self) -> Option<f64> {
        Some(match self {
            Self::KanaiTajimiLinear(system) => system.structure().period(),
            Self::KanaiTajimiDamper(system) => system.structure().period(),
            Self::KanaiTajimiDuffing(system) => system.structure().period(),
            Self::KanaiTajimiBoucWen(system) => system.structure().period(),
            Self::KanaiTajimiTwoStorey(system) => frame_period(system.structure()),
            Self::CloughPenzienLinear(system) => system.structure().period(),
            Self::CloughPenzienDamper(system) => system.structure().period(),
            Self::CloughPenzienDuffing(system) => system.structure().period(),
            _ => return None,
        })
    }

    /// Integrator of its paths.
    #[must_use]
    pub fn integrator(&self) -> PathIntegrator {
        self.visit(IntegratorOf)
    }

    /// Reference time of the steps: the shortest period of an oscillation, else a relaxation time (s).
    #[must_use]
    pub fn reference_period(&self) -> f64 {
        match self {
            Self::LinearOscillator(system) => system.period(),
            Self::ViscousDamper(system) => system.period(),
            Self::BoucWen(system) => system.period(),
            Self::Duffing(system) => system.period(),
            Self::VanDerPol(system) => system.period(),
            Self::TwoStorey(system) => frame_period(system),
            Self::OrnsteinUhlenbeck1(system) => fastest(&system.parameters().rates),
            Self::OrnsteinUhlenbeck2(system) => fastest(&system.parameters().rates),
            Self::OrnsteinUhlenbeck3(system) => fastest(&system.parameters().rates),
            Self::OrnsteinUhlenbeck4(system) => fastest(&system.parameters().rates),
            Self::Bistable(system) => std::f64::consts::TAU * system.relaxation_time(),
            Self::CoxIngersollRoss(system) => std::f64::consts::TAU / system.parameters().rate,
            // In units of its own time: it has no relaxation.
            Self::GeometricBrownianMotion(_) => 1.0,
            Self::KanaiTajimiLinear(_)
            | Self::KanaiTajimiDamper(_)
            | Self::KanaiTajimiDuffing(_)
            | Self::KanaiTajimiBoucWen(_)
            | Self::KanaiTajimiTwoStorey(_)
            | Self::CloughPenzienLinear(_)
            | Self::CloughPenzienDamper(_)
            | Self::CloughPenzienDuffing(_) => {
                let filter = self.filter().map(|(_, period)| period);
                [self.structure_period(), filter]
                    .into_iter()
                    .flatten()
                    .fold(f64::INFINITY, f64::min)
            }
        }
    }

    /// The stationary covariance of the filter's states, which come last.
    #[must_use]
    pub fn filter_covariance(&self) -> Option<Vec<Vec<f64>>> {
        self.filter().map(|(covariance, _)| covariance)
    }

    /// Stationary covariance and period of the filter, if there is one.
    fn filter(&self) -> Option<(Vec<Vec<f64>>, f64)> {
        self.visit_filtered(FilterOf)
    }
}

/// Returns the stationary covariance of a filter and its period.
struct FilterOf;

impl FilteredVisitor for FilterOf {
    type Output = (Vec<Vec<f64>>, f64);
    fn visit<S, const DS: usize, const DF: usize, const D: usize>(
        self,
        system: &Filtered<S, DS, DF>,
    ) -> Self::Output
    where
        S: Sde<DS, 1, Noise = Additive>,
    {
        let filter = system.filter();
        let covariance = filter.stationary_covariance().iter().map(|row| row.to_vec()).collect();
        (covariance, filter.period())
    }
}

/// The shortest natural period of a building (s).
fn frame_period(system: &TwoStorey) -> f64 {
    std::f64::consts::TAU / system.natural_frequencies()[1]
}

/// Returns the integrator of a system.
struct IntegratorOf;

impl Visitor for IntegratorOf {
    type Output = PathIntegrator;
    fn visit<S: Paths<D, M>, const D: usize, const M: usize>(self, _: &S) -> Self::Output {
        S::INTEGRATOR
    }
}

/// `2 pi` over the largest rate, bounded through the row sums.
fn fastest<const D: usize>(rates: &[[f64; D]; D]) -> f64 {
    let sums = rates.iter().map(|row| row.iter().map(|rate| rate.abs()).sum::<f64>());
    std::f64::consts::TAU / sums.fold(f64::MIN_POSITIVE, f64::max)
}
