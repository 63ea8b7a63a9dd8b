//! Numbers in one or two bytes.

use serde::Serialize;

use crate::error::PageError;

/// A range of numbers that codes divide evenly.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub(crate) struct Range {
    pub(crate) low: f64,
    pub(crate) high: f64,
}

impl Range {
    /// The range of values, each with its frame.
    ///
    /// # Errors
    /// [`PageError::Field`] for a value that is not finite.
    pub(crate) fn of(
        layer: &str,
        values: impl Iterator<Item = (usize, f64)>,
    ) -> Result<Self, PageError> {
        let mut range = Self { low: f64::INFINITY, high: f64::NEG_INFINITY };
        for (frame, value) in values {
            if !value.is_finite() {
                return Err(PageError::Field { layer: layer.to_owned(), frame, value });
            }
            range = Self { low: range.low.min(value), high: range.high.max(value) };
        }
        let is_empty = range.low > range.high;
        Ok(if is_empty { Self { low: 0.0, high: 0.0 } } else { range })
    }

    /// The nearest of the codes `0..=most`.
    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "from 0 to `most`")]
    pub(crate) fn code(self, value: f64, most: u16) -> u16 {
        let width = self.high - self.low;
        if width <= 0.0 {
            return 0;
        }
        let part = ((value - self.low) / width).clamp(0.0, 1.0);
        (part * f64::from(most)).round() as u16
    }

    /// Largest difference between a number of the range and its code's.
    pub(crate) fn half_step(self, most: u16) -> f64 {
        0.5 * (self.high - self.low) / f64::from(most)
    }
}
