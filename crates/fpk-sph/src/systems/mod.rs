//! Systems, each declared once for the density solver and for its Monte Carlo rival.
//!
//! | system | states | noise | what is exact | source |
//! |---|---|---|---|---|
//! | [`LinearOscillator`] | `(q, q')` | additive, modulated | the law at all times: normal, by the Lyapunov equation | Canor & Denoël 2013, eq 26 with `eta = 0` |
//! | [`ViscousDamper`] | `(q, q')` | additive, modulated | | Canor & Denoël 2013, eq 26 |
//! | [`BoucWen`] | `(q, q', z)` | additive, modulated | the limit of `z` | Canor & Denoël 2013, eq 28 |
//! | [`Duffing`] | `(q, q')` | additive, modulated | the stationary law | Caughey 1963 |
//! | [`VanDerPolRayleigh`] | `(q, q')` | additive, modulated | the stationary law | Caughey & Payne 1967 |
//! | [`TwoStorey`] | `(q_1, q_2, q_1', q_2')` | additive, modulated | without dampers the law at all times | Chopra 2012 |
//! | [`ShearBuilding`] | drifts, their rates, hysteretic variables of any number of storeys, then those of a filter | additive, modulated | without hysteresis the law at all times | Chopra 2012, Wen 1976 |
//! | [`Filtered`] | those of a structure, then those of a [`Filter`] | additive, modulated | for a linear structure the law at all times | Kanai 1957, Tajimi 1960, Clough & Penzien 1975 |
//! | [`OrnsteinUhlenbeck`] | `x` in `D` dimensions | additive | the law at all times | Uhlenbeck & Ornstein 1930 |
//! | [`Bistable`] | `x` | additive | the stationary law | Risken 1996 |
//! | [`CoxIngersollRoss`] | `x > 0` | depends on the state | the transition density | Cox, Ingersoll & Ross 1985 |
//! | [`GeometricBrownianMotion`] | `x > 0` | depends on the state | the transition density | Øksendal 1992 |
//!
//! For paths, [`StrangOscillator`](sde_integrators::StrangOscillator) takes the oscillators that are
//! [`SecondOrder`](sde_integrators::SecondOrder): linear, damper, Duffing, van der Pol-Rayleigh; [`StrangBoucWen`] the
//! hysteretic one; [`Shark`](sde_integrators::Shark) every one whose noise is additive; forward Euler all. Paths of
//! [`ShearBuilding`], whose number of states is known at run time, take [`WongZakai`](sde_integrators::WongZakai) steps; it is no
//! system of the density solver.

mod bistable;
mod bouc_wen;
mod cox_ingersoll_ross;
mod duffing;
mod filter;
mod filtered;
mod geometric_brownian_motion;
mod hysteresis;
mod linear_law;
mod linear_oscillator;
mod ornstein_uhlenbeck;
mod shear_building;
mod shear_chain;
mod stationary;
mod two_storey;
mod van_der_pol;
mod viscous_damper;
mod window;

pub use bistable::{Bistable, BistableParameters};
pub use bouc_wen::{BoucWen, BoucWenParameters, StrangBoucWen};
pub use cox_ingersoll_ross::{CoxIngersollRoss, CoxIngersollRossParameters};
pub use duffing::{Duffing, DuffingParameters};
pub use filter::{CloughPenzienParameters, Filter, KanaiTajimiParameters};
pub use filtered::Filtered;
pub use geometric_brownian_motion::GeometricBrownianMotion;
pub use hysteresis::Hysteresis;
pub use linear_oscillator::{LinearOscillator, LinearOscillatorParameters};
pub use ornstein_uhlenbeck::{OrnsteinUhlenbeck, OrnsteinUhlenbeckParameters};
pub use shear_building::{Ground, ShearBuilding, ShearBuildingParameters, Storey};
pub use stationary::StationaryOscillator;
pub use two_storey::{TwoStorey, TwoStoreyParameters};
pub use van_der_pol::{VanDerPolRayleigh, VanDerPolRayleighParameters};
pub use viscous_damper::{ViscousDamper, ViscousDamperParameters};
pub use window::{TabulatedWindow, Window};
