//! SRA1: two drift evaluations, strong order 1.5 for additive noise.

use crate::sra::{Tableau, integrate_by_tableau};

/// Rößler's SRA1, for additive noise: the reference for other methods.
///
/// $$ H_2 = X_n + \tfrac34 h f(t_n, X_n) + \tfrac32 \frac Ih g(t_{n+1}), \qquad I = h \left(\tfrac12 w + H\right), $$
/// $$ X_{n+1} = X_n + h \left(\tfrac13 f(t_n, X_n) + \tfrac23 f(t_n + \tfrac34 h, H_2)\right) +
///    g(t_{n+1}) w + (g(t_n) - g(t_{n+1})) \frac Ih $$
///
/// Solves `dX = f(t, X) dt + g(t) dB`; Ito and Stratonovich agree. Symbols: `h` = `dt`, `w` = `dw.brownian`, `H` =
/// `dw.space_time_area`.
///
/// Order (additive noise): strong 1.5, weak 2; 2 without noise.
///
/// Stable for: as Heun without noise, `|1 + z + z^2/2| < 1` with `z = h l`; for a lightly damped oscillator `h omega`
/// up to about `(8 xi)^(1/3)`.
///
/// Source: Rößler 2010, table 6.1. A test checks its order conditions, and that no coefficient can change without
/// breaking one.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Sra1;

const TABLEAU: Tableau<2> = Tableau {
    a: [1.0 / 3.0, 2.0 / 3.0],
    a0: [[0.0, 0.0], [0.75, 0.0]],
    b0: [[0.0, 0.0], [1.5, 0.0]],
    b1: [1.0, 0.0],
    b2: [-1.0, 1.0],
    c0: [0.0, 0.75],
    c1: [1.0, 0.0],
};

integrate_by_tableau!(Sra1);

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sra::conditions;

    #[test]
    fn the_conditions_of_order_hold_and_pin_every_coefficient() {
        conditions::hold_and_pin_every_coefficient(TABLEAU);
    }
}
