//! Reverse mode: derivatives of a few responses by all numbers of all particles, at a cost that does not depend on how many
//! they are by.
//!
//! A run is a chain of steps $s^{n+1} = F_n(s^n)$ of the state of all particles. With the derivatives $\bar s^n$ of a response `y` by the
//! state at the begin of step `n`,
//!
//! $$ \bar s^n = \Big( \frac{\partial F_n}{\partial s^n} \Big)^T \bar s^{n+1} + \frac{\partial y}{\partial s^n}, \qquad
//!    \frac{\partial y}{\partial \xi_k} = \bar s^0 \cdot \frac{\partial s^0}{\partial \xi_k} $$
//!
//! where constants that vary in space are part of the state, which no step changes. Transfers and the solution at the nodes are reversed by
//! hand; the material update of a particle by its own derivatives, with jets ([`local`]). Branches are those of the run: contact with
//! planes, yield, cut-offs, damage. The state at the begin of each step is kept or computed anew ([`revolve`]).
//!
//! Source: Griewank and Walther 2000 (checkpoints); the adjoints follow from the equations of the step.

mod adjoint;
mod certain;
mod eight;
mod local;
mod node_box;
mod revolve;
mod saved;
mod solution;
mod step;
mod sweep;
mod transfer;
mod weights;

pub use revolve::{RevolveAction, fewest_advances, revolve};
pub use sweep::SweepCost;
pub(crate) use sweep::{Task, sensitivities};
