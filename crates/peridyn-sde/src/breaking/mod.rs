//! Bonds that break: at the ends of steps, by cuts, and between the ends of steps by the bridge test.
//!
//! This module asks bodies for stretches and strengths and sets which of their bonds are intact. It knows no scheme and no loads.

pub(crate) mod broken_bond;
pub(crate) mod crossing;
pub(crate) mod failure;
