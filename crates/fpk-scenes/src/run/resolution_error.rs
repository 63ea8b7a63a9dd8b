//! The error of a value from the same value at coarser resolutions: one place for densities, grids and linearisation.

/// Orders of convergence in the ratio of the resolutions.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Orders {
    /// The order of the method: an observed order above it is not trusted.
    pub(crate) of_method: f64,
    /// The largest order at which the error of a coarse run may decrease.
    pub(crate) largest: f64,
}

/// A value at a coarser resolution, and the ratio of its resolution to that of the next finer one.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Coarser {
    pub(crate) value: f64,
    pub(crate) ratio: f64,
}

/// The error of the finest of two or three values (Roache 1994):
///
/// $$ \epsilon = \frac{|f_1 - f_2|}{r^p - 1}, \qquad p = \frac{\ln(|f_2 - f_3| / |f_1 - f_2|)}{\ln s}, $$
///
/// with the ratios `r` and `s` of the resolutions. The observed order `p` counts between 1 and the order of the method, which is taken
/// where there is no third value; then the other one may also be finer, `r < 1`. The error is at least `|f_2 - f_3| / (s^p - 1) / r^q` at the order of the method `p` and the largest
/// order `q`: a smaller difference is a change of sign.
pub(crate) fn error_of_finest(
    finest: f64,
    coarse: Coarser,
    coarsest: Option<Coarser>,
    orders: Orders,
) -> f64 {
    let difference = (finest - coarse.value).abs();
    let by_order = |order: f64| difference / (coarse.ratio.powf(order) - 1.0).abs();
    let Some(coarsest) = coarsest else { return by_order(orders.of_method) };
    let before = (coarse.value - coarsest.value).abs();
    let order = (before / difference).ln() / coarsest.ratio.ln();
    let order = if order.is_nan() { orders.of_method } else { order.clamp(1.0, orders.of_method) };
    let of_coarse = before / (coarsest.ratio.powf(orders.of_method) - 1.0);
    by_order(order).max(of_coarse / coarse.ratio.powf(orders.largest))
}

/// Numbers of steps in an interval between observations that differ: of the run, and of two coarser ones where there are so many.
///
/// A run with one step an interval has no coarser one, so that two is the least.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct StepsOfInterval {
    pub(crate) fine: u32,
    pub(crate) coarse: u32,
    pub(crate) coarsest: Option<u32>,
}

impl StepsOfInterval {
    /// For at least `asked` steps in an interval, and runs coarser by a ratio.
    pub(crate) fn new(asked: f64, ratio: f64) -> Self {
        #[expect(
            clippy::cast_possible_truncation,
            clippy::cast_sign_loss,
            reason = "a cast saturates, and so many steps are refused elsewhere"
        )]
        let whole = |steps: f64| steps as u32;
        // The tolerance prevents roundoff from adding a step.
        let fine = whole((asked - 1e-9).ceil()).max(2);
        let fewer = |than: u32| whole((f64::from(than) / ratio).round()).clamp(1, than - 1);
        let coarse = fewer(fine);
        let coarsest = (coarse > 1).then(|| fewer(coarse));
        Self { fine, coarse, coarsest }
    }

    /// Of the coarse run to the fine one, and of the coarsest to the coarse one.
    pub(crate) fn ratios(self) -> (f64, Option<f64>) {
        let of = |fine: u32, coarse: u32| f64::from(fine) / f64::from(coarse);
        (of(self.fine, self.coarse), self.coarsest.map(|coarsest| of(self.coarse, coarsest)))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const ORDERS: Orders = Orders { of_method: 4.0, largest: 4.0 };

    fn error(values: [f64; 3]) -> f64 {
        let [finest, coarse, coarsest] = values;
        let of = |value| Coarser { value, ratio: 2.0 };
        error_of_finest(finest, of(coarse), Some(of(coarsest)), ORDERS)
    }

    #[test]
    fn an_error_of_any_order_up_to_that_of_the_method_is_found() {
        for order in [1, 2, 3, 4] {
            let at = |h: f64| 1.0 + 1e-3 * h.powi(order);
            let found = error([at(1.0), at(2.0), at(4.0)]);
            assert!((found / 1e-3 - 1.0).abs() < 1e-9, "{order}: {found}");
        }
    }

    #[test]
    fn a_finer_value_shows_the_error_as_a_coarser_one_does() {
        let at = |h: f64| 1.0 + 1e-3 * h.powi(4);
        let finer = Coarser { value: at(0.5), ratio: 0.5 };
        let found = error_of_finest(at(1.0), finer, None, ORDERS);
        assert!((found / 1e-3 - 1.0).abs() < 1e-9, "{found}");
    }

    #[test]
    fn a_change_of_sign_and_equal_values_leave_an_error() {
        // The difference vanishes between the two finest.
        assert!((error([1.0, 1.0, 1.15]) - 0.01 / 16.0).abs() < 1e-12);
        // No convergence is seen: first order.
        assert!((error([1.0, 1.1, 1.15]) - 0.1).abs() < 1e-12);
        assert!(error([1.0; 3]).abs() < 1e-300);
    }

    #[test]
    fn a_coarser_run_takes_other_steps_whatever_the_times_are() {
        for asked in [0.01, 1.0, 1.2, 2.0, 3.0, 7.0, 40.0, 1e4] {
            for ratio in [std::f64::consts::SQRT_2, 2.0, 1.1] {
                let steps = StepsOfInterval::new(asked, ratio);
                assert!(f64::from(steps.fine) >= asked && steps.coarse < steps.fine);
                assert!(steps.coarsest.is_none_or(|coarsest| coarsest < steps.coarse));
            }
        }
        let few = StepsOfInterval { fine: 2, coarse: 1, coarsest: None };
        assert_eq!(StepsOfInterval::new(0.2, 2.0), few);
    }
}
