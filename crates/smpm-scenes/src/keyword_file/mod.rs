//! Keyword files of LS-DYNA: constants of materials from their cards.

mod cards;
mod constants;
#[cfg(test)]
mod tests;

pub(crate) use self::cards::Cards;
pub(crate) use self::constants::Constants;
