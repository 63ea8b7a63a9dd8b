//! Two published responses with derivatives in closed form.
//!
//! They are the reference for the other ways of differentiation, and correct the printed derivatives of their source.
//! They know no solver: a state is a few numbers.

mod johnson_cook;
mod mie_gruneisen;

pub use johnson_cook::JohnsonCook;
pub use mie_gruneisen::{MieGruneisen, MieGruneisenState};
