//! Bonds that break: at the ends of steps, by cuts, and between the ends of steps by the bridge test.
//!
//! What is here asks bodies for stretches and strengths and tells them which bonds are intact. It knows no scheme and no loads.

pub(crate) mod broken_bond;
pub(crate) mod crossing;
pub(crate) mod failure;
