//! Time windows that modulate white noise.

use std::sync::Arc;

use crate::error::{Error, finite, not_negative, positive};

/// The modulating function `a(t)` of a noise.
// A clone of a tabulated window shares its table.
#[derive(Debug, Clone, Default, PartialEq)]
#[cfg_attr(feature = "schema", derive(serde::Serialize, serde::Deserialize, schemars::JsonSchema))]
#[cfg_attr(feature = "schema", serde(rename_all = "snake_case", deny_unknown_fields))]
#[cfg_attr(feature = "schema", schemars(rename = "WindowScene"))]
#[cfg_attr(feature = "schema", schemars(example = Self::tabulated_example()))]
#[cfg_attr(feature = "schema", schemars(example = Self::RisePlateauDecay { rise_exponent: 2.0, rise_end: 2.0, decay_rate: 0.5, decay_start: 6.0 }))]
#[cfg_attr(feature = "schema", schemars(example = Self::SinglePeak { peak: 1.0, peak_time: 2.0 }))]
pub enum Window {
    /// `a = 1` at all times.
    #[default]
    Stationary,
    /// Rise, plateau, exponential decay (Canor & Denoël 2013, eq 27).
    RisePlateauDecay {
        /// `n_1`, the power of the rise (no unit).
        rise_exponent: f64,
        /// `t_1`, the end of the rise (s).
        rise_end: f64,
        /// `n_2`, the rate of the decay (1/s).
        decay_rate: f64,
        /// `t_2`, the beginning of the decay (s).
        decay_start: f64,
    },
    /// Rise to one peak, and decay (Canor & Denoël 2013, eq 29).
    SinglePeak {
        /// `f_max`, the value at the peak (no unit).
        peak: f64,
        /// `t_max`, the time of the peak (s).
        peak_time: f64,
    },
    /// Piecewise linear between rows `[t, a]`, `t` increasing (s and no unit).
    Tabulated(#[cfg_attr(feature = "schema", schemars(with = "Vec<[f64; 2]>"))] TabulatedWindow),
}

/// A window that is linear between the rows `(t, a)` of a table; before the first row and after the last it keeps their
/// amplitudes.
#[derive(Debug, Clone, PartialEq)]
#[cfg_attr(feature = "schema", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "schema", serde(try_from = "Vec<[f64; 2]>", into = "Vec<[f64; 2]>"))]
pub struct TabulatedWindow {
    rows: Arc<[[f64; 2]]>,
}

impl TryFrom<Vec<[f64; 2]>> for TabulatedWindow {
    type Error = Error;

    fn try_from(rows: Vec<[f64; 2]>) -> Result<Self, Error> {
        Self::new(&rows)
    }
}

impl From<TabulatedWindow> for Vec<[f64; 2]> {
    fn from(table: TabulatedWindow) -> Self {
        table.rows.to_vec()
    }
}

impl TabulatedWindow {
    /// A window through the rows `[t, a]`.
    ///
    /// # Errors
    /// [`Error::TooFewRows`] below two rows; [`Error::NotFinite`]; [`Error::Negative`] for an amplitude;
    /// [`Error::NotIncreasing`] where a time does not exceed the one before it.
    pub fn new(rows: &[[f64; 2]]) -> Result<Self, Error> {
        let (name, limit) = ("table of the window", 2);
        if rows.len() < limit {
            return Err(Error::TooFewRows { name, count: rows.len(), limit });
        }
        for &[time, amplitude] in rows {
            finite("time of the window", time)?;
            not_negative("amplitude of the window", amplitude)?;
        }
        for (k, pair) in rows.windows(2).enumerate() {
            let (limit, value) = (pair[0][0], pair[1][0]);
            if value <= limit {
                return Err(Error::NotIncreasing { name, row: k + 1, value, limit });
            }
        }
        Ok(Self { rows: rows.into() })
    }

    /// The rows `[t, a]`.
    pub fn rows(&self) -> &[[f64; 2]] {
        &self.rows
    }

    fn amplitude(&self, t: f64) -> f64 {
        let rows = &self.rows;
        let next = rows.partition_point(|row| row[0] <= t);
        if next == 0 {
            return rows[0][1];
        }
        let [t_0, a_0] = rows[next - 1];
        rows.get(next).map_or(a_0, |[t_1, a_1]| a_0 + (t - t_0) / (t_1 - t_0) * (a_1 - a_0))
    }
}

impl Window {
    #[cfg(feature = "schema")]
    fn tabulated_example() -> Self {
        Self::Tabulated(TabulatedWindow { rows: Arc::new([[0.0, 0.0], [2.0, 1.0], [6.0, 0.2]]) })
    }

    /// The window of the paper's hysteretic example: `f_max = 1, t_max = 2` (Canor & Denoël 2013, section 4.2).
    pub const CANOR_DENOEL_2013_HYSTERETIC: Self = Self::SinglePeak { peak: 1.0, peak_time: 2.0 };

    /// The window of the paper's example: `n_1 = 1, t_1 = 2, n_2 = 2, t_2 = 6` (Canor & Denoël 2013, section 4.1).
    pub const CANOR_DENOEL_2013: Self = Self::RisePlateauDecay {
        rise_exponent: 1.0,
        rise_end: 2.0,
        decay_rate: 2.0,
        decay_start: 6.0,
    };

    /// Times at which it has a kink: a step across one loses its order.
    #[must_use]
    pub fn kinks(&self) -> Vec<f64> {
        match self {
            Self::Stationary | Self::SinglePeak { .. } => Vec::new(),
            Self::RisePlateauDecay { rise_end, decay_start, .. } => vec![*rise_end, *decay_start],
            Self::Tabulated(table) => table.rows.iter().map(|row| row[0]).collect(),
        }
    }

    /// Refuses parameters outside their range.
    ///
    /// # Errors
    /// [`Error::NotFinite`], [`Error::NotPositive`], [`Error::Negative`] with the name of the parameter;
    /// [`Error::OutOfOrder`] where the decay starts before the rise ends.
    pub fn check(&self) -> Result<(), Error> {
        match *self {
            // A table is checked when it is made.
            Self::Stationary | Self::Tabulated(_) => Ok(()),
            Self::SinglePeak { peak, peak_time } => {
                not_negative("peak", peak)?;
                positive("peak_time", peak_time)
            }
            Self::RisePlateauDecay { rise_exponent, rise_end, decay_rate, decay_start } => {
                not_negative("rise_exponent", rise_exponent)?;
                positive("rise_end", rise_end)?;
                not_negative("decay_rate", decay_rate)?;
                finite("decay_start", decay_start)?;
                if decay_start < rise_end {
                    let (name, other) = ("decay_start", "rise_end");
                    return Err(Error::OutOfOrder {
                        name,
                        value: decay_start,
                        other,
                        limit: rise_end,
                    });
                }
                Ok(())
            }
        }
    }

    /// `a(t) sqrt(2 S_0)`, what multiplies `dB` where `E[W(t) W(t + tau)] = 2 S_0 delta(tau)`.
    #[inline]
    pub(crate) fn noise_amplitude(&self, t: f64, noise_intensity: f64) -> f64 {
        self.amplitude(t) * (2.0 * noise_intensity).sqrt()
    }

    /// `a(t)`; zero before `t = 0` where the window rises. Of [`Window::RisePlateauDecay`]
    ///
    /// $$ a(t) = \begin{cases} (t/t_1)^{n_1} & t \le t_1 \\ 1 & t_1 < t < t_2 \\ e^{n_2 (t_2 - t)} & t_2 \le t \end{cases} $$
    ///
    /// and of [`Window::SinglePeak`]
    ///
    /// $$ a(t) = f_{max} \frac{t}{t_{max}} \exp\left(1 - \frac{t}{t_{max}}\right), \quad t \ge 0 . $$
    #[inline]
    #[must_use]
    pub fn amplitude(&self, t: f64) -> f64 {
        match *self {
            Self::Stationary => 1.0,
            Self::SinglePeak { peak, peak_time } => {
                let part = t.max(0.0) / peak_time;
                peak * part * (1.0 - part).exp()
            }
            Self::Tabulated(ref table) => table.amplitude(t),
            Self::RisePlateauDecay { rise_exponent, rise_end, decay_rate, decay_start } => {
                if t <= rise_end {
                    let part = t.max(0.0) / rise_end;
                    // The linear rise of the paper is met in every step of every path: no power for it.
                    if rise_exponent.to_bits() == 1.0_f64.to_bits() {
                        part
                    } else {
                        part.powf(rise_exponent)
                    }
                } else if t < decay_start {
                    1.0
                } else {
                    (decay_rate * (decay_start - t)).exp()
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_papers_window_rises_rests_and_decays() {
        let window = Window::CANOR_DENOEL_2013;
        for (t, a) in
            [(0.0, 0.0), (1.0, 0.5), (2.0, 1.0), (4.0, 1.0), (6.0, 1.0), (7.0, (-2.0_f64).exp())]
        {
            assert!((window.amplitude(t) - a).abs() < 1e-15, "a({t})");
        }
    }

    #[test]
    fn the_single_peak_starts_at_zero_and_is_largest_at_its_time() {
        let window = Window::SinglePeak { peak: 0.7, peak_time: 2.0 };
        // a(4) = 0.7 * 2 / e by eq 29.
        for (t, a) in [(-1.0, 0.0), (0.0, 0.0), (2.0, 0.7), (4.0, 1.4 * (-1.0_f64).exp())] {
            assert!((window.amplitude(t) - a).abs() < 1e-15, "a({t})");
        }
        assert!(window.amplitude(1.9) < 0.7 && window.amplitude(2.1) < 0.7);
    }

    #[test]
    fn a_table_is_linear_between_its_rows_and_level_beyond_them() {
        let table = TabulatedWindow::new(&[[1.0, 0.5], [2.0, 1.0], [4.0, 0.0]]).unwrap();
        let window = Window::Tabulated(table);
        for (t, a) in [(0.0, 0.5), (1.0, 0.5), (1.5, 0.75), (2.0, 1.0), (3.5, 0.25), (9.0, 0.0)] {
            assert!((window.amplitude(t) - a).abs() < 1e-15, "a({t})");
        }
    }

    #[test]
    fn a_table_that_is_too_short_or_does_not_increase_or_is_negative_is_refused() {
        let message = |rows: &[[f64; 2]]| TabulatedWindow::new(rows).unwrap_err().to_string();
        assert_eq!(message(&[[0.0, 1.0]]), "table of the window has 1 rows; at least 2 are needed");
        assert_eq!(
            message(&[[0.0, 1.0], [1.0, 1.0], [1.0, 0.5]]),
            "table of the window: row 2 is at 1; it must be greater than the row before it, 1"
        );
        assert_eq!(
            message(&[[0.0, 1.0], [1.0, -0.5]]),
            "amplitude of the window is -0.5; it must be 0 or greater"
        );
        assert_eq!(
            message(&[[f64::NAN, 1.0], [1.0, 0.5]]),
            "time of the window is NaN; it must be finite"
        );
    }

    #[test]
    fn a_decay_before_the_rise_has_ended_is_refused_by_name() {
        let window = Window::RisePlateauDecay {
            rise_exponent: 1.0,
            rise_end: 2.0,
            decay_rate: 2.0,
            decay_start: 1.5,
        };
        let message = window.check().unwrap_err().to_string();
        assert_eq!(message, "decay_start is 1.5; it must be greater than rise_end, which is 2");
    }
}
