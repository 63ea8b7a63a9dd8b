//! Time windows that modulate white noise.

use crate::error::{Error, not_negative, positive};

/// The modulating window `a(t)` of a white noise `a(t) W(t)`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Window {
    /// `a = 1` at all times.
    Stationary,
    /// Rise, plateau, exponential decay (Canor & Denoël 2013, eq 27):
    ///
    /// $$ a(t) = \begin{cases} (t/t_1)^{n_1} & t \le t_1 \\ 1 & t_1 < t < t_2 \\ e^{n_2 (t_2 - t)} & t_2 \le t \end{cases} $$
    RisePlateauDecay {
        /// `n_1`, exponent of the rise.
        rise_exponent: f64,
        /// `t_1`, end of the rise (time).
        rise_end: f64,
        /// `n_2`, rate of the decay (1 per unit of time).
        decay_rate: f64,
        /// `t_2`, begin of the decay (time).
        decay_start: f64,
    },
}

impl Window {
    /// The window of the paper's example: `n_1 = 1, t_1 = 2, n_2 = 2, t_2 = 6` (Canor & Denoël 2013, section 4.1).
    pub const CANOR_DENOEL_2013: Self = Self::RisePlateauDecay {
        rise_exponent: 1.0,
        rise_end: 2.0,
        decay_rate: 2.0,
        decay_start: 6.0,
    };

    /// Refuses parameters outside their range.
    ///
    /// # Errors
    /// [`Error::NotFinite`], [`Error::NotPositive`], [`Error::Negative`] with the name of the parameter;
    /// [`Error::OutOfOrder`] where the decay starts before the rise ends.
    pub fn check(&self) -> Result<(), Error> {
        match *self {
            Self::Stationary => Ok(()),
            Self::RisePlateauDecay { rise_exponent, rise_end, decay_rate, decay_start } => {
                not_negative("rise_exponent", rise_exponent)?;
                positive("rise_end", rise_end)?;
                not_negative("decay_rate", decay_rate)?;
                crate::error::finite("decay_start", decay_start)?;
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

    /// `a(t)`; zero before `t = 0` where the window rises.
    #[inline]
    #[must_use]
    pub fn amplitude(&self, t: f64) -> f64 {
        match *self {
            Self::Stationary => 1.0,
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
