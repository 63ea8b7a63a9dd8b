//! Two published responses with their derivatives in closed form.
//!
//! They stand here as the measure of the other ways to differentiate, and as the place where the printed derivatives of
//! their source are corrected. They know no solver: a state is a few numbers.

mod johnson_cook;
mod mie_gruneisen;

pub use johnson_cook::JohnsonCook;
pub use mie_gruneisen::{MieGruneisen, MieGruneisenState};
