//! Schemes in time, their limits of stability.

use crate::chebyshev::{Chebyshev, MOST_STAGES};

/// Explicit schemes for `dX/dt = v(t, X)`. Metric and neighbours are those of each stage; so are smoothing lengths, to second
/// order, where the estimator gives their rates. Where it gives none, as in the paper's method, they are frozen over a step.
///
/// | scheme | stages | order | interval of stability, imaginary axis | negative real axis |
/// |---|---|---|---|---|
/// | [`Self::ForwardEuler`] | 1 | 1 | none | 2 |
/// | [`Self::LeapFrog`] | 1 | 2 | 1 | none |
/// | [`Self::Heun`] | 2 | 2 | none | 2 |
/// | [`Self::RungeKutta4`] | 4 | 4 | 2.828 | 2.785 |
/// | [`Self::LawsonRungeKutta4`] | 4 | 4 | 2.828, of what remains | 2.785, of what remains |
/// | [`Self::LawsonAdamsBashforth2`] | 1 | 2 | none, of what remains | 1, of what remains |
/// | [`Self::RungeKuttaChebyshev`] | 2 to 20 | 2 | none, of what remains | `0.65 s^2` for `s` stages, of what remains |
///
/// The last three are in Lawson's form (Lawson 1967): of the velocity `v = A x + r(t, x)` the linear part of the drift
/// ([`Sde::linear_part`](sde_integrators::Sde::linear_part)) is solved exactly by its flow `exp(A t)`, and only what remains
/// limits the step.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Scheme {
    /// One stage, order 1 (Canor & Denoël 2013, eq 16). Makes an undamped oscillator grow by `exp(omega^2 dt t)` in energy.
    ForwardEuler,
    /// Two steps, one stage, order 2: the explicit midpoint rule over two steps, with the ratio `r = dt_n / dt_(n-1)` of the
    /// present step to the last one,
    ///
    /// $$ X_{n+1} = X_n + r^2 (X_{n-1} - X_n) + (1 + r) \Delta t_n v(t_n, X_n), $$
    ///
    /// which is `X_(n+1) = X_(n-1) + 2 dt v_n` for equal steps. The first step is Heun's. Kicks and drifts in turn, the
    /// other scheme of that name, need an equation of second order; the motion of these particles is of the first. Canor &
    /// Denoël 2013 name a leap-frog scheme beside eq 16 and give no equation.
    ///
    /// It keeps the energy of an undamped oscillator for `omega dt < 1`. But it has a second solution that changes sign at
    /// every step and grows like `exp(lambda t)` where the true one decays like `exp(-lambda t)`: there is no step at which
    /// damping and diffusion are stable. The disorder of the particles decays by diffusion, so that their places on odd and
    /// even steps drift apart.
    LeapFrog,
    /// Two stages, order 2 (Heun).
    Heun,
    /// Four stages, order 4 (classical).
    RungeKutta4,
    /// [`Self::RungeKutta4`] in Lawson's form, with `E = exp(A dt)` and `H = exp(A dt/2)`:
    ///
    /// $$ X_{n+1} = E X_n + \frac{\Delta t}{6} (E r_1 + 2 H r_2 + 2 H r_3 + r_4) . $$
    ///
    /// Refused for a system that declares no linear part.
    LawsonRungeKutta4,
    /// The method of Adams and Bashforth of order 2 in Lawson's form, with `r = dt_n / dt_(n-1)` and `R` for what remains:
    ///
    /// $$ X_{n+1} = E \left(X_n + \Delta t_n (1 + \tfrac r2) R_n\right) -
    ///    \Delta t_n \tfrac r2\, e^{A (\Delta t_n + \Delta t_{n-1})} R_{n-1} . $$
    ///
    /// One evaluation a step. The first step, the first after a remeshing, and one more than twice as long as the one before
    /// it are Heun's in Lawson's form. Refused for a system that declares no linear part.
    LawsonAdamsBashforth2,
    /// The stabilised method of order 2 of Sommeijer, Shampine and Verwer (1998), with as many stages as the diffusion needs,
    /// for lattices so fine that it limits the step; in Lawson's form where the system declares a linear part.
    RungeKuttaChebyshev,
}

/// The limit of [`Scheme::diffusion_limit`] for Runge-Kutta 4, and its interval of stability on the negative real axis.
///
/// Measured on the damper with 6,561 particles: with deformed-lattice volumes runs hold at 0.3 and fail at the rim at 0.4,
/// with kernel sums they hold at 0.4; 0.25 leaves room.
const RUNGE_KUTTA_4: (f64, f64) = (0.25, 2.785);

/// The part of its interval that a Runge-Kutta-Chebyshev step uses: cells become thinner within a step as long as that.
///
/// Measured on the damper in steps of a twentieth of the period: with 841 to 6,561 particles runs hold with a quarter, take more
/// stages for nothing with a half, and fail or are wrong with the whole interval.
const USED_OF_CHEBYSHEV: f64 = 0.25;

impl Scheme {
    /// The interval of stability on the negative real axis, `|lambda| dt`; leap-frog, which has none, counts as Euler.
    #[must_use]
    pub fn real_interval(self) -> f64 {
        match self {
            Self::ForwardEuler | Self::LeapFrog | Self::Heun => 2.0,
            Self::RungeKutta4 | Self::LawsonRungeKutta4 => RUNGE_KUTTA_4.1,
            Self::LawsonAdamsBashforth2 => 1.0,
            Self::RungeKuttaChebyshev => Chebyshev::with(MOST_STAGES).real_interval(),
        }
    }

    /// Largest `D_y dt / R^2` that is allowed, with `D_y` the trace of the diffusion matrix in the metric and `R` the
    /// support radius: 0.25 for Runge-Kutta 4, the others in proportion to [`Self::real_interval`], of which
    /// Runge-Kutta-Chebyshev uses a quarter.
    #[must_use]
    pub fn diffusion_limit(self) -> f64 {
        let used = if self == Self::RungeKuttaChebyshev { USED_OF_CHEBYSHEV } else { 1.0 };
        RUNGE_KUTTA_4.0 * used * self.real_interval() / RUNGE_KUTTA_4.1
    }

    /// Evaluations of the velocity per step; the most for a scheme that chooses.
    #[must_use]
    pub fn stages(self) -> usize {
        match self {
            Self::ForwardEuler | Self::LeapFrog | Self::LawsonAdamsBashforth2 => 1,
            Self::Heun => 2,
            Self::RungeKutta4 | Self::LawsonRungeKutta4 => 4,
            Self::RungeKuttaChebyshev => MOST_STAGES,
        }
    }

    /// Whether the scheme is defined by the linear part of the drift, so that a system must declare one.
    #[must_use]
    pub fn needs_linear_part(self) -> bool {
        matches!(self, Self::LawsonRungeKutta4 | Self::LawsonAdamsBashforth2)
    }

    /// The name of what the scheme remembers of one step ago; none for a scheme of one step.
    pub(crate) fn remembers(self) -> Option<&'static str> {
        match self {
            Self::LeapFrog => Some("previous_position"),
            Self::LawsonAdamsBashforth2 => Some("previous_rate"),
            _ => None,
        }
    }
}
