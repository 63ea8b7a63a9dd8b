//! Two published responses with derivatives in closed form: the reference for the ways of differentiation.
//!
//! They correct the printed derivatives of their source and know no solver: a state is a few numbers. The laws of this crate and of
//! smpm, the claims and the benchmark of moments include them.

#![allow(dead_code, unused_imports, reason = "who includes them needs a part")]

mod johnson_cook;
mod mie_gruneisen;

pub(crate) use johnson_cook::JohnsonCook;
pub(crate) use mie_gruneisen::{MieGruneisen, MieGruneisenState};
