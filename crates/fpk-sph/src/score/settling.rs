//! How fast positions lose what the flow-map fit does not see.

use crate::error::{Error, positive};

/// Time constants with which waves that the flow-map fit does not resolve are taken out of the positions, in reference
/// periods. By the distance from the centre of the lattice in initial standard deviations: `inside` up to 2.5, `outside`
/// from 4, in between
///
/// $$ \tau(d) = \tau_{in} \left(\frac{\tau_{out}}{\tau_{in}}\right)^{(d - 2.5)/1.5} . $$
///
/// The distance is that of the particle's place: exact on a ball; on a box whose axes have different spacings, that of a
/// cube of the same cell volume. Source: this project; measured in `docs/methods/fpk-sph.md`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Settling {
    /// Time constant near the centre, above zero (reference periods).
    pub inside: f64,
    /// Time constant near the rim, above zero (reference periods).
    pub outside: f64,
}

impl Settling {
    /// The same everywhere, the default: 0.3 reference periods. Measured on the damper: E[v^2] at t = 6 is 0.8 % high
    /// without, 0.02 % at 0.6, and the same within 0.1 % from 0.3 to 1.3.
    pub const UNIFORM: Self = Self { inside: 0.3, outside: 0.3 };
    /// Slower inside, where moments are made, and faster at the rim, where cells fold: 0.6 and 0.1.
    pub const GRADED: Self = Self { inside: 0.6, outside: 0.1 };

    /// Refuses time constants that are not above zero.
    pub(crate) fn check(&self) -> Result<(), Error> {
        positive("settling inside", self.inside)?;
        positive("settling outside", self.outside)
    }

    /// The part of what is settled at the uniform rate that a step takes out.
    pub(crate) fn part_of_a_step(dt: f64, reference_period: f64) -> f64 {
        1.0 - (-dt / (Self::UNIFORM.inside * reference_period)).exp()
    }

    /// For each place, the rate of settling over that of [`Self::UNIFORM`]; none where they are the same. `spacing` in
    /// initial standard deviations.
    pub(crate) fn relative_rates<const D: usize>(
        &self,
        places: &[[f64; D]],
        spacing: f64,
    ) -> Vec<f64> {
        if *self == Self::UNIFORM {
            return Vec::new();
        }
        let mut centre = [0.0; D];
        for place in places {
            for k in 0..D {
                centre[k] += place[k] / places.len() as f64;
            }
        }
        let rate = |place: &[f64; D]| {
            let square: f64 = (0..D).map(|k| (place[k] - centre[k]).powi(2)).sum();
            Self::UNIFORM.inside / self.time_constant(spacing * square.sqrt())
        };
        places.iter().map(rate).collect()
    }

    /// `tau(d)`, in reference periods.
    fn time_constant(&self, distance: f64) -> f64 {
        let [near, far] = GRADED_OVER;
        let way = ((distance - near) / (far - near)).clamp(0.0, 1.0);
        self.inside * (self.outside / self.inside).powf(way)
    }
}

impl Default for Settling {
    fn default() -> Self {
        Self::UNIFORM
    }
}

/// Distances between which the time constant changes, in initial standard deviations.
const GRADED_OVER: [f64; 2] = [2.5, 4.0];

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_time_constant_goes_from_one_end_to_the_other_by_equal_factors() {
        let settling = Settling { inside: 0.8, outside: 0.05 };
        let at = |distance| settling.time_constant(distance);
        for (distance, expected) in
            [(0.0, 0.8), (2.5, 0.8), (2.875, 0.4), (3.25, 0.2), (4.0, 0.05), (9.0, 0.05)]
        {
            // Roundoff of a power.
            let error = at(distance) / expected - 1.0;
            assert!(error.abs() < 1e-14, "{distance}: {}", at(distance));
        }
    }

    #[test]
    fn rates_are_by_the_distance_from_the_centre_wherever_the_lattice_starts() {
        let places: Vec<[f64; 2]> =
            (0..11_u8).flat_map(|i| (3..14_u8).map(move |j| [i, j].map(f64::from))).collect();
        let rates = Settling { inside: 0.6, outside: 0.15 }.relative_rates(&places, 1.0);
        // The centre (5, 8), 1 from it, 5 from it: 0.3 over the time constant.
        for ([i, j], expected) in [([5, 8], 0.5), ([5, 9], 0.5), ([10, 8], 2.0)] {
            let rate = rates[11 * i + j - 3];
            assert!((rate / expected - 1.0).abs() < 1e-14, "{i}, {j}: {rate}");
        }
        assert!(Settling::UNIFORM.relative_rates(&places, 1.0).is_empty());
    }

    #[test]
    fn a_time_constant_that_is_not_above_zero_is_refused_by_name() {
        let message =
            |inside, outside| Settling { inside, outside }.check().unwrap_err().to_string();
        assert_eq!(message(0.0, 0.1), "settling inside is 0; it must be greater than 0");
        assert_eq!(message(0.6, -1.0), "settling outside is -1; it must be greater than 0");
        assert_eq!(message(0.6, f64::NAN), "settling outside is NaN; it must be finite");
    }
}
