//! The worst of a family of values that share one reason.

/// The value farthest from its target, and where it is.
#[derive(Debug, Clone, Default)]
pub(super) struct Worst {
    target: f64,
    value: Option<f64>,
    place: String,
    count: usize,
}

impl Worst {
    /// Of errors, which should be zero.
    pub(super) const fn of_errors() -> Self {
        Self::about(0.0)
    }

    /// Of values that should be this one.
    pub(super) const fn about(target: f64) -> Self {
        Self { target, value: None, place: String::new(), count: 0 }
    }

    /// Takes one of the family; a value that is not a number is the worst.
    pub(super) fn take(&mut self, value: f64, place: &str) {
        self.count += 1;
        let nearer = self.value.is_some_and(|worst| {
            worst.is_nan() || (value - self.target).abs() <= (worst - self.target).abs()
        });
        if !nearer {
            self.value = Some(value);
            place.clone_into(&mut self.place);
        }
    }

    /// The worst value; not a number where there is none.
    pub(super) fn value(&self) -> f64 {
        self.value.unwrap_or(f64::NAN)
    }

    /// A method, over what the worst was taken and where it is.
    pub(super) fn method(&self, method: &str) -> String {
        format!("{method}: worst of {}, at {}", self.count, self.place)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_farthest_from_the_target_is_the_worst_and_no_number_is_worse() {
        let mut worst = Worst::about(1.0);
        assert!(worst.value().is_nan());
        for (value, place) in [(1.1, "a"), (0.7, "b"), (1.2, "c")] {
            worst.take(value, place);
        }
        assert_eq!((worst.value(), worst.method("m").as_str()), (0.7, "m: worst of 3, at b"));
        worst.take(f64::NAN, "d");
        worst.take(9.0, "e");
        assert!(worst.value().is_nan());
    }
}
