//! Systems, each declared once for the density solver and for its Monte Carlo rival.
//!
//! | system | states | source |
//! |---|---|---|
//! | [`LinearOscillator`] | `(q, q')` | Canor & Denoël 2013, eq 26 with `eta = 0`; exactly solvable |
//! | [`ViscousDamper`] | `(q, q')` | Canor & Denoël 2013, eq 26 |

mod linear_oscillator;
mod viscous_damper;
mod window;

pub use linear_oscillator::{LinearOscillator, LinearOscillatorParameters};
pub use viscous_damper::{ViscousDamper, ViscousDamperParameters};
pub use window::Window;
