//! The worst of a family of errors that share one reason.

/// The largest of some errors, and where it was seen.
#[derive(Debug, Clone, Default, PartialEq)]
pub(super) struct Worst {
    seen: Option<(f64, String)>,
}

impl Worst {
    /// Adds an error, by its size; what is no number is worse than any number.
    pub(super) fn see(&mut self, error: f64, at: &str) {
        let error = error.abs();
        if self.seen.as_ref().is_none_or(|(worst, _)| error > *worst || error.is_nan()) {
            self.seen = Some((error, at.to_owned()));
        }
    }

    /// NaN where no error was added, which fails.
    pub(super) fn value(&self) -> f64 {
        self.seen.as_ref().map_or(f64::NAN, |(worst, _)| *worst)
    }

    /// A method, followed by where the worst error is.
    pub(super) fn at(&self, method: &str) -> String {
        let place = self.seen.as_ref().map_or("nowhere", |(_, place)| place);
        format!("{method}; worst at {place}")
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_largest_error_is_kept_with_its_place() {
        let mut worst = Worst::default();
        assert!(worst.value().is_nan());
        for (error, at) in [(1.0, "a"), (-3.0, "b"), (2.0, "c")] {
            worst.see(error, at);
        }
        assert!((worst.value() - 3.0).abs() < 1e-15);
        assert_eq!(worst.at("by hand"), "by hand; worst at b");
    }

    #[test]
    fn what_is_no_number_is_the_worst() {
        let mut worst = Worst::default();
        for error in [1.0, f64::NAN, 2.0] {
            worst.see(error, "x");
        }
        assert!(worst.value().is_nan());
    }
}
