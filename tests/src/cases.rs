//! What is claimed of each crate.
//!
//! A case is one file here and one line in [`ALL`].

use crate::case::Case;

/// Every case, in the order in which the table is printed.
pub const ALL: &[Case] = &[];

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_table_is_well_formed() {
        crate::verify::check_table(ALL).unwrap();
    }
}
