//! SRA3: three drift evaluations, strong order 1.5 for additive noise and order 3 without noise.

use crate::sra::{Tableau, integrate_by_tableau};

/// Rößler's SRA3, for weak additive noise.
///
/// $$ H_2 = X_n + h f(t_n, X_n), \qquad
///    H_3 = X_n + \tfrac14 h \left(f(t_n, X_n) + f(t_{n+1}, H_2)\right) +
///    \frac Ih \left(g(t_{n+1}) + \tfrac12 g(t_n)\right), $$
/// $$ X_{n+1} = X_n + \tfrac16 h \left(f(t_n, X_n) + f(t_{n+1}, H_2) + 4 f(t_n + \tfrac12 h, H_3)\right) +
///    g(t_{n+1}) w + (g(t_n) - g(t_{n+1})) \frac Ih $$
///
/// with `I = h (w/2 + H)`. Solves `dX = f(t, X) dt + g(t) dB`; Ito and Stratonovich agree. Symbols: `h` = `dt`, `w` =
/// `dw.brownian`, `H` = `dw.space_time_area`.
///
/// Order (additive noise): strong 1.5, weak 2; 3 without noise, which is visible for weak noise.
///
/// Stable for: `|1 + z + z^2/2 + z^3/6| < 1` with `z = h l`; an undamped oscillator for `h omega < sqrt(3)`.
///
/// Source: Rößler 2010, table 6.3. One published implementation has the wrong sign of `b2`, which lowers the order to
/// 1 for time-dependent noise; the test of the conditions detects that error.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Sra3;

const TABLEAU: Tableau<3> = Tableau {
    a: [1.0 / 6.0, 1.0 / 6.0, 2.0 / 3.0],
    a0: [[0.0; 3], [1.0, 0.0, 0.0], [0.25, 0.25, 0.0]],
    b0: [[0.0; 3], [0.0; 3], [1.0, 0.5, 0.0]],
    b1: [1.0, 0.0, 0.0],
    b2: [-1.0, 1.0, 0.0],
    c0: [0.0, 1.0, 0.5],
    c1: [1.0, 0.0, 0.0],
};

integrate_by_tableau!(Sra3);

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sra::conditions;

    #[test]
    fn the_conditions_of_order_hold_and_pin_every_coefficient() {
        conditions::hold_and_pin_every_coefficient(TABLEAU);
    }
}
