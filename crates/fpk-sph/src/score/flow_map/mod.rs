//! The flow-map fit: a polynomial around every particle over its neighbours on the lattice.
//!
//! On a lattice most particles have neighbours arranged alike. Their weights are computed once, by arrangement, and sums with
//! them run along rows of the lattice. Cells, monomials and small matrices are those of the folder above; this one knows the
//! cloud at one stage, and no system or step.

mod arrangement;
mod fit;
mod folded;
mod lattice_sums;
mod passes;
mod pattern;
mod runs;
mod stencils;

pub use fit::FlowMapFit;
pub(crate) use fit::WAVE_DAMPING;
pub use passes::SMALLEST_CELL;
pub(crate) use stencils::RIM;
