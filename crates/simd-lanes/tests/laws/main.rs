//! Registers and elementary functions at every level: bitwise identical to scalars, and errors in units of the last place.

#[path = "../shared/number.rs"]
mod any_number;
#[path = "../shared/reference.rs"]
mod reference;

mod bits;
mod elementary;
mod registers;
