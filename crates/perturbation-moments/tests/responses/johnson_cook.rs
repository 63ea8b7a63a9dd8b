//! Johnson-Cook flow stress with five random parameters.

#![allow(
    clippy::inline_always,
    reason = "what is not inlined into the dispatched closure is not compiled for its registers"
)]

use perturbation_moments::{Expansion, Response, Scalar};

/// Johnson-Cook flow stress at a given state, as a function of its parameters `x = [A, B, C, n, m]`.
///
/// $$ \sigma_y = (A + B \varepsilon^n) (1 + C \ln \dot\varepsilon^{\ast}) (1 - T^{\ast m}) $$
///
/// Symbols: `A`, `B` and $\sigma_y$ in one unit of stress; `C`, `n`, `m` pure numbers; $\varepsilon$ = plastic strain,
/// $\dot\varepsilon^{\ast}$ = strain rate over the reference rate (1/s in the source), $T^{\ast}$ = homologous temperature,
/// `(T - T_room)/(T_melt - T_room)`.
///
/// Source: Johnson and Cook 1983; derivatives Chen et al. 2019, eq 34-35. Five entries are wrong in print
/// (docs/errata.md): the second derivatives in `n` and `m` are not zero, and `C4`, `C5`, `C6` are products of
/// logarithms, not logarithms of sums.
#[derive(Debug, Clone, Copy, PartialEq)]
#[allow(
    clippy::struct_field_names,
    reason = "they are logarithms, and must not be taken for the state"
)]
pub(crate) struct JohnsonCook {
    log_strain: f64,
    log_rate: f64,
    log_temperature: f64,
}

impl JohnsonCook {
    /// Response at a state: plastic strain, strain rate over the reference rate, homologous temperature, all positive.
    pub(crate) fn new(
        plastic_strain: f64,
        relative_rate: f64,
        homologous_temperature: f64,
    ) -> Self {
        let state = [plastic_strain, relative_rate, homologous_temperature];
        Self::from_logarithms(state.map(f64::ln))
    }

    /// Response at a state given by the logarithms of strain, relative rate and homologous temperature.
    ///
    /// For loops over many states whose logarithms are available.
    #[must_use]
    #[inline(always)]
    pub(crate) const fn from_logarithms([log_strain, log_rate, log_temperature]: [f64; 3]) -> Self {
        Self { log_strain, log_rate, log_temperature }
    }

    /// Value, and the five first and five unmixed second derivatives, in closed form.
    #[must_use]
    #[inline(always)]
    pub(crate) fn diagonal(&self, x: &[f64; 5]) -> (f64, [f64; 5], [f64; 5]) {
        let p = self.parts(x);
        let (c12, c13, c23) = (p.c1 * p.c2, p.c1 * p.c3, p.c2 * p.c3);
        let by_n = p.b_strain * self.log_strain * c23;
        let by_m = -(p.temperature * self.log_temperature * c12);
        (
            c12 * p.c3,
            [c23, p.strain * c23, self.log_rate * c13, by_n, by_m],
            [0.0, 0.0, 0.0, by_n * self.log_strain, by_m * self.log_temperature],
        )
    }

    /// Value, gradient, Hessian and third derivatives, in closed form.
    ///
    /// The response is a product of three factors without common parameters, so each derivative is the product of the
    /// factors' derivatives.
    #[must_use]
    pub(crate) fn expansion(&self, x: &[f64; 5]) -> Expansion<5> {
        let p = self.parts(x);
        let (ln_e, ln_t) = (self.log_strain, self.log_temperature);
        // The order in each parameter selects the derivative of each factor.
        let strain_factor = |a: usize, b: usize, n: usize| match (a, b) {
            (0, 0) if n == 0 => p.c1,
            (0, 0) => p.b_strain * power(ln_e, n),
            (1, 0) if n == 0 => 1.0,
            (0, 1) => p.strain * power(ln_e, n),
            _ => 0.0,
        };
        let rate_factor = |c: usize| [p.c2, self.log_rate, 0.0, 0.0][c];
        let heat_factor = |m: usize| if m == 0 { p.c3 } else { -(p.temperature * power(ln_t, m)) };
        let derivative = |by: &[usize]| {
            let mut times = [0; 5];
            for &i in by {
                times[i] += 1;
            }
            let [a, b, c, n, m] = times;
            strain_factor(a, b, n) * rate_factor(c) * heat_factor(m)
        };
        Expansion::from_derivatives(derivative)
    }

    #[inline(always)]
    fn parts(&self, &[a, b, c, n, m]: &[f64; 5]) -> Parts {
        let strain = (n * self.log_strain).exp();
        let temperature = (m * self.log_temperature).exp();
        let b_strain = b * strain;
        let (c1, c2, c3) = (a + b_strain, 1.0 + c * self.log_rate, 1.0 - temperature);
        Parts { strain, temperature, b_strain, c1, c2, c3 }
    }
}

/// The three factors and their components.
struct Parts {
    strain: f64,
    temperature: f64,
    b_strain: f64,
    c1: f64,
    c2: f64,
    c3: f64,
}

fn power(base: f64, exponent: usize) -> f64 {
    (0..exponent).fold(1.0, |product, _| product * base)
}

impl Response<5> for JohnsonCook {
    #[inline(always)]
    fn value<S: Scalar>(&self, x: &[S; 5]) -> S {
        let [a, b, c, n, m] = *x;
        // The exponentials come first, so the rest is one sequence of lane-wise operations without a call. Both
        // factors have the opposite sign: their product is the same, and a subtraction from one is saved.
        let (strain, temperature) =
            (n.exp_scaled(self.log_strain), m.exp_scaled(self.log_temperature));
        let minus_c2 = c * -self.log_rate - 1.0;
        let minus_c3 = temperature - 1.0;
        (a + b * strain) * (minus_c2 * minus_c3)
    }
}
